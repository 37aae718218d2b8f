#include "scene_file/grouted_tie.hpp"

#include <sstream>

#include "scene_file/points_outside.hpp"

namespace quoin::scene_file {
namespace {

/// The block in which a point lies deepest; one on a joint may by rounding lie outside all.
int block_at(const solver::Scene& scene, const solver::Vector3& point) {
  int deepest = -1;
  double distance = 0.0;
  for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
    const double of_block = distance_outside(scene.blocks[b], point);
    if (of_block > largest_distance_on(scene.blocks[b])) continue;
    if (deepest >= 0 && of_block >= distance) continue;
    deepest = static_cast<int>(b);
    distance = of_block;
  }
  if (deepest >= 0) return deepest;
  std::ostringstream line;
  line << "the point (" << point.transpose() << ") m of the grouted tie lies in no block";
  throw geometry::InputError(line.str());
}

bool can_move(const solver::Scene& scene, int block) {
  return block >= 0 &&
         scene.blocks[static_cast<std::size_t>(block)].kind < solver::BlockKind::Fixed;
}

}  // namespace

std::vector<solver::Tie> grouted_tie(const solver::Scene& scene, const solver::Tie& whole,
                                     int points) {
  std::vector<solver::Tie> ties;
  solver::Tie part = whole;
  part.stiffness *= points - 1;
  part.b = whole.a >= 0 ? whole.a : block_at(scene, whole.point_a);
  part.point_b = whole.point_a;
  for (int i = 1; i < points; ++i) {
    const double share = static_cast<double>(i) / (points - 1);
    part.a = part.b;
    part.point_a = part.point_b;
    part.point_b = whole.point_a + share * (whole.point_b - whole.point_a);
    const bool last = i + 1 == points;
    part.b = last && whole.b >= 0 ? whole.b : block_at(scene, part.point_b);
    part.name = whole.name + "/" + std::to_string(i);
    if (part.a != part.b && (can_move(scene, part.a) || can_move(scene, part.b)))
      ties.push_back(part);
  }
  if (ties.empty()) {
    throw geometry::InputError("all " + std::to_string(points) +
                               " points of the grouted tie lie in one block, or in blocks that "
                               "can't move: it spans no joint");
  }
  return ties;
}

}  // namespace quoin::scene_file
