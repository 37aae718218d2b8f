#include "support/trial.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <quoin/geometry/build.hpp>
#include <stdexcept>

namespace quoin::tests {
namespace {

using geometry::FeatureHint;
using geometry::NearestFeatures;

constexpr double kEps = std::numeric_limits<double>::epsilon();

/// The stated length below which points count as lying in one plane, m.
double stated_thickness(const Solid& solid) {
  return std::max(1e-9 * diameter(solid), 16 * kEps * largest_coordinate(solid));
}

/// The thickness of the points, m; 0 where they lie in one plane.
double thickness(const Solid& solid) {
  try {
    return static_cast<double>(exact_width({solid.placed.points, {}}));
  } catch (const std::invalid_argument&) {
    return 0.0;
  }
}

/// Sizes for which answers are promised.
bool in_range(const Solid& solid) {
  return diameter(solid) >= geometry::kSmallestExtent &&
         largest_world_coordinate(solid) <= geometry::kLargestCoordinate &&
         largest_coordinate(solid) <= geometry::kLargestCoordinate;
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << fault.kind << ": " << fault.text;
}

Query::Query(const SolidPair& pair)
    : own_frames_(stands_in_own_frame(pair.a) && stands_in_own_frame(pair.b)),
      shape_a_(shape_of(pair.a)),
      shape_b_(shape_of(pair.b)),
      place_a_(pair.a.placed.placement),
      place_b_(pair.b.placed.placement) {}

NearestFeatures Query::nearest(const FeatureHint& hint) const {
  return own_frames_ ? nearest_features(shape_a_, shape_b_, {}, hint)
                     : nearest_features(a(), b(), {}, hint);
}

NearestFeatures Query::nearest_swapped() const {
  return own_frames_ ? nearest_features(shape_b_, shape_a_) : nearest_features(b(), a());
}

geometry::PairContact Query::contact(double reach) const {
  geometry::PairContact contact;
  if (own_frames_) {
    update_pair_contact(shape_a_, shape_b_, {.reach = reach}, contact);
  } else {
    update_pair_contact(a(), b(), {.reach = reach}, contact);
  }
  return contact;
}

NearestFeatures Query::contacts_within(double reach,
                                       std::vector<geometry::ContactPoint>& points) const {
  const geometry::ContactOptions options{.reach = reach};
  return own_frames_ ? append_contacts_within_reach({0, 1}, shape_a_, shape_b_, options, {}, points)
                     : append_contacts_within_reach({0, 1}, a(), b(), options, {}, points);
}

Trial::Trial(const SolidPair& given)
    : pair(given), query(given), exact(given.a.placed, given.b.placed) {
  const double a = diameter(pair.a), b = diameter(pair.b);
  larger = std::max(a, b);
  smaller = std::min(a, b);
  shape_coordinate = std::max(largest_coordinate(pair.a), largest_coordinate(pair.b));
  world_coordinate = std::max(largest_world_coordinate(pair.a), largest_world_coordinate(pair.b));
  tolerance = default_tolerance(query.a(), query.b());
}

double Trial::allowed_gap(long double gap) const {
  const bool own_frames = stands_in_own_frame(pair.a) && stands_in_own_frame(pair.b);
  return 1e-12 * std::abs(static_cast<double>(gap)) + 16 * kEps * larger +
         (own_frames ? 0.0 : 4 * kEps * shape_coordinate);
}

double Trial::allowed_place(long double gap) const {
  return allowed_gap(gap) + 4 * kEps * std::max(world_coordinate, shape_coordinate);
}

void check_taken(const SolidPair& pair, Faults& faults) {
  faults.expect(in_range(pair.a) && in_range(pair.b), "taken", "a solid out of the promised range");
}

void check_refused(const SolidPair& pair, const std::string& message, Faults& faults) {
  bool right = false;
  for (const Solid* solid : {&pair.a, &pair.b}) {
    right = right || !in_range(*solid) || thickness(*solid) <= stated_thickness(*solid);
  }
  faults.expect(right, "refused", message, " (A is ", thickness(pair.a), " m thick, B ",
                thickness(pair.b), " m)");
}

}  // namespace quoin::tests
