#include "support/trial.hpp"

#include "referee/pairs/judged.hpp"

namespace quoin::tests {
namespace {

using geometry::FeatureHint;
using geometry::NearestFeatures;

}  // namespace

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

geometry::PairContact Query::contact(const geometry::ContactOptions& options) const {
  geometry::PairContact contact;
  if (own_frames_)
    update_pair_contact(shape_a_, shape_b_, options, contact);
  else
    update_pair_contact(a(), b(), options, contact);
  return contact;
}

NearestFeatures Query::contacts_within(double reach,
                                       std::vector<geometry::ContactPoint>& points) const {
  const geometry::ContactOptions options{.reach = reach};
  return own_frames_ ? append_contacts_within_reach({0, 1}, shape_a_, shape_b_, options, {}, points)
                     : append_contacts_within_reach({0, 1}, a(), b(), options, {}, points);
}

Trial::Trial(const SolidPair& given)
    : PairSizes(given),
      pair(given),
      query(given),
      exact(given.a.placed, given.b.placed),
      tolerance(default_tolerance(query.a(), query.b())) {}

void check_taken(const SolidPair& pair, Faults& faults) {
  faults.expect(in_range(pair.a) && in_range(pair.b), "taken", "a solid out of the promised range");
}

void check_refused(const SolidPair& pair, const std::string& message, Faults& faults) {
  const bool right = refusal_is_right(pair.a) || refusal_is_right(pair.b);
  faults.expect(right, "refused", message, " (A is ", thickness(pair.a), " m thick, B ",
                thickness(pair.b), " m)");
}

}  // namespace quoin::tests
