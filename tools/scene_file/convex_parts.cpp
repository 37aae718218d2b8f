#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/split.hpp>
#include <sstream>

#include "scene_file/mesh_file.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Shape;
using geometry::Vector3;
using Polygon = std::vector<Vector3>;
using Triangle = std::array<Vector3, 3>;

constexpr std::size_t kMostParts = 10000;

Vector3 area_vector(const Triangle& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]); }

/// The part of a polygon behind a plane.
Polygon behind(const Polygon& polygon, const Vector3& normal, double offset) {
  Polygon part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 &here = polygon[i], &next = polygon[(i + 1) % polygon.size()];
    const double h = normal.dot(here) - offset, n = normal.dot(next) - offset;
    if (h <= 0) part.push_back(here);
    if ((h <= 0) != (n <= 0)) part.push_back(here + h / (h - n) * (next - here));
  }
  return part;
}

/// Without vertices that rounding has left on its edges and faces: a plane through those would cut
/// off slivers.
Shape corners_alone(const Shape& shape) {
  if (shape.topology().all_are_corners()) return shape;
  std::vector<int> corners;
  for (int v = 0; v < shape.vertex_count(); ++v)
    if (shape.topology().is_corner(v)) corners.push_back(v);
  return geometry::make_hull(geometry::Points(shape.vertices()(Eigen::all, corners))).polyhedron;
}

/// Parts a solid by the planes of those faces that run through it: a binary space partition.
class Splitter {
 public:
  Splitter(const MeshBlock& mesh, Shape hull) : hull_(std::move(hull)) {
    rounding_ = 4 * mesh.rounding;
    tolerance_ = std::max(geometry::label_length(mesh.vertices), rounding_);
    for (const std::vector<int>& face : mesh.faces) {
      for (std::size_t i = 2; i < face.size(); ++i) {
        surface_.push_back({mesh.vertices.col(face[0]), mesh.vertices.col(face[i - 1]),
                            mesh.vertices.col(face[i])});
        area_ += area_vector(surface_.back()).norm();
      }
    }
  }

  std::vector<Shape> parts() {
    std::vector<const Triangle*> all;
    for (const Triangle& triangle : surface_) all.push_back(&triangle);
    split(hull_, all);
    double sum = 0.0;
    for (const Shape& part : parts_) sum += geometry::mass_properties(part).volume;
    const double volume = std::abs(signed_volume());
    const double allowed = 1e-12 * volume + rounding_ * area_;
    if (std::abs(sum - volume) <= allowed) return std::move(parts_);
    std::ostringstream line;
    line << "can't be split into convex parts: their volumes are off its own, " << volume
         << " m3, by " << sum - volume << " m3";
    throw geometry::InputError(line.str());
  }

 private:
  double signed_volume() const {
    double volume = 0.0;
    for (const auto& [p, q, r] : surface_)
      volume += (p - hull_.origin()).dot((q - hull_.origin()).cross(r - hull_.origin())) / 6;
    return volume;
  }

  /// Of what runs through the inside of a cell, m2.
  double area_inside(const Shape& cell, const Triangle& triangle) const {
    Polygon polygon(triangle.begin(), triangle.end());
    for (int f = 0; f < cell.topology().face_count() && polygon.size() > 2; ++f) {
      const Vector3 normal = cell.face_normal(f);
      polygon =
          behind(polygon, normal, normal.dot(cell.vertex(cell.topology().face(f)[0])) - tolerance_);
    }
    Vector3 area = Vector3::Zero();
    for (std::size_t i = 2; i < polygon.size(); ++i)
      area += area_vector({polygon[0], polygon[i - 1], polygon[i]});
    return area.norm();
  }

  /// How many of the triangles a plane would part.
  long parted(const std::vector<const Triangle*>& triangles, const geometry::Plane& plane) const {
    return std::ranges::count_if(triangles, [&](const Triangle* triangle) {
      const auto height = [&](const Vector3& p) { return plane.normal.dot(p - plane.point); };
      const auto [low, high] = std::ranges::minmax(*triangle, {}, height);
      return height(low) < -tolerance_ && height(high) > tolerance_;
    });
  }

  void split(const Shape& cell, const std::vector<const Triangle*>& near) {
    std::vector<std::pair<double, const Triangle*>> crossing;
    std::vector<const Triangle*> inside;
    for (const Triangle* triangle : near) {
      const double area = area_inside(cell, *triangle);
      if (!(area > tolerance_ * tolerance_)) continue;
      crossing.emplace_back(area, triangle);
      inside.push_back(triangle);
    }
    if (crossing.empty()) return take(cell);
    std::vector<std::tuple<long, double, geometry::Plane>> planes;
    for (const auto& [area, triangle] : crossing) {
      const geometry::Plane plane{(*triangle)[0], area_vector(*triangle).normalized()};
      planes.emplace_back(parted(inside, plane), -area, plane);
    }
    std::ranges::sort(planes, [](const auto& x, const auto& y) {
      return std::tie(std::get<0>(x), std::get<1>(x)) < std::tie(std::get<0>(y), std::get<1>(y));
    });
    for (const auto& [count, area, plane] : planes) {
      const geometry::Split halves = geometry::split(cell, plane);
      if (!halves.below || !halves.above) continue;
      split(corners_alone(halves.below->shape), inside);
      return split(corners_alone(halves.above->shape), inside);
    }
    take(cell);  // what runs through it lies within rounding of its faces
  }

  /// Keeps a cell that lies inside: by the solid angle of the surface [Van Oosterom & Strackee].
  void take(const Shape& cell) {
    const Vector3 from = geometry::mass_properties(cell).centroid;
    double angle = 0.0;
    for (const Triangle& triangle : surface_) {
      const Vector3 a = triangle[0] - from, b = triangle[1] - from, c = triangle[2] - from;
      const double x = a.norm(), y = b.norm(), z = c.norm();
      angle +=
          2 * std::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y);
    }
    const double winding = std::abs(angle) / (4 * std::numbers::pi);
    if (winding > 0.5) parts_.push_back(cell);
    if (parts_.size() <= kMostParts) return;
    throw geometry::InputError("needs more than " + std::to_string(kMostParts) + " convex parts");
  }

  const Shape hull_;
  std::vector<Triangle> surface_;
  double tolerance_ = 0.0, rounding_ = 0.0, area_ = 0.0;
  std::vector<Shape> parts_;
};

}  // namespace

std::vector<Shape> convex_parts(const MeshBlock& mesh) {
  const geometry::Hull hull = geometry::make_hull(mesh.vertices);
  return Splitter(mesh, corners_alone(hull.polyhedron)).parts();
}

}  // namespace quoin::scene_file
