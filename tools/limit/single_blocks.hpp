#pragma once
/// Key blocks: what every single block does while all others stay.

#include <optional>

#include "limit/varied_scene.hpp"

namespace quoin::limit_analysis {

/// One block against its neighbours, which do not move. To first order: small motions.
struct SingleBlock {
  int block = 0;
  double volume = 0.0;     ///< m3
  bool removable = false;  ///< a motion opens a contact and closes none, or loads without friction
                           ///< move it
  bool key = false;        ///< without friction, cohesion and tension its loads move it
  /// Friction, cohesion and tension divided by this: proved to stand, proved to fall. None: beyond
  /// kLeastStrength or kMostStrength.
  std::optional<double> stands{}, falls{};
};

inline constexpr double kLeastStrength = 1e-3, kMostStrength = 1e3;

/// Of every block that moves, with its loads at time 0; key blocks first, then by volume, the
/// largest first. `tolerance`: between stands and falls, relative. Throws nothing of its own.
std::vector<SingleBlock> single_blocks(const Scene& scene, double tolerance);

}  // namespace quoin::limit_analysis
