/// V13–V15, V20: blocks on contact springs, at rest and swinging.

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "cases.hpp"
#include "scenes.hpp"

namespace quoin::validation {
namespace {

using solver::Analysis;
using solver::ContactMethod;
using solver::Simulation;
using solver::StepOptions;
using solver::TimeScheme;

/// Static steps until the unbalanced force is rounding.
void rest(Simulation& simulation) {
  constexpr int kMostSteps = 1000;
  for (int i = 0; i < kMostSteps; ++i) {
    if (step(simulation).unbalance <= 1e-14) return;
  }
}

double top(const Simulation& simulation, int block) {
  return simulation.vertices(block).row(2).maxCoeff();
}

constexpr solver::Material kSoft{.density = 2500, .young = 1e8, .poisson = 0.25};

solver::Scene column_scene(int count) {
  solver::Scene scene;
  scene.add_fixed(geometry::make_box({-1, -1, -1}, {2, 2, 0}));
  for (int i = 0; i < count; ++i) {
    scene.add_block(geometry::make_box({0, 0, 1.0 * i}, {1, 1, i + 1.0}), kSoft);
  }
  return scene;
}

void column(int count, const StepOptions& options, Report& report) {
  report.start_run();
  const double young = kSoft.young, spring = 1e9;
  Simulation simulation(column_scene(count), options);
  rest(simulation);
  const double weight = kSoft.density * kGravity;
  // The stack is exact for every N: top settlement rho g H^2/(2 E); four springs carry the weight
  // above.
  const double elastic = weight * count * count / (2.0 * young);
  const double joints = weight * 0.5 * count * (count + 1) / (4.0 * spring);
  const bool springs = options.method == ContactMethod::Springs;
  const std::string which = ", N=" + text(count) + ", " + name(options);
  const double settlement = count - top(simulation, count);
  report.relative("top settlement [m]" + which, springs ? elastic + joints : elastic, settlement,
                  1e-8);
  if (!springs) {
    report.absolute("joint part / that of springs" + which, 0.0, (settlement - elastic) / joints,
                    1e-7);
  }
  for (int i = count; i >= 1; --i) {
    const double exact = -weight * (count - i + 0.5);
    report.relative("vertical stress of block " + text(i) + " [Pa]" + which, exact,
                    simulation.stress(i)[2], 1e-8);
  }
  if (count > 1) return;
  const solver::Vector6 strain = simulation.state().blocks[1].strain;
  report.relative("vertical strain" + which, -weight / (2.0 * young), strain[2], 1e-8);
  report.relative("lateral strain" + which, 0.25 * weight / (2.0 * young), strain[0], 1e-8);
}

}  // namespace

void v13_column(Report& report) {
  for (const int count : {1, 5}) {
    StepOptions options{.time_step = 0.1, .analysis = Analysis::Static};
    column(count, options, report);
    options.method = ContactMethod::Springs;
    options.penalty = 1e9;
    column(count, options, report);
  }
}

void v13_converges(Convergence& convergence) {
  // Three blocks: springs add their own settlement to the column's, the exact contact adds none.
  constexpr int kCount = 3;
  const double elastic = 2500 * kGravity * kCount * kCount / (2.0 * 1e8);
  convergence.raise_penalty(
      {"top settlement against rigid joints, rel.", 1e7, 8, 1.0, 1e-9}, [=](double penalty) {
        Simulation simulation(column_scene(kCount), {.time_step = 0.1,
                                                     .analysis = Analysis::Static,
                                                     .method = ContactMethod::Springs,
                                                     .penalty = penalty});
        rest(simulation);
        return (kCount - top(simulation, kCount)) / elastic - 1.0;
      });
}

namespace {

using Pair = Eigen::Vector2d;  ///< (w, eps): rise of the centroid, m, and vertical strain

/// The 2 × 2 model: M d2x/dt2 + K x = F stepped with forces at the end (1) or middle (1/2) of the
/// step.
struct SpringModel {
  double mass = 2500.0, young = 1e9, stiffness = 1e8, time_step = 1e-3;
  Eigen::Matrix2d m, k;
  Pair force;
  SpringModel() {
    m << mass, 0, 0, mass / 12.0;
    k << stiffness, -0.5 * stiffness, -0.5 * stiffness, young + 0.25 * stiffness;
    force << -mass * kGravity, 0.0;
  }
  Pair at_rest() const { return k.inverse() * force; }
  std::pair<Pair, Pair> after(int steps, Pair x, double share) const {
    Pair v = Pair::Zero();
    const Eigen::Matrix2d inverse = (2.0 / (time_step * time_step) * m + share * k).inverse();
    for (int i = 0; i < steps; ++i) {
      const Pair d = inverse * (2.0 / time_step * (m * v) + force - k * x);
      x += d;
      v = 2.0 / time_step * d - v;
    }
    return {x, v};
  }
};

/// The cube of the model in its state `start`.
Simulation springs_at(const SpringModel& model, const Pair& start, TimeScheme scheme) {
  // It stands lower by its penetration and carries the stress of eps.
  const double bottom = start[0] - 0.5 * start[1];
  solver::Scene scene;
  scene.initial_overlap = solver::InitialOverlap::Keep;
  scene.add_fixed(geometry::make_box({-1, -1, -1}, {2, 2, 0}));
  scene.add_block(geometry::make_box({0, 0, bottom}, {1, 1, bottom + 1.0}),
                  {.density = model.mass, .young = model.young, .poisson = 0.0});
  scene.blocks[1].initial_stress[2] = model.young * start[1];
  return {scene,
          {.time_step = model.time_step,
           .method = ContactMethod::Springs,
           .scheme = scheme,
           .penalty = 0.25 * model.stiffness}};
}

void follow(const SpringModel& model, bool from_half, TimeScheme scheme, Report& report) {
  report.start_run();
  const Pair start = from_half ? Pair(0.5 * model.at_rest()) : Pair(Pair::Zero());
  Simulation simulation = springs_at(model, start, scheme);
  const Vector3 centroid = simulation.state().blocks[1].centroid;
  const bool middle = scheme == TimeScheme::EnergyMomentum;
  const std::string which = std::string(from_half ? "B" : "A") + (middle ? ", trapezoid" : "");
  int done = 0;
  for (const int count : {1, 2, 10, 50, 100, 200}) {
    run_for(simulation, (count - done) * model.time_step);
    done = count;
    const Pair exact = model.after(count, start, middle ? 0.5 : 1.0).first;
    const double w = start[0] + (simulation.state().blocks[1].centroid - centroid).z();
    const double eps = start[1] + simulation.state().blocks[1].strain[2];
    report.relative(which + ", w after step " + text(count) + " [m]", exact[0], w, 5e-11);
    report.relative(which + ", eps after step " + text(count), exact[1], eps, 5e-11);
  }
}

/// Rise of the centroid 0.05 s after half the static state against the motion in continuous time,
/// relative to the static state.
double swing_error(double time_step, TimeScheme scheme) {
  SpringModel model;
  model.time_step = time_step;
  constexpr double kTime = 0.05;  // s
  const Pair rest = model.at_rest(), start = 0.5 * rest;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> modes(model.k, model.m);
  const Pair cosines = (modes.eigenvalues().cwiseSqrt() * kTime).array().cos().matrix();
  const Pair exact =
      rest + modes.eigenvectors() *
                 cosines.cwiseProduct(modes.eigenvectors().transpose() * model.m * (start - rest));
  Simulation simulation = springs_at(model, start, scheme);
  const double from = simulation.state().blocks[1].centroid.z();
  run_for(simulation, kTime);
  return (start[0] + simulation.state().blocks[1].centroid.z() - from - exact[0]) / rest[0];
}

}  // namespace

void v14_converges(Convergence& convergence) {
  convergence.halve_time_step({"w(0.05 s) of the swing, rel.", 1e-3, 12, 1.0, 1e-9}, [](double dt) {
    return swing_error(dt, TimeScheme::ConstantAcceleration);
  });
  convergence.halve_time_step(
      {"w(0.05 s) of the swing, energy-momentum, rel.", 1e-3, 12, 2.0, 1e-9},
      [](double dt) { return swing_error(dt, TimeScheme::EnergyMomentum); });
}

void v14_time_scheme(Report& report) {
  const SpringModel model;
  follow(model, false, TimeScheme::ConstantAcceleration, report);
  follow(model, true, TimeScheme::ConstantAcceleration, report);
  follow(model, true, TimeScheme::EnergyMomentum, report);
}

namespace {

/// A rigid cube of 1000 kg on four springs of 2.5e7 N/m each: omega = sqrt(1e8/1000).
solver::Scene swinging_cube(double bottom) {
  solver::Scene scene;
  scene.add_fixed(geometry::make_box({-1, -1, -1}, {2, 2, 0}));
  scene.add_rigid(geometry::make_box({0, 0, bottom}, {1, 1, bottom + 1.0}), {.density = 1000});
  return scene;
}

const double kOmega = std::sqrt(1e8 / 1000.0);

StepOptions swinging_options(double omega_dt) {
  return {.time_step = omega_dt / kOmega, .method = ContactMethod::Springs, .penalty = 2.5e7};
}

struct Swing {
  double radius = 0.0;    ///< spectral radius of the step
  double omega_dt = 0.0;  ///< as the run reports it
  double damping = 0.0;   ///< damping ratio, as the run reports it
};

/// Largest root of x_{n+2} = trace x_{n+1} - determinant x_n fitted to four places of a run.
Swing swing(double omega_dt) {
  Simulation simulation(swinging_cube(0.0), swinging_options(omega_dt));
  const double sag = kGravity / (kOmega * kOmega);
  const double start = simulation.state().blocks[1].centroid.z();
  double x[4];
  Swing result;
  for (double& place : x) {
    place = simulation.state().blocks[1].centroid.z() - start + sag;
    const solver::StepReport now = step(simulation);
    result.omega_dt = now.stiffest_omega_dt;
    result.damping = now.numerical_damping;
  }
  Eigen::Matrix2d places;
  places << x[1], -x[0], x[2], -x[1];
  const Eigen::Vector2d fit = places.inverse() * Eigen::Vector2d(x[2], x[3]);
  const double half = 0.5 * fit[0], under = half * half - fit[1];
  result.radius = under < 0.0 ? std::sqrt(fit[1]) : std::abs(half) + std::sqrt(under);
  return result;
}

/// Rebound speed over impact speed of a fall from `height`, by the energy of the free flight after
/// it.
double restitution(double height, double omega_dt) {
  const StepOptions options = swinging_options(omega_dt);
  // Constant acceleration makes free flight exact: start two steps before the surface is reached.
  const double dt = options.time_step;
  const double fallen = dt * (std::floor(std::sqrt(2.0 * height / kGravity) / dt) - 2.0);
  const double bottom = height - 0.5 * kGravity * fallen * fallen;
  solver::Scene scene = swinging_cube(bottom);
  scene.blocks[1].velocity = Vector3(0, 0, -kGravity * fallen);
  Simulation simulation(scene, options);
  bool touched = false;
  for (;;) {
    const solver::StepReport now = step(simulation);
    touched = touched || now.closed_count > 0;
    if (touched && now.closed_count == 0) break;
  }
  const double speed = simulation.state().blocks[1].velocity.z();
  const double place = simulation.state().blocks[1].centroid.z() - 0.5;
  return std::sqrt((speed * speed + 2.0 * kGravity * place) / (2.0 * kGravity * height));
}

}  // namespace

void v15_algorithmic_damping(Report& report) {
  for (const double omega_dt : {0.01, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0}) {
    report.start_run();
    // x' = x + d, V' = 2 d - V, d = (2 V - Om^2 x)/(2 + Om^2): determinant 1/(1 + Om^2/2), half
    // trace (1 - Om^2/4) times that; complex roots below Om = 4, real ones above.
    const double d = 1.0 / (1.0 + 0.5 * omega_dt * omega_dt);
    const double half_trace = d * (1.0 - 0.25 * omega_dt * omega_dt);
    const double under = half_trace * half_trace - d;
    const double exact = under < 0.0 ? std::sqrt(d) : std::abs(half_trace) + std::sqrt(under);
    const Swing run = swing(omega_dt);
    report.relative("spectral radius at omega dt " + text(omega_dt), exact, run.radius,
                    omega_dt == 4.0 ? 1e-5 : 1e-8);
    if (omega_dt != 0.1) continue;
    // One corner spring against the cube's inertia there, 1/m + 2 (1/2)^2/(m/6) = 4/m: P/4 × 4/m.
    report.relative("omega dt that the run reports, at 0.1", omega_dt, run.omega_dt, 1e-9);
    report.relative("damping ratio that the run reports, at 0.1", 0.25 * omega_dt, run.damping,
                    1e-9);
  }
  // Mean over 40 heights 1.000 … 1.039 m of the scheme run by itself on one spring.
  constexpr std::pair<double, double> kRestitution[] = {{0.02, 0.9842745201162142},
                                                        {0.05, 0.9611651778364362},
                                                        {0.1, 0.9238674103101638},
                                                        {0.2, 0.8540718567993473}};
  for (const auto& [omega_dt, exact] : kRestitution) {
    report.start_run();
    double sum = 0.0;
    for (int i = 0; i < 40; ++i) sum += restitution(1.0 + 0.001 * i, omega_dt);
    report.relative("mean restitution of a drop at omega dt " + text(omega_dt), exact, sum / 40.0,
                    5e-4);
    report.relative("the same against exp(-pi Om/4)", std::exp(-0.25 * std::numbers::pi * omega_dt),
                    sum / 40.0, 3e-3);
  }
}

void v15_converges(Convergence& convergence) {
  convergence.halve_time_step(
      {"1 - mean restitution of a drop on springs", 0.4 / kOmega, 6, 1.0, 0.0}, [](double dt) {
        constexpr int kDrops = 20;
        double sum = 0.0;
        for (int i = 0; i < kDrops; ++i) {
          sum += restitution(1.0 + 0.002 * i, dt * kOmega);
        }
        return 1.0 - sum / kDrops;
      });
}

void v20_elastic_foundation(Report& report) {
  const double spring = 1e8, force = 1e4, weight = 2500 * kGravity;
  solver::Scene scene;
  scene.add_fixed(geometry::make_box({-2, -2, -1}, {2, 2, 0}));
  scene.add_block(geometry::make_box({-0.5, -0.5, 0}, {0.5, 0.5, 1}),
                  {.density = 2500, .young = 1e13, .poisson = 0.25});
  scene.point_loads.push_back({1, Vector3(0.2, 0.1, 1), Vector3(0, 0, -force)});
  Simulation simulation(scene, {.time_step = 0.1,
                                .analysis = Analysis::Static,
                                .method = ContactMethod::Springs,
                                .penalty = spring});
  rest(simulation);
  for (const solver::Contact& contact : simulation.state().contacts) {
    const Vector3& p = contact.point.point_a;
    const double x = p.x() > 0.0 ? 0.5 : -0.5, y = p.y() > 0.0 ? 0.5 : -0.5;
    // (W + F)/4 + F (e_x x + e_y y) / sum x^2, sum x^2 = 1 m2.
    report.relative("N at vertex (" + text(x) + "," + text(y) + ") [N]",
                    0.25 * (weight + force) + force * (0.2 * x + 0.1 * y), contact.normal_force,
                    3e-4);
  }
  const solver::BlockState& now = simulation.state().blocks[1];
  const double sink = 0.5 - (now.centroid + simulation.state().origin).z();
  report.relative("settlement of the middle of the base [m]", (weight + force) / (4.0 * spring),
                  sink, 1e-4);
  const Vector3 up = now.rotation * Vector3::UnitZ();
  report.relative("tilt towards x [rad]", force * 0.2 / spring, up.x(), 1e-3);
  report.relative("tilt towards y [rad]", force * 0.1 / spring, up.y(), 1e-3);
}

}  // namespace quoin::validation
