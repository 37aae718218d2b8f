/// The list of contacts when islands take their steps apart: each contact once, none of blocks that
/// have parted, those of islands at rest whatever becomes of the others.

#include <algorithm>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <random>
#include <sstream>

#include "support/catch.hpp"
#include "support/same_state.hpp"

using namespace quoin::solver;
using quoin::geometry::make_box;

namespace {

constexpr Material kStone{.density = 2400};

Block& add_cube(Scene& scene, const Vector3& low, const Vector3& velocity = Vector3::Zero()) {
  const int block = scene.add_rigid(make_box(low, low + Vector3(1, 1, 1)), kStone);
  Block& added = scene.blocks[static_cast<std::size_t>(block)];
  added.velocity = velocity;
  return added;
}

/// A block that slides, one that tumbles when it lands, and more of these.
Scene sliding_and_tumbling() {
  Scene scene{.joint = {.friction_angle = 0.35}};
  scene.add_fixed(make_box({-50, -50, -1}, {50, 50, 0}));
  add_cube(scene, {0, 0, 0}, {3, 0.5, 0});
  for (int i = 0; i < 6; ++i) {
    add_cube(scene, {10.0 + 4 * i, 10, 0.05 + 0.01 * i}, {0.3, 0, -1}).angular_velocity =
        Vector3(2 + 0.3 * i, 1, 0.5);
  }
  return scene;
}

auto key_of(const Contact& contact) { return contact.point.key; }

std::vector<double> numbers(const State& state) {
  std::vector<double> result;
  for (const BlockState& block : state.blocks)
    for (const Vector3* v : {&block.centroid, &block.velocity, &block.angular_velocity})
      result.insert(result.end(), v->begin(), v->end());
  for (const Contact& contact : state.contacts) result.push_back(contact.normal_force);
  return result;
}

}  // namespace

TEST_CASE("An island that needs another round finds no contact of the others twice") {
  const StepOptions options{.time_step = 2e-3, .reach = 1e-4};
  Simulation simulation(sliding_and_tumbling(), options);
  for (int i = 0; i < 100; ++i) {
    std::istringstream before(quoin::tests::saved(simulation));
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    const std::vector<Contact>& contacts = simulation.state().contacts;
    const auto twin = std::ranges::adjacent_find(
        contacts, [](const Contact& a, const Contact& b) { return !(key_of(a) < key_of(b)); });
    CHECK(twin == contacts.end());
    if (i % 10 != 0) continue;
    Simulation resumed(sliding_and_tumbling(), options, before);
    REQUIRE(resumed.advance().status == StepStatus::Converged);
    CHECK(numbers(resumed.state()) == numbers(simulation.state()));
  }
}

TEST_CASE("Of two blocks that have parted no contact is left") {
  Scene scene{.joint = {.friction_angle = 0.35}};
  scene.add_fixed(make_box({-500, -500, -1}, {500, 500, 0}));
  for (int i = 0; i < 40; ++i) add_cube(scene, {3.0 * i, 0, 0});
  add_cube(scene, {0, 50, 10}, {-0.5, 0, 3});
  add_cube(scene, {1.0001, 50.2, 10}, {0.5, 0, 3});
  Simulation simulation(scene, {.time_step = 2e-3});
  for (int i = 0; i < 50; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
  CHECK(simulation.state().contacts.size() == 40 * 4);
}

TEST_CASE("The best try of one island leaves the bonds of another at rest") {
  Scene scene{.joint = {.friction_angle = 0.35, .cohesion = 1e6, .tension = 1e6}};
  scene.add_fixed(make_box({-50, -50, -1}, {50, 50, 0}));
  scene.add_fixed(make_box({20, 0, 5}, {21, 1, 6}));
  add_cube(scene, {20, 0, 4});
  add_cube(scene, {0, 0, 1.6}, {3, 1, -3}).angular_velocity = Vector3(5, 3, 1);
  const StepOptions options{.time_step = 5e-3,
                            .contact_iteration = ContactIteration::OpenClose,
                            .max_iterations = 6,
                            .smallest_time_step = 5e-3};
  Simulation simulation(scene, options);
  int failed = 0;
  for (int i = 0; i < 120; ++i) {
    const StepStatus status = simulation.advance().status;
    REQUIRE(status != StepStatus::Diverged);
    if (status != StepStatus::NotConverged) continue;
    ++failed;
    simulation.take_best_try();
  }
  REQUIRE(failed > 0);
  CHECK(simulation.displacement(2, Vector3::Zero()).norm() < 1e-9);
}

TEST_CASE("A joint of faces that are flush but for rounding has the area of both, and its bonds") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto vector = [&](double size) {
    return Vector3(size * Vector3(any(random), any(random), any(random)));
  };
  for (int i = 0; i < 100; ++i) {
    Scene scene{
        .joint = {
            .cohesion = 1e6, .tension = 1e6, .normal_stiffness = 1e9, .shear_stiffness = 1e9}};
    scene.add_fixed(make_box({0, 0, 1}, {1, 1, 2}));
    Block& hung = add_cube(scene, {3e-9 * any(random), 3e-9 * any(random), 0}, vector(1e-4));
    hung.placement.linear = Eigen::AngleAxisd(3e-9 * any(random), Vector3::UnitZ()).matrix();
    hung.angular_velocity = vector(1e-4);
    Simulation simulation(scene, {.time_step = 1e-3});
    for (int step = 0; step < 100; ++step) {
      REQUIRE(simulation.advance().status == StepStatus::Converged);
      double area = 0.0;
      for (const Contact& contact : simulation.state().contacts)
        area += contact.failed ? 0.0 : contact.spring_area;
      CHECK(std::abs(area - 1.0) < 1e-6);
    }
  }
}
