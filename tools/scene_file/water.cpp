#include "scene_file/water.hpp"

#include <algorithm>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <set>

namespace quoin::scene_file {
namespace {

using geometry::Vector3;
using solver::BlockKind;

constexpr double kTouching = 1e-6;  // of the smaller block: blocks no farther apart have a joint
constexpr double kParallel = 1.0 - 1e-4;  // cosine: 0.8 degrees

/// A contact polygon, counter-clockwise seen against the normal, which points from a to b.
struct JointPolygon {
  int a = 0, b = 0;
  Vector3 normal = Vector3::UnitX();
  std::vector<Vector3> corners{};
};

double size_of(const solver::Block& block) {
  return block.body().stretch() * block.shape->diameter();
}

std::vector<JointPolygon> joint_polygons(const solver::Scene& scene, std::span<const char> absent) {
  geometry::ContactFinder finder({});
  double largest = 0.0;
  for (const solver::Block& block : scene.blocks) {
    finder.add(block.shape, block.placement);
    largest = std::max(largest, size_of(block));
  }
  const auto is_absent = [&](int b) {
    return !absent.empty() && absent[static_cast<std::size_t>(b)] != 0;
  };
  finder.set_reach(std::max(kTouching * largest, scene.coordinate_rounding));
  std::vector<geometry::ContactPoint> points;
  finder.find(points);
  std::set<std::pair<int, int>> pairs;
  for (const geometry::ContactPoint& point : points) {
    const auto [a, b] = std::pair(point.key.a, point.key.b);
    const double size = std::min(size_of(scene.blocks[static_cast<std::size_t>(a)]),
                                 size_of(scene.blocks[static_cast<std::size_t>(b)]));
    const double touching = std::max(kTouching * size, scene.coordinate_rounding);
    if (point.gap <= touching && !is_absent(a) && !is_absent(b)) pairs.emplace(a, b);
  }
  std::vector<JointPolygon> joints;
  geometry::PairContact contact;
  for (const auto& [a, b] : pairs) {
    geometry::update_pair_contact(scene.blocks[static_cast<std::size_t>(a)].body(),
                                  scene.blocks[static_cast<std::size_t>(b)].body(), {}, contact);
    if (contact.area > 0.0) joints.push_back({a, b, contact.nearest.normal, contact.polygon});
  }
  return joints;
}

/// Adds the loads of one entry.
class Wetting {
 public:
  Wetting(const Water& water, solver::Scene& scene) : water_(water), scene_(scene) {}

  void joint(const JointPolygon& joint, double factor) {
    std::vector<Vector3> corners = joint.corners;
    add(joint.a, joint.b, joint.normal, corners, factor);
    std::ranges::reverse(corners);
    add(joint.b, joint.a, -joint.normal, std::move(corners), factor);
  }

  void faces(int block) {
    const geometry::Body body = scene_.blocks[static_cast<std::size_t>(block)].body();
    const geometry::Topology& topology = body.shape().topology();
    for (int f = 0; f < topology.face_count(); ++f) {
      std::vector<Vector3> corners;
      for (const int v : topology.face(f)) corners.push_back(body.vertex(v));
      const Vector3 normal = (body.cofactors() * body.shape().face_normal(f)).normalized();
      add(block, -1, normal, std::move(corners), 1.0);
    }
  }

 private:
  /// `normal`: outward of the block.
  void add(int block, int other, const Vector3& normal, std::vector<Vector3> corners,
           double factor) {
    const BlockKind kind = scene_.blocks[static_cast<std::size_t>(block)].kind;
    if (kind != BlockKind::Rigid && kind != BlockKind::Deformable) return;
    if (water_.towards && normal.dot(water_.towards->normalized()) < kParallel) return;
    const bool of_joint = water_.surface == WetSurface::Joints;
    if (!water_.wets(block, of_joint ? other : -1)) return;
    scene_.pressure_loads.push_back({.block = block,
                                     .corners = std::move(corners),
                                     .field = water_.field,
                                     .factor = factor,
                                     .divisions = water_.divisions});
  }

  const Water& water_;
  solver::Scene& scene_;
};

}  // namespace

void append_water(const Water& water, std::span<const char> absent, solver::Scene& scene) {
  Wetting wetting(water, scene);
  if (water.surface != WetSurface::Joints) {
    for (int b = 0; b < static_cast<int>(scene.blocks.size()); ++b) wetting.faces(b);
  }
  if (water.surface == WetSurface::All) return;
  const double factor = water.surface == WetSurface::Joints ? 1.0 : -1.0;
  for (const JointPolygon& joint : joint_polygons(scene, absent)) wetting.joint(joint, factor);
}

}  // namespace quoin::scene_file
