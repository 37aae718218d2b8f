#include "referee/pairs/judged.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace quoin::referee {
namespace {

using Real = long double;

/// How far a corner stands out beyond the line between its neighbours; a segment's end by all of
/// it.
Real standing_out(const ExactPatch& patch, std::size_t i) {
  const std::size_t count = patch.corners.size();
  if (count == 1) return std::numeric_limits<Real>::infinity();
  return distance_to_places(
      {patch.corners[(i + 1) % count].place, patch.corners[(i + count - 1) % count].place},
      patch.corners[i].place);
}

/// How far the point at a corner may lie from the place given, m. Each of the lines that cross
/// there is known to `slack`; that of an edge may as well run between other ends as far apart,
/// which lie up to open_ends beside those taken. (An end itself, of sine 1, has tol for that.)
Real blur_of(const ExactPatch& patch, const PatchCorner& corner, Real slack) {
  const int edges = patch.type == geometry::ContactType::EdgeEdgeCrossing ? 2
                    : corner.sine < 1                                     ? 1
                                                                          : 0;
  return (2 * slack + edges * patch.open_ends) / std::max(corner.sine, Real(kEpsilon));
}

}  // namespace

Real distance(const Place& p, const Place& q) { return std::hypot(p[0] - q[0], p[1] - q[1]); }

bool refusal_is_right(const Solid& solid) {
  return !in_range(solid) || thickness(solid) <= stated_thickness(solid);
}

double judge_gap(const ExactGap& exact, double gap, double allowed, Faults& faults) {
  const double off = static_cast<double>(std::abs(Real(gap) - exact.gap));
  const bool same_sign = (gap > 0) == (exact.gap > 0);
  faults.expect(off <= allowed || same_sign, "sign", "gap ", gap, ", exact ", exact.gap);
  faults.expect(off <= allowed || !same_sign, "gap", gap, ", exact ", exact.gap, ", off by ", off,
                ", allowed ", allowed);
  return off;
}

void judge_normal(const ExactPair& numbers, const ExactGap& exact, const geometry::Vector3& normal,
                  double length_error, double allowed, Faults& faults) {
  const double length = normal.norm();
  faults.expect(std::abs(length - 1) <= length_error, "normal", "its length is ", length);
  if (!(std::abs(length - 1) <= length_error)) return;
  const Real along = gap_along(numbers, normal / length);
  faults.expect(along >= exact.gap - Real(allowed), "normal", "the solids are ", along,
                " apart along it, ", exact.gap, " along the best, allowed ", allowed);
}

void judge_places(const ExactPair& numbers, const std::array<geometry::Vector3, 2>& points,
                  double allowed, const std::string& kind, double excused, Faults& faults) {
  for (const int side : {0, 1}) {
    const double off = numbers.distance(side, points[static_cast<std::size_t>(side)], allowed);
    const bool nearly = excused > 0 && off <= excused + allowed;
    faults.expect(off <= allowed, (kind + (nearly ? " off by less than tol" : "")).c_str(),
                  "the point on ", side == 0 ? "A" : "B", " is ", off, " off, allowed ", allowed);
  }
}

ExactPatch judged_patch(const ExactPair& numbers, const geometry::Vector3& normal, double tolerance,
                        double slack, const PairSizes& sizes) {
  return exact_patch(
      numbers, normal,
      {.tolerance = tolerance, .decision = slack, .border = 2 * kEpsilon * sizes.larger});
}

void judge_corners(const ExactPair& numbers, const geometry::Vector3& normal,
                   const ExactPatch& patch, const std::vector<Place>& places,
                   const CornerLengths& lengths, double slack, Faults& faults) {
  const Real tolerance = lengths.tolerance;
  for (std::size_t i = 0; i < patch.corners.size(); ++i) {
    const PatchCorner& corner = patch.corners[i];
    if (corner.excess > tolerance - Real(slack)) continue;  // its gap may be out of reach
    const Real blur = blur_of(patch, corner, slack);
    const Real beyond = distance_to_places(places, corner.place);
    Real nearest = std::numeric_limits<Real>::infinity();
    for (const Place& place : places) nearest = std::min(nearest, distance(place, corner.place));
    const bool shown = nearest <= tolerance + blur ||
                       standing_out(patch, i) <= 4 * tolerance + 4 * blur ||
                       lies_on_cut(numbers, normal, corner, lengths.tolerance, lengths.extent);
    const bool covered = beyond <= 2 * tolerance + blur && shown;
    faults.expect(covered || !asks_for_point(numbers, normal, patch, corner, lengths),
                  "missing corner", "a corner of the exact patch is ", nearest,
                  " from the nearest point, ", beyond, " outside all");
  }
}

}  // namespace quoin::referee
