/// V01–V06: blocks that slide, stop, curve and stay.

#include <cmath>

#include "cases.hpp"
#include "scenes.hpp"

namespace quoin::validation {
namespace {

using solver::Analysis;
using solver::ContactMethod;
using solver::Simulation;
using solver::StepOptions;

constexpr solver::Material kRock{.density = 2600, .young = 5e9, .poisson = 0.25};

/// s = g (sin - cos tan phi) t^2 / 2.
double slide_acceleration(double angle, double friction) {
  return kGravity * (std::sin(angle) - std::cos(angle) * std::tan(friction));
}

struct SlideRun {
  double friction_deg = 0.0;
  StepOptions options{.time_step = 0.01};
  bool settled = true;
  bool rigid = false;
  double allowed = 0.0;
};

/// The paper's example 5.1: s(1 s) … s(5 s) in m, and the largest overlap.
void slide(const SlideRun& run, Report& report) {
  report.start_run();
  const SlopeScene slope{.angle = radians(20),
                         .friction = radians(run.friction_deg),
                         .material = kRock,
                         .rigid = run.rigid};
  Simulation simulation(slope.scene(), run.options);
  if (run.settled) settle(simulation);
  const double acceleration = slide_acceleration(slope.angle, slope.friction);
  const double start = slope.displacement(simulation).x();
  double overlap = 0.0;
  const std::string which = ", phi " + text(run.friction_deg) + ", " + name(run.options) +
                            (run.settled ? ", settled" : ", sudden gravity") +
                            (run.rigid ? ", rigid" : "");
  const bool each_second =
      run.settled && !run.rigid && run.options.method == ContactMethod::AugmentedLagrangian;
  for (int t = 1; t <= 5; ++t) {
    overlap = std::max(overlap, run_for(simulation, 1.0));
    if (!each_second && t < 5) continue;
    report.relative("s(" + std::to_string(t) + " s) [m]" + which, 0.5 * acceleration * t * t,
                    slope.displacement(simulation).x() - start, run.allowed);
  }
  if (run.options.method != ContactMethod::Springs) {
    report.absolute("largest overlap [m]" + which, 0.0, overlap,
                    run.options.method == ContactMethod::Paper ? 2e-10 : 1e-12);
    return;
  }
  // Four springs carry W cos.
  const double sag = 2600 * kGravity * std::cos(slope.angle) / (4.0 * run.options.penalty);
  if (run.settled) {
    double end = 0.0;
    for (const solver::Contact& contact : simulation.state().contacts) end -= contact.point.gap;
    report.absolute("mean overlap at 5 s [m]" + which, sag, end / 4.0, 5e-11);
  }
}

}  // namespace

void v01_sliding_down_a_plane(Report& report) {
  const StepOptions exact{.time_step = 0.01};
  for (const double friction : {0.0, 10.0}) {
    slide({.friction_deg = friction, .options = exact, .allowed = friction > 0.0 ? 1e-6 : 1e-12},
          report);
    slide({.friction_deg = friction, .options = exact, .rigid = true, .allowed = 1e-12}, report);
    slide({.friction_deg = friction,
           .options = exact,
           .settled = false,
           .allowed = friction > 0.0 ? 2e-7 : 1e-12},
          report);
    for (const double penalty : {50e6, 500e6, 50e9}) {
      StepOptions options = exact;
      options.penalty = penalty;
      options.method = ContactMethod::Springs;
      // The case asks for no figure at the lowest penalty; frictionless the motion is exact at any.
      slide(
          {.friction_deg = friction, .options = options, .allowed = friction > 0.0 ? 2e-7 : 1e-12},
          report);
      options.method = ContactMethod::Paper;
      // Its solve is rounded like the stiffest spring, 4 Pn against 2 M/dt^2: 8e-13 of a step's
      // motion at 50 GN/m, at random over 500 steps.
      slide(
          {.friction_deg = friction, .options = options, .allowed = friction > 0.0 ? 2e-7 : 2e-11},
          report);
    }
  }
}

namespace {

/// Relative error of s(2 s) in example 5.1, from sudden gravity.
double slide_error(double friction_deg, bool rigid, const StepOptions& options) {
  const SlopeScene slope{
      .angle = radians(20), .friction = radians(friction_deg), .material = kRock, .rigid = rigid};
  Simulation simulation(slope.scene(), options);
  run_for(simulation, 2.0);
  const double exact = 2.0 * slide_acceleration(slope.angle, slope.friction);
  return slope.displacement(simulation).x() / exact - 1.0;
}

/// Mean overlap of a settled block on penalty springs, m.
double sag_on_springs(double penalty) {
  const SlopeScene slope{.angle = radians(20), .material = kRock};
  Simulation simulation(slope.scene(),
                        {.time_step = 0.01, .method = ContactMethod::Springs, .penalty = penalty});
  settle(simulation);
  double sum = 0.0;
  for (const solver::Contact& contact : simulation.state().contacts) sum -= contact.point.gap;
  return sum / static_cast<double>(simulation.state().contacts.size());
}

}  // namespace

void v01_converges(Convergence& convergence) {
  // The formula is of a rigid block: strain of its own weight, 5e-6, is beyond it, and steps that
  // resolve its vibration (below 5 ms) follow that.
  constexpr double kStrain = 2600 * kGravity / 5e9;
  convergence.halve_time_step({"s(2 s), phi 0, rel.", 0.08, 6, 0.0, 1e-12},
                              [](double dt) { return slide_error(0.0, false, {.time_step = dt}); });
  convergence.halve_time_step({"s(2 s), phi 10, rigid, rel.", 0.08, 6, 0.0, 1e-12},
                              [](double dt) { return slide_error(10.0, true, {.time_step = dt}); });
  convergence.halve_time_step({"s(2 s), phi 10, rel.", 0.08, 5, 0.0, kStrain}, [](double dt) {
    return slide_error(10.0, false, {.time_step = dt});
  });
  convergence.raise_penalty({"overlap on springs [m]", 1e6, 8, 1.0, 1e-13}, sag_on_springs);
  convergence.raise_penalty(
      {"s(2 s), phi 10, springs, rel.", 1e5, 6, 1.0, kStrain}, [](double penalty) {
        return slide_error(
            10.0, false, {.time_step = 0.01, .method = ContactMethod::Springs, .penalty = penalty});
      });
}

namespace {

/// Block at rest on 20 degrees under friction 30: forces at t = 10 s, drift between 1 s and 10 s.
void rest(Analysis analysis, const StepOptions& options, bool rigid, Report& report) {
  report.start_run();
  const SlopeScene slope{
      .angle = radians(20), .friction = radians(30), .material = kRock, .rigid = rigid};
  Simulation simulation(slope.scene(), options);
  settle(simulation, analysis);
  run_for(simulation, 1.0);
  const Vector3 early = slope.displacement(simulation);
  run_for(simulation, 9.0);
  const double drift = (slope.displacement(simulation) - early).norm();
  const Matrix3 axes = slope.slope_axes();
  double down = 0.0, up = 0.0;
  for (const solver::Contact& contact : simulation.state().contacts) {
    (axes.col(0).dot(contact.point.point_a) > 0.0 ? down : up) += contact.normal_force;
  }
  const double shear = -axes.col(0).dot(contact_force(simulation.state(), slope.block()));
  const double weight = 2600 * kGravity;
  const std::string which = ", " + name(options) +
                            (analysis == Analysis::Static ? ", static" : ", dynamic") +
                            (rigid ? ", rigid" : "");
  // Per vertex W cos/4 -+ W sin h/(4 b), h/2 the height of the centroid.
  const double mean = weight * std::cos(slope.angle) / 4.0;
  const double tilt = weight * std::sin(slope.angle) / 4.0;
  // The numbers are of a rigid block: strain of 1e-6 and the sag of springs shift the centroid.
  const double allowed = options.method == ContactMethod::Springs ? 5e-4 : rigid ? 1e-9 : 1e-5;
  report.relative("N per down-slope vertex [N]" + which, mean + tilt, down / 2.0, allowed);
  report.relative("N per up-slope vertex [N]" + which, mean - tilt, up / 2.0, allowed);
  report.relative("total shear [N]" + which, weight * std::sin(slope.angle), shear, allowed);
  report.absolute("drift from 1 s to 10 s [m]" + which, 0.0, drift, 1e-12);
}

/// A tenth of a degree under the friction angle: stays; over it: slides.
void near_the_friction_angle(Report& report) {
  report.start_run();
  SlopeScene slope{.angle = radians(20), .friction = radians(20.1), .material = kRock};
  Simulation holding(slope.scene(), {.time_step = 0.01});
  settle(holding);
  relax(holding, 200);
  const Vector3 start = slope.displacement(holding);
  run_for(holding, 10.0);
  report.absolute("creep in 10 s, slope 0.1 deg under phi [m]", 0.0,
                  (slope.displacement(holding) - start).norm(), 1e-12);
  report.start_run();
  slope.friction = radians(19.9);
  Simulation sliding(slope.scene(), {.time_step = 0.01});
  settle(sliding);
  relax(sliding, 20);
  const double from = slope.displacement(sliding).x();
  run_for(sliding, 2.0);
  report.relative("acceleration, slope 0.1 deg over phi [m/s2]",
                  slide_acceleration(slope.angle, slope.friction),
                  (slope.displacement(sliding).x() - from) / 2.0, 1e-11);
}

}  // namespace

void v02_at_rest_on_a_plane(Report& report) {
  StepOptions options{.time_step = 0.01};
  for (const Analysis analysis : {Analysis::Static, Analysis::Dynamic}) {
    options.method = ContactMethod::AugmentedLagrangian;
    rest(analysis, options, false, report);
    rest(analysis, options, true, report);
    options.method = ContactMethod::Springs;
    for (const double penalty : {50e6, 50e9}) {
      options.penalty = penalty;
      rest(analysis, options, false, report);
    }
  }
  near_the_friction_angle(report);
}

namespace {

void push(const StepOptions& options, double allowed, Report& report) {
  report.start_run();
  const solver::Material material{.density = 2000, .young = 100e6, .poisson = 0.3};
  solver::Scene scene;
  scene.add_fixed(geometry::make_box({0, 0, -2.5}, {5, 3.5, 0}));
  const Vector3 start(1.0, 2.5, 0.5);
  const Vector3 half(0.5, 0.5, 0.5);
  const int block = scene.add_block(geometry::make_box(start - half, start + half), material);
  scene.point_loads.push_back({block, start - Vector3(0.5, 0, 0), Vector3(500, 0, 0)});
  scene.point_loads.push_back({block, start + Vector3(0, 0.5, 0), Vector3(0, -250, 0)});
  Simulation simulation(scene, options);
  const double acceleration = std::hypot(500.0, 250.0) / 2000.0;
  double done = 0.0;
  for (const double t : {1.0, 2.0, 3.0, 4.0, 4.5}) {
    run_for(simulation, t - done);
    done = t;
    const Vector3 moved = simulation.state().blocks[1].centroid + simulation.state().origin - start;
    report.relative("S(" + text(t) + " s) [m], " + name(options), 0.5 * acceleration * t * t,
                    moved.head<2>().norm(), allowed);
    if (t < 4.5) continue;
    report.relative("x(4.5 s) [m], " + name(options), 0.125 * t * t, moved.x(), allowed);
    report.relative("y(4.5 s) [m], " + name(options), -0.0625 * t * t, moved.y(), allowed);
  }
}

}  // namespace

void v03_pushed_by_two_forces(Report& report) {
  push({.time_step = 0.01}, 1e-12, report);
  push({.time_step = 0.01, .method = ContactMethod::Paper, .penalty = 100e6}, 1e-12, report);
  push({.time_step = 0.01, .method = ContactMethod::Springs, .penalty = 100e6}, 1e-12, report);
}

void v03_converges(Convergence& convergence) {
  convergence.halve_time_step({"S(4.5 s), rel.", 0.1, 6, 0.0, 1e-12}, [](double dt) {
    Report report("V03");
    push({.time_step = dt}, 0.0, report);
    return report.rows().back().error;
  });
}

namespace {

struct Stop {
  double distance = 0.0, time = 0.0, backward = 0.0;
  double speed_after = 0.0;  ///< largest from two steps after the stop, m/s
  double base_speed = 0.0;   ///< likewise, of the corners of its base
  double speed_end = 0.0;    ///< 0.1 s after the stop, m/s
};

std::vector<Vector3> base_corners(const Simulation& simulation) {
  std::vector<Vector3> corners;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      corners.push_back(world_point(simulation.state(), 1, {x, y, -0.25}));
    }
  }
  return corners;
}

/// v0 = 2 m/s along the diagonal until rest, then 0.1 s more.
Stop stop_by_friction(const StepOptions& options, bool rigid) {
  const Vector3 along = Vector3(1, 1, 0).normalized();
  const SlopeScene slope{.friction = radians(20),
                         .size = {1, 1, 0.5},
                         .material = {.density = 2500, .young = 5e9, .poisson = 0.25},
                         .velocity = 2.0 * along,
                         .rigid = rigid};
  Simulation simulation(slope.scene(), options);
  settle(simulation);
  Stop stop;
  double farthest = 0.0, speed = 2.0;
  const double start = slope.displacement(simulation).dot(along);
  int steps_after = 0;
  std::vector<Vector3> base;
  while (steps_after * options.time_step < 0.1 && simulation.state().time < 2.0) {
    step(simulation);
    const double now = slope.block_velocity(simulation).dot(along);
    const double moved = slope.displacement(simulation).dot(along) - start;
    farthest = std::max(farthest, moved);
    stop.backward = std::max(stop.backward, farthest - moved);
    if (steps_after == 0 && now > 1e-3 * speed && now > 1e-6) {
      stop.time += options.time_step;
      speed = now;
      continue;
    }
    const std::vector<Vector3> corners = base_corners(simulation);
    if (++steps_after >= 2) {
      for (std::size_t i = 0; i < corners.size(); ++i) {
        stop.base_speed =
            std::max(stop.base_speed, (corners[i] - base[i]).norm() / options.time_step);
      }
      stop.speed_after = std::max(stop.speed_after, slope.block_velocity(simulation).norm());
    }
    base = corners;
  }
  stop.distance = slope.displacement(simulation).dot(along) - start;
  stop.speed_end = slope.block_velocity(simulation).norm();
  return stop;
}

}  // namespace

void v04_stopping_by_friction(Report& report) {
  const double mu = std::tan(radians(20));
  const double stop_time = 2.0 / (mu * kGravity);       // v0 / (mu g)
  const double distance = 4.0 / (2.0 * mu * kGravity);  // v0^2 / (2 mu g)
  StepOptions options{.time_step = 1e-3};
  for (const bool rigid : {false, true}) {
    for (const ContactMethod method :
         {ContactMethod::AugmentedLagrangian, ContactMethod::Springs}) {
      if (rigid && method == ContactMethod::Springs) continue;
      report.start_run();
      options.method = method;
      options.penalty = method == ContactMethod::Springs ? 1e9 : 0.0;
      const Stop stop = stop_by_friction(options, rigid);
      const std::string which = ", " + name(options) + (rigid ? ", rigid" : "");
      const bool springs = method == ContactMethod::Springs;
      report.relative("stop distance [m]" + which, distance, stop.distance, springs ? 1e-5 : 3e-6);
      report.absolute("stop time [s]" + which, stop_time, stop.time, 2e-3);
      report.absolute("motion backward [m]" + which, 0.0, stop.backward, springs ? 1e-5 : 2e-6);
      // The base stops. Above it an elastic block springs back by the strain that friction gave it,
      // and a joint of springs swings itself: they are asked 0.1 s later.
      if (!springs) {
        report.absolute("speed of the base from two steps after the stop [m/s]" + which, 0.0,
                        stop.base_speed, 1e-6);
      }
      const bool swings = springs || !rigid;
      report.absolute(std::string("speed ") + (swings ? "0.1 s" : "from two steps") +
                          " after the stop [m/s]" + which,
                      0.0, swings ? stop.speed_end : stop.speed_after, 1e-9);
    }
  }
}

void v04_converges(Convergence& convergence) {
  const double distance = 4.0 / (2.0 * std::tan(radians(20)) * kGravity);
  // Right at the largest step already: 6e-8 rigid, a tenth of the block's strain else.
  for (const bool rigid : {true, false}) {
    convergence.halve_time_step(
        {std::string("stop distance, rel.") + (rigid ? ", rigid" : ""), 8e-3, 5, 0.0, 1e-6},
        [&](double dt) {
          return stop_by_friction({.time_step = dt}, rigid).distance / distance - 1.0;
        });
  }
}

namespace {

/// Down the slope after 0.5 s of curved sliding, relative error.
double curved_error(double time_step) {
  const SlopeScene slope{.angle = radians(25),
                         .friction = radians(25),
                         .size = {0.5, 0.5, 0.1},
                         .material = {.density = 2500, .young = 5e9, .poisson = 0.25},
                         .velocity = {0, 3, 0}};
  Simulation simulation(slope.scene(), {.time_step = time_step});
  settle(simulation);
  const double start = slope.displacement(simulation).x();
  run_for(simulation, 0.5);
  return (slope.displacement(simulation).x() - start) / 0.3860466705806206 - 1.0;
}

}  // namespace

void v05_converges(Convergence& convergence) {
  convergence.halve_time_step({"down(0.5 s), rel.", 0.02, 8, 2.0, 1e-8}, curved_error);
}

void v05_curved_sliding(Report& report) {
  // Down the slope g sin = mu g cos: the speed lost to friction goes into v_down, so v + v_down =
  // v0. dv/dt = g sin (down - v/|v|), integrated to 1e-12 (8th order Runge-Kutta, 12 digits kept).
  struct Time {
    double t, down, across, v_down, v_across;
  };
  constexpr Time kExact[] = {
      {0.5, 0.3860466705806206, 1.0093393105683244, 1.2782668068312815, 1.1534293038665773},
      {1.0, 1.095885921569756, 1.3345996959605428, 1.4839664327350208, 0.3101635110563559},
      {2.0, 2.5929815629716573, 1.4401055328981276, 1.499935591925987, 0.01965829201352129},
      {4.0, 5.592969911339558, 1.4471898243286765, 1.499999998982641, 7.813429829629951e-05}};
  const SlopeScene slope{.angle = radians(25),
                         .friction = radians(25),
                         .size = {0.5, 0.5, 0.1},
                         .material = {.density = 2500, .young = 5e9, .poisson = 0.25},
                         .velocity = {0, 3, 0}};
  Simulation simulation(slope.scene(), {.time_step = 1e-3});
  settle(simulation);
  const Vector3 start = slope.displacement(simulation);
  double done = 0.0;
  for (const Time& exact : kExact) {
    run_for(simulation, exact.t - done);
    done = exact.t;
    const Vector3 moved = slope.displacement(simulation) - start;
    const Vector3 speed = slope.block_velocity(simulation);
    const std::string at = "(" + text(exact.t) + " s)";
    report.relative("down" + at + " [m]", exact.down, moved.x(), 2e-6);
    report.relative("across" + at + " [m]", exact.across, moved.y(), 2e-6);
    report.relative("v_down" + at + " [m/s]", exact.v_down, speed.x(), 2e-6);
    report.relative("v_across" + at + " [m/s]", exact.v_across, speed.y(),
                    exact.t > 3.0 ? 3e-4 : 2e-5);
  }
  const Vector3 side = simulation.state().blocks[1].rotation * Vector3::UnitY();
  report.absolute("yaw after 4 s [rad]", 0.0,
                  std::atan2(slope.slope_axes().col(0).dot(side), side.y()), 1e-6);
}

namespace {

struct Drag {
  double moved_a = 0.0, moved_b = 0.0, slip = 0.0;  ///< m
};

/// A on B on a frictionless floor, `force` at the centroid of B, after 0.5 s.
Drag drag(double force, bool rigid) {
  solver::Scene scene;
  scene.joint.friction_angle = radians(25);
  scene.pair_joints.push_back({.group_a = 0, .group_b = 1, .joint = {}});
  const solver::Material rock{.density = 2500, .young = 5e9, .poisson = 0.25};
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {20, 5, 0}), {.joint_group = 1});
  for (const geometry::Shape& shape : {geometry::make_box({-1.5, -0.5, 0}, {1.5, 0.5, 1}),
                                       geometry::make_box({-0.5, -0.5, 1}, {0.5, 0.5, 2})}) {
    rigid ? scene.add_rigid(shape, rock) : scene.add_block(shape, rock);
  }
  scene.point_loads.push_back({1, Vector3(0, 0, 0.5), Vector3(force, 0, 0)});
  Simulation simulation(scene, {.time_step = 1e-3});
  settle(simulation);
  relax(simulation, 10);
  const auto place = [&](std::size_t block) {
    return simulation.state().blocks[block].centroid.x();
  };
  const auto slip = [&] {  // of the middle of B's top against that of A's bottom
    return solver::world_point(simulation.state(), 1, {0, 0, 0.5}).x() -
           solver::world_point(simulation.state(), 2, {0, 0, -0.5}).x();
  };
  const double a = place(2), b = place(1), slipped = slip();
  run_for(simulation, 0.5);
  return {place(2) - a, place(1) - b, slip() - slipped};
}

}  // namespace

void v06_dragged_by_friction(Report& report) {
  const double mu = std::tan(radians(25)), t = 0.5;
  const double mass_a = 2500, mass_b = 7500;
  const double limit = mu * kGravity * (mass_a + mass_b);
  for (const bool rigid : {false, true}) {
    const std::string which = rigid ? ", rigid" : "";
    report.start_run();
    const Drag below = drag(0.9 * limit, rigid);
    const double together = 0.9 * limit / (mass_a + mass_b);
    report.relative("a of A at 0.9 F* [m/s2]" + which, together, 2.0 * below.moved_a / (t * t),
                    1e-10);
    report.relative("a of B at 0.9 F* [m/s2]" + which, together, 2.0 * below.moved_b / (t * t),
                    1e-10);
    report.absolute("slip at 0.9 F* [m]" + which, 0.0, below.slip, 1e-10);
    report.start_run();
    const Drag above = drag(1.5 * limit, rigid);
    const double exact_a = mu * kGravity, exact_b = (1.5 * limit - mu * mass_a * kGravity) / mass_b;
    report.relative("a of A at 1.5 F* [m/s2]" + which, exact_a, 2.0 * above.moved_a / (t * t),
                    1e-6);
    report.relative("a of B at 1.5 F* [m/s2]" + which, exact_b, 2.0 * above.moved_b / (t * t),
                    1e-6);
    report.relative("A relative to B at 0.5 s, 1.5 F* [m]" + which,
                    0.5 * (exact_b - exact_a) * t * t, above.moved_b - above.moved_a, 1e-6);
  }
}

}  // namespace quoin::validation
