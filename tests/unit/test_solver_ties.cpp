/// Ties through a change of the scene and a checkpoint, and those that are refused. Closed forms:
/// tools/scenes/cases/tie_*.json.

#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <sstream>

#include "support/catch.hpp"
#include "support/message.hpp"

using namespace quoin::solver;

namespace {

constexpr double kWeight = 2500 * 9.81;  // of a cube of 1 m
const StepOptions kStatic{.analysis = Analysis::Static};

Scene cube() {
  Scene scene;
  scene.add_rigid(quoin::geometry::make_box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}),
                  {.density = 2500});
  return scene;
}

bool near(double value, double wanted, double relative) {
  return std::abs(value - wanted) <= relative * std::abs(wanted);
}

void rest(Simulation& simulation) {
  for (int i = 0; i < 400; ++i) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    if (report.verdict == StaticVerdict::Rest) return;
  }
  FAIL("no rest");
}

}  // namespace

TEST_CASE(
    "a tie put in by a change of the scene is unstressed there, and goes on after a checkpoint") {
  Scene scene = cube();
  scene.ties.push_back({.a = 0, .point_b = {0, 0, 3}, .stiffness = 1e6});
  Simulation simulation(scene, kStatic);
  rest(simulation);
  const double length = simulation.state().ties[0].length;
  scene.ties.push_back(scene.ties[0]);
  scene.ties[1].name = "second";
  scene.ties[1].pretension = 100.0;
  simulation.change(scene);
  CHECK(near(simulation.state().ties[0].force, kWeight, 1e-6));
  CHECK(near(simulation.state().ties[1].force, 100.0, 1e-9));
  CHECK(simulation.state().ties[1].length == length);
  std::stringstream saved;
  simulation.save(saved);
  Simulation other(scene, kStatic, saved);
  for (int i = 0; i < 5; ++i) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    REQUIRE(other.advance().status == StepStatus::Converged);
  }
  CHECK(other.state().ties[1].force == simulation.state().ties[1].force);
  CHECK(near(simulation.state().ties[0].force + simulation.state().ties[1].force, kWeight, 1e-3));
}

TEST_CASE("ties that are none are refused in one line") {
  const Scene scene = cube();
  const auto refused = [&](const Tie& tie, const std::string& said) {
    Scene with = scene;
    with.ties.push_back(tie);
    CHECK_THAT(quoin::tests::message([&] { Simulation(with, {}); }),
               quoin::tests::ContainsSubstring(said));
  };
  const Tie good{.a = 0, .point_b = {0, 0, 3}, .stiffness = 1e6};
  const auto with = [&](const auto& set) {
    Tie tie = good;
    set(tie);
    return tie;
  };
  refused(with([](Tie& t) { t.stiffness = 0.0; }), "stiffness");
  refused(with([](Tie& t) { t.a = 7; }), "tie 0");
  refused(with([](Tie& t) { t.b = 0; }), "both ends");
  refused(with([](Tie& t) { t.a = -1; }), "can move");
  refused(with([](Tie& t) { t.point_b.setZero(); }), "length");
  refused(with([](Tie& t) { t.pretension = -1.0; }), "pretension");
  refused(with([](Tie& t) { t.yield_force = 0.0; }), "yield");
}
