/// ODE as a plug-in of the referee: dBoxBox for boxes, dCollide for its convex geometries, both for
/// solids that touch or overlap.

#include <ode/ode.h>

#include "peer_solid.hpp"

namespace {

using quoin::referee::copy, quoin::referee::free_solid;
using quoin::referee::Vector3;

struct PlacedBox {
  Vector3 centre;    ///< in the solid's frame, m
  dVector3 sides{};  ///< m
  dVector3 place{};
  dMatrix3 rotation{};
};

void* make_box(const quoin_referee_solid* solid) {
  if (solid->box_half[0] == 0) return nullptr;
  auto* made = new PlacedBox{Vector3(solid->box_centre), {}, {}, {}};
  for (int k = 0; k < 3; ++k) made->sides[k] = 2 * solid->box_half[k];
  return made;
}

void place_box(void* solid, const quoin_referee_placement* placement) {
  PlacedBox& box = *static_cast<PlacedBox*>(solid);
  const quoin::referee::PeerPlacement place = quoin::referee::to_eigen(*placement);
  copy(place.translation + place.linear * box.centre, box.place);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      box.rotation[4 * row + column] = place.linear(row, column);
}

constexpr int kMost = 8;

struct Contacts {
  dVector3 normal{};
  dReal depth = 0;
  dContactGeom points[kMost];
  int count = 0;
};

Contacts box_contacts(void* a_solid, void* b_solid) {
  const PlacedBox& a = *static_cast<PlacedBox*>(a_solid);
  const PlacedBox& b = *static_cast<PlacedBox*>(b_solid);
  Contacts found;
  int code = 0;
  found.count = dBoxBox(a.place, a.rotation, a.sides, b.place, b.rotation, b.sides, found.normal,
                        &found.depth, &code, kMost, found.points, sizeof(dContactGeom));
  return found;
}

struct PlacedConvex {
  Vector3 middle;  ///< origin of the geometry in the solid's frame: must lie inside, m
  std::vector<dReal> planes, points;
  std::vector<unsigned int> polygons;  ///< each: number of corners, corners
  dGeomID geometry = nullptr;
};

void add_plane(const int* face, int size, PlacedConvex& made) {
  const auto point = [&](int i) { return Vector3(made.points.data() + 3 * face[i]); };
  Vector3 normal = Vector3::Zero();  // Newell's: twice the area
  for (int i = 0; i < size; ++i)
    normal += (point(i) - point(0)).cross(point((i + 1) % size) - point(0));
  normal.normalize();
  made.planes.insert(made.planes.end(), normal.begin(), normal.end());
  made.planes.push_back(normal.dot(point(0)));
  made.polygons.push_back(static_cast<unsigned>(size));
  made.polygons.insert(made.polygons.end(), face, face + size);
}

void* make_convex(const quoin_referee_solid* solid) {
  if (solid->face_count == 0) return nullptr;
  dInitODE2(0);
  dAllocateODEDataForThread(dAllocateMaskAll);
  auto* made = new PlacedConvex;
  const Eigen::Map<const Eigen::Matrix3Xd> points(solid->points, 3, solid->point_count);
  made->middle = points.rowwise().mean();
  for (int i = 0; i < solid->point_count; ++i) {
    const Vector3 point = points.col(i) - made->middle;
    made->points.insert(made->points.end(), point.begin(), point.end());
  }
  const int* face = solid->face_vertices;
  for (int f = 0; f < solid->face_count; ++f) {
    add_plane(face, solid->face_sizes[f], *made);
    face += solid->face_sizes[f];
  }
  made->geometry = dCreateConvex(nullptr, made->planes.data(),
                                 static_cast<unsigned>(solid->face_count), made->points.data(),
                                 static_cast<unsigned>(solid->point_count), made->polygons.data());
  return made;
}

void free_convex(void* solid) {
  auto* made = static_cast<PlacedConvex*>(solid);
  dGeomDestroy(made->geometry);
  delete made;
}

void place_convex(void* solid, const quoin_referee_placement* placement) {
  const PlacedConvex& made = *static_cast<PlacedConvex*>(solid);
  const quoin::referee::PeerPlacement place = quoin::referee::to_eigen(*placement);
  dMatrix3 rotation{};
  for (int row = 0; row < 3; ++row) std::copy_n(placement->linear + 3 * row, 3, rotation + 4 * row);
  dGeomSetRotation(made.geometry, rotation);
  const Vector3 t = place.translation + place.linear * made.middle;
  dGeomSetPosition(made.geometry, t.x(), t.y(), t.z());
}

/// Of its contact points the deepest is the answer; its normals point from B to A.
Contacts convex_contacts(void* a, void* b) {
  Contacts found;
  found.count =
      dCollide(static_cast<PlacedConvex*>(a)->geometry, static_cast<PlacedConvex*>(b)->geometry,
               kMost, found.points, sizeof(dContactGeom));
  for (int i = 0; i < found.count; ++i) {
    if (i == 0 || found.points[i].depth > found.depth) {
      found.depth = found.points[i].depth;
      for (int k = 0; k < 3; ++k) found.normal[k] = -found.points[i].normal[k];
    }
  }
  return found;
}

template <Contacts (*find)(void*, void*)>
quoin_referee_status ask(void* a, void* b, void*, quoin_referee_answer* answer) {
  const Contacts found = find(a, b);
  if (found.count == 0) return QUOIN_REFEREE_NO_ANSWER;  // apart
  answer->gap = -found.depth;
  std::copy_n(found.normal, 3, answer->normal);
  return QUOIN_REFEREE_ANSWERED;
}

quoin_referee_status list_box_points(void* a, void* b, void*, quoin_referee_point* points,
                                     int* count) {
  const Contacts found = box_contacts(a, b);
  for (int i = 0; i < std::min(found.count, *count); ++i) {
    std::copy_n(found.points[i].pos, 3, points[i].point_a);
    std::copy_n(found.points[i].pos, 3, points[i].point_b);
    points[i].gap = -found.points[i].depth;
    points[i].area = 0;
  }
  *count = found.count;
  return found.count == 0 ? QUOIN_REFEREE_NO_ANSWER : QUOIN_REFEREE_ANSWERED;
}

constexpr int kOffers = QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL;

constexpr quoin_referee_library kLibraries[] = {
    {QUOIN_REFEREE_INTERFACE, "ODE dBoxBox", "double",
     kOffers | QUOIN_REFEREE_POINTS | QUOIN_REFEREE_BOXES_ONLY, 0.0, make_box,
     free_solid<PlacedBox>, nullptr, nullptr, place_box, ask<box_contacts>, list_box_points},
    {QUOIN_REFEREE_INTERFACE, "ODE convex", "double", kOffers, 0.0, make_convex, free_convex,
     nullptr, nullptr, place_convex, ask<convex_contacts>, nullptr}};

}  // namespace

extern "C" const quoin_referee_library* quoin_referee_plugin(int index) {
  return quoin::referee::library_at(index, kLibraries);
}
