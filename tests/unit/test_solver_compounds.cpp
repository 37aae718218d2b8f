/// Blocks of several convex parts: one mass, contacts by part. Closed forms are
/// tools/scenes/cases/ell_*.json, halves_joined.json and slides_over_parts.json.

#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver.hpp>
#include <sstream>

#include "support/catch.hpp"

using namespace quoin::solver;
namespace geometry = quoin::geometry;
using namespace quoin::tests;

namespace {

std::vector<geometry::Shape> ell() {  // foot along x, upright at its left end; centroid x = 0.75
  return {geometry::make_box({0, 0, 0}, {2, 1, 1}), geometry::make_box({0, 0, 1}, {1, 1, 3})};
}

}  // namespace

TEST_CASE("Mass properties of parts sum up about their common centroid") {
  const std::vector<geometry::Shape> parts = ell();
  const geometry::MassProperties sum = geometry::mass_properties(geometry::join(parts));
  CHECK_THAT(sum.volume, WithinRel(4.0, 1e-14));
  CHECK((sum.centroid - Vector3(0.75, 0.5, 1.25)).norm() < 1e-14);
  // Of each box about its own centroid, and its volume at its distance.
  const double long_side = 4.0 / 12, short_side = 1.0 / 12;
  CHECK_THAT(sum.second_moment(0, 0),
             WithinRel(2.0 * (long_side + 0.0625) + 2.0 * (short_side + 0.0625), 1e-12));
  CHECK_THAT(sum.second_moment(2, 2),
             WithinRel(2.0 * (short_side + 0.5625) + 2.0 * (long_side + 0.5625), 1e-12));
  CHECK_THAT(sum.second_moment(0, 2), WithinRel(-2.0 * 0.25 * 0.75 - 2.0 * 0.25 * 0.75, 1e-12));
  const std::vector<geometry::Shape> none;
  CHECK_THROWS_AS(compound(none), InputError);
}

TEST_CASE("Blocks of several parts go on from a checkpoint") {
  const BlockKind kind = GENERATE(BlockKind::Rigid, BlockKind::Deformable);
  Scene scene;
  scene.blocks.push_back(compound({geometry::make_box({-1, -1, -1}, {1.3, 1, 0}),
                                   geometry::make_box({1.3, -1, -1}, {5, 1, 0})}));
  scene.blocks[0].kind = BlockKind::Fixed;
  Block& block = scene.blocks.emplace_back(compound(ell()));
  block.material = {.density = 2000, .young = 1e9, .poisson = 0.2};
  block.kind = kind;
  block.velocity = {1, 0.1, 0};
  Simulation simulation(scene, {.time_step = 5e-3});
  std::stringstream saved;
  for (int step = 0; step < 200; ++step) {
    if (step == 100) simulation.save(saved);
    REQUIRE(simulation.advance().status == StepStatus::Converged);
  }
  Simulation resumed(scene, {.time_step = 5e-3}, saved);
  for (int step = 100; step < 200; ++step)
    REQUIRE(resumed.advance().status == StepStatus::Converged);
  CHECK(resumed.state().blocks[1].centroid == simulation.state().blocks[1].centroid);
}
