#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <sstream>

#include "scene_file/mesh_file.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Vector3;

/// Depth of a point below the surface of a convex polyhedron with its outward face planes, m.
struct Plane {
  Vector3 normal;
  double offset;
};

std::vector<Plane> planes(const geometry::Shape& hull) {
  std::vector<Plane> result;
  for (int f = 0; f < hull.topology().face_count(); ++f) {
    const std::span<const int> cycle = hull.topology().face(f);
    Vector3 area = Vector3::Zero();
    Vector3 middle = Vector3::Zero();
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      const Vector3 from = hull.vertex(cycle[i]) - hull.vertex(cycle[0]);
      area += from.cross(hull.vertex(cycle[(i + 1) % cycle.size()]) - hull.vertex(cycle[0]));
      middle += hull.vertex(cycle[i]) / static_cast<double>(cycle.size());
    }
    const Vector3 normal = area.normalized();
    result.push_back({normal, normal.dot(middle)});
  }
  return result;
}

double depth(const std::vector<Plane>& planes, const Vector3& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const Plane& plane : planes) least = std::min(least, plane.offset - plane.normal.dot(point));
  return least;
}

/// How deep vertices, edge middles and face middles of the mesh lie below its hull, m.
double greatest_depth(const MeshBlock& mesh, const std::vector<Plane>& planes) {
  double greatest = 0.0;
  for (const std::vector<int>& face : mesh.faces) {
    Vector3 middle = Vector3::Zero();
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vector3 here = mesh.vertices.col(face[i]);
      const Vector3 next = mesh.vertices.col(face[(i + 1) % face.size()]);
      middle += here / static_cast<double>(face.size());
      greatest = std::max({greatest, depth(planes, here), depth(planes, 0.5 * (here + next))});
    }
    greatest = std::max(greatest, depth(planes, middle));
  }
  return greatest;
}

/// Volume of the cones from an inner point to the faces, whichever way they are turned, m3.
double cone_volume(const MeshBlock& mesh, const Vector3& inside) {
  double volume = 0.0;
  for (const std::vector<int>& face : mesh.faces) {
    double cone = 0.0;
    const Vector3 first = mesh.vertices.col(face[0]) - inside;
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      const Vector3 second = mesh.vertices.col(face[i]) - inside;
      const Vector3 third = mesh.vertices.col(face[i + 1]) - inside;
      cone += first.dot(second.cross(third)) / 6;
    }
    volume += std::abs(cone);
  }
  return volume;
}

std::string text(double value) {
  std::ostringstream stream;
  stream.precision(3);
  stream << value;
  return stream.str();
}

}  // namespace

geometry::Shape convex_block(const MeshBlock& mesh, double tolerance, double* taken) {
  // Modellers that compute in floats weld corners and cut faces to some 1e-5 of a solid: Blender's
  // pieces of a wall 10 m wide lie up to 5e-5 m below their hulls. Gaps of 1e-4 of a block are
  // laid.
  constexpr double kDoubles = 1e-6, kFloats = 1e-4;
  const geometry::Hull hull = geometry::make_hull(mesh.vertices);
  const geometry::Box& box = hull.polyhedron.box();
  // Corners of a plane face that are rounded by r each way lie within sqrt(3) r of it, and so does
  // the face of their hull.
  const double diameter = (box.max - box.min).norm();
  const double least = std::max((mesh.single ? kFloats : kDoubles) * diameter, 4 * mesh.rounding);
  const double limit = tolerance < 0 ? least : tolerance;
  const double deep = greatest_depth(mesh, planes(hull.polyhedron));
  if (deep > limit) {
    throw geometry::InputError("is not convex: its surface lies " + text(deep) +
                               " m below its convex hull, more than convexity_tolerance " +
                               text(limit) + " m");
  }
  if (taken != nullptr && deep > kDoubles * diameter) *taken = std::max(*taken, deep);
  const geometry::MassProperties mass = geometry::mass_properties(hull.polyhedron);
  const double enclosed = cone_volume(mesh, mass.centroid);
  // A surface at most `limit` below the hull leaves out at most limit × area, and area < 6 d^2.
  const double allowed = 6 * limit * diameter * diameter + 1e-9 * mass.volume;
  if (std::abs(enclosed - mass.volume) > allowed) {
    throw geometry::InputError("is not closed: its faces enclose " + text(enclosed) +
                               " m3, its convex hull " + text(mass.volume) + " m3");
  }
  return hull.polyhedron;
}

}  // namespace quoin::scene_file
