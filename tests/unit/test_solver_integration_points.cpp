/// Joints that act by area against closed forms of the whole area: stiffness in rocking and twist,
/// strength against twist, beds in one piece and in strips.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <vector>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;
using Eigen::Vector2d;
using Polygon = std::vector<Vector2d>;

namespace {

constexpr double kGravity = 9.81, kDensity = 2000.0;

/// Where a scene stands in the world.
struct Frame {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 origin = Vector3::Zero();
  bool rigid = true;

  Vector3 point(const Vector3& p) const { return origin + rotation * p; }
  geometry::Shape prism(const Polygon& base, double low, double high) const {
    geometry::Points places(3, base.size());
    for (std::size_t i = 0; i < base.size(); ++i) {
      places.col(static_cast<Eigen::Index>(i)) = point({base[i].x(), base[i].y(), low});
    }
    return geometry::make_prism(places, rotation * Vector3(0, 0, high - low));
  }
  Scene on_floor(const Joint& joint, const Vector3& gravity, const Polygon& base,
                 double height) const {
    Scene scene{.joint = joint, .gravity = Vector3(rotation * gravity)};
    scene.add_fixed(prism({{-5, -5}, {5, -5}, {5, 5}, {-5, 5}}, -1, 0));
    const Material rock{.density = kDensity, .young = 1e15, .poisson = 0.2};
    const geometry::Shape block = prism(base, 0, height);
    rigid ? scene.add_rigid(block, rock) : scene.add_block(block, rock);
    return scene;
  }
  /// Of the last block since the start, in the frame's axes, rad.
  Vector3 turn(const Simulation& simulation) const {
    const Eigen::AngleAxisd turned(Eigen::Quaterniond(simulation.state().blocks.back().rotation));
    return rotation.transpose() * (turned.angle() * turned.axis());
  }
};

std::vector<Frame> frames() {
  const Matrix3 turned =
      Eigen::AngleAxisd(1.1, Vector3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  return {{}, {.rigid = false}, {turned, {1234.5, -678.9, 42.0}}, {turned, {0, 0, 0}, false}};
}

Polygon rectangle(double x, double y) {
  return {{-x / 2, -y / 2}, {x / 2, -y / 2}, {x / 2, y / 2}, {-x / 2, y / 2}};
}

/// By triangles from the origin.
struct Moments {
  double area = 0.0;
  Vector2d first = Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  explicit Moments(const Polygon& polygon) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double part = 0.5 * (p.x() * q.y() - p.y() * q.x());
      area += part;
      first += part / 3.0 * (p + q);
      second +=
          part / 12.0 * (p * p.transpose() + q * q.transpose() + (p + q) * (p + q).transpose());
    }
  }
};

/// With its centroid in the origin.
Polygon centred(Polygon polygon) {
  const Moments moments(polygon);
  for (Vector2d& corner : polygon) corner -= moments.first / moments.area;
  return polygon;
}

/// In place of the floor, each as long under a block of 1 m.
void lay_strips(const Frame& frame, int strips, Scene& scene) {
  const Block block = scene.blocks.back();
  scene.blocks.clear();
  for (int i = 0; i < strips; ++i) {
    const double low = i == 0 ? -5 : -0.5 + 1.0 * i / strips;
    const double high = i == strips - 1 ? 5 : -0.5 + 1.0 * (i + 1) / strips;
    scene.add_fixed(frame.prism({{low, -5}, {high, -5}, {high, 5}, {low, 5}}, -1, 0));
  }
  scene.blocks.push_back(block);
}

StaticVerdict rest(Simulation& simulation) {
  StepOptions options = simulation.options();
  options.analysis = Analysis::Static;
  simulation.set_options(options);
  for (int i = 0; i < 500; ++i) {
    const StepReport report = simulation.advance();
    INFO(describe(report));
    REQUIRE(report.status == StepStatus::Converged);
    if (report.verdict != StaticVerdict::Seeking) return report.verdict;
  }
  FAIL("no verdict");
  return StaticVerdict::Seeking;
}

/// Mean distance of a rectangle's points from its centre, by its quarter.
double mean_radius(double x, double y) {
  const double a = x / 2, b = y / 2, d = std::hypot(a, b);
  return (2.0 * a * b * d + a * a * a * std::asinh(b / a) + b * b * b * std::asinh(a / b)) /
         (6.0 * a * b);
}

void advance_to(double time, Simulation& simulation) {
  while (simulation.state().time < time - 1e-9) {
    const StepReport report = simulation.advance();
    INFO(describe(report));
    REQUIRE(report.status == StepStatus::Converged);
  }
}

/// About the joint's normal, rad/s.
double spin(const Frame& frame, const Simulation& simulation) {
  const BlockState& block = simulation.state().blocks.back();
  return (frame.rotation.transpose() * (block.rotation * block.angular_velocity)).z();
}

}  // namespace

TEST_CASE("A bonded joint rocks and twists as its area does, whatever its shape") {
  constexpr double kNormal = 1e9, kShear = 4e8;
  const Vector3 moment(30.0, -20.0, 25.0);  // N m
  for (const Frame& frame : frames()) {
    for (const Polygon& base :
         {rectangle(0.6, 0.2), centred({{0, 0}, {1, 0}, {0.2, 0.7}}),
          centred({{0, 0}, {0.7, -0.2}, {0.9, 0.3}, {0.4, 0.8}, {-0.1, 0.5}})}) {
      CAPTURE(frame.rigid, frame.origin.x(), base.size());
      const Joint joint{.friction_angle = 0.5,
                        .cohesion = 1e9,
                        .tension = 1e9,
                        .normal_stiffness = kNormal,
                        .shear_stiffness = kShear};
      Scene scene = frame.on_floor(joint, {0, 0, 0}, base, 0.5);
      // Couples, at the height of the joint: no other moment.
      const auto couple = [&](const Vector3& axis, double size) {
        const Vector3 arm = axis.unitOrthogonal(), force = size / 0.1 * axis.cross(arm);
        for (const double side : {0.05, -0.05}) {
          scene.point_loads.push_back({1, frame.point(Vector3(0, 0, 0.25) + side * arm),
                                       Vector3(frame.rotation * (side > 0 ? force : -force))});
        }
      };
      for (int i = 0; i < 3; ++i) couple(Vector3::Unit(i), moment[i]);
      Simulation simulation(scene, {});
      REQUIRE(rest(simulation) == StaticVerdict::Rest);
      const Moments area(base);
      Eigen::Matrix2d rocking = kNormal * area.second;
      std::swap(rocking(0, 0), rocking(1, 1));
      rocking(0, 1) = rocking(1, 0) = -rocking(0, 1);
      const Vector2d rocks = rocking.inverse() * moment.head<2>();
      const double twists = moment.z() / (kShear * area.second.trace());
      const Vector3 exact(rocks.x(), rocks.y(), twists);
      CHECK((frame.turn(simulation) - exact).norm() < 1e-4 * exact.norm());
    }
  }
}

TEST_CASE("A pressed joint tilts as its area does, in one piece and in strips") {
  constexpr double kNormal = 1e7, kForce = 1000.0, kWidth = 0.8;
  const double weight = kDensity * kWidth * kGravity;
  const double exact = kForce / (kNormal * kWidth / 12.0 - weight / 2.0);  // e < 1/6 of the length
  for (const Frame& frame : frames()) {
    for (const int strips : {1, 2, 5}) {
      CAPTURE(frame.rigid, frame.origin.x(), strips);
      Scene scene = frame.on_floor(
          {.friction_angle = 0.7, .normal_stiffness = kNormal, .shear_stiffness = kNormal},
          {0, 0, -kGravity}, rectangle(1.0, kWidth), 1.0);
      lay_strips(frame, strips, scene);
      scene.point_loads.push_back(
          {strips, frame.point({0, 0, 1}), Vector3(frame.rotation * Vector3(kForce, 0, 0))});
      Simulation simulation(scene, {});
      REQUIRE(rest(simulation) == StaticVerdict::Rest);
      CHECK_THAT(frame.turn(simulation).y(), WithinRel(exact, 1e-3));
    }
  }
}

TEST_CASE("A joint without tension opens as its area does, to the mesh of its points") {
  constexpr double kNormal = 1e10, kWeight = kDensity * kGravity;
  struct Tilt {
    double eccentricity, one, five;  // m; what one face and five strips may be off
  };
  for (const Tilt& tilt : {Tilt{1.0 / 6.0, 1e-3, 1e-3}, Tilt{0.2, 0.04, 0.006},
                           Tilt{0.25, 0.10, 0.006}, Tilt{0.3, 0.06, 0.006}}) {
    const double pressed = 3.0 * (0.5 - tilt.eccentricity);
    const double exact = 2.0 * kWeight / (kNormal * pressed * pressed);
    for (const int strips : {1, 5}) {
      CAPTURE(tilt.eccentricity, strips);
      const Frame frame;
      Scene scene = frame.on_floor(
          {.friction_angle = 0.7, .normal_stiffness = kNormal, .shear_stiffness = kNormal},
          {0, 0, -kGravity}, rectangle(1.0, 1.0), 1.0);
      lay_strips(frame, strips, scene);
      scene.point_loads = {{strips, {0, 0, 1}, Vector3(tilt.eccentricity * kWeight, 0, 0)}};
      Simulation simulation(scene, {});
      REQUIRE(rest(simulation) == StaticVerdict::Rest);
      CHECK_THAT(frame.turn(simulation).y(), WithinRel(exact, strips > 1 ? tilt.five : tilt.one));
    }
  }
}

TEST_CASE("What slips all over in twist bears the cohesion of its area, or its even friction") {
  constexpr double kHeight = 0.1, kSpin = 6.0, kStrength = 2000.0;  // Pa
  const double pressure = kDensity * kGravity * kHeight;
  for (const Frame& frame : frames()) {
    for (const double length : {1.0, 2.0, 4.0}) {
      for (const double stiffness : {0.0, 1e9}) {
        for (const bool rubs : {false, true}) {
          if (rubs && stiffness == 0.0) continue;  // pressed at the corners
          CAPTURE(frame.rigid, frame.origin.x(), length, stiffness, rubs);
          const Joint joint{.friction_angle = rubs ? std::atan(kStrength / pressure) : 0.0,
                            .cohesion = rubs ? 0.0 : kStrength,
                            .residual_cohesion = rubs ? 0.0 : kStrength,
                            .normal_stiffness = stiffness,
                            .shear_stiffness = stiffness};
          const Vector3 gravity(0, 0, -kGravity);
          Scene scene = frame.on_floor(joint, gravity, rectangle(length, 1.0), kHeight);
          Simulation simulation(scene, {.time_step = 1e-3});
          REQUIRE(rest(simulation) == StaticVerdict::Rest);
          simulation.set_options({.time_step = 1e-3});
          simulation.set_velocities(std::vector<BlockVelocity>{
              {.block = 1, .angular_velocity = frame.rotation * Vector3(0, 0, kSpin)}});
          advance_to(0.1, simulation);
          const double inertia = kDensity * kHeight * length * (length * length + 1.0) / 12.0;
          const double slowed = 0.1 * kStrength * length * mean_radius(length, 1.0) / inertia;
          // Friction where the springs press: 6 % less at 4 : 1.
          const double allowed = !rubs ? 0.01 : length > 3.0 ? 0.06 : length > 1.0 ? 0.03 : 0.01;
          CHECK_THAT(kSpin - spin(frame, simulation), WithinRel(slowed, allowed));
        }
      }
    }
  }
}

TEST_CASE("A soft bed without tension lets a block topple, in one piece and in strips") {
  constexpr double kDip = 40.0 * std::numbers::pi / 180.0;
  for (const int strips : {1, 2, 5, 20}) {
    for (const double stiffness : {1e7, 1e9}) {
      CAPTURE(strips, stiffness);
      Scene scene{.joint = {.friction_angle = 41.0 * std::numbers::pi / 180.0,
                            .normal_stiffness = stiffness,
                            .shear_stiffness = stiffness},
                  .gravity = Vector3(10.0 * std::sin(kDip), 0, -10.0 * std::cos(kDip))};
      for (int i = 0; i < strips; ++i) {
        const double low = i == 0 ? -40 : -4 + 8.0 * i / strips;
        const double high = i == strips - 1 ? 40 : -4 + 8.0 * (i + 1) / strips;
        scene.add_fixed(geometry::make_box({low, -20, -5}, {high, 20, 0}));
      }
      scene.add_rigid(geometry::make_box({-4, -4, 0}, {4, 4, 8}), {.density = kDensity});
      Simulation simulation(scene, {});
      CHECK(rest(simulation) == (stiffness < 1e8 ? StaticVerdict::Mechanism : StaticVerdict::Rest));
    }
  }
}

TEST_CASE("A law given later acts on the whole area that is laid") {
  Joint joint{.cohesion = 1e5};  // judged by the whole joint: corners alone
  Scene scene = Frame().on_floor(joint, {0, 0, -kGravity}, rectangle(1, 1), 0.5);
  for (const double share : {0.98, 1.02}) {
    CAPTURE(share);
    scene.joint = joint;
    Simulation simulation(scene, {.time_step = 1e-3});
    advance_to(0.01, simulation);
    REQUIRE(simulation.state().contacts.size() == 4);
    scene.joint.softening_slip = 1.0;
    scene.point_loads = {{1, {0, 0, 0}, Vector3(share * 1e5, 0, 0)}};
    simulation.change(scene);
    advance_to(0.2, simulation);
    CHECK(simulation.state().contacts.size() == 8);
    CHECK((simulation.state().blocks[1].centroid.x() > 1e-3) == (share > 1.0));
    scene.point_loads.clear();
  }
}
