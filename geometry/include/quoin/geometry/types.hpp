#pragma once
/// Basic types shared by all of quoin::geometry. SI units (m, rad), world frame.

#include <Eigen/Core>
#include <Eigen/Geometry>  // cross
#include <stdexcept>

namespace quoin::geometry {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

/// 3 × point_count, m. Not aligned: aligned ones are given back otherwise by code that is compiled
/// for other instructions, or under AddressSanitizer, than by this library.
using Points = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor | Eigen::DontAlign>;

/// Axis-aligned box, m.
struct Box {
  Vector3 min = Vector3::Zero();
  Vector3 max = Vector3::Zero();
};

/// Data that cannot be worked with. Thrown when a polyhedron or a scene is made, never later;
/// the message names block, feature, value and limit.
class InputError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

}  // namespace quoin::geometry
