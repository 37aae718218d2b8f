#pragma once
/// Contacts of the caller's own candidate pairs: for a code that has a broad phase of its own.

#include <memory>
#include <quoin/geometry/contact_point.hpp>
#include <quoin/geometry/executor.hpp>
#include <span>

namespace quoin::geometry {

/// Two bodies by their index, a < b.
struct BlockPair {
  int a = 0;
  int b = 0;
  auto operator<=>(const BlockPair&) const = default;
};

/// What became of a body since the last call.
enum class BodyChange : char {
  None,   ///< shape, placement and reach are the same to the bit
  Moved,  ///< another placement, or another reach
  Shape   ///< another shape: its features have other names
};

/// The bodies that pairs speak of, wherever their owner keeps them.
struct BodySource {
  BodySource() = default;
  BodySource(std::span<const Body> bodies);    // NOLINT: bodies in a row
  BodySource(const std::vector<Body>& bodies)  // NOLINT
      : BodySource(std::span<const Body>(bodies)) {}

  const void* owner = nullptr;
  Body (*body)(const void* owner, int index) = nullptr;
  int count = 0;
  std::span<const int> names{};           ///< in keys and results, ascending; empty: the index
  std::span<const BodyChange> changes{};  ///< one a body; empty: all have moved
  /// One a body, m: the reach of a pair is the largest of those of its two bodies and of the one
  /// for all. Empty: bodies have none of their own.
  std::span<const double> reaches{};
};

enum class PairEvent : std::uint8_t { Begin, Persist, End };

/// Two bodies in contact, that is with contact points: their gap is at most the reach, or they
/// touch or overlap. The values of a pair that has ended are those of the last call before.
struct PairResult {
  int a = 0, b = 0;  ///< names of the bodies, a < b
  PairStatus status = PairStatus::NotConverged;
  ContactType type = ContactType::VertexVertex;
  PairEvent event = PairEvent::Begin;
  bool indeterminate = false;         ///< the contact plane is one choice of several
  double gap = 0.0;                   ///< the least one, m
  Vector3 normal = Vector3::UnitX();  ///< unit, from a to b
  double area = 0.0;                  ///< of the contact polygon, m2; 0 unless face-face
  int first = 0, count = 0;           ///< its points in the list; none when it has ended
};

/// What a call had to do.
struct FindCounts {
  int candidates = 0;  ///< pairs of bodies near enough to touch
  int searched = 0;    ///< of these: a body has moved in the last call or the one before
};

/// Answers lists of candidate pairs, and remembers of each pair where its search ended, its
/// contacts and, of bodies that stand still, the answer: that changes the speed, never the answer.
class PairBatch {
 public:
  /// options.reach: of all pairs; contact points are listed up to this gap, m. Throws InputError
  /// when a length is negative or not finite.
  explicit PairBatch(const ContactOptions& options);
  ~PairBatch();
  PairBatch(PairBatch&&) noexcept;
  PairBatch& operator=(PairBatch&&) noexcept;

  /// Writes the contact points of all pairs to `contacts`, sorted by key, each with the index of
  /// the same contact in the list of the last call: the one with the same key or, where a contact
  /// slid over an edge, the nearest of the same two bodies that no key claims, within the reach
  /// (tol at least) as seen from body a (with PointFrame::Bodies: the nearest places on a). Pairs
  /// may stand in any order; a pair given twice is answered once. The list is the same for any
  /// number of workers; without an executor the calling thread does it all. No allocation when
  /// warm. Throws InputError for an index out of range, a body paired with itself, names that do
  /// not ascend, spans of the wrong size or, of bodies in a row that a pair names, a placement that
  /// is none.
  FindCounts find(const BodySource& bodies, std::span<const BlockPair> pairs,
                  std::vector<ContactPoint>& contacts, Executor* executor = nullptr);

  /// A question by the way: what find() would list of these pairs alone, ContactPoint::previous
  /// being -1. Costs what these pairs cost, not what all do. The next find() lists, matches and
  /// counts as though nobody had asked; `changes` are those since the last find(). Throws as find()
  /// does, but trusts names and reaches. No allocation when warm.
  FindCounts contacts_of(const BodySource& bodies, std::span<const BlockPair> pairs,
                         std::vector<ContactPoint>& contacts, Executor* executor = nullptr);

  /// The pairs in contact after the last find() and those that it ended, ascending by (a, b).
  std::span<const PairResult> pairs() const;

  void set_reach(double reach);  ///< m, from the next find() on

 private:
  struct Memory;
  Memory& memory() const;
  std::unique_ptr<Memory> memory_;
};

/// What nearest_features(bodies[pair.a], bodies[pair.b], options, answer.hint) gives, to the bit,
/// for each pair, in place of its answer of the last call (one as made: a cold search). Pairs may
/// come in any order and more than once; `answers` are as many. `executor`: null: the caller's
/// thread alone; the answers depend neither on the number of workers nor on the other pairs.
/// Throws InputError, before any answer is touched, for a pair that does not name two bodies, for
/// another number of answers and for a body named whose placement is none. What an executor throws
/// leaves each answer the old one or the new one.
void update_nearest_features(std::span<const Body> bodies, std::span<const BlockPair> pairs,
                             std::span<NearestFeatures> answers, const SearchOptions& options = {},
                             Executor* executor = nullptr);

}  // namespace quoin::geometry
