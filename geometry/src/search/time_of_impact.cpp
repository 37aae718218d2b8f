#include <quoin/geometry/time_of_impact.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include "numeric/error_bounds.hpp"
#include "numeric/numbers.hpp"

namespace quoin::geometry {
namespace {

void check(const Body& body, const Motion& motion, int name) {
  const Placement& start = body.placement();
  const double sum = start.linear.cwiseAbs().sum() + start.translation.cwiseAbs().sum() +
                     motion.translation.cwiseAbs().sum() + motion.rotation.cwiseAbs().sum() +
                     motion.centre.cwiseAbs().sum();
  const Matrix3& m = start.linear;
  if (sum <= kLargestCoordinate && m.col(0).dot(m.col(1).cross(m.col(2))) > 0.0) return;
  throw InputError("body " + std::to_string(name) +
                   ": its placement mirrors, or it or the motion is not finite");
}

/// How far any point of the body is from the axis that it turns about, at most, m.
double farthest_from_axis(const Body& body, const Motion& motion) {
  const Vector3 axis = motion.rotation.stableNormalized();
  double squared = 0.0;
  for (int v = 0; v < body.shape().vertex_count(); ++v)
    squared = std::max(squared, axis.cross(body.vertex(v) - motion.centre).squaredNorm());
  return std::sqrt(squared);
}

/// Bound of all coordinates that go into a body's places during the step, m.
double size(const Body& body, const Motion& motion) {
  return body.stretch() * std::sqrt(3.0) * body.shape().largest_coordinate() +
         2.0 * body.placement().translation.norm() + 3.0 * motion.centre.norm() +
         motion.translation.norm();
}

}  // namespace

Placement placement_at(const Placement& start, const Motion& motion, double s) {
  const double angle = s * motion.rotation.stableNorm();
  if (angle == 0.0) return {start.linear, start.translation + s * motion.translation};
  const Matrix3 turn =
      Eigen::AngleAxisd(angle, motion.rotation.stableNormalized()).toRotationMatrix();
  return {turn * start.linear,
          motion.centre + s * motion.translation + turn * (start.translation - motion.centre)};
}

Motion motion_between(const Placement& start, const Placement& end, const Vector3& centre) {
  const Eigen::Quaterniond turn(Matrix3(end.linear * start.linear.transpose()));
  const Eigen::AngleAxisd rotation(turn.normalized());
  const Vector3 own = start.linear.transpose() * (centre - start.translation);
  return {end.translation + end.linear * own - centre, rotation.angle() * rotation.axis(), centre};
}

Impact time_of_impact(const Body& a, const Motion& motion_a, const Body& b, const Motion& motion_b,
                      const ImpactOptions& options) {
  require_length(options.length, "time of impact: length");
  check(a, motion_a, 0);
  check(b, motion_b, 1);
  const double rounding = 4.0 * kQueryRounding * kEpsilon * (size(a, motion_a) + size(b, motion_b));
  const double length = std::max(options.length, 4.0 * rounding);
  const double arm_a = farthest_from_axis(a, motion_a), arm_b = farthest_from_axis(b, motion_b);
  Body at_a = a, at_b = b;
  Impact impact;
  for (;;) {
    ++impact.iterations;
    at_a.move(placement_at(a.placement(), motion_a, impact.s));
    at_b.move(placement_at(b.placement(), motion_b, impact.s));
    const NearestFeatures nearest = nearest_features(at_a, at_b, {}, impact.nearest.hint);
    impact.nearest = nearest;
    if (nearest.status == PairStatus::NotConverged) return impact;
    if (nearest.gap <= length) {
      impact.status = ImpactStatus::Impact;
      return impact;
    }
    if (impact.s == 1.0) {
      impact.status = ImpactStatus::Apart;
      return impact;
    }
    if (impact.iterations >= options.max_iterations) return impact;
    const Vector3& normal = nearest.normal;
    const double speed = std::max(0.0, normal.dot(motion_a.translation - motion_b.translation)) +
                         normal.cross(motion_a.rotation).norm() * arm_a +
                         normal.cross(motion_b.rotation).norm() * arm_b;
    const double certain = nearest.gap - nearest.residual_a - nearest.residual_b - rounding;
    const double step = (certain - 0.5 * length) / speed;  // infinite: they never come nearer
    impact.s = std::min(1.0, impact.s + step);
  }
}

}  // namespace quoin::geometry
