#include "contact/flush_batch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "certify/canonical_order.hpp"
#include "certify/certificate.hpp"
#include "contact/point_frame.hpp"

namespace quoin::geometry {
namespace {

constexpr int kVertices = 8, kCorners = 4;

/// A convex face of four corners, and no other vertices in it, of a solid of eight vertices in each
/// of which three faces meet; a placement that keeps lengths.
bool is_brick(const Body& body, int face) {
  const Shape& shape = body.shape();
  const Topology& topology = shape.topology();
  return shape.vertex_count() == kVertices && face >= 0 && face < topology.face_count() &&
         topology.face(face).size() == kCorners && topology.face_set(face).size() == kCorners &&
         topology.three_faces_at_vertices() && shape.is_convex(face) && body.is_rigid();
}

void pack_face(const Shape& shape, int face, std::size_t lane, FlushSide& side) {
  const Topology& topology = shape.topology();
  const double *const vertices = shape.vertices().data(), *const normals =
                                                              shape.face_normals().data();
  const std::span<const int> cycle = topology.face(face), set = topology.face_set(face),
                             around = topology.face_neighbours(face);
  side.normal[0][lane] = normals + 3 * face;
  unsigned others = (1u << kVertices) - 1;
  for (std::size_t k = 0; k < kCorners; ++k) {
    side.corners[k][lane] = vertices + 3 * cycle[k];
    side.set[k][lane] = vertices + 3 * set[k];
    side.neighbours[k][lane] = normals + 3 * around[k];
    others &= ~(1u << set[k]);
  }
  for (std::size_t k = 0; k < kCorners; ++k, others &= others - 1) {
    side.others[k][lane] = vertices + 3 * std::countr_zero(others);
  }
}

void pack_side(const Body& body, int face, std::size_t lane, FlushSide& side) {
  const Shape& shape = body.shape();
  for (std::size_t k = 0; k < 3; ++k) {
    side.linear[k][lane] = body.placement().linear.data() + 3 * k;
    side.cofactors[k][lane] = body.cofactors().data() + 3 * k;
  }
  side.origin[0][lane] = shape.origin().data();
  side.mean[0][lane] = shape.vertex_mean().data();
  side.diameter.of[lane] = shape.diameter();
  side.coordinate.of[lane] = shape.largest_coordinate();
  side.turned[lane] = body.is_turned();
  pack_face(shape, face, lane, side);
}

void pack_centre(const Body& body, std::size_t lane, LaneCentres& centres) {
  centres.translation[lane] = body.placement().translation.data();
  centres.turned[lane] = body.turned_origin().data();
  centres.rest[lane] = body.turned_origin_rest().data();
}

Vector3 vector_at(const FlushRow (&rows)[3], std::size_t lane) {
  return {rows[0].of[lane], rows[1].of[lane], rows[2].of[lane]};
}

/// The corners that one pair has.
std::span<const PolygonCorner> corners_of(const FlushAnswer& found, std::size_t lane,
                                          std::array<PolygonCorner, 2 * kCorners>& corners) {
  std::size_t count = 0;
  for (int k = 0; k < found.corner_count; ++k) {
    const FlushCorner& c = found.corners[static_cast<std::size_t>(k)];
    if ((c.pairs >> lane & 1) == 0) continue;
    corners[count++] = {c.x.of[lane],     c.y.of[lane], c.height_p.of[lane], c.height_q.of[lane],
                        c.share.of[lane], c.feature_p,  c.feature_q};
  }
  return std::span(corners).first(count);
}

/// A side of one of the faces in the plane, which is counted around it.
std::array<double, 2> side_of(const PolygonSide& face, int side, std::size_t lane) {
  const auto corner = [&](int k) { return face.corners[static_cast<std::size_t>(k)][lane]; };
  const double *from = corner(side), *to = corner(side + 1 < face.count[lane] ? side + 1 : 0);
  std::array<double, 2> in_plane{};
  for (std::size_t i = 0; i < 3; ++i) {
    in_plane[0] += face.axis_u[i].of[lane] * (to[i] - from[i]);
    in_plane[1] += face.axis_v[i].of[lane] * (to[i] - from[i]);
  }
  return in_plane;
}

/// As FlushLanes::need_no_parallels.
bool is_of_parallels(const PolygonQuestion& question, const PolygonCorner& corner, std::size_t lane,
                     double tolerance) {
  if (corner.feature_p.kind != FeatureKind::Edge) return false;
  const std::array p = side_of(question.p, corner.feature_p.index, lane);
  const std::array q = side_of(question.q, corner.feature_q.index, lane);
  const double longer = std::max(std::hypot(p[0], p[1]), std::hypot(q[0], q[1]));
  return !(std::abs(p[0] * q[1] - p[1] * q[0]) > 2.0 * tolerance * longer);
}

}  // namespace

bool FlushPair::take(const Body& body_a, const Body& body_b, const FeatureHint& hint) {
  if (hint.vertices_a[0] < 0 || !is_brick(body_a, hint.face_a) || !is_brick(body_b, hint.face_b) ||
      (body_a.stands_in_own_frame() && body_b.stands_in_own_frame())) {
    return false;
  }
  a.emplace(body_a);
  b.emplace(body_b);
  const bool reversed = in_reverse_order(Solid(*a, a->centre()), Solid(*b, b->centre()));
  faces.reversed = reversed;
  faces.p = reversed ? &b->shape() : &a->shape();
  faces.q = reversed ? &a->shape() : &b->shape();
  faces.face_p = reversed ? hint.face_b : hint.face_a;
  faces.face_q = reversed ? hint.face_a : hint.face_b;
  return true;
}

void FlushPair::pack(std::size_t lane, FlushQuestion& question) const {
  question.reversed[lane] = faces.reversed;
  question.reach.of[lane] = reach;
  pack_centre(*a, lane, question.centres_a);
  pack_centre(*b, lane, question.centres_b);
  pack_side(faces.reversed ? *b : *a, faces.face_p, lane, question.p);
  pack_side(faces.reversed ? *a : *b, faces.face_q, lane, question.q);
}

void FlushBatch::start(const ContactOptions& options) {
  options_ = options;
  bricks_.tolerance = options.tolerance;
  bricks_waiting_ = polygons_waiting_ = 0;
  answers_.clear();
  used_ = 0;
}

void FlushBatch::take(std::size_t pair, const std::array<int, 2>& blocks, const Body& a,
                      const Body& b, const FeatureHint& hint, double reach) {
  FlushPair& bricks = brick_pairs_[bricks_waiting_];
  if (bricks.take(a, b, hint)) {
    bricks.number = pair;
    bricks.faces.blocks = blocks;
    bricks.reach = reach;
    bricks.pack(bricks_waiting_++, bricks_);
    if (bricks_waiting_ == FlushRow::kPairs) ask_bricks();
    return;
  }
  PolygonPair& polygons = polygon_pairs_[polygons_waiting_];
  if (!polygons.take(a, b, hint, options_.tolerance, polygons_waiting_, polygons_)) return;
  polygons.number = pair;
  polygons.faces.blocks = blocks;
  polygons.reach = reach;
  if (options_.frame != PointFrame::World) {
    polygons.a.emplace(a);
    polygons.b.emplace(b);
  }
  if (++polygons_waiting_ == FlushRow::kPairs) ask_polygons();
}

void FlushBatch::finish() {
  if (bricks_waiting_ > 0) ask_bricks();
  if (polygons_waiting_ > 0) ask_polygons();
}

/// Lanes that are left over repeat the first pair.
void FlushBatch::ask_bricks() {
  const std::size_t count = bricks_waiting_;
  bricks_waiting_ = 0;
  for (std::size_t lane = count; lane < FlushRow::kPairs; ++lane) {
    brick_pairs_[0].pack(lane, bricks_);
  }
  flush_bricks(bricks_, of_bricks_);
  for (std::size_t lane = 0; lane < count; ++lane) {
    if ((of_bricks_.solved >> lane & 1) != 0) add_brick(lane);
  }
}

void FlushBatch::ask_polygons() {
  const std::size_t count = polygons_waiting_;
  polygons_waiting_ = 0;
  for (std::size_t lane = count; lane < FlushRow::kPairs; ++lane) polygons_.repeat_first(lane);
  flush_polygons(polygons_, of_polygons_);
  for (std::size_t lane = 0; lane < count; ++lane) {
    if ((of_polygons_.solved >> lane & 1) != 0) add_polygon(lane);
  }
}

/// Behind the points that are used; from the middle of the pair unless they are told in the world.
void FlushBatch::write(const FlushPoints& points, const ContactPlane& plane, const Vector3& middle,
                       FlushPairAnswer& answer) {
  answer.count = points.count();
  if (points_.size() < used_ + answer.count) points_.resize(2 * (used_ + answer.count));
  points.write(plane, answer.normal, options_.frame == PointFrame::World ? &middle : nullptr,
               std::span(points_).subspan(used_, answer.count));
}

void FlushBatch::into_bodies(const Body& a, const Body& b, const Vector3& between,
                             const FlushPairAnswer& answer) {
  move(Solid(a, -0.5 * between), Solid(b, 0.5 * between), Vector3::Zero(), options_.frame,
       std::span(points_).subspan(used_, answer.count));
}

/// With the newest points. Two kinds of pairs take turns: one may overtake a few of the other.
void FlushBatch::add(const FlushPairAnswer& answer) {
  answers_.push_back(answer);
  for (std::size_t k = answers_.size() - 1; k > 0 && answers_[k].pair < answers_[k - 1].pair; --k) {
    std::swap(answers_[k], answers_[k - 1]);
  }
  used_ += answer.count;
}

void FlushBatch::add_brick(std::size_t lane) {
  const FlushPair& pair = brick_pairs_[lane];
  const double tolerance = of_bricks_.tolerance.of[lane];
  FlushPairAnswer answer;
  answer.pair = pair.number;
  answer.gap = of_bricks_.gap.of[lane] + 0.0;  // one zero, as of the normal
  answer.status = status_of(answer.gap, tolerance);
  answer.first = used_;
  ContactPlane plane;
  plane.origin = vector_at(of_bricks_.origin, lane);
  plane.normal = vector_at(of_bricks_.normal, lane);
  plane.axis_u = vector_at(of_bricks_.axis_u, lane);
  plane.axis_v = vector_at(of_bricks_.axis_v, lane);
  answer.normal = one_zero(pair.faces.reversed ? -Vec3(plane.normal) : Vec3(plane.normal));
  if ((of_bricks_.listed >> lane & 1) != 0) {
    std::array<PolygonCorner, 2 * kCorners> corners;
    const FlushPoints points(pair.faces, corners_of(of_bricks_, lane, corners));
    if (points.crowded(tolerance)) return;
    const Vector3 middle = 0.5 * pair.a->centre() + 0.5 * pair.b->centre();
    write(points, plane, middle, answer);
    if (options_.frame != PointFrame::World) {
      into_bodies(*pair.a, *pair.b, vector_at(of_bricks_.between, lane), answer);
    }
  }
  add(answer);
}

/// As find_face_points and append_within_reach.
void FlushBatch::add_polygon(std::size_t lane) {
  const PolygonPair& pair = polygon_pairs_[lane];
  if (!pair.proved(of_polygons_.area.of[lane], of_polygons_.margin.of[lane])) return;
  FlushPairAnswer answer;
  answer.pair = pair.number;
  answer.gap = pair.gap + 0.0;
  answer.status = status_of(answer.gap, pair.contact);
  answer.first = used_;
  const Vec3 normal = one_zero(pair.plane.normal);
  answer.normal = pair.faces.reversed ? one_zero(-normal) : normal;
  if (!(answer.gap > pair.reach && answer.status != PairStatus::Touching)) {
    const double band = std::max(pair.contact, pair.reach - answer.gap);
    const auto count = static_cast<std::size_t>(of_polygons_.count[lane]);
    const std::span corners = std::span(of_polygons_.corners[lane]).first(count);
    const bool parallels = std::any_of(corners.begin(), corners.end(), [&](const auto& corner) {
      return is_of_parallels(polygons_, corner, lane, pair.contact);
    });
    const FlushPoints points(pair.faces, corners);
    if (parallels || band > pair.clear || points.crowded(pair.contact) ||
        !points.lie_between(answer.gap + pair.border, answer.gap + band)) {
      return;
    }
    write(points, pair.plane, pair.middle, answer);
    if (options_.frame != PointFrame::World) into_bodies(*pair.a, *pair.b, pair.between, answer);
  }
  add(answer);
}

}  // namespace quoin::geometry
