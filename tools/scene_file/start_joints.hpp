#pragma once
/// Where faces of blocks lie on each other as a scene is laid.

#include <quoin/solver/scene.hpp>
#include <vector>

namespace quoin::scene_file {

/// A contact polygon of two convex parts, of two blocks or of one.
struct StartJoint {
  int a = 0, b = 0;                                   ///< blocks, a <= b
  int part_a = 0, part_b = 0;                         ///< of their convex parts
  solver::Vector3 normal = solver::Vector3::UnitX();  ///< unit, from a to b
  std::vector<solver::Vector3> corners{};  ///< m, counter-clockwise seen against the normal
};

/// Of all blocks as they are laid, absent ones as well, sorted by blocks and parts. Parts no
/// farther apart than 1e-6 of the smaller one, or Scene::coordinate_rounding, have a joint.
std::vector<StartJoint> start_joints(const solver::Scene& scene);

}  // namespace quoin::scene_file
