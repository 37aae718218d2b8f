/// Static analysis: equilibrium where there is one, "mechanism" where there is none, whatever the
/// time step and the frame; what follows starts in balance.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};
constexpr double kDegree = std::numbers::pi / 180.0;

/// Where a scene stands and of what its blocks are.
struct Frame {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Vector3 origin = Vector3::Zero();
  bool rigid = true;
};

Frame turned(double angle, const Vector3& origin, bool rigid) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3(1, 2, -0.5).normalized())), origin,
          rigid};
}

std::vector<Frame> frames() {
  return {{}, {.rigid = false}, turned(0.7, {3, -20, 5}, true), turned(2.1, {0, 1, 0}, false)};
}

class Builder {
 public:
  Builder(const Frame& frame, double friction_deg) : frame_(frame) {
    scene.gravity = Vector3(frame.turn * Vector3(0, 0, -9.81));
    scene.joint.friction_angle = friction_deg * kDegree;
  }
  void fix(const geometry::Shape& shape) { scene.add_fixed(placed(shape)); }
  void add(const geometry::Shape& shape) {
    frame_.rigid ? scene.add_rigid(placed(shape), kRock) : scene.add_block(placed(shape), kRock);
  }
  Scene scene;

 private:
  geometry::Shape placed(const geometry::Shape& shape) const {
    geometry::Points points = frame_.turn.toRotationMatrix() * shape.vertices();
    points.colwise() += frame_.origin;
    return geometry::make_hull(points).polyhedron;
  }
  Frame frame_;
};

/// A cube on a slope of 20 degrees.
Scene slope(const Frame& frame, double friction_deg) {
  const Eigen::Quaterniond down(Eigen::AngleAxisd(20.0 * kDegree, Vector3::UnitY()));
  Builder builder({frame.turn * down, frame.origin, frame.rigid}, friction_deg);
  builder.scene.gravity = Vector3(frame.turn * Vector3(0, 0, -9.81));
  builder.fix(geometry::make_box({-5, -2, -1}, {5, 2, 0}));
  builder.add(geometry::make_box({-0.5, -0.5, 0}, {0.5, 0.5, 1}));
  return builder.scene;
}

/// Five cubes, each farther out by `lean`; they tip at 0.2.
Scene tower(const Frame& frame, double lean) {
  Builder builder(frame, 35.0);
  builder.fix(geometry::make_box({-3, -3, -1}, {6, 3, 0}));
  for (int i = 0; i < 5; ++i) {
    builder.add(geometry::make_box({lean * i, 0, 1.0 * i}, {lean * i + 1, 1, i + 1.0}));
  }
  return builder.scene;
}

/// A cube with one corner over the corner of its support, which ends at `end` in x and y; it tips
/// at 0.5.
Scene corner_over(const Frame& frame, double end) {
  Builder builder(frame, 35.0);
  builder.fix(geometry::make_box({-3, -3, -1}, {end, end, 0}));
  builder.add(geometry::make_box({0, 0, 0}, {1, 1, 1}));
  return builder.scene;
}

/// Half a ring of mean radius 1 m on two fixed blocks. A continuous one needs a thickness of 0.1075
/// of the radius: Milankovitch 1907, in Foce, Meccanica 42 (2007).
Scene arch(const Frame& frame, double thickness) {
  constexpr int kVoussoirs = 15;
  Builder builder(frame, 40.0);
  builder.fix(geometry::make_box({-2, -1, -1}, {-0.5, 1, 0}));
  builder.fix(geometry::make_box({0.5, -1, -1}, {2, 1, 0}));
  for (int i = 0; i < kVoussoirs; ++i) {
    geometry::Points points(3, 8);
    int column = 0;
    for (const int joint : {i, i + 1}) {
      const double angle = std::numbers::pi * joint / kVoussoirs;
      for (const double radius : {1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness}) {
        for (const double y : {-0.2, 0.2}) {
          points.col(column++) = Vector3(-radius * std::cos(angle), y, radius * std::sin(angle));
        }
      }
    }
    builder.add(geometry::make_hull(points).polyhedron);
  }
  return builder.scene;
}

struct Found {
  StaticVerdict verdict = StaticVerdict::Seeking;
  double unbalance = 0.0;
  int steps = 0, solves = 0;
  Vector3 moved = Vector3::Zero();  ///< of the last block, m
};

Found search(Simulation& simulation) {
  Found found;
  const Vector3 start = simulation.state().blocks.back().centroid;
  while (found.verdict == StaticVerdict::Seeking && found.steps < 1000) {
    const StepReport report = simulation.advance();
    INFO(describe(report));
    REQUIRE(report.status == StepStatus::Converged);
    found.verdict = report.verdict;
    found.unbalance = report.unbalance;
    ++found.steps;
    found.solves += report.linear_solves;
  }
  found.moved = simulation.state().blocks.back().centroid - start;
  return found;
}

Found search(const Scene& scene, double time_step, Analysis analysis = Analysis::Static) {
  Simulation simulation(scene, {.time_step = time_step, .analysis = analysis});
  return search(simulation);
}

struct Case {
  const char* name;
  Scene (*scene)(const Frame&, double);
  double stands, falls;
};

constexpr Case kCases[] = {{"slope", slope, 21.0, 19.0},
                           {"tower", tower, 0.19, 0.21},
                           {"corner", corner_over, 0.52, 0.48},
                           {"arch", arch, 0.12, 0.1}};

}  // namespace

TEST_CASE("Equilibrium is found where there is one, and a mechanism is told, in every frame") {
  for (const Case& c : kCases) {
    for (const Frame& frame : frames()) {
      CAPTURE(c.name, frame.rigid, frame.origin.x());
      const Found stands = search(c.scene(frame, c.stands), 1e-2);
      CHECK(stands.verdict == StaticVerdict::Rest);
      CHECK(stands.unbalance < 1e-9);
      const Found falls = search(c.scene(frame, c.falls), 1e-2);
      CHECK(falls.verdict == StaticVerdict::Mechanism);
      CHECK(falls.unbalance > 1e-4);
      CHECK(falls.solves < 300 * falls.steps);
    }
  }
}

TEST_CASE("A static analysis does not know the time step") {
  for (const Case& c : kCases) {
    const Found one = search(c.scene({}, c.falls), 1e-4), other = search(c.scene({}, c.falls), 1.0);
    CHECK(one.verdict == other.verdict);
    CHECK(one.steps == other.steps);
    CHECK(one.moved == other.moved);  // to the bit
  }
}

TEST_CASE("What moves when a static analysis begins loses its energy to the ledger") {
  for (const bool rigid : {true, false}) {
    Builder builder({.rigid = rigid}, 30);
    builder.fix(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
    builder.add(geometry::make_box({0, 0, 0}, {1, 1, 0.2}));
    builder.scene.blocks[1].velocity = {1, 0, 0};
    Simulation simulation(builder.scene, {.analysis = Analysis::Static});
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    const EnergyLedger& energy = simulation.state().energy;
    CHECK(energy.kinetic == 0.0);
    CHECK(std::abs(energy.closure) < 1e-6 * 0.5 * kRock.density * 0.2);
  }
}

TEST_CASE("A settling block does not slide, but it tips") {
  CHECK(search(slope({}, 5.0), 1.0, Analysis::Settle).verdict == StaticVerdict::Rest);
  CHECK(search(tower({}, 0.25), 1.0, Analysis::Settle).verdict == StaticVerdict::Mechanism);
}

namespace {

/// Nine blocks in four courses.
Scene wall(const Frame& frame) {
  Builder builder(frame, 35.0);
  builder.fix(geometry::make_box({-2, -2, -1}, {6, 3, 0}));
  for (int course = 0; course < 4; ++course) {
    const double first = 0.5 * (course % 2), low = 0.5 * course;
    for (int i = 0; i < 3 - course % 2; ++i) {
      builder.add(geometry::make_box({first + i, 0, low}, {first + i + 1, 0.5, low + 0.5}));
    }
  }
  return builder.scene;
}

/// A wedge of half-angle 0.19 rad between two fixed blocks, held by friction.
Scene wedge(const Frame& frame) {
  const auto prism = [](double left_low, double right_low, double left_high, double right_high) {
    geometry::Points points(3, 8);
    int column = 0;
    for (const double y : {0.0, 1.0}) {
      points.col(column++) = Vector3(left_low, y, 0);
      points.col(column++) = Vector3(right_low, y, 0);
      points.col(column++) = Vector3(left_high, y, 1);
      points.col(column++) = Vector3(right_high, y, 1);
    }
    return geometry::make_hull(points).polyhedron;
  };
  const double wider = std::tan(0.19);
  Builder builder(frame, 12.0);
  builder.fix(prism(-2, -0.5, -2, -0.5 - wider));
  builder.fix(prism(0.5, 2, 0.5 + wider, 2));
  builder.add(prism(-0.5, 0.5, -0.5 - wider, 0.5 + wider));
  return builder.scene;
}

double farthest(const State& from, const State& to) {
  double most = 0.0;
  for (std::size_t b = 0; b < from.blocks.size(); ++b) {
    most = std::max(most, (to.blocks[b].centroid - from.blocks[b].centroid).norm());
  }
  return most;
}

Frame turned_frame(int i) { return turned(0.7 * (i % 5), {0, 0, 0}, i < 5); }

struct Moved {
  double way = 0.0, speed = 0.0;  ///< m, m/s
};

/// `steps` of 0.01 s from rest on, without a flag: the most that a block has moved, and how fast it
/// is.
Moved after_rest(const Scene& scene, int steps) {
  Simulation simulation(scene, {.time_step = 0.01, .analysis = Analysis::Static});
  REQUIRE(search(simulation).verdict == StaticVerdict::Rest);
  const State rest = simulation.state();
  simulation.set_options({.time_step = 0.01});
  for (int step = 0; step < steps; ++step) {
    const StepReport report = simulation.advance();
    REQUIRE(report.status == StepStatus::Converged);
    REQUIRE(report.flags.empty());
  }
  Moved moved{.way = farthest(rest, simulation.state())};
  for (const BlockState& block : simulation.state().blocks) {
    moved.speed = std::max(moved.speed, block.velocity.norm());
  }
  return moved;
}

}  // namespace

TEST_CASE("What follows a static analysis stands, in every frame") {
  for (Scene (*scene)(const Frame&) : {wall, wedge}) {
    for (int i = 0; i < 10; ++i) {
      CAPTURE(i, scene == wedge);
      const auto [moved, speed] = after_rest(scene(turned_frame(i)), i == 7 ? 500 : 150);
      CHECK(moved < 1e-12);
      CHECK(speed < 1e-12);
    }
  }
}

// Rest is where the unbalance falls no further: what is left of it swings, a hundredth of what gaps
// may be off by.
TEST_CASE("A deformable tower that leans and an arch stand after a static analysis, turned") {
  const Frame frame = turned_frame(7);
  for (const Scene& scene : {tower(frame, 0.15), arch(frame, 0.2)}) {
    const auto [moved, speed] = after_rest(scene, 500);
    CHECK(moved < 1e-11);
    CHECK(speed < 1e-9);
  }
}

namespace {

/// Bricks of 0.8 x 0.3 x 0.25 m in running bond, half bricks at the ends of every other course;
/// rigid where `brick` has no modulus.
Scene wall(double length, int courses, const Material& brick) {
  Scene scene;
  scene.joint.friction_angle = 35.0 * kDegree;
  scene.add_fixed(geometry::make_box({-0.5, -1, -0.3}, {length + 0.5, 1.3, 0}));
  for (int course = 0; course < courses; ++course) {
    const double low = 0.25 * course;
    double left = 0.0;
    for (double right = course % 2 == 0 ? 0.8 : 0.4; left < length - 1e-9; right += 0.8) {
      right = std::min(right, length);
      const auto shape = geometry::make_box({left, 0, low}, {right, 0.3, low + 0.25});
      brick.young > 0.0 ? scene.add_block(shape, brick) : scene.add_rigid(shape, brick);
      left = right;
    }
  }
  return scene;
}

}  // namespace

// At this tolerance Newton's residual ends above it, in the rounding of stiffness times change: 230
// solves, 3156 where that counts as a failure.
TEST_CASE("A deformable wall whose residual is rounding comes to rest without detours") {
  const Material soft{.density = 2400, .young = 1e9, .poisson = 0.25};
  Simulation simulation(wall(4.0, 6, soft),
                        {.time_step = 1e-3, .analysis = Analysis::Static, .tolerance = 1e-12});
  const Found found = search(simulation);
  CHECK(found.verdict == StaticVerdict::Rest);
  CHECK(found.solves <= 500);
}

// Poisson's ratio makes each brick push on those beside it, and friction holds some of that.
TEST_CASE("A wall of bricks that deform comes to rest from nothing") {
  const Material stone{.density = 2400, .young = 1e9, .poisson = 0.3};
  Simulation simulation(wall(8.0, 20, stone), {.time_step = 1e-3, .analysis = Analysis::Static});
  const Found found = search(simulation);
  CHECK(found.verdict == StaticVerdict::Rest);
  CHECK(found.solves <= 400);
}

// Bricks of the top course slide on the two below, that part under them, in opposite directions:
// nothing but the ends of these slides holds them. 23 solves, 73 where Newton's step is not damped
// there.
TEST_CASE("A wall whose top bricks slide both ways comes to rest without softer contacts") {
  Simulation simulation(wall(20.0, 40, {.density = 2400}),
                        {.time_step = 1e-3, .analysis = Analysis::Static});
  const Found found = search(simulation);
  CHECK(found.verdict == StaticVerdict::Rest);
  CHECK(found.solves <= 40);
}

namespace {

constexpr double kPull = 1e6;  // Pa

/// A block of 1 m × 2 m × 3 m in the air that tractions pull lengthwise; their sum is rounding.
Scene pulled(const Frame& frame) {
  Builder builder(frame, 30.0);
  builder.scene.gravity = Vector3(0, 0, 0);
  builder.add(geometry::make_box({0, 0, 0}, {1, 2, 3}));
  const Vector3 along = frame.turn * Vector3::UnitZ();
  const geometry::Shape& shape = *builder.scene.blocks[0].shape;
  for (int face = 0; face < shape.topology().face_count(); ++face) {
    const Vector3 traction = kPull * shape.face_normal(face).dot(along) * along;
    builder.scene.face_loads.push_back({0, face, traction});
  }
  return builder.scene;
}

/// Hooke's, in the frame.
Matrix3 pulled_strain(const Frame& frame) {
  const Vector3 along = frame.turn * Vector3::UnitZ();
  return kPull / kRock.young *
         ((1.0 + kRock.poisson) * along * along.transpose() - kRock.poisson * Matrix3::Identity());
}

}  // namespace

TEST_CASE("Tractions that balance strain a block and move it nowhere, in every frame") {
  for (const bool held : {false, true}) {
    for (const Frame& frame : frames()) {
      CAPTURE(held, frame.rigid, frame.origin.x());
      Scene scene = pulled(frame);
      const Vector3 centre = frame.origin + frame.turn * Vector3(0.5, 1, 1.5);
      if (held) scene.fixed_points.push_back({0, centre, Vector3(0, 0, 0)});
      Simulation simulation(scene, {.time_step = 1e-2, .analysis = Analysis::Static});
      const Found found = search(simulation);
      CHECK(found.verdict == StaticVerdict::Rest);
      CHECK(found.moved.norm() < 1e-12);
      const BlockState& block = simulation.state().blocks[0];
      CHECK(block.rotation.angularDistance(Eigen::Quaterniond::Identity()) < 1e-9);
      const Vector6& e = block.strain;
      Matrix3 strain;
      strain << e[0], e[3] / 2, e[5] / 2, e[3] / 2, e[1], e[4] / 2, e[5] / 2, e[4] / 2, e[2];
      if (frame.rigid) {
        CHECK(strain.isZero(0.0));
      } else {
        CHECK((strain - pulled_strain(frame)).norm() < 1e-6 * pulled_strain(frame).norm());
      }
    }
  }
}

TEST_CASE("Forces that balance but for rounding, or for the digits of a file, are no motion") {
  for (const double digits : {0.0, 1e-9}) {
    Scene scene;
    scene.gravity = Vector3(0, 0, 0);
    scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), kRock);
    for (const double force : {0.1, 0.2, -0.3 - digits}) {
      scene.point_loads.push_back({0, {0.5, 0.5, 0.5}, Vector3(force, 0, 0)});
    }
    const Found found = search(scene, 1e-2);
    CHECK(found.verdict == StaticVerdict::Rest);
    CHECK(found.moved.norm() < 1e-2 * digits + 1e-15);
  }
}

// What rounding leaves of the point's arm is no lever: augmentation that goes by it is 1e44 N/m.
TEST_CASE("A block that is pulled apart hangs by its centroid with its weight, wherever it is") {
  for (int i = 0; i < 12; ++i) {
    const Frame frame = turned(0.5 * i, 1e3 * i * Vector3(1, -2, 3), i % 4 == 0);
    CAPTURE(i);
    Scene scene = pulled(frame);
    scene.gravity = Vector3(frame.turn * Vector3(0, 0, -9.81));
    scene.fixed_points.push_back(
        {0, frame.origin + frame.turn * Vector3(0.5, 1, 1.5), Vector3(0, 0, 0)});
    Simulation simulation(scene, {.time_step = 1e-2, .analysis = Analysis::Static});
    CHECK(search(simulation).verdict == StaticVerdict::Rest);
    const Vector3 weight = 6.0 * kRock.density * scene.gravity.at(0.0);
    CHECK((simulation.state().held_forces[0] + weight).norm() < 1e-9 * weight.norm());
  }
}
