#include "search/quick_answers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "numeric/error_bounds.hpp"
#include "search/nearest_feature_search.hpp"
#include "search/proposals.hpp"
#include "search/touching_faces.hpp"

namespace quoin::geometry {
namespace {

/// At least three corners of each solid.
struct Spanning {
  std::span<const int> a, b;
};

/// The features that three corners each span as an ordinary answer.
bool found_answer(const Solid& a, const Solid& b, const Lengths& length, const Spanning& by_corners,
                  const Overlap* overlap, NearestFeatures& answer) {
  Carrier by_a, by_b;
  return corner_carrier(a, by_corners.a, by_a) && corner_carrier(b, by_corners.b, by_b) &&
         certify(a, b, by_a, by_b, length, overlap, answer) == Trial::Proved;
}

/// The least overlap from where the search found that there is one.
void grow(const CanonicalPair& pair, Quick& quick) {
  quick.grown = true;
  if (quick.found.corners == 1) {  // in a corner of the set of differences many planes meet
    quick.found.outcome = SearchOutcome::Unclear;
    return;
  }
  quick.found = expand_polytope(pair.p, pair.q, quick.found, kSearchShare * pair.length.rounding);
  quick.iterations += quick.found.iterations;
}

bool are_bricks(const Solid& a, const Solid& b) {
  return !a.topology().brick().empty() && !b.topology().brick().empty();
}

/// The normal of the face that parts two solids with the faces of a brick most, from P to Q.
Vector3 parting_normal(const Solid& p, const Solid& q) {
  constexpr std::array<int, 6> kFaces{0, 1, 2, 3, 4, 5};
  const PartingFace by_p = parting_face(p, q, kFaces), by_q = parting_face(q, p, kFaces);
  if (by_q.gap > by_p.gap) return -q.face_normal(by_q.face);
  return p.face_normal(std::max(by_p.face, 0));
}

/// The least overlap of two bricks, where it is clear.
bool part_bricks(const CanonicalPair& pair, Quick& quick) {
  const SearchResult found = box_sat(pair.p, pair.q, pair.length.rounding);
  if (found.outcome == SearchOutcome::Touching) quick.middle = found.normal;
  if (found.outcome == SearchOutcome::Unclear) {
    const bool even = found.normal != Vector3::Zero();
    quick.facing = even ? found.normal : parting_normal(pair.p, pair.q);
  }
  if (found.outcome != SearchOutcome::Overlapping) return false;
  quick.searched = true;
  quick.found = found;
  quick.iterations += found.iterations;
  return quick.grown = true;
}

/// The least overlap as an ordinary answer.
bool overlapping_answer(const CanonicalPair& pair, Quick& quick, NearestFeatures& answer) {
  const double rounding = pair.length.rounding;
  if (!quick.grown) {
    grow(pair, quick);
    if (quick.found.outcome != SearchOutcome::Overlapping) return false;
  }
  const SearchResult& found = quick.found;
  const Overlap overlap{found.normal, least_gap(found, rounding)};
  if (!found_answer(pair.p, pair.q, pair.length, {found.p, found.q}, &overlap, answer))
    return false;
  if (pair.reversed) swap_names(answer);
  return true;
}

/// Solids that touch at a vertex or along an edge: the middle of the planes between them. Its gap
/// is nothing within rounding, and the features that carry it lie over each other: no plane is
/// better by more than that, for there the solids share a point.
bool middle_plane(const CanonicalPair& pair, const Vector3& middle, Optimum& optimum) {
  const Solid &p = pair.p, &q = pair.q;
  const Lengths& length = pair.length;
  CandidatePlane& plane = optimum.plane;
  scan(p, q, middle, plane);
  if (!(std::abs(plane.gap) <= length.rounding)) return false;
  find_sets(p, q, length, plane);
  if (!lies_over(p, q, plane, nullptr, -length.rounding)) return false;
  return optimum.converged = optimum.several = optimum.middle = true;
}

/// Describes what `find` proves.
template <class Find>
bool proved_answer(const CanonicalPair& pair, Quick& quick, NearestFeatures& answer,
                   const Find& find) {
  LateInit<ContactPolygon> own;
  Optimum optimum(quick.faces != nullptr ? *quick.faces : own);
  if (!find(optimum)) {
    optimum.faces.reset();
    return false;
  }
  describe_best(pair, optimum, answer);
  quick.iterations += optimum.iterations;
  if (pair.reversed) swap_names(answer);
  return true;
}

/// Bricks that touch, from what the directions of their faces and edges have shown.
[[gnu::noinline]] bool touching_answer(const CanonicalPair& pair, Quick& quick,
                                       NearestFeatures& answer) {
  if (!quick.middle && !quick.facing) return false;
  return proved_answer(pair, quick, answer, [&](Optimum& optimum) {
    const auto& [p, q, reversed, length] = pair;
    if (quick.middle) return middle_plane(pair, *quick.middle, optimum);
    CandidatePlane near;
    scan(p, q, *quick.facing, near);
    return whole_faces(p, q, length, near, optimum) ||
           touching_faces(p, q, length, *quick.facing, optimum);
  });
}

/// Two bricks, by box SAT; `quick.searched` where it has found the least overlap.
bool brick_answer(const CanonicalPair& pair, Quick& quick, NearestFeatures& answer) {
  if (part_bricks(pair, quick)) return overlapping_answer(pair, quick, answer);
  return touching_answer(pair, quick, answer);
}

}  // namespace

void describe_best(const CanonicalPair& pair, Optimum& optimum, NearestFeatures& answer) {
  const Solid &p = pair.p, &q = pair.q;
  const Lengths& length = pair.length;
  Optimum clear(optimum.faces);
  const bool doubtful =
      optimum.converged && !optimum.straight && !optimum.several && !length.uneven;
  const bool straight = doubtful && (whole_faces(p, q, length, optimum.plane, clear) ||
                                     near_features(p, q, length, optimum, clear));
  optimum.iterations += clear.iterations;
  describe(p, q, straight ? clear : optimum, length, answer);
}

bool searched_answer(const Solid& a, const Solid& b, const Lengths& length, const FeatureHint& hint,
                     Quick& quick, NearestFeatures& answer) {
  const bool hinted = hint.vertices_a[0] >= 0;
  if (hinted && corner_answer(a, b, length, quick.iterations, answer)) return true;
  if (are_bricks(a, b) && brick_answer(ordered(a, b, length), quick, answer)) return true;
  if (quick.searched) return false;
  const SearchResult found = nearest_feature_search(a, b, b.vertex_mean() - a.vertex_mean(),
                                                    kSearchShare * length.rounding);
  quick.iterations += found.iterations;
  const bool overlapping = found.outcome == SearchOutcome::Overlapping;
  if (!overlapping && found_answer(a, b, length, {found.p, found.q}, nullptr, answer)) return true;
  const CanonicalPair pair = ordered(a, b, length);
  quick.searched = true;
  quick.found = found;
  if (pair.reversed) quick.found = swapped(quick.found);
  return overlapping && overlapping_answer(pair, quick, answer);
}

bool fast_answer(const CanonicalPair& pair, const Quick& quick, Optimum& optimum) {
  const Solid &p = pair.p, &q = pair.q;
  const Lengths& length = pair.length;
  const SearchResult& found = quick.found;
  const bool overlapping = found.outcome == SearchOutcome::Overlapping;
  if (found.outcome == SearchOutcome::Unclear) return false;
  // Of two nearly parallel planes, as good within rounding, the one where the features meet.
  const double least = least_gap(found, length.rounding);
  // Solids that touch it leaves open whether others are as good.
  const auto best = [&] {
    const CandidatePlane& plane = optimum.plane;
    if (!(plane.gap >= least)) return false;
    return overlapping ? lies_firmly_over(p, q, plane, optimum.laid(), length)
                       : proves_optimum(p, q, plane, optimum.laid(), length);
  };
  take_corners(p, q, found, optimum.plane.sets);
  optimum.straight = straight_plane(p, q, length, found.normal, optimum) && best();
  if (optimum.straight) return optimum.converged = true;
  optimum.faces.reset();
  return optimum.converged = settle_corners(p, q, found, length, optimum.plane) && best();
}

}  // namespace quoin::geometry
