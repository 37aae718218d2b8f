#include "scene_file/comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace quoin::scene_file {

namespace {

Vector3 vector_of(Quantity quantity, const MonitorValue& monitor) {
  using Value = MonitorValue;
  constexpr std::array kMembers = {
      // in the order of the quantities
      &Value::displacement,       &Value::velocity, &Value::rotation,
      &Value::angular_velocity,   &Value::force,    &Value::moment,
      &Value::centre_of_pressure, &Value::momentum, &Value::angular_momentum};
  return monitor.*kMembers[static_cast<std::size_t>(quantity)];
}

}  // namespace

void Comparison::compare(double time, const MonitorValue& monitor) {
  // A step may end a rounding error beside the time that was meant.
  const double slack = 1e-9 * (1 + std::abs(time));
  if (time < reference_.from - slack || time > reference_.until + slack) return;
  result_.value = quantity(monitor);
  result_.exact = reference_.exact(time);
  last_difference_ = (result_.value - result_.exact).norm();
  if (!std::isnan(largest_difference_) && !(last_difference_ <= largest_difference_))
    largest_difference_ = last_difference_;  // what is no number stays so
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
  if (reference_.quantity == Quantity::Stress || reference_.quantity == Quantity::Strain) {
    const auto& tensor = reference_.quantity == Quantity::Stress ? monitor.stress : monitor.strain;
    return Eigen::VectorXd::Constant(1, tensor[reference_.tensor_component]);
  }
  const Vector3 vector = vector_of(reference_.quantity, monitor);
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
