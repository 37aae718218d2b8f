/// The projection on the cone, and the proximal Newton method on problems with known answers.

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver/contact_problem.hpp>
#include <sstream>

#include "solver/src/iteration/cone.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/sanitized.hpp"

using namespace quoin::solver;
using namespace quoin::tests;

namespace {

Vector3 random_vector(Random& random) {
  return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

/// Unit mass, a cube of side 1, on four corners; H of corners by its translations and turns.
ContactProblem::Block cube(const Vector3& force) {
  ContactProblem::Block block;
  block.length = 1.0;
  block.matrix = Eigen::MatrixXd::Identity(6, 6);
  block.matrix.bottomRightCorner(3, 3) /= 6.0;
  block.force = Eigen::VectorXd::Zero(6);
  block.force.head(3) = force;
  block.guess = Eigen::VectorXd::Zero(6);
  return block;
}

/// Rows (normal z, x, y) of a cube's point at `arm` from its centre.
Eigen::MatrixXd rows(const Vector3& arm, double sign) {
  Matrix3 frame;
  frame << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  Matrix3 cross;
  cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
  Eigen::MatrixXd result(3, 6);
  result << sign * frame, -sign * frame * cross;
  return result;
}

/// A tower of `count` cubes under `force` each; slot -1 is the ground.
ContactProblem tower(int count, const Vector3& force, double friction) {
  ContactProblem problem;
  for (int i = 0; i < count; ++i) {
    problem.blocks.push_back(cube(force));
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        ContactProblem::Contact contact;
        contact.a = i - 1;
        contact.b = i;
        contact.friction = friction;
        contact.offset.setZero();
        contact.force.setZero();
        if (i > 0) contact.rows_a = rows({x, y, 0.5}, -1.0);
        contact.rows_b = rows({x, y, -0.5}, 1.0);
        problem.contacts.push_back(contact);
      }
    }
  }
  return problem;
}

Vector3 sum_of(const ContactSolution& solution, std::size_t first, std::size_t count) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = first; i < first + count; ++i) sum += solution.forces[i];
  return sum;
}

/// Of all blocks, the angular one about the origin; sizes: sums of those of each block.
struct Momenta {
  Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
  double linear_size = 0.0, angular_size = 0.0;
};

/// Of rigid blocks that started unturned.
Momenta momenta(const Scene& scene, const State& state) {
  Momenta sum;
  for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
    const auto body = quoin::geometry::mass_properties(scene.blocks[b].body());
    const double density = scene.blocks[b].material.density;
    const Matrix3 inertia =
        density * (body.second_moment.trace() * Matrix3::Identity() - body.second_moment);
    const BlockState& block = state.blocks[b];
    const Vector3 linear = density * body.volume * block.velocity;
    const Vector3 angular =
        block.centroid.cross(linear) + block.rotation * (inertia * block.angular_velocity);
    sum.linear += linear;
    sum.angular += angular;
    sum.linear_size += linear.norm();
    sum.angular_size += angular.norm();
  }
  return sum;
}

/// At 2 Hz from now on; amplitude by gravity.
void shake(const Vector3& amplitude, Block& block) {
  block.kind = BlockKind::Prescribed;
  block.motion = {MotionKind::Acceleration, VectorOfTime([=](double time) -> Vector3 {
                    return 9.81 * std::cos(4.0 * std::numbers::pi * time) * amplitude;
                  })};
}

/// In running bond, shaken across by half of gravity.
Scene shaken_wall(int columns, int rows) {
  Scene scene{.joint = {.friction_angle = std::atan(0.7)}};
  const double length = 0.4 * columns;
  scene.add_fixed(quoin::geometry::make_box({-2, -2, -1}, {length + 2, 2, 0}));
  shake({0, 0.5, 0}, scene.blocks[0]);
  for (int row = 0; row < rows; ++row) {
    const double shift = row % 2 == 0 ? 0.0 : 0.2;
    for (int i = 0; i < columns + row % 2; ++i) {
      const double low = std::max(0.0, 0.4 * i - shift),
                   high = std::min(length, 0.4 * (i + 1) - shift);
      scene.add_rigid(quoin::geometry::make_box({low, 0, 0.2 * row}, {high, 0.2, 0.2 * (row + 1)}),
                      {.density = 2000});
    }
  }
  return scene;
}

/// Shaken in its plane, of deformable bricks; `young`: Pa.
Scene deformable_in_plane(int columns, int rows, double young) {
  Scene scene = shaken_wall(columns, rows);
  scene.joint.friction_angle = 35.0 * std::numbers::pi / 180.0;
  shake({0.5, 0, 0}, scene.blocks[0]);
  for (Block& block : scene.blocks) {
    if (block.kind != BlockKind::Rigid) continue;
    block.kind = BlockKind::Deformable;
    block.material = {.density = 2000, .young = young, .poisson = 0.2};
  }
  return scene;
}

/// Contacts without cohesion push, and friction is within its limit: forces to 1e-6 of the largest.
void check_law(const Simulation& simulation, double friction) {
  double largest = 0.0, tension = 0.0, beyond = 0.0;
  for (const Contact& contact : simulation.state().contacts) {
    largest = std::max(largest, contact.normal_force);
    tension = std::max(tension, -contact.normal_force);
    beyond = std::max(beyond, contact.shear_force.norm() - friction * contact.normal_force);
  }
  CHECK(tension <= 1e-6 * largest);
  CHECK(beyond <= 1e-6 * largest);
}

/// Of energy less the work of supports above its least so far, by the largest kinetic energy.
double growth(
    Simulation& simulation, int steps,
    const std::function<void(const StepReport&)>& look = [](const StepReport&) {}) {
  double least = 0.0, most = 0.0, kinetic = 0.0;
  for (int step = 0; step < steps; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    look(report);
    const EnergyLedger& energy = simulation.state().energy;
    const double own = energy.mechanical() - energy.work;
    least = std::min(least, own);
    most = std::max(most, own - least);
    kinetic = std::max(kinetic, energy.kinetic);
  }
  return most / kinetic;
}

}  // namespace

/// Largest difference between the derivative and that of the values.
double derivative_error(const Admissible& forces, const Vector3& z, double smoothing) {
  constexpr double h = 1e-6;
  const SmoothProjection smooth = project_smoothly(forces, z, smoothing);
  double worst = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 forward = project_smoothly(forces, z + h * Vector3::Unit(axis), smoothing).value;
    const Vector3 back = project_smoothly(forces, z - h * Vector3::Unit(axis), smoothing).value;
    const Vector3 slope = (forward - back) / (2 * h);
    worst = std::max(worst, (slope - smooth.derivative.col(axis)).norm());
  }
  return worst;
}

TEST_CASE("the projection is the nearest point of the cone, the smoothed one comes to it") {
  Random random(environment_number("QUOIN_SEED", 1));
  for (int i = 0; i < 1000; ++i) {
    const Vector3 z = random_vector(random), p = project_on({}, z), left = p - z;
    REQUIRE(p[0] >= p.tail<2>().norm() - 1e-15);
    REQUIRE(left[0] >= left.tail<2>().norm() - 1e-15);  // the cone is its own dual
    REQUIRE(std::abs(p.dot(left)) <= 1e-15);
    REQUIRE((project_smoothly({}, z, 1e-12).value - p).norm() <= 1e-11);
    REQUIRE(derivative_error({}, z, 0.1) <= 1e-8);
  }
}

TEST_CASE("what joints and bonds bear: a range of normal forces, and its limit of shear") {
  using Shear = Admissible::Shear;
  Random random(environment_number("QUOIN_SEED", 1));
  for (int i = 0; i < 1000; ++i) {
    const Vector3 z = random_vector(random);
    for (const bool pulls : {false, true}) {
      CHECK(project_on({Shear::All, pulls}, z).tail<2>() == z.tail<2>());
      for (const double friction : {0.0, 0.7}) {
        for (const double cohesion : {0.0, 0.3}) {
          const Admissible forces{Shear::Disc, pulls, friction, cohesion};
          const Vector3 p = project_on(forces, z);
          REQUIRE(p[0] == (pulls ? z[0] : std::max(z[0], 0.0)));
          const double limit = std::max(friction * p[0] + cohesion, 0.0);
          REQUIRE(std::abs(p.tail<2>().norm() - std::min(limit, z.tail<2>().norm())) <= 1e-15);
          REQUIRE((project_smoothly(forces, z, 1e-12).value - p).norm() <= 1e-11);
          REQUIRE(derivative_error(forces, z, 0.1) <= 1e-8);
        }
      }
    }
  }
}

/// A slab on a slope of 45 degrees, or under a ceiling, with this joint; its motion in 0.1 s, m.
double motion_of_bonded_slab(const Joint& joint, bool hangs) {
  Scene scene{.joint = joint};
  const double g = 9.81, slope = hangs ? std::numbers::pi : 0.25 * std::numbers::pi;
  scene.gravity = VectorOfTime(Vector3(g * std::sin(slope), 0, -g * std::cos(slope)));
  scene.add_fixed(quoin::geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.add_rigid(quoin::geometry::make_box({0, 0, 0}, {1, 1, 0.25}), {.density = 4000});
  Simulation simulation(scene,
                        {.time_step = 5e-3, .contact_iteration = ContactIteration::ProximalNewton});
  const Vector3 start = simulation.state().blocks[1].centroid;
  for (int step = 0; step < 20; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    REQUIRE(report.proximal_newton_attempts == 1);
  }
  return (simulation.state().blocks[1].centroid - start).norm();
}

TEST_CASE("bonds and cohesion hold up to their strength where contacts yield") {
  constexpr double kWeight = 9810.0, kTime = 0.1;
  const double push = kWeight * std::sqrt(0.5), friction = std::tan(0.5);
  const double left = push * (1.0 - friction);  // for cohesion to bear
  const auto slide = [&](double force) { return 0.5 * force / 1000.0 * kTime * kTime; };
  const auto tension = [](double of) { return Joint{.friction_angle = 0.5, .tension = of}; };
  CHECK(motion_of_bonded_slab(tension(1.01 * kWeight), true) <= 1e-9);  // forces to 1e-6: 5e-8
  CHECK(std::abs(motion_of_bonded_slab(tension(0.99 * kWeight), true) - slide(kWeight)) <= 1e-9);
  for (const double share : {0.5, 1.01}) {
    CAPTURE(share);
    const bool holds = share > 1.0;
    // Brittle: all or nothing. What is residual, or goes with a slip of 1 km, bears its share.
    const Joint brittle{.friction_angle = 0.5, .cohesion = share * left};
    const Joint residual{
        .friction_angle = 0.5, .cohesion = 0.1 * left, .residual_cohesion = share * left};
    const Joint softening{.friction_angle = 0.5, .cohesion = share * left, .softening_slip = 1e3};
    const double slid = slide(holds ? 0.0 : left), rest = slide(holds ? 0.0 : (1.0 - share) * left);
    CHECK(std::abs(motion_of_bonded_slab(brittle, false) - slid) <= 1e-9);
    CHECK(std::abs(motion_of_bonded_slab(residual, false) - rest) <= 1e-9);
    CHECK(std::abs(motion_of_bonded_slab(softening, false) - rest) <= 1e-6 * slide(left));
  }
}

TEST_CASE("all corners of a joint that is pulled apart slowly bear the same until it breaks") {
  const auto iteration = GENERATE(ContactIteration::Automatic, ContactIteration::ProximalNewton);
  const double dt = GENERATE(1e-2, 1e-3);
  const bool turned = GENERATE(false, true);
  CAPTURE(iteration, dt, turned);
  constexpr double kYoung = 1e9, kSpeed = 1e-3, kTension = 5e4;
  Matrix3 turn = Matrix3::Identity();
  Vector3 origin = Vector3::Zero();
  if (turned) {
    turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    origin = {1000, -2000, 500};
  }
  Scene scene{.joint = {.friction_angle = 0.5, .cohesion = 1e6, .tension = kTension}};
  scene.gravity = Vector3(Vector3::Zero());
  scene.add_fixed(quoin::geometry::make_box({-1, -1, -0.5}, {2, 2, 0}));
  const auto cube = scene.add_block(quoin::geometry::make_box({0, 0, 0}, {1, 1, 1}),
                                    {.density = 2000, .young = kYoung});
  const auto plate = scene.add_fixed(quoin::geometry::make_box({-1, -1, 1}, {2, 2, 1.5}));
  for (Block& block : scene.blocks) block.placement = {.linear = turn, .translation = origin};
  Block& pulled = scene.blocks[static_cast<std::size_t>(plate)];
  pulled.kind = BlockKind::Prescribed;
  pulled.motion = {MotionKind::Velocity, Vector3(kSpeed * turn.col(2))};
  REQUIRE(scene.blocks[static_cast<std::size_t>(cube)].kind == BlockKind::Deformable);
  Simulation simulation(scene, {.time_step = dt, .contact_iteration = iteration});
  double borne = 0.0;  // N, by the whole joint
  for (bool broken = false; !broken;) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    double sum = 0.0, least = 0.0, most = -1e300;
    for (const Contact& c : simulation.state().contacts) {
      broken = broken || c.failed > 0.0;
      if (c.point.key.a != 0) continue;  // of the lower one of the two joints
      least = std::min(least, c.normal_force);
      most = std::max(most, c.normal_force);
      sum -= c.normal_force;
    }
    if (broken) break;
    CHECK(most - least <= 1e-6 * sum);  // a third of the mean where sweeps share it out
    CHECK(sum > borne);
    borne = sum;
  }
  const double step = kYoung * kSpeed * dt;                    // N that a step adds
  CHECK(borne > kTension - 1.01 * step - 2000 * kSpeed / dt);  // its first one sets it in motion
  CHECK(borne <= kTension * (1.0 + 1e-9));
}

TEST_CASE("a box on a slope sticks below the angle of friction and slides above it") {
  constexpr double friction = 0.5, normal = 1.0;
  for (const double pull : {0.3, 0.45, 0.6, 2.0}) {
    ContactProblem problem = tower(1, {pull, 0.0, -normal}, friction);
    const double friction_force = std::min(pull, friction * normal);
    problem.blocks[0].force[4] = -0.5 * friction_force;  // what friction turns: nothing tips
    const ContactSolution solution = solve(problem, ContactIteration::ProximalNewton, 1e-10);
    REQUIRE(solution.converged);
    const Vector3 sum = sum_of(solution, 0, 4);
    REQUIRE(std::abs(sum[0] - normal) <= 1e-6);
    REQUIRE(std::abs(sum[1] + friction_force) <= 1e-6);
    REQUIRE(std::abs(sum[2]) <= 1e-6);
    REQUIRE(contact_error(problem, solution.forces).gap <= 1e-6);
  }
}

TEST_CASE("a tower bears its weight, each joint what is above it") {
  constexpr int count = 5;
  ContactProblem problem = tower(count, {0, 0, -1}, 0.5);
  const ContactSolution solution = solve(problem, ContactIteration::ProximalNewton, 1e-10);
  REQUIRE(solution.converged);
  REQUIRE(solution.factorizations <= 20);
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(4 * i);
    REQUIRE(std::abs(sum_of(solution, at, 4)[0] - (count - i)) <= 1e-6);
  }
  REQUIRE(contact_error(problem, solution.forces).gap <= 1e-6);
}

TEST_CASE("both iterations find the same forces where they are unique") {
  Random random(environment_number("QUOIN_SEED", 1));
  int slides = 0;
  for (int i = 0; i < 100; ++i) {
    // A point under the centre of each cube: one contact, no redundancy.
    ContactProblem problem = tower(1, random_vector(random) - Vector3(0, 0, 1.1), 0.4);
    problem.contacts.resize(1);
    problem.contacts[0].rows_b = rows({0, 0, -0.5}, 1.0);
    const ContactSolution soft = solve(problem, ContactIteration::ProximalNewton, 1e-12);
    const ContactSolution hard = solve(problem, ContactIteration::OpenClose, 1e-12);
    REQUIRE(soft.converged);
    REQUIRE(hard.converged);
    REQUIRE((soft.forces[0] - hard.forces[0]).norm() <= 1e-7);
    slides += hard.forces[0].tail<2>().norm() >= (0.4 - 1e-9) * hard.forces[0][0] ? 1 : 0;
  }
  REQUIRE(slides > 0);
  REQUIRE(slides < 100);
}

TEST_CASE(
    "a block that sticks on a slope does not creep, one that slides accelerates as it should") {
  for (const bool sticks : {true, false}) {
    constexpr double degree = 3.14159265358979323846 / 180.0, slope = 20.0 * degree, g = 9.81;
    const double friction_angle = (sticks ? 20.1 : 15.0) * degree;
    Scene scene{.joint = {.friction_angle = friction_angle}};
    scene.gravity = VectorOfTime(Vector3(g * std::sin(slope), 0, -g * std::cos(slope)));
    scene.add_fixed(quoin::geometry::make_box({-5, -5, -1}, {50, 5, 0}));
    scene.add_rigid(quoin::geometry::make_box({0, 0, 0}, {1, 1, 1}), {.density = 2600});
    Simulation simulation(
        scene, {.time_step = 5e-3, .contact_iteration = ContactIteration::ProximalNewton});
    const auto place = [&] { return simulation.state().blocks[1].centroid.x(); };
    const double start = place();
    double settled = 0.0;  // where the first steps have found its forces
    for (int step = 0; step < 200; ++step) {
      if (step == 20) settled = place();
      const StepReport report = simulation.advance();
      REQUIRE(report.status == StepStatus::Converged);
      REQUIRE(report.proximal_newton_attempts == 1);
    }
    const double pull = g * (std::sin(slope) - std::cos(slope) * std::tan(friction_angle));
    if (sticks) {
      REQUIRE(std::abs(settled - start) <= 1e-5);
      REQUIRE(std::abs(place() - settled) <= 1e-12);
    } else {
      REQUIRE(std::abs(place() - start - 0.5 * pull) <= 1e-3 * 0.5 * pull);
    }
  }
}

TEST_CASE("what sticks does not creep on a base that is shaken below the limit") {
  Scene scene{.joint = {.friction_angle = std::atan(0.5)}};
  scene.add_fixed(quoin::geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  shake({0.2, 0, 0}, scene.blocks[0]);
  constexpr int count = 3;
  for (int i = 0; i < count; ++i) {
    scene.add_rigid(quoin::geometry::make_box({0, 0, 0.5 * i}, {1, 1, 0.5 * (i + 1)}),
                    {.density = 2600});
  }
  for (const auto iteration : {ContactIteration::ProximalNewton, ContactIteration::Automatic}) {
    Simulation simulation(scene, {.time_step = 5e-3, .contact_iteration = iteration});
    const auto stretch = [&](int block) -> Vector3 {
      const auto& blocks = simulation.state().blocks;
      const auto at = static_cast<std::size_t>(block);
      return blocks[at].centroid - blocks[at - 1].centroid;
    };
    std::array<Vector3, count> start;
    for (int i = 0; i < count; ++i) start[static_cast<std::size_t>(i)] = stretch(i + 1);
    for (int step = 0; step < 1000; ++step) {
      REQUIRE(simulation.advance().status == StepStatus::Converged);
    }
    for (int i = 0; i < count; ++i) {
      CAPTURE(name(iteration), i);
      CHECK((stretch(i + 1) - start[static_cast<std::size_t>(i)]).norm() <= 1e-6 * 0.5);
    }
  }
}

TEST_CASE("a wall that sticks goes with its base, also where the shaking turns round") {
  Scene scene = shaken_wall(5, 5);
  shake({0, 0.2, 0}, scene.blocks[0]);
  Simulation simulation(scene, {.time_step = 5e-3});
  const auto start = simulation.state().blocks;
  constexpr int kSteps = 210;  // it turns round at 0.25, 0.5, 0.75 and 1 s
  int solves = 0;
  const auto look = [&](const StepReport& report) {
    CHECK(report.proximal_newton_attempts == 0);
    solves += report.linear_solves;
  };
  CHECK(growth(simulation, kSteps, look) <= 1e-8);
  CHECK(solves <= 13 * kSteps);  // 14.4 a step where all contact forces are exact
  const auto& end = simulation.state().blocks;
  const Vector3 base = end[0].centroid - start[0].centroid;
  for (std::size_t b = 1; b < end.size(); ++b) {
    CHECK((end[b].centroid - start[b].centroid - base).norm() <= 1e-10);
  }
}

TEST_CASE("a wall shaken across by half of gravity rocks and comes down, and no step is lost") {
  const Scene scene = shaken_wall(3, 6);
  Simulation simulation(scene, {.time_step = 5e-3});
  int crowded = 0;
  for (int step = 0; step < 100; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    crowded += report.proximal_newton_attempts > 0 ? 1 : 0;
    CHECK(report.largest_overlap <= 5e-5 * 0.2);  // without the projection: 4e-4 of a block
  }
  CHECK(crowded > 0);
}

TEST_CASE("walls with mortar that rock come down without a step lost, and gain no energy") {
  const double phi = 35.0 * std::numbers::pi / 180.0;
  const std::array joints{
      Joint{.friction_angle = phi, .cohesion = 2e4, .tension = 1e4},
      Joint{.friction_angle = phi, .cohesion = 1e4, .tension = 5e3, .residual_cohesion = 3e3},
      Joint{.friction_angle = phi, .tension = 5e3},
      Joint{.friction_angle = phi, .cohesion = 1e4, .tension = 5e3, .softening_slip = 1e-3},
  };
  for (const Joint& joint : joints) {
    CAPTURE(joint.cohesion, joint.residual_cohesion, joint.tension, joint.softening_slip);
    Scene scene = shaken_wall(3, 6);
    scene.joint = joint;
    shake({0.3, 1.0, 0}, scene.blocks[0]);
    Simulation simulation(scene, {.time_step = 5e-3});
    int crowded = 0;
    const auto look = [&](const StepReport& report) {
      crowded += report.proximal_newton_attempts > 0 ? 1 : 0;
      CHECK(report.largest_overlap <= 5e-6 * 0.2);  // 7e-6 m where edges that stick may turn
    };
    CHECK(growth(simulation, unless_sanitized(120, 60), look) <= 1e-7);
    CHECK(crowded > 0);
  }
}

TEST_CASE("walls with mortar that are hit are solved") {
  const double phi = 35.0 * std::numbers::pi / 180.0;
  const std::array joints{
      Joint{.friction_angle = phi, .cohesion = 2e4, .dilation_angle = 0.1, .dilation_slip = 0.02},
      Joint{.friction_angle = phi,
            .cohesion = 2e4,
            .tension = 1e4,
            .residual_cohesion = 5e3,
            .softening_slip = 0.01},
  };
  for (const Joint& joint : joints) {
    for (const double dt : {1e-2, 2.5e-3}) {
      CAPTURE(joint.dilation_angle, dt);
      Scene scene = shaken_wall(3, 4);
      scene.joint = joint;
      scene.blocks[0].kind = BlockKind::Fixed;
      scene.blocks[0].motion = {};
      scene.add_rigid(quoin::geometry::make_box({0.3, -0.61, 0.25}, {0.7, -0.21, 0.65}),
                      {.density = 8000});
      scene.blocks.back().velocity = {0, 5, 0};
      Simulation simulation(scene, {.time_step = dt});
      while (simulation.state().time < (quoin::tests::kSanitized ? 0.04 : 0.1)) {
        REQUIRE(simulation.advance().status == StepStatus::Converged);
      }
    }
  }
}

/// 30 drums on a base that is pulled away. `young`: Pa; 0: they are rigid.
Scene pulled_tower(double young) {
  Scene scene;
  scene.add_fixed(quoin::geometry::make_box({-5, -5, -1}, {9, 5, 0}));
  scene.add_fixed(quoin::geometry::make_box({0, 0, 0}, {1, 1, 0.5}));
  scene.blocks.back().kind = BlockKind::Prescribed;
  scene.blocks.back().motion = {MotionKind::Acceleration, VectorOfTime([](double) -> Vector3 {
                                  return {8, 0, 0};
                                })};
  for (int i = 1; i <= 30; ++i) {
    const auto drum = quoin::geometry::make_box({0, 0, 0.5 * i}, {1, 1, 0.5 * (i + 1)});
    if (young > 0.0) {
      scene.add_block(drum, {.density = 2000, .young = young, .poisson = 0.2});
    } else {
      scene.add_rigid(drum, {.density = 2000});
    }
  }
  return scene;
}

TEST_CASE(
    "linearisations that go to and fro are soon given up: a tower whose base is pulled away") {
  // 946 and 690; where they are not, 3218 and 1400.
  const auto [degrees, limit] = GENERATE(std::pair{30.14, 1500}, std::pair{29.0, 1000});
  CAPTURE(degrees);
  Scene scene = pulled_tower(0.0);
  scene.joint.friction_angle = degrees / 180.0 * std::numbers::pi;
  Simulation simulation(scene, {.time_step = 5e-3});
  int most = 0;
  for (int step = 0; step < unless_sanitized(400, 120); ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    most = std::max(most, report.linear_solves);
  }
  CHECK(most < limit);
}

TEST_CASE("a deformable tower whose base is pulled away gains no energy") {
  Scene scene = pulled_tower(1e8);
  scene.joint.friction_angle = std::numbers::pi / 6.0;
  Simulation simulation(scene, {.time_step = 1e-3});
  CHECK(growth(simulation, unless_sanitized(130, 40)) <=
        1e-7);  // 1.3e-4 where sub-steps that gain are not halved
}

TEST_CASE("a wall that falls back gains no energy, nor do gaps that are mended later") {
  for (const auto& [columns, rows, degrees] :
       {std::array{3, 5, 35}, std::array{2, 4, 38}, std::array{2, 6, 33}}) {
    CAPTURE(columns, rows, degrees);
    Scene scene = shaken_wall(columns, rows);
    scene.joint.friction_angle = degrees * std::numbers::pi / 180.0;
    Simulation simulation(scene, {.time_step = 5e-3});
    int crowded = 0;
    for (int step = 0; step < 80; ++step) {
      const StepReport report = simulation.advance();
      REQUIRE(report.status == StepStatus::Converged);
      CHECK(report.largest_overlap <= 1e-6 * 0.35);  // a millionth of the smallest brick
      check_law(simulation, std::tan(scene.joint.friction_angle));
      crowded += report.proximal_newton_attempts > 0 ? 1 : 0;
      for (const StepFlag& flag : report.flags) CHECK(flag.kind != FlagKind::EnergyGrowth);
    }
    CHECK(crowded > 0);
  }
}

TEST_CASE("a deformable wall shaken in its plane is not lifted by gaps that it sank by") {
  Simulation simulation(deformable_in_plane(3, 3, 1e10),
                        {.time_step = 5e-3, .contact_iteration = ContactIteration::ProximalNewton});
  CHECK(growth(simulation, unless_sanitized(100, 40)) <=
        1e-7);  // 6.9e-6 where overlaps alone were kept
}

TEST_CASE("deformable walls that slid in their planes are caught without a gain") {
  Simulation narrow(deformable_in_plane(3, 8, 1e13), {.time_step = 0.01});
  Simulation wide(deformable_in_plane(6, 6, 1e13), {.time_step = 0.02});
  CHECK(growth(narrow, unless_sanitized(60, 20)) <=
        1e-8);  // 1.3e-4 and 1.8e-4 where contacts yield about the forces
  CHECK(growth(wide, unless_sanitized(30, 10)) <= 1e-8);  // that they began with
}

TEST_CASE("contacts that yield have the same bits on any number of threads") {
  const Scene scene = shaken_wall(22, 24);
  StepOptions options{.time_step = 5e-3, .contact_iteration = ContactIteration::ProximalNewton};
  Simulation one(scene, options);
  options.threads = 3;
  Simulation three(scene, options);
  for (int step = 0; step < 2; ++step) {
    REQUIRE(one.advance().status == StepStatus::Converged);
    REQUIRE(three.advance().status == StepStatus::Converged);
    bool same = true;
    for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
      const BlockState &x = one.state().blocks[b], &y = three.state().blocks[b];
      same = same && x.centroid == y.centroid && x.rotation.coeffs() == y.rotation.coeffs() &&
             x.velocity == y.velocity && x.angular_velocity == y.angular_velocity;
    }
    CHECK(same);
  }
}

TEST_CASE("a corner that comes down beside one that rests is held in the same step") {
  Scene scene{.joint = {.friction_angle = std::numbers::pi / 6.0}};
  scene.add_fixed(quoin::geometry::make_box({-3, -3, -0.5}, {3, 3, 0}));
  const auto toss = [&](const Vector3& low, const Vector3& high, double fall, const Vector3& spin) {
    scene.add_rigid(quoin::geometry::make_box(low, high), {.density = 2000});
    scene.blocks.back().velocity = {0, 0, -fall};
    scene.blocks.back().angular_velocity = spin;
  };
  toss({-0.236, -0.164, 0.191}, {0.329, 0.346, 0.809}, 1.82, {2.422, -4.01, 1.986});
  toss({-0.206, -0.203, 0.966}, {0.23, 0.313, 1.534}, 0.947, {-2.71, -0.246, 2.21});
  Simulation simulation(scene,
                        {.time_step = 5e-3, .contact_iteration = ContactIteration::ProximalNewton});
  for (int step = 0; step < 160; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    CHECK(report.largest_overlap <= 1e-6);  // else 1.6e-3 in one step
  }
}

TEST_CASE("rocks that fall into a bin overlap by no more than a millionth, or what is asked for") {
  const double tolerance = GENERATE(1e-12, 1e-10, 1e-8, 1e-6, 1e-4);
  CAPTURE(tolerance);
  Random random(environment_number("QUOIN_SEED", 3));
  Scene scene{.joint = {.friction_angle = 35.0 * std::numbers::pi / 180.0}};
  scene.add_fixed(quoin::geometry::make_box({-2, -2, -1}, {2, 2, 0}));
  scene.add_fixed(quoin::geometry::make_box({-2, -2, 0}, {-0.5, 2, 3}));
  scene.add_fixed(quoin::geometry::make_box({0.5, -2, 0}, {2, 2, 3}));
  scene.add_fixed(quoin::geometry::make_box({-0.5, -2, 0}, {0.5, -0.5, 3}));
  scene.add_fixed(quoin::geometry::make_box({-0.5, 0.5, 0}, {0.5, 2, 3}));
  constexpr double size = 0.3;
  for (int i = 0; i < 27; ++i) {
    const Vector3 middle(0.33 * (i % 3 - 1), 0.33 * (i / 3 % 3 - 1), 0.2 + 0.35 * (i / 9));
    quoin::geometry::Points corners(3, 12);
    for (auto corner : corners.colwise()) {
      corner = middle + 0.5 * size * random_vector(random).normalized();
    }
    scene.add_rigid(quoin::geometry::make_hull(corners).polyhedron, {.density = 2400});
  }
  Simulation simulation(scene, {.time_step = 5e-3, .tolerance = tolerance});
  double largest = 0.0;
  for (int step = 0; step < 120; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    largest = std::max(largest, report.largest_overlap);
  }
  // With crossed edges as they were found: 1e-4 m; at 1e4 times any tolerance: 2 mm at 1e-4, and a
  // step lost at 1e-6.
  // At 1e-12 4e-8 to 7e-8 m while turned contacts were held to 1e-6 of a block at any tolerance.
  CHECK(largest <= (tolerance < 1e-11 ? 1e-7 : std::max(1e-6, tolerance)) * size);
}

/// A beam that lies on a ridge by its lower edge, a little askew, and spins, rad/s.
Scene beam_on_ridge(double friction_angle, double spin) {
  const auto prism = [](double half_length, double yaw, double pitch) {
    const Matrix3 turn =
        (Eigen::AngleAxisd(yaw, Vector3::UnitZ()) * Eigen::AngleAxisd(-pitch, Vector3::UnitY()) *
         Eigen::AngleAxisd(0.25 * std::numbers::pi, Vector3::UnitX()))
            .toRotationMatrix();
    const Vector3 half(half_length, 0.2, 0.2);
    return quoin::geometry::Points(turn * quoin::geometry::make_box(-half, half).vertices());
  };
  const auto hull = [](const quoin::geometry::Points& corners) {
    return quoin::geometry::make_hull(corners).polyhedron;
  };
  Scene scene{.joint = {.friction_angle = friction_angle}};
  scene.add_fixed(hull(prism(2.0, 0.0, 0.0)));
  const double height = 0.4 * std::numbers::sqrt2;
  scene.add_rigid(hull(prism(1.0, 0.015, 0.003).colwise() + Vector3(0, 0, height)),
                  {.density = 2000});
  scene.blocks[1].angular_velocity = {0, 0, spin};
  return scene;
}

TEST_CASE("an edge that slides and turns on one that it was nearly along is held as it ends") {
  const Scene scene = beam_on_ridge(0.09, -2);
  for (const ContactIteration iteration :
       {ContactIteration::ProximalNewton, ContactIteration::OpenClose}) {
    Simulation simulation(scene, {.time_step = 0.01, .contact_iteration = iteration});
    for (int step = 0; step < 12; ++step) {
      const StepReport report = simulation.advance();
      REQUIRE(report.status == StepStatus::Converged);
      CHECK(report.largest_overlap <= 2e-6);  // a millionth of the beam; else 2e-4
    }
  }
}

TEST_CASE("an edge that is held as it ends slips by what it slides") {
  Scene scene = beam_on_ridge(0.3, -2);
  scene.blocks[1].velocity = {1, 0, 0};
  Simulation simulation(scene,
                        {.time_step = 0.01, .contact_iteration = ContactIteration::OpenClose});
  for (int step = 0; step < 2; ++step) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    double slip = 0.0;
    for (const Contact& contact : simulation.state().contacts) {
      if (contact.mode == ContactMode::Open) continue;
      slip = std::max(slip, contact.slip);
      CHECK(contact.mode == ContactMode::Slip);
      const double limit =
          std::tan(0.3) * contact.normal_force;  // normal force of the turned normal
      CHECK(contact.shear_force.norm() == Approx(limit).epsilon(0.03));
    }
    CHECK(slip == Approx(0.01 * (step + 1)).epsilon(0.05));
  }
}

TEST_CASE("two swarms that meet keep momentum and angular momentum") {
  Random random(2);
  Scene scene{.joint = {.friction_angle = std::numbers::pi / 6.0}};
  scene.gravity = VectorOfTime(Vector3(0, 0, 0));
  for (int i = 0; i < 16; ++i) {
    const int side = i / 8;
    const Vector3 middle(i % 2 + 3.0 * side, i / 2 % 2 + 0.2 * side, i / 4 % 2 + 0.3 * side);
    const Vector3 half(random.uniform(0.2, 0.35), random.uniform(0.2, 0.35),
                       random.uniform(0.2, 0.35));
    scene.add_rigid(quoin::geometry::make_box(middle - half, middle + half), {.density = 2000});
    scene.blocks.back().velocity = {2.0 - 4.0 * side, 0, 0};
    scene.blocks.back().angular_velocity = random_vector(random);
  }
  Simulation simulation(scene, {.time_step = 5e-3});
  int closed = 0;
  Momenta before = momenta(scene, simulation.state());
  for (int step = 0; step < 300; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    closed += report.closed_count;
    const Momenta now = momenta(scene, simulation.state());
    CHECK((now.linear - before.linear).norm() <= 1e-10 * now.linear_size);
    CHECK((now.angular - before.angular).norm() <= 1e-10 * now.angular_size);
    before = now;
  }
  CHECK(closed > 0);
}

TEST_CASE("a row of blocks that touch and is hit goes on with one velocity") {
  constexpr int kBlocks = 100;
  constexpr double kHammer = 100.0;  // of a block's mass
  Scene scene{.joint = {.friction_angle = 0.0}};
  scene.gravity = VectorOfTime(Vector3(0, 0, 0));
  for (int i = 0; i < kBlocks; ++i) {
    scene.add_rigid(quoin::geometry::make_box({1.0 * i, 0, 0}, {1.0 * (i + 1), 1, 0.6}),
                    {.density = 2000});
  }
  scene.add_rigid(quoin::geometry::make_box({-1.3, 0, 0}, {-0.3, 1, 0.6}),
                  {.density = 2000 * kHammer});
  scene.blocks.back().velocity = Vector3(3, 0, 0);
  Simulation simulation(scene, {.time_step = 2e-3});
  int yielded = 0;
  for (int step = 0; step < 60; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    yielded += report.proximal_newton_attempts;
  }
  CHECK(yielded > 0);
  constexpr double kExact = 3.0 * kHammer / (kHammer + kBlocks);
  for (const BlockState& block : simulation.state().blocks) {
    CHECK(std::abs(block.velocity.x() - kExact) <= 1e-3 * kExact);  // were up to half of it off
  }
}

TEST_CASE("an attempt that yields takes no more iterations than it may") {
  Scene scene{.joint = {.friction_angle = 0.5}};
  scene.add_fixed(quoin::geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  for (int i = 0; i < 3; ++i) {
    scene.add_rigid(quoin::geometry::make_box({0.1 * i, 0, 1.0 * i}, {1 + 0.1 * i, 1, 1.0 + i}),
                    {.density = 2600});
  }
  StepOptions options{.time_step = 1e-2,
                      .contact_iteration = ContactIteration::ProximalNewton,
                      .max_iterations = 2,
                      .smallest_time_step = 1e-2};
  const StepReport cut_short = Simulation(scene, options).advance();
  REQUIRE(cut_short.status == StepStatus::NotConverged);
  REQUIRE(cut_short.proximal_newton_attempts == 1);
  REQUIRE(cut_short.iterations == 2);
  options.max_iterations = 1000;
  const StepReport whole = Simulation(scene, options).advance();
  REQUIRE(whole.status == StepStatus::Converged);
  REQUIRE(whole.iterations > 2);
}

TEST_CASE("two blocks in free fall feel nothing") {
  ContactProblem problem = tower(2, {0, 0, -1}, 0.5);
  for (ContactProblem::Contact& contact : problem.contacts) {
    contact.offset[0] = contact.a < 0 ? 10.0 : 1e-3;
  }
  const ContactSolution solution = solve(problem, ContactIteration::ProximalNewton, 1e-10);
  REQUIRE(solution.converged);
  REQUIRE(solution.factorizations == 0);
  for (const Vector3& force : solution.forces) REQUIRE(force.norm() == 0.0);
}

TEST_CASE("a contact problem is read back to the bit") {
  Random random(environment_number("QUOIN_SEED", 1));
  ContactProblem problem = tower(3, random_vector(random), random.uniform(0, 1));
  for (ContactProblem::Contact& contact : problem.contacts) contact.offset = random_vector(random);
  std::stringstream text, again;
  write(text, problem);
  const ContactProblem copy = read_contact_problem(text);
  write(again, copy);
  REQUIRE(text.str() == again.str());
  REQUIRE(copy.contacts.back().rows_a == problem.contacts.back().rows_a);
}

TEST_CASE("a contact problem that is cut short or wrong says where") {
  std::ostringstream text;
  write(text, tower(2, {0, 0, -1}, 0.5));
  const auto message = [](const std::string& given) {
    std::istringstream in(given);
    try {
      read_contact_problem(in);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  REQUIRE(message(text.str()).empty());
  REQUIRE(message("fclib") == "contact problem: the first line must be 'quoin contact problem 1'");
  REQUIRE(message(text.str().substr(0, text.str().size() - 20)).find("contact 7: ") !=
          std::string::npos);
  std::string wrong = text.str();
  wrong.replace(wrong.find("\nf "), 3, "\nf x");
  REQUIRE(message(wrong).find("block 0: 'x0' is no finite number") != std::string::npos);
}

TEST_CASE("a contact problem that cannot be is refused, not solved") {
  const auto message = [](auto&& spoil, double tolerance = 1e-10) {
    ContactProblem problem = tower(2, {0, 0, -1}, 0.5);
    spoil(problem);
    try {
      solve(problem, ContactIteration::Automatic, tolerance);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const double no_number = std::nan("");
  const auto nothing = [](ContactProblem&) {};
  CHECK(message(nothing).empty());
  CHECK(message(nothing, no_number) == "contact problem: tolerance nan must lie in (0, 0.01)");
  for (const auto& [row, column] : {std::pair(0, 2), std::pair(2, 0)}) {
    CHECK(message([r = row, c = column](ContactProblem& p) { p.blocks[1].matrix(r, c) = 0.1; }) ==
          "contact problem: block 1: its matrix must be symmetric");
  }
  CHECK(message([](ContactProblem& p) { p.blocks[1].matrix(0, 2) = 1e-14; }).empty());
  CHECK_THROWS_AS(contact_error(tower(1, {0, 0, -1}, 0.5),
                                {{no_number, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}}),
                  InputError);
  CHECK(message([&](ContactProblem& p) { p.contacts[1].friction = no_number; }) ==
        "contact problem: contact 1: friction nan must be finite and not negative");
  CHECK(message([&](ContactProblem& p) { p.contacts[1].b = 7; }) ==
        "contact problem: contact 1: block 7 does not exist (the problem has 2)");
  CHECK(message([&](ContactProblem& p) { p.contacts[1].a = -2; }) ==
        "contact problem: contact 1: block -2 does not exist (the problem has 2)");
  CHECK(message([&](ContactProblem& p) { p.contacts[1].a = p.contacts[1].b = -1; }) ==
        "contact problem: contact 1: it must have a block");
  CHECK(message([&](ContactProblem& p) { p.contacts[1].offset[2] = no_number; }) ==
        "contact problem: contact 1: its offset or force is not finite");
  CHECK(message([&](ContactProblem& p) { p.contacts[1].rows_b.resize(3, 12); }) ==
        "contact problem: contact 1: its rows of block 0 must be 3, with a column for each of its "
        "unknowns");
  CHECK(message([&](ContactProblem& p) { p.blocks[1].matrix(0, 0) = -1.0; }) ==
        "contact problem: block 1: its matrix must be positive definite");
  CHECK(message([&](ContactProblem& p) { p.blocks[1].force.resize(5); }) ==
        "contact problem: block 1: its force has 5 numbers, 6 or 12 are expected");
  CHECK(message([&](ContactProblem& p) { p.blocks[1].length = 0.0; }) ==
        "contact problem: block 1: length 0 must be finite and greater than 0");
  const ContactProblem good = tower(2, {0, 0, -1}, 0.5);
  CHECK_THROWS_WITH(contact_error(good, {}), "contact problem: 0 forces are given for 8 contacts");
  CHECK(solve(ContactProblem(), ContactIteration::Automatic, 1e-10).converged);
}
