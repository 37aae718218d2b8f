#include "judge.hpp"

#include <quoin/referee.h>

#include <cmath>

#include "referee/pairs/judged.hpp"

namespace quoin::referee {
namespace {

using geometry::Vector3;
using Real = long double;

/// Within rounding of its nine numbers.
bool is_rotation(const geometry::Matrix3& linear) {
  return (linear.transpose() * linear - geometry::Matrix3::Identity()).cwiseAbs().maxCoeff() <=
         1e-14;
}

/// A normal as good as the answer's own, or the exact one where that is no direction.
Vector3 contact_normal(const LibraryInfo& library, const Answer& answer, const Vector3& exact) {
  const bool own = library.has(QUOIN_REFEREE_NORMAL) && answer.outcome == Outcome::Answered &&
                   std::abs(answer.normal.norm() - 1) <= 1e-6;
  return own ? answer.normal.normalized() : exact;
}

}  // namespace

Judge::Judge(const Question& question)
    : question_(question),
      numbers_(question.pair.a.placed, question.pair.b.placed),
      gap_(numbers_.gap()),
      sizes_(question.pair),
      boxes_(question.solids->a.is_box() && question.solids->b.is_box()),
      rotations_(is_rotation(question.pair.a.placed.placement.linear) &&
                 is_rotation(question.pair.b.placed.placement.linear)) {}

bool Judge::offered(const LibraryInfo& library) const {
  return gap_offered(library) || points_offered(library);
}

bool Judge::gap_offered(const LibraryInfo& library) const {
  const double allowed = allowed_gap(library);
  const bool apart = gap_.gap > allowed, overlapping = gap_.gap < -allowed;
  const bool of_this_sign = (library.has(QUOIN_REFEREE_SIGN) && (apart || overlapping)) ||
                            (library.has(QUOIN_REFEREE_DISTANCE) && !overlapping) ||
                            (library.has(QUOIN_REFEREE_DEPTH) && !apart);
  return of_this_sign && solids_offered(library);
}

bool Judge::solids_offered(const LibraryInfo& library) const {
  return (rotations_ || library.has(QUOIN_REFEREE_DEFORMED)) &&
         (boxes_ || !library.has(QUOIN_REFEREE_BOXES_ONLY));
}

bool Judge::points_offered(const LibraryInfo& library) const {
  const bool apart = gap_.gap > allowed_gap(library);
  return library.has(QUOIN_REFEREE_POINTS) && (!apart || library.has(QUOIN_REFEREE_APART)) &&
         solids_offered(library);
}

const Solid& Judge::refused(const Answer& answer) const {
  return answer.outcome == Outcome::RefusedA ? question_.pair.a : question_.pair.b;
}

Judgement Judge::judge(const LibraryInfo& library, const Answer& answer) const {
  Judgement result;
  result.asked = offered(library);
  switch (answer.outcome) {
    case Outcome::Crashed:
      result.faults.expect(false, "crash", "the library ended its process");
      return result;
    case Outcome::TimedOut:
      result.faults.expect(false, "hang", "no answer within the time limit");
      return result;
    case Outcome::RefusedA:
    case Outcome::RefusedB:
      result.faults.expect(!result.asked || refusal_is_right(refused(answer)), "refused",
                           "a solid within the promised range");
      return result;
    case Outcome::Failed:
      result.faults.expect(!gap_offered(library), "failed", "the library says so");
      break;
    case Outcome::Answered:
      if (gap_offered(library)) {
        result.answered = true;
        check_gap(library, answer, result);
      }
      break;
    case Outcome::NoAnswer:
      break;
  }
  if (points_offered(library)) {
    result.faults.expect(answer.points_outcome != Outcome::Failed, "failed",
                         "the library says so of the contact points");
    if (answer.points_outcome == Outcome::Answered) {
      result.answered = true;
      check_points(library, answer, result);
    }
  }
  return result;
}

void Judge::check_gap(const LibraryInfo& library, const Answer& answer, Judgement& result) const {
  if (!std::isfinite(answer.gap)) {
    result.faults.expect(false, "not finite", "gap ", answer.gap);
    return;
  }
  const double allowed = allowed_gap(library);
  if (library.has(QUOIN_REFEREE_SIGN)) {
    result.faults.expect(std::abs(gap_.gap) <= allowed || (answer.gap > 0) == (gap_.gap > 0),
                         "sign", "said to be ", answer.gap > 0 ? "apart" : "overlapping",
                         ", exact gap ", gap_.gap);
    return;
  }
  const double off = judge_gap(gap_, answer.gap, allowed, result.faults);
  result.gap_given = true;
  result.gap_error = off / sizes_.larger;
  if (off > allowed) return;  // what follows would say the same again
  if (library.has(QUOIN_REFEREE_NORMAL) && !answer.normal.isZero(0.0)) {  // else none is given
    judge_normal(numbers_, gap_, answer.normal, 1e-12 + library.promised_error, 2 * allowed,
                 result.faults);
  }
  if (library.has(QUOIN_REFEREE_WITNESSES)) check_witnesses(library, answer, result);
}

void Judge::check_witnesses(const LibraryInfo& library, const Answer& answer,
                            Judgement& result) const {
  const double allowed = allowed_place(library);
  if (!answer.point_a.allFinite() || !answer.point_b.allFinite()) {
    result.faults.expect(false, "not finite", "a witness");
    return;
  }
  judge_places(numbers_, {answer.point_a, answer.point_b}, allowed, "witness", 0.0, result.faults);
  const double apart = (answer.point_b - answer.point_a).norm();
  result.faults.expect(std::abs(apart - std::abs(answer.gap)) <= 2 * allowed, "witness",
                       "the points are ", apart, " apart where the gap is ", answer.gap);
}

void Judge::check_points(const LibraryInfo& library, const Answer& answer,
                         Judgement& result) const {
  const Vector3 normal = contact_normal(library, answer, gap_.normal);
  const double slack = allowed_place(library);
  Real area = 0;
  for (const ListedPoint& point : answer.points) {
    if (!point.point_a.allFinite() || !point.point_b.allFinite() || !std::isfinite(point.gap)) {
      result.faults.expect(false, "not finite", "a contact point");
      return;
    }
    const double allowed = slack + (point.point_a == point.point_b ? std::abs(point.gap) : 0.0);
    judge_places(numbers_, {point.point_a, point.point_b}, allowed, "point", 0.0, result.faults);
    area += point.area;
  }
  const double tolerance = question_.solids->contact_length;
  if (tolerance == 0) return;
  const ExactPatch patch = judged_patch(numbers_, normal, tolerance, slack, sizes_);
  if (!patch.clear) return;  // what belongs to the patch hangs on its tolerance
  judge_corners(numbers_, normal, patch, middles(numbers_, PlaneFrame(normal), answer.points),
                {tolerance, sizes_.smaller, sizes_.allowed_gap(0)}, slack, result.faults);
  if (library.has(QUOIN_REFEREE_AREAS)) {
    const Real allowed = patch.perimeter * 2 * slack + slack * slack;
    result.faults.expect(std::abs(area - patch.area) <= allowed, "area", area, ", exact ",
                         patch.area, ", allowed error ", allowed);
  }
}

}  // namespace quoin::referee
