#pragma once
/// Pairs that lay with two faces on each other last step, proved again side by side: bricks, and
/// solids whose faces have other numbers of corners. Internal.

#include <optional>
#include <quoin/geometry/contact_point.hpp>
#include <vector>

#include "contact/flush_points.hpp"
#include "contact/flush_polygon_pair.hpp"
#include "search/flush_bricks.hpp"

namespace quoin::geometry {

/// A pair of bricks that waits for its answer.
struct FlushPair {
  std::size_t number = 0;  ///< the caller's
  FlushFaces faces;        ///< to be proved
  std::optional<Body> a, b;
  double reach = 0.0;  ///< ContactOptions, m

  /// Copies the bodies; false: `hint` names no two faces of bricks.
  bool take(const Body& body_a, const Body& body_b, const FeatureHint& hint);
  /// Into a lane of a question, which refers to this pair.
  void pack(std::size_t lane, FlushQuestion& question) const;
};

/// Takes pairs one by one and answers them in groups. Keeps its memory.
class FlushBatch {
 public:
  /// Forgets all pairs.
  void start(const ContactOptions& options);
  /// Takes a pair of which `hint` names two faces that may carry it; others are left alone. The
  /// bodies are copied, their shapes must stay until finish(). `reach` stands for that of the
  /// options.
  void take(std::size_t pair, const std::array<int, 2>& blocks, const Body& a, const Body& b,
            const FeatureHint& hint, double reach);
  /// Answers those that still wait.
  void finish();
  /// Of the pairs that were taken, by their numbers, which ascend, those of which nothing was left
  /// to doubt.
  std::span<const FlushPairAnswer> answers() const { return answers_; }
  std::span<const ContactPoint> points(const FlushPairAnswer& answer) const {
    return std::span(points_).subspan(answer.first, answer.count);
  }

 private:
  void ask_bricks();
  void add_brick(std::size_t lane);
  void ask_polygons();
  void add_polygon(std::size_t lane);
  void add(const FlushPairAnswer& answer);
  void write(const FlushPoints& points, const ContactPlane& plane, const Vector3& middle,
             FlushPairAnswer& answer);
  void into_bodies(const Body& a, const Body& b, const Vector3& between,
                   const FlushPairAnswer& answer);

  ContactOptions options_;
  FlushQuestion bricks_;
  FlushAnswer of_bricks_;
  std::array<FlushPair, FlushRow::kPairs> brick_pairs_;
  PolygonQuestion polygons_;
  PolygonAnswer of_polygons_;
  std::array<PolygonPair, FlushRow::kPairs> polygon_pairs_;
  std::size_t bricks_waiting_ = 0, polygons_waiting_ = 0;
  std::vector<FlushPairAnswer> answers_;
  std::vector<ContactPoint> points_;  // room for those of all answers
  std::size_t used_ = 0;              // of it
};

}  // namespace quoin::geometry
