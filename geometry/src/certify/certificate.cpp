#include "certify/certificate.hpp"

#include <algorithm>

#include "numeric/error_bounds.hpp"

namespace quoin::geometry {

double default_tolerance(const Body& a, const Body& b) {
  return default_tolerance(Solid(a, Vector3::Zero()), Solid(b, Vector3::Zero()));
}

bool carry_turned(const Solid& a, const Solid& b, const std::array<int, 2>& counts,
                  const Vector3& normal, const Turned& turned) {
  const auto keeps = [&](const Solid& solid, const Vector3& outward, double top, int count) {
    const double least = std::max(turned.lift, turned.contact - turned.lift);
    const int near = count_beyond(solid, outward, top - least);
    return count_beyond(solid, outward, top - turned.contact - turned.lift) == near &&
           (near == count || count_beyond(solid, outward, top - turned.lift) == count);
  };
  const PairSupport both = support_pair(a, b, normal);
  return keeps(a, normal, both.p.value, counts[0]) && keeps(b, -normal, both.q.value, counts[1]);
}

}  // namespace quoin::geometry
