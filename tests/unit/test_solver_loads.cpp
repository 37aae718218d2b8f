/// Pressure of water, quiet faces and turning supports against closed forms.

#include <Eigen/Geometry>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <quoin/solver/equilibrium.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr double kGravity = 9.81;
constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};

bool near(double value, double wanted, double relative) {
  return std::abs(value - wanted) <= relative * std::abs(wanted);
}

struct Frame {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Vector3 origin = Vector3::Zero();
  bool rigid = true;
  Vector3 at(double x, double y, double z) const { return origin + turn * Vector3(x, y, z); }
  double height(const Vector3& place) const { return turn.col(2).dot(place - origin); }
};

std::vector<Frame> frames() {
  const Eigen::AngleAxisd turn(1.1, Vector3(1, 2, -0.5).normalized());
  return {{},
          {.rigid = false},
          {turn.matrix(), {4e4, -2e4, 1e4}, true},
          {turn.matrix(), {4e4, -2e4, 1e4}, false}};
}

geometry::Shape box(const Frame& frame, const Vector3& low, const Vector3& high) {
  geometry::Points points = frame.turn * geometry::make_box(low, high).vertices();
  points.colwise() += frame.origin;
  return geometry::make_hull(points).polyhedron;
}

/// A cube on a floor whose underside has this pressure.
Scene uplifted(const Frame& frame, std::function<double(const Vector3&, double)> pressure) {
  Scene scene;
  scene.gravity = Vector3(-kGravity * frame.turn.col(2));
  scene.joint.friction_angle = 0.5;
  scene.add_fixed(box(frame, {-3, -3, -1}, {3, 3, 0}));
  const geometry::Shape cube = box(frame, {0, 0, 0}, {1, 1, 1});
  frame.rigid ? scene.add_rigid(cube, kRock) : scene.add_block(cube, kRock);
  const auto field =
      std::make_shared<const PressureField>(PressureField{std::move(pressure), true});
  scene.pressure_loads.push_back(
      {.block = 1,
       .corners = {frame.at(0, 0, 0), frame.at(0, 1, 0), frame.at(1, 1, 0), frame.at(1, 0, 0)},
       .field = field});
  return scene;
}

/// Cubes of 1 m along x, glued by stiff springs.
Scene bar(int count, const Material& material) {
  Scene scene;
  scene.gravity = Vector3(Vector3::Zero());
  scene.joint = {
      .cohesion = 1e9, .tension = 1e9, .normal_stiffness = 1e12, .shear_stiffness = 1e12};
  for (int i = 0; i < count; ++i) {
    scene.add_block(geometry::make_box({double(i), 0, 0}, {i + 1.0, 1, 1}), material);
  }
  return scene;
}

/// The face of a box whose normal has this x.
int face_along(const geometry::Shape& shape, double x) {
  int face = 0;
  for (int f = 0; f < shape.topology().face_count(); ++f) {
    if (x * shape.face_normal(f).x() > 0.9) face = f;
  }
  return face;
}

}  // namespace

TEST_CASE("water under a block takes its pressure off the joint, with its moment") {
  for (const Frame& frame : frames()) {
    const Scene scene = uplifted(frame, [frame](const Vector3& place, double) {
      return 5000 + 3000 * frame.turn.col(0).dot(place - frame.origin);
    });
    const Vector6 load = block_loads(scene)[1];
    const Vector3 force = frame.turn.transpose() * load.head<3>();
    const Vector3 moment = frame.turn.transpose() * load.tail<3>();
    const double weight = 2500 * kGravity;
    CHECK(near(force.z(), 6500 - weight, 1e-9));
    CHECK(std::abs(force.x()) + std::abs(force.y()) < 1e-9 * weight);
    CHECK(near(moment.y(), -3000.0 / 12, 1e-6));  // 3000 times the second moment of the area
    Simulation simulation(scene, {.analysis = Analysis::Static});
    StepReport report;
    for (int i = 0; i < 200 && report.verdict != StaticVerdict::Rest; ++i) {
      report = simulation.advance();
      REQUIRE(report.status == StepStatus::Converged);
    }
    CHECK(report.verdict == StaticVerdict::Rest);
    double normal = 0.0;
    for (const Contact& contact : simulation.state().contacts) normal += contact.normal_force;
    CHECK(near(normal, weight - 6500, 1e-6));
  }
}

TEST_CASE("water that lifts a block does the work that its ledger shows") {
  for (const Frame& frame : frames()) {
    Simulation simulation(uplifted(frame, [](const Vector3&, double) { return 3e4; }),
                          {.time_step = 0.01});
    for (int i = 0; i < 20; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
    const double lift = 0.5 * (3e4 / 2500 - kGravity) * 0.04;
    const EnergyLedger& energy = simulation.state().energy;
    CHECK(near(energy.work, 3e4 * lift, 1e-3));
    CHECK(std::abs(energy.closure) < 1e-9 * energy.work);
  }
}

TEST_CASE("a turning support carries a block that sticks to it") {
  const double rate = 0.5;  // rad/s
  for (const Frame& frame : frames()) {
    Scene scene = uplifted(frame, [](const Vector3&, double) { return 0.0; });
    scene.blocks[0].kind = BlockKind::Prescribed;
    scene.blocks[0].motion.rotation = VectorOfTime(
        [=](double t) -> Vector3 { return rate * (1 - std::cos(t)) * frame.turn.col(1); });
    scene.blocks[0].motion.centre = frame.at(0.5, 0.5, -2);
    Simulation simulation(scene, {.time_step = 0.01});
    for (int i = 0; i < 100; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
    const double angle = rate * (1 - std::cos(simulation.state().time));
    const Eigen::AngleAxisd turned(angle, frame.turn.col(1));
    for (const int block : {0, 1}) {
      const Quaternion& now = simulation.state().blocks[static_cast<std::size_t>(block)].rotation;
      CHECK(now.angularDistance(Quaternion(turned)) < (block == 0 ? 1e-12 : 1e-4));
    }
    const Vector3 arm(frame.at(0.5, 0.5, 0.5) - frame.at(0.5, 0.5, -2));
    const Vector3 way = turned * arm - arm;
    CHECK((simulation.displacement(1, Vector3::Zero()) - way).norm() < 1e-3 * way.norm());
    CHECK(std::abs(simulation.state().energy.closure) <
          1e-6 * std::abs(simulation.state().energy.work));
  }
}

TEST_CASE("a wave leaves a bar by its quiet face") {
  constexpr int kCount = 30, kPulse = 5;
  const double young = 1e9, density = 2500, speed = std::sqrt(young / density);
  for (const bool quiet : {true, false}) {
    Scene scene = bar(kCount, {.density = density, .young = young});
    for (std::size_t i = 0; i < kPulse; ++i) scene.blocks[i].velocity = {0.01, 0, 0};
    if (quiet) {
      scene.quiet_faces.push_back({.block = kCount - 1,
                                   .face = face_along(*scene.blocks.back().shape, 1.0),
                                   .normal_impedance = density * speed,
                                   .shear_impedance = density * speed / std::sqrt(2.0)});
    }
    StepOptions options{.time_step = 0.25 / speed};
    options.scheme = TimeScheme::EnergyMomentum;
    Simulation simulation(scene, options);
    const double begun = simulation.state().energy.mechanical();
    while (simulation.state().time < 1.6 * kCount / speed) {
      REQUIRE(simulation.advance().status == StepStatus::Converged);
    }
    const EnergyLedger& energy = simulation.state().energy;
    CHECK(std::abs(energy.closure) < 1e-6 * begun);
    INFO(energy.mechanical() / begun);
    CHECK((quiet ? energy.mechanical() < 0.05 * begun : energy.mechanical() > 0.99 * begun));
  }
}

TEST_CASE("a wave comes in through a quiet face, and a free end shows twice its velocity") {
  constexpr int kCount = 30;
  const double young = 1e9, density = 2500, speed = std::sqrt(young / density), incoming = 0.01;
  Scene scene = bar(kCount, {.density = density, .young = young});
  const double rise = 10.0 / speed;  // s
  scene.quiet_faces = {{.block = 0,
                        .face = face_along(*scene.blocks.front().shape, -1.0),
                        .normal_impedance = density * speed,
                        .shear_impedance = density * speed,
                        .velocity = interpolate({0, rise}, {{0, 0, 0}, {incoming, 0, 0}})}};
  Simulation simulation(scene, {.time_step = 0.25 / speed});
  const auto advance_to = [&](double time) {
    while (simulation.state().time < time) {
      REQUIRE(simulation.advance().status == StepStatus::Converged);
    }
  };
  advance_to(0.8 * kCount / speed);
  CHECK_THAT(simulation.state().blocks[5].velocity.x(), WithinAbs(incoming, 0.03 * incoming));
  advance_to(1.6 * kCount / speed);
  CHECK_THAT(simulation.state().blocks[kCount - 1].velocity.x(),
             WithinAbs(2.0 * incoming, 0.03 * 2.0 * incoming));
}
