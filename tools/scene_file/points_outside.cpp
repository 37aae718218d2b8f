#include "scene_file/points_outside.hpp"

#include <algorithm>
#include <limits>
#include <quoin/geometry/body.hpp>
#include <sstream>

namespace quoin::scene_file {

namespace {

double largest_distance(const geometry::Body& body, const Vector3& point) {
  const geometry::Shape& shape = body.shape();
  double largest = -std::numeric_limits<double>::infinity();
  for (int face = 0; face < shape.topology().face_count(); ++face) {
    const Vector3 normal = (body.cofactors() * shape.face_normal(face)).normalized();
    const Vector3 corner = body.vertex(shape.topology().face(face)[0]);
    largest = std::max(largest, normal.dot(point - corner));
  }
  return largest;
}

}  // namespace

double distance_outside(const solver::Block& block, const Vector3& point) {
  double distance = std::numeric_limits<double>::infinity();
  for (const geometry::Shape& part : block.convex_parts())
    distance = std::min(distance, largest_distance({part, block.placement}, point));
  return distance;
}

double largest_distance_on(const solver::Block& block) {
  constexpr double kTouching = 1e-6;
  const geometry::Box box = block.body().box();
  return kTouching * (box.max - box.min).norm();
}

std::vector<PointOutside> points_outside(const SceneFile& file) {
  std::vector<PointOutside> outside;
  const auto look = [&](const solver::Scene& scene, std::string_view what, int b,
                        const Vector3& point) {
    const solver::Block& block = scene.blocks[static_cast<std::size_t>(b)];
    const double distance = distance_outside(block, point);
    if (distance <= largest_distance_on(block)) return;
    const bool known = std::ranges::any_of(outside, [&](const PointOutside& other) {
      return other.what == what && other.block == block.name && other.point == point;
    });
    if (!known) outside.push_back({what, block.name, point, distance});
  };
  const auto append = [&](const solver::Scene& scene) {
    for (const auto& load : scene.point_loads) look(scene, "load", load.block, load.point);
    for (const auto& held : scene.fixed_points) {
      look(scene, "fixed point", held.block, held.point);
    }
    for (const solver::Tie& tie : scene.ties) {
      if (tie.a >= 0) look(scene, "tie", tie.a, tie.point_a);
      if (tie.b >= 0) look(scene, "tie", tie.b, tie.point_b);
    }
  };
  append(file.scene);
  for (const Stage& stage : file.stages)
    if (stage.scene) append(*stage.scene);
  for (const Monitor& monitor : file.monitors)
    if (monitor.point) look(file.scene, "monitor", monitor.blocks[0], *monitor.point);
  return outside;
}

std::vector<std::string> points_outside_lines(const SceneFile& file) {
  constexpr std::size_t kMost = 10;
  std::vector<std::string> lines;
  for (const PointOutside& point : points_outside(file)) {
    std::ostringstream line;
    line << "block \"" << point.block << "\": " << point.what << " at (" << point.point.x() << ", "
         << point.point.y() << ", " << point.point.z() << ") m is " << point.distance
         << " m or more outside it, and moves along as the end of a lever";
    lines.push_back(line.str());
  }
  if (lines.size() > kMost) {
    const std::size_t more = lines.size() - kMost;
    lines.resize(kMost);
    lines.push_back("… and " + std::to_string(more) + " points more outside their blocks");
  }
  return lines;
}

}  // namespace quoin::scene_file
