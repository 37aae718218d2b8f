#include "search/exact_answer.hpp"

#include "search/exact_overlap.hpp"
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
  // A line between solids that touch is rounding alone: it has no direction.
  const auto has_direction = [&] {
    return nearest.converged || !plane.form.joined || plane.form.crossed;
  };
  const bool same = !length.uneven && !found.middle &&
                    settle_normal(p, q, length, found.normal, plane) && has_direction() &&
                    plane.gap >= found.gap - slack(length.rounding, found.gap) &&
                    lies_over(p, q, plane, nullptr, -length.rounding);
  if (same) return;
  scan(p, q, found.normal, plane);
  find_sets(p, q, length, plane);
  plane.form = {};
  plane.gap = found.gap;
  optimum.loose = true;
}

}  // namespace quoin::geometry
