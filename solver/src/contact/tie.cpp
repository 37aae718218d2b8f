#include "contact/tie.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

/// From its first point to its second, m.
Vector3 reach_of(const TieModel& model, std::span<const Pose> poses) {
  const Pose world{.rotation = Matrix3::Identity(), .shape = Matrix3::Identity()};
  const auto of = [&](int block) -> const Pose& { return block < 0 ? world : poses[index(block)]; };
  const Pose &a = of(model.tie.a), &b = of(model.tie.b);
  return between(a, b) + (b.shape * model.arm_b - a.shape * model.arm_a);
}

double elongation(const TieState& state, double length) {
  return length - state.rest_length - state.plastic;
}

double force_of(const Tie& tie, double elongation) {
  const double least = tie.tension_only ? 0.0 : -tie.yield_force;
  return std::clamp(tie.stiffness * elongation, least, tie.yield_force);
}

/// Stored and plastic work from no elongation to this one, J.
double work_to(const Tie& tie, double elongation) {
  const double force = force_of(tie, elongation);
  return force == 0.0 ? 0.0 : force * (elongation - 0.5 * force / tie.stiffness);
}

/// Force as a linear function of the elongation at the end of the step, about the present one.
struct MeanForce {
  double force = 0.0, slope = 0.0;
};

/// The discrete gradient of work_to(). [Gonzalez 2000]
MeanForce mean_force(const Tie& tie, double start, double end) {
  constexpr double kSame = 1e-7;  // of the elongations: the quotient would be rounding
  const double change = end - start, middle = 0.5 * (start + end);
  const double f0 = force_of(tie, start), f1 = force_of(tie, end);
  const auto elastic = [&](double e) { return force_of(tie, e) == tie.stiffness * e; };
  if (elastic(start) && elastic(end)) return {tie.stiffness * middle, 0.5 * tie.stiffness};
  if (f0 == f1 || std::abs(change) <= kSame * (std::abs(start) + std::abs(end)))
    return {force_of(tie, middle), 0.0};
  const double mean = (work_to(tie, end) - work_to(tie, start)) / change;
  return {mean, (f1 - mean) / change};
}

}  // namespace

TieState laid_tie(const TieModel& model, std::span<const Pose> poses) {
  const Tie& tie = model.tie;
  TieState state;
  state.length = reach_of(model, poses).norm();
  state.rest_length =
      tie.rest_length > 0.0 ? tie.rest_length : state.length - tie.pretension / tie.stiffness;
  state.force = force_of(tie, elongation(state, state.length));
  return state;
}

double stored_energy(const Tie& tie, const TieState& state) {
  return 0.5 * state.force * state.force / tie.stiffness;
}

TieState tie_at_end(const TieModel& model, const TieState& before, std::span<const Pose> end) {
  TieState state = before;
  state.length = reach_of(model, end).norm();
  const double stretched = elongation(before, state.length);
  state.force = before.broken ? 0.0 : force_of(model.tie, stretched);
  if (std::abs(state.force) < model.tie.yield_force) return state;
  state.plastic += stretched - state.force / model.tie.stiffness;
  return state;
}

bool is_overloaded(const Tie& tie, const TieState& state) {
  return !state.broken && (std::abs(state.force) > tie.break_force ||
                           state.length > state.rest_length * (1.0 + tie.break_strain));
}

double force_until_break(const Tie& tie, const TieState& before, double length) {
  const double start = elongation(before, before.length), end = elongation(before, length);
  const double by_force = tie.break_force / tie.stiffness;
  const double by_strain = before.rest_length * tie.break_strain - before.plastic;
  double least = -std::numeric_limits<double>::infinity(), most = by_strain;
  if (tie.break_force < tie.yield_force) {
    most = std::min(by_force, by_strain);
    if (!tie.tension_only) least = -by_force;
  }
  const double broken = std::clamp(end, least, most);
  if (!((broken - start) * (end - start) > 0.0)) return 0.0;  // at once
  return (work_to(tie, broken) - work_to(tie, start)) / (end - start);
}

void linearise_tie(const TieModel& model, const TieState& before, const StepPoses& poses,
                   double end_share, LinearContact& c) {
  const Vector3 start = reach_of(model, poses.start), end = reach_of(model, poses.end);
  const double length = end.norm(), both = before.length + length;
  const Vector3 along = (start + end) / both;
  Matrix3 rows;
  rows.row(0) = -along;
  rows.row(1) = along.unitOrthogonal();
  rows.row(2) = along.cross(Vector3(rows.row(1))).normalized();
  Vector3 idle = Vector3::Zero(), moved = Vector3::Zero();
  const auto fill = [&](int block, int slot, double sign, const Vector3& arm,
                        ContactJacobian& jacobian) {
    if (block < 0) return;
    const std::size_t b = index(block);
    const Vector12& increment = poses.increment[b];
    jacobian.set(sign * rows *
                     mean_motion(poses.start[b], poses.end[b], increment.segment<3>(3), arm,
                                 poses.deforms[b] != 0),
                 poses.deforms[b] != 0);
    (slot < 0 ? idle : moved) += jacobian * increment;
  };
  fill(model.tie.a, c.slot_a, -1.0, model.arm_a, c.jacobian_a);
  fill(model.tie.b, c.slot_b, 1.0, model.arm_b, c.jacobian_b);
  c.start = {-elongation(before, before.length), 0.0, 0.0};
  c.offset = c.start + idle;
  c.offset.tail<2>() = -moved.tail<2>();
  c.multiplier.setZero();
  c.shear_stiffness = std::max(c.force[0], 0.0) / both;
  c.normal_stiffness = before.broken ? 0.0 : model.tie.stiffness;
  if (before.broken) {
    c.multiplier[0] = before.force;
    c.bonded = before.force < 0.0;
    return;
  }
  if (!(end_share < 1.0)) return;
  const double stretched = elongation(before, length);
  const MeanForce mean = mean_force(model.tie, -c.start[0], stretched);
  c.multiplier[0] = mean.force - mean.slope * stretched;
  c.normal_stiffness = mean.slope;
  c.bonded = true;
  c.cohesion = std::numeric_limits<double>::infinity();
}

ContactWork tie_work(const Tie& tie, const TieState& before, const TieState& end, double force) {
  ContactWork work{.stored = stored_energy(tie, end)};
  const double gained = work.stored - stored_energy(tie, before);
  const double yielded = std::abs(end.plastic - before.plastic);
  const double done = force * (end.length - before.length);
  work.heat = end.broken ? done - gained : yielded > 0 ? tie.yield_force * yielded : 0.0;
  work.scheme = done - gained - work.heat;
  return work;
}

}  // namespace quoin::solver
