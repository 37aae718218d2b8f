#pragma once
/// Where water presses: faces of blocks and joints between them, as the scene has them at the
/// start.

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "scene_file/start_joints.hpp"

namespace quoin::scene_file {

enum class WetSurface : std::uint8_t {
  Joints,  ///< contact polygons of faces, both sides
  Free,    ///< faces but for those polygons
  All      ///< whole faces
};

/// One entry of the list "water".
struct Water {
  std::shared_ptr<const solver::PressureField> field{};
  WetSurface surface = WetSurface::All;
  std::function<bool(int block)> wets{};
  std::function<bool(const StartJoint&)> wets_joint{};  ///< of Joints
  std::optional<solver::Vector3> towards{};             ///< faces with this outward normal alone
  int divisions = 4;
};

/// The pressure loads of the blocks that can move. `joints`: start_joints() of the scene. Blocks
/// that are `absent` (by block; may be empty) touch nothing.
void append_water(const Water& water, std::span<const StartJoint> joints,
                  std::span<const char> absent, solver::Scene& scene);

}  // namespace quoin::scene_file
