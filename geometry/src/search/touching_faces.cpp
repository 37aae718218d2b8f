#include "search/touching_faces.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/error_bounds.hpp"
#include "polygon/contact_plane.hpp"
#include "polygon/overlay.hpp"

namespace quoin::geometry {
namespace {

/// Two faces that look at each other along a direction, and the corners of what they share as seen
/// along P's normal: places where both solids have a point.
struct FacingFaces {
  int p = -1, q = -1;
  Vector3 normal = Vector3::UnitX();  // of P's face
  SharedCorners corners;
  std::size_t lowest = 0;  // where the faces come nearest
  double gap = kInfinity;  // there, m
  double high = 0.0;       // greatest difference of heights of the two faces, m
  double span = 0.0;       // twice the area of a wide triangle of corners, m2
};

/// Which corner is the lowest, and how far the corners reach.
void measure(FacingFaces& faces) {
  double least_p = kInfinity, most_p = -kInfinity, least_q = kInfinity, most_q = -kInfinity;
  const SharedCorners& corners = faces.corners;
  const Vector2 base = corners[0].place;
  Vector2 far = base;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const SharedCorner& c = corners[k];
    least_p = std::min(least_p, c.height_p);
    most_p = std::max(most_p, c.height_p);
    least_q = std::min(least_q, c.height_q);
    most_q = std::max(most_q, c.height_q);
    const double gap = c.height_q - c.height_p;
    if (gap < faces.gap) {
      faces.gap = gap;
      faces.lowest = k;
    }
    if ((c.place - base).squaredNorm() > (far - base).squaredNorm()) far = c.place;
  }
  for (const SharedCorner& c : corners)
    faces.span = std::max(faces.span, std::abs(cross2(far - base, c.place - base)));
  faces.high = std::max(most_q - least_p, most_p - least_q);
}

/// Those that look along `across`. False: they do not look at each other, share nothing, or are not
/// flat.
bool find(const Solid& solid_p, const Solid& solid_q, const Vector3& across, double rounding,
          FacingFaces& faces) {
  const PairSupport near = support_pair(solid_p, solid_q, across);
  faces.p = facing_face(solid_p, solid_p.topology().vertex_faces(near.p.vertex), across);
  faces.q = facing_face(solid_q, solid_q.topology().vertex_faces(near.q.vertex), -across);
  if (faces.p < 0 || faces.q < 0) return false;
  faces.normal = solid_p.face_normal(faces.p);
  if (!(faces.normal.dot(solid_q.face_normal(faces.q)) <= kTouchingOpposite)) return false;
  // From a place that hangs on the face alone: which corner is lowest hangs on it within rounding.
  const ContactPlane plane(solid_p.vertex(solid_p.topology().face(faces.p)[0]), faces.normal);
  ProjectedFeature patch_p, patch_q;
  lay_feature(solid_p, {FeatureKind::Face, faces.p}, plane, 1.0, patch_p);
  lay_feature(solid_q, {FeatureKind::Face, faces.q}, plane, -1.0, patch_q);
  append_shared_corners(patch_p, patch_q, rounding, faces.corners);
  if (faces.corners.empty()) return false;
  measure(faces);
  return is_flat(patch_p, rounding) && is_flat(patch_q, rounding);
}

/// Do the faces lie so near to each other, over all that they share, that no plane is better than
/// the lowest gap, but by rounding, and none of another direction as good?
bool is_least(const Solid& p, const Solid& q, const FacingFaces& faces, double rounding) {
  if (clearly_apart(faces.gap, rounding)) return true;  // so near are two points of the solids
  const double width = faces.span / std::min(p.diameter(), q.diameter());
  const double reach = faces.high - faces.gap + 2.0 * rounding;
  if (!(reach <= kTouchingTilt * width)) return false;
  const Vector3 inner = q.vertex_mean() - p.vertex_mean();
  const double down = inner.dot(faces.normal), aside = (inner - down * faces.normal).norm();
  return down > 2.0 * std::abs(faces.gap) + 4.0 * kTouchingTilt * aside;
}

/// May a corner of the shared part prove itself: is that wide enough for a firm foot, and for the
/// overlap? Only speed hangs on it.
bool may_stand_alone(const Solid& p, const Solid& q, const FacingFaces& faces, double rounding) {
  const double size = std::min(p.diameter(), q.diameter());
  return faces.span > size * std::max(kFirm * rounding, -faces.gap);
}

/// Does no vertex lie so near the plane, beside those of its sets, that rounding might sort it to
/// them?
bool is_clear(const CandidatePlane& plane, const Lengths& length) {
  const auto clear = [&](const NearVertices& near) {
    return std::all_of(near.depths.begin(), near.depths.end(), [&](double depth) {
      return depth <= kClearBelow * length.rounding || depth > kClearAbove * length.rounding;
    });
  };
  return clear(*plane.near_p) && clear(*plane.near_q);
}

/// A settled plane that is known to be the best. Where no other vertex comes near it, last step's
/// features lead to it without a search: it is then described as they do.
bool take_settled(const Solid& p, const Solid& q, const Lengths& length, Optimum& optimum) {
  const CandidatePlane& plane = optimum.plane;
  const bool alone = plane.near_p->vertices.size() == plane.sets.p.size() &&
                     plane.near_q->vertices.size() == plane.sets.q.size();
  if (alone) return straight_answer(p, q, length, plane.normal, optimum);
  return optimum.converged = true;
}

}  // namespace

void take_feature(const Solid& solid, const Feature& feature, VertexSet& set, int& face) {
  set.clear();
  face = -1;
  if (feature.kind == FeatureKind::Vertex) {
    set.push_back(feature.index);
  } else if (feature.kind == FeatureKind::Edge) {
    const auto [from, to] = solid.topology().edge(feature.index);
    set.push_back(std::min(from, to));
    set.push_back(std::max(from, to));
  } else {
    face = feature.index;
    set.assign(solid.topology().face_set(face));
  }
}

PartingFace parting_face(const Solid& p, const Solid& q, std::span<const int> faces) {
  const Vector3 between = q.vertex_mean() - p.vertex_mean();
  PartingFace best;
  for (const int f : faces) {
    const Vector3 normal = p.face_normal(f);
    if (!(normal.dot(between) > 0.0)) continue;
    const Vector3 lowest = q.vertex(support(q, -normal).vertex);
    const double gap = normal.dot(lowest - p.vertex(p.topology().face(f)[0]));
    if (gap > best.gap) best = {f, gap};
  }
  return best;
}

bool touching_faces(const Solid& p, const Solid& q, const Lengths& length, const Vector3& across,
                    Optimum& optimum) {
  FacingFaces faces;
  if (!find(p, q, across, length.rounding, faces)) return false;
  ++optimum.iterations;
  const bool near = is_least(p, q, faces, length.rounding);
  if (!near && !may_stand_alone(p, q, faces, length.rounding)) return false;
  const SharedCorner& corner = faces.corners[faces.lowest];
  ContactSets sets;
  take_feature(p, corner.feature_p, sets.p, sets.face_p);
  take_feature(q, corner.feature_q, sets.q, sets.face_q);
  CandidatePlane& plane = optimum.plane;
  if (!settle(p, q, length, sets, faces.normal, plane)) return false;
  const auto nearest = [&] {
    if (!near || !(plane.gap >= faces.gap - length.rounding)) return false;
    const double aside = std::abs(plane.gap) * (plane.normal - faces.normal).norm();
    optimum.loose = aside <= length.rounding;  // what carries it may lie beside the shared part
    return optimum.loose || lies_over(p, q, plane, nullptr, -length.rounding);
  };
  return (nearest() || (faces.gap < 0.0 && is_clear(plane, length) &&
                        proves_optimum(p, q, plane, nullptr, length))) &&
         take_settled(p, q, length, optimum);
}

}  // namespace quoin::geometry
