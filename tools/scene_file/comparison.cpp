#include "scene_file/comparison.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::scene_file {

void Comparison::compare(double time, const MonitorValue& monitor) {
  // A step may end a rounding error beside the time that was meant.
  const double slack = 1e-9 * (1 + std::abs(time));
  if (time < reference_.from - slack || time > reference_.until + slack) {
    return;
  }
  result_.value = quantity(monitor);
  result_.exact = reference_.exact(time);
  last_difference_ = (result_.value - result_.exact).norm();
  if (!std::isnan(largest_difference_) && !(last_difference_ <= largest_difference_)) {
    largest_difference_ = last_difference_;  // what is no number stays so
  }
  largest_exact_ = std::max(largest_exact_, result_.exact.norm());
  ++result_.compared;
}

ReferenceResult Comparison::result() const {
  ReferenceResult result = result_;
  const double scale = largest_exact_ > 0 ? largest_exact_ : 1.0;
  result.error = largest_difference_ / scale;
  result.error_end = last_difference_ / scale;
  result.ok = result.compared > 0 && std::isfinite(result.error) &&
              (reference_.allowed == 0 || result.error <= reference_.allowed);
  return result;
}

Eigen::VectorXd Comparison::quantity(const MonitorValue& monitor) const {
  const Vector3 vector = reference_.quantity == Quantity::Displacement ? monitor.displacement
                         : reference_.quantity == Quantity::Velocity   ? monitor.velocity
                         : reference_.quantity == Quantity::Rotation   ? monitor.rotation
                         : reference_.quantity == Quantity::AngularVelocity
                             ? monitor.angular_velocity
                             : monitor.force;
  switch (reference_.component) {
    case Reference::Component::Along:
      return Eigen::VectorXd::Constant(1, vector.dot(reference_.direction));
    case Reference::Component::Magnitude:
      return Eigen::VectorXd::Constant(1, vector.norm());
    case Reference::Component::Vector:
      break;
  }
  return vector;
}

}  // namespace quoin::scene_file
