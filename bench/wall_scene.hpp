#pragma once
/// The wall of S7 as a scene of quoin's, of boxes given where they stand.

#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "rigid_scenes.hpp"

namespace quoin::bench {

/// `young`: of bricks that deform, Pa; 0: they are rigid.
inline solver::Scene wall_scene(int columns, int rows, double young = 0.0) {
  const RigidScene rigid = wall(columns, rows);
  solver::Scene scene{.joint = {.friction_angle = std::atan(rigid.friction)}};
  for (const RigidBody& body : rigid.bodies) {
    const auto shape = geometry::make_box(body.place - body.half_size, body.place + body.half_size);
    if (!(body.density > 0.0))
      scene.add_fixed(shape);
    else if (young > 0.0)
      scene.add_block(shape, {.density = body.density, .young = young, .poisson = 0.2});
    else
      scene.add_rigid(shape, {.density = body.density});
  }
  return scene;
}

}  // namespace quoin::bench
