#include "search/proposals.hpp"

#include "numeric/error_bounds.hpp"
#include "numeric/floating_point.hpp"
#include "search/touching_faces.hpp"

namespace quoin::geometry {
namespace {

/// Ascending, each once.
void insert_sorted(int v, VertexSet& set) {
  std::size_t k = set.size();
  while (k > 0 && set[k - 1] > v) --k;
  if (k > 0 && set[k - 1] == v) return;
  set.push_back(v);
  for (std::size_t i = set.size() - 1; i > k; --i) set[i] = set[i - 1];
  set[k] = v;
}

/// The vertices of a hint and those of the face that it names: in order when the hint is our own.
/// False: no vertex, or more than two that are not just those of the face. Another face may then
/// name the same vertices, or none, and its normal has other last bits.
bool add_hinted(const std::array<int, 4>& vertices, int face, const Solid& polyhedron,
                VertexSet& set, int& known_face) {
  const int count = polyhedron.vertex_count();
  known_face = face >= 0 && face < polyhedron.topology().face_count() ? face : -1;
  if (known_face >= 0) set.assign(polyhedron.topology().face_set(known_face));
  for (std::size_t k = 0; k < 4; ++k) {
    const int v = vertices[k];
    const bool known = k < set.size() && set[k] == v;
    if (!known && v >= 0 && v < count) insert_sorted(v, set);
  }
  const bool whole =
      known_face >= 0 && set.size() == polyhedron.topology().face_set(known_face).size();
  return vertices[0] >= 0 && vertices[0] < count && (whole || set.size() <= 2);
}

}  // namespace

bool hinted_plane(const Solid& p, const Solid& q, const FeatureHint& hint, const Lengths& length,
                  Optimum& optimum) {
  ContactSets& sets = optimum.plane.sets;
  if (!add_hinted(hint.vertices_a, hint.face_a, p, sets.p, sets.face_p) ||
      !add_hinted(hint.vertices_b, hint.face_b, q, sets.q, sets.face_q))
    return false;
  return straight_answer(p, q, length, hint.normal, optimum);
}

double slack(double rounding, double gap) {
  return rounding + kGapRounding * kEpsilon * std::abs(gap);
}

void take_corners(const Solid& p, const Solid& q, const SearchResult& found, ContactSets& sets) {
  sets.p.clear();
  sets.q.clear();
  for (int k = 0; k < found.corners; ++k) {
    insert_sorted(found.p[static_cast<std::size_t>(k)], sets.p);
    insert_sorted(found.q[static_cast<std::size_t>(k)], sets.q);
  }
  sets.face_p = common_face(p.topology(), sets.p);
  sets.face_q = common_face(q.topology(), sets.q);
  const auto complete = [](const Solid& polyhedron, int face, VertexSet& set) {
    if (face >= 0) set.assign(polyhedron.topology().face_set(face));
  };
  complete(p, sets.face_p, sets.p);
  complete(q, sets.face_q, sets.q);
}

bool settle_corners(const Solid& p, const Solid& q, const SearchResult& found,
                    const Lengths& length, CandidatePlane& plane) {
  ContactSets sets;
  take_corners(p, q, found, sets);
  return settle(p, q, length, sets, found.normal, plane) ||
         settle_normal(p, q, length, found.normal, plane);
}

namespace {

/// Could a face carry a support plane along a direction alone? Its own vertices are then level.
bool is_level(const Solid& solid, int face, const Vector3& outward, double flat) {
  const Vec3 local = solid.turned_back(outward);
  double low = kInfinity, high = -kInfinity;
  for (const int v : solid.topology().face_set(face)) {
    const double value = dot(row_offset(solid, v), local);
    low = lesser(low, value);
    high = greater(high, value);
  }
  return low >= high - flat;
}

}  // namespace

bool whole_faces(const Solid& p, const Solid& q, const Lengths& length, const Candidate& near,
                 Optimum& optimum) {
  const int face_p = facing_face(p, p.topology().vertex_faces(near.support_p.vertex), near.normal);
  const int face_q = facing_face(q, q.topology().vertex_faces(near.support_q.vertex), -near.normal);
  if (face_p < 0 || face_q < 0) return false;
  const Vector3 normal_p = p.face_normal(face_p), normal_q = q.face_normal(face_q);
  if (!(normal_p.dot(normal_q) <= kTouchingOpposite)) return false;
  const double flat = kClearBelow * length.rounding;
  const bool by_p = p.diameter() >= q.diameter();
  if (!(by_p ? is_level(q, face_q, -normal_p, flat) : is_level(p, face_p, -normal_q, flat)))
    return false;
  ContactSets& sets = optimum.plane.sets;
  take_feature(p, {FeatureKind::Face, face_p}, sets.p, sets.face_p);
  take_feature(q, {FeatureKind::Face, face_q}, sets.q, sets.face_q);
  ++optimum.iterations;
  if (!straight_plane(p, q, length, near.normal, optimum) || !optimum.faces) return false;
  ContactPolygon& part = *optimum.faces;
  find_polygon(part);
  const auto margin = [&] { return part.margin; };
  const CandidatePlane& plane = optimum.plane;
  const bool wide = !part.corners.empty() && are_wide(p, q, part, length.contact) &&
                    proves_faces(p, q, plane.normal, plane.gap, length.rounding, margin);
  optimum.straight = wide || proves_optimum(p, q, plane, &part, length);  // as of a hint
  if (!optimum.straight) optimum.faces.reset();
  return optimum.converged = optimum.straight;
}

bool near_features(const Solid& p, const Solid& q, const Lengths& length, const Optimum& found,
                   Optimum& optimum) {
  const CandidatePlane& near = found.plane;
  ContactSets& sets = optimum.plane.sets;
  const auto take = [&](const Solid& solid, const NearVertices& all, const Vector3& outward,
                        VertexSet& set, int& face) {
    all.select(0.5 * length.widest, set);
    face = covered_face(solid, set, outward);
    return set.size() <= 2 || is_whole(solid, face, set);
  };
  return take(p, *near.near_p, near.normal, sets.p, sets.face_p) &&
         take(q, *near.near_q, -near.normal, sets.q, sets.face_q) &&
         (found.loose || !(sets == near.sets)) &&
         straight_answer(p, q, length, near.normal, optimum);
}

double least_gap(const SearchResult& found, double rounding) {
  const bool overlapping = found.outcome == SearchOutcome::Overlapping;
  return found.bound - slack(overlapping ? kOverlapRounding * rounding : rounding, found.bound);
}

}  // namespace quoin::geometry
