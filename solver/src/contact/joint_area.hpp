#pragma once
/// The area of a joint: what its two faces share, as seen along its normal, whether or not they are
/// tilted. It is integrated at its corners and, of joints that act by area, at a point of each of
/// the triangles (centroid, corner, next).

#include <optional>
#include <quoin/geometry/types.hpp>
#include <span>
#include <vector>

#include "contact/contact_history.hpp"

namespace quoin::solver {

/// rad: a side that turns by less does not.
inline constexpr double kStraight = 1e-3;

/// The blocks of a joint where they stand.
struct JointBlocks {
  const BlockModel &model_a, &model_b;
  const Pose &a, &b;
};

/// Its plane, seen along the normal; from A's centroid, m.
struct JointPlane {
  Vector3 normal, u, v;
  explicit JointPlane(const Vector3& along) : normal(along) {
    u = normal.unitOrthogonal();
    v = normal.cross(u);
  }
  Eigen::Vector2d operator()(const Vector3& place) const { return {u.dot(place), v.dot(place)}; }
};

inline double cross(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  return p.x() * q.y() - p.y() * q.x();
}

/// The face of a block that carries the joint, as it stands: its plane passes through `middle`.
struct JointFace {
  int face = -1;
  Vector3 middle = Vector3::Zero(), normal = Vector3::Zero();  ///< from A's centroid; not unit
};

/// What the two faces share.
struct JointPolygon {
  struct Corner {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    bool of_b = false;  ///< whose edge the side from here to the next corner lies on
    int edge = -1;
  };
  JointPlane plane;
  JointFace a{}, b{};
  std::vector<Corner> corners{};    ///< counter-clockwise
  std::vector<double> triangles{};  ///< by corner: area of (centroid, corner, next), m2
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  double area = 0.0;  ///< m2; 0: the faces share none
};

/// Corners of its core, one for each side: while the normal force stays within them, a section that
/// remains plane has no tension. A corner counts for its side's triangle: they balance about the
/// centroid. Empty: no area.
std::vector<Eigen::Vector2d> core(const JointPolygon& polygon);

/// `contact`: any of the joint's.
JointPolygon joint_polygon(const JointBlocks& blocks, const BodyContact& contact);

/// Whether what a point of its area bears goes by the motion there. (Brittle strength of a rigid
/// joint is judged by the forces on all of it.)
inline bool acts_by_area(const Joint& joint) {
  return joint.normal_stiffness > 0.0 || joint.residual_cohesion > 0.0 ||
         (joint.cohesion > 0.0 && joint.softening_slip > 0.0);
}

/// Of the median of each triangle, from the centroid: where its inner point is. sqrt(2/5).
inline constexpr double kInner = 0.6324555320336759;

/// Of the area of each triangle, what each of its two corners has, and its inner point.
struct AreaRule {
  double corner = 0.0, inner = 0.0;
};
/// As geometry shares out a contact polygon.
inline constexpr AreaRule kCornersAlone{1.0 / 2.0, 0.0};
/// Area, first and second moments are those of the polygon, of whatever shape: of each triangle the
/// second moments about the centroid are exact, and the first ones of all cancel.
inline constexpr AreaRule kSecondDegree{1.0 / 12.0, 5.0 / 6.0};

/// A mix of the two with the polygon's mean distance from its centroid: what has cohesion all over
/// has its exact strength against twist, too.
AreaRule cohesion_rule(const JointPolygon& polygon);

/// By which a joint has its strength in steps.
AreaRule strength_rule(const Joint& joint, const JointPolygon& polygon);

/// A contact at an inner point: its key has an edge of one block, on which the triangle's side
/// lies, and the other one's face.
inline bool is_inner(const geometry::ContactKey& key) {
  using geometry::FeatureKind;
  return key.feature_a.kind != key.feature_b.kind && key.feature_a.kind != FeatureKind::Vertex &&
         key.feature_b.kind != FeatureKind::Vertex;
}

/// What each contact of the joint has of the area, m2. A corner gives its part to the nearest
/// contact, the less the farther that is: of lifted corners nobody has it.
std::vector<double> area_shares(const JointBlocks& blocks, const JointPolygon& polygon,
                                const AreaRule& rule, std::span<const BodyContact> joint);

/// The inner points up to this gap (m), as a search would have found them, in the frames of the
/// reference shapes. `corners`: the joint's contacts, whose gaps they lie between.
std::vector<geometry::ContactPoint> inner_points(const JointBlocks& blocks,
                                                 const JointPolygon& polygon,
                                                 std::span<const BodyContact> corners,
                                                 double reach);

/// The area of a joint as the cross-section of a beam: stress from the forces on its contacts. A
/// convex polygon: area, centroid, second moments about it (xx: integral of x x).
struct JointSection {
  double area = 0.0;  ///< m2
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second_moment = Eigen::Matrix2d::Zero();  ///< m4
};

/// Of the convex hull of these places (m). None when they span no area.
std::optional<JointSection> joint_section(std::span<const Eigen::Vector2d> places);

/// Mean distance of the hull's points from a place, m.
double mean_distance(std::span<const Eigen::Vector2d> places, const Eigen::Vector2d& from);

/// Normal stress at each place (Pa, tension positive), linear over the section, that has the
/// resultant and the moments of `pull` (N, tension positive, one force a place): beam theory.
std::vector<double> section_stress(const JointSection& section,
                                   std::span<const Eigen::Vector2d> places,
                                   std::span<const double> pull);

}  // namespace quoin::solver
