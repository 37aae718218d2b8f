/// G01–G08: contact geometry of single pairs.

#include <algorithm>
#include <cmath>
#include <quoin/geometry/contact_point.hpp>

#include "cases.hpp"
#include "scenes.hpp"

namespace quoin::validation {
namespace {

using geometry::ContactType;
using geometry::NearestFeatures;
using geometry::Shape;

Shape cube(const Vector3& centre, const Matrix3& rotation = Matrix3::Identity(),
           double side = 1.0) {
  const Vector3 half = Vector3::Constant(0.5 * side);
  return Frame{.rotation = rotation, .origin = centre}.place(geometry::make_box(-half, half));
}

Shape hull(std::initializer_list<Vector3> corners) {
  geometry::Points points(3, static_cast<Eigen::Index>(corners.size()));
  Eigen::Index i = 0;
  for (const Vector3& corner : corners) points.col(i++) = corner;
  return geometry::make_hull(points).polyhedron;
}

geometry::PairContact pair_contact(const Shape& a, const Shape& b, double reach = 0.0) {
  geometry::PairContact contact;
  geometry::update_pair_contact(a, b, {.tolerance = 0.0, .reach = reach}, contact);
  return contact;
}

void normal_rows(const Vector3& exact, const NearestFeatures& nearest, double allowed,
                 Report& report) {
  report.absolute("normal, |difference|", 0.0, (nearest.normal - exact).norm(), allowed);
}

}  // namespace

void g01_local_search(Report& report) {
  // A flat pyramid with its base on top against the tip of a tetrahedron: the nearest vertex pair
  // is (apex, tip), and no face around the apex holds the nearest point.
  const Shape a = hull({{-10, -10, 0}, {10, -10, 0}, {10, 10, 0}, {-10, 10, 0}, {0, 0, -0.5}});
  const Shape b = hull({{0, 0, 0.005}, {1, 0, 1}, {-0.5, 0.8, 1}, {-0.5, -0.8, 1}});
  const geometry::PairContact contact = pair_contact(a, b);
  report.absolute("distance [m]", 0.005, contact.nearest.gap, 1e-14);
  report.absolute("witness on A, |difference| [m]", 0.0, contact.nearest.point_a.norm(), 1e-14);
  report.absolute("witness on B, |difference| [m]", 0.0,
                  (contact.nearest.point_b - Vector3(0, 0, 0.005)).norm(), 1e-14);
  normal_rows(Vector3::UnitZ(), contact.nearest, 1e-14, report);
  report.absolute(
      "contact points, all vertex-face", 1.0,
      contact.type == ContactType::VertexFace ? static_cast<double>(contact.points.size()) : 0.0,
      0.0);
}

namespace {

void crossed_edges(const Vector3& shift, double allowed, Report& report) {
  const Matrix3 about_x = turn(radians(45), Vector3::UnitX());
  const Matrix3 about_y = turn(radians(45), Vector3::UnitY());
  const Shape a = cube(shift, about_x);
  for (const double gap : {0.01, -0.01}) {
    const Shape b = cube(shift + Vector3(0, 0, std::sqrt(2.0) + gap), about_y);
    const geometry::PairContact contact = pair_contact(a, b);
    const std::string at = " at " + text(gap);
    report.absolute("signed gap [m]" + at, gap, contact.nearest.gap, allowed);
    normal_rows(Vector3::UnitZ(), contact.nearest, std::max(allowed, 1e-12), report);
    report.absolute("crossed edges (1 yes)" + at, 1.0,
                    contact.type == ContactType::EdgeEdgeCrossing ? 1.0 : 0.0, 0.0);
    const Vector3 crossing = shift + Vector3(0, 0, std::sqrt(0.5));
    report.absolute("witness on A, |difference| [m]" + at, 0.0,
                    (contact.nearest.point_a - crossing).norm(), std::max(allowed, 1e-12));
  }
}

}  // namespace

void g02_crossed_edges(Report& report) { crossed_edges(Vector3::Zero(), 1e-14, report); }

void g07_far_from_the_origin(Report& report) {
  crossed_edges({512345.678, 4123456.789, 1500.25}, 5e-12, report);
}

void g03_turned_faces(Report& report) {
  const Shape a = cube(Vector3::Zero());
  const Shape b = cube({0, 0, 1}, turn(radians(45), Vector3::UnitZ()));
  const geometry::PairContact contact = pair_contact(a, b);
  report.absolute("face-face (1 yes)", 1.0, contact.type == ContactType::FaceFace ? 1.0 : 0.0, 0.0);
  report.absolute("area of the octagon [m2]", 2.0 * (std::sqrt(2.0) - 1.0), contact.area, 1e-12);
  report.absolute("corners", 8.0, static_cast<double>(contact.polygon.size()), 0.0);
  report.absolute("contact points", 8.0, static_cast<double>(contact.points.size()), 0.0);
  const double side =
      contact.polygon.size() < 2 ? 0.0 : (contact.polygon[1] - contact.polygon[0]).norm();
  report.absolute("side [m]", std::sqrt(2.0) - 1.0, side, 1e-12);
}

void g04_nearly_parallel_edges(Report& report) {
  // Roofs of 100 m with their ridges 0.01 m apart, crossing in the middle at a small angle:
  // alternating projection shrinks the offset by cos^2 of it a cycle, 9 million cycles for 1e-12 at
  // 0.1 degrees.
  const Shape a =
      hull({{-50, 0, 0}, {50, 0, 0}, {-50, -1, -1}, {50, -1, -1}, {-50, 1, -1}, {50, 1, -1}});
  const Shape roof =
      hull({{-50, 0, 0}, {50, 0, 0}, {-50, -1, 1}, {50, -1, 1}, {-50, 1, 1}, {50, 1, 1}});
  for (const double degrees : {10.0, 5.0, 1.0, 0.1}) {
    const Frame crossed{.rotation = turn(radians(degrees), Vector3::UnitZ()),
                        .origin = Vector3(0, 0, 0.01)};
    const NearestFeatures nearest = geometry::nearest_features(a, crossed.place(roof));
    const std::string at = " at " + text(degrees) + " deg";
    report.absolute("distance [m]" + at, 0.01, nearest.gap, 1e-14);
    report.absolute("iterations" + at, 0.0, nearest.iterations, 10.0);
  }
}

void g05_vertex_to_vertex(Report& report) {
  const geometry::PairContact contact =
      pair_contact(cube(Vector3::Zero()), cube(Vector3::Constant(1.001)));
  report.absolute("distance [m]", 0.001 * std::sqrt(3.0), contact.nearest.gap, 1e-13);
  normal_rows(Vector3::Ones().normalized(), contact.nearest, 1e-13, report);
  report.absolute("vertex-vertex (1 yes)", 1.0,
                  contact.type == ContactType::VertexVertex ? 1.0 : 0.0, 0.0);
  report.absolute("contact plane flagged indeterminate (1 yes)", 1.0,
                  contact.nearest.indeterminate ? 1.0 : 0.0, 0.0);
}

void g06_slivers(Report& report) {
  const Shape a = geometry::make_box({-50, -50, -0.001}, {50, 50, 0});
  const Frame turned{.rotation = turn(radians(17), Vector3::UnitZ()), .origin = Vector3(30, 20, 0)};
  const Shape b = turned.place(geometry::make_box({-0.5, -0.5, 1e-7}, {0.5, 0.5, 0.001 + 1e-7}));
  const geometry::PairContact contact = pair_contact(a, b);
  report.absolute("distance [m]", 1e-7, contact.nearest.gap, 1e-13);
  report.absolute("contact points", 4.0, static_cast<double>(contact.points.size()), 0.0);
  report.absolute("area [m2]", 1.0, contact.area, 1e-12);
}

void g08_depth(Report& report) {
  // Least overlap over face normals and edge-edge normals, all enumerated; the same by the hull of
  // the Minkowski difference.
  const Shape a = cube(Vector3::Zero(), Matrix3::Identity(), 2.0);
  const Shape b = cube({1.3, 0.1, 1.3}, turn(radians(40), Vector3(1, 2, 3)));
  const NearestFeatures nearest = geometry::nearest_features(a, b);
  report.absolute("depth [m]", 0.1517024057963554, -nearest.gap, 1e-12);
  normal_rows({0.4915777024106926, 0.0, 0.870833716901582}, nearest, 1e-12, report);
}

}  // namespace quoin::validation
