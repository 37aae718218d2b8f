#include "scene_file/start_joints.hpp"

#include <algorithm>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <set>

namespace quoin::scene_file {
namespace {

constexpr double kTouching = 1e-6;  // of the smaller part

/// A convex part of a block where it is laid.
struct LaidPart {
  int block = 0, part = 0;
  geometry::Body body;
  double size = 0.0;  // m
};

std::vector<LaidPart> laid_parts(const solver::Scene& scene) {
  std::vector<LaidPart> parts;
  for (int b = 0; b < static_cast<int>(scene.blocks.size()); ++b) {
    const solver::Block& block = scene.blocks[static_cast<std::size_t>(b)];
    int number = 0;
    for (const geometry::Shape& shape : block.convex_parts()) {
      const geometry::Body body(shape, block.placement);
      parts.push_back({b, number++, body, body.stretch() * shape.diameter()});
    }
  }
  return parts;
}

}  // namespace

std::vector<StartJoint> start_joints(const solver::Scene& scene) {
  const std::vector<LaidPart> parts = laid_parts(scene);
  const auto part = [&](int p) -> const LaidPart& { return parts[static_cast<std::size_t>(p)]; };
  geometry::ContactFinder finder({});
  double largest = 0.0;
  for (const LaidPart& laid : parts) {
    finder.add({std::shared_ptr<const void>(), &laid.body.shape()}, laid.body.placement());
    largest = std::max(largest, laid.size);
  }
  finder.set_reach(std::max(kTouching * largest, scene.coordinate_rounding));
  std::vector<geometry::ContactPoint> points;
  finder.find(points);
  std::set<std::pair<int, int>> pairs;
  for (const geometry::ContactPoint& point : points) {
    const auto [a, b] = std::pair(point.key.a, point.key.b);
    const double touching = kTouching * std::min(part(a).size, part(b).size);
    if (point.gap <= std::max(touching, scene.coordinate_rounding)) pairs.emplace(a, b);
  }
  std::vector<StartJoint> joints;
  geometry::PairContact contact;
  for (const auto& [a, b] : pairs) {
    geometry::update_pair_contact(part(a).body, part(b).body, {}, contact);
    if (!(contact.area > 0.0)) continue;
    joints.push_back({part(a).block, part(b).block, part(a).part, part(b).part,
                      contact.nearest.normal, contact.polygon});
  }
  return joints;
}

}  // namespace quoin::scene_file
