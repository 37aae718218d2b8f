#include "initial_depths.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace quoin::solver {

using geometry::ContactPoint;

namespace {

std::pair<int, int> pair_of(const geometry::ContactKey& key) { return {key.a, key.b}; }

}  // namespace

void InitialDepths::remember(std::span<const ContactPoint> found, std::span<const char> laid) {
  const auto is_laid = [&](const geometry::ContactKey& key) {
    return laid[static_cast<std::size_t>(key.a)] || laid[static_cast<std::size_t>(key.b)];
  };
  std::erase_if(entries, [&](const Entry& entry) { return is_laid(entry.key); });
  for (auto from = found.begin(); from != found.end();) {
    const auto until = std::find_if(from, found.end(), [&](const ContactPoint& point) {
      return pair_of(point.key) != pair_of(from->key);
    });
    if (is_laid(from->key) &&
        std::any_of(from, until, [](const ContactPoint& point) { return point.gap < 0.0; })) {
      for (auto point = from; point != until; ++point) {
        entries.push_back(
            {.key = point->key, .place = point->point_a, .depth = std::max(0.0, -point->gap)});
      }
    }
    from = until;
  }
  std::ranges::sort(entries, {}, &Entry::key);
}

void InitialDepths::take_off(std::span<const BlockModel> models, std::span<const BlockState> blocks,
                             std::vector<ContactPoint>& found) const {
  for (ContactPoint& point : found) {
    const auto [from, until] = std::ranges::equal_range(
        entries, pair_of(point.key), {}, [](const Entry& entry) { return pair_of(entry.key); });
    if (from == until) continue;
    const auto distance = [&](const Entry& entry) {
      return entry.key == point.key ? -1.0 : (entry.place - point.point_a).squaredNorm();
    };
    const auto nearest = std::min_element(
        from, until, [&](const Entry& a, const Entry& b) { return distance(a) < distance(b); });
    const auto a = static_cast<std::size_t>(point.key.a);
    const Matrix3 linear = placement(models[a], pose(blocks[a])).linear;
    point.point_a -= linear.inverse() * (nearest->depth * point.normal);
    point.gap += nearest->depth;
  }
}

}  // namespace quoin::solver
