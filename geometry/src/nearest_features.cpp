#include <quoin/geometry/nearest_features.hpp>

#include <cmath>
#include <limits>
#include <utility>

#include "pair_order.hpp"
#include "patch.hpp"
#include "wide_search.hpp"

namespace quoin::geometry {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// The support sets of a pair along a normal, within a length of the extreme.
struct SupportSets {
  VertexSet p, q;
  Support support_p, support_q;
  FeatureKind kind_p = FeatureKind::Vertex, kind_q = FeatureKind::Vertex;
  SupportSets(const Polyhedron& solid_p, const Polyhedron& solid_q, const Vector3& normal,
              double length)
      : support_p(support(solid_p, normal)), support_q(support(solid_q, -normal)) {
    find_vertices_beyond(solid_p, normal, support_p.value - length, p);
    find_vertices_beyond(solid_q, -normal, support_q.value - length, q);
    kind_p = span_kind(solid_p, p, length);
    kind_q = span_kind(solid_q, q, length);
  }
};

ActiveFeatures find_optimum(const Polyhedron& p, const Polyhedron& q, int max_iterations) {
  ActiveFeatures found = wide_nearest(p, q, max_iterations);
  if (!found.overlapping) return found;
  const int iterations = found.iterations;
  found = exhaustive_overlap(p, q);
  found.iterations += iterations;
  return found;
}

/// Where two lines of the pair cross seen along the normal: share of the way along the edge of P.
double crossing_share(const Polyhedron& p, const Polyhedron& q, const ActiveFeatures& found) {
  const Vector3 base = p.vertex(found.p[0]);
  const Vector3 e = p.vertex(found.p[1]) - base, f = q.vertex(found.q[1]) - q.vertex(found.q[0]);
  const Vector3 side = f.cross(found.normal);
  const double denominator = e.dot(side);
  if (denominator == 0.0) return 0.5;
  return std::clamp((q.vertex(found.q[0]) - base).dot(side) / denominator, 0.0, 1.0);
}

/// Witness points: of the shared part of the two features that rounding cannot tell from parallel.
void set_witnesses(const Polyhedron& p, const Polyhedron& q, const ActiveFeatures& found,
                   NearestFeatures& answer) {
  const double larger = std::max(p.diameter(), q.diameter());
  const double coordinate = std::max(p.largest_coordinate(), q.largest_coordinate());
  const double rounding = kEpsilon * std::max(4 * larger, 2 * coordinate);
  const Vector3 across = answer.gap * answer.normal;
  const SupportSets sets(p, q, answer.normal, rounding);
  if (sets.p.size() == 1) {
    answer.point_a = p.vertex(sets.p[0]);
    answer.point_b = sets.q.size() == 1 && answer.gap > 0.0 ? q.vertex(sets.q[0])
                                                            : Vector3(answer.point_a + across);
    return;
  }
  if (sets.q.size() == 1) {
    answer.point_b = q.vertex(sets.q[0]);
    answer.point_a = answer.point_b - across;
    return;
  }
  const ContactPlane plane(p.vertex(sets.support_p.vertex), answer.normal);
  Patch patch_p, patch_q;
  lay_support_set(p, sets.p, sets.kind_p, plane, 1.0, patch_p);
  lay_support_set(q, sets.q, sets.kind_q, plane, -1.0, patch_q);
  SharedCorners corners;
  append_shared_corners(patch_p, patch_q, 2 * rounding + kEpsilon * std::abs(answer.gap), corners);
  if (!corners.empty()) {
    SharedPolygon polygon;
    find_polygon(corners, polygon);
    answer.point_a = plane.point(polygon.centroid, 0.0);
    answer.point_b = answer.point_a + across;
  } else if (found.q_count == 1) {
    answer.point_b = q.vertex(found.q[0]);
    answer.point_a = answer.point_b - across;
  } else {
    const Vector3 base = p.vertex(found.p[0]);
    const double share = found.p_count == 1 ? 0.0 : crossing_share(p, q, found);
    answer.point_a = share > 0.0 ? Vector3(base + share * (p.vertex(found.p[1]) - base)) : base;
    answer.point_b = answer.point_a + across;
  }
}

/// Features within the contact tolerance and what they leave open.
void set_features(const Polyhedron& p, const Polyhedron& q, const ActiveFeatures& found,
                  double tolerance, NearestFeatures& answer) {
  const SupportSets sets(p, q, answer.normal, tolerance);
  answer.feature_a = name_support_set(p, sets.p, sets.kind_p, answer.normal);
  answer.feature_b = name_support_set(q, sets.q, sets.kind_q, -answer.normal);
  answer.residual_a =
      std::max(0.0, answer.normal.dot(p.vertex(sets.support_p.vertex) - answer.point_a));
  answer.residual_b =
      std::max(0.0, -answer.normal.dot(q.vertex(sets.support_q.vertex) - answer.point_b));
  const ContactType type = type_of(p, q, sets.p, sets.q, sets.kind_p, sets.kind_q, tolerance);
  const bool open = type == ContactType::VertexVertex || type == ContactType::VertexEdge ||
                    type == ContactType::EdgeEdgeParallel;
  answer.indeterminate = open || found.several;
  answer.rule = found.middle    ? PlaneRule::MiddleOfPlanes
                : found.several ? PlaneRule::LeastOverlap
                : open          ? PlaneRule::ShortestLine
                                : PlaneRule::Unique;
}

void set_hint(const ActiveFeatures& found, NearestFeatures& answer) {
  for (int k = 0; k < found.p_count; ++k) {
    answer.hint.vertices_a[static_cast<std::size_t>(k)] = found.p[static_cast<std::size_t>(k)];
  }
  for (int k = 0; k < found.q_count; ++k) {
    answer.hint.vertices_b[static_cast<std::size_t>(k)] = found.q[static_cast<std::size_t>(k)];
  }
  answer.hint.normal = answer.normal;
}

NearestFeatures ordered_answer(const Polyhedron& p, const Polyhedron& q,
                               const SearchOptions& options) {
  const double tolerance = options.tolerance > 0.0 ? options.tolerance : default_tolerance(p, q);
  const ActiveFeatures found = find_optimum(p, q, options.max_iterations);
  NearestFeatures answer;
  answer.iterations = found.iterations;
  answer.normal = found.normal;
  answer.gap = found.gap;
  set_witnesses(p, q, found, answer);
  set_features(p, q, found, tolerance, answer);
  set_hint(found, answer);
  if (found.converged) {
    answer.status = std::abs(answer.gap) <= tolerance ? PairStatus::Touching
                    : answer.gap > 0.0                ? PairStatus::Separated
                                                      : PairStatus::Overlapping;
  }
  return answer;
}

void swap_names(NearestFeatures& answer) {
  answer.normal = -answer.normal;
  answer.hint.normal = -answer.hint.normal;
  std::swap(answer.point_a, answer.point_b);
  std::swap(answer.feature_a, answer.feature_b);
  std::swap(answer.residual_a, answer.residual_b);
  std::swap(answer.hint.vertices_a, answer.hint.vertices_b);
}

}  // namespace

std::string_view name(PairStatus status) {
  switch (status) {
    case PairStatus::Separated:
      return "separated";
    case PairStatus::Touching:
      return "touching";
    case PairStatus::Overlapping:
      return "overlapping";
    case PairStatus::NotConverged:
      return "not-converged";
  }
  return "";
}

std::string_view name(PlaneRule rule) {
  switch (rule) {
    case PlaneRule::Unique:
      return "unique";
    case PlaneRule::ShortestLine:
      return "shortest-line";
    case PlaneRule::LeastOverlap:
      return "least-overlap";
    case PlaneRule::MiddleOfPlanes:
      return "middle-of-planes";
  }
  return "";
}

double default_tolerance(const Polyhedron& a, const Polyhedron& b) {
  return std::max(1e-9 * std::min(a.diameter(), b.diameter()),
                  16 * kEpsilon * std::max(a.largest_coordinate(), b.largest_coordinate()));
}

NearestFeatures nearest_features(const Polyhedron& a, const Polyhedron& b,
                                 const SearchOptions& options, const FeatureHint& hint) {
  (void)hint;
  if (!worked_in_reverse(a, b)) return ordered_answer(a, b, options);
  NearestFeatures answer = ordered_answer(b, a, options);
  swap_names(answer);
  return answer;
}

}  // namespace quoin::geometry
