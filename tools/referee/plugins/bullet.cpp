/// Bullet (double precision) as a plug-in of the referee: hulls without margin, its GJK with EPA as
/// an engine calls it and by itself (btGjkEpaSolver2); boxes by its box-box detector.

#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <LinearMath/btScalar.h>

#include "peer_solid.hpp"

namespace {

using quoin::referee::copy, quoin::referee::free_solid;
using quoin::referee::Vector3;

btTransform to_bullet(const quoin_referee_placement& placement, const Vector3& middle) {
  const quoin::referee::PeerPlacement place = quoin::referee::to_eigen(placement);
  const double* m = placement.linear;
  const Vector3 t = place.translation + place.linear * middle;
  return btTransform(btMatrix3x3(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]),
                     btVector3(t.x(), t.y(), t.z()));
}

template <class Shape>
struct Placed {
  Shape shape;
  Vector3 middle = Vector3::Zero();  ///< of the shape's frame in the solid's, m
  btTransform place = btTransform::getIdentity();
};
using PlacedHull = Placed<btConvexHullShape>;
using PlacedBox = Placed<btBoxShape>;

template <class Shape>
void set_placement(void* solid, const quoin_referee_placement* placement) {
  auto& placed = *static_cast<Placed<Shape>*>(solid);
  placed.place = to_bullet(*placement, placed.middle);
}

struct Memory {
  btVector3 axis{0, 1, 0};
};

Vector3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

void* make_hull(const quoin_referee_solid* solid) {
  auto* made = new PlacedHull;
  for (const Vector3& point : quoin::referee::points_of(*solid))
    made->shape.addPoint(btVector3(point.x(), point.y(), point.z()), false);
  made->shape.recalcLocalAabb();
  made->shape.setMargin(0);
  return made;
}

void* make_memory() { return new Memory; }
void free_memory(void* memory) { delete static_cast<Memory*>(memory); }

quoin_referee_status ask_detector(void* a_solid, void* b_solid, void* memory,
                                  quoin_referee_answer* answer) {
  PlacedHull& a = *static_cast<PlacedHull*>(a_solid);
  PlacedHull& b = *static_cast<PlacedHull*>(b_solid);
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth_solver;
  btGjkPairDetector detector(&a.shape, &b.shape, &simplex, &depth_solver);
  if (memory != nullptr) detector.setCachedSeparatingAxis(static_cast<Memory*>(memory)->axis);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = a.place;
  input.m_transformB = b.place;
  btPointCollector found;
  detector.getClosestPoints(input, found, nullptr);
  if (memory != nullptr) static_cast<Memory*>(memory)->axis = detector.getCachedSeparatingAxis();
  if (!found.m_hasResult) return QUOIN_REFEREE_FAILED;
  const Vector3 normal = from_bullet(found.m_normalOnBInWorld);
  const Vector3 on_b = from_bullet(found.m_pointInWorld);
  answer->gap = found.m_distance;
  copy(-normal, answer->normal);
  copy(on_b + found.m_distance * normal, answer->point_a);
  copy(on_b, answer->point_b);
  return QUOIN_REFEREE_ANSWERED;
}

/// Distance first, depth where there is none.
quoin_referee_status ask_epa2(void* a_solid, void* b_solid, void*, quoin_referee_answer* answer) {
  const PlacedHull& a = *static_cast<PlacedHull*>(a_solid);
  const PlacedHull& b = *static_cast<PlacedHull*>(b_solid);
  const btVector3 guess = b.place.getOrigin() - a.place.getOrigin();
  btGjkEpaSolver2::sResults found;
  if (!btGjkEpaSolver2::Distance(&a.shape, a.place, &b.shape, b.place, guess, found) &&
      !btGjkEpaSolver2::Penetration(&a.shape, a.place, &b.shape, b.place, guess, found, false))
    return QUOIN_REFEREE_FAILED;
  answer->gap = found.distance;
  copy(from_bullet(found.witnesses[0]), answer->point_a);
  copy(from_bullet(found.witnesses[1]), answer->point_b);
  return QUOIN_REFEREE_ANSWERED;  // its normal has either sign: none is offered
}

void* make_box(const quoin_referee_solid* solid) {
  if (solid->box_half[0] == 0) return nullptr;
  const double* half = solid->box_half;
  auto* made =
      new PlacedBox{btBoxShape(btVector3(half[0], half[1], half[2])), Vector3(solid->box_centre)};
  return made;
}

/// Keeps every point, where the engine keeps four.
struct AllPoints final : btDiscreteCollisionDetectorInterface::Result {
  struct Point {
    Vector3 normal, on_b;  ///< normal from B to A
    double gap;
  };
  std::vector<Point> points;
  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3& normal, const btVector3& on_b, btScalar gap) override {
    points.push_back({from_bullet(normal), from_bullet(on_b), gap});
  }
};

AllPoints box_contacts(void* a_solid, void* b_solid) {
  PlacedBox& a = *static_cast<PlacedBox*>(a_solid);
  PlacedBox& b = *static_cast<PlacedBox*>(b_solid);
  btBoxBoxDetector detector(&a.shape, &b.shape);
  btDiscreteCollisionDetectorInterface::ClosestPointInput input;
  input.m_transformA = a.place;
  input.m_transformB = b.place;
  AllPoints found;
  detector.getClosestPoints(input, found, nullptr);
  return found;
}

quoin_referee_status ask_boxes(void* a, void* b, void*, quoin_referee_answer* answer) {
  const AllPoints found = box_contacts(a, b);
  if (found.points.empty()) return QUOIN_REFEREE_NO_ANSWER;  // apart
  const auto deepest = std::min_element(found.points.begin(), found.points.end(),
                                        [](const auto& p, const auto& q) { return p.gap < q.gap; });
  answer->gap = deepest->gap;
  copy(-deepest->normal, answer->normal);
  return QUOIN_REFEREE_ANSWERED;
}

quoin_referee_status list_points(void* a, void* b, void*, quoin_referee_point* points, int* count) {
  const AllPoints found = box_contacts(a, b);
  const int room = *count;
  *count = static_cast<int>(found.points.size());
  for (int i = 0; i < std::min(room, *count); ++i) {
    const AllPoints::Point& point = found.points[static_cast<std::size_t>(i)];
    copy(point.on_b + point.gap * point.normal, points[i].point_a);
    copy(point.on_b, points[i].point_b);
    points[i].gap = point.gap;
    points[i].area = 0;
  }
  return *count == 0 ? QUOIN_REFEREE_NO_ANSWER : QUOIN_REFEREE_ANSWERED;
}

constexpr int kGaps = QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_WITNESSES;
constexpr double kError =
    1e-6;  // its GJK stops at 1e-6 of the squared distance in double precision

constexpr quoin_referee_library kLibraries[] = {
    {QUOIN_REFEREE_INTERFACE, "Bullet GJK", "double",
     kGaps | QUOIN_REFEREE_NORMAL | QUOIN_REFEREE_MEMORY, kError, make_hull,
     free_solid<Placed<btConvexHullShape>>, make_memory, free_memory,
     set_placement<btConvexHullShape>, ask_detector, nullptr},
    {QUOIN_REFEREE_INTERFACE, "Bullet GjkEpa2", "double", kGaps, kError, make_hull,
     free_solid<Placed<btConvexHullShape>>, nullptr, nullptr, set_placement<btConvexHullShape>,
     ask_epa2, nullptr},
    {QUOIN_REFEREE_INTERFACE, "Bullet box-box", "double",
     QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL | QUOIN_REFEREE_POINTS | QUOIN_REFEREE_BOXES_ONLY,
     0.0, make_box, free_solid<Placed<btBoxShape>>, nullptr, nullptr, set_placement<btBoxShape>,
     ask_boxes, list_points}};

}  // namespace

extern "C" const quoin_referee_library* quoin_referee_plugin(int index) {
  return quoin::referee::library_at(index, kLibraries);
}
