#include <ccd/ccd.h>
#include <ccd/vec3.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>

#include <exception>
#include <memory>
#include <quoin/geometry/gjk_oracle.hpp>
#include <vector>

namespace quoin::geometry {
namespace {

constexpr unsigned long kMaxIterations = 1000;
constexpr int kMaxSupports =
    2000;  // libccd's EPA sets itself no limit, and slows down as its polytope grows

/// A solid as libccd sees it: its vertices relative to an origin that both of a pair share.
struct Body {
  const Shape* solid;
  Vector3 origin;
  mutable int supports = 0;  // asked so far
};

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
  const Body& body = *static_cast<const Body*>(object);
  if (++body.supports > kMaxSupports) {  // no progress: each loop of libccd ends
    ccdVec3Set(result, 0, 0, 0);
    return;
  }
  const Vector3 d(ccdVec3X(direction), ccdVec3Y(direction), ccdVec3Z(direction));
  Eigen::Index best = 0;
  (d.transpose() * (body.solid->vertices().colwise() - body.origin)).maxCoeff(&best);
  const Vector3 point = body.solid->vertices().col(best) - body.origin;
  ccdVec3Set(result, point.x(), point.y(), point.z());
}

void centre(const void* object, ccd_vec3_t* result) {
  const Body& body = *static_cast<const Body*>(object);
  const Vector3 point = body.solid->vertices().rowwise().mean() - body.origin;
  ccdVec3Set(result, point.x(), point.y(), point.z());
}

ccd_t settings(double tolerance) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = support;
  ccd.support2 = support;
  ccd.center1 = centre;
  ccd.center2 = centre;
  ccd.max_iterations = kMaxIterations;
  ccd.epa_tolerance = tolerance;
  ccd.mpr_tolerance = tolerance;
  return ccd;
}

using Penetration = int (*)(const void*, const void*, const ccd_t*, ccd_real_t*, ccd_vec3_t*,
                            ccd_vec3_t*);

OracleAnswer depth_by(Penetration penetration, const Shape& a, const Shape& b, double tolerance) {
  const ccd_t ccd = settings(tolerance);
  const Body body_a{&a, a.vertex(0)}, body_b{&b, a.vertex(0)};
  ccd_real_t depth = 0;
  ccd_vec3_t direction, position;
  OracleAnswer answer;
  if (penetration(&body_a, &body_b, &ccd, &depth, &direction, &position) == 0 &&
      body_a.supports <= kMaxSupports) {
    answer.answered = true;
    answer.gap = -depth;
    answer.normal = {ccdVec3X(&direction), ccdVec3Y(&direction), ccdVec3Z(&direction)};
  }
  return answer;
}

fcl::Convexd convex_of(const Shape& solid, const Vector3& origin) {
  auto vertices = std::make_shared<std::vector<fcl::Vector3d>>();
  for (int v = 0; v < solid.topology().vertex_count(); ++v)
    vertices->push_back(solid.vertex(v) - origin);
  auto faces = std::make_shared<std::vector<int>>();
  for (int f = 0; f < solid.topology().face_count(); ++f) {
    const std::span<const int> face = solid.topology().face(f);
    faces->push_back(static_cast<int>(face.size()));
    faces->insert(faces->end(), face.begin(), face.end());
  }
  return {vertices, solid.topology().face_count(), faces};
}

}  // namespace

bool gjk_overlap(const Shape& a, const Shape& b) {
  const ccd_t ccd = settings(0.0);
  const Body body_a{&a, a.vertex(0)}, body_b{&b, a.vertex(0)};
  return ccdGJKIntersect(&body_a, &body_b, &ccd) != 0;
}

OracleAnswer epa_depth(const Shape& a, const Shape& b, double tolerance) {
  return depth_by(ccdGJKPenetration, a, b, tolerance);
}

OracleAnswer mpr_depth(const Shape& a, const Shape& b, double tolerance) {
  return depth_by(ccdMPRPenetration, a, b, tolerance);
}

OracleAnswer gjk_distance(const Shape& a, const Shape& b, double tolerance) {
  OracleAnswer answer;
  try {
    const Vector3 origin = a.vertex(0);
    const fcl::Convexd convex_a = convex_of(a, origin), convex_b = convex_of(b, origin);
    fcl::detail::GJKSolver_libccdd solver;
    solver.distance_tolerance = tolerance;
    solver.max_distance_iterations = kMaxIterations;
    const fcl::Transform3d here = fcl::Transform3d::Identity();
    answer.answered = solver.shapeDistance(convex_a, here, convex_b, here, &answer.gap,
                                           &answer.point_a, &answer.point_b);
    answer.point_a += origin;
    answer.point_b += origin;
  } catch (const std::exception&) {  // FCL throws on some ordinary pairs
    answer.answered = false;
  }
  return answer;
}

}  // namespace quoin::geometry
