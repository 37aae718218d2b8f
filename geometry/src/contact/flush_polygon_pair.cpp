#include "contact/flush_polygon_pair.hpp"

#include <algorithm>
#include <cmath>

#include "certify/canonical_order.hpp"
#include "numeric/branchless.hpp"
#include "search/prefetch.hpp"
#include "shape/support.hpp"

namespace quoin::geometry {
namespace {

/// A convex face of not too many corners, and no other vertices in it, of a solid in each vertex of
/// which three faces meet; a placement that keeps lengths.
bool is_polygon(const Body& body, int face) {
  const Shape& shape = body.shape();
  const Topology& topology = shape.topology();
  if (face < 0 || face >= topology.face_count()) return false;
  const std::size_t count = topology.face(face).size();
  return count <= PolygonSide::kMost && topology.face_set(face).size() == count &&
         topology.three_faces_at_vertices() && shape.is_convex(face) && body.is_rigid();
}

/// The plane leans by less than 2e-3 rad from the face, so no neighbour that stands more than 36
/// degrees off it is within 30 degrees of the plane.
bool has_steep_neighbours(const Shape& shape, int face) {
  constexpr double kSteep = 0.8;
  const double* const normals = shape.face_normals().data();
  const Vec3 own(normals[3 * face], normals[3 * face + 1], normals[3 * face + 2]);
  double most = -kInfinity;
  for (const int f : shape.topology().face_neighbours(face)) {
    const double* const n = normals + 3 * f;
    most = greater(most, dot(Vec3(n[0], n[1], n[2]), own));
  }
  return most < kSteep;
}

void put(const Vec3& v, std::size_t lane, FlushRow (&rows)[3]) {
  rows[0].of[lane] = v.x;
  rows[1].of[lane] = v.y;
  rows[2].of[lane] = v.z;
}

/// As LaidFace; `normal`: of the face, placed.
void pack(const Solid& solid, int face, const Vector3& normal, const ContactPlane& plane,
          std::size_t lane, PolygonSide& side) {
  const std::span<const int> cycle = solid.topology().face(face);
  const double* const vertices = solid.shape().vertices().data();
  const std::size_t count = cycle.size();
  side.count[lane] = static_cast<int>(count);
  for (std::size_t k = 0; k < count; ++k) side.corners[k][lane] = vertices + 3 * cycle[k];
  for (std::size_t k = count; k < PolygonSide::kMost; ++k) {
    side.corners[k][lane] = side.corners[0][lane];
  }
  const LocalPlane local(solid, plane);
  put(local.base, lane, side.base);
  put(local.axis_u, lane, side.axis_u);
  put(local.axis_v, lane, side.axis_v);
  put(local.normal, lane, side.up);
  put({local.shift_u, local.shift_v, local.shift_height}, lane, side.shift);
  put(solid.shape().face_normal(face), lane, side.own);
  const double across = normal.dot(plane.normal);
  side.slope[0].of[lane] = -normal.dot(plane.axis_u) / across;
  side.slope[1].of[lane] = -normal.dot(plane.axis_v) / across;
}

}  // namespace

bool PolygonPair::take(const Body& body_a, const Body& body_b, const FeatureHint& hint,
                       double tolerance, std::size_t lane, PolygonQuestion& question) {
  if (hint.vertices_a[0] < 0 || !is_polygon(body_a, hint.face_a) ||
      !is_polygon(body_b, hint.face_b) ||
      (body_a.stands_in_own_frame() && body_b.stands_in_own_frame())) {
    return false;
  }
  between = apart(body_a, body_b);
  const Solid of_a(body_a, -0.5 * between), of_b(body_b, 0.5 * between);
  fetch(of_a);
  fetch(of_b);
  const Lengths length = lengths(of_a, of_b, tolerance);
  const double smaller = std::min(of_a.diameter(), of_b.diameter());
  clear = kFarBelow * smaller;
  if (length.uneven || !(clear > length.widest)) return false;

  faces.reversed = in_reverse_order(of_a, of_b);
  const Solid &p = faces.reversed ? of_b : of_a, &q = faces.reversed ? of_a : of_b;
  faces.p = &p.shape();
  faces.q = &q.shape();
  faces.face_p = faces.reversed ? hint.face_b : hint.face_a;
  faces.face_q = faces.reversed ? hint.face_a : hint.face_b;
  const Vector3 normal_p = p.face_normal(faces.face_p), normal_q = q.face_normal(faces.face_q);
  if (along(normal_p, normal_q) > kTouchingOpposite) return false;
  const Vector3 normal = p.diameter() >= q.diameter() ? normal_p : Vector3(-normal_q);

  const double flat = kClearBelow * length.rounding;
  Support top_p, top_q;
  const auto set = [](const Solid& solid, int face) { return solid.topology().face_set(face); };
  if (!carried_alone(p, normal, {set(p, faces.face_p), flat, clear}, top_p) ||
      !carried_alone(q, -normal, {set(q, faces.face_q), flat, clear}, top_q) ||
      !has_steep_neighbours(*faces.p, faces.face_p) ||
      !has_steep_neighbours(*faces.q, faces.face_q)) {
    return false;
  }
  const Vector3 high = p.vertex(top_p.vertex), low = q.vertex(top_q.vertex);
  gap = normal.dot(low - high);
  border = border_rounding(p, q, gap);
  contact = length.contact;
  wide = 8 * contact * std::max(p.diameter(), q.diameter());
  margin = clearly_apart(gap, length.rounding)
               ? length.rounding
               : shallow_margin(Vec3(q.vertex_mean()) - Vec3(p.vertex_mean()), normal, gap,
                                length.rounding);
  plane = ContactPlane(high, normal);
  middle = 0.5 * body_a.centre() + 0.5 * body_b.centre();
  question.rounding.of[lane] = border;
  pack(p, faces.face_p, normal_p, plane, lane, question.p);
  pack(q, faces.face_q, normal_q, plane, lane, question.q);
  return true;
}

}  // namespace quoin::geometry
