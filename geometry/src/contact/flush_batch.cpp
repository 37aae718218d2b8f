#include "contact/flush_batch.hpp"

#include <bit>
#include <cmath>

#include "certify/canonical_order.hpp"
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

/// Are any two corners within `tolerance` of each other? m
bool crowded(const SharedCorners& corners, double tolerance) {
  double nearest = kInfinity;
  for (const SharedCorner* c = corners.begin(); c != corners.end(); ++c) {
    for (const SharedCorner* other = corners.begin(); other != c; ++other) {
      const double x = c->place.x() - other->place.x(), y = c->place.y() - other->place.y();
      nearest = lesser(nearest, x * x + y * y);
    }
  }
  return !(nearest > tolerance * tolerance);
}

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
  question_.reach = options.reach;
  waiting_ = 0;
  answers_.clear();
  points_.clear();
}

void FlushBatch::take(std::size_t pair, const std::array<int, 2>& blocks, const Body& a,
                      const Body& b, const FeatureHint& hint) {
  FlushPair& entry = pairs_[waiting_];
  if (!entry.take(a, b, hint)) return;
  entry.number = pair;
  entry.blocks = blocks;
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
  answer.gap = found_.gap.of[lane];
  const double tolerance = found_.tolerance.of[lane];
  answer.status = std::abs(answer.gap) <= tolerance ? PairStatus::Touching
                  : answer.gap > 0.0                ? PairStatus::Separated
                                                    : PairStatus::Overlapping;
  const Vector3 normal = at(found_.normal, lane);
  answer.normal = pair.reversed ? Vector3(-normal) : normal;
  answer.first = points_.size();
  if ((found_.listed >> lane & 1) != 0 && !add_points(lane, answer.normal)) return;
  answer.count = points_.size() - answer.first;
  answers_.push_back(answer);
}

/// False: two of them are within the tolerance of each other.
bool FlushBatch::add_points(std::size_t lane, const Vector3& normal) {
  const FlushPair& pair = pairs_[lane];
  const Body &a = *pair.a, &b = *pair.b;
  const Topology& topology_p = (pair.reversed ? b : a).shape().topology();
  const Topology& topology_q = (pair.reversed ? a : b).shape().topology();
  const auto vertex = [](const Topology& topology, int face, int k) {
    return Feature{FeatureKind::Vertex, topology.face(face)[static_cast<std::size_t>(k)]};
  };
  const auto edge = [](const Topology& topology, int face, int k) {
    return Feature{FeatureKind::Edge, topology.face_edges(face)[static_cast<std::size_t>(k)]};
  };
  const Feature face_p{FeatureKind::Face, pair.face_p}, face_q{FeatureKind::Face, pair.face_q};
  SharedCorners corners;
  for (int k = 0; k < found_.corner_count; ++k) {
    const FlushCorner& found = found_.corners[static_cast<std::size_t>(k)];
    if ((found.pairs >> lane & 1) == 0) continue;
    SharedCorner& corner = corners.add();
    corner.place = {found.x.of[lane], found.y.of[lane]};
    corner.height_p = found.height_p.of[lane];
    corner.height_q = found.height_q.of[lane];
    corner.share = found.share.of[lane];
    if (found.side_p >= 0) {
      corner.feature_p = edge(topology_p, pair.face_p, found.side_p);
      corner.feature_q = edge(topology_q, pair.face_q, found.side_q);
    } else {
      corner.feature_p =
          found.corner_p >= 0 ? vertex(topology_p, pair.face_p, found.corner_p) : face_p;
      corner.feature_q =
          found.corner_q >= 0 ? vertex(topology_q, pair.face_q, found.corner_q) : face_q;
    }
  }
  if (crowded(corners, found_.tolerance.of[lane])) return false;
  ContactPlane plane;
  plane.origin = at(found_.origin, lane);
  plane.normal = at(found_.normal, lane);
  plane.axis_u = at(found_.axis_u, lane);
  plane.axis_v = at(found_.axis_v, lane);
  NearestFeatures nearest;
  nearest.normal = normal;
  const std::size_t first = points_.size();
  append_corners(pair.blocks, pair.reversed, nearest, ContactType::FaceFace, plane, corners,
                 points_);
  const Vector3 between = at(found_.between, lane);
  move(Solid(a, -0.5 * between), Solid(b, 0.5 * between), 0.5 * a.centre() + 0.5 * b.centre(),
       options_.frame, std::span(points_).subspan(first));
  return true;
}

}  // namespace quoin::geometry
