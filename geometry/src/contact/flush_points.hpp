#pragma once
/// Corners that two flush faces share, as contact points. Internal.

#include <array>
#include <quoin/geometry/contact_point.hpp>
#include <span>

#include "contact/contact_corners.hpp"
#include "numeric/floating_point.hpp"
#include "polygon/contact_plane.hpp"
#include "search/flush_polygons.hpp"

namespace quoin::geometry {

/// What is known of a pair in the end: the same bits as append_contacts_within_reach.
struct FlushPairAnswer {
  std::size_t pair = 0;  ///< the caller's number
  PairStatus status = PairStatus::NotConverged;
  double gap = 0.0;  // m
  Vector3 normal = Vector3::UnitX();
  std::size_t first = 0, count = 0;  ///< its points
};

/// The faces that carry a pair, P before Q, in the names of the caller.
struct FlushFaces {
  std::array<int, 2> blocks{};
  bool reversed = false;  ///< P is the caller's B
  const Shape *p = nullptr, *q = nullptr;
  int face_p = -1, face_q = -1;
};

/// The corners of one pair with their names and their places in the order of keys.
class FlushPoints {
 public:
  FlushPoints(const FlushFaces& faces, std::span<const PolygonCorner> corners);

  std::size_t count() const { return corners_.size(); }
  /// Are two of them within `tolerance` (m) of each other?
  bool crowded(double tolerance) const { return !(nearest_ > tolerance * tolerance); }
  /// Is the least gap at most `least` and the greatest at most `highest`? m
  bool lie_between(double least, double highest) const {
    return highest_ <= highest && lowest_ <= least;
  }
  /// To points[0 …], sorted by key; `normal`: from A to B; `middle` (m): added to all places, if
  /// it is not null.
  void write(const ContactPlane& plane, const Vector3& normal, const Vector3* middle,
             std::span<ContactPoint> points) const;

 private:
  static constexpr std::size_t kMost = 2 * PolygonSide::kMost;

  /// Of the corners, sides and the face itself, by kind.
  struct Names {
    const int face;
    const std::array<const int*, 3> names;
    Names(const Shape& shape, int of_face)
        : face(of_face),
          names{shape.topology().face(of_face).data(), shape.topology().face_edges(of_face).data(),
                &face} {}
    int of(const Feature& counted) const {
      return names[static_cast<std::size_t>(counted.kind)][counted.index];
    }
  };
  static_assert(static_cast<int>(FeatureKind::Vertex) == 0 &&
                static_cast<int>(FeatureKind::Edge) == 1 &&
                static_cast<int>(FeatureKind::Face) == 2);

  void find_order();

  const FlushFaces& faces_;
  std::span<const PolygonCorner> corners_;
  double nearest_ = kInfinity;                        // of two corners, squared, m2
  double lowest_ = kInfinity, highest_ = -kInfinity;  // gaps, m
  std::array<int, kMost> name_p_, name_q_;            // of the features
  std::array<std::int64_t, kMost> key_;
  std::array<unsigned, kMost> place_;
};

}  // namespace quoin::geometry
