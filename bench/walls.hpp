#pragma once
/// B: walls of bricks that move a little each step.

#include <quoin/geometry/body.hpp>
#include <vector>

#include "workloads.hpp"

namespace quoin::bench {

/// How the bricks move.
enum class Motion {
  Jitter,  ///< each about its place and its own axis, to and fro, to no end
  Drift    ///< each steadily in its own direction
};

struct WallOptions {
  int count = 1000;              ///< bricks, about
  int leaves = 1;                ///< walls one behind the other
  double joint = 0.0;            ///< between all bricks, m
  Vector3 brick{0.4, 0.2, 0.2};  ///< with its joints, m
  Motion motion = Motion::Jitter;
  double shift = 0.0;    ///< the most that a brick moves in a step, m
  double turn = 0.0;     ///< the most that it turns, rad
  double heading = 0.0;  ///< of the whole wall about the upright, rad
  double carry = 0.0;    ///< along x for all of them in each step, m
};

/// A running-bond wall, all steps from a formula.
class Wall {
 public:
  explicit Wall(const WallOptions& options);
  std::size_t size() const { return places_.size(); }
  const BenchShape& shape() const { return shape_; }  ///< of all bricks
  geometry::Placement placement(std::size_t i, int step) const;
  /// Of a brick that does not turn.
  geometry::Box box(std::size_t i, int step) const;

 private:
  double way(std::size_t i, int step) const;

  WallOptions options_;
  std::vector<Vector3> places_, directions_;  // centres at the start, m; unit vectors
  BenchShape shape_;
};

}  // namespace quoin::bench
