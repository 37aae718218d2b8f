#include "scene_file/water.hpp"

#include <algorithm>
#include <array>

namespace quoin::scene_file {
namespace {

using geometry::Vector3;
using solver::BlockKind;

constexpr double kParallel = 1.0 - 1e-4;  // cosine: 0.8 degrees
constexpr int kHalvings = 60;             // of an edge, to its last bit

/// Where water begins on the edge from `dry` to `wet`.
Vector3 waterline(const solver::PressureField& field, Vector3 dry, Vector3 wet) {
  for (int i = 0; i < kHalvings; ++i) {
    const Vector3 middle = 0.5 * (dry + wet);
    (field.value(middle, 0.0) > 0.0 ? wet : dry) = middle;
  }
  return dry;
}

/// The dry and the wet part of a polygon, as the water stands at the start. Loads are integrated
/// exactly where pressure is linear; across a waterline it is not.
std::array<std::vector<Vector3>, 2> at_waterline(const solver::PressureField& field,
                                                 const std::vector<Vector3>& corners) {
  std::array<std::vector<Vector3>, 2> parts;
  const auto add = [&](bool wet, const Vector3& place) {
    std::vector<Vector3>& part = parts[wet];
    if (part.empty() || (part.back() != place && part.front() != place)) part.push_back(place);
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3 &from = corners[i], &to = corners[(i + 1) % corners.size()];
    const bool wet = field.value(from, 0.0) > 0.0;
    add(wet, from);
    if (wet == (field.value(to, 0.0) > 0.0)) continue;
    const Vector3 place = wet ? waterline(field, to, from) : waterline(field, from, to);
    add(false, place);
    add(true, place);
  }
  return parts;
}

/// Adds the loads of one entry.
class Wetting {
 public:
  Wetting(const Water& water, solver::Scene& scene) : water_(water), scene_(scene) {}

  void joint(const StartJoint& joint, double factor) {
    std::vector<Vector3> corners = joint.corners;
    const bool of_two = joint.a != joint.b;
    add(joint.a, joint.normal, corners, factor, of_two ? joint.b : -1);
    std::ranges::reverse(corners);
    add(joint.b, -joint.normal, corners, factor, of_two ? joint.a : -1);
  }

  void faces(int index) {
    const solver::Block& block = scene_.blocks[static_cast<std::size_t>(index)];
    for (const geometry::Shape& part : block.convex_parts()) {
      const geometry::Body body(part, block.placement);
      for (int f = 0; f < part.topology().face_count(); ++f) {
        std::vector<Vector3> corners;
        for (const int v : part.topology().face(f)) corners.push_back(body.vertex(v));
        const Vector3 normal = (body.cofactors() * part.face_normal(f)).normalized();
        add(index, normal, corners, 1.0);
      }
    }
  }

 private:
  /// `normal`: outward of the block.
  void add(int block, const Vector3& normal, const std::vector<Vector3>& corners, double factor,
           int across = -1) {
    const BlockKind kind = scene_.blocks[static_cast<std::size_t>(block)].kind;
    if (kind != BlockKind::Rigid && kind != BlockKind::Deformable) return;
    if (water_.towards && normal.dot(water_.towards->normalized()) < kParallel) return;
    if (!water_.wets(block)) return;
    for (std::vector<Vector3>& part : at_waterline(*water_.field, corners)) {
      if (part.size() < 3) continue;
      scene_.pressure_loads.push_back({.block = block,
                                       .corners = std::move(part),
                                       .field = water_.field,
                                       .factor = factor,
                                       .divisions = water_.divisions,
                                       .across = across});
    }
  }

  const Water& water_;
  solver::Scene& scene_;
};

}  // namespace

void append_water(const Water& water, std::span<const StartJoint> joints,
                  std::span<const char> absent, solver::Scene& scene) {
  const auto is_absent = [&](int b) {
    return !absent.empty() && absent[static_cast<std::size_t>(b)] != 0;
  };
  const bool of_joints = water.surface == WetSurface::Joints;
  Wetting wetting(water, scene);
  for (int b = 0; !of_joints && b < static_cast<int>(scene.blocks.size()); ++b) wetting.faces(b);
  for (const StartJoint& joint : joints) {
    if (is_absent(joint.a) || is_absent(joint.b)) continue;
    // Faces that parts of one block have in common are no surface.
    if (joint.a == joint.b ? !of_joints : water.surface == WetSurface::Free)
      wetting.joint(joint, -1.0);
    else if (of_joints && joint.a != joint.b && water.wets_joint(joint))
      wetting.joint(joint, 1.0);
  }
}

}  // namespace quoin::scene_file
