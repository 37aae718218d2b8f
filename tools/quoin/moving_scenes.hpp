#pragma once
/// Scenes of `quoin make` in which many blocks move at once, and the wall that some of them begin
/// with.

#include "made_scene.hpp"

namespace quoin::commands {

struct Wall {
  double length = 4, height = 2, thickness = 0.3, block_length = 0.8, block_height = 0.25;  // m
};

/// How many bricks it has.
double bricks(const Wall& wall);

/// Running bond on the block "ground": every second course begins with half a block. Returns the
/// name of the last brick.
std::string lay_wall(const Wall& wall, Made& made);

struct Shaking {
  double peak = 0.5;  ///< of the ground's acceleration, g
  double hz = 2;
  double direction_deg = 90;  ///< 0: along the wall, 90: across
};
void make_shaken_wall(const Stone& stone, const Wall& wall, const Shaking& shaking);

struct Hammer {
  double mass = 1000;  ///< kg
  double speed = 3;    ///< m/s
};
/// A cube that flies into the middle of the wall, across it.
void make_struck_wall(const Stone& stone, const Wall& wall, const Hammer& hammer);

struct Bin {
  double size = 0.3;  ///< of a rock, m
  int blocks = 200, seed = 1;
};
/// Hulls of random points that fall into a bin and come to rest.
void make_bin(const Stone& stone, const Bin& bin);

struct JointedSlope {
  double dip_deg = 45, block_length = 1, block_width = 1, block_height = 0.5;  // m
  int rows = 8, columns = 4, sheets = 3;
};
/// Sheets of blocks in bond on a plane, held by a toe that is taken away.
void make_jointed_slope(const Stone& stone, const JointedSlope& slope);

struct Vault {
  double radius = 2, thickness = 0.4, length = 4, block_length = 0.8, pier_height = 1.5;  // m
  int courses = 13, piers = 2;
};
/// A barrel vault in bond, without mortar, on two rows of piers; one pier is taken away.
void make_vault(const Stone& stone, const Vault& vault);

}  // namespace quoin::commands
