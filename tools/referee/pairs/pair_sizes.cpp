#include "referee/pairs/pair_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <quoin/geometry/shape.hpp>
#include <stdexcept>

namespace quoin::referee {
PairSizes::PairSizes(const SolidPair& pair)
    : own_frames(stands_in_own_frame(pair.a) && stands_in_own_frame(pair.b)) {
  const double a = diameter(pair.a), b = diameter(pair.b);
  larger = std::max(a, b);
  smaller = std::min(a, b);
  shape_coordinate = std::max(largest_coordinate(pair.a), largest_coordinate(pair.b));
  world_coordinate = std::max(largest_world_coordinate(pair.a), largest_world_coordinate(pair.b));
}

double PairSizes::allowed_gap(long double exact, double promised) const {
  return 1e-12 * std::abs(static_cast<double>(exact)) + (16 * kEpsilon + promised) * larger +
         (own_frames ? 0.0 : 4 * kEpsilon * shape_coordinate);
}

double PairSizes::allowed_place(long double exact, double promised) const {
  return allowed_gap(exact, promised) + 4 * kEpsilon * std::max(world_coordinate, shape_coordinate);
}

double stated_thickness(const Solid& solid) {
  return std::max(1e-9 * diameter(solid), 16 * kEpsilon * largest_coordinate(solid));
}

double thickness(const Solid& solid) {
  try {
    return static_cast<double>(exact_width({solid.placed.points, {}}));
  } catch (const std::invalid_argument&) {
    return 0.0;
  }
}

bool in_range(const Solid& solid) {
  return diameter(solid) >= geometry::kSmallestExtent &&
         largest_world_coordinate(solid) <= geometry::kLargestCoordinate &&
         largest_coordinate(solid) <= geometry::kLargestCoordinate;
}

}  // namespace quoin::referee
