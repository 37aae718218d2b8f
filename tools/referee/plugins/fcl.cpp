/// FCL as a plug-in of the referee: Convex shapes, asked straight at both of its solvers.

#include <fcl/config.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/narrowphase/detail/gjk_solver_indep.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>

#include "peer_solid.hpp"

namespace {

using quoin::referee::copy;
using quoin::referee::Vector3;

struct PlacedConvex {
  fcl::Convexd shape;
  fcl::Transform3d place = fcl::Transform3d::Identity();
};

void* make_solid(const quoin_referee_solid* solid) {
  if (solid->face_count == 0) {
    return nullptr;
  }
  const auto points = std::make_shared<std::vector<Vector3>>(quoin::referee::points_of(*solid));
  const auto faces = std::make_shared<std::vector<int>>();
  const int* next = solid->face_vertices;
  for (int f = 0; f < solid->face_count; ++f) {
    faces->push_back(solid->face_sizes[f]);
    faces->insert(faces->end(), next, next + solid->face_sizes[f]);
    next += solid->face_sizes[f];
  }
  return new PlacedConvex{fcl::Convexd(points, solid->face_count, faces, false)};
}
void free_solid(void* solid) { delete static_cast<PlacedConvex*>(solid); }

void set_placement(void* solid, const quoin_referee_placement* placement) {
  const quoin::referee::PeerPlacement place = quoin::referee::to_eigen(*placement);
  fcl::Transform3d& to = static_cast<PlacedConvex*>(solid)->place;
  to.linear() = place.linear;
  to.translation() = place.translation;
}

/// FCL gives no normal of a distance.
template <class Solver>
quoin_referee_status ask(void* a_solid, void* b_solid, void*, quoin_referee_answer* answer) {
  const PlacedConvex& a = *static_cast<PlacedConvex*>(a_solid);
  const PlacedConvex& b = *static_cast<PlacedConvex*>(b_solid);
  static const Solver solver;
  Vector3 on_a = Vector3::Zero(), on_b = Vector3::Zero();
  if (solver.shapeDistance(a.shape, a.place, b.shape, b.place, &answer->gap, &on_a, &on_b) &&
      answer->gap > 0) {
    copy(on_a, answer->point_a);
    copy(on_b, answer->point_b);
    return QUOIN_REFEREE_ANSWERED;
  }
  std::vector<fcl::ContactPointd> contacts;
  if (!solver.shapeIntersect(a.shape, a.place, b.shape, b.place, &contacts) || contacts.empty()) {
    return QUOIN_REFEREE_FAILED;  // neither apart nor overlapping
  }
  const fcl::ContactPointd& contact = contacts.front();
  answer->gap = -std::abs(contact.penetration_depth);  // the indep solver's has the other sign
  copy(contact.normal, answer->normal);
  copy(contact.pos + 0.5 * std::abs(answer->gap) * contact.normal, answer->point_a);
  copy(contact.pos - 0.5 * std::abs(answer->gap) * contact.normal, answer->point_b);
  return QUOIN_REFEREE_ANSWERED;
}

template <class Solver>
constexpr quoin_referee_library library(const char* name) {
  return {
      QUOIN_REFEREE_INTERFACE,
      name,
      FCL_VERSION,
      QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL | QUOIN_REFEREE_WITNESSES,
      1e-6,  // its default distance and collision tolerances, of lengths near 1 m
      make_solid,
      free_solid,
      nullptr,
      nullptr,
      set_placement,
      ask<Solver>,
      nullptr};
}

constexpr quoin_referee_library kLibraries[] = {
    library<fcl::detail::GJKSolver_libccd<double>>("FCL libccd"),
    library<fcl::detail::GJKSolver_indep<double>>("FCL indep")};

}  // namespace

extern "C" const quoin_referee_library* quoin_referee_plugin(int index) {
  return index >= 0 && index < 2 ? kLibraries + index : nullptr;
}
