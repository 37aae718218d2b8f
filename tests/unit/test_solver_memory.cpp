/// What a wall takes of memory a brick: its contacts, its equations and what the search knows of
/// it.

#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "contact/contact_history.hpp"
#include "contact/linear_contact.hpp"
#include "support/catch.hpp"
#include "support/counted_allocations.hpp"

using namespace quoin::solver;
namespace geometry = quoin::geometry;

// A brick of a wall has 12 contacts: 100 bytes of each are 1.2 kB a brick.
static_assert(sizeof(Contact) <= 272);
static_assert(sizeof(BodyContact) <= 424);  // 8 of them name the convex parts of compounds
static_assert(sizeof(LinearContact) <= 632);

namespace {

/// Running bond of 20 × 10 bricks on a base; all whole bricks share one shape.
Scene wall() {
  constexpr double length = 0.4, height = 0.2;
  constexpr int columns = 20, rows = 10;
  const auto brick =
      std::make_shared<const geometry::Shape>(geometry::make_box({0, 0, 0}, {length, 0.2, height}));
  Scene scene{.joint = {.friction_angle = 0.6}};
  scene.add_fixed(geometry::make_box({-2, -2, -1}, {length * columns + 2, 2, 0}));
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < columns; ++i) {
      Block block{.shape = brick, .material = {.density = 2000}};
      block.placement.translation = {length * (i + 0.5 * (row % 2)), 0, height * row};
      block.kind = BlockKind::Rigid;
      scene.blocks.push_back(block);
    }
  }
  return scene;
}

/// Held after two steps: the first comes to rest, the second solves nothing.
double kilobytes_a_brick() {
  Scene scene = wall();
  const double bricks = static_cast<double>(scene.blocks.size() - 1);
  const long before = quoin::tests::bytes_in_use;
  Simulation simulation(std::move(scene), {.time_step = 0.01});
  for (int step = 0; step < 2; ++step)
    REQUIRE(simulation.advance().status == StepStatus::Converged);
  return static_cast<double>(quoin::tests::bytes_in_use - before) / bricks / 1000.0;
}

}  // namespace

TEST_CASE("Memory a brick of a wall of rigid bricks") {
  CHECK(kilobytes_a_brick() <= 42.0);  // measured: 39
}
