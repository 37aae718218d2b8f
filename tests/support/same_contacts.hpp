#pragma once
/// Contact points that agree to the bit; which of the last list they come from is left out.

#include <algorithm>
#include <quoin/geometry/contact_point.hpp>
#include <vector>

namespace quoin::tests {

inline bool same_but_previous(const geometry::ContactPoint& c, const geometry::ContactPoint& d) {
  return c.key == d.key && c.type == d.type && c.indeterminate == d.indeterminate &&
         c.point_a == d.point_a && c.point_b == d.point_b && c.normal == d.normal &&
         c.gap == d.gap && c.area == d.area;
}

inline bool same_but_previous(const std::vector<geometry::ContactPoint>& c,
                              const std::vector<geometry::ContactPoint>& d) {
  return std::equal(c.begin(), c.end(), d.begin(), d.end(),
                    [](const auto& x, const auto& y) { return same_but_previous(x, y); });
}

}  // namespace quoin::tests
