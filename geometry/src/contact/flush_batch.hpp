#pragma once
/// Pairs of bricks that lay with two faces on each other last step, proved again side by side.
/// Internal.

#include <optional>
#include <quoin/geometry/contact_point.hpp>
#include <vector>

#include "search/flush_bricks.hpp"

namespace quoin::geometry {

/// A pair that waits for its answer.
struct FlushPair {
  std::size_t number = 0;  ///< the caller's
  std::array<int, 2> blocks{};
  std::optional<Body> a, b;
  double reach = 0.0;            ///< ContactOptions, m
  bool reversed = false;         ///< P is the caller's B
  int face_p = -1, face_q = -1;  ///< to be proved

  /// Copies the bodies; false: `hint` names no two faces of bricks.
  bool take(const Body& body_a, const Body& body_b, const FeatureHint& hint);
  /// Into a lane of a question, which refers to this pair.
  void pack(std::size_t lane, FlushQuestion& question) const;
};

/// What is known of a pair in the end: the same bits as append_contacts_within_reach.
struct FlushPairAnswer {
  std::size_t pair = 0;  ///< the caller's number
  PairStatus status = PairStatus::NotConverged;
  double gap = 0.0;  // m
  Vector3 normal = Vector3::UnitX();
  std::size_t first = 0, count = 0;  ///< its points
};

/// Takes pairs one by one and answers them in groups. Keeps its memory.
class FlushBatch {
 public:
  /// Forgets all pairs.
  void start(const ContactOptions& options);
  /// Takes a pair of which `hint` names two faces of bricks; others are left alone. The bodies are
  /// copied, their shapes must stay until finish(). `reach` stands for that of the options.
  void take(std::size_t pair, const std::array<int, 2>& blocks, const Body& a, const Body& b,
            const FeatureHint& hint, double reach);
  /// Answers those that still wait.
  void finish();
  /// Of the pairs that were taken, in their order, those of which nothing was left to doubt.
  std::span<const FlushPairAnswer> answers() const { return answers_; }
  std::span<const ContactPoint> points(const FlushPairAnswer& answer) const {
    return std::span(points_).subspan(answer.first, answer.count);
  }

 private:
  void ask();
  void add_answer(std::size_t lane);
  bool add_points(std::size_t lane, const Vector3& normal);

  ContactOptions options_;
  FlushQuestion question_;
  FlushAnswer found_;
  std::array<FlushPair, FlushRow::kPairs> pairs_;
  std::size_t waiting_ = 0;
  std::vector<FlushPairAnswer> answers_;
  std::vector<ContactPoint> points_;  // room for those of all answers
  std::size_t used_ = 0;              // of it
};

}  // namespace quoin::geometry
