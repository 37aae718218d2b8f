#include "search/touching_faces.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/error_bounds.hpp"
#include "polygon/cross2.hpp"

namespace quoin::geometry {
namespace {

/// Do all corners of a laid face lie in its plane within `rounding`? Then a place on it is one of
/// the solid.
bool is_flat(const PolygonRows& face, double rounding) {
  double off = 0.0;
  for (int k = 1; k < face.count; ++k) {
    const double height = face.height[0] + (face.slope_x * (face.x[k] - face.x[0]) +
                                            face.slope_y * (face.y[k] - face.y[0]));
    off = std::max(off, std::abs(face.height[k] - height));
  }
  return off <= rounding;
}

/// The corners of what two faces share: places where both solids have a point.
struct SharedPlaces {
  SharedCorners corners;
  std::size_t lowest = 0;  // where the faces come nearest
  double gap = kInfinity;  // there, m
  double high = 0.0;       // greatest difference of heights of the two faces, m
  double span = 0.0;       // twice the area of a triangle of them, m2

  /// False: there are none.
  bool measure() {
    if (corners.empty()) return false;
    double least_p = kInfinity, most_p = -kInfinity, least_q = kInfinity, most_q = -kInfinity;
    const Vector2& base = corners[0].place;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const SharedCorner& c = corners[k];
      least_p = std::min(least_p, c.height_p);
      most_p = std::max(most_p, c.height_p);
      least_q = std::min(least_q, c.height_q);
      most_q = std::max(most_q, c.height_q);
      if (c.height_q - c.height_p < gap) {
        gap = c.height_q - c.height_p;
        lowest = k;
      }
      for (std::size_t i = 1; i < k; ++i) {
        span = std::max(span, std::abs(cross2(corners[i].place - base, c.place - base)));
      }
    }
    high = std::max(most_q - least_p, most_p - least_q);
    return true;
  }
};

/// Is what the faces share so wide that they alone come so near each other, and not their edges?
bool is_wide(const Solid& p, const Solid& q, const SharedPlaces& places, double rounding) {
  const double size = std::min(p.diameter(), q.diameter()), width = places.span / size;
  const double reach = places.high - places.gap + 2.0 * rounding;
  return reach <= kTouchingTilt * width && width > kWideTouch * kTouchingTilt * size;
}

/// Is no plane better than the lowest gap, but by rounding, and none of another direction as good?
bool is_least(const Solid& p, const Solid& q, const Vector3& normal, const SharedPlaces& places,
              double rounding) {
  if (clearly_apart(places.gap, rounding)) return true;  // so near are two points of the solids
  const double width = places.span / std::min(p.diameter(), q.diameter());
  const double reach = places.high - places.gap + 2.0 * rounding;
  if (!(reach <= kTouchingTilt * width)) return false;
  const Vector3 inner = q.vertex_mean() - p.vertex_mean();
  const double down = inner.dot(normal), aside = (inner - down * normal).norm();
  return down > 2.0 * std::abs(places.gap) + 4.0 * kTouchingTilt * aside;
}

/// The faces that look along a direction and against it; the normal is P's.
struct FacingFaces {
  int p = -1, q = -1;
  Vector3 normal;

  /// False: they do not look at each other.
  bool find(const Solid& solid_p, const Solid& solid_q, const Vector3& across) {
    const PairSupport near = support_pair(solid_p, solid_q, across);
    p = facing_face(solid_p, near.p.vertex, across);
    q = facing_face(solid_q, near.q.vertex, -across);
    if (p < 0 || q < 0) return false;
    normal = solid_p.face_normal(p);
    return normal.dot(solid_q.face_normal(q)) <= kTouchingOpposite;
  }
};

/// What two faces share; false: nothing, or they are not flat.
bool share_faces(const Solid& p, const Solid& q, const FacingFaces& faces, double rounding,
                 SharedPlaces& places) {
  // From a place that hangs on the face alone: which corner is lowest hangs on it within rounding.
  const ContactPlane plane(p.vertex(p.topology().face(faces.p)[0]), faces.normal);
  PolygonRows rows_p, rows_q;
  if (!lay_face(p, faces.p, plane, 1.0, rows_p) || !lay_face(q, faces.q, plane, -1.0, rows_q)) {
    return false;
  }
  append_shared_of_polygons(rows_p, rows_q, rounding, places.corners);
  return places.measure() && is_flat(rows_p, rounding) && is_flat(rows_q, rounding);
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

bool touching_faces(const Solid& p, const Solid& q, const Lengths& length, const Vector3& across,
                    SharedWidth least, Optimum& optimum) {
  ++optimum.iterations;
  const bool wide = least == SharedWidth::Wide;
  FacingFaces faces;
  if (!faces.find(p, q, across)) return false;
  if (wide && !(faces.normal.dot(across) >= -kTouchingOpposite)) return false;
  SharedPlaces places;
  if (!share_faces(p, q, faces, length.rounding, places) ||
      (wide && !is_wide(p, q, places, length.rounding)) ||
      !is_least(p, q, faces.normal, places, length.rounding)) {
    return false;
  }
  const SharedCorner& corner = places.corners[places.lowest];
  ContactSets sets;
  take_feature(p, corner.feature_p, sets.p, sets.face_p);
  take_feature(q, corner.feature_q, sets.q, sets.face_q);
  CandidatePlane& plane = optimum.plane;
  if (!settle(p, q, length, sets, faces.normal, plane)) return false;
  const double aside = std::abs(plane.gap) * (plane.normal - faces.normal).norm();
  const bool over = aside <= length.rounding || lies_over(p, q, plane, nullptr, -length.rounding);
  return over && plane.gap >= places.gap - length.rounding && take_settled(p, q, length, optimum);
}

}  // namespace quoin::geometry
