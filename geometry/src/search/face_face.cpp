#include "search/face_face.hpp"

#include <algorithm>
#include <cmath>

#include "certify/canonical_order.hpp"
#include "certify/feature_normal.hpp"
#include "numeric/branchless.hpp"
#include "search/prefetch.hpp"

namespace quoin::geometry {
namespace {

/// A face steeper than 30 degrees against the contact plane parts from it by more than half the way
/// walked along it: points on it would belong to another contact.
constexpr double kFacingCosine = 0.86602540378443865;

/// A face of either solid; -1: none.
struct FacePair {
  int a = -1, b = -1;
};

/// Of the faces around the two vertices that look most at the other solid, the one of A that parts
/// these vertices most and the one of B that looks most against it.
FacePair facing_faces(const Solid& a, const Solid& b) {
  const PairSupport near = support_pair(a, b, b.vertex_mean() - a.vertex_mean());
  const int v = near.p.vertex, w = near.q.vertex;
  const int face_a = facing_face(a, v, b.vertex(w) - a.vertex(v));
  return {face_a, face_a < 0 ? -1 : facing_face(b, w, -a.face_normal(face_a))};
}

FacePair hinted_faces(const Solid& a, const Solid& b, const FeatureHint& hint) {
  const bool known =
      hint.face_a < a.topology().face_count() && hint.face_b < b.topology().face_count();
  return known ? FacePair{hint.face_a, hint.face_b} : FacePair{};
}

bool look_at_each_other(const Solid& a, const Solid& b, const FacePair& faces) {
  return faces.a >= 0 && faces.b >= 0 &&
         along(a.face_normal(faces.a), b.face_normal(faces.b)) <= kTouchingOpposite;
}

/// Does a face around `face` look at the other solid, too?
bool others_look(const Topology& topology, int face, const LooksAlong& looks) {
  const std::span<const int> beside = topology.face_neighbours(face);
  if (std::any_of(beside.begin(), beside.end(), looks)) return true;
  if (topology.three_faces_at_vertices()) return false;
  for (const int v : topology.face(face)) {
    for (const int f : topology.vertex_faces(v)) {
      if (f != face && looks(f)) return true;
    }
  }
  return false;
}

bool stands_alone(const Solid& solid, int face, const Vector3& outward) {
  const LooksAlong looks(solid, outward);
  return looks(face) && !others_look(solid.topology(), face, looks);
}

/// A face as a hint names it: with its first vertices, ascending.
void name_face(const Solid& solid, int face, std::array<int, 4>& vertices, int& hinted) {
  const std::span<const int> set = solid.topology().face_set(face);
  std::copy_n(set.begin(), std::min<std::size_t>(set.size(), 4), vertices.begin());
  hinted = face;
}

/// Two whole faces, in the order in which the pair is worked.
class WholeFaces {
 public:
  WholeFaces(const Solid& a, const Solid& b, const FacePair& faces, const Lengths& length,
             ContactPolygon& part)
      : reversed_(in_reverse_order(a, b)),
        p_(reversed_ ? b : a),
        q_(reversed_ ? a : b),
        length_(length),
        part_(part) {
    part_.face_p = reversed_ ? faces.b : faces.a;
    part_.face_q = reversed_ ? faces.a : faces.b;
  }

  /// Do the faces alone carry the plane of the larger one, lie over each other, and is no other
  /// plane better, all of it clearly?
  bool carries_answer() {
    const Vector3 normal = p_.diameter() >= q_.diameter() ? p_.face_normal(part_.face_p)
                                                          : Vector3(-q_.face_normal(part_.face_q));
    const double far_below = kFarBelow * std::min(p_.diameter(), q_.diameter());
    if (!(far_below > length_.widest && carried(normal, far_below)) &&
        !carried(normal, length_.widest)) {
      return false;
    }
    high_ = p_.vertex(part_.top_p.vertex);
    low_ = q_.vertex(part_.top_q.vertex);
    gap_ = normal.dot(low_ - high_);
    part_.plane = ContactPlane(high_, normal);
    lay_faces(p_, q_, gap_, part_);
    if (part_.corners.empty()) return false;
    find_polygon(part_);
    return surely_wide(p_, q_, part_, length_.contact) && is_best();
  }

  void describe(NearestFeatures& answer) const {
    const Vector3 normal = one_zero(part_.plane.normal);
    const Vector3 point_p = part_.plane.point(part_.polygon.centroid, 0.0);
    const Vector3 point_q = point_p + gap_ * normal;
    const double beyond_p = std::max(0.0, normal.dot(high_ - point_p));
    const double beyond_q = std::max(0.0, normal.dot(point_q - low_));
    answer.status = status_of(gap_, length_.contact);
    answer.gap = gap_ + 0.0;  // one zero, as of the normal
    answer.normal = reversed_ ? Vector3(one_zero(-Vec3(normal))) : normal;
    answer.point_a = reversed_ ? point_q : point_p;
    answer.point_b = reversed_ ? point_p : point_q;
    answer.residual_a = reversed_ ? beyond_q : beyond_p;
    answer.residual_b = reversed_ ? beyond_p : beyond_q;
    answer.iterations = 1;
    answer.feature_a = {FeatureKind::Face, reversed_ ? part_.face_q : part_.face_p};
    answer.feature_b = {FeatureKind::Face, reversed_ ? part_.face_p : part_.face_q};
  }

 private:
  /// Do just the vertices of the faces carry the planes, all others more than `clear` away?
  bool carried(const Vector3& normal, double clear) {
    const double flat = kClearBelow * length_.rounding;
    const auto set = [](const Solid& solid, int face) { return solid.topology().face_set(face); };
    part_.clear = clear;
    return carried_alone(p_, normal, {set(p_, part_.face_p), flat, clear}, part_.top_p) &&
           carried_alone(q_, -normal, {set(q_, part_.face_q), flat, clear}, part_.top_q);
  }
  bool is_best() const {
    return proves_faces(p_, q_, part_.plane.normal, gap_, length_.rounding,
                        [this] { return part_.margin; });
  }

  bool reversed_;
  const Solid &p_, &q_;
  const Lengths& length_;
  Vector3 high_, low_;  // vertices of P and Q in the support planes
  ContactPolygon& part_;
  double gap_ = 0.0;
};

}  // namespace

bool LooksAlong::operator()(int face) const {
  constexpr double kNear = 1e-9;  // a rotation and its products are right to a few eps
  if (solid_.turned() != nullptr && solid_.turned()->is_rigid()) {
    const double beyond = dot(Vec3(solid_.shape().face_normal(face)), local_) - kFacingCosine;
    if (std::abs(beyond) > kNear) return beyond > 0.0;
  }
  return along(solid_.face_normal(face), outward_) >= kFacingCosine;
}

bool faces_alone(const Solid& p, const Solid& q, const ContactPolygon& part, double band) {
  const Vector3 &outward_p = part.plane.normal, outward_q = -outward_p;
  const auto alone = [band](const Solid& solid, int face, const Vector3& outward,
                            const Support& top) {
    return only_these_beyond(solid, outward, top.value - band, solid.topology().face_set(face));
  };
  if (band > part.clear && (!alone(p, part.face_p, outward_p, part.top_p) ||
                            !alone(q, part.face_q, outward_q, part.top_q))) {
    return false;
  }
  return stands_alone(p, part.face_p, outward_p) && stands_alone(q, part.face_q, outward_q);
}

bool flush_answer(const Solid& a, const Solid& b, double tolerance, const FeatureHint& hint,
                  LateInit<ContactPolygon>& part, NearestFeatures& answer) {
  fetch(a);
  fetch(b);
  fetch_faces(a);
  fetch_faces(b);
  const bool cold = hint.vertices_a[0] < 0;
  const FacePair faces = cold ? facing_faces(a, b) : hinted_faces(a, b, hint);
  if (!look_at_each_other(a, b, faces)) return false;
  const Lengths length = lengths(a, b, tolerance);
  if (length.uneven) return false;
  WholeFaces pair(a, b, faces, length, part.emplace());
  if (!pair.carries_answer()) {
    part.reset();
    return false;
  }
  pair.describe(answer);
  name_face(a, faces.a, answer.hint.vertices_a, answer.hint.face_a);
  name_face(b, faces.b, answer.hint.vertices_b, answer.hint.face_b);
  answer.hint.normal = answer.normal;
  return true;
}

}  // namespace quoin::geometry
