/// Simulation::change against closed forms.
#include <array>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver/simulation.hpp>
#include <sstream>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr double kG = 9.81;  // m/s2
const Material kStone{.density = 2000, .young = 1e9, .poisson = 0.2};

geometry::Shape cube_at(double x, double z) {
  return geometry::make_box({x, 0, z}, {x + 1, 1, z + 1});
}

/// Ground, a cube on it, and another that stands on that.
Scene stack() {
  Scene scene{.joint = {.friction_angle = 0.6}};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(cube_at(0, 0), kStone);
  scene.add_rigid(cube_at(0, 1), kStone);
  return scene;
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
}

/// Of all contacts with block 0, N.
double force_on_ground(const Simulation& simulation) {
  double sum = 0.0;
  for (const Contact& contact : simulation.state().contacts) {
    if (contact.point.key.a == 0) sum += contact.normal_force;
  }
  return sum;
}

std::string saved(const Simulation& simulation) {
  std::ostringstream out;
  simulation.save(out);
  return out.str();
}

}  // namespace

TEST_CASE("a block that is laid adds its weight, one that is taken away takes it along") {
  const double weight = 2000 * kG;
  Scene without = stack();
  without.blocks[2].kind = BlockKind::Absent;
  for (const Analysis analysis : {Analysis::Static, Analysis::Dynamic}) {
    Simulation simulation(without, {.analysis = analysis});
    run(simulation, 3);
    REQUIRE(std::abs(force_on_ground(simulation) - weight) < 1e-6 * weight);
    simulation.change(stack());
    run(simulation, 3);
    REQUIRE(std::abs(force_on_ground(simulation) - 2 * weight) < 1e-6 * weight);
    simulation.change(without);
    run(simulation, 3);
    REQUIRE(std::abs(force_on_ground(simulation) - weight) < 1e-6 * weight);
    for (const Contact& contact : simulation.state().contacts) REQUIRE(contact.point.key.b == 1);
    REQUIRE(std::abs(simulation.state().energy.closure) < 1e-6 * weight);
  }
}

TEST_CASE("a support that is released falls freely, from rest or with its motion's velocity") {
  Scene scene = stack();
  Scene held = scene;
  held.gravity = VectorOfTime(Vector3(0, 0, -kG));
  held.blocks[1].kind = BlockKind::Absent;
  held.blocks[0].kind = BlockKind::Absent;
  held.blocks[2].kind = BlockKind::Fixed;
  Scene released = held;
  released.blocks[2].kind = BlockKind::Deformable;
  for (const double speed : {0.0, 2.0}) {
    if (speed > 0.0) {
      held.blocks[2].kind = BlockKind::Prescribed;
      held.blocks[2].motion = {MotionKind::Velocity, VectorOfTime(Vector3(speed, 0, 0))};
    }
    Simulation simulation(held, {.time_step = 1e-2});
    run(simulation, 10);
    simulation.change(released);
    run(simulation, 50);
    const Vector3 moved = simulation.state().blocks[2].centroid - Vector3(0.5, 0.5, 1.5);
    REQUIRE((moved - Vector3(speed * 0.6, 0, -0.5 * kG * 0.25)).norm() < 1e-10);
    REQUIRE((simulation.state().blocks[2].velocity - Vector3(speed, 0, -0.5 * kG)).norm() < 1e-9);
    REQUIRE(std::abs(simulation.state().energy.closure) < 1e-6);
  }
}

TEST_CASE("a block slides with g (sin - cos tan) as soon as the joint's law lets it") {
  Scene scene{.joint = {.friction_angle = 0.7}};
  const double slope = 0.5, phi = 0.3;
  scene.gravity = VectorOfTime(Vector3(kG * std::sin(slope), 0, -kG * std::cos(slope)));
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {15, 5, 0}));
  scene.add_block(cube_at(0, 0), {.density = 2000, .young = 1e10, .poisson = 0.2});
  Simulation simulation(scene, {.time_step = 1e-2});
  run(simulation, 50);
  const double before = simulation.state().blocks[1].centroid.x();
  REQUIRE(std::abs(before - 0.5) < 1e-4);
  scene.joint.friction_angle = phi;
  simulation.change(scene);
  run(simulation, 100);
  const double a = kG * (std::sin(slope) - std::cos(slope) * std::tan(phi));
  REQUIRE(std::abs(simulation.state().blocks[1].centroid.x() - before - 0.5 * a) < 2e-3 * a);
}

TEST_CASE("a motion counts from where its block stands, a held point stays where it is") {
  Scene scene;
  scene.gravity = VectorOfTime(Vector3(Vector3::Zero()));
  scene.add_rigid(cube_at(0, 0), kStone);
  scene.blocks[0].velocity = Vector3(1, 0, 0);
  Simulation simulation(scene, {.time_step = 1e-2});
  run(simulation, 100);
  Scene driven = scene;
  driven.blocks[0].kind = BlockKind::Prescribed;
  driven.blocks[0].motion = {MotionKind::Displacement,
                             VectorOfTime([](double t) { return Vector3(0, t - 1, 0); })};
  simulation.change(driven);
  run(simulation, 50);
  REQUIRE((simulation.state().blocks[0].centroid - Vector3(1.5, 1, 0.5)).norm() < 1e-10);
  Scene held = scene;
  held.fixed_points = {{.block = 0, .point = {0.5, 0.5, 0.5}, .displacement = {}}};
  simulation.change(held);
  run(simulation, 50);
  REQUIRE((simulation.state().blocks[0].centroid - Vector3(1.5, 1, 0.5)).norm() < 1e-8);
}

TEST_CASE("a displacement given to a block that another motion moves counts from where it stands") {
  const auto along = [](double rate) {
    return VectorOfTime([rate](double t) { return Vector3(rate * t, 0, 0); });
  };
  for (const MotionKind kind :
       {MotionKind::Displacement, MotionKind::Velocity, MotionKind::Acceleration}) {
    CAPTURE(static_cast<int>(kind));
    Scene scene;
    scene.add_rigid(cube_at(0, 0), kStone);
    scene.blocks[0].kind = BlockKind::Prescribed;
    scene.blocks[0].motion = {kind, along(0.5)};
    scene.add_rigid(cube_at(9, 0), kStone);
    Simulation simulation(scene, {.time_step = 1e-2});
    run(simulation, 10);
    const double reached = simulation.state().blocks[0].centroid.x();
    CHECK(reached > 0.5);
    Scene stopped = scene, other = scene;
    stopped.blocks[0].motion = {MotionKind::Displacement, along(0.0)};
    other.blocks[0].motion = {MotionKind::Displacement, along(2.0)};
    simulation.change(stopped);
    run(simulation, 1);
    CHECK(simulation.state().blocks[0].centroid.x() == reached);
    simulation.change(other);
    run(simulation, 10);
    CHECK_THAT(simulation.state().blocks[0].centroid.x(), WithinAbs(reached + 0.2, 1e-12));
    simulation.change(other);  // goes on
    run(simulation, 10);
    CHECK_THAT(simulation.state().blocks[0].centroid.x(), WithinAbs(reached + 0.4, 1e-12));
  }
}

TEST_CASE("what is laid is bonded, and goes on from a checkpoint to the bit") {
  Scene without = stack();
  without.joint.tension = 1e5;
  without.joint.cohesion = 1e5;
  without.initial_overlap = InitialOverlap::Zero;
  without.blocks[2].shape = std::make_shared<const geometry::Shape>(
      geometry::make_box({0, 0, 0.99}, {1, 1, 2}));  // 10 mm into the lower one
  Scene with = without;
  without.blocks[2].kind = BlockKind::Absent;
  with.fixed_points = {{.block = 1, .point = {0.5, 0.5, 0.5}, .displacement = {}}};
  with.gravity = VectorOfTime(Vector3(0, 0, kG));
  Simulation simulation(without, {});
  run(simulation, 3);
  simulation.change(with);
  const std::string middle = saved(simulation);
  run(simulation, 20);
  REQUIRE(std::abs(simulation.state().blocks[2].centroid.z() - 1.495) <
          1e-6);  // hangs by its joint
  std::istringstream in(middle);
  Simulation other(with, {}, in);
  run(other, 20);
  for (std::size_t b = 0; b < 3; ++b) {
    const BlockState &one = simulation.state().blocks[b], &two = other.state().blocks[b];
    REQUIRE(one.centroid == two.centroid);
    REQUIRE(one.velocity == two.velocity);
  }
  REQUIRE(simulation.state().energy.work == other.state().energy.work);
}

TEST_CASE("a fixed block that is set free has the joints it was laid with, if none has moved") {
  // Pulled up by 9.81 m/s2: either the ground came up to it in the meantime, or stood.
  for (const bool stands : {true, false}) {
    Scene scene{.joint = {.friction_angle = 0.6, .cohesion = 1e5, .tension = 1e5}};
    scene.gravity = VectorOfTime(Vector3(0, 0, kG));
    scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
    scene.add_rigid(cube_at(0, 0), kStone);
    scene.blocks[1].kind = BlockKind::Fixed;
    if (!stands) {
      scene.blocks[0].placement.translation.z() = -0.1;
      scene.blocks[0].kind = BlockKind::Prescribed;
      scene.blocks[0].motion = {MotionKind::Velocity, VectorOfTime(Vector3(0, 0, 1))};
    }
    Simulation simulation(scene, {.time_step = 1e-2});
    run(simulation, 10);
    scene.blocks[0].kind = BlockKind::Fixed;
    scene.blocks[1].kind = BlockKind::Rigid;
    simulation.change(scene);
    run(simulation, 10);
    const double rise = simulation.state().blocks[1].centroid.z() - 0.5;
    REQUIRE(std::abs(rise - (stands ? 0.0 : 0.5 * kG * 0.01)) < 1e-9);
  }
}

TEST_CASE("a loaded block stays where it is when its springs become stiffer, or rigid") {
  // 2 kN along the ground stretch the springs by 2 mm; the weight squeezes them.
  const Joint soft{.friction_angle = 0.7, .normal_stiffness = 1e7, .shear_stiffness = 1e6};
  Joint bonded = soft, stiffer = soft, harder = soft;
  bonded.tension = bonded.cohesion = 1e5;
  stiffer.normal_stiffness = stiffer.shear_stiffness = 2e8;
  harder.normal_stiffness = 1e9;
  for (const Joint& before : {soft, bonded}) {
    for (const Joint& after : {Joint{.friction_angle = 0.7}, stiffer, harder}) {
      for (const Analysis analysis : {Analysis::Static, Analysis::Settle, Analysis::Dynamic}) {
        Scene scene{.joint = before};
        scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
        scene.add_rigid(cube_at(0, 0), {.density = 1000});
        scene.point_loads = {
            {.block = 1, .point = {0.5, 0.5, 0}, .force = VectorOfTime(Vector3(2000, 0, 0))}};
        Simulation simulation(scene, {.time_step = 1e-3, .analysis = Analysis::Static});
        run(simulation, 60);
        const Vector3 stood = simulation.state().blocks[1].centroid;
        REQUIRE(std::abs(stood.x() - 0.502) < 1e-9);
        scene.joint = after;
        simulation.change(scene);
        StepOptions options = simulation.options();
        options.analysis = analysis;
        simulation.set_options(options);
        run(simulation, 10);
        REQUIRE((simulation.state().blocks[1].centroid - stood).norm() < 1e-9);
        REQUIRE(std::abs(force_on_ground(simulation) - 1000 * kG) < 1e-3);
        REQUIRE(simulation.state().energy.friction_loss > -1e-9);
      }
    }
  }
}

TEST_CASE(
    "a block that was held for a while has the joints it had before, also from a checkpoint") {
  // A cube lies on the ground, tied by a bond or not, and is fixed or prescribed without a motion;
  // another one flies, so that steps go on.
  for (const auto& [bonded, kind] :
       {std::pair(true, BlockKind::Fixed), std::pair(true, BlockKind::Prescribed),
        std::pair(false, BlockKind::Fixed)}) {
    Scene scene{.joint = {.friction_angle = 0.6, .cohesion = 1e5, .tension = 1e5}};
    if (!bonded) scene.joint = {.friction_angle = 0.6};
    scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
    scene.add_rigid(cube_at(0, 0), kStone);
    scene.add_rigid(cube_at(3, 20), kStone);
    Simulation simulation(scene, {.time_step = 1e-2});
    run(simulation, 3);
    scene.blocks[1].kind = kind;
    simulation.change(scene);
    run(simulation, 3);
    std::ostringstream out;
    simulation.save(out);
    std::istringstream in(out.str());
    Simulation other(scene, {.time_step = 1e-2}, in);
    scene.blocks[1].kind = BlockKind::Rigid;
    scene.gravity = VectorOfTime(Vector3(0, 0, kG));
    for (Simulation* freed : {&simulation, &other}) {
      freed->change(scene);
      run(*freed, 10);
      const double rise = freed->state().blocks[1].centroid.z() - 0.5;
      REQUIRE(std::abs(rise - (bonded ? 0.0 : 0.5 * kG * 0.01)) < 1e-9);
    }
  }
}

TEST_CASE("a joint whose bond has ended is no bond again after its block was held") {
  Scene scene{.joint = {.friction_angle = 0.6, .tension = 1e5}};
  scene.gravity = VectorOfTime(Vector3(Vector3::Zero()));
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(cube_at(0, 0), kStone);
  Simulation simulation(scene, {.time_step = 1e-2});
  run(simulation, 2);
  scene.joint.tension = 0.0;
  simulation.change(scene);
  run(simulation, 2);
  scene.blocks[1].kind = BlockKind::Fixed;
  simulation.change(scene);
  run(simulation, 2);
  scene.joint.tension = 1e5;
  scene.blocks[1].kind = BlockKind::Rigid;
  scene.gravity = VectorOfTime(Vector3(0, 0, kG));
  simulation.change(scene);
  run(simulation, 10);
  REQUIRE(std::abs(simulation.state().blocks[1].centroid.z() - 0.5 - 0.5 * kG * 0.01) < 1e-9);
}

TEST_CASE("a fixed block that a support has come into is not set free") {
  Scene scene{.joint = {.friction_angle = 0.6}};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(cube_at(0, 0), kStone);
  scene.blocks[0].kind = BlockKind::Prescribed;
  scene.blocks[0].motion = {MotionKind::Velocity, VectorOfTime(Vector3(0, 0, 0.5))};
  scene.blocks[1].kind = BlockKind::Fixed;
  Simulation simulation(scene, {.time_step = 1e-2});
  run(simulation, 10);
  const std::string before = saved(simulation);
  scene.blocks[1].kind = BlockKind::Rigid;
  REQUIRE_THROWS_AS(simulation.change(scene), InputError);
  REQUIRE((saved(simulation) == before));
}

TEST_CASE("the ledger closes where a held point is given a constant displacement") {
  const Material soft{.density = 1000, .young = 1e8, .poisson = 0.25};
  for (const ContactMethod method :
       {ContactMethod::AugmentedLagrangian, ContactMethod::Penalty, ContactMethod::Paper}) {
    for (const Analysis analysis : {Analysis::Static, Analysis::Dynamic}) {
      Scene scene{.joint = {.friction_angle = 0.6}};
      scene.gravity = VectorOfTime(Vector3(Vector3::Zero()));
      scene.add_block(cube_at(0, 0), soft);
      for (const double x : {0.0, 1.0}) {
        for (const double y : {0.0, 1.0}) {
          for (const double z : {0.0, 1.0}) {
            scene.fixed_points.push_back({.block = 0, .point = {x, y, z}, .displacement = {}});
          }
        }
      }
      const auto pull = [&](double way) {
        for (std::size_t i = 4; i < 8; ++i) {
          scene.fixed_points[i].displacement = VectorOfTime(Vector3(way, 0, 0));
        }
      };
      pull(1e-4);
      Simulation simulation(
          scene, {.time_step = 1e-2, .analysis = analysis, .method = method, .penalty = 1e9});
      run(simulation, 3);
      pull(3e-4);
      simulation.change(scene);
      run(simulation, 3);
      const EnergyLedger& energy = simulation.state().energy;
      CAPTURE(static_cast<int>(method), static_cast<int>(analysis), energy.work);
      REQUIRE(energy.strain > 3.0);  // of 5.4 J at rest
      REQUIRE(std::abs(energy.closure) < 1e-8 * energy.work);
    }
  }
}

TEST_CASE("a block that hangs by its joint falls once the joint has no strength any more") {
  Scene scene{.joint = {.friction_angle = 0.6, .cohesion = 1e5, .tension = 3e4}};
  scene.add_fixed(geometry::make_box({-5, -5, 1}, {5, 5, 2}));
  scene.add_rigid(cube_at(0, 0), kStone);
  Simulation simulation(scene, {.time_step = 5e-3});
  run(simulation, 20);
  REQUIRE(std::abs(simulation.state().blocks[1].centroid.z() - 0.5) < 1e-9);
  scene.joint = {.friction_angle = 0.6};
  simulation.change(scene);
  run(simulation, 20);
  REQUIRE(std::abs(simulation.state().blocks[1].centroid.z() - 0.5 + 0.5 * kG * 0.01) < 1e-9);
}

TEST_CASE("a joint without tension bears none of what it is given later, and keeps its cohesion") {
  // Pulled up, or along the ground so hard that the corner behind is unloaded.
  for (const bool up : {true, false}) {
    Scene scene{.joint = {.friction_angle = 0.5, .cohesion = 1e5, .tension = 1e5}};
    scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
    scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 0.2}), kStone);
    Simulation simulation(scene, {.time_step = 5e-3});
    run(simulation, 2);
    scene.joint = {.friction_angle = 0.5, .cohesion = 1e6};
    simulation.change(scene);
    run(simulation, 2);
    if (up) scene.joint.tension = 1e6;
    scene.gravity = VectorOfTime(up ? Vector3(0, 0, kG) : Vector3(20, 0, -kG));
    simulation.change(scene);
    run(simulation, 20);
    const Vector3 moved = simulation.state().blocks[1].centroid - Vector3(0.5, 0.5, 0.1);
    REQUIRE((moved - Vector3(0, 0, up ? 0.5 * kG * 0.01 : 0.0)).norm() < 1e-9);
  }
}

TEST_CASE(
    "a joint that begins to dilate lifts by the slip from then on, one that ends stays open") {
  const double slope = std::tan(0.1), friction = std::tan(0.5);
  for (const double dt : {2e-3, 5e-4}) {
    CAPTURE(dt);
    Scene scene = stack();
    scene.blocks.pop_back();
    scene.joint = {};
    scene.blocks[1].velocity = {2, 0, 0};
    Simulation simulation(scene, {.time_step = dt});
    run(simulation, static_cast<int>(0.2 / dt + 0.5));  // it slips by 0.4 m
    scene.joint = {.friction_angle = 0.5, .dilation_angle = 0.1};
    simulation.change(scene);
    const auto block = [&] { return simulation.state().blocks[1]; };
    run(simulation, 1);
    // One impulse onto the slope, with friction of tan(phi) times it.
    const double speed = 2.0 / (1.0 + slope * friction);
    CHECK_THAT(block().velocity.x(), WithinAbs(speed, 10 * dt));
    CHECK_THAT(block().velocity.z(), WithinAbs(slope * speed, 10 * dt * slope));
    run(simulation, static_cast<int>(0.5 / dt + 0.5));
    const double rise = block().centroid.z() - 0.5;
    CHECK_THAT(rise, WithinRel(slope * (block().centroid.x() - 0.9), 1e-2));
    scene.joint.dilation_angle = 0.0;
    simulation.change(scene);
    run(simulation, static_cast<int>(0.5 / dt + 0.5));
    CHECK(std::abs(block().velocity.norm()) < 1e-9);
    CHECK_THAT(block().centroid.z() - 0.5, WithinAbs(rise, 1e-9));
  }
}

TEST_CASE("blocks in balance stay where they are when the stiffness of their joints changes") {
  for (const double stiffness : {1e7, 1e9, 0.0}) {
    CAPTURE(stiffness);
    Scene scene = stack();
    scene.joint.normal_stiffness = scene.joint.shear_stiffness = 1e8;
    Simulation simulation(scene, {.analysis = Analysis::Static});
    run(simulation, 50);
    const double height = simulation.state().blocks[2].centroid.z();
    REQUIRE(height < 1.5 - 1e-4);  // 2000 g / 1e8 and twice that
    scene.joint.normal_stiffness = scene.joint.shear_stiffness = stiffness;
    simulation.change(scene);
    simulation.set_options({.time_step = 1e-3});
    for (int step = 0; step < 50; ++step) {
      run(simulation, 1);
      REQUIRE_THAT(simulation.state().blocks[2].centroid.z(), WithinAbs(height, 1e-9));
    }
  }
}

TEST_CASE("springs keep what shear has stored in them through a change of scene") {
  Scene scene{.joint = {.friction_angle = 0.7, .normal_stiffness = 1e8, .shear_stiffness = 1e7}};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 0.5}), kStone);
  for (const double along : {4.0, 9.0}) {  // it sticks; it slides
    scene.gravity = VectorOfTime(Vector3(along, 0, -kG));
    Simulation simulation(scene, {.time_step = 2e-3});
    run(simulation, 20);
    const EnergyLedger before = simulation.state().energy;
    simulation.change(scene);
    run(simulation, 20);
    const EnergyLedger& energy = simulation.state().energy;
    REQUIRE(energy.contact > 0.1);
    REQUIRE(energy.work == before.work);
    REQUIRE(std::abs(energy.closure) < 1e-6 * energy.contact);
  }
}

TEST_CASE(
    "an edge that a block stands on has its corners' share of the face when a stiffness is given "
    "later") {
  constexpr double kStiffness = 1e8;  // Pa/m
  Scene scene;
  scene.joint = {.friction_angle = 0.6};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(cube_at(0, 0), kStone);
  Simulation simulation(scene, {.time_step = 1e-3});
  run(simulation, 1);
  simulation.set_velocities(std::array{
      BlockVelocity{.block = 1, .velocity = {0.25, 0, 0.25}, .angular_velocity = {0, 0.5, 0}}});
  run(simulation, 50);
  scene.joint.normal_stiffness = scene.joint.shear_stiffness = kStiffness;
  simulation.change(scene);
  run(simulation, 1);
  int closed = 0;
  for (const Contact& contact : simulation.state().contacts) {
    if (contact.mode == ContactMode::Open) continue;
    ++closed;
    CHECK(contact.point.area == 0.0);
    CHECK(std::abs(contact.spring_area - 1.0 / 24.0) < 1e-4);
  }
  CHECK(closed == 2);
}

TEST_CASE("a change that can't be is refused and changes nothing") {
  Scene without = stack();
  without.blocks[2].kind = BlockKind::Absent;
  without.blocks[2].shape = std::make_shared<const geometry::Shape>(
      geometry::make_box({0, 0, 0.5}, {1, 1, 2}));  // within the lower cube
  Simulation simulation(without, {});
  run(simulation, 2);
  const std::string before = saved(simulation);
  Scene with = without;
  with.blocks[2].kind = BlockKind::Rigid;
  REQUIRE_THROWS_AS(simulation.change(with), InputError);
  Scene fewer = without;
  fewer.blocks.pop_back();
  REQUIRE_THROWS_AS(simulation.change(fewer), InputError);
  Scene other = without;
  other.blocks[1].shape = std::make_shared<const geometry::Shape>(cube_at(0.1, 0));
  REQUIRE_THROWS_AS(simulation.change(other), InputError);
  Scene moved = without;
  moved.blocks[1].placement.translation.x() = 0.1;
  REQUIRE_THROWS_AS(simulation.change(moved), InputError);
  REQUIRE((saved(simulation) == before));
}
