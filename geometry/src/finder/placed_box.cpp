#include "finder/placed_box.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "numeric/numbers.hpp"

namespace quoin::geometry {
namespace {

std::string number_name(const Placement& placement, const double& number) {
  if (&number >= placement.translation.data() && &number < placement.translation.data() + 3)
    return "translation[" + std::to_string(&number - placement.translation.data()) + "]";
  const auto place = &number - placement.linear.data();
  return "linear(" + std::to_string(place % 3) + ", " + std::to_string(place / 3) + ")";
}

void require_finite(const Placement& placement, const double& number, int body) {
  if (std::abs(number) <= kLargestCoordinate) return;
  throw InputError("body " + std::to_string(body) + ": " + number_name(placement, number) +
                   " of its placement is " + text(number) + ", must be finite and at most " +
                   text(kLargestCoordinate));
}

}  // namespace

void refuse_placement(const Placement& placement, int body) {
  const Matrix3& m = placement.linear;
  for (Eigen::Index k = 0; k < 9; ++k) require_finite(placement, m.data()[k], body);
  for (Eigen::Index k = 0; k < 3; ++k)
    require_finite(placement, placement.translation.data()[k], body);
  const double determinant = m.col(0).dot(m.col(1).cross(m.col(2)));
  if (determinant > 0.0) return;
  throw InputError("body " + std::to_string(body) + ": the determinant of its placement is " +
                   text(determinant) + ", must be positive");
}

/// The image of the shape's box lies within |A| h of the image of its middle, that of the ball
/// around it within a row's length times the radius: the lesser of the two. Each sum has at most
/// eight roundings of terms no larger than `size`; 16 of them are a bound with room.
Box placed_box(const Shape& shape, const Placement& placement) {
  constexpr double kSlack = 16 * std::numeric_limits<double>::epsilon();
  const Vector3 middle = shape.origin();
  const Vector3 half = 0.5 * (shape.box().max - shape.box().min);
  const double radius = 0.5 * shape.diameter();
  Box box;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vector3 row = placement.linear.row(k);
    const Vector3 size_of_row = row.cwiseAbs();
    const double centre = placement.translation[k] + row.dot(middle);
    const double reach = std::min(size_of_row.dot(half), radius * row.norm());
    const double size =
        std::abs(placement.translation[k]) + size_of_row.dot(middle.cwiseAbs() + half) + reach;
    box.min[k] = centre - reach - kSlack * size;
    box.max[k] = centre + reach + kSlack * size;
  }
  return box;
}

}  // namespace quoin::geometry
