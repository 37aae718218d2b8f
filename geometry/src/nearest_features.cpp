#include <quoin/geometry/nearest_features.hpp>

#include <cmath>
#include <limits>
#include <utility>

#include "closed_form.hpp"
#include "fast_search.hpp"
#include "pair_order.hpp"
#include "patch.hpp"
#include "wide_search.hpp"

namespace quoin::geometry {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// Lengths that decide, m.
struct Lengths {
  double contact = 0.0;   // the tolerance of features and status
  double rounding = 0.0;  // what the support functions and normals of doubles may be off
  double place = 0.0;     // what the rounding of coordinates leaves of a place in the world
  bool uneven = false;    // the rounding of the larger solid would show on the smaller one
};

Lengths lengths(const Polyhedron& p, const Polyhedron& q, const SearchOptions& options) {
  Lengths length;
  length.contact = options.tolerance > 0.0 ? options.tolerance : default_tolerance(p, q);
  constexpr double kUneven = 1e4;
  const double larger = std::max(p.diameter(), q.diameter());
  length.rounding = 5 * kEpsilon * larger;
  length.uneven = larger > kUneven * std::min(p.diameter(), q.diameter());
  const double coordinate = std::max(p.largest_coordinate(), q.largest_coordinate());
  length.place = std::max(length.rounding, 2 * kEpsilon * coordinate);
  return length;
}

/// A plane between the solids: its normal, how far each reaches, what carries it.
struct Plane {
  Vector3 normal = Vector3::UnitX();
  Support support_p, support_q;
  double gap = 0.0;  // m
  ContactSets sets;
  bool joined = false;  // the shortest line between vertices or edges lies within both
};

void find_sets(const Polyhedron& p, const Polyhedron& q, const Plane& plane, double length,
               ContactSets& sets) {
  find_vertices_beyond(p, plane.normal, plane.support_p.value - length, sets.p);
  find_vertices_beyond(q, -plane.normal, plane.support_q.value - length, sets.q);
  sets.face_p = covered_face(p, sets.p, plane.normal);
  sets.face_q = covered_face(q, sets.q, -plane.normal);
}

void scan(const Polyhedron& p, const Polyhedron& q, const Vector3& normal, Plane& plane) {
  plane.normal = normal;
  const PairSupport both = support_pair(p, q, normal);
  plane.support_p = both.p;
  plane.support_q = both.q;
  plane.gap = normal.dot(q.vertex(plane.support_q.vertex) - p.vertex(plane.support_p.vertex));
}

/// Replaces a normal found somehow by the closed form of the sets that carry it. False where the
/// sets are of no simple kind or the closed form is carried by other sets.
bool settle(const Polyhedron& p, const Polyhedron& q, double rounding, Plane& plane) {
  find_sets(p, q, plane, rounding, plane.sets);
  const ClosedForm form = closed_form(p, q, plane.sets, plane.normal, rounding);
  if (!form.found) return false;
  plane.joined = form.joined;
  if (form.normal == plane.normal) return true;
  scan(p, q, form.normal, plane);
  ContactSets again;
  find_sets(p, q, plane, rounding, again);
  return again == plane.sets;
}

/// What is known in the end.
struct Optimum {
  Plane plane;
  bool several = false, middle = false;
  bool converged = false;
  int iterations = 0;
};

/// The two contact features laid into the contact plane.
struct PatchPair {
  ContactPlane plane;
  Patch p, q;
  PatchPair(const Polyhedron& solid_p, const Polyhedron& solid_q, const Plane& contact,
            const ContactSets& sets, double length)
      : plane(solid_p.vertex(contact.support_p.vertex), contact.normal) {
    lay_support_set(solid_p, sets.p, span_kind(solid_p, sets.p, length), plane, 1.0, p);
    lay_support_set(solid_q, sets.q, span_kind(solid_q, sets.q, length), plane, -1.0, q);
  }
};

/// The plane carries a facet of the Minkowski difference. Proves that no other facet is nearer to
/// the origin: always so when the solids are apart and the origin projects into the facet; for an
/// overlap d, when it does so at least r = d / margin <= 1 from the border and a known inner point
/// (the difference of the vertex means) lies deep enough. See geometry/README.md, "Shallow
/// overlap".
bool proves_optimum(const Polyhedron& p, const Polyhedron& q, const Plane& plane, double rounding) {
  const bool apart = plane.gap > 8 * rounding;  // nearer than that several planes may be as good
  if (plane.joined && apart) return true;
  const PatchPair patches(p, q, plane, plane.sets, rounding);
  const double margin = overlap_margin(patches.p, patches.q);
  if (apart) return margin >= -rounding;
  const double depth = -plane.gap * (1.0 + 1e-9) + 64 * rounding;  // by so much the only one, too
  if (depth > margin) return false;
  const double ratio = depth / margin;
  const Vector3 inner = q.vertex_mean() - p.vertex_mean();
  const double down = inner.dot(plane.normal);
  const double aside = (inner - down * plane.normal).norm();
  return (1.0 - ratio * ratio) * down - 2.0 * ratio * aside >= depth * (1.0 + ratio * ratio);
}

bool usable(const std::array<int, 4>& vertices, const Polyhedron& polyhedron) {
  return vertices[0] >= 0 && vertices[0] < polyhedron.vertex_count();
}

void add_vertices(const std::array<int, 4>& vertices, const Polyhedron& polyhedron,
                  VertexSet& set) {
  for (const int v : vertices) {
    if (v >= 0 && v < polyhedron.vertex_count() && !set.contains(v)) set.push_back(v);
  }
  std::sort(set.begin(), set.end());
}

/// No vertex so near the limit of the sets that another way to the answer could sort it otherwise,
/// or that another plane through nearly the same vertices is as good: then the search starts cold.
bool sets_are_clear(const Polyhedron& p, const Polyhedron& q, const Plane& plane, double rounding) {
  ContactSets narrow, wide;
  const auto find = [&](double length, ContactSets& sets) {
    find_vertices_beyond(p, plane.normal, plane.support_p.value - length, sets.p);
    find_vertices_beyond(q, -plane.normal, plane.support_q.value - length, sets.q);
  };
  find(0.5 * rounding, narrow);
  find(64.0 * rounding, wide);
  return narrow == plane.sets && wide == plane.sets;
}

/// Last step's features first: if they carry the optimum still, and clearly, that is the answer.
bool warm_answer(const Polyhedron& p, const Polyhedron& q, const FeatureHint& hint, double rounding,
                 Optimum& optimum) {
  if (!usable(hint.vertices_a, p) || !usable(hint.vertices_b, q)) return false;
  ContactSets sets;
  add_vertices(hint.vertices_a, p, sets.p);
  add_vertices(hint.vertices_b, q, sets.q);
  const auto valid = [](int face, const Polyhedron& solid) {
    return face >= 0 && face < solid.topology().face_count() ? face : -1;
  };
  sets.face_p = valid(hint.face_a, p);
  sets.face_q = valid(hint.face_b, q);
  const ClosedForm form = closed_form(p, q, sets, hint.normal, rounding);
  if (!form.found) return false;
  Plane& plane = optimum.plane;
  scan(p, q, form.normal, plane);
  if (!settle(p, q, rounding, plane) || !sets_are_clear(p, q, plane, rounding)) return false;
  if (!proves_optimum(p, q, plane, rounding)) return false;
  optimum.converged = true;
  optimum.iterations = 1;
  return true;
}

/// Few faces: the best of their planes costs less than one step of the search and often is the
/// answer.
bool face_answer(const Polyhedron& p, const Polyhedron& q, double rounding, Optimum& optimum) {
  const Vector3 towards = q.vertex_mean() - p.vertex_mean();
  Plane& best = optimum.plane;
  best.gap = -std::numeric_limits<double>::infinity();
  Plane candidate;
  const auto consider = [&](const Vector3& normal) {
    if (!(normal.dot(towards) > 0.0)) return;
    scan(p, q, normal, candidate);
    if (candidate.gap > best.gap) {
      best.normal = candidate.normal;
      best.support_p = candidate.support_p;
      best.support_q = candidate.support_q;
      best.gap = candidate.gap;
    }
  };
  for (int f = 0; f < p.topology().face_count(); ++f) consider(p.face_normal(f));
  for (int f = 0; f < q.topology().face_count(); ++f) consider(-q.face_normal(f));
  if (!std::isfinite(best.gap)) return false;
  const Vector3 direction = best.normal;
  optimum.iterations = 1;
  optimum.converged = settle(p, q, rounding, best) && proves_optimum(p, q, best, rounding);
  if (!optimum.converged) best.normal = direction;
  return optimum.converged;
}

/// By how much the gap of a settled plane may miss the bound that the search proved, m.
double slack(double rounding, double gap) { return rounding + 8 * kEpsilon * std::abs(gap); }

/// The normal that the last corners of the search define: for short distances the search's own line
/// between vertices and edges has lost the digits that tell which vertices carry it.
Vector3 corner_normal(const Polyhedron& p, const Polyhedron& q, const FastResult& found,
                      double rounding) {
  ContactSets sets;
  for (int k = 0; k < found.corners; ++k) {
    const int i = found.p[static_cast<std::size_t>(k)], j = found.q[static_cast<std::size_t>(k)];
    if (!sets.p.contains(i)) sets.p.push_back(i);
    if (!sets.q.contains(j)) sets.q.push_back(j);
  }
  const ClosedForm form = closed_form(p, q, sets, found.normal, rounding);
  return form.found ? form.normal : found.normal;
}

bool fast_answer(const Polyhedron& p, const Polyhedron& q, double rounding, Optimum& optimum) {
  constexpr int kFewFaces = 16;
  Vector3 direction = q.vertex_mean() - p.vertex_mean();
  if (p.topology().face_count() + q.topology().face_count() <= kFewFaces) {
    if (face_answer(p, q, rounding, optimum)) return true;
    direction = optimum.plane.normal;
  }
  FastResult found = fast_nearest(p, q, direction, 0.25 * rounding);
  optimum.iterations += found.iterations;
  if (found.outcome == FastOutcome::Overlapping) {
    found = fast_overlap(p, q, found, 0.25 * rounding);
    optimum.iterations += found.iterations;
  }
  if (found.outcome == FastOutcome::Unclear) return false;
  scan(p, q, corner_normal(p, q, found, rounding), optimum.plane);
  if (!settle(p, q, rounding, optimum.plane)) return false;
  const bool overlapping = found.outcome == FastOutcome::Overlapping;
  const double allowed = overlapping ? 2.2 * rounding : rounding;
  optimum.converged = optimum.plane.gap >= found.bound - slack(allowed, found.bound);
  if (optimum.converged && overlapping) {
    // Of two nearly parallel planes the one where the features lie over each other.
    const PatchPair patches(p, q, optimum.plane, optimum.plane.sets, rounding);
    optimum.converged = overlap_margin(patches.p, patches.q) >= -rounding;
  }
  return optimum.converged;
}

/// Whatever doubles could not decide.
void wide_answer(const Polyhedron& p, const Polyhedron& q, int max_iterations,
                 const Lengths& length, Optimum& optimum) {
  const double rounding = length.rounding;
  ActiveFeatures found = wide_nearest(p, q, max_iterations);
  optimum.iterations += found.iterations;
  if (found.overlapping) found = exhaustive_overlap(p, q);
  optimum.converged = found.converged;
  optimum.several = found.several;
  optimum.middle = found.middle;
  scan(p, q, found.normal, optimum.plane);
  const bool same = !length.uneven && !found.middle && settle(p, q, rounding, optimum.plane) &&
                    optimum.plane.gap >= found.gap - slack(rounding, found.gap);
  if (same) return;
  scan(p, q, found.normal, optimum.plane);
  find_sets(p, q, optimum.plane, rounding, optimum.plane.sets);
  optimum.plane.gap = found.gap;
}

/// Witness points: of the shared part of the two features that rounding cannot tell from parallel.
void set_witnesses(const Polyhedron& p, const Polyhedron& q, const Plane& contact,
                   const Lengths& length, NearestFeatures& answer) {
  ContactSets wider;
  if (length.place > length.rounding) find_sets(p, q, contact, length.place, wider);
  const ContactSets& sets = length.place > length.rounding ? wider : contact.sets;
  const Vector3 across = answer.gap * answer.normal;
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
  const PatchPair patches(p, q, contact, sets, length.place);
  SharedCorners corners;
  append_shared_corners(patches.p, patches.q, 2 * length.place + kEpsilon * std::abs(answer.gap),
                        corners);
  Vector2 place = Vector2::Zero();
  if (corners.empty()) {
    place = nearest_place(patches.p, patches.q);
  } else {
    SharedPolygon polygon;
    find_polygon(corners, polygon);
    place = polygon.centroid;
  }
  answer.point_a = patches.plane.point(place, 0.0);
  answer.point_b = answer.point_a + across;
}

/// Features within the contact tolerance and what they leave open.
void set_features(const Polyhedron& p, const Polyhedron& q, const Optimum& optimum,
                  double tolerance, NearestFeatures& answer) {
  const Plane& plane = optimum.plane;
  ContactSets sets;
  find_vertices_beyond(p, plane.normal, plane.support_p.value - tolerance, sets.p);
  find_vertices_beyond(q, -plane.normal, plane.support_q.value - tolerance, sets.q);
  const FeatureKind kind_p = span_kind(p, sets.p, tolerance);
  const FeatureKind kind_q = span_kind(q, sets.q, tolerance);
  answer.feature_a = name_support_set(p, sets.p, kind_p, answer.normal);
  answer.feature_b = name_support_set(q, sets.q, kind_q, -answer.normal);
  const Vector3 high = p.vertex(plane.support_p.vertex), low = q.vertex(plane.support_q.vertex);
  answer.residual_a = std::max(0.0, answer.normal.dot(high - answer.point_a));
  answer.residual_b = std::max(0.0, answer.normal.dot(answer.point_b - low));
  const ContactType type = type_of(p, q, sets.p, sets.q, kind_p, kind_q, tolerance);
  const bool open = type == ContactType::VertexVertex || type == ContactType::VertexEdge ||
                    type == ContactType::EdgeEdgeParallel;
  answer.indeterminate = open || optimum.several;
  answer.rule = optimum.middle    ? PlaneRule::MiddleOfPlanes
                : optimum.several ? PlaneRule::LeastOverlap
                : open            ? PlaneRule::ShortestLine
                                  : PlaneRule::Unique;
}

void set_hint(const Plane& plane, NearestFeatures& answer) {
  for (std::size_t k = 0; k < 4; ++k) {
    answer.hint.vertices_a[k] = k < plane.sets.p.size() ? plane.sets.p[k] : -1;
    answer.hint.vertices_b[k] = k < plane.sets.q.size() ? plane.sets.q[k] : -1;
  }
  answer.hint.face_a = plane.sets.face_p;
  answer.hint.face_b = plane.sets.face_q;
  answer.hint.normal = answer.normal;
}

NearestFeatures ordered_answer(const Polyhedron& p, const Polyhedron& q,
                               const SearchOptions& options, const FeatureHint& hint) {
  const Lengths length = lengths(p, q, options);
  Optimum optimum;
  if (length.uneven || (!warm_answer(p, q, hint, length.rounding, optimum) &&
                        !fast_answer(p, q, length.rounding, optimum))) {
    wide_answer(p, q, options.max_iterations, length, optimum);
  }
  NearestFeatures answer;
  answer.iterations = optimum.iterations;
  answer.normal = optimum.plane.normal;
  answer.gap = optimum.plane.gap;
  set_witnesses(p, q, optimum.plane, length, answer);
  set_features(p, q, optimum, length.contact, answer);
  set_hint(optimum.plane, answer);
  if (optimum.converged) {
    answer.status = std::abs(answer.gap) <= length.contact ? PairStatus::Touching
                    : answer.gap > 0.0                     ? PairStatus::Separated
                                                           : PairStatus::Overlapping;
  }
  return answer;
}

void swap_names(FeatureHint& hint) {
  hint.normal = -hint.normal;
  std::swap(hint.vertices_a, hint.vertices_b);
  std::swap(hint.face_a, hint.face_b);
}

void swap_names(NearestFeatures& answer) {
  answer.normal = -answer.normal;
  std::swap(answer.point_a, answer.point_b);
  std::swap(answer.feature_a, answer.feature_b);
  std::swap(answer.residual_a, answer.residual_b);
  swap_names(answer.hint);
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
  if (!worked_in_reverse(a, b)) return ordered_answer(a, b, options, hint);
  FeatureHint reversed = hint;
  swap_names(reversed);
  NearestFeatures answer = ordered_answer(b, a, options, reversed);
  swap_names(answer);
  return answer;
}

}  // namespace quoin::geometry
