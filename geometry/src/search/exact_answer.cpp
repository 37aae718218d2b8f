#include "search/quick_answers.hpp"

#include "numeric/error_bounds.hpp"
#include "search/exact_search.hpp"
#include "search/proposals.hpp"

namespace quoin::geometry {

void exact_answer(const CanonicalPair& pair, int max_iterations, const SearchResult& known,
                  Optimum& optimum) {
  const Solid &p = pair.p, &q = pair.q;
  const Lengths& length = pair.length;
  const ActiveFeatures nearest =
      exact_nearest(p, q, {.p = known.p, .q = known.q, .corners = known.corners}, max_iterations);
  optimum.iterations += nearest.iterations;
  LeastOverlap found{.normal = nearest.normal, .gap = nearest.gap, .converged = nearest.converged};
  if (!nearest.converged) {
    found = exact_overlap(p, q, nearest);
    found.converged &= nearest.overlapping || found.gap <= length.rounding;
  }
  optimum.iterations += found.iterations;
  optimum.converged = found.converged;
  optimum.several = found.directions > 1;
  optimum.middle = found.middle;
  CandidatePlane& plane = optimum.plane;
  // Of solids that share a point the normal is that of the polytope: a line between them, or edges
  // that cross at a small angle, are rounding alone and have no direction. Of parallel edges it is
  // that of the search: from other vertices the line across them would be another, and may have
  // other features on it. And three vertices, two of which are one but for rounding, have none.
  const auto parallel_edges = [&] {
    if (plane.sets.p.size() != 2 || plane.sets.q.size() != 2) return false;
    return !feature_normal(p, q, plane.sets, found.normal, length.rounding).crossed;
  };
  const auto has_direction = [&] {
    return (plane.normal - found.normal).squaredNorm() < kOneDirection &&
           !(nearest.converged && parallel_edges());
  };
  // A line between features, formed in doubles, is turned by rounding over the gap: where that may
  // change what lies near the plane, or where the line ends, the search's own normal stands.
  const auto keeps_features = [&] {
    return (!nearest.converged || keeps_line(p, q, plane, length)) &&
           lies_over(p, q, plane, nullptr, -length.rounding);
  };
  scan(p, q, found.normal, plane);
  find_sets(p, q, length, plane);
  const bool same = !length.uneven && !found.middle && !(nearest.converged && parallel_edges()) &&
                    settle_normal(p, q, length, found.normal, plane) && has_direction() &&
                    plane.gap >= found.gap - slack(length.rounding, found.gap) && keeps_features();
  if (same) return;
  scan(p, q, found.normal, plane);
  find_sets(p, q, length, plane);
  plane.form = {};
  plane.gap = found.gap;
  optimum.loose = true;
}

}  // namespace quoin::geometry
