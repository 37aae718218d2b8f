/// The solver as its user meets it: refusal of bad scenes, steps that cannot converge, bits by
/// threads. Mechanics are cases of tools/scenes.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <quoin/solver/output.hpp>
#include <quoin/solver/parts.hpp>
#include <sstream>

#include "step/step_flags.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/same_state.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};

geometry::Shape unit_cube(const Vector3& corner) {
  return geometry::make_box(corner, corner + Vector3::Ones());
}

Scene cube_on_ground() {
  Scene scene;
  scene.joint.friction_angle = 0.5;
  scene.add_fixed(geometry::make_box({-3, -3, -1}, {3, 3, 0}));
  scene.add_block(unit_cube({0, 0, 0}), kRock);
  return scene;
}

std::string refusal(const Scene& scene, const StepOptions& options = {}) {
  return message([&] { Simulation(scene, options); });
}

bool all_finite(const State& state) {
  for (const BlockState& b : state.blocks)
    if (!b.centroid.allFinite() || !b.rotation.coeffs().allFinite() || !b.strain.allFinite() ||
        !b.velocity.allFinite() || !b.angular_velocity.allFinite() || !b.strain_rate.allFinite())
      return false;
  return std::isfinite(state.energy.mechanical());
}

}  // namespace

TEST_CASE("Scenes that cannot be worked with are refused, and say why") {
  CHECK(refusal(cube_on_ground()).empty());
  CHECK_THAT(refusal(Scene{}), ContainsSubstring("no blocks"));
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  static const Vector3 none(0, infinite, 0), push(1, 0, 0), zero = Vector3::Zero();
  const struct {
    void (*set)(Scene&);
    const char *said, *too = "";
  } cases[] = {
      {[](Scene& s) { s.blocks[1].placement.translation.z() = -0.01; }, "blocks 0 and 1 overlap"},
      {[](Scene& s) { s.blocks[1].placement.translation.x() = 1e300; },
       "block 1: translation (1e+300", "less than 1e+30 m"},
      {[](Scene& s) { s.blocks[1].velocity.x() = 1e160; }, "block 1", "velocity"},
      {[](Scene& s) { s.blocks[1].velocity.x() = std::nan(""); }, "block 1", "velocity"},
      {[](Scene& s) { s.blocks[1].material.density = 0.0; }, "block 1", "density"},
      {[](Scene& s) { s.blocks[1].material.density = infinite; },
       "density inf kg/m3 must be finite"},
      {[](Scene& s) { s.blocks[1].initial_stress[2] = infinite; }, "block 1", "initial stress"},
      {[](Scene& s) { s.blocks[0].motion.value = none; }, "block 0", "motion"},
      {[](Scene& s) {
         s.point_loads = {{0, zero, push}};
       },
       "point load", "block 0"},
      {[](Scene& s) {
         s.point_loads = {{1, zero, none}};
       },
       "point load 0: force"},
      {[](Scene& s) {
         s.face_loads = {{0, 0, push}};
       },
       "face load"},
      {[](Scene& s) {
         s.face_loads = {{1, 6, push}};
       },
       "no face 6"},
      {[](Scene& s) {
         s.face_loads = {{1, 0, none}};
       },
       "face load 0: traction"},
      {[](Scene& s) {
         s.body_loads = {{2, push}};
       },
       "block 2"},
      {[](Scene& s) {
         s.body_loads = {{1, none}};
       },
       "body load 0: force"},
      {[](Scene& s) {
         s.fixed_points = {{0, zero, {}}};
       },
       "fixed point"},
      {[](Scene& s) {
         s.fixed_points = {{1, none, {}}};
       },
       "fixed point 0: point"},
      {[](Scene& s) {
         s.fixed_points = {{1, zero, none}};
       },
       "fixed point 0: displacement"},
      {[](Scene& s) { s.joint.friction_angle = 1.6; }, "friction angle"},
      {[](Scene& s) { s.joint.residual_friction_angle = -0.5; },
       "residual friction angle -0.5 rad"},
      {[](Scene& s) { s.joint.restitution = 1.5; }, "restitution"},
      {[](Scene& s) { s.joint.cohesion = -1.0; }, "cohesion"},
      {[](Scene& s) { s.joint.tension = infinite; }, "tension is not finite"},
      {[](Scene& s) { s.pair_joints = {{.joint = {.tension = NAN}}}; }, "pair joint 0", "tension"},
      {[](Scene& s) {
         s.pair_joints = {{0, 1, {}}, {0, 0, {}}, {1, 0, {}}};
       },
       "pair joints 0 and 2", "joint groups 0 and 1"},
      {[](Scene& s) { s.gravity = Vector3(0, 0, infinite); }, "gravity"}};
  for (const auto& wrong : cases) {
    Scene scene = cube_on_ground();
    wrong.set(scene);
    CHECK_THAT(refusal(scene), ContainsSubstring(wrong.said) && ContainsSubstring(wrong.too));
  }
  Scene scene = cube_on_ground();
  scene.blocks[1].placement.translation.z() = -1e-4;  // kept and reported
  CHECK(refusal(scene).empty());
  scene.blocks[1].placement.translation.z() = -0.01;
  scene.initial_overlap = InitialOverlap::Keep;
  CHECK(refusal(scene).empty());
  CHECK_THROWS_WITH(interpolate({0, 1}, {none, none}), ContainsSubstring("entry 0 is not finite"));
}

TEST_CASE("Blocks, parts and pieces that do not exist are refused") {
  const Scene scene = cube_on_ground();
  const Simulation simulation(scene, {});
  for (const int block : {-1, 2, 100000}) {
    CAPTURE(block);
    CHECK_THROWS_AS(simulation.vertices(block), InputError);
    CHECK_THROWS_AS(simulation.stress(block), InputError);
    CHECK_THROWS_AS(simulation.reference_arm(block, Vector3::Zero()), InputError);
    CHECK_THROWS_AS(simulation.displacement(block, Vector3::Zero()), InputError);
  }
  const std::vector<Vector3> points(3, Vector3::Zero());
  const std::vector<double> weights(3, 1.0);
  CHECK_THROWS_AS(bisect(points, weights, 0), InputError);
  CHECK_THROWS_AS(bisect(points, std::span(weights).first(2), 2), InputError);
  CHECK_THROWS_AS(parts_of_blocks(scene, -1), InputError);
  CHECK_THROWS_AS(write_index("index.pvtu", {}), InputError);
  const std::span<const BlockState> one(simulation.state().blocks.data(), 1);
  CHECK_THROWS_WITH(write_blocks("blocks.vtu", simulation, one),
                    "blocks.vtu: 1 places are given for 2 blocks");
  const std::vector<int> parts{0};
  CHECK_THROWS_AS(write_contacts("contacts.vtp", simulation, {.part_of_block = parts}), InputError);
}

TEST_CASE("A series names its files as XML wants it, one for each time") {
  CHECK_THROWS_WITH(write_series("series.pvd", {0.0, 1.0}, {"a.vtu"}),
                    ContainsSubstring("series.pvd: 2 times are given for 1 files"));
  const std::string path = (std::filesystem::temp_directory_path() / "quoin_series.pvd").string();
  write_series(path, {0.5}, {"a&b \"<c>.vtu"});
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  std::filesystem::remove(path);
  CHECK_THAT(text.str(),
             ContainsSubstring("<DataSet file=\"a&amp;b &quot;&lt;c>.vtu\" timestep=\"0.5\"/>"));
}

TEST_CASE("Options that cannot be worked with are refused") {
  const Scene scene = cube_on_ground();
  const double infinite = std::numeric_limits<double>::infinity();
  const std::pair<StepOptions, const char*> cases[] = {{{.time_step = 0.0}, "time step"},
                                                       {{.time_step = -1e-3}, "time step"},
                                                       {{.time_step = std::nan("")}, "time step"},
                                                       {{.reach = infinite}, "reach"},
                                                       {{.penalty = -1.0}, "penalty"},
                                                       {{.shear_ratio = 0.0}, "shear ratio"},
                                                       {{.shear_ratio = infinite}, "shear ratio"},
                                                       {{.tolerance = 0.0}, "tolerance"},
                                                       {{.max_iterations = 0}, "iterations"},
                                                       {{.threads = 0}, "threads"}};
  for (const auto& [options, said] : cases)
    CHECK_THAT(refusal(scene, options), ContainsSubstring(said));
  Simulation simulation(scene, {});
  CHECK_THROWS_AS(simulation.set_options({.time_step = 0.0}), InputError);
  CHECK_THROWS_AS(simulation.set_velocities(std::array{BlockVelocity{.block = 0}}), InputError);
  CHECK_THROWS_AS(simulation.set_velocities(std::array{BlockVelocity{.block = 2}}), InputError);
  for (const double wrong : {infinite, std::nan(""), 1e300}) {
    const BlockVelocity moved{.block = 1, .velocity = {wrong, 0, 0}};
    const BlockVelocity turned{.block = 1, .angular_velocity = {0, wrong, 0}};
    CHECK_THROWS_WITH(simulation.set_velocities(std::array{moved}), ContainsSubstring("block 1"));
    CHECK_THROWS_WITH(simulation.set_velocities(std::array{turned}), ContainsSubstring("block 1"));
    CHECK(simulation.state().blocks[1].velocity.isZero(0.0));
    CHECK(simulation.state().blocks[1].angular_velocity.isZero(0.0));
  }
}

TEST_CASE("A step that cannot converge leaves the state alone and offers its best try") {
  // Plain multiplier updates with a spring far too soft, and one iteration to do it in.
  Simulation simulation(cube_on_ground(), {.time_step = 1e-3,
                                           .method = ContactMethod::Paper,
                                           .penalty = 1.0,
                                           .max_iterations = 1,
                                           .smallest_time_step = 5e-4});
  const State before = simulation.state();
  const StepReport report = simulation.advance();
  REQUIRE(report.status == StepStatus::NotConverged);
  CHECK(report.cuts_by_convergence > 0);
  CHECK(report.sub_steps == 0);
  CHECK_THAT(describe(report), ContainsSubstring("did not converge"));
  const State& after = simulation.state();
  CHECK(after.time == before.time);
  CHECK(after.blocks[1].centroid == before.blocks[1].centroid);
  CHECK(after.blocks[1].velocity == before.blocks[1].velocity);
  CHECK(after.blocks[1].strain == before.blocks[1].strain);
  REQUIRE(simulation.best_try().blocks.size() == 2);
  CHECK(simulation.best_try().blocks[1].centroid.allFinite());
  CHECK(simulation.best_try().time > before.time);
  simulation.take_best_try();
  CHECK(simulation.state().time > before.time);
  CHECK(all_finite(simulation.state()));
}

TEST_CASE("A failed step in the air leaves no contact of an earlier impact") {
  StepOptions options;
  options.time_step = 2e-2;
  options.reach = 0.02;
  StepOptions hasty = options;
  hasty.max_iterations = 3;
  hasty.smallest_time_step = hasty.time_step;
  constexpr int kBounced = 6;  // steps until then
  const auto flies = [](const Simulation& simulation) {
    return std::ranges::all_of(simulation.state().contacts, [](const Contact& contact) {
      return contact.mode == ContactMode::Open && contact.normal_force == 0.0;
    });
  };
  int failed = 0;
  for (int draw = 0; draw < 8; ++draw) {
    Scene scene;
    scene.joint.friction_angle = 0.6;
    scene.joint.restitution = 0.8;
    scene.add_fixed(geometry::make_box({-20, -20, -1}, {20, 20, 0}));
    const double low = 0.05 + 0.01 * draw;
    Block& slab = scene.blocks[static_cast<std::size_t>(
        scene.add_rigid(geometry::make_box({-0.8, -0.6, low}, {0.8, 0.6, low + 0.2}), kRock))];
    slab.velocity = {0.3, 0, -1};
    slab.angular_velocity = {1.3 + 0.05 * draw, 0.9 - 0.03 * draw, 0.2};
    Simulation simulation(scene, options);
    for (int step = 0; step < 120; ++step) {
      const bool in_the_air = step > kBounced && flies(simulation);
      simulation.set_options(in_the_air ? hasty : options);
      if (simulation.advance().status == StepStatus::Converged || !in_the_air) continue;
      ++failed;
      CHECK(flies(simulation));
      break;
    }
  }
  CHECK(failed > 0);
}

TEST_CASE("set_velocities sets a settled block in motion, in world axes") {
  Scene scene;
  scene.gravity = Vector3(0, 0, 0);
  scene.add_rigid(unit_cube({0, 0, 0}), kRock);
  scene.blocks[0].angular_velocity = Vector3(0, 0, 1);
  Simulation simulation(scene, {.time_step = 0.01});
  for (int i = 0; i < 100; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
  simulation.set_velocities(std::array{BlockVelocity{0, Vector3(1, 0, 0), Vector3(0, 2, 0)}});
  const BlockState& block = simulation.state().blocks[0];
  CHECK((block.rotation * block.angular_velocity - Vector3(0, 2, 0)).norm() < 1e-14);
  const EnergyLedger& energy = simulation.state().energy;
  CHECK_THAT(energy.kinetic, WithinRel(0.5 * 2500 * (1.0 + 4.0 / 6.0), 1e-12));
  CHECK_THAT(energy.work, WithinRel(0.5 * 2500 * (1.0 + 3.0 / 6.0), 1e-12));  // what it had is less
}

namespace {

/// Integrals of a table from its first knot to `time`, which is not beyond the last.
struct Integrals {
  Vector3 once = Vector3::Zero(), twice = Vector3::Zero();
};

Integrals integrals(const std::vector<double>& times, const std::vector<Vector3>& values,
                    double time) {
  Integrals sum;
  for (std::size_t i = 1; i < times.size() && times[i - 1] < time; ++i) {
    const double h = std::min(times[i], time) - times[i - 1];
    const Vector3 slope = (values[i] - values[i - 1]) / (times[i] - times[i - 1]);
    sum.twice += h * sum.once + h * h * (values[i - 1] / 2.0 + h * slope / 6.0);
    sum.once += h * (values[i - 1] + h * slope / 2.0);
  }
  return sum;
}

}  // namespace

// At 20 ms a rule over whole steps is off by more than the motion.
TEST_CASE("Motion by a table of velocities or accelerations is its integral at any time step") {
  std::vector<double> times;
  std::vector<Vector3> values;
  for (int i = 0; i <= 401; ++i) {
    times.push_back(2.5e-3 * i);
    values.emplace_back(std::sin(37.0 * i * i), std::cos(11.0 * i * i), i % 3 - 1.0);
  }
  for (const MotionKind kind : {MotionKind::Velocity, MotionKind::Acceleration}) {
    for (const double time_step : {0.02, 0.007, 0.0025, 0.001}) {
      Scene scene;
      scene.add_fixed(unit_cube({0, 0, 0}));
      scene.blocks[0].kind = BlockKind::Prescribed;
      scene.blocks[0].motion = {kind, interpolate(times, values)};
      Simulation simulation(scene, {.time_step = time_step});
      while (simulation.state().time + time_step < 1.0025) {
        REQUIRE(simulation.advance().status == StepStatus::Converged);
        const State& state = simulation.state();
        const auto [once, twice] = integrals(times, values, state.time);
        const bool accelerated = kind == MotionKind::Acceleration;
        const Vector3 moved = state.blocks[0].centroid - Vector3(0.5, 0.5, 0.5);
        CAPTURE(accelerated, time_step, state.time);
        REQUIRE((moved - (accelerated ? twice : once)).norm() < 1e-14);
        if (accelerated) REQUIRE((state.blocks[0].velocity - once).norm() < 1e-14);
      }
    }
  }
}

TEST_CASE("Any number of threads gives the same bits") {
  const auto run = [](int threads) {
    Scene scene;
    scene.joint.friction_angle = 0.5;
    scene.add_fixed(geometry::make_box({-1, -1, -1}, {30, 30, 0}));
    for (int i = 0; i < 1024; ++i) {  // stacks of four with a lean and a drop: all pairs change
      const int x = i % 16, y = i / 16 % 16, z = i / 256;
      scene.add_rigid(unit_cube({1.6 * x + 0.1 * z, 1.6 * y, 1.001 * z + 0.001}), kRock);
    }
    Simulation simulation(scene, {.time_step = 5e-3, .threads = threads});
    for (int i = 0; i < 8; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
    return simulation.state();
  };
  const State one = run(1);
  for (const int threads : {2, 4}) CHECK(same_bits(one, run(threads)));
}

TEST_CASE("Time is counted in steps, not added up; static steps take none") {
  Scene scene;
  scene.add_fixed(geometry::make_box({-3, -3, -1}, {3, 3, 0}));
  scene.add_rigid(unit_cube({0, 0, 0}), kRock);
  Simulation simulation(scene, {.time_step = 0.1, .analysis = Analysis::Static});
  for (int i = 0; i < 3; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
  CHECK(simulation.state().time == 0.0);
  simulation.set_options({.time_step = 0.1});
  for (int i = 1; i <= 100000; ++i) REQUIRE(simulation.advance().time == 0.1 * i);
}

TEST_CASE("The best try of a failed step keeps the prescribed motion") {
  Scene scene = cube_on_ground();
  scene.blocks[0].kind = BlockKind::Prescribed;
  scene.blocks[0].motion = {MotionKind::Velocity, Vector3(1, 0, 0)};
  StepOptions hopeless{.time_step = 1e-3, .max_iterations = 1, .smallest_time_step = 1e-3};
  hopeless.tolerance = 1e-15;
  Simulation simulation(scene, hopeless);
  REQUIRE(simulation.advance().status == StepStatus::NotConverged);
  simulation.take_best_try();
  const double place = simulation.state().blocks[0].centroid.x();
  CHECK_THAT(place, WithinRel(simulation.state().time, 1e-12));
  simulation.set_options({.time_step = 1e-3});
  REQUIRE(simulation.advance().status == StepStatus::Converged);
  CHECK_THAT(simulation.state().blocks[0].centroid.x(), WithinRel(simulation.state().time, 1e-12));
}

TEST_CASE("A step that can't be solved ends within its iterations and says which contacts fight") {
  Scene scene = cube_on_ground();
  scene.add_block(unit_cube({0, 0, 1}), kRock);
  for (const Analysis analysis : {Analysis::Dynamic, Analysis::Static}) {
    const StepOptions hopeless{.time_step = 1e-3,
                               .analysis = analysis,
                               .contact_iteration = ContactIteration::OpenClose,
                               .max_iterations = 2};
    Simulation simulation(scene, hopeless);
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::NotConverged);
    CHECK(report.cuts_by_convergence == 11);
    CHECK(report.iterations <= 11 * 3);  // one more: an attempt ends with the iteration it is in
    REQUIRE(report.fighting.count > 0);
    const FightingContact& worst = report.fighting.contacts[0];
    CHECK(worst.change > 0.0);
    CHECK(worst.other == worst.block + 1);
    CHECK_THAT(worst.place.z(), WithinAbs(worst.block, 1e-3));  // of the joint below the upper one
  }
}

TEST_CASE("A step that no iteration solves ends after the attempts of both") {
  Scene scene = cube_on_ground();
  scene.add_block(unit_cube({0, 0, 1}), kRock);
  Simulation simulation(scene, {.time_step = 1e-3, .max_iterations = 2});
  const StepReport report = simulation.advance();
  REQUIRE(report.status == StepStatus::NotConverged);
  // Open-close whole and halved, then the other: it has had the whole one, which is no cut.
  CHECK(report.cuts_by_convergence == 2 + 10);
  CHECK(report.proximal_newton_attempts >= 11);
  CHECK(report.iterations < 100);  // 75; where one was not bounded, 221 and more
}

TEST_CASE("A closed contact whose blocks are no longer found is told, unless they rebounded") {
  Scene scene = cube_on_ground();
  scene.add_block(unit_cube({0, 0, 1}), kRock);
  const CompiledScene compiled = compile(std::move(scene));
  std::vector<Contact> contacts(2);
  contacts[0].point.key = {0, 1, {}, {}};
  contacts[1].point.key = {1, 2, {}, {}};
  std::vector<geometry::ContactPoint> found{contacts[0].point};
  CHECK(vanished(compiled, contacts, found) == nullptr);
  contacts[1].mode = ContactMode::Stick;
  CHECK(vanished(compiled, contacts, found) == &contacts[1].point);
  contacts[1].impact = true;
  CHECK(vanished(compiled, contacts, found) == &contacts[1].point);
  contacts[1].point.gap = 1e-3;
  CHECK(vanished(compiled, contacts, found) == nullptr);
  contacts[1].impact = false;
  found.push_back(contacts[1].point);
  CHECK(vanished(compiled, contacts, found) == nullptr);
}
