#pragma once
/// One pair on trial: as it is given, as the library takes it, in exact numbers, with what is
/// allowed; and what was found to be wrong.

#include <optional>
#include <quoin/geometry/contact_point.hpp>
#include <string>
#include <vector>

#include "referee/pairs/faults.hpp"
#include "referee/pairs/pair_sizes.hpp"
#include "support/random.hpp"

namespace quoin::tests {

/// Both shapes as the library makes them, and where they stand.
class Query {
 public:
  /// Throws InputError where the library refuses one.
  explicit Query(const SolidPair& pair);

  geometry::Body a() const { return {shape_a_, place_a_}; }
  geometry::Body b() const { return {shape_b_, place_b_}; }

  geometry::NearestFeatures nearest(const geometry::FeatureHint& hint = {}) const;
  geometry::NearestFeatures nearest_swapped() const;
  geometry::PairContact contact(const geometry::ContactOptions& options = {}) const;
  /// Both in one call; `reach` is the gap itself.
  geometry::NearestFeatures contacts_within(double reach,
                                            std::vector<geometry::ContactPoint>& points) const;

 private:
  bool own_frames_;
  geometry::Shape shape_a_, shape_b_;
  geometry::Placement place_a_, place_b_;
};

struct Trial : PairSizes {
  const SolidPair& pair;
  Query query;
  ExactPair exact;
  double tolerance = 0;  ///< the library's contact length tol, m

  /// Throws InputError where the library refuses a solid.
  explicit Trial(const SolidPair& pair);
};

/// The library took both solids, or refused one and said so: right if and only if both keep to the
/// promised range and are thicker than the stated length. Thin ones that are taken are no fault.
void check_taken(const SolidPair& pair, Faults& faults);
void check_refused(const SolidPair& pair, const std::string& message, Faults& faults);

}  // namespace quoin::tests
