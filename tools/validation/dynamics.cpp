/// V11, V12, V18, V19, V22: free motion, prescribed motion, impact.

#include <cmath>
#include <numbers>

#include "cases.hpp"
#include "scenes.hpp"

namespace quoin::validation {
namespace {

using solver::ContactMethod;
using solver::Simulation;
using solver::StepOptions;
using solver::TimeScheme;

double volume(const Simulation& simulation, int block) {
  geometry::Shape now = *simulation.scene().blocks[static_cast<std::size_t>(block)].shape;
  now.set_vertices(simulation.vertices(block));
  return geometry::mass_properties(now).volume;
}

/// Volume factor of the block's elastic strain (centrifugal, real): what is beyond it is the
/// method's.
double dilation(const Simulation& simulation, int block) {
  const solver::Vector6& strain = simulation.state().blocks[static_cast<std::size_t>(block)].strain;
  return (Matrix3::Identity() + strain_matrix(strain)).determinant();
}

struct Tumble {
  Vector3 spin = Vector3::Zero();  ///< body axes, rad/s
  Matrix3 rotation = Matrix3::Identity();
  double energy = 0.0, volume = 0.0;  ///< volume / volume at the start - det(I + strain)
  Vector3 momentum = Vector3::Zero();
};

Tumble tumble(double time_step, TimeScheme scheme, bool rigid = false) {
  solver::Scene scene;
  scene.gravity = Vector3(0, 0, 0);
  const geometry::Shape shape = geometry::make_box({-1.5, -1, -0.5}, {1.5, 1, 0.5});
  const solver::Material material{.density = 2000, .young = 50e9, .poisson = 0.25};
  rigid ? scene.add_rigid(shape, material) : scene.add_block(shape, material);
  scene.blocks[0].angular_velocity = Vector3(2, 0, 5);
  Simulation simulation(scene, {.time_step = time_step, .scheme = scheme});
  run_for(simulation, 3.0);
  const solver::BlockState& now = simulation.state().blocks[0];
  return {now.angular_velocity, now.rotation.toRotationMatrix(), simulation.state().energy.kinetic,
          volume(simulation, 0) / 6.0 - dilation(simulation, 0), momentum(simulation).angular};
}

}  // namespace

void v11_tumbling(Report& report) {
  // Euler's equations with J = (5000, 10000, 13000) kg m2 from W = (2, 0, 5) rad/s: Jacobi elliptic
  // functions, checked by an 8th order Runge-Kutta method at 1e-12; body axes, t = 3 s.
  const Vector3 spin(-1.5228265234906748, -1.4971080474715124, 4.891056766720909);
  Matrix3 rotation;
  rotation << -0.966585057505674, -0.2556651152313199, -0.01867285357167533,  //
      0.25439533058123726, -0.9477118246624563, -0.19267930136218825,         //
      0.03156489165538677, -0.19099122034458516, 0.981084100047529;
  const Vector3 angular(10000, 0, 65000);
  for (const TimeScheme scheme : {TimeScheme::ConstantAcceleration, TimeScheme::EnergyMomentum}) {
    report.start_run();
    const Tumble run = tumble(1e-3, scheme);
    const std::string which = scheme == TimeScheme::EnergyMomentum ? ", energy-momentum" : "";
    for (int i = 0; i < 3; ++i) {
      report.relative("omega_" + std::string(1, "xyz"[i]) + "(3 s) body [rad/s]" + which, spin[i],
                      run.spin[i], scheme == TimeScheme::EnergyMomentum ? 1e-3 : 5e-5);
    }
    report.absolute("rotation(3 s), largest difference of an entry" + which, 0.0,
                    (run.rotation - rotation).cwiseAbs().maxCoeff(), 2e-4);
    report.relative("kinetic energy [J]" + which, 172500.0, run.energy, 3e-6);
    report.absolute("angular momentum, change / size" + which, 0.0,
                    (run.momentum - angular).norm() / angular.norm(), 1e-11);
    report.absolute("volume factor beyond elastic strain's" + which, 0.0, run.volume, 1e-13);
  }
  report.start_run();
  const double coarse = (tumble(2e-3, TimeScheme::ConstantAcceleration).spin - spin).norm();
  const double fine = (tumble(1e-3, TimeScheme::ConstantAcceleration).spin - spin).norm();
  report.at_least("order of omega(3 s), dt 2e-3 to 1e-3", 1.9, std::log2(coarse / fine));
}

void v11_converges(Convergence& convergence) {
  const Vector3 spin(-1.5228265234906748, -1.4971080474715124, 4.891056766720909);
  for (const TimeScheme scheme : {TimeScheme::ConstantAcceleration, TimeScheme::EnergyMomentum}) {
    const std::string which = scheme == TimeScheme::EnergyMomentum ? ", energy-momentum" : "";
    convergence.halve_time_step(
        {"omega(3 s), rigid" + which + ", rel.", 0.01, 10, 2.0, 1e-11},
        [&](double dt) { return (tumble(dt, scheme, true).spin - spin).norm() / spin.norm(); });
  }
}

void v12_converges(Convergence& convergence) {
  convergence.halve_time_step(
      {"volume factor of a tumbling block less elastic strain's", 0.02, 6, 0.0, 1e-12},
      [](double dt) { return tumble(dt, TimeScheme::ConstantAcceleration).volume; });
}

void v12_spinning(Report& report) {
  for (const double time_step : {1e-3, 1e-2}) {
    report.start_run();
    solver::Scene scene;
    scene.gravity = Vector3(0, 0, 0);
    scene.add_block(geometry::make_box({-1.5, -1, -0.5}, {1.5, 1, 0.5}),
                    {.density = 2000, .young = 50e9, .poisson = 0.25});
    scene.blocks[0].angular_velocity = Vector3(0, 0, 10);
    Simulation simulation(scene, {.time_step = time_step});
    run_for(simulation, 1.0);
    report.relative("volume factor after 1 s less elastic strain's, dt " + text(time_step), 1.0,
                    1.0 + volume(simulation, 0) / 6.0 - dilation(simulation, 0), 1e-12);
  }
  report.start_run();
  solver::Scene rigid;
  rigid.gravity = Vector3(0, 0, 0);
  rigid.add_rigid(geometry::make_box({-1.5, -1, -0.5}, {1.5, 1, 0.5}), {.density = 2000});
  rigid.blocks[0].angular_velocity = Vector3(0, 0, 10);
  Simulation turning(rigid, {.time_step = 1e-3});
  run_for(turning, 1.0);
  report.relative("volume factor after 1 s, rigid", 1.0, volume(turning, 0) / 6.0, 1e-12);
  // Centrifugal stress of one block of constant strain: V E eps = W^2 (S_xx, S_yy, 0), S = rho a^2
  // V/12 (virtual work with the strain modes).
  report.start_run();
  const double young = 1e9, spin = 10.0, density = 2000.0;
  solver::Scene scene;
  scene.gravity = Vector3(0, 0, 0);
  scene.add_block(geometry::make_box({-1.5, -1, -0.5}, {1.5, 1, 0.5}),
                  {.density = density, .young = young, .poisson = 0.25});
  scene.blocks[0].angular_velocity = Vector3(0, 0, spin);
  Simulation simulation(scene, {.time_step = 1e-3});
  run_for(simulation, 0.5);  // the scheme damps the swing of the start
  const solver::Vector6 strain = simulation.state().blocks[0].strain;
  const double now = simulation.state().blocks[0].angular_velocity.z();
  const double sx = density * 9.0 / 12.0 * now * now, sy = density * 4.0 / 12.0 * now * now;
  report.relative("centrifugal strain xx", (sx - 0.25 * sy) / young, strain[0], 1e-6);
  report.relative("centrifugal strain yy", (sy - 0.25 * sx) / young, strain[1], 1e-6);
  report.relative("centrifugal strain zz", -0.25 * (sx + sy) / young, strain[2], 1e-6);
}

namespace {

/// Relative motion: stick while |a| <= mu g, then relative acceleration -a -+ mu g; events by root
/// finding, checked against 4e5 explicit steps.
constexpr std::pair<double, double> kShaken[] = {{0.5, -0.09652210986655502},
                                                 {1.0, -0.009414198566287169},
                                                 {2.0, -0.009414198566287224},
                                                 {3.0, -0.009414198566287224}};

/// Displacement against the table at the times of kShaken up to `end`, m.
std::vector<double> shake(double time_step, bool rigid, double end) {
  solver::Scene scene;
  scene.joint.friction_angle = std::atan(0.3);
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  scene.blocks[0].kind = solver::BlockKind::Prescribed;
  double release = std::numeric_limits<double>::infinity();
  scene.blocks[0].motion = {
      solver::MotionKind::Acceleration,
      std::function<Vector3(double)>([&release](double t) -> Vector3 {
        const double shaking = t - release;
        return {shaking > 0.0 ? 5.0 * std::sin(2.0 * std::numbers::pi * shaking) : 0.0, 0, 0};
      })};
  const geometry::Shape shape = geometry::make_box({-0.5, -0.5, 0}, {0.5, 0.5, 0.5});
  const solver::Material material{.density = 2500, .young = 5e9, .poisson = 0.25};
  rigid ? scene.add_rigid(shape, material) : scene.add_block(shape, material);
  Simulation simulation(scene, {.time_step = time_step});
  settle(simulation);
  release = simulation.state().time;
  const auto relative = [&] {
    return simulation.state().blocks[1].centroid.x() - simulation.state().blocks[0].centroid.x();
  };
  const double start = relative();
  double done = 0.0;
  std::vector<double> moved;
  for (const auto& [time, exact] : kShaken) {
    if (time > end) break;
    run_for(simulation, time - done);
    done = time;
    moved.push_back(relative() - start);
  }
  return moved;
}

}  // namespace

void v18_shaking_table(Report& report) {
  const std::vector<double> moved = shake(1e-3, false, 3.0);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    report.absolute("relative displacement at " + text(kShaken[i].first) + " s [m]",
                    kShaken[i].second, moved[i], 3e-4);
  }
}

void v18_converges(Convergence& convergence) {
  convergence.halve_time_step(
      {"relative displacement at 0.5 s, rigid [m]", 0.02, 6, 0.0, 1e-6},
      [](double dt) { return shake(dt, true, 0.5).back() - kShaken[0].second; });
}

namespace {

struct ImpactCase {
  double young, stiffness, mass_ratio;
  double v1, v2, vibration;
};

struct Impact {
  double v1 = 0.0, v2 = 0.0, vibration = 0.0, momentum = 0.0, growth = 0.0;
};

Impact central_impact(const ImpactCase& c, double time_step, TimeScheme scheme) {
  solver::Scene scene;
  scene.gravity = Vector3(0, 0, 0);
  solver::Material material{.density = 2500, .young = c.young, .poisson = 0.0};
  scene.add_block(geometry::make_box({0, 0, 0}, {1, 1, 1}), material);
  material.density *= c.mass_ratio;
  scene.add_block(geometry::make_box({1, 0, 0}, {2, 1, 1}), material);
  scene.blocks[0].velocity = Vector3(1, 0, 0);
  Simulation simulation(scene, {.time_step = time_step,
                                .method = ContactMethod::Springs,
                                .scheme = scheme,
                                .penalty = 0.25 * c.stiffness});
  const double start = simulation.state().energy.mechanical();
  Impact result;
  double largest = start;
  bool touched = false;
  for (;;) {
    const solver::StepReport now = step(simulation);
    largest = std::max(largest, simulation.state().energy.mechanical());
    touched = touched || now.closed_count > 0;
    const bool parting =
        simulation.state().blocks[1].velocity.x() > simulation.state().blocks[0].velocity.x();
    // The strain of the blocks may close the contact again: wait until they are well apart.
    const double apart =
        simulation.state().blocks[1].centroid.x() - simulation.state().blocks[0].centroid.x() - 1.0;
    if (touched && parting && now.closed_count == 0 && apart > 1e-4) break;
    if (simulation.state().time > 0.2) break;
  }
  result.v1 = simulation.state().blocks[0].velocity.x();
  result.v2 = simulation.state().blocks[1].velocity.x();
  double kinetic = 0.0;
  kinetic += 0.5 * 2500.0 * (result.v1 * result.v1 + c.mass_ratio * result.v2 * result.v2);
  result.vibration = (simulation.state().energy.mechanical() - kinetic) / start;
  result.momentum = momentum(simulation).linear.x() / 2500.0 - 1.0;
  result.growth = largest / start - 1.0;
  return result;
}

}  // namespace

namespace {

/// Centroid and axial strain of each cube, M = diag(m, m/12), one spring P between the end faces,
/// k_strain = V E: the ODE integrated with momentum and energy asserted; limit dt -> 0.
constexpr ImpactCase kImpacts[] = {
    {1e12, 1e8, 1, 3.08123720845907e-12, 0.999999999996921, 6.175489792594894e-12},
    {1e9, 1e8, 1, 0.0007399211950426832, 0.9992600788049553, 0.0014787474197753556},
    {1e9, 1e9, 1, 0.034633789731595116, 0.9653662102684051, 0.06686858065076572},
    {1e9, 1e9, 2, -0.29479014365570494, 0.6473950718278527, 0.0748580132073784}};

/// A hundredth of the period of the contact spring over 2 pi, s.
double impact_step(const ImpactCase& c) {
  const double reduced = 2500.0 * c.mass_ratio / (1.0 + c.mass_ratio);
  return 0.01 / std::sqrt(c.stiffness / reduced);
}

}  // namespace

void v19_central_impact(Report& report) {
  for (const ImpactCase& c : kImpacts) {
    const double time_step = impact_step(c);
    const std::string which =
        ", E " + text(c.young) + " P " + text(c.stiffness) + " m2/m1 " + text(c.mass_ratio);
    report.start_run();
    const Impact middle = central_impact(c, time_step, TimeScheme::EnergyMomentum);
    report.absolute("v1' [m/s]" + which + ", energy-momentum", c.v1, middle.v1, 2e-4);
    report.absolute("v2' [m/s]" + which + ", energy-momentum", c.v2, middle.v2, 2e-4);
    report.absolute("share of energy in vibration" + which + ", energy-momentum", c.vibration,
                    middle.vibration, 2e-4);
    report.absolute("momentum after/before - 1" + which + ", energy-momentum", 0.0, middle.momentum,
                    1e-11);
    report.absolute("growth of energy, relative" + which + ", energy-momentum", 0.0, middle.growth,
                    1e-11);
    report.start_run();
    const Impact coarse = central_impact(c, time_step, TimeScheme::ConstantAcceleration);
    const Impact fine = central_impact(c, 0.5 * time_step, TimeScheme::ConstantAcceleration);
    report.absolute("v1' [m/s]" + which + ", dt -> 0", c.v1, 2.0 * fine.v1 - coarse.v1, 1e-4);
    report.absolute("v2' [m/s]" + which + ", dt -> 0", c.v2, 2.0 * fine.v2 - coarse.v2, 1e-4);
    report.absolute("momentum after/before - 1" + which, 0.0, coarse.momentum, 1e-11);
    report.absolute("growth of energy, relative" + which, 0.0, std::max(coarse.growth, 0.0), 1e-11);
  }
}

void v19_converges(Convergence& convergence) {
  const ImpactCase& c = kImpacts[2];
  for (const TimeScheme scheme : {TimeScheme::ConstantAcceleration, TimeScheme::EnergyMomentum}) {
    const bool middle = scheme == TimeScheme::EnergyMomentum;
    convergence.halve_time_step(
        {std::string("v1' [m/s], E 1e9 P 1e9") + (middle ? ", energy-momentum" : ""),
         16.0 * impact_step(c), 12, middle ? 2.0 : 1.0, 1e-9},
        [&](double dt) { return central_impact(c, dt, scheme).v1 - c.v1; });
  }
}

namespace {

/// A cube falls on a free plate, 0.1 s. Momenta of the start: m_A (0, 0, -1) and
/// (0.8, 0.5, 0.501) × it, m_A = 2500 kg.
void free_impact(const StepOptions& options, Report& report) {
  const Vector3 linear(0, 0, -2500), angular(-1250, 2000, 0);
  report.start_run();
  solver::Scene scene;
  scene.gravity = Vector3(0, 0, 0);
  const solver::Material rock{.density = 2500, .young = 5e9, .poisson = 0.25};
  scene.add_block(geometry::make_box({-2, -2, -1}, {2, 2, 0}), rock);
  scene.add_block(geometry::make_box({0.3, 0, 0.001}, {1.3, 1, 1.001}), rock);
  scene.blocks[1].velocity = Vector3(0, 0, -1);
  Simulation simulation(scene, options);
  run_for(simulation, 0.1);
  const Momentum now = momentum(simulation);
  const std::string which = ", " + name(options) + ", dt " + text(options.time_step);
  report.absolute("linear momentum, change / size" + which, 0.0,
                  (now.linear - linear).norm() / linear.norm(), 1e-13);
  report.absolute("angular momentum, change / size" + which, 0.0,
                  (now.angular - angular).norm() / angular.norm(), 2e-9);
  report.at_least("speed of the plate after the impact [m/s]" + which, 0.01,
                  simulation.state().blocks[0].velocity.norm());
}

}  // namespace

void v22_converges(Convergence& convergence) {
  convergence.halve_time_step(
      {"angular momentum in a free impact, change / size", 0.01, 6, 0.0, 1e-12}, [](double dt) {
        Report report("V22");
        free_impact({.time_step = dt}, report);
        return report.rows()[1].error;
      });
}

void v22_angular_momentum(Report& report) {
  for (const ContactMethod method : {ContactMethod::AugmentedLagrangian, ContactMethod::Springs}) {
    for (const double time_step : {1e-3, 1e-4}) {
      StepOptions options{.time_step = time_step, .method = method};
      if (method == ContactMethod::Springs) options.penalty = 5e8;
      free_impact(options, report);
    }
  }
}

}  // namespace quoin::validation
