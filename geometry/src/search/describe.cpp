#include "search/quick_answers.hpp"

#include "numeric/error_bounds.hpp"
#include "polygon/line_normal.hpp"
#include "polygon/overlay.hpp"

namespace quoin::geometry {
namespace {

/// Centroid of what two patches share; where that is nothing, where they come nearest.
Vector2 shared_middle(const ProjectedFeature& p, const ProjectedFeature& q,
                      SharedCorners& corners) {
  if (corners.empty()) return nearest_place(p, q);
  SharedPolygon polygon;
  find_polygon(corners, polygon);
  return polygon.centroid;
}

/// Witness points: of the shared part of the two features that rounding cannot tell from parallel.
void set_witnesses(const Solid& p, const Solid& q, const CandidatePlane& contact,
                   const VertexSet& set_p, const VertexSet& set_q, double length,
                   NearestFeatures& answer) {
  const Vector3 across = answer.gap * answer.normal;
  if (set_p.size() == 1) {
    answer.point_a = p.vertex(set_p[0]);
    answer.point_b = set_q.size() == 1 && answer.gap > 0.0 ? q.vertex(set_q[0])
                                                           : Vector3(answer.point_a + across);
    return;
  }
  if (set_q.size() == 1) {
    answer.point_b = q.vertex(set_q[0]);
    answer.point_a = answer.point_b - across;
    return;
  }
  if (contact.form.crossed && set_p.size() == 2 && set_q.size() == 2) {
    const Vector3 base = p.vertex(set_p[0]);
    answer.point_a = base + contact.form.share * p.line(set_p[0], set_p[1]);
    answer.point_b = answer.point_a + across;
    return;
  }
  Vec3 middle;
  const bool on_p = set_p.size() == 2 && is_whole(q, contact.sets.face_q, set_q) &&
                    middle_on_face(q, contact.sets.face_q, -Vec3(answer.normal),
                                   Side(p, set_p[0], set_p[1]), kFirm * length, middle);
  if (on_p || (set_q.size() == 2 && is_whole(p, contact.sets.face_p, set_p) &&
               middle_on_face(p, contact.sets.face_p, answer.normal, Side(q, set_q[0], set_q[1]),
                              kFirm * length, middle))) {
    answer.point_a = on_p ? Vector3(middle) : Vector3(middle) - across;
    answer.point_b = on_p ? Vector3(middle) + across : Vector3(middle);
    return;
  }
  LateInit<ContactPolygon> faces;
  if (lay_whole_faces(p, q, contact, set_p, set_q, faces.emplace())) find_polygon(*faces);
  if (faces->convex) {
    answer.point_a = faces->plane.point(faces->polygon.centroid, 0.0);
    answer.point_b = answer.point_a + across;
    return;
  }
  const ProjectedPair patches(p, q, contact, set_p, set_q, length);
  SharedCorners corners;
  append_shared_corners(patches.p, patches.q, 2 * length + kEpsilon * std::abs(answer.gap),
                        corners);
  answer.point_a = patches.plane.point(shared_middle(patches.p, patches.q, corners), 0.0);
  answer.point_b = answer.point_a + across;
}

/// Witnesses of a plane whose sets need not lie over each other: normals that are as good within
/// rounding tilt what carries them by more than rounding, as of slivers and of edges that are
/// parallel but for noise. The solids meet, then, a little below their support planes.
void set_loose_witnesses(const Solid& p, const Solid& q, const CandidatePlane& contact,
                         const VertexSet& set_p, const VertexSet& set_q, double length,
                         NearestFeatures& answer) {
  const ProjectedPair patches(p, q, contact, set_p, set_q, length);
  if (overlap_margin(patches.p, patches.q) >= -length)
    return set_witnesses(p, q, contact, set_p, set_q, length, answer);
  ProjectedFeature top_p, top_q;
  lay_top(p, patches.p.face, patches.plane, 1.0, 2 * length, top_p);
  lay_top(q, patches.q.face, patches.plane, -1.0, 2 * length, top_q);
  SharedCorners corners;
  append_shared_corners(top_p, top_q, length, corners);
  answer.point_a = patches.plane.point(shared_middle(top_p, top_q, corners), 0.0);
  answer.point_b = answer.point_a + answer.gap * answer.normal;
}

Feature feature_of(const Solid& polyhedron, const VertexSet& set, FeatureKind kind, int face,
                   const Vector3& outward) {
  if (kind == FeatureKind::Vertex) return {kind, set[0]};
  const Topology& topology = polyhedron.topology();
  if (set.size() == 2) {
    const int edge = topology.find_edge(set[0], set[1]);
    if (edge >= 0) return {FeatureKind::Edge, edge};
  }
  const bool named = face >= 0 && topology.face_set(face).size() == set.size();
  if (kind == FeatureKind::Face && named) return {kind, face};
  return name_support_set(polyhedron, set, kind, outward);
}

/// How far either solid reaches beyond its witness.
void set_residuals(const Solid& p, const Solid& q, const Candidate& plane,
                   NearestFeatures& answer) {
  const Vector3 high = p.vertex(plane.support_p.vertex), low = q.vertex(plane.support_q.vertex);
  answer.residual_a = std::max(0.0, answer.normal.dot(high - answer.point_a));
  answer.residual_b = std::max(0.0, answer.normal.dot(answer.point_b - low));
}

/// Features within the contact tolerance: the sets are those of `tolerance`.
void set_features(const Solid& p, const Solid& q, const Candidate& plane, const VertexSet& set_p,
                  const VertexSet& set_q, double tolerance, NearestFeatures& answer) {
  const FeatureKind kind_p = span_kind(p, set_p, tolerance);
  const FeatureKind kind_q = span_kind(q, set_q, tolerance);
  answer.feature_a = feature_of(p, set_p, kind_p, plane.sets.face_p, answer.normal);
  answer.feature_b = feature_of(q, set_q, kind_q, plane.sets.face_q, -answer.normal);
  set_residuals(p, q, plane, answer);
  if (kind_p == FeatureKind::Face || kind_q == FeatureKind::Face) return;
  if (type_of(p, q, set_p, set_q, kind_p, kind_q, tolerance) != ContactType::EdgeEdgeCrossing) {
    answer.indeterminate = true;
    answer.rule = PlaneRule::ShortestLine;
  }
}

/// The witnesses of two whole faces, and what the contact points will ask for.
void set_face_witnesses(const Solid& p, const Solid& q, const Candidate& contact,
                        ContactPolygon& faces, NearestFeatures& answer) {
  Vector2 place;
  if (faces.corners.empty()) {
    ProjectedFeature patch_p, patch_q;
    lay_feature(p, {FeatureKind::Face, faces.face_p}, faces.plane, 1.0, patch_p);
    lay_feature(q, {FeatureKind::Face, faces.face_q}, faces.plane, -1.0, patch_q);
    place = nearest_place(patch_p, patch_q);
  } else {
    find_polygon(faces);
    place = faces.polygon.centroid;
  }
  answer.point_a = faces.plane.point(place, 0.0);
  answer.point_b = answer.point_a + answer.gap * answer.normal;
  faces.top_p = contact.support_p;
  faces.top_q = contact.support_q;
}

void set_hint(const Candidate& plane, NearestFeatures& answer) {
  for (std::size_t k = 0; k < 4; ++k) {
    answer.hint.vertices_a[k] = k < plane.sets.p.size() ? plane.sets.p[k] : -1;
    answer.hint.vertices_b[k] = k < plane.sets.q.size() ? plane.sets.q[k] : -1;
  }
  answer.hint.face_a = plane.sets.face_p;
  answer.hint.face_b = plane.sets.face_q;
  answer.hint.normal = answer.normal;
}

void describe_features(const Solid& p, const Solid& q, Optimum& optimum, const Lengths& length,
                       NearestFeatures& answer) {
  const CandidatePlane& plane = optimum.plane;
  if (optimum.faces) {
    const ContactPolygon& faces = *optimum.faces;
    set_face_witnesses(p, q, plane, *optimum.faces, answer);
    if (!are_wide(p, q, faces, length.contact)) {
      set_features(p, q, plane, plane.sets.p, plane.sets.q, length.contact, answer);
      return;
    }
    answer.feature_a = {FeatureKind::Face, faces.face_p};
    answer.feature_b = {FeatureKind::Face, faces.face_q};
    set_residuals(p, q, plane, answer);
    return;
  }
  if (optimum.straight) {
    set_witnesses(p, q, plane, plane.sets.p, plane.sets.q, length.place, answer);
    set_features(p, q, plane, plane.sets.p, plane.sets.q, length.contact, answer);
    return;
  }
  VertexSet set_p, set_q;
  plane.near_p->select(length.place, set_p);
  plane.near_q->select(length.place, set_q);
  (optimum.loose ? set_loose_witnesses : set_witnesses)(p, q, plane, set_p, set_q, length.place,
                                                        answer);
  plane.near_p->select(length.contact, set_p);
  plane.near_q->select(length.contact, set_q);
  set_features(p, q, plane, set_p, set_q, length.contact, answer);
  if (!optimum.several) return;
  answer.indeterminate = true;
  answer.rule = optimum.middle ? PlaneRule::MiddleOfPlanes : PlaneRule::LeastOverlap;
}

}  // namespace

void describe(const Solid& p, const Solid& q, Optimum& optimum, const Lengths& length,
              NearestFeatures& answer) {
  answer.normal = one_zero(optimum.plane.normal);
  answer.gap = optimum.plane.gap + 0.0;  // one zero
  describe_features(p, q, optimum, length, answer);
  set_hint(optimum.plane, answer);
  if (optimum.converged) answer.status = status_of(answer.gap, length.contact);
}

}  // namespace quoin::geometry
