#pragma once
/// All contacts of a crowd of bodies: bodies in, contact points sorted by key out.

#include <functional>
#include <memory>
#include <optional>
#include <quoin/geometry/pair_batch.hpp>
#include <quoin/geometry/queries.hpp>
#include <span>

namespace quoin::geometry {

inline constexpr int kMostThreads = 4096;  ///< chosen: more than a machine has

struct FinderOptions {
  double reach = 0.0;      ///< of all pairs: contact points are listed up to this gap, m; touching
                           ///< pairs always
  double tolerance = 0.0;  ///< contact length tol, m; 0: default_tolerance of each pair
  int threads = 1;         ///< to kMostThreads, with the same bits; not used with an executor
  Executor* executor = nullptr;          ///< the caller's threads; must outlive the finder
  PointFrame frame = PointFrame::World;  ///< of the places of contact points
  double coordinate_rounding = 0.0;      ///< of ContactOptions, m
};

/// Whether a body takes part by itself. Pairs of two idle bodies (fixed, or known not to move) are
/// never tested and never listed.
enum class BodyMotion : char { Moving, Idle };

/// A pair is tested when each body's category has a bit of what the other collides with.
struct BodyOptions {
  std::uint32_t category = 1;
  std::uint32_t collides_with = ~std::uint32_t{0};
  BodyMotion motion = BodyMotion::Moving;
  bool operator==(const BodyOptions&) const = default;
};

/// A part of a compound and where it stands in the compound's frame.
struct CompoundPart {
  std::shared_ptr<const Shape> shape;
  Placement placement{};
};

/// The compound that a body is a part of; a body by itself is part 0 of itself.
struct PartName {
  int compound = 0, part = 0;
};

/// Which bodies a query of the finder looks at: those whose category has one of these bits, and of
/// which `accepts` says so (empty: all).
struct QueryFilter {
  std::uint32_t categories = ~std::uint32_t{0};
  std::function<bool(int handle)> accepts{};
};

/// A body that a ray meets, and where.
struct BodyHit {
  int handle = 0;
  RayHit hit;
};

/// Keeps bodies under stable handles, the tree of their boxes, and what is known of each pair: that
/// changes the speed, never the answer.
///
/// A handle is a number from 0 on, given in ascending order and never given again, not even after
/// its body is removed; a finder takes 2^31 - 1 bodies in its life. Erasing a body renames no
/// other. All calls throw InputError naming the handle when it is none or its body is gone, and
/// when the finder was moved from.
class ContactFinder {
 public:
  explicit ContactFinder(const FinderOptions& options);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  /// Adds a body and returns its handle. A shape is shared by all its bodies. Throws InputError for
  /// no shape, and for a placement with a number that is not finite or too large, or with a
  /// determinant that is not positive.
  int add(std::shared_ptr<const Shape> shape, const Placement& placement = {},
          const BodyOptions& options = {});
  /// Adds bodies that move as one, such as a solid that is not convex, under one handle h: that of
  /// part 0. Part k has the handle h + k, by which contacts and hits name it. Parts are never
  /// tested against each other. remove(), move(), set_options(), set_reach() and contacts_of() of h
  /// are of all parts; of other parts all but the last are refused. size() counts parts. Throws
  /// InputError for no parts, and as add() does, and then adds none.
  int add_compound(std::span<const CompoundPart> parts, const Placement& placement = {},
                   const BodyOptions& options = {});
  PartName part_name(int handle) const;
  void remove(int handle);
  /// Another placement, checked as in add(). The same one to the bit: the body stands still.
  void move(int handle, const Placement& placement);
  /// Another shape in the same place. One of the same topology, such as a copy with other vertices,
  /// has moved freely: its contacts go on. Else they have no predecessors in the next list.
  void replace_shape(int handle, std::shared_ptr<const Shape> shape);
  void set_options(int handle, const BodyOptions& options);
  /// Reach of a body, m, 0 when it is added; from the next find() on. The reach of a pair is the
  /// largest of those of its two bodies and of the one for all. So "a pair is watched up to what
  /// the faster of its two bodies can move" is said body by body, and a fast body makes nobody
  /// search pairs that it has no part in: another reach of a body counts as a move of that body.
  /// Throws InputError when it is negative or not finite.
  void set_reach(int handle, double reach);

  bool contains(int handle) const;
  int size() const;  ///< number of bodies
  Body body(int handle) const;

  /// Asked for each pair of near bodies that the masks let pass, a < b, in each find() and
  /// contacts_of() by the calling thread: false leaves the pair out. An empty function: none is.
  void set_filter(std::function<bool(int a, int b)> filter);
  void set_reach(double reach);  ///< of all pairs, m, from the next find() on
  /// Threads that find() uses: fewer than asked for where the system refused to start them.
  int threads() const;

  /// Writes all contact points, sorted by key; key.a and key.b are handles. See PairBatch::find()
  /// for ContactPoint::previous. No allocation when warm.
  FindCounts find(std::vector<ContactPoint>& contacts);
  /// A question by the way: what find() would list of those pairs alone that have a body of
  /// `handles`, in any order, ContactPoint::previous being -1. Costs what these pairs
  /// and the bodies moved since the last call cost, however many others there are. The next find()
  /// lists, matches and counts as though nobody had asked. No allocation when warm.
  FindCounts contacts_of(std::span<const int> handles, std::vector<ContactPoint>& contacts);
  /// Queries through the tree, of the bodies where they stand now. The next find() goes on as
  /// though nobody had asked. Rays hit and points lie in bodies as in queries.hpp, which also says
  /// what is thrown; of bodies that a ray enters at the same s the lowest handle is first.
  std::optional<BodyHit> nearest_hit(const Ray& ray, const QueryFilter& filter = {});
  /// All bodies that a ray enters, by s, then by handle.
  void all_hits(const Ray& ray, std::vector<BodyHit>& hits, const QueryFilter& filter = {});
  /// Handles of the bodies whose axis-aligned boxes meet `box` (m), ascending. A body's box
  /// holds the box of its shape as it is turned, or the ball around it where that ends before: no
  /// body is left out, and a turned one may be up to half its diameter away. Throws InputError for
  /// a box that is not finite or of which max < min.
  void bodies_in_box(const Box& box, std::vector<int>& handles, const QueryFilter& filter = {});
  /// Handles of the bodies that contain `point` (m, world) within `tolerance` (m), and whose boxes
  /// come as near, ascending.
  void bodies_at(const Vector3& point, double tolerance, std::vector<int>& handles,
                 const QueryFilter& filter = {});

  /// The pairs in contact after the last find() and those that it ended, ascending by handles.
  std::span<const PairResult> pairs() const;

 private:
  struct Memory;
  Memory& memory() const;
  std::unique_ptr<Memory> memory_;
};

}  // namespace quoin::geometry
