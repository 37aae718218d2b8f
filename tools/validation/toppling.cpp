/// V07–V10: cohesion, wedge, toppling, rocking.

#include <cmath>
#include <limits>
#include <sstream>

#include "cases.hpp"
#include "scenes.hpp"

namespace quoin::validation {
namespace {

using solver::Analysis;
using solver::Simulation;
using solver::StepOptions;

}  // namespace

void v07_cohesion(Report& report) {
  const double angle = radians(35), mu = std::tan(radians(20));
  const double density = 2500, side = 2.0, height = 1.0;
  const double weight = density * kGravity * side * side * height;
  // Whole face: c* = rho g h (sin - cos tan phi). Up-slope vertices: N = W cos/4 - W sin h/(4 b),
  // and a quarter of the shear and of the area each.
  const double whole = density * kGravity * height * (std::sin(angle) - std::cos(angle) * mu);
  const double up_slope = 0.25 * weight * (std::cos(angle) - std::sin(angle) * height / side);
  const double vertex = (0.25 * weight * std::sin(angle) - mu * up_slope) / (0.25 * side * side);
  for (const double cohesion : {1.02 * vertex, 0.98 * whole}) {
    report.start_run();
    const SlopeScene slope{.angle = angle,
                           .friction = radians(20),
                           .size = {side, side, height},
                           .material = {.density = density, .young = 5e9, .poisson = 0.25}};
    solver::Scene scene = slope.scene();
    scene.joint.cohesion = cohesion;  // residual 0: brittle, each vertex for itself
    Simulation simulation(scene, {.time_step = 1e-3});
    settle(simulation);
    const double start = slope.displacement(simulation).x();
    const double t = 1.0;
    run_for(simulation, t);
    const double moved = slope.displacement(simulation).x() - start;
    if (cohesion > whole) {
      report.absolute("motion in 1 s at 1.02 c_v [m]", 0.0, moved, 1e-10);
    } else {
      const double exact = kGravity * (std::sin(angle) - std::cos(angle) * mu);
      report.relative("a at 0.98 c* [m/s2]", exact, 2.0 * moved / (t * t), 2e-4);
    }
  }
}

namespace {

/// The half-space under a joint, as a slab: its face holds the apex and two more vertices of the
/// wedge.
geometry::Shape slab_under(const Vector3& p, const Vector3& q, const Vector3& inside) {
  Vector3 normal = p.cross(q).normalized();
  if (normal.dot(inside) > 0.0) normal = -normal;  // away from the wedge
  const Vector3 along = p.normalized(), across = normal.cross(along);
  const Vector3 middle = (p + q) / 3.0;
  geometry::Points polygon(3, 4);
  polygon << middle - 20.0 * along - 20.0 * across, middle + 20.0 * along - 20.0 * across,
      middle + 20.0 * along + 20.0 * across, middle - 20.0 * along + 20.0 * across;
  return geometry::make_prism(polygon, 5.0 * normal);
}

/// Upward unit normal of a plane by dip and dip direction; x east, y north.
Vector3 plane_normal(double dip, double direction) {
  return {std::sin(dip) * std::sin(direction), std::sin(dip) * std::cos(direction), std::cos(dip)};
}

struct Wedge {
  geometry::Points vertices{3,
                            4};  ///< apex, then the crest at the line of intersection, two corners
  double plunge = 0.0;           ///< of the line of intersection, rad
  double half_angle = 0.0;       ///< xi/2 between the joints
  double slope = 0.0;            ///< beta: of the bisector against the vertical
};

/// Joints 50/130 and 50/230, face 70/180, top horizontal at 10 m, apex at the origin.
Wedge make_wedge() {
  const Vector3 a = plane_normal(radians(50), radians(130));
  const Vector3 b = plane_normal(radians(50), radians(230));
  const Vector3 face = plane_normal(radians(70), radians(180));
  const auto meet_top = [](const Vector3& n, const Vector3& m) {
    Vector3 line = n.cross(m);
    return Vector3(line * (10.0 / line.z()));
  };
  Wedge wedge;
  wedge.vertices << Vector3::Zero(), meet_top(a, b), meet_top(a, face), meet_top(b, face);
  const Vector3 line = meet_top(a, b).normalized();
  wedge.plunge = std::asin(line.z());
  wedge.half_angle = 0.5 * std::acos(-a.dot(b));
  return wedge;
}

struct WedgeRun {
  double slip = 0.0;          ///< after 1 s, m
  double acceleration = 0.0;  ///< between slips of 0.1 m and 0.3 m, m/s2
  Vector3 direction = Vector3::Zero();
};

WedgeRun slide_wedge(double friction, double most_slip) {
  const Wedge wedge = make_wedge();
  const Vector3 crest = wedge.vertices.col(1);
  solver::Scene scene;
  scene.joint.friction_angle = friction;
  const Vector3 inside = wedge.vertices.rowwise().mean();
  scene.add_fixed(slab_under(crest, wedge.vertices.col(2), inside));
  scene.add_fixed(slab_under(crest, wedge.vertices.col(3), inside));
  const int block = scene.add_block(geometry::make_hull(wedge.vertices).polyhedron,
                                    {.density = 2600, .young = 50e9, .poisson = 0.25});
  Simulation simulation(scene, {.time_step = 2e-3});
  settle(simulation);
  relax(simulation, 20);
  const auto now = [&]() -> const solver::BlockState& {
    return simulation.state().blocks[static_cast<std::size_t>(block)];
  };
  const Vector3 start = now().centroid;
  const double settled = simulation.state().time;
  double time_before = 0.0, speed_before = 0.0;
  WedgeRun run;
  while (simulation.state().time - settled < 2.0) {
    step(simulation);
    const double time = simulation.state().time - settled;
    const double slip = (now().centroid - start).norm();
    if (time <= 1.0 + 1e-9) run.slip = slip;
    if (slip >= 0.1 && time_before == 0.0) {
      time_before = time;
      speed_before = now().velocity.norm();
    }
    if (slip >= most_slip || (time_before == 0.0 && time > 1.0 && slip < 1e-3)) break;
  }
  const double time = simulation.state().time - settled;
  run.acceleration = (now().velocity.norm() - speed_before) / (time - time_before);
  run.direction = (now().centroid - start).normalized();
  return run;
}

}  // namespace

void v08_wedge(Report& report) {
  const Wedge wedge = make_wedge();
  const Vector3 down = -Vector3(wedge.vertices.col(1)).normalized();
  // The normal forces balance the weight across the line: N (each) = m g cos psi / (2 sin(xi/2))
  // for joints that stand symmetric to the vertical plane; a = g sin psi - 2 N tan phi / m.
  const double normal = kGravity * std::cos(wedge.plunge) / (2.0 * std::sin(wedge.half_angle));
  const double driving = kGravity * std::sin(wedge.plunge);
  const double friction_at_one = std::atan(driving / (2.0 * normal));
  for (const double degrees : {30.0, 0.0}) {
    report.start_run();
    const WedgeRun run = slide_wedge(radians(degrees), 0.3);
    const double exact = driving - 2.0 * normal * std::tan(radians(degrees));
    report.relative("a after 0.1 m, phi " + text(degrees) + " [m/s2]", exact, run.acceleration,
                    1e-6);
    report.absolute("direction against the line, phi " + text(degrees) + " [rad]", 0.0,
                    run.direction.cross(down).norm(), 1e-6);
  }
  report.start_run();
  report.absolute("motion in 1 s, phi 35 [m]", 0.0, slide_wedge(radians(35), 0.3).slip, 1e-9);
  report.start_run();
  double slides = radians(31), holds = radians(33);
  while (holds - slides > radians(0.02)) {
    const double middle = 0.5 * (slides + holds);
    (slide_wedge(middle, 1e-3).slip < 1e-4 ? holds : slides) = middle;
  }
  report.absolute("phi at FS = 1 by strength reduction [rad]", friction_at_one,
                  0.5 * (slides + holds), radians(0.05));
}

namespace {

enum class Regime { Stable, Slide, Topple, SlideAndTopple };

struct Chart {
  Regime regime = Regime::Stable;
  double down = 0.0;   ///< m/s2, of the centroid along the slope
  double alpha = 0.0;  ///< rad/s2
};

/// First motion of a block b × h on a slope, with the dynamic boundary. [Sagaseta 1986]
Chart first_motion(double b, double h, double theta, double phi, double g) {
  const double mu = std::tan(phi);
  if (std::tan(theta) <= b / h && phi >= theta) return {};
  if (mu < std::tan(theta) && mu <= b / h) {
    return {Regime::Slide, g * (std::sin(theta) - std::cos(theta) * mu), 0.0};
  }
  const double pivot = 1.5 * g * (h * std::sin(theta) - b * std::cos(theta)) / (b * b + h * h);
  const double needed =
      (g * std::sin(theta) - 0.5 * pivot * h) / (g * std::cos(theta) + 0.5 * pivot * b);
  if (mu >= needed) return {Regime::Topple, 0.5 * pivot * h, pivot};
  // The toe slides with mu N and the block turns: N = m (g cos + alpha b/2), I alpha = N (mu h -
  // b)/2.
  const double lever = 0.5 * (mu * h - b), inertia = (b * b + h * h) / 12.0;
  const double alpha = g * std::cos(theta) * lever / (inertia - 0.5 * b * lever);
  const double normal = g * std::cos(theta) + 0.5 * alpha * b;
  return {Regime::SlideAndTopple, g * std::sin(theta) - mu * normal, alpha};
}

Regime observed(double down, double alpha, double slip) {
  const bool turns = alpha > 1e-3, slides = slip > 1e-2;  // rad/s2, m/s2
  if (turns) return slides ? Regime::SlideAndTopple : Regime::Topple;
  return down > 1e-3 ? Regime::Slide : Regime::Stable;
}

/// Turn of block 1 about y, rad.
double tilt_of(const Simulation& simulation) {
  const Eigen::AngleAxisd turned(simulation.state().blocks[1].rotation);
  return turned.angle() * turned.axis().y();
}

struct ChartPoint {
  double b, h, theta, phi, g;
};

/// Means over the first 0.05 s from rest. The contacts settle under the part of gravity that
/// presses the block on the plane. A block that can rest then does so under all of it; another
/// takes one static step, which strains it and moves it by a quarter of a percent at most.
void chart_point(const ChartPoint& p, bool rigid, Report& report) {
  report.start_run();
  const SlopeScene slope{.angle = radians(p.theta),
                         .friction = radians(p.phi),
                         .size = {p.b, 1, p.h},
                         .material = {.density = 2600, .young = 10e9, .poisson = 0.25},
                         .gravity = p.g,
                         .rigid = rigid};
  solver::Scene scene = slope.scene();
  const Vector3 full = scene.gravity.at(0.0), normal = slope.slope_axes().col(2);
  double release = std::numeric_limits<double>::infinity();
  scene.gravity = std::function<Vector3(double)>([&release, full, normal](double t) -> Vector3 {
    return t >= release ? full : Vector3(full.dot(normal) * normal);
  });
  Simulation simulation(scene, {.time_step = 1e-3});
  settle(simulation);
  release = simulation.state().time;
  std::stringstream settled;
  simulation.save(settled);
  if (relax(simulation, 200) == solver::StaticVerdict::Mechanism) {
    simulation.load(settled);
    relax(simulation, 1);
  }
  const Vector3 start = slope.displacement(simulation);
  const double tilted = tilt_of(simulation);
  const Vector3 toe_arm = slope.slope_axes() * Vector3(0.5 * p.b, 0, -0.5 * p.h);
  const auto toe = [&] {
    return slope.slope_axes().col(0).dot(solver::world_point(simulation.state(), 1, toe_arm));
  };
  const double toe_start = toe();
  const double t = 0.05;
  run_for(simulation, t);
  const double down = 2.0 * (slope.displacement(simulation) - start).x() / (t * t);
  const double alpha = 2.0 * (tilt_of(simulation) - tilted) / (t * t);
  const Chart exact = first_motion(p.b, p.h, slope.angle, slope.friction, p.g);
  const std::string which = " b=" + text(p.b) + " h=" + text(p.h) + " theta=" + text(p.theta) +
                            " phi=" + text(p.phi) + (rigid ? ", rigid" : "");
  report.absolute(
      "regime (0 stable, 1 slide, 2 topple, 3 both)" + which, static_cast<double>(exact.regime),
      static_cast<double>(observed(down, alpha, 2.0 * (toe() - toe_start) / (t * t))), 0.0);
  if (exact.down > 0.0) report.relative("a_down [m/s2]" + which, exact.down, down, 0.02);
  if (exact.alpha > 0.0) report.relative("alpha [rad/s2]" + which, exact.alpha, alpha, 0.02);
}

}  // namespace

void v09_sliding_and_toppling(Report& report) {
  constexpr ChartPoint kPoints[] = {
      {1, 1, 20, 30, kGravity}, {1, 1, 30, 20, kGravity}, {1, 3, 20, 45, kGravity},
      {1, 3, 30, 20, kGravity}, {1, 3, 15, 30, kGravity}, {1, 2, 40, 40, kGravity},
      {10, 10, 40, 40.1, 10},   {10, 5, 40, 20, 10},      {10, 25, 40, 40, 10}};
  for (const ChartPoint& point : kPoints) {
    chart_point(point, false, report);
    chart_point(point, true, report);
  }
}

namespace {

struct Rocking {
  double time = 0.0, rate = 0.0, ratio = 0.0, rebound = 0.0;
};

/// Block 1×1×4 m released at alpha/2 on its edge, until its first rebound is over.
Rocking rock(double time_step, bool rigid) {
  const double theta0 = 0.5 * std::atan(0.25);
  solver::Scene scene;
  scene.joint.friction_angle = radians(45);
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  Frame tilted{.rotation = turn(theta0, Vector3::UnitY())};  // about the edge in the origin
  const geometry::Shape shape = tilted.place(geometry::make_box({-1, -0.5, 0}, {0, 0.5, 4}));
  const solver::Material material{.density = 2500, .young = 50e9, .poisson = 0.25};
  rigid ? scene.add_rigid(shape, material) : scene.add_block(shape, material);
  Simulation simulation(scene, {.time_step = time_step});
  const auto angle = [&] { return theta0 + tilt_of(simulation); };
  const auto rate = [&] { return -simulation.state().blocks[1].angular_velocity.y(); };
  Rocking result;
  double time = 0.0, tilt = theta0, rate_before = 0.0, slope = 0.0;
  while (time < 2.0) {
    step(simulation);
    const double now = angle(), spin = rate();
    if (result.time == 0.0 && (now <= 1e-9 || spin < rate_before)) {
      // Impact inside this step: the last free state carried on with its own acceleration.
      const double discriminant = rate_before * rate_before + 2.0 * slope * tilt;
      const double left = (std::sqrt(discriminant) - rate_before) / slope;
      result.time = time + left;
      result.rate = rate_before + slope * left;
      // Past upright the weight brings it back: the same acceleration with the other sign.
      result.ratio = (spin + slope * (time_step - left)) / result.rate;
    }
    time += time_step;
    if (result.time > 0.0) {
      result.rebound = std::max(result.rebound, -now);
      if (spin < 0.0 && time > result.time + 0.1) break;
    }
    slope = (spin - rate_before) / time_step;
    tilt = now;
    rate_before = spin;
  }
  return result;
}

}  // namespace

namespace {

/// I theta'' = -m g R sin(alpha - theta), alpha = atan(1/4), R = sqrt(0.5^2 + 2^2), p^2 = 3 g/(4
/// R).
Rocking exact_rocking() {
  const double alpha = std::atan(0.25), theta0 = 0.5 * alpha, radius = std::hypot(0.5, 2.0);
  const double p = std::sqrt(0.75 * kGravity / radius);
  Rocking exact;
  exact.time = 0.6983432039079103;  // by quadrature, checked against the ODE to 1e-9 s
  exact.rate = p * std::sqrt(2.0 * (std::cos(alpha - theta0) - std::cos(alpha)));
  exact.ratio = 1.0 - 1.5 * std::sin(alpha) * std::sin(alpha);  // [Housner 1963]
  const double rise = exact.ratio * exact.rate / p;
  exact.rebound = alpha - std::acos(std::cos(alpha) + 0.5 * rise * rise);
  return exact;
}

}  // namespace

void v10_rocking(Report& report) {
  const Rocking exact = exact_rocking();
  for (const bool rigid : {false, true}) {
    report.start_run();
    const Rocking run = rock(1e-3, rigid);
    const std::string which = rigid ? ", rigid" : "";
    report.relative("time to first impact [s]" + which, exact.time, run.time, 1e-5);
    report.relative("rate at impact [rad/s]" + which, exact.rate, run.rate, 1e-5);
    report.relative("rate ratio" + which, exact.ratio, run.ratio, 5e-4);
    report.relative("first rebound angle [rad]" + which, exact.rebound, run.rebound, 1e-3);
  }
}

void v10_converges(Convergence& convergence) {
  const Rocking exact = exact_rocking();
  convergence.halve_time_step({"time to first impact, rigid, rel.", 0.02, 9, 2.0, 1e-8},
                              [&](double dt) { return rock(dt, true).time / exact.time - 1.0; });
  // Below 1e-6 the hundredth of a sub-step that is left before its impact tells: first order.
  convergence.halve_time_step(
      {"first rebound angle, rigid, rel.", 0.02, 9, 2.0, 1e-6},
      [&](double dt) { return rock(dt, true).rebound / exact.rebound - 1.0; });
}

}  // namespace quoin::validation
