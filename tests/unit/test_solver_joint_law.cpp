/// Joints by what contacts say of themselves: which have failed, which are bonded, whose law holds.
/// Closed forms of strength, stiffness and dilation are cases of tools/scenes/validation.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <span>
#include <vector>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr double kGravity = 9.81;
constexpr double kDensity = 2500.0;
constexpr double kDegree = std::numbers::pi / 180.0;

/// Where a scene stands in the world.
struct Frame {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 origin = Vector3::Zero();
  bool rigid = true;

  geometry::Shape box(const Vector3& low, const Vector3& high) const {
    geometry::Shape shape = geometry::make_box(low, high);
    geometry::Points places = (rotation * shape.vertices()).colwise() + origin;
    shape.set_vertices(places);
    return shape;
  }
  Vector3 point(const Vector3& p) const { return origin + rotation * p; }
  Scene scene(const Vector3& gravity = {0, 0, -kGravity}) const {
    Scene scene;
    scene.gravity = Vector3(rotation * gravity);
    return scene;
  }
  void add(Scene& scene, const Vector3& low, const Vector3& high, double young = 5e9) const {
    const Material rock{.density = kDensity, .young = young, .poisson = 0.2};
    rigid ? scene.add_rigid(box(low, high), rock) : scene.add_block(box(low, high), rock);
  }
  /// Of a block's centroid since the start, in the frame's axes.
  Vector3 moved(const Simulation& simulation, int block) const {
    const auto b = static_cast<std::size_t>(block);
    const geometry::Points start = simulation.scene().blocks[b].body().vertices();
    const geometry::Points now = simulation.vertices(static_cast<int>(b));
    return rotation.transpose() * (now.rowwise().mean() - start.rowwise().mean());
  }
};

std::vector<Frame> frames() {
  const Matrix3 turned =
      Eigen::AngleAxisd(1.1, Vector3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  std::vector<Frame> all;
  for (const bool rigid : {true, false}) {
    all.push_back({.rigid = rigid});
    all.push_back({.rotation = turned, .rigid = rigid});
    all.push_back({.rotation = turned, .origin = {1234.5, -678.9, 42.0}, .rigid = rigid});
  }
  return all;
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const StepReport report = simulation.advance();
    INFO(describe(report));
    REQUIRE(report.status == StepStatus::Converged);
  }
}

/// Two bricks side by side and a third one laid on both, without weight: blocks 0, 1 and 2.
Scene joined_bricks(const Frame& frame, const Joint& joint) {
  Scene scene = frame.scene(Vector3::Zero());
  scene.joint = joint;
  frame.add(scene, {0, 0, 0}, {1, 0.6, 0.4});
  frame.add(scene, {1, 0, 0}, {2, 0.6, 0.4});
  frame.add(scene, {0.5, 0, 0.4}, {1.5, 0.6, 0.8});
  return scene;
}

bool any_failed(const Simulation& simulation, int a, int b) {
  return std::ranges::any_of(simulation.state().contacts, [&](const Contact& c) {
    return c.point.key.a == a && c.point.key.b == b && c.failed;
  });
}

/// Brittle, with restitution and without.
std::vector<Joint> brittle(double restitution) {
  const double peak = 20.0 * kDegree;
  return {{.friction_angle = peak, .cohesion = 1e4, .restitution = restitution},
          {.friction_angle = peak,
           .restitution = restitution,
           .residual_friction_angle = 12.0 * kDegree}};
}

}  // namespace

TEST_CASE("A rebound breaks the weaker one of two joints in its way, and spares the other") {
  for (const Frame& frame : frames()) {
    if (!frame.rigid) continue;
    for (const int glued : {0, 1}) {
      CAPTURE(glued);
      Scene scene = joined_bricks(frame, brittle(0.5).front());
      Joint glue = scene.joint;
      glue.cohesion = glue.tension = 1e9;
      scene.blocks[2].material.joint_group = 1;
      scene.blocks[static_cast<std::size_t>(glued)].material.joint_group = 2;
      scene.pair_joints = {{1, 2, glue}};
      scene.blocks[1].velocity = frame.rotation * Vector3(-1, 0, 0);
      Simulation simulation(scene, {.time_step = 2e-3});
      run(simulation, 1);
      CHECK_FALSE(any_failed(simulation, glued, 2));
      CHECK(any_failed(simulation, 1 - glued, 2));
    }
  }
}

/// Cubes of 1 m, bonded, that turn as one body without weight.
Scene spinning(std::span<const Vector3> corners) {
  const Vector3 spin(1.0, 4.0, 0.5);  // rad/s
  Vector3 middle = Vector3::Zero();
  for (const Vector3& corner : corners) middle += corner / static_cast<double>(corners.size());
  Scene scene{.joint = {.friction_angle = 30 * kDegree, .cohesion = 1e6, .tension = 1e6},
              .gravity = Vector3(0, 0, 0)};
  for (const Vector3& corner : corners) {
    scene.add_rigid(geometry::make_box(corner, corner + Vector3(1, 1, 1)), {.density = 1000});
    scene.blocks.back().velocity = spin.cross(corner - middle);
    scene.blocks.back().angular_velocity = spin;
  }
  return scene;
}

TEST_CASE(
    "What is bonded and turns without weight stays whole, also where edges meet beside bonds") {
  const std::array angle{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0)};
  std::vector<Vector3> cube;
  for (int i = 0; i < 8; ++i) cube.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  const auto iteration = GENERATE(ContactIteration::Automatic, ContactIteration::ProximalNewton);
  // Contacts that yield leave gaps of up to a millionth.
  const double strip = iteration == ContactIteration::Automatic ? 1e-9 : 1e-6;  // m2
  const auto check_whole = [=](const Scene& scene, int bonds, double dt) {
    CAPTURE(static_cast<int>(iteration), scene.blocks.size(), dt);
    Simulation simulation(scene, {.time_step = dt, .contact_iteration = iteration});
    double largest = 0.0;  // N
    while (simulation.state().time < 0.42) {
      REQUIRE(simulation.advance().status == StepStatus::Converged);
      int bonded = 0;
      for (const Contact& contact : simulation.state().contacts) {
        largest = std::max(largest, std::abs(contact.normal_force));
        bonded += contact.bonded ? 1 : 0;
        // Two blocks of the angle, and pairs across the cube, share an edge or a corner at most.
        const bool of_faces =
            (scene.blocks[static_cast<std::size_t>(contact.point.key.a)].body().centre() -
             scene.blocks[static_cast<std::size_t>(contact.point.key.b)].body().centre())
                .norm() < 1.1;
        CHECK((of_faces || contact.point.area < strip));
      }
      REQUIRE(bonded == bonds);
    }
    CHECK(largest < 5e4);  // m w^2 r of a block is 1.5e4
  };
  for (const double dt : {0.0038, 0.004, 0.0045, 0.005}) check_whole(spinning(angle), 8, dt);
  for (const double dt : {0.0048, 0.005}) check_whole(spinning(cube), 48, dt);
}

TEST_CASE("the joint of a pair of blocks goes before that of their groups") {
  for (const Frame& frame : frames()) {
    const double tilt = 20.0 * kDegree;
    Scene scene = frame.scene({kGravity * std::sin(tilt), 0, -kGravity * std::cos(tilt)});
    scene.joint.friction_angle = 40.0 * kDegree;
    scene.pair_joints = {{.group_a = 0, .group_b = 0, .joint = {.friction_angle = 30.0 * kDegree}}};
    scene.add_fixed(frame.box({-5, -5, -1}, {5, 5, 0}));
    frame.add(scene, {0, 0, 0}, {1, 1, 1});
    frame.add(scene, {2, 0, 0}, {3, 1, 1});
    scene.block_joints = {{.a = 0, .b = 2, .joint = {.friction_angle = 10.0 * kDegree}}};
    Simulation simulation(scene, {.time_step = 0.01});
    for (int step = 0; step < 10; ++step) {
      REQUIRE(simulation.advance().status == StepStatus::Converged);
    }
    const double slides =
        0.5 * kGravity * (std::sin(tilt) - std::cos(tilt) * std::tan(10.0 * kDegree)) * 0.01;
    CHECK_THAT(frame.moved(simulation, 1).x(), WithinAbs(0.0, 1e-4));
    CHECK_THAT(frame.moved(simulation, 2).x(), WithinAbs(slides, 1e-2 * slides));
    scene.block_joints = {{.a = 2, .b = 0, .joint = {}}};
    CHECK_THROWS_AS(Simulation(scene, {.time_step = 0.01}), InputError);
    scene.block_joints = {{.a = 0, .b = 2, .joint = {}}, {.a = 0, .b = 1, .joint = {}}};
    CHECK_THROWS_AS(Simulation(scene, {.time_step = 0.01}), InputError);
  }
}
