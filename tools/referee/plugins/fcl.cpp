/// FCL as a plug-in of the referee: Convex and Box shapes, asked straight at both of its solvers,
/// as they come and with tolerances of 1e-12.

#include <fcl/config.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/narrowphase/detail/gjk_solver_indep.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>

#include "peer_solid.hpp"

namespace {

using quoin::referee::copy, quoin::referee::free_solid;
using quoin::referee::Vector3;

using Libccd = fcl::detail::GJKSolver_libccd<double>;
using Indep = fcl::detail::GJKSolver_indep<double>;

template <class Shape>
struct Placed {
  Shape shape;
  Vector3 middle = Vector3::Zero();  ///< of the shape's frame in the solid's, m
  fcl::Transform3d place = fcl::Transform3d::Identity();
};

void* make_box(const quoin_referee_solid* solid) {
  if (solid->box_half[0] == 0) return nullptr;
  return new Placed<fcl::Boxd>{fcl::Boxd(2 * Vector3(solid->box_half)), Vector3(solid->box_centre)};
}

void* make_convex(const quoin_referee_solid* solid) {
  if (solid->face_count == 0) return nullptr;
  const auto points = std::make_shared<std::vector<Vector3>>(quoin::referee::points_of(*solid));
  const auto faces = std::make_shared<std::vector<int>>();
  const int* next = solid->face_vertices;
  for (int f = 0; f < solid->face_count; ++f) {
    faces->push_back(solid->face_sizes[f]);
    faces->insert(faces->end(), next, next + solid->face_sizes[f]);
    next += solid->face_sizes[f];
  }
  return new Placed<fcl::Convexd>{fcl::Convexd(points, solid->face_count, faces, false)};
}

template <class Shape>
void set_placement(void* solid, const quoin_referee_placement* placement) {
  const quoin::referee::PeerPlacement place = quoin::referee::to_eigen(*placement);
  Placed<Shape>& to = *static_cast<Placed<Shape>*>(solid);
  to.place.linear() = place.linear;
  to.place.translation() = place.translation + place.linear * to.middle;
}

/// Tight: its tolerances at 1e-12.
enum class Tolerance { Default, Tight };

template <Tolerance tolerance>
void tighten(Libccd& solver) {
  if (tolerance == Tolerance::Tight) solver.distance_tolerance = solver.collision_tolerance = 1e-12;
}
template <Tolerance tolerance>
void tighten(Indep& solver) {
  if (tolerance == Tolerance::Tight) solver.gjk_tolerance = solver.epa_tolerance = 1e-12;
}

template <class Solver, Tolerance tolerance>
const Solver& solver_of() {
  static const Solver solver = [] {
    Solver made;
    tighten<tolerance>(made);
    return made;
  }();
  return solver;
}

/// FCL gives no normal of a distance.
template <class Shape, class Solver, Tolerance tolerance>
quoin_referee_status ask(void* a_solid, void* b_solid, void*, quoin_referee_answer* answer) {
  const Placed<Shape>& a = *static_cast<Placed<Shape>*>(a_solid);
  const Placed<Shape>& b = *static_cast<Placed<Shape>*>(b_solid);
  const Solver& solver = solver_of<Solver, tolerance>();
  Vector3 on_a = Vector3::Zero(), on_b = Vector3::Zero();
  if (solver.shapeDistance(a.shape, a.place, b.shape, b.place, &answer->gap, &on_a, &on_b) &&
      answer->gap > 0) {
    copy(on_a, answer->point_a);
    copy(on_b, answer->point_b);
    return QUOIN_REFEREE_ANSWERED;
  }
  std::vector<fcl::ContactPointd> contacts;
  if (!solver.shapeIntersect(a.shape, a.place, b.shape, b.place, &contacts) || contacts.empty())
    return QUOIN_REFEREE_FAILED;  // neither apart nor overlapping
  const fcl::ContactPointd& contact = contacts.front();
  answer->gap = -std::abs(contact.penetration_depth);  // the indep solver's has the other sign
  copy(contact.normal, answer->normal);
  copy(contact.pos + 0.5 * std::abs(answer->gap) * contact.normal, answer->point_a);
  copy(contact.pos - 0.5 * std::abs(answer->gap) * contact.normal, answer->point_b);
  return QUOIN_REFEREE_ANSWERED;
}

template <class Shape, class Solver, Tolerance tolerance>
constexpr quoin_referee_library library(const char* name) {
  constexpr bool box = std::is_same_v<Shape, fcl::Boxd>;
  return {QUOIN_REFEREE_INTERFACE,
          name,
          FCL_VERSION,
          QUOIN_REFEREE_DISTANCE | QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL |
              QUOIN_REFEREE_WITNESSES | (box ? QUOIN_REFEREE_BOXES_ONLY : 0),
          1e-6,  // its default distance and collision tolerances, of lengths near 1 m
          box ? make_box : make_convex,
          free_solid<Placed<Shape>>,
          nullptr,
          nullptr,
          set_placement<Shape>,
          ask<Shape, Solver, tolerance>,
          nullptr};
}

constexpr quoin_referee_library kLibraries[] = {
    library<fcl::Convexd, Libccd, Tolerance::Default>("FCL libccd"),
    library<fcl::Convexd, Libccd, Tolerance::Tight>("FCL libccd 1e-12"),
    library<fcl::Convexd, Indep, Tolerance::Default>("FCL indep"),
    library<fcl::Convexd, Indep, Tolerance::Tight>("FCL indep 1e-12"),
    library<fcl::Boxd, Libccd, Tolerance::Default>("FCL libccd Box"),
    library<fcl::Boxd, Indep, Tolerance::Default>("FCL indep Box")};

}  // namespace

extern "C" const quoin_referee_library* quoin_referee_plugin(int index) {
  return quoin::referee::library_at(index, kLibraries);
}
