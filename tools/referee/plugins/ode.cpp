/// ODE as a plug-in of the referee: dBoxBox, for boxes that touch or overlap.

#include <ode/ode.h>

#include "peer_solid.hpp"

namespace {

using quoin::referee::copy;
using quoin::referee::Vector3;

struct PlacedBox {
  Vector3 centre;    ///< in the solid's frame, m
  dVector3 sides{};  ///< m
  dVector3 place{};
  dMatrix3 rotation{};
};

void* make_solid(const quoin_referee_solid* solid) {
  if (solid->box_half[0] == 0) {
    return nullptr;
  }
  auto* made = new PlacedBox{Vector3(solid->box_centre), {}, {}, {}};
  for (int k = 0; k < 3; ++k) {
    made->sides[k] = 2 * solid->box_half[k];
  }
  return made;
}
void free_solid(void* solid) { delete static_cast<PlacedBox*>(solid); }

void set_placement(void* solid, const quoin_referee_placement* placement) {
  PlacedBox& box = *static_cast<PlacedBox*>(solid);
  const quoin::referee::PeerPlacement place = quoin::referee::to_eigen(*placement);
  copy(place.translation + place.linear * box.centre, box.place);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      box.rotation[4 * row + column] = place.linear(row, column);
    }
  }
}

constexpr int kMost = 8;

struct Contacts {
  dVector3 normal{};
  dReal depth = 0;
  dContactGeom points[kMost];
  int count = 0;
};

Contacts find(void* a_solid, void* b_solid) {
  const PlacedBox& a = *static_cast<PlacedBox*>(a_solid);
  const PlacedBox& b = *static_cast<PlacedBox*>(b_solid);
  Contacts found;
  int code = 0;
  found.count = dBoxBox(a.place, a.rotation, a.sides, b.place, b.rotation, b.sides, found.normal,
                        &found.depth, &code, kMost, found.points, sizeof(dContactGeom));
  return found;
}

quoin_referee_status ask(void* a, void* b, void*, quoin_referee_answer* answer) {
  const Contacts found = find(a, b);
  if (found.count == 0) {
    return QUOIN_REFEREE_NO_ANSWER;  // apart
  }
  answer->gap = -found.depth;
  std::copy_n(found.normal, 3, answer->normal);
  return QUOIN_REFEREE_ANSWERED;
}

quoin_referee_status list_points(void* a, void* b, void*, quoin_referee_point* points, int* count) {
  const Contacts found = find(a, b);
  for (int i = 0; i < std::min(found.count, *count); ++i) {
    std::copy_n(found.points[i].pos, 3, points[i].point_a);
    std::copy_n(found.points[i].pos, 3, points[i].point_b);
    points[i].gap = -found.points[i].depth;
    points[i].area = 0;
  }
  *count = found.count;
  return found.count == 0 ? QUOIN_REFEREE_NO_ANSWER : QUOIN_REFEREE_ANSWERED;
}

constexpr quoin_referee_library kOde{
    QUOIN_REFEREE_INTERFACE,
    "ODE dBoxBox",
    "double",
    QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL | QUOIN_REFEREE_POINTS | QUOIN_REFEREE_BOXES_ONLY,
    0.0,
    make_solid,
    free_solid,
    nullptr,
    nullptr,
    set_placement,
    ask,
    list_points};

}  // namespace

extern "C" const quoin_referee_library* quoin_referee_plugin(int index) {
  return index == 0 ? &kOde : nullptr;
}
