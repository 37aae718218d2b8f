#pragma once
/// Where water presses: faces of blocks and joints between them, as the scene has them at the
/// start.

#include <functional>
#include <memory>
#include <optional>
#include <quoin/solver/scene.hpp>
#include <span>

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
  std::function<bool(int a, int b)> wets{};  ///< Joints: between two blocks; else: a, b is -1
  std::optional<solver::Vector3> towards{};  ///< faces with this outward normal alone
  int divisions = 4;
};

/// The pressure loads of the blocks that can move. Blocks that are `absent` (by block; may be
/// empty) touch nothing.
void append_water(const Water& water, std::span<const char> absent, solver::Scene& scene);

}  // namespace quoin::scene_file
