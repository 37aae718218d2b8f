#pragma once
/// What is asked of any answer to a pair, of a library by the referee and of quoin by its tests:
/// each part of it against the exact numbers.

#include "referee/pairs/exact_patch.hpp"
#include "referee/pairs/faults.hpp"
#include "referee/pairs/pair_sizes.hpp"

namespace quoin::referee {

/// Is a solid that a library does not take out of the promised range, or no thicker than stated?
bool refusal_is_right(const Solid& solid);

/// *sign* and *gap*. Returns by how much it is off, m.
double judge_gap(const ExactGap& exact, double gap, double allowed, Faults& faults);

/// *normal*: a unit vector to within `length_error`, along which the solids are no more than
/// `allowed` (m) nearer than the exact gap.
void judge_normal(const ExactPair& numbers, const ExactGap& exact, const geometry::Vector3& normal,
                  double length_error, double allowed, Faults& faults);

/// *`kind`*: the points lie on their solids. What is off by less than `excused` more, m, is of a
/// kind of its own.
void judge_places(const ExactPair& numbers, const std::array<geometry::Vector3, 2>& points,
                  double allowed, const std::string& kind, double excused, Faults& faults);

/// Points in the plane of a frame, each midway between its places on A and B.
std::vector<Place> middles(const ExactPair& numbers, const PlaneFrame& frame, const auto& points) {
  std::vector<Place> places;
  for (const auto& point : points) {
    const Place a = frame.place(numbers.place(point.point_a)),
                b = frame.place(numbers.place(point.point_b));
    places.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2});
  }
  return places;
}

/// The exact patch as answers are held against it, whose places may be off by `slack`, m.
ExactPatch judged_patch(const ExactPair& numbers, const geometry::Vector3& normal, double tolerance,
                        double slack, const PairSizes& sizes);

/// *missing corner*: of the exact patch. One whose gap is surely within tol, and at which the
/// solids end (asks_for_point), is within 2 tol of the points' hull, and one that stands out by
/// more than 4 tol within tol of a point, but for those on a side where tol cuts a face
/// (lies_on_cut); all plus `slack` over the sine of the lines that cross there.
void judge_corners(const ExactPair& numbers, const geometry::Vector3& normal,
                   const ExactPatch& patch, const std::vector<Place>& places,
                   const CornerLengths& lengths, double slack, Faults& faults);

long double distance(const Place& p, const Place& q);

}  // namespace quoin::referee
