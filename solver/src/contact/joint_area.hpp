#pragma once
/// The area of a joint: what its two faces share, as seen along its normal, whether or not they are
/// tilted.

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

/// What its corners have of the area, by contact.
struct JointArea {
  double whole = 0.0;         ///< m2
  std::vector<double> share;  ///< m2; of lifted corners nobody has it
};

/// Each corner has half of the two triangles (centroid, corner, next) beside it, as geometry shares
/// out a contact polygon, and gives it to the nearest contact, the less the farther that is.
JointArea joint_area(const JointBlocks& blocks, std::span<const BodyContact> joint);

}  // namespace quoin::solver
