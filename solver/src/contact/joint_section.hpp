#pragma once
/// The area of a joint as the cross-section of a beam: stress from the forces on its contacts.

#include <optional>
#include <quoin/geometry/types.hpp>
#include <span>
#include <vector>

namespace quoin::solver {

/// A convex polygon: area, centroid, second moments about it (xx: integral of x x).
struct JointSection {
  double area = 0.0;  ///< m2
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second_moment = Eigen::Matrix2d::Zero();  ///< m4
};

/// Of the polygon with these corners, in any order (m). None when they span no area.
std::optional<JointSection> joint_section(std::span<const Eigen::Vector2d> corners);

/// Mean distance of the polygon's points from a place, m. Corners in any order.
double mean_distance(std::span<const Eigen::Vector2d> corners, const Eigen::Vector2d& from);

/// Normal stress at each corner (Pa, tension positive), linear over the section, that has the
/// resultant and the moments of `pull` (N, tension positive, one force a corner): beam theory.
std::vector<double> section_stress(const JointSection& section,
                                   std::span<const Eigen::Vector2d> corners,
                                   std::span<const double> pull);

}  // namespace quoin::solver
