/// V16, V17, V21, the stack of 30 and the paper's examples 5.3 and 5.4.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cases.hpp"
#include "scenes.hpp"

namespace quoin::validation {
namespace {

using solver::ContactMethod;
using solver::Simulation;
using solver::StepOptions;

const solver::BlockState& state_of(const Simulation& simulation, int block) {
  return simulation.state().blocks[static_cast<std::size_t>(block)];
}

/// Largest pitch of the top block within 2 s, rad.
double overhang_pitch(double scale) {
  const double length = 1.0, width = 0.5, height = 0.2;
  solver::Scene scene;
  scene.joint.friction_angle = radians(45);
  scene.add_fixed(geometry::make_box({-3, -2, -1}, {0, 2, 0}));  // its edge is x = 0
  // Limits from the top: L/2, L/4, L/6, L/8 over the edge of what carries it.
  double front = 0.0;
  for (int i = 0; i < 4; ++i) {
    front += scale * length / (2.0 * (4 - i));
    scene.add_block(geometry::make_box({front - length, -0.5 * width, i * height},
                                       {front, 0.5 * width, (i + 1) * height}),
                    {.density = 2500, .young = 10e9, .poisson = 0.25});
  }
  Simulation simulation(scene, {.time_step = 1e-3});
  settle(simulation);
  double pitch = 0.0;
  for (int i = 0; i < 2000 && pitch < 0.5; ++i) {
    step(simulation);
    const Vector3 along = state_of(simulation, 4).rotation * Vector3::UnitX();
    pitch = std::max(pitch, std::abs(std::atan2(-along.z(), along.x())));
  }
  return pitch;
}

}  // namespace

void v16_overhang(Report& report) {
  for (const double scale : {0.98, 0.995}) {
    report.start_run();
    report.absolute("pitch after 2 s at s = " + text(scale) + " [rad]", 0.0, overhang_pitch(scale),
                    1e-6);
  }
  report.start_run();
  report.at_least("pitch after 2 s at s = 1.02 [rad]", 0.05, overhang_pitch(1.02));
  report.start_run();
  report.at_least("pitch after 2 s at s = 1.005 [rad]", 0.05, overhang_pitch(1.005));
}

namespace {

struct ArchRun {
  double crown_drop = 0.0;  ///< m, largest of the blocks beside the crown
  double speed = 0.0;       ///< m/s, of a vertex at the end
};

/// Voussoirs between radial joints, vertices at R -+ t/2, springings on fixed blocks; 10 s or until
/// down.
ArchRun stand(int count, double thickness, double young, bool rigid) {
  const double radius = 10.0, inner = radius - 0.5 * thickness, outer = radius + 0.5 * thickness;
  solver::Scene scene;
  scene.joint.friction_angle = radians(40);
  const solver::Material stone{.density = 2500, .young = young, .poisson = 0.25};
  for (const double side : {-1.0, 1.0}) {
    scene.add_fixed(
        geometry::make_box({side * radius - 1.0, -1.0, -1.0}, {side * radius + 1.0, 2.0, 0}));
  }
  const auto corner = [](double r, double angle) {
    return Vector3(-r * std::cos(angle), 0.0, r * std::sin(angle));
  };
  for (int i = 0; i < count; ++i) {
    const double from = std::numbers::pi * i / count, to = std::numbers::pi * (i + 1) / count;
    geometry::Points polygon(3, 4);
    polygon << corner(inner, from), corner(outer, from), corner(outer, to), corner(inner, to);
    if (i == 0) polygon.row(2).head<2>().setZero();
    if (i == count - 1) polygon.row(2).tail<2>().setZero();
    const geometry::Shape shape = geometry::make_prism(polygon, {0, 1, 0});
    rigid ? scene.add_rigid(shape, stone) : scene.add_block(shape, stone);
  }
  Simulation simulation(scene, {.time_step = 0.01});
  settle(simulation);
  const int crown = 2 + count / 2;
  const double start = state_of(simulation, crown).centroid.z();
  ArchRun run;
  for (int i = 0; i < 1000 && run.crown_drop < 0.02 * radius; ++i) {
    run.speed = step(simulation).largest_speed;
    run.crown_drop = start - state_of(simulation, crown).centroid.z();
  }
  return run;
}

}  // namespace

void v17_arch(Report& report) {
  // Lower-bound linear programme: compressive forces at the two ends of each joint, |shear| <= tan
  // 40 N, bisection on t; tends to the continuous ring's 0.107478 [Milankovitch 1907] for many
  // voussoirs.
  constexpr double kLimit16 = 0.10707620335742833, kLimit9 = 0.10152546735480428;
  struct Arch {
    int count;
    double ratio;
    double young;
    bool rigid;
    bool stands;
    const char* what;
  };
  const Arch kArches[] = {
      {16, 0.112, 10e9, false, true, "N=16 t/R=0.112, E 1e10"},
      {16, 1.01 * kLimit16, 1e12, false, true, "N=16 at 1.01 of the limit, E 1e12"},
      {16, 0.99 * kLimit16, 1e12, false, false, "N=16 at 0.99 of the limit, E 1e12"},
      {16, 1.01 * kLimit16, 0, true, true, "N=16 at 1.01 of the limit, rigid"},
      {16, 0.99 * kLimit16, 0, true, false, "N=16 at 0.99 of the limit, rigid"},
      {9, 1.01 * kLimit9, 0, true, true, "N=9 at 1.01 of the limit, rigid"},
      {9, 0.99 * kLimit9, 0, true, false, "N=9 at 0.99 of the limit, rigid"}};
  for (const Arch& arch : kArches) {
    report.attempt(arch.what, [&] {
      const ArchRun run = stand(arch.count, 10.0 * arch.ratio, arch.young, arch.rigid);
      const std::string what = arch.what;
      if (arch.stands) {
        report.absolute(what + ": speed after 10 s [m/s]", 0.0, run.speed, 1e-6);
      } else {
        report.at_least(what + ": crown down within 10 s [m]", 0.2, run.crown_drop);
      }
    });
  }
}

void v17_soft_arch(Report& report) {
  report.attempt("N=16 t/R=0.102, E 1e10", [&] {
    const ArchRun run = stand(16, 1.02, 10e9, false);
    report.at_least("N=16 t/R=0.102, E 1e10: crown down within 10 s [m]", 0.2, run.crown_drop);
  });
}

namespace {

void stack(bool rigid, Report& report) {
  constexpr int kCount = 30;
  solver::Scene scene;
  scene.joint.friction_angle = radians(35);
  scene.add_fixed(geometry::make_box({-1, -1, -1}, {2, 2, 0}));
  const solver::Material rock{.density = 2500, .young = 5e9, .poisson = 0.25};
  for (int i = 0; i < kCount; ++i) {
    const geometry::Shape cube = geometry::make_box({0, 0, 1.0 * i}, {1, 1, i + 1.0});
    rigid ? scene.add_rigid(cube, rock) : scene.add_block(cube, rock);
  }
  Simulation simulation(scene, {.time_step = 0.01});
  settle(simulation);
  relax(simulation, 200);  // squeezed corners slip until friction bears them
  std::vector<Vector3> start;
  for (const solver::BlockState& block : simulation.state().blocks) start.push_back(block.centroid);
  run_for(simulation, 5.0);
  double worst = 0.0, drift = 0.0;
  for (int i = 0; i < kCount; ++i) {
    double force = 0.0;
    for (const solver::Contact& contact : simulation.state().contacts) {
      if (contact.point.key.a == i && contact.point.key.b == i + 1) force += contact.normal_force;
    }
    const double exact = (kCount - i) * 2500 * kGravity;
    worst = std::max(worst, std::abs(force / exact - 1.0));
    const auto block = static_cast<std::size_t>(i + 1);
    drift = std::max(drift, (simulation.state().blocks[block].centroid - start[block]).norm());
  }
  const std::string which = rigid ? ", rigid" : "";
  report.absolute("interface forces after 5 s, worst / k m g - 1" + which, 0.0, worst, 1e-8);
  report.absolute("drift in 5 s [m]" + which, 0.0, drift, 1e-10);
}

}  // namespace

void stack_of_30(Report& report) {
  report.attempt("deformable", [&] { stack(false, report); });
  report.attempt("rigid", [&] { stack(true, report); });
}

namespace {

/// What a run on a slope ends with, in the axes of its frame and in m.
struct SlopeResult {
  std::vector<double> values;
};

SlopeResult curved(const Frame& frame, bool plane_last) {
  const SlopeScene slope{.angle = radians(25),
                         .friction = radians(25),
                         .size = {0.5, 0.5, 0.1},
                         .material = {.density = 2500, .young = 5e9, .poisson = 0.25},
                         .velocity = {0, 3, 0},
                         .plane_last = plane_last,
                         .frame = frame};
  Simulation simulation(slope.scene(), {.time_step = 1e-3});
  settle(simulation);
  run_for(simulation, 0.5);
  const Vector3 moved = slope.displacement(simulation), speed = slope.block_velocity(simulation);
  return {{moved.x(), moved.y(), speed.x(), speed.y()}};
}

SlopeResult toppling(const Frame& frame, bool plane_last) {
  const SlopeScene slope{.angle = radians(30),
                         .friction = radians(20),
                         .size = {1, 1, 3},
                         .material = {.density = 2600, .young = 10e9, .poisson = 0.25},
                         .plane_last = plane_last,
                         .frame = frame};
  Simulation simulation(slope.scene(), {.time_step = 1e-3});
  run_for(simulation, 0.3);
  const Vector3 moved = slope.displacement(simulation);
  return {{moved.x(), moved.z(), slope.angular_velocity(simulation).y()}};
}

double change(const SlopeResult& now, const SlopeResult& reference) {
  double worst = 0.0;
  for (std::size_t i = 0; i < now.values.size(); ++i) {
    worst = std::max(worst, std::abs(now.values[i] / reference.values[i] - 1.0));
  }
  return worst;
}

}  // namespace

void v21_invariances(Report& report) {
  struct Change {
    const char* what;
    Frame frame;
    bool plane_last;
  };
  const Change kChanges[] = {
      {"moved by (1000, -2000, 500)", {.origin = Vector3(1000, -2000, 500)}, false},
      {"turned by 90 deg about z", {.rotation = turn(radians(90), Vector3::UnitZ())}, false},
      {"turned by 30 deg about z", {.rotation = turn(radians(30), Vector3::UnitZ())}, false},
      {"blocks in reverse", {}, true},
      {"lengths in mm", {.scale = 1000.0}, false}};
  const SlopeResult reference_curved = curved({}, false);
  const SlopeResult reference_toppling = toppling({}, false);
  for (const Change& c : kChanges) {
    report.start_run();
    report.absolute(std::string("V05, ") + c.what + ": largest relative change", 0.0,
                    change(curved(c.frame, c.plane_last), reference_curved), 3e-8);
    report.start_run();
    report.absolute(std::string("V09 (1,3,30,20), ") + c.what + ": largest relative change", 0.0,
                    change(toppling(c.frame, c.plane_last), reference_toppling), 3e-8);
  }
}

void paper_falling_block(Report& report) {
  // Cube turned 20 degrees about y against the plane, lowest vertex 2 m above it, restitution 0.3.
  report.start_run();
  const double angle = radians(20);
  const Frame slope{.rotation = turn(angle, Vector3::UnitY())};
  solver::Scene scene;
  scene.joint.friction_angle = radians(10);
  scene.joint.restitution = 0.3;
  scene.add_fixed(slope.place(geometry::make_box({-10, -5, -1}, {60, 5, 0})));
  // Level, it is turned by 20 degrees against the plane: the lower edge down-slope is lowest.
  const Vector3 low = slope.rotation * Vector3(0, 0, 2.0);
  scene.add_block(geometry::make_box(low - Vector3(0, 0.5, 0), low + Vector3(1, 0.5, 1)),
                  {.density = 2600, .young = 5e9, .poisson = 0.25});
  // Gaps are good to the tolerance times the block's size, 1 m.
  Simulation simulation(scene, {.time_step = 1e-3, .tolerance = 1e-12});
  const Vector3 start = state_of(simulation, 1).centroid;
  double flight = 0.0, overlap = 0.0, free_error = 0.0,
         largest = simulation.state().energy.mechanical();
  const double scale = 2600 * kGravity * 2.0;  // J, of the fall
  double growth = 0.0;
  bool free = true;
  while (simulation.state().time < 4.0 - 1e-9) {
    const solver::StepReport now = step(simulation);
    overlap = std::max(overlap, now.largest_overlap);
    free = free && now.closed_count == 0;
    if (free) {
      flight = simulation.state().time;
      const Vector3 exact(0, 0, -0.5 * kGravity * flight * flight);
      free_error = std::max(free_error, (state_of(simulation, 1).centroid - start - exact).norm());
    }
    const double energy = simulation.state().energy.mechanical();
    growth = std::max(growth, (energy - largest) / scale);
    largest = std::min(largest, energy);
  }
  // The lowest vertex falls 2/cos(20) m.
  report.absolute("free flight against g t^2/2 [m]", 0.0, free_error, 1e-11);
  report.absolute("time of impact [s]", std::sqrt(2.0 * 2.0 / std::cos(angle) / kGravity), flight,
                  1e-3);
  report.absolute("largest overlap [m]", 0.0, overlap, 1e-12);
  report.absolute("growth of energy / energy of the fall", 0.0, growth, 1e-6);
  report.at_least("down the slope after 4 s [m]", 2.0,
                  (slope.back(state_of(simulation, 1).centroid - start)).x());
}

namespace {

/// Four blocks in a row on a base, the first turned 14.5 degrees about its lower edge, past
/// balance, and turning on at `push` (rad/s). Without a push it comes to lean on the second; with 1
/// rad/s all fall.
solver::Scene five_blocks(double push) {
  solver::Scene scene;
  scene.joint.friction_angle = radians(10);
  const solver::Material rock{.density = 2700, .young = 3e9, .poisson = 0.2};
  scene.add_fixed(geometry::make_box({-3, -1, -1}, {3, 1, 0}), rock);
  for (int i = 0; i < 4; ++i) {
    Frame frame{.origin = Vector3(i - 1.3, 0, 0)};  // the lower edge
    if (i == 0) frame.rotation = turn(radians(14.5), Vector3::UnitY());
    scene.add_block(frame.place(geometry::make_box({-0.4, -0.5, 0}, {0, 0.5, 1.6})), rock);
  }
  const Vector3 spin(0, push, 0);
  const Vector3 arm = turn(radians(14.5), Vector3::UnitY()) * Vector3(-0.2, 0, 0.8);
  scene.blocks[1].angular_velocity = spin;
  scene.blocks[1].velocity = spin.cross(arm);
  return scene;
}

void fall(double push, const StepOptions& options, Report& report) {
  Simulation simulation(five_blocks(push), options);
  const double scale = 4 * 0.64 * 2700 * kGravity * 0.8;  // J: the weight of all from half height
  double overlap = 0.0, growth = 0.0, least = simulation.state().energy.mechanical();
  for (int i = 0; i < 5000; ++i) {
    overlap = std::max(overlap, step(simulation).largest_overlap);
    const double energy = simulation.state().energy.mechanical();
    growth = std::max(growth, (energy - least) / scale);
    least = std::min(least, energy);
  }
  int fallen = 0;
  for (int b = 1; b <= 4; ++b) {
    fallen += (state_of(simulation, b).rotation * Vector3::UnitZ()).z() < 0.9;
  }
  const std::string which = ", push " + text(push) + ", penalty " + text(options.penalty);
  report.absolute("largest overlap [m]" + which, 0.0, overlap, 2e-8);
  report.absolute("growth of energy / energy of the fall" + which, 0.0, growth, 1e-6);
  report.absolute("blocks that fell over" + which, push > 0.0 ? 4.0 : 0.0, fallen, 0.0);
}

}  // namespace

void paper_five_blocks(Report& report) {
  // No exact answer: no overlap, energy never grows, all fall. Augmented Lagrangian at both
  // penalties.
  for (const double penalty : {40e6, 20e6}) {
    for (const double push : {0.0, 1.0}) {
      report.attempt("push " + text(push) + ", penalty " + text(penalty), [&] {
        fall(push, {.time_step = 1e-3, .penalty = penalty, .max_displacement_ratio = 0.1}, report);
      });
    }
  }
}

}  // namespace quoin::validation
