#include "contact/flush_batch.hpp"

#include <bit>
#include <cmath>

#include "certify/canonical_order.hpp"
#include "certify/certificate.hpp"
#include "contact/contact_corners.hpp"
#include "contact/point_frame.hpp"

namespace quoin::geometry {
namespace {

constexpr int kVertices = 8, kCorners = 4;

/// A convex face of four corners, and no other vertices in it, of a solid of eight vertices in each
/// of which three faces meet; a placement that keeps lengths.
bool fits(const Body& body, int face) {
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

Vector3 at(const FlushRow (&rows)[3], std::size_t lane) {
  return {rows[0].of[lane], rows[1].of[lane], rows[2].of[lane]};
}

/// The corners that one pair has, with their names and their places in the order of keys.
struct LaneCorners {
  static constexpr std::size_t kMost = 2 * kCorners;
  std::size_t count = 0;
  std::array<const FlushCorner*, kMost> corner;
  std::array<Feature, kMost> feature_p, feature_q;
  std::array<std::int64_t, kMost> key;
  std::array<std::size_t, kMost> place;
  double nearest_squared = kInfinity;  // of two corners, m2

  LaneCorners(const FlushAnswer& found, std::size_t lane, const FlushPair& pair) {
    const Names names_p(pair.reversed ? *pair.b : *pair.a, pair.face_p);
    const Names names_q(pair.reversed ? *pair.a : *pair.b, pair.face_q);
    for (int k = 0; k < found.corner_count; ++k) {
      const FlushCorner& c = found.corners[static_cast<std::size_t>(k)];
      if ((c.pairs >> lane & 1) == 0) continue;
      corner[count] = &c;
      feature_p[count] = names_p.of(c.side_p, c.corner_p);
      feature_q[count] = names_q.of(c.side_q, c.corner_q);
      key[count] = key_number(feature_p[count], feature_q[count], pair.reversed);
      compare(lane);
      ++count;
    }
  }
  bool crowded(double tolerance) const { return !(nearest_squared > tolerance * tolerance); }

 private:
  /// The feature of one face: a side, a corner, or itself.
  struct Names {
    int face;
    std::span<const int> corners, edges;
    Names(const Body& body, int of_face)
        : face(of_face),
          corners(body.shape().topology().face(of_face)),
          edges(body.shape().topology().face_edges(of_face)) {}
    Feature of(int side, int at_corner) const {
      if (side >= 0) return {FeatureKind::Edge, edges[static_cast<std::size_t>(side)]};
      if (at_corner < 0) return {FeatureKind::Face, face};
      return {FeatureKind::Vertex, corners[static_cast<std::size_t>(at_corner)]};
    }
  };
  /// The newest with those before it: how near, and behind how many.
  void compare(std::size_t lane) {
    const double x = corner[count]->x.of[lane], y = corner[count]->y.of[lane];
    place[count] = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double dx = x - corner[k]->x.of[lane], dy = y - corner[k]->y.of[lane];
      nearest_squared = lesser(nearest_squared, dx * dx + dy * dy);
      const std::size_t smaller = key[k] <= key[count];
      place[count] += smaller;
      place[k] += 1 - smaller;
    }
  }
};

}  // namespace

bool FlushPair::take(const Body& body_a, const Body& body_b, const FeatureHint& hint) {
  if (hint.vertices_a[0] < 0 || !fits(body_a, hint.face_a) || !fits(body_b, hint.face_b) ||
      (body_a.stands_in_own_frame() && body_b.stands_in_own_frame())) {
    return false;
  }
  a.emplace(body_a);
  b.emplace(body_b);
  reversed = in_reverse_order(Solid(*a, a->centre()), Solid(*b, b->centre()));
  face_p = reversed ? hint.face_b : hint.face_a;
  face_q = reversed ? hint.face_a : hint.face_b;
  return true;
}

void FlushPair::pack(std::size_t lane, FlushQuestion& question) const {
  question.reversed[lane] = reversed;
  question.reach.of[lane] = reach;
  question.translation_a[0][lane] = a->placement().translation.data();
  question.translation_b[0][lane] = b->placement().translation.data();
  question.turned_a[0][lane] = a->turned_origin().data();
  question.turned_b[0][lane] = b->turned_origin().data();
  question.rest_a[0][lane] = a->turned_origin_rest().data();
  question.rest_b[0][lane] = b->turned_origin_rest().data();
  pack_side(reversed ? *b : *a, face_p, lane, question.p);
  pack_side(reversed ? *a : *b, face_q, lane, question.q);
}

void FlushBatch::start(const ContactOptions& options) {
  options_ = options;
  question_.tolerance = options.tolerance;
  waiting_ = 0;
  answers_.clear();
  used_ = 0;
}

void FlushBatch::take(std::size_t pair, const std::array<int, 2>& blocks, const Body& a,
                      const Body& b, const FeatureHint& hint, double reach) {
  FlushPair& entry = pairs_[waiting_];
  if (!entry.take(a, b, hint)) return;
  entry.number = pair;
  entry.blocks = blocks;
  entry.reach = reach;
  entry.pack(waiting_++, question_);
  if (waiting_ == FlushRow::kPairs) ask();
}

void FlushBatch::finish() {
  if (waiting_ > 0) ask();
}

/// Lanes that are left over repeat the first pair.
void FlushBatch::ask() {
  const std::size_t count = waiting_;
  waiting_ = 0;
  for (std::size_t lane = count; lane < FlushRow::kPairs; ++lane) pairs_[0].pack(lane, question_);
  flush_bricks(question_, found_);
  for (std::size_t lane = 0; lane < count; ++lane) {
    if ((found_.solved >> lane & 1) != 0) add_answer(lane);
  }
}

void FlushBatch::add_answer(std::size_t lane) {
  const FlushPair& pair = pairs_[lane];
  FlushPairAnswer answer;
  answer.pair = pair.number;
  answer.gap = found_.gap.of[lane] + 0.0;  // one zero, as of the normal
  answer.status = status_of(answer.gap, found_.tolerance.of[lane]);
  const Vector3 normal = at(found_.normal, lane);
  answer.normal = one_zero(pair.reversed ? -Vec3(normal) : Vec3(normal));
  answer.first = used_;
  if ((found_.listed >> lane & 1) != 0 && !add_points(lane, answer.normal)) return;
  answer.count = used_ - answer.first;
  answers_.push_back(answer);
}

/// Sorted by key, as append_corners does. False: two of them are within the tolerance of each
/// other.
bool FlushBatch::add_points(std::size_t lane, const Vector3& normal) {
  const FlushPair& pair = pairs_[lane];
  const LaneCorners corners(found_, lane, pair);
  if (corners.crowded(found_.tolerance.of[lane])) return false;
  const Vector3 origin = at(found_.origin, lane), up = at(found_.normal, lane);
  const Vector3 u = at(found_.axis_u, lane), v = at(found_.axis_v, lane);
  const bool in_world = options_.frame == PointFrame::World;
  const Vector3 middle = 0.5 * pair.a->centre() + 0.5 * pair.b->centre();
  if (points_.size() < used_ + corners.count) points_.resize(2 * (used_ + corners.count));
  for (std::size_t k = 0; k < corners.count; ++k) {
    const FlushCorner& corner = *corners.corner[k];
    const Vector3 foot = origin + u * corner.x.of[lane] + v * corner.y.of[lane];
    const double height_p = corner.height_p.of[lane], height_q = corner.height_q.of[lane];
    ContactPoint& point = points_[used_ + corners.place[k]];
    point.key = {pair.blocks[0], pair.blocks[1],
                 pair.reversed ? corners.feature_q[k] : corners.feature_p[k],
                 pair.reversed ? corners.feature_p[k] : corners.feature_q[k]};
    point.type = ContactType::FaceFace;
    point.point_a = foot + (pair.reversed ? height_q : height_p) * up;
    point.point_b = foot + (pair.reversed ? height_p : height_q) * up;
    if (in_world) {
      point.point_a += middle;
      point.point_b += middle;
    }
    point.normal = normal;
    point.gap = height_q - height_p + 0.0;  // one zero
    point.area = corner.share.of[lane];
  }
  const std::span<ContactPoint> points = std::span(points_).subspan(used_, corners.count);
  used_ += corners.count;
  if (in_world) return true;
  const Vector3 between = at(found_.between, lane);
  move(Solid(*pair.a, -0.5 * between), Solid(*pair.b, 0.5 * between), middle, options_.frame,
       points);
  return true;
}

}  // namespace quoin::geometry
