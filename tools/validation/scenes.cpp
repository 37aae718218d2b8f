#include "scenes.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace quoin::validation {

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

Matrix3 turn(double angle, const Vector3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

geometry::Shape Frame::place(const geometry::Shape& shape) const {
  geometry::Points places(3, shape.vertex_count());
  for (int v = 0; v < shape.vertex_count(); ++v) places.col(v) = point(shape.vertex(v));
  return {shape.shared_topology(), places};
}

solver::Material Frame::material(const solver::Material& m) const {
  solver::Material scaled = m;
  scaled.density = m.density / (scale * scale * scale);
  scaled.young = m.young / scale;
  return scaled;
}

Matrix3 SlopeScene::slope_axes() const { return turn(angle, Vector3::UnitY()); }

solver::Scene SlopeScene::scene() const {
  Frame slope = frame;
  slope.rotation = frame.rotation * slope_axes();
  solver::Scene scene;
  scene.joint.friction_angle = friction;
  scene.gravity = frame.vector({0, 0, -gravity});
  const geometry::Shape plane =
      slope.place(geometry::make_box({-3.0 * size.x(), -10.0 * size.y(), -1.0},
                                     {plane_length + 3.0 * size.x(), 10.0 * size.y(), 0.0}));
  const Vector3 half(0.5 * size.x(), 0.5 * size.y(), 0.0);
  const geometry::Shape body =
      slope.place(geometry::make_box(-half, half + Vector3(0, 0, size.z())));
  if (!plane_last) scene.add_fixed(plane);
  const int b = rigid ? scene.add_rigid(body, frame.material(material))
                      : scene.add_block(body, frame.material(material));
  if (plane_last) scene.add_fixed(plane);
  scene.blocks[static_cast<std::size_t>(b)].velocity = slope.vector(velocity);
  return scene;
}

Vector3 SlopeScene::displacement(const solver::Simulation& simulation) const {
  return slope_axes().transpose() * frame.back(simulation.displacement(block(), Vector3::Zero()));
}

Vector3 SlopeScene::block_velocity(const solver::Simulation& simulation) const {
  const auto b = static_cast<std::size_t>(block());
  return slope_axes().transpose() * frame.back(simulation.state().blocks[b].velocity);
}

Vector3 SlopeScene::angular_velocity(const solver::Simulation& simulation) const {
  const solver::BlockState& b = simulation.state().blocks[static_cast<std::size_t>(block())];
  const Vector3 world = b.rotation * b.angular_velocity;
  return slope_axes().transpose() * (frame.rotation.transpose() * world);
}

solver::StepReport step(solver::Simulation& simulation) {
  const solver::StepReport report = simulation.advance();
  if (report.status != solver::StepStatus::Converged) throw std::runtime_error(describe(report));
  return report;
}

namespace {

/// Steps of a static analysis until balanced or a mechanism, then the options as they were.
solver::StaticVerdict static_steps(solver::Simulation& simulation, solver::Analysis analysis,
                                   int most_steps) {
  constexpr double kBalanced = 1e-14;  // of the largest force
  const solver::StepOptions before = simulation.options();
  solver::StepOptions options = before;
  options.analysis = analysis;
  if (options.method == solver::ContactMethod::Paper) {
    options.method = solver::ContactMethod::AugmentedLagrangian;  // the same state, in fewer solves
  }
  simulation.set_options(options);
  solver::StaticVerdict verdict = solver::StaticVerdict::Seeking;
  for (int i = 0; i < most_steps && verdict != solver::StaticVerdict::Mechanism; ++i) {
    const solver::StepReport report = step(simulation);
    verdict = report.verdict;
    if (report.unbalance <= kBalanced) break;
  }
  simulation.set_options(before);
  return verdict;
}

}  // namespace

solver::StaticVerdict relax(solver::Simulation& simulation, int most_steps) {
  return static_steps(simulation, solver::Analysis::Static, most_steps);
}

void settle(solver::Simulation& simulation, solver::Analysis analysis) {
  constexpr int kMostSteps = 200;
  static_steps(simulation, solver::Analysis::Settle, kMostSteps);
  solver::StepOptions options = simulation.options();
  options.analysis = analysis;
  simulation.set_options(options);
  std::vector<solver::BlockVelocity> velocities;
  for (std::size_t b = 0; b < simulation.scene().blocks.size(); ++b) {
    const solver::Block& block = simulation.scene().blocks[b];
    if (block.velocity.isZero(0.0) && block.angular_velocity.isZero(0.0)) continue;
    velocities.push_back({static_cast<int>(b), block.velocity, block.angular_velocity});
  }
  simulation.set_velocities(velocities);
}

double run_for(solver::Simulation& simulation, double duration) {
  const long steps = std::lround(duration / simulation.options().time_step);
  double overlap = 0.0;
  for (long i = 0; i < steps; ++i) overlap = std::max(overlap, step(simulation).largest_overlap);
  return overlap;
}

Matrix3 strain_matrix(const solver::Vector6& e) {
  Matrix3 m;
  m << e[0], 0.5 * e[3], 0.5 * e[5], 0.5 * e[3], e[1], 0.5 * e[4], 0.5 * e[5], 0.5 * e[4], e[2];
  return m;
}

Momentum momentum(const solver::Simulation& simulation) {
  Momentum total;
  for (std::size_t b = 0; b < simulation.scene().blocks.size(); ++b) {
    const solver::Block& block = simulation.scene().blocks[b];
    if (block.kind != solver::BlockKind::Deformable && block.kind != solver::BlockKind::Rigid) {
      continue;
    }
    const geometry::MassProperties mass = geometry::mass_properties(block.body());
    const solver::BlockState& now = simulation.state().blocks[b];
    const Vector3 linear = block.material.density * mass.volume * now.velocity;
    total.linear += linear;
    total.angular += (simulation.state().origin + now.centroid).cross(linear);
    // Momentum of the reference shape, as the method defines it: the integral of X × (W × X + eps'
    // X).
    const Matrix3 moment = block.material.density * mass.second_moment;
    const Matrix3 rate = strain_matrix(now.strain_rate);
    Vector3 spin = Vector3::Zero();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Vector3 moving = now.angular_velocity.cross(Vector3::Unit(j)) + rate.col(j);
        spin += moment(i, j) * Vector3::Unit(i).cross(moving);
      }
    }
    total.angular += now.rotation * spin;
  }
  return total;
}

Vector3 contact_force(const solver::State& state, int on) {
  Vector3 sum = Vector3::Zero();
  for (const solver::Contact& contact : state.contacts) {
    if (contact.mode == solver::ContactMode::Open) continue;
    // The normal points from A to B: compression pushes A against it.
    const Vector3 on_a = contact.shear_force - contact.normal_force * contact.point.normal;
    if (contact.point.key.a == on) sum += on_a;
    if (contact.point.key.b == on) sum -= on_a;
  }
  return sum;
}

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", value);
  return buffer;
}

std::string name(const solver::StepOptions& options) {
  if (options.method == solver::ContactMethod::AugmentedLagrangian) return "augmented Lagrangian";
  return solver::name(options.method) + (" " + text(options.penalty));
}

}  // namespace quoin::validation
