#pragma once
/// The judge of contact points: the exact patch against what the library lists.

#include "referee/pairs/judged.hpp"
#include "support/trial.hpp"

namespace quoin::tests {

/// Type, polygon, area and points listed for `reach` 0 (that is, up to tol above the least gap):
///   - points: as in check_points;
///   - *type*, where it is clear;
///   - *missing corner*: as in judge_corners;
///   - *area*: of the patch within its perimeter times what is allowed for a place, and the sum of
///     the shares is the area;
///   - *moment*: the shares' first moment is that of the polygon: off by no more than the area is,
///     times the patch's extent, and the area times what a place may be off (or tol, where corners
///     lie within 2 tol of each other and their points are merged);
///   - *polygon*: as reported, the exact one within what is allowed for a place;
///   - *many points*: no more than twice the vertices that carry the contact.
void check_contact(const Trial& trial, const geometry::PairContact& contact, Faults& faults);

/// Points listed for a reach (m), one by one: vertex–face or edge–edge of features that are there,
/// sorted, no key twice, on both solids, over each other along the normal, gap that of the points,
/// none below the least gap or out of reach, the least gap among them.
void check_points(const Trial& trial, const geometry::PairContact& contact, double reach,
                  Faults& faults);

}  // namespace quoin::tests
