#include "search/touching_faces.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/error_bounds.hpp"
#include "polygon/cross2.hpp"
#include "polygon/overlay.hpp"

namespace quoin::geometry {
namespace {

/// Which corner is the lowest, and how far the corners reach.
void measure(FacingFaces& faces) {
  double least_p = kInfinity, most_p = -kInfinity, least_q = kInfinity, most_q = -kInfinity;
  const SharedCorners& corners = faces.corners;
  const Vector2 base = corners[0].place;
  Vector2 far = base;
  faces.gap = faces.next = kInfinity;
  faces.span = 0.0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const SharedCorner& c = corners[k];
    least_p = std::min(least_p, c.height_p);
    most_p = std::max(most_p, c.height_p);
    least_q = std::min(least_q, c.height_q);
    most_q = std::max(most_q, c.height_q);
    const double gap = c.height_q - c.height_p;
    faces.next = std::min(faces.next, std::max(gap, faces.gap));
    if (gap < faces.gap) {
      faces.gap = gap;
      faces.lowest = k;
    }
    if ((c.place - base).squaredNorm() > (far - base).squaredNorm()) far = c.place;
  }
  for (const SharedCorner& c : corners) {
    faces.span = std::max(faces.span, std::abs(cross2(far - base, c.place - base)));
  }
  faces.high = std::max(most_q - least_p, most_p - least_q);
}

/// Is what the faces share so wide that they alone come so near each other, and not their edges?
bool is_wide(const Solid& p, const Solid& q, const FacingFaces& faces, double rounding) {
  const double size = std::min(p.diameter(), q.diameter()), width = faces.span / size;
  const double reach = faces.high - faces.gap + 2.0 * rounding;
  return reach <= kTouchingTilt * width && width > kWideTouch * kTouchingTilt * size;
}

/// Is no plane better than the lowest gap, but by rounding, and none of another direction as good?
bool is_least(const Solid& p, const Solid& q, const FacingFaces& faces, double rounding) {
  if (clearly_apart(faces.gap, rounding)) return true;  // so near are two points of the solids
  const double width = faces.span / std::min(p.diameter(), q.diameter());
  const double reach = faces.high - faces.gap + 2.0 * rounding;
  if (!(reach <= kTouchingTilt * width)) return false;
  const Vector3 inner = q.vertex_mean() - p.vertex_mean();
  const double down = inner.dot(faces.normal), aside = (inner - down * faces.normal).norm();
  return down > 2.0 * std::abs(faces.gap) + 4.0 * kTouchingTilt * aside;
}

/// The carrier that a feature of a laid face is.
Carrier carrier_of(const Solid& solid, const Feature& feature) {
  if (feature.kind == FeatureKind::Face) return {feature.kind, {}, feature.index};
  if (feature.kind == FeatureKind::Vertex) return {feature.kind, {feature.index, feature.index}};
  const auto [from, to] = solid.topology().edge(feature.index);
  return {feature.kind, {std::min(from, to), std::max(from, to)}};
}

/// Do the faces lie so near to each other, over all that they share, that no plane is better?
bool lie_near(const Solid& p, const Solid& q, const FacingFaces& faces, SharedWidth least,
              double rounding) {
  return (least == SharedWidth::Any || is_wide(p, q, faces, rounding)) &&
         is_least(p, q, faces, rounding);
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

bool take_settled(const Solid& p, const Solid& q, const Lengths& length, Optimum& optimum) {
  const CandidatePlane& plane = optimum.plane;
  const bool alone = plane.near_p->vertices.size() == plane.sets.p.size() &&
                     plane.near_q->vertices.size() == plane.sets.q.size();
  if (alone) return straight_answer(p, q, length, plane.normal, optimum);
  return optimum.converged = true;
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

bool FacingFaces::find(const Solid& solid_p, const Solid& solid_q, const Vector3& across,
                       double opposite, double rounding) {
  const PairSupport near = support_pair(solid_p, solid_q, across);
  const int face_p = facing_face(solid_p, near.p.vertex, across);
  const int face_q = facing_face(solid_q, near.q.vertex, -across);
  if (flat && face_p == p && face_q == q) return true;
  flat = false;
  p = face_p;
  q = face_q;
  if (p < 0 || q < 0) return false;
  normal = solid_p.face_normal(p);
  if (!(normal.dot(solid_q.face_normal(q)) <= opposite)) return false;
  // From a place that hangs on the face alone: which corner is lowest hangs on it within rounding.
  const ContactPlane plane(solid_p.vertex(solid_p.topology().face(p)[0]), normal);
  ProjectedFeature patch_p, patch_q;
  lay_feature(solid_p, {FeatureKind::Face, p}, plane, 1.0, patch_p);
  lay_feature(solid_q, {FeatureKind::Face, q}, plane, -1.0, patch_q);
  corners.clear();
  append_shared_corners(patch_p, patch_q, rounding, corners);
  if (corners.empty()) return false;
  measure(*this);
  return flat = is_flat(patch_p, rounding) && is_flat(patch_q, rounding);
}

bool lowest_corner(const CanonicalPair& pair, const FacingFaces& faces, NearestFeatures& answer) {
  const bool alone = faces.next > faces.gap + pair.length.widest;
  if (!alone || !may_stand_alone(pair.p, pair.q, faces, pair.length.rounding)) return false;
  const SharedCorner& corner = faces.corners[faces.lowest];
  const Carrier by_p = carrier_of(pair.p, corner.feature_p);
  const Carrier by_q = carrier_of(pair.q, corner.feature_q);
  if (certify(pair.p, pair.q, by_p, by_q, pair.length, nullptr, answer) != Trial::Proved) {
    return false;
  }
  if (pair.reversed) swap_names(answer);
  return true;
}

bool touching_faces(const Solid& p, const Solid& q, const Lengths& length, const FacingFaces& faces,
                    SharedWidth least, Optimum& optimum) {
  ++optimum.iterations;
  const bool near = lie_near(p, q, faces, least, length.rounding);
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
