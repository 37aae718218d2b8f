#include <array>
#include <chrono>
#include <quoin/geometry/build.hpp>
#include <quoin/solver/simulation.hpp>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "support/catch.hpp"
#include "support/same_state.hpp"
#include "support/sanitized.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

/// A heap that falls: blocks of all kinds that hit, slide and turn.
Scene heap(int blocks, double cohesion = 10.0) {
  Scene scene{.joint = {.friction_angle = 0.5, .cohesion = cohesion}};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {15, 15, 0}));
  const Material rock{.density = 2000, .young = 1e8, .poisson = 0.2};
  for (int i = 0; i < blocks; ++i) {
    const Vector3 low(0.3 * (i % 3), 0.2 * (i % 2), 1.01 * i);
    const geometry::Shape box = geometry::make_box(low, low + Vector3(1, 1, 1));
    i % 2 == 0 ? scene.add_block(box, rock) : scene.add_rigid(box, rock);
    scene.blocks.back().velocity = Vector3(0.5 * (i % 2), 0, -1);
    scene.blocks.back().angular_velocity = Vector3(0.2 * i, 0.1, 0);
  }
  return scene;
}

/// A wall of three courses that comes apart; bit 3 k + i of `deformable`: brick i of course k is.
Scene mixed_wall(unsigned deformable) {
  Scene scene{.joint = {.friction_angle = 0.6, .cohesion = 2e3, .tension = 1e3}};
  scene.joint.residual_friction_angle = 0.2;
  scene.joint.dilation_angle = 0.15;
  scene.joint.dilation_slip = 0.02;
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  const Material rock{.density = 2500, .young = 2e8, .poisson = 0.2};
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      const Vector3 low(i + 0.4 * (k % 2), 0, 0.5 * k);
      const geometry::Shape brick = geometry::make_box(low, low + Vector3(1, 0.8, 0.5));
      (deformable >> (3 * k + i)) & 1u ? scene.add_block(brick, rock)
                                       : scene.add_rigid(brick, rock);
    }
  }
  scene.blocks[1].velocity = Vector3(0.3, 0, 0.2);
  scene.blocks[4].angular_velocity = Vector3(0, 0.4, 0);
  return scene;
}

}  // namespace

TEST_CASE("a simulation that is read goes on as the one that was saved, to the bit") {
  for (const ContactMethod method : {ContactMethod::AugmentedLagrangian, ContactMethod::Penalty}) {
    const StepOptions options{.time_step = 2e-3, .method = method, .max_displacement_ratio = 0.005};
    Simulation simulation(heap(4), options);
    for (int step = 0; step < unless_sanitized(75, 30); ++step) {
      Simulation other(heap(4), options);
      std::istringstream in(saved(simulation));
      other.load(in);
      REQUIRE(simulation.advance().status == other.advance().status);
      REQUIRE(quoin::tests::same_bits(simulation.state(), other.state()));
    }
  }
}

TEST_CASE("rigid and deformable bricks go on to the bit, whatever the steps before them were") {
  for (const unsigned deformable : {0x12du, 0x0b6u, 0x153u, 0x0e5u, 0x19au, 0x06bu}) {
    for (const double dt : {1e-3, 4e-3}) {
      CAPTURE(deformable, dt);
      Simulation simulation(mixed_wall(deformable), {.time_step = dt});
      for (int step = 0; step < unless_sanitized(6, 3); ++step) {
        Simulation other(mixed_wall(deformable), {.time_step = dt});
        std::istringstream in(saved(simulation));
        other.load(in);
        REQUIRE(simulation.advance().status == other.advance().status);
        REQUIRE(quoin::tests::same_bits(simulation.state(), other.state()));
      }
    }
  }
}

TEST_CASE("a checkpoint of another scene, or half a one, is refused") {
  const Simulation simulation(heap(4), {});
  const std::string whole = saved(simulation);
  Simulation other(heap(3), {}), same(heap(4), {});
  std::istringstream in(whole), half(whole.substr(0, whole.size() / 2));
  CHECK_THROWS_AS(other.load(in), InputError);
  CHECK_THROWS_AS(same.load(half), InputError);
}

TEST_CASE("a checkpoint of other blocks is refused, and a refused one changes nothing") {
  Simulation simulation(heap(4), {});
  for (int step = 0; step < 3; ++step) REQUIRE(simulation.advance().time > 0.0);
  const std::string whole = saved(simulation);
  const auto check_refused = [](Simulation& into, const std::string& bytes) {
    const std::string before = saved(into);
    std::istringstream in(bytes);
    REQUIRE_THROWS_AS(into.load(in), InputError);
    CHECK((saved(into) == before));  // bytes: not to be printed
    CHECK(into.advance().status == StepStatus::Converged);
  };
  for (const double share : {0.1, 0.3, 0.5, 0.9, 0.999}) {
    Simulation same(heap(4), {});
    check_refused(
        same, whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
  }
  const auto changes = std::to_array<void (*)(Block&)>({
      [](Block& block) { block.placement.translation.z() += 0.4; },
      [](Block& block) { block.material.density *= 2.0; },
      [](Block& block) { block.material.young *= 2.0; },
      [](Block& block) { block.kind = BlockKind::Fixed; },
      [](Block& block) {
        block.shape =
            std::make_shared<const geometry::Shape>(geometry::make_box({0, 0, 4.1}, {1, 1, 4.9}));
      },
  });
  for (const auto& changed : changes) {
    Scene scene = heap(4);
    changed(scene.blocks.back());
    Simulation other(scene, {});
    check_refused(other, whole);
  }
}

TEST_CASE("a function of time that throws ends its step alone") {
  bool throws = false;
  const auto scene = [&] {
    Scene falling = heap(3);
    falling.gravity = VectorOfTime([&](double time) -> Vector3 {
      if (throws) throw std::runtime_error("no gravity");
      return {0, 0, -9.81 - time};
    });
    return falling;
  };
  Simulation disturbed(scene(), {.time_step = 5e-3}), undisturbed(scene(), {.time_step = 5e-3});
  for (int step = 0; step < 40; ++step) {
    if (step % 10 == 5) {
      throws = true;
      const std::string before = saved(disturbed);
      REQUIRE_THROWS_WITH(disturbed.advance(), "no gravity");
      CHECK((saved(disturbed) == before));
      throws = false;
    }
    REQUIRE(disturbed.advance().status == undisturbed.advance().status);
    REQUIRE(quoin::tests::same_bits(disturbed.state(), undisturbed.state()));
  }
}

TEST_CASE("a step that is stopped has not begun") {
  int asked = 0;
  int allowed = 0;
  StepOptions options{
      .time_step = 5e-3, .max_displacement_ratio = 1e-5, .smallest_time_step = 1e-9};
  Simulation undisturbed(heap(12, 0.0), options);
  options.watch = [&](const StepReport&) { return ++asked <= allowed; };
  // Each sub-step lasts longer than watches wait for, on a fast machine too.
  options.contact_problem = [&](const ContactProblem&) {
    if (allowed < 3) std::this_thread::sleep_for(std::chrono::milliseconds(60));
  };
  Simulation simulation(heap(12, 0.0), options);
  for (allowed = 0; allowed < 3; ++allowed) {
    asked = 0;
    REQUIRE(simulation.advance().status == StepStatus::Stopped);
    REQUIRE(simulation.state().step == 0);
    REQUIRE(quoin::tests::same_bits(simulation.state(), undisturbed.state()));
  }
  allowed = 1 << 30;
  REQUIRE(simulation.advance().status == undisturbed.advance().status);
  REQUIRE(quoin::tests::same_bits(simulation.state(), undisturbed.state()));
}
