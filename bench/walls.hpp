#pragma once
/// B: walls of bricks that move a little each step.

#include <memory>
#include <quoin/geometry/shape.hpp>
#include <vector>

#include "workloads.hpp"

namespace quoin::bench {

/// How the bricks move.
enum class Motion {
  Jitter,  ///< each about its place, at most 0.1 % of its diagonal a step, to no end
  Drift    ///< each steadily in its own direction, 0.1 % of its diagonal a step
};

/// A running-bond wall with a joint of `gap` (m) between all bricks, all steps from a formula.
class Wall {
 public:
  Wall(int count, Motion motion, double gap, double amplitude);
  std::size_t size() const { return bricks_.size(); }
  const Brick& brick(std::size_t i) const { return bricks_[i]; }
  /// Centre of brick i at a step, m.
  Vector3 place(std::size_t i, int step) const;
  geometry::Box box(std::size_t i, int step) const;
  /// Of all bricks, about its centre.
  std::shared_ptr<const geometry::Shape> shape() const;
  /// Polyhedra at step 0 over one shared topology.
  std::vector<geometry::Shape> solids() const;

 private:
  Motion motion_;
  double amplitude_;  // m a step
  std::vector<Brick> bricks_;
  std::vector<Vector3> direction_;
  BenchShape shape_;
};

}  // namespace quoin::bench
