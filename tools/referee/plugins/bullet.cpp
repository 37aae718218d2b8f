/// Bullet (double precision) as a plug-in of the referee: hulls without margin, its GJK with EPA as
/// an engine calls it, and its polyhedral clipping.

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <LinearMath/btScalar.h>

#include "peer_solid.hpp"

namespace {

using quoin::referee::copy;
using quoin::referee::Vector3;

struct PlacedHull {
  btConvexHullShape shape;
  btTransform place = btTransform::getIdentity();
};

struct Memory {
  btVector3 axis{0, 1, 0};
};

Vector3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

void* make_solid(const quoin_referee_solid* solid) {
  auto* made = new PlacedHull;
  for (const Vector3& point : quoin::referee::points_of(*solid)) {
    made->shape.addPoint(btVector3(point.x(), point.y(), point.z()), false);
  }
  made->shape.recalcLocalAabb();
  made->shape.setMargin(0);
  return made;
}
void free_solid(void* solid) { delete static_cast<PlacedHull*>(solid); }

void* make_memory() { return new Memory; }
void free_memory(void* memory) { delete static_cast<Memory*>(memory); }

void set_placement(void* solid, const quoin_referee_placement* placement) {
  const double* m = placement->linear;
  const double* t = placement->translation;
  static_cast<PlacedHull*>(solid)->place =
      btTransform(btMatrix3x3(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]),
                  btVector3(t[0], t[1], t[2]));
}

quoin_referee_status ask(void* a_solid, void* b_solid, void* memory, quoin_referee_answer* answer) {
  PlacedHull& a = *static_cast<PlacedHull*>(a_solid);
  PlacedHull& b = *static_cast<PlacedHull*>(b_solid);
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth_solver;
  btGjkPairDetector detector(&a.shape, &b.shape, &simplex, &depth_solver);
  if (memory != nullptr) {
    detector.setCachedSeparatingAxis(static_cast<Memory*>(memory)->axis);
  }
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = a.place;
  input.m_transformB = b.place;
  btPointCollector found;
  detector.getClosestPoints(input, found, nullptr);
  if (memory != nullptr) {
    static_cast<Memory*>(memory)->axis = detector.getCachedSeparatingAxis();
  }
  if (!found.m_hasResult) {
    return QUOIN_REFEREE_FAILED;
  }
  const Vector3 normal = from_bullet(found.m_normalOnBInWorld);
  const Vector3 on_b = from_bullet(found.m_pointInWorld);
  answer->gap = found.m_distance;
  copy(-normal, answer->normal);
  copy(on_b + found.m_distance * normal, answer->point_a);
  copy(on_b, answer->point_b);
  return QUOIN_REFEREE_ANSWERED;
}

constexpr quoin_referee_library kBullet{
    QUOIN_REFEREE_INTERFACE,
    "Bullet GJK",
    "double",
    QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL | QUOIN_REFEREE_WITNESSES |
        QUOIN_REFEREE_MEMORY,
    1e-6,  // its GJK stops at 1e-6 of the squared distance in double precision
    make_solid,
    free_solid,
    make_memory,
    free_memory,
    set_placement,
    ask,
    nullptr};

}  // namespace

extern "C" const quoin_referee_library* quoin_referee_plugin(int index) {
  return index == 0 ? &kBullet : nullptr;
}
