/// Ties against closed forms, rigid and deformable, turned and far from the origin; the ledger
/// closed.

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <sstream>

#include "support/catch.hpp"

using namespace quoin::solver;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRock{.density = 2500, .young = 5e9, .poisson = 0.25};
constexpr double kGravity = 9.81;
constexpr double kWeight = 2500 * kGravity;  // of a cube of 1 m

struct Frame {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Vector3 origin = Vector3::Zero();
  bool rigid = true;
  Vector3 at(double x, double y, double z) const { return origin + turn * Vector3(x, y, z); }
  Vector3 along(double x, double y, double z) const { return turn * Vector3(x, y, z); }
};

std::vector<Frame> frames() {
  const Eigen::AngleAxisd turn(1.1, Vector3(1, 2, -0.5).normalized());
  const Vector3 far(4e5, -2e5, 1e5);
  return {{}, {.rigid = false}, {turn.matrix(), far, true}, {turn.matrix(), far, false}};
}

int add_box(const Frame& frame, const Vector3& low, const Vector3& high, Scene& scene) {
  geometry::Points points = frame.turn * geometry::make_box(low, high).vertices();
  points.colwise() += frame.origin;
  const geometry::Shape shape = geometry::make_hull(points).polyhedron;
  return frame.rigid ? scene.add_rigid(shape, kRock) : scene.add_block(shape, kRock);
}

/// A cube about (0, 0, 0), alone.
Scene cube(const Frame& frame, double gravity) {
  Scene scene;
  scene.gravity = frame.along(0, 0, -gravity);
  add_box(frame, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, scene);
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

void check_closed(const Simulation& simulation, double scale) {
  CHECK(std::abs(simulation.state().energy.closure) <= 1e-8 * scale);
}

const StepOptions kStatic{.analysis = Analysis::Static};

StepOptions dynamic(double time_step, TimeScheme scheme) {
  StepOptions options{.time_step = time_step};
  options.scheme = scheme;
  return options;
}

}  // namespace

TEST_CASE("a mass hangs from a tie") {
  for (const Frame& frame : frames()) {
    Scene scene = cube(frame, kGravity);
    scene.ties.push_back(
        {.a = 0, .point_a = frame.at(0, 0, 0), .point_b = frame.at(0, 0, 3), .stiffness = 1e6});
    Simulation simulation(scene, kStatic);
    rest(simulation);
    const TieState& tie = simulation.state().ties[0];
    CHECK(near(tie.force, kWeight, 1e-6));
    CHECK(near(tie.length - 3.0, kWeight / 1e6, 1e-5));
    CHECK(tie.plastic == 0.0);
    check_closed(simulation, kWeight);
  }
}

TEST_CASE("a weight between two ties hangs where these balance it") {
  // Half span 2, nearly level: all stiffness across is that of the tension.
  double low = 0.0, high = 1.0;
  const double k = 1e6;
  for (int i = 0; i < 100; ++i) {
    const double sag = 0.5 * (low + high), length = std::hypot(2.0, sag);
    (2.0 * k * (length - 2.0) * sag / length < kWeight ? low : high) = sag;
  }
  for (const Frame& frame : frames()) {
    Scene scene = cube(frame, kGravity);
    for (const double x : {-2.0, 2.0}) {
      scene.ties.push_back(
          {.b = 0, .point_a = frame.at(x, 0, 0), .point_b = frame.at(0, 0, 0), .stiffness = k});
    }
    Simulation simulation(scene, kStatic);
    rest(simulation);
    const Vector3 moved = frame.turn.transpose() * simulation.displacement(0, Vector3::Zero());
    CHECK(near(moved.z(), -low, 1e-5));
    const double length = std::hypot(2.0, low);
    CHECK(near(simulation.state().ties[1].force, k * (length - 2.0), 1e-5));
  }
}

TEST_CASE("a mass on a tie swings with its period and keeps its energy") {
  const double k = 1e6, omega = std::sqrt(k / 2500.0), period = 2.0 * std::numbers::pi / omega;
  for (const Frame& frame : frames()) {
    for (const TimeScheme scheme : {TimeScheme::EnergyMomentum, TimeScheme::ConstantAcceleration}) {
      Scene scene = cube(frame, 0.0);
      scene.blocks[0].velocity = frame.along(0, 0, -0.1);
      scene.ties.push_back({.a = 0,
                            .point_a = frame.at(0, 0, 0),
                            .point_b = frame.at(0, 0, 3),
                            .stiffness = k,
                            .tension_only = false});
      Simulation simulation(scene, dynamic(period / 200, scheme));
      const double energy = simulation.state().energy.mechanical();
      for (int i = 0; i < 200; ++i) {
        REQUIRE(simulation.advance().status == StepStatus::Converged);
        if (i == 49) {  // a quarter: out to v / omega, but for what the scheme damps
          const bool exact = scheme == TimeScheme::EnergyMomentum;
          CHECK(near(simulation.state().ties[0].length - 3.0, 0.1 / omega, exact ? 1e-3 : 2e-2));
        }
      }
      const EnergyLedger& ledger = simulation.state().energy;
      check_closed(simulation, energy);
      if (scheme == TimeScheme::ConstantAcceleration) {
        CHECK(ledger.algorithmic_loss > 0.0);
        continue;
      }
      CHECK(std::abs(simulation.state().ties[0].length - 3.0 - 0.0) <= 1e-3 * 0.1 / omega);
      CHECK(near(ledger.mechanical(), energy, 1e-9));
    }
  }
}

TEST_CASE("a tie that bears tension only is slack on the way in, and keeps the energy") {
  for (const Frame& frame : frames()) {
    Scene scene = cube(frame, kGravity);
    scene.blocks[0].velocity = frame.along(0, 0, 1.0);  // up, towards the other end
    scene.ties.push_back(
        {.a = 0, .point_a = frame.at(0, 0, 0), .point_b = frame.at(0, 0, 3), .stiffness = 1e7});
    Simulation simulation(scene, dynamic(1e-3, TimeScheme::EnergyMomentum));
    const double energy = simulation.state().energy.mechanical();
    double largest = 0.0;
    const double back = 2.0 / kGravity;  // s, in free flight
    for (int i = 0; i < 230; ++i) {
      REQUIRE(simulation.advance().status == StepStatus::Converged);
      const double force = simulation.state().ties[0].force;
      if (simulation.state().time < back - 2e-3) CHECK(force == 0.0);
      largest = std::max(largest, force);
      CHECK(near(simulation.state().energy.mechanical(), energy, 1e-8));
    }
    // 1/2 k e^2 = 1/2 m v^2 + m g e
    const double e = (kWeight + std::sqrt(kWeight * kWeight + 1e7 * 2500)) / 1e7;
    CHECK(near(largest, 1e7 * e, 1e-2));
    check_closed(simulation, energy);
  }
}

namespace {

/// A held cube, and a block that moves away from it by `way` in 1 s with the tie's other end.
Scene pulled(const Frame& frame, double way, Tie tie) {
  Scene scene = cube(frame, 0.0);
  Frame rigid = frame;
  rigid.rigid = true;
  const int puller = add_box(rigid, {4, -1, -1}, {6, 1, 1}, scene);
  scene.blocks[1].kind = BlockKind::Prescribed;
  scene.blocks[1].motion = {.kind = MotionKind::Displacement,
                            .value = VectorOfTime([=](double t) -> Vector3 {
                              return way * std::min(t, 1.0) * frame.along(1, 0, 0);
                            })};
  for (const Vector3& point : {Vector3(0, 0, 0), Vector3(0.4, 0, 0), Vector3(0, 0.4, 0)}) {
    scene.fixed_points.push_back({0, frame.at(point.x(), point.y(), point.z()), {}});
  }
  tie.a = puller;
  tie.b = 0;
  tie.point_a = frame.at(5, 0, 0);
  tie.point_b = frame.at(0, 0, 0);
  scene.ties.push_back(tie);
  return scene;
}

}  // namespace

TEST_CASE("a tie yields at its force, and its work is stored and lost") {
  const double k = 1e6, yield = 2e3, way = 0.01;
  for (const Frame& frame : frames()) {
    for (const TimeScheme scheme : {TimeScheme::EnergyMomentum, TimeScheme::ConstantAcceleration}) {
      Simulation simulation(pulled(frame, way, {.stiffness = k, .yield_force = yield}),
                            dynamic(7e-3, scheme));
      while (simulation.state().time < 1.0 - 1e-9) {
        REQUIRE(simulation.advance().status == StepStatus::Converged);
      }
      const TieState& tie = simulation.state().ties[0];
      CHECK(near(tie.force, yield, 1e-9));
      CHECK(near(tie.plastic, way - yield / k, 1e-6));
      const EnergyLedger& ledger = simulation.state().energy;
      const double lost = yield * (way - yield / k), stored = 0.5 * yield * yield / k;
      CHECK(near(ledger.friction_loss, lost, 1e-6));
      CHECK(near(ledger.work - ledger.algorithmic_loss, lost + stored, 1e-6));
      CHECK(near(ledger.contact, stored, 1e-9));
      if (scheme == TimeScheme::EnergyMomentum) CHECK(std::abs(ledger.algorithmic_loss) < 1e-6);
      check_closed(simulation, lost);
    }
  }
}

TEST_CASE("a tie breaks by its force or by its strain, and what it had stored is lost") {
  const double k = 1e6;
  for (const Frame& frame : frames()) {
    for (const Tie& tie : {Tie{.stiffness = k, .break_force = 2e3},
                           Tie{.stiffness = k, .yield_force = 1e3, .break_strain = 2e-3 / 5.0}}) {
      Simulation simulation(pulled(frame, 4e-3, tie), {.time_step = 1e-2});
      double last = 0.0;
      for (int i = 0; i < 100; ++i) {
        if (!simulation.state().ties[0].broken) last = simulation.state().ties[0].length - 5.0;
        REQUIRE(simulation.advance().status == StepStatus::Converged);
      }
      CHECK(simulation.state().ties[0].broken);
      CHECK(simulation.state().ties[0].force == 0.0);
      CHECK(std::abs(last - 2e-3) <= 4.1e-5);
      const EnergyLedger& ledger = simulation.state().energy;
      CHECK(ledger.contact == 0.0);
      CHECK(near(ledger.friction_loss + ledger.algorithmic_loss, ledger.work, 1e-9));
      check_closed(simulation, ledger.work);
    }
  }
}

TEST_CASE("blocks that a tie drags stop where friction bears it") {
  const double friction = std::numbers::pi / 6.0, k = 1e6;
  for (const Frame& frame : frames()) {
    for (const double height : {0.3, 0.5}) {
      for (const double pretension : {2e4, 3e4, 5e4, 1e5}) {
        Scene scene{.joint = {.friction_angle = friction}};
        scene.gravity = frame.along(0, 0, -kGravity);
        Frame ground = frame;
        ground.rigid = true;
        add_box(ground, {-5, -5, -1}, {6, 6, 0}, scene);
        scene.blocks[0].kind = BlockKind::Fixed;
        add_box(frame, {0, 0, 0}, {1, 1, 1}, scene);
        add_box(frame, {2, 0, 0}, {3, 1, 1}, scene);
        scene.ties.push_back({.a = 1,
                              .b = 2,
                              .point_a = frame.at(1, 0.5, height),
                              .point_b = frame.at(2, 0.5, height),
                              .stiffness = k,
                              .pretension = pretension});
        Simulation simulation(scene, kStatic);
        rest(simulation);
        const double limit = kWeight * std::tan(friction);
        const TieState& tie = simulation.state().ties[0];
        CHECK(near(tie.force, limit, 1e-6));
        CHECK(near(1.0 - tie.length, (pretension - limit) / k, 1e-3));
      }
    }
  }
}

TEST_CASE("a tie rod bears the thrust of half an arch that leans on its plane of symmetry") {
  // A triangle of the plane y = 0, 0.8 m3: its foot on a smooth floor at x = -2, its top at (0, 2)
  // against a smooth wall; the rod at z = 0.5 bears H (2 - 0.5) = W (2 - 1.6 / 1.5).
  const double thrust = 0.8 * kWeight * (2.0 - 3.2 / 3.0) / 1.5;
  for (const Frame& frame : frames()) {
    Scene scene{.joint = {.friction_angle = 0.0}};
    scene.gravity = frame.along(0, 0, -kGravity);
    Frame held = frame;
    held.rigid = true;
    add_box(held, {-4, -2, -1}, {0, 2, 0}, scene);
    add_box(held, {0, -2, 1}, {1, 2, 3}, scene);
    for (Block& block : scene.blocks) block.kind = BlockKind::Fixed;
    geometry::Points corners(3, 6);
    corners << frame.at(-2, -0.5, 0), frame.at(-1.2, -0.5, 1.6), frame.at(0, -0.5, 2),
        frame.at(-2, 0.5, 0), frame.at(-1.2, 0.5, 1.6), frame.at(0, 0.5, 2);
    const geometry::Shape half = geometry::make_hull(corners).polyhedron;
    const int arch = frame.rigid ? scene.add_rigid(half, kRock) : scene.add_block(half, kRock);
    for (const double y : {-0.4, 0.4}) {
      scene.ties.push_back({.a = arch,
                            .point_a = frame.at(-1.6, y, 0.5),
                            .point_b = frame.at(1, y, 0.5),
                            .stiffness = 1e8});
    }
    Simulation simulation(scene, kStatic);
    rest(simulation);
    const std::vector<TieState>& ties = simulation.state().ties;
    CHECK(near(ties[0].force, 0.5 * thrust, 1e-3));
    CHECK(near(ties[1].force, 0.5 * thrust, 1e-3));
  }
}

TEST_CASE("a tie breaks within the step, and takes all that it can bear") {
  // Of the kinetic energy F^2 / (2 k), however long the step is.
  const double k = 1e6, strength = 2e4, mass = 2500.0;
  const double speed = std::sqrt(1.0 - strength * strength / (k * mass));
  for (const Frame& frame : frames()) {
    for (const double time_step : {2.7e-3, 4.1e-3, 5.3e-3}) {
      Scene scene = cube(frame, 0.0);
      scene.blocks[0].velocity = frame.along(1, 0, 0);
      scene.ties.push_back({.a = 0,
                            .point_a = frame.at(0, 0, 0),
                            .point_b = frame.at(-3, 0, 0),
                            .stiffness = k,
                            .break_force = strength});
      Simulation simulation(scene, dynamic(time_step, TimeScheme::EnergyMomentum));
      while (simulation.state().time < 0.05) {
        REQUIRE(simulation.advance().status == StepStatus::Converged);
      }
      CHECK(simulation.state().ties[0].broken);
      CHECK(near(simulation.state().blocks[0].velocity.norm(), speed, 2e-3));
      const EnergyLedger& ledger = simulation.state().energy;
      CHECK(near(ledger.friction_loss, 0.5 * strength * strength / k, 2e-2));
      check_closed(simulation, ledger.friction_loss);
    }
  }
}

TEST_CASE("a bolt takes what friction lacks on a slope") {
  const double slope = 35.0, friction = 20.0, degree = std::numbers::pi / 180.0;
  for (Frame frame : frames()) {
    frame.turn = frame.turn * Eigen::AngleAxisd(slope * degree, Vector3::UnitY()).matrix();
    Scene scene;
    scene.joint.friction_angle = friction * degree;
    scene.gravity =
        Vector3(kGravity * frame.along(std::sin(slope * degree), 0, -std::cos(slope * degree)));
    Frame ground = frame;
    ground.rigid = true;
    add_box(ground, {-4, -4, -1}, {4, 4, 0}, scene);
    scene.blocks[0].kind = BlockKind::Fixed;
    const int block = add_box(frame, {-0.5, -0.5, 0}, {0.5, 0.5, 1}, scene);
    scene.ties.push_back({.a = 0,
                          .b = block,
                          .point_a = frame.at(-3, 0, 0.1),
                          .point_b = frame.at(-0.5, 0, 0.1),
                          .stiffness = 1e7});
    Simulation simulation(scene, kStatic);
    rest(simulation);
    const double wanted = kWeight * (std::sin(slope * degree) -
                                     std::cos(slope * degree) * std::tan(friction * degree));
    CHECK(near(simulation.state().ties[0].force, wanted, 1e-3));
  }
}

TEST_CASE(
    "a tie put in by a change of the scene is unstressed there, and goes on after a checkpoint") {
  const Frame frame;
  Scene scene = cube(frame, kGravity);
  scene.ties.push_back(
      {.a = 0, .point_a = frame.at(0, 0, 0), .point_b = frame.at(0, 0, 3), .stiffness = 1e6});
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
  Scene scene = cube({}, kGravity);
  const auto refused = [&](const Tie& tie, const std::string& message) {
    Scene with = scene;
    with.ties.push_back(tie);
    try {
      Simulation simulation(with, {});
      FAIL("taken");
    } catch (const InputError& error) {
      CHECK(std::string(error.what()).find(message) != std::string::npos);
    }
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
