/// Equilibrium and load factors against closed forms and published limit loads.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/solver/equilibrium.hpp>
#include <quoin/solver/simulation.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using quoin::tests::WithinAbs;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kStone{.density = 2000.0};

Scene on_ground(double friction) {
  Scene scene{.joint = {.friction_angle = std::atan(friction)}};
  scene.add_fixed(geometry::make_box({-9, -9, -1}, {9, 9, 0}));
  return scene;
}

/// Live load: the weight of each block along `direction`.
EquilibriumProblem pushed(const Scene& scene, const Vector3& direction) {
  EquilibriumProblem problem = equilibrium_problem(scene);
  Scene live = scene;
  live.gravity = Vector3(scene.gravity.at(0.0).norm() * direction);
  const std::vector<Vector6> loads = block_loads(live);
  for (std::size_t b = 0; b < loads.size(); ++b) problem.blocks[b].live = loads[b];
  return problem;
}

double limit(const Scene& scene, const Vector3& direction = Vector3::UnitX()) {
  const Equilibrium found = largest_load_factor(pushed(scene, direction), 10.0);
  REQUIRE(found.verdict == EquilibriumVerdict::Admissible);
  REQUIRE(found.limited);
  REQUIRE(found.unbalance <= Equilibrium::kBalanced);
  REQUIRE(found.violation <= Equilibrium::kBalanced);
  REQUIRE(found.factorizations <= 60);
  return found.factor;
}

/// The first of Ferris and Tin-Loi's walls [Ferris & Tin-Loi 2001]: six courses in running bond.
/// All six walls: tests/tools/test_limit.py.
Scene first_wall() {
  constexpr double kLength = 0.4, kHeight = 0.175;  // m
  Scene scene{.joint = {.friction_angle = std::atan(0.65)}};
  scene.add_fixed(geometry::make_box({0, 0, -kHeight}, {5 * kLength, 1, 0}));
  for (int row = 0; row < 6; ++row) {
    const double shift = row % 2 == 0 ? 0.5 : 0.0, z = kHeight * row;
    for (double from = -shift; from < 5.0; ++from) {
      const double low = kLength * std::max(from, 0.0), high = kLength * std::min(from + 1, 5.0);
      scene.add_rigid(geometry::make_box({low, 0, z}, {high, 1, z + kHeight}), kStone);
    }
  }
  return scene;
}

}  // namespace

TEST_CASE("cohesion and tension are borne on the contact area") {
  Scene scene = on_ground(0.5);
  scene.joint.cohesion = 3e3;  // Pa
  scene.add_rigid(geometry::make_box({0, 0, 0}, {4, 1, 0.1}), kStone);
  const double weight = 2000 * 9.81 * 0.4;
  REQUIRE_THAT(limit(scene), WithinAbs(0.5 + 3e3 * 4.0 / weight, 1e-6));
  scene.joint.friction_angle = 0.0;
  REQUIRE_THAT(limit(scene), WithinAbs(3e3 * 4.0 / weight, 1e-6));
  scene.joint.tension = 5e3;
  REQUIRE_THAT(limit(scene, Vector3::UnitZ()), WithinAbs(1.0 + 5e3 * 4.0 / weight, 1e-5));
}

TEST_CASE("a column leans out by half its width") {
  for (const double out : {0.4999, 0.5001}) {
    Scene leaning = on_ground(0.8);
    leaning.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), kStone);
    leaning.add_rigid(geometry::make_box({out, 0, 1}, {1 + out, 1, 2}), kStone);
    const Equilibrium found = find_equilibrium(equilibrium_problem(leaning));
    REQUIRE(found.verdict ==
            (out < 0.5 ? EquilibriumVerdict::Admissible : EquilibriumVerdict::Mechanism));
  }
}

TEST_CASE("a masonry wall stands below its limit load, and falls above it") {
  const Scene scene = first_wall();
  const double factor = limit(scene);
  REQUIRE_THAT(factor, WithinAbs(0.642859003, 1e-6));
  const EquilibriumProblem problem = pushed(scene, Vector3::UnitX());
  const Equilibrium below = find_equilibrium(problem, 0.999 * factor);
  REQUIRE(below.verdict == EquilibriumVerdict::Admissible);
  REQUIRE(below.margin > 0.0);
  const Equilibrium above = find_equilibrium(problem, 1.001 * factor);
  REQUIRE(above.verdict == EquilibriumVerdict::Mechanism);
  REQUIRE(above.incompatibility == 0.0);
  REQUIRE(above.power > above.dissipation);
  REQUIRE(above.factorizations <= 40);
}

TEST_CASE("a bond hangs a block without cohesion, and bears shear as steps do") {
  const double weight = 2000 * 9.81;  // on 1 m2
  const auto hung = [&](double tension, double cohesion, double push) {
    Scene scene{.joint = {.friction_angle = 0.5, .cohesion = cohesion, .tension = tension}};
    scene.point_loads.push_back({1, {0.5, 0.5, 0}, Vector3(push * weight, 0, 0)});
    scene.add_fixed(geometry::make_box({-9, -9, 0}, {9, 9, 1}));
    scene.add_rigid(geometry::make_box({0, 0, -1}, {1, 1, 0}), kStone);
    return scene;
  };
  const auto of_steps = [](const Scene& scene) {
    return find_equilibrium(equilibrium_problem(Simulation(scene, {}), 0.0)).verdict;
  };
  for (const double share : {0.99, 1.01}) {
    const auto wanted =
        share > 1.0 ? EquilibriumVerdict::Admissible : EquilibriumVerdict::Mechanism;
    const Scene scene = hung(share * weight, 0.0, 0.0);
    REQUIRE(find_equilibrium(equilibrium_problem(scene)).verdict == wanted);
    REQUIRE(of_steps(scene) == wanted);
  }
  // The pull takes friction * W off its shear: c A - 0.546 W = 0.254 W.
  for (const double push : {0.25, 0.26}) {
    const bool holds = push < 0.8 - std::tan(0.5);
    const auto wanted = holds ? EquilibriumVerdict::Admissible : EquilibriumVerdict::Mechanism;
    const Scene sheared = hung(1.4 * weight, 0.8 * weight, push);
    REQUIRE(find_equilibrium(equilibrium_problem(sheared)).verdict == wanted);
    REQUIRE(of_steps(sheared) == wanted);
    for (const double stiffness : {0.0, 1e9}) {
      Scene loaded = sheared;
      loaded.joint.normal_stiffness = loaded.joint.shear_stiffness = stiffness;
      StepOptions options;
      options.analysis = Analysis::Static;
      Simulation run(loaded, options);
      StepReport report = run.advance();
      for (int i = 0; i < 500 && report.verdict == StaticVerdict::Seeking; ++i)
        report = run.advance();
      REQUIRE((report.verdict == StaticVerdict::Rest) == holds);
    }
  }
}

TEST_CASE(
    "a mechanism is looked for by fewer factorizations where forces exist, with gaps closed") {
  EquilibriumProblem problem = pushed(first_wall(), Vector3::UnitX());
  const std::vector<EquilibriumBlock> blocks = problem.blocks;
  for (const double factor : {0.5, 0.6, 0.645}) {
    for (std::size_t b = 0; b < blocks.size(); ++b)
      problem.blocks[b].load = blocks[b].load + factor * blocks[b].live;
    const Equilibrium found = find_mechanism(problem), whole = find_equilibrium(problem);
    REQUIRE(found.factorizations <= whole.factorizations);
    if (factor > 0.642859) {
      REQUIRE(found.verdict == EquilibriumVerdict::Mechanism);
      REQUIRE(found.power > found.dissipation);
    } else {
      REQUIRE(found.verdict == EquilibriumVerdict::Undecided);
      REQUIRE(found.factorizations <= 8);
    }
  }
  Scene slope = on_ground(0.1);
  slope.gravity = Vector3(2, 0, -9.81);
  slope.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), kStone);
  slope.add_fixed(geometry::make_box({1.05, 0, 0}, {2, 1, 1}));
  const Simulation simulation(slope, {});
  REQUIRE(find_mechanism(equilibrium_problem(simulation, 0.02)).verdict ==
          EquilibriumVerdict::Mechanism);
  REQUIRE(find_equilibrium(equilibrium_problem(simulation, 0.1)).verdict ==
          EquilibriumVerdict::Admissible);
}

TEST_CASE("islands, blocks without load and blocks without support are told apart") {
  Scene scene = on_ground(0.6);
  scene.gravity = Vector3(0, 0, 0);
  scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), kStone);
  scene.add_rigid(geometry::make_box({3, 0, 5}, {4, 1, 6}), kStone);
  const Equilibrium unloaded = find_equilibrium(equilibrium_problem(scene));
  REQUIRE(unloaded.verdict == EquilibriumVerdict::Admissible);
  REQUIRE(unloaded.islands == 2);
  REQUIRE(unloaded.factorizations == 0);
  scene.gravity = Vector3(0, 0, -9.81);
  const Equilibrium falling = find_equilibrium(equilibrium_problem(scene));
  REQUIRE(falling.verdict == EquilibriumVerdict::Mechanism);
  REQUIRE(falling.velocities[1].isZero(0.0));
  REQUIRE(falling.velocities[2][2] < 0.0);
}

TEST_CASE("a held point bears any force; frictionless and far lighter blocks are no harm") {
  Scene hung = on_ground(0.0);
  hung.add_rigid(geometry::make_box({0, 0, 2}, {1, 1, 3}), kStone);
  hung.fixed_points.push_back({.block = 1, .point = {0.5, 0.5, 3}, .displacement = {}});
  const Equilibrium held = find_equilibrium(equilibrium_problem(hung));
  REQUIRE(held.verdict == EquilibriumVerdict::Admissible);
  REQUIRE_THAT(held.forces.back().z(), WithinAbs(2000 * 9.81, 1e-3));
  hung.fixed_points[0].point = {0, 0, 3};  // it swings
  REQUIRE(find_equilibrium(equilibrium_problem(hung)).verdict == EquilibriumVerdict::Mechanism);

  Scene tower = on_ground(0.0);
  for (int i = 0; i < 5; ++i) {
    tower.add_rigid(geometry::make_box({0, 0, 1.0 * i}, {1, 1, i + 1.0}),
                    {.density = i == 4 ? 2e3 : 2e-3});
  }
  REQUIRE(find_equilibrium(equilibrium_problem(tower)).verdict == EquilibriumVerdict::Admissible);
}
