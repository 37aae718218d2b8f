#include "certify/certificate.hpp"

#include <algorithm>

#include "numeric/error_bounds.hpp"

namespace quoin::geometry {

double default_tolerance(const Shape& a, const Shape& b) {
  return default_tolerance(Solid(a), Solid(b));
}

double default_tolerance(const Body& a, const Body& b) {
  return default_tolerance(Solid(a, Vector3::Zero()), Solid(b, Vector3::Zero()));
}

bool carry_turned(const Solid& a, const Solid& b, const std::array<int, 2>& counts,
                  const Vector3& normal, double depth) {
  const PairSupport both = support_pair(a, b, normal);
  return count_beyond(a, normal, both.p.value - depth) == counts[0] &&
         count_beyond(b, -normal, both.q.value - depth) == counts[1];
}

}  // namespace quoin::geometry
