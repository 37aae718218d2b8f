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
