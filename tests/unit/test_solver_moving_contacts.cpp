/// The projection on the cone, the proximal Newton method on contact problems, and what it keeps in
/// scenes: the law of each contact, momentum, bits. Scenes with known answers are cases of
/// tools/scenes/cases.

#include <array>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver/contact_problem.hpp>
#include <sstream>

#include "scene_file/contact_problem_file.hpp"
#include "solver/src/iteration/cone.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/random.hpp"
#include "support/same_state.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace scene_file = quoin::scene_file;

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

TEST_CASE("contacts that yield have the same bits on any number of threads") {
  const Scene scene = shaken_wall(22, 24);
  StepOptions options{.time_step = 5e-3, .contact_iteration = ContactIteration::ProximalNewton};
  Simulation one(scene, options);
  options.threads = 3;
  Simulation three(scene, options);
  for (int step = 0; step < 2; ++step) {
    REQUIRE(one.advance().status == StepStatus::Converged);
    REQUIRE(three.advance().status == StepStatus::Converged);
    CHECK(same_bits(one.state(), three.state()));
  }
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
  for (ContactProblem::Contact& contact : problem.contacts)
    contact.offset[0] = contact.a < 0 ? 10.0 : 1e-3;
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
  scene_file::write(text, problem);
  const ContactProblem copy = scene_file::read_contact_problem(text);
  scene_file::write(again, copy);
  REQUIRE(text.str() == again.str());
  REQUIRE(copy.contacts.back().rows_a == problem.contacts.back().rows_a);
}

TEST_CASE("a contact problem that is cut short or wrong says where") {
  std::ostringstream text;
  scene_file::write(text, tower(2, {0, 0, -1}, 0.5));
  const auto refusal = [](const std::string& given) {
    std::istringstream in(given);
    return message([&] { scene_file::read_contact_problem(in); });
  };
  REQUIRE(refusal(text.str()).empty());
  REQUIRE(refusal("fclib") == "contact problem: the first line must be 'quoin contact problem 1'");
  REQUIRE(refusal(text.str().substr(0, text.str().size() - 20)).find("contact 7: ") !=
          std::string::npos);
  std::string wrong = text.str();
  wrong.replace(wrong.find("\nf "), 3, "\nf x");
  REQUIRE(refusal(wrong).find("block 0: 'x0' is no finite number") != std::string::npos);
}

TEST_CASE("a contact problem that cannot be is refused, not solved") {
  const auto refusal = [](auto&& spoil, double tolerance = 1e-10) {
    ContactProblem problem = tower(2, {0, 0, -1}, 0.5);
    spoil(problem);
    return message([&] { solve(problem, ContactIteration::Automatic, tolerance); });
  };
  const double no_number = std::nan("");
  const auto nothing = [](ContactProblem&) {};
  CHECK(refusal(nothing).empty());
  CHECK(refusal(nothing, no_number) == "contact problem: tolerance nan must lie in (0, 0.01)");
  for (const auto& [row, column] : {std::pair(0, 2), std::pair(2, 0)}) {
    CHECK(refusal([r = row, c = column](ContactProblem& p) { p.blocks[1].matrix(r, c) = 0.1; }) ==
          "contact problem: block 1: its matrix must be symmetric");
  }
  CHECK(refusal([](ContactProblem& p) { p.blocks[1].matrix(0, 2) = 1e-14; }).empty());
  CHECK_THROWS_AS(contact_error(tower(1, {0, 0, -1}, 0.5),
                                {{no_number, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}}),
                  InputError);
  CHECK(refusal([&](ContactProblem& p) { p.contacts[1].friction = no_number; }) ==
        "contact problem: contact 1: friction nan must be finite and not negative");
  CHECK(refusal([&](ContactProblem& p) { p.contacts[1].b = 7; }) ==
        "contact problem: contact 1: block 7 does not exist (the problem has 2)");
  CHECK(refusal([&](ContactProblem& p) { p.contacts[1].a = -2; }) ==
        "contact problem: contact 1: block -2 does not exist (the problem has 2)");
  CHECK(refusal([&](ContactProblem& p) { p.contacts[1].a = p.contacts[1].b = -1; }) ==
        "contact problem: contact 1: it must have a block");
  CHECK(refusal([&](ContactProblem& p) { p.contacts[1].offset[2] = no_number; }) ==
        "contact problem: contact 1: its offset or force is not finite");
  CHECK(refusal([&](ContactProblem& p) { p.contacts[1].rows_b.resize(3, 12); }) ==
        "contact problem: contact 1: its rows of block 0 must be 3, with a column for each of its "
        "unknowns");
  CHECK(refusal([&](ContactProblem& p) { p.blocks[1].matrix(0, 0) = -1.0; }) ==
        "contact problem: block 1: its matrix must be positive definite");
  CHECK(refusal([&](ContactProblem& p) { p.blocks[1].force.resize(5); }) ==
        "contact problem: block 1: its force has 5 numbers, 6 or 12 are expected");
  CHECK(refusal([&](ContactProblem& p) { p.blocks[1].length = 0.0; }) ==
        "contact problem: block 1: length 0 must be finite and greater than 0");
  const ContactProblem good = tower(2, {0, 0, -1}, 0.5);
  CHECK_THROWS_WITH(contact_error(good, {}), "contact problem: 0 forces are given for 8 contacts");
  CHECK(solve(ContactProblem(), ContactIteration::Automatic, 1e-10).converged);
}
