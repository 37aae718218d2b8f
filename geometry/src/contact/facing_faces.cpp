#include "contact/facing_faces.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::geometry {
namespace {

/// A face steeper than 30 degrees against the contact plane parts from it by more than half the way
/// walked along it: points on it would belong to another contact.
constexpr double kFacingCosine = 0.86602540378443865, kFacingSine = 0.5;
/// A rotation and its products are right to a few eps.
constexpr double kNear = 1e-9;

}  // namespace

bool LooksAlong::operator()(int face) const {
  if (solid_.is_rigid()) {
    const double beyond = own_cosine(face) - kFacingCosine;
    if (std::abs(beyond) > kNear) return beyond > 0.0;
  }
  return along(solid_.face_normal(face), outward_) >= kFacingCosine;
}

bool LooksAlong::others_do(int face) const {
  if (solid_.is_rigid()) {  // those around it turn away by more than it leans and 30 degrees
    const double lean = own_cosine(face), aside = std::sqrt(std::max(0.0, 1.0 - lean * lean));
    const double least = lean * kFacingCosine - aside * kFacingSine;
    if (solid_.shape().label_fit(face).turn < least - kNear) return false;
  }
  const Topology& topology = solid_.topology();
  for (const int v : topology.face(face)) {
    for (const int f : topology.vertex_faces(v))
      if (f != face && (*this)(f)) return true;
  }
  return false;
}

int only_facing(const Solid& solid, const VertexSet& vertices, const Vector3& outward) {
  const Topology& topology = solid.topology();
  const LooksAlong looks(solid, outward);
  const std::span<const int> around = topology.vertex_faces(vertices[0]);
  const auto face = std::find_if(around.begin(), around.end(), looks);
  if (face == around.end()) return -1;
  const std::span<const int> set = topology.face_set(*face);
  const bool has_all = std::includes(set.begin(), set.end(), vertices.begin(), vertices.end());
  return has_all && looks.alone(*face) ? *face : -1;
}

bool faces_alone(const Solid& p, const Solid& q, const ContactPolygon& part, double band) {
  const Vector3 &outward_p = part.plane.normal, outward_q = -outward_p;
  const auto alone = [band](const Solid& solid, int face, const Vector3& outward,
                            const Support& top) {
    return only_these_beyond(solid, outward, top.value - band, solid.topology().face_set(face));
  };
  if (band > part.clear && (!alone(p, part.face_p, outward_p, part.top_p) ||
                            !alone(q, part.face_q, outward_q, part.top_q)))
    return false;
  return LooksAlong(p, outward_p).alone(part.face_p) && LooksAlong(q, outward_q).alone(part.face_q);
}

}  // namespace quoin::geometry
