/// libccd as a plug-in of the referee: whether solids overlap (GJK), EPA and MPR depths, as they
/// come and with a tolerance of 1e-9. It has no distance of its own.

#include <ccd/ccd.h>

#include <cmath>

#include "peer_solid.hpp"

namespace {

using quoin::referee::Vector3;

struct PlacedPoints {
  std::vector<Vector3> points;  ///< in the solid's frame, m
  quoin::referee::PeerPlacement place;
  Vector3 middle = Vector3::Zero();
};

void* make_solid(const quoin_referee_solid* solid) {
  auto* made = new PlacedPoints;
  made->points = quoin::referee::points_of(*solid);
  for (const Vector3& point : made->points)
    made->middle += point / static_cast<double>(made->points.size());
  return made;
}
void set_placement(void* solid, const quoin_referee_placement* placement) {
  static_cast<PlacedPoints*>(solid)->place = quoin::referee::to_eigen(*placement);
}

void to_ccd(const Vector3& from, ccd_vec3_t* to) { ccdVec3Set(to, from.x(), from.y(), from.z()); }

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
  const auto& solid = *static_cast<const PlacedPoints*>(object);
  const Vector3 d =
      solid.place.linear.transpose() * Vector3(direction->v[0], direction->v[1], direction->v[2]);
  const Vector3* best = nullptr;
  double most = -HUGE_VAL;
  for (const Vector3& point : solid.points) {
    const double along = point.dot(d);
    if (along <= most) continue;
    best = &point;
    most = along;
  }
  to_ccd(solid.place.linear * *best + solid.place.translation, result);
}

void centre(const void* object, ccd_vec3_t* result) {
  const auto& solid = *static_cast<const PlacedPoints*>(object);
  to_ccd(solid.place.linear * solid.middle + solid.place.translation, result);
}

ccd_t settings(double tolerance) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = support;
  ccd.center1 = ccd.center2 = centre;
  ccd.max_iterations = 500;  // it comes without a limit
  if (tolerance > 0) ccd.epa_tolerance = ccd.mpr_tolerance = tolerance;
  return ccd;
}

quoin_referee_status overlaps(void* a, void* b, void*, quoin_referee_answer* answer) {
  const ccd_t ccd = settings(0);
  answer->gap = ccdGJKIntersect(a, b, &ccd) != 0 ? -1 : 1;
  return QUOIN_REFEREE_ANSWERED;
}

enum class Method { Epa, Mpr };
enum class Tolerance { Default, Tight };

template <Method method, Tolerance tolerance>
quoin_referee_status ask(void* a, void* b, void*, quoin_referee_answer* answer) {
  const ccd_t ccd = settings(tolerance == Tolerance::Tight ? 1e-9 : 0);
  ccd_real_t depth = 0;
  ccd_vec3_t normal{}, place{};
  const int failed = method == Method::Epa ? ccdGJKPenetration(a, b, &ccd, &depth, &normal, &place)
                                           : ccdMPRPenetration(a, b, &ccd, &depth, &normal, &place);
  if (failed == -1) return QUOIN_REFEREE_NO_ANSWER;  // apart
  if (failed != 0) return QUOIN_REFEREE_FAILED;
  answer->gap = -depth;
  std::copy_n(normal.v, 3, answer->normal);
  return QUOIN_REFEREE_ANSWERED;
}

using Ask = decltype(quoin_referee_library::ask);

constexpr quoin_referee_library library(const char* name, int offers, double error, Ask ask_it) {
  return {QUOIN_REFEREE_INTERFACE,
          name,
          "2",
          offers | QUOIN_REFEREE_DEFORMED,
          error,
          make_solid,
          quoin::referee::free_solid<PlacedPoints>,
          nullptr,
          nullptr,
          set_placement,
          ask_it,
          nullptr};
}

constexpr int kDepth = QUOIN_REFEREE_DEPTH | QUOIN_REFEREE_NORMAL;
constexpr double kDefault = 1e-4;  // its default tolerances, of lengths near 1 m

constexpr quoin_referee_library kLibraries[] = {
    library("libccd GJK", QUOIN_REFEREE_SIGN, 0.0, overlaps),
    library("libccd EPA", kDepth, kDefault, ask<Method::Epa, Tolerance::Default>),
    library("libccd EPA 1e-9", kDepth, kDefault, ask<Method::Epa, Tolerance::Tight>),
    library("libccd MPR", kDepth, kDefault, ask<Method::Mpr, Tolerance::Default>),
    library("libccd MPR 1e-9", kDepth, kDefault, ask<Method::Mpr, Tolerance::Tight>)};

}  // namespace

extern "C" const quoin_referee_library* quoin_referee_plugin(int index) {
  return quoin::referee::library_at(index, kLibraries);
}
