#include <algorithm>
#include <numeric>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver/parts.hpp>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

struct Weighted {
  std::span<const Vector3> points;
  std::span<const double> weights;
};

/// Coordinate along which the points stretch farthest.
int longest_side(const Weighted& all, std::span<const int> members) {
  Vector3 least = all.points[index(members.front())], most = least;
  for (const int i : members) {
    least = least.cwiseMin(all.points[index(i)]);
    most = most.cwiseMax(all.points[index(i)]);
  }
  int side = 0;
  (most - least).maxCoeff(&side);
  return side;
}

/// How many of the sorted members come before the cut at this share of their weight.
std::size_t cut(const Weighted& all, std::span<const int> members, double share) {
  double sum = 0.0;
  for (const int i : members) sum += all.weights[index(i)];
  double before = 0.0;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const double weight = all.weights[index(members[k])];
    if (before + 0.5 * weight > share * sum) return k;
    before += weight;
  }
  return members.size();
}

/// `members` get the parts `first` … `first + parts` - 1.
void bisect(const Weighted& all, std::span<int> members, int first, int parts,
            std::vector<int>& part_of) {
  if (parts == 1 || members.empty()) {
    for (const int i : members) part_of[index(i)] = first;
    return;
  }
  const int side = longest_side(all, members);
  std::ranges::sort(members, {}, [&](int i) { return std::pair(all.points[index(i)][side], i); });
  const int left = parts / 2;
  const std::size_t at = cut(all, members, static_cast<double>(left) / parts);
  bisect(all, members.first(at), first, left, part_of);
  bisect(all, members.subspan(at), first + left, parts - left, part_of);
}

}  // namespace

std::vector<int> bisect(std::span<const Vector3> points, std::span<const double> weights,
                        int parts) {
  if (points.size() != weights.size()) {
    throw InputError("parts: " + std::to_string(weights.size()) + " weights are given for " +
                     std::to_string(points.size()) + " points");
  }
  if (parts < 1) throw InputError("parts: " + std::to_string(parts) + " must be at least 1");
  std::vector<int> members(points.size()), part_of(points.size(), 0);
  std::iota(members.begin(), members.end(), 0);
  bisect({points, weights}, members, 0, parts, part_of);
  return part_of;
}

std::vector<int> parts_of_blocks(const Scene& scene, int parts) {
  std::vector<Vector3> centroids;
  std::vector<double> weights;
  for (const Block& block : scene.blocks) {
    if (block.shape == nullptr)
      throw InputError("parts: block " + std::to_string(centroids.size()) + " has no shape");
    centroids.push_back(geometry::mass_properties(block.body()).centroid);
    const bool stays = block.kind == BlockKind::Fixed || block.kind == BlockKind::Prescribed;
    weights.push_back(stays ? 0.0 : 1.0);
  }
  return bisect(centroids, weights, parts);
}

}  // namespace quoin::solver
