/// Joints of pairs of blocks that are refused. Closed forms of joints are cases of
/// tools/scenes/cases and tools/scenes/validation.

#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using quoin::geometry::make_box;

TEST_CASE("joints of a pair of blocks are refused out of order or twice") {
  Scene scene;
  scene.add_fixed(make_box({-5, -5, -1}, {5, 5, 0}));
  for (const double x : {0.0, 2.0})
    scene.add_rigid(make_box({x, 0, 0}, {x + 1, 1, 1}), {.density = 2500});
  scene.block_joints = {{.a = 0, .b = 2, .joint = {}}};
  CHECK_NOTHROW(Simulation(scene, {}));
  scene.block_joints = {{.a = 2, .b = 0, .joint = {}}};
  CHECK_THROWS_AS(Simulation(scene, {}), InputError);
  scene.block_joints = {{.a = 0, .b = 2, .joint = {}}, {.a = 0, .b = 1, .joint = {}}};
  CHECK_THROWS_AS(Simulation(scene, {}), InputError);
}
