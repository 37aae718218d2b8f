#include "contact/facing_faces.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::geometry {
namespace {

/// A face steeper than 30 degrees against the contact plane parts from it by more than half the way
/// walked along it: points on it would belong to another contact.
constexpr double kFacingCosine = 0.86602540378443865;

/// Does a face around `face` look at the other solid, too?
bool others_look(const Topology& topology, int face, const LooksAlong& looks) {
  const std::span<const int> beside = topology.face_neighbours(face);
  if (std::any_of(beside.begin(), beside.end(), looks)) return true;
  if (topology.three_faces_at_vertices()) return false;
  for (const int v : topology.face(face)) {
    for (const int f : topology.vertex_faces(v))
      if (f != face && looks(f)) return true;
  }
  return false;
}

bool stands_alone(const Solid& solid, int face, const Vector3& outward) {
  const LooksAlong looks(solid, outward);
  return looks(face) && !others_look(solid.topology(), face, looks);
}

}  // namespace

bool LooksAlong::operator()(int face) const {
  constexpr double kNear = 1e-9;  // a rotation and its products are right to a few eps
  if (solid_.turned() != nullptr && solid_.turned()->is_rigid()) {
    const double beyond = dot(Vec3(solid_.shape().face_normal(face)), local_) - kFacingCosine;
    if (std::abs(beyond) > kNear) return beyond > 0.0;
  }
  return along(solid_.face_normal(face), outward_) >= kFacingCosine;
}

int only_facing(const Solid& solid, const VertexSet& vertices, const Vector3& outward) {
  const Topology& topology = solid.topology();
  const LooksAlong looks(solid, outward);
  const std::span<const int> around = topology.vertex_faces(vertices[0]);
  const auto face = std::find_if(around.begin(), around.end(), looks);
  if (face == around.end()) return -1;
  const std::span<const int> set = topology.face_set(*face);
  const bool has_all = std::includes(set.begin(), set.end(), vertices.begin(), vertices.end());
  return has_all && !others_look(topology, *face, looks) ? *face : -1;
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
  return stands_alone(p, part.face_p, outward_p) && stands_alone(q, part.face_q, outward_q);
}

}  // namespace quoin::geometry
