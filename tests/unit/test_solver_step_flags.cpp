#include <algorithm>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <utility>

#include "solver/src/step/step_flags.hpp"
#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

Scene cube_on_ground(double young) {
  Scene scene;
  scene.add_fixed(geometry::make_box({-3, -3, -1}, {60, 3, 0}));
  scene.add_block(geometry::make_box({0, 0, 0}, {1, 1, 1}),
                  {.density = 2600, .young = young, .poisson = 0.25});
  return scene;
}

const StepFlag* find(const StepReport& report, FlagKind kind) {
  const auto* found =
      std::ranges::find_if(report.flags, [&](const StepFlag& f) { return f.kind == kind; });
  return found == report.flags.end() ? nullptr : found;
}

/// What the evidence of a step at rest raises, of one kind; 0: nothing.
double value(const StepEvidence& evidence, FlagKind kind) {
  const CompiledScene compiled = compile(cube_on_ground(5e9));
  StepReport report;
  append_flags(compiled, {}, evidence, report);
  const StepFlag* flag = find(report, kind);
  return flag != nullptr ? flag->value : 0.0;
}

}  // namespace

TEST_CASE("Energy that grows by more than 1e-6 of its scale is flagged, noise of the gaps is not") {
  StepEvidence evidence{.energy_growth = 2e-6,
                        .energy_scale = 1.0,
                        .energy_noise = 1e-9,
                        .rounding = 0.0,
                        .gap_tolerance = 1e-10,
                        .missing = nullptr};
  CHECK_THAT(value(evidence, FlagKind::EnergyGrowth), WithinRel(2e-6, 1e-12));
  evidence.energy_growth = 0.5e-6;
  CHECK(value(evidence, FlagKind::EnergyGrowth) == 0.0);
  evidence.energy_growth = 2e-6;
  evidence.energy_noise = 3e-6;
  CHECK(value(evidence, FlagKind::EnergyGrowth) == 0.0);
}

TEST_CASE("An overlap that no attempt held is flagged with its blocks") {
  geometry::ContactPoint lost;
  lost.key.a = 0;
  lost.key.b = 1;
  lost.gap = -0.01;
  StepEvidence evidence{.gap_tolerance = 1e-10, .missing = &lost};
  CHECK_THAT(value(evidence, FlagKind::LostContact), WithinRel(0.01 / std::sqrt(3.0), 1e-9));
  evidence.missing = nullptr;
  CHECK(value(evidence, FlagKind::LostContact) == 0.0);
}

TEST_CASE("Energy that grows in one island is flagged there, whatever another one loses") {
  Scene scene = cube_on_ground(1e5);
  scene.blocks[1].angular_velocity = Vector3(3, 5, 7);
  scene.joint.friction_angle = 0.5;
  // Slides on another ground and loses more in every step than the cube could gain.
  scene.add_fixed(geometry::make_box({-90, -3, -1}, {-10, 3, 0}));
  const int heavy =
      scene.add_rigid(geometry::make_box({-20, -1, 0}, {-18, 1, 0.2}), {.density = 1e7});
  scene.blocks[static_cast<std::size_t>(heavy)].velocity = Vector3(-20, 0, 0);
  Simulation simulation(scene, {.time_step = 0.01});
  const StepFlag* flag = nullptr;
  for (int i = 0; i < 200 && flag == nullptr; ++i) {
    const StepReport report = simulation.advance();
    flag = find(report, FlagKind::EnergyGrowth);
    if (flag != nullptr) CHECK(flag->block == 1);
  }
  CHECK(flag != nullptr);
}

TEST_CASE("An impact that follows from another one in a step is flagged") {
  for (const double dt : {1e-3, 1e-4}) {
    CAPTURE(dt);
    Scene scene;
    scene.gravity = Vector3(Vector3::Zero());
    scene.joint.restitution = 1.0;
    for (const double x : {0.0, 0.4496, 0.8506})
      scene.add_rigid(geometry::make_box({x, 0, 0}, {x + 0.4, 0.4, 0.4}), {.density = 2000});
    scene.blocks[0].velocity = Vector3(1.5, 0, 0);
    Simulation simulation(scene, {.time_step = dt});
    bool flagged = false;
    while (simulation.state().time < 0.06) {
      const StepReport report = simulation.advance();
      const StepFlag* flag = find(report, FlagKind::Impacts);
      if (flag != nullptr) CHECK(std::pair(flag->block, flag->other) == std::pair(1, 2));
      flagged = flagged || flag != nullptr;
    }
    CHECK(flagged == (dt == 1e-3));
    if (!flagged) CHECK_THAT(simulation.state().blocks[2].velocity.x(), WithinRel(1.5, 1e-9));
  }
}
