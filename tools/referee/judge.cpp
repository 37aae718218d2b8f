#include "judge.hpp"

#include <quoin/referee.h>

#include <cmath>
#include <limits>
#include <quoin/geometry/shape.hpp>
#include <sstream>
#include <stdexcept>

#include "described_solid.hpp"
#include "support/exact_patch.hpp"

namespace quoin::referee {
namespace {

using geometry::Vector3;
using tests::ExactPatch;
using tests::Place;
using tests::PlaneFrame;
using tests::Solid;
using Real = long double;

constexpr double kEps = std::numeric_limits<double>::epsilon();

template <class... Parts>
void expect(bool holds, Judgement& result, const char* kind, const Parts&... parts) {
  if (!holds) {
    std::ostringstream out;
    out.precision(17);
    (out << ... << parts);
    result.faults.push_back({kind, out.str()});
  }
}

bool is_box(const Solid& solid) {
  return DescribedSolid(solid.placed.points).view().box_half[0] > 0;
}

/// The length below which points count as lying in one plane, as in make_hull, m.
double stated_thickness(const Solid& solid) {
  return std::max(1e-9 * diameter(solid), 16 * kEps * largest_coordinate(solid));
}

double thickness(const Solid& solid) {
  try {
    return static_cast<double>(tests::exact_width({solid.placed.points, {}}));
  } catch (const std::invalid_argument&) {
    return 0.0;
  }
}

/// A normal as good as the answer's own, or the exact one where that is no direction.
Vector3 contact_normal(const LibraryInfo& library, const Answer& answer, const Vector3& exact) {
  const bool own = library.has(QUOIN_REFEREE_NORMAL) && answer.outcome == Outcome::Answered &&
                   std::abs(answer.normal.norm() - 1) <= 1e-6;
  return own ? answer.normal.normalized() : exact;
}

}  // namespace

Judge::Judge(const tests::SolidPair& pair)
    : pair_(pair), numbers_(pair.a.placed, pair.b.placed), gap_(numbers_.gap()) {
  const double a = diameter(pair.a), b = diameter(pair.b);
  larger_ = std::max(a, b);
  smaller_ = std::min(a, b);
  const double coordinate = std::max(largest_coordinate(pair.a), largest_coordinate(pair.b));
  const bool own_frames = stands_in_own_frame(pair.a) && stands_in_own_frame(pair.b);
  turned_coordinate_ = own_frames ? 0.0 : coordinate;
  world_coordinate_ =
      std::max({coordinate, largest_world_coordinate(pair.a), largest_world_coordinate(pair.b)});
  tolerance_ = std::max(1e-9 * smaller_, 16 * kEps * coordinate);
  boxes_ = is_box(pair.a) && is_box(pair.b);
  rotations_ =
      is_rotation(pair.a.placed.placement.linear) && is_rotation(pair.b.placed.placement.linear);
}

bool Judge::offered(const LibraryInfo& library) const {
  const double allowed = allowed_gap(library);
  const bool apart = gap_.gap > allowed, overlapping = gap_.gap < -allowed;
  const bool gap_offered =
      (library.has(QUOIN_REFEREE_DISTANCE) && !overlapping) ||
      (library.has(QUOIN_REFEREE_DEPTH) && !apart) ||
      (library.has(QUOIN_REFEREE_POINTS) && (!apart || library.has(QUOIN_REFEREE_APART)));
  return gap_offered && (rotations_ || library.has(QUOIN_REFEREE_DEFORMED)) &&
         (boxes_ || !library.has(QUOIN_REFEREE_BOXES_ONLY));
}

double Judge::allowed_gap(const LibraryInfo& library) const {
  return 1e-12 * std::abs(static_cast<double>(gap_.gap)) +
         (16 * kEps + library.promised_error) * larger_ + 4 * kEps * turned_coordinate_;
}

double Judge::allowed_place(const LibraryInfo& library) const {
  return allowed_gap(library) + 4 * kEps * world_coordinate_;
}

bool Judge::refusal_is_right(int side) const {
  const Solid& solid = side == 0 ? pair_.a : pair_.b;
  return diameter(solid) < geometry::kSmallestExtent ||
         largest_world_coordinate(solid) > geometry::kLargestCoordinate ||
         thickness(solid) <= stated_thickness(solid);
}

Judgement Judge::judge(const LibraryInfo& library, const Answer& answer) const {
  Judgement result;
  result.asked = offered(library);
  switch (answer.outcome) {
    case Outcome::Crashed:
      expect(false, result, "crash", "the library ended its process");
      return result;
    case Outcome::TimedOut:
      expect(false, result, "hang", "no answer within the time limit");
      return result;
    case Outcome::RefusedA:
    case Outcome::RefusedB:
      expect(!result.asked || refusal_is_right(answer.outcome == Outcome::RefusedB), result,
             "refused", "a solid within the promised range");
      return result;
    case Outcome::Failed:
      expect(!result.asked, result, "failed", "the library says so");
      break;
    case Outcome::Answered:
      result.answered = true;
      check_gap(library, answer, result);
      break;
    case Outcome::NoAnswer:
      break;
  }
  if (result.asked && answer.points_outcome == Outcome::Answered) {
    result.answered = true;
    check_points(library, answer, result);
  }
  return result;
}

void Judge::check_gap(const LibraryInfo& library, const Answer& answer, Judgement& result) const {
  if (!std::isfinite(answer.gap)) {
    expect(false, result, "not finite", "gap ", answer.gap);
    return;
  }
  const double allowed = allowed_gap(library);
  const double off = static_cast<double>(std::abs(Real(answer.gap) - gap_.gap));
  result.gap_error = off / larger_;
  const bool same_sign = (answer.gap > 0) == (gap_.gap > 0);
  expect(off <= allowed || same_sign, result, "sign", "gap ", answer.gap, ", exact ", gap_.gap);
  expect(off <= allowed || !same_sign, result, "gap", answer.gap, ", exact ", gap_.gap,
         ", allowed error ", allowed);
  if (off > allowed) {
    return;  // what follows would say the same again
  }
  if (library.has(QUOIN_REFEREE_NORMAL)) {
    check_normal(library, answer, result);
  }
  if (library.has(QUOIN_REFEREE_WITNESSES)) {
    check_witnesses(library, answer, result);
  }
}

void Judge::check_normal(const LibraryInfo& library, const Answer& answer,
                         Judgement& result) const {
  const double length = answer.normal.norm();
  if (length == 0) {
    return;  // none is given
  }
  if (!(std::abs(length - 1) <= 1e-12 + library.promised_error)) {
    expect(false, result, "normal", "its length is ", length);
    return;
  }
  const Real along = tests::gap_along(numbers_, answer.normal / length);
  const double short_of = static_cast<double>(gap_.gap - along);
  expect(short_of <= 2 * allowed_gap(library), result, "normal", "the solids are ", along,
         " apart along it, ", gap_.gap, " along the best");
}

void Judge::check_witnesses(const LibraryInfo& library, const Answer& answer,
                            Judgement& result) const {
  const double allowed = allowed_place(library);
  if (!answer.point_a.allFinite() || !answer.point_b.allFinite()) {
    expect(false, result, "not finite", "a witness");
    return;
  }
  for (const int side : {0, 1}) {
    const Vector3& point = side == 0 ? answer.point_a : answer.point_b;
    const double off = numbers_.distance(side, point, allowed);
    expect(off <= allowed, result, "witness", "the point on ", side == 0 ? "A" : "B", " is ", off,
           " off, allowed ", allowed);
  }
  const double apart = (answer.point_b - answer.point_a).norm();
  expect(std::abs(apart - std::abs(answer.gap)) <= 2 * allowed, result, "witness",
         "the points are ", apart, " apart where the gap is ", answer.gap);
}

void Judge::check_points(const LibraryInfo& library, const Answer& answer,
                         Judgement& result) const {
  const Vector3 normal = contact_normal(library, answer, gap_.normal);
  const double slack = allowed_place(library);
  const PlaneFrame frame(normal);
  std::vector<Place> places;
  Real area = 0;
  for (const ListedPoint& point : answer.points) {
    if (!point.point_a.allFinite() || !point.point_b.allFinite() || !std::isfinite(point.gap)) {
      expect(false, result, "not finite", "a contact point");
      return;
    }
    const double allowed = slack + (point.point_a == point.point_b ? std::abs(point.gap) : 0.0);
    const double off = std::max(numbers_.distance(0, point.point_a, allowed),
                                numbers_.distance(1, point.point_b, allowed));
    expect(off <= allowed, result, "point", "a contact point is ", off, " off its solid, allowed ",
           allowed);
    const Place a = frame.place(numbers_.place(point.point_a));
    const Place b = frame.place(numbers_.place(point.point_b));
    places.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2});
    area += point.area;
  }
  const ExactPatch patch = tests::exact_patch(
      numbers_, normal, {.tolerance = tolerance_, .decision = slack, .border = 2 * kEps * larger_});
  if (!patch.clear) {
    return;  // what belongs to the patch hangs on its tolerance
  }
  for (const tests::PatchCorner& corner : patch.corners) {
    const Real blur = 2 * slack / std::max(corner.sine, Real(kEps));
    const Real beyond = tests::distance_to_places(places, corner.place);
    const bool judged = corner.excess <= tolerance_ - slack &&
                        tests::ends_at(numbers_, normal, corner, tolerance_, smaller_);
    expect(!judged || beyond <= 2 * tolerance_ + blur, result, "missing corner",
           "a corner of the patch is ", beyond, " outside the points");
  }
  if (library.has(QUOIN_REFEREE_AREAS)) {
    const Real allowed = patch.perimeter * 2 * slack + slack * slack;
    expect(std::abs(area - patch.area) <= allowed, result, "area", area, ", exact ", patch.area,
           ", allowed error ", allowed);
  }
}

}  // namespace quoin::referee
