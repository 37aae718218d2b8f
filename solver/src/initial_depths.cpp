#include "initial_depths.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace quoin::solver {

using geometry::ContactPoint;

namespace {

std::pair<int, int> pair_of(const geometry::ContactKey& key) { return {key.a, key.b}; }

/// Of the pair's gaps, for the rounding of the coordinates, m. 0 where that is less than what every
/// step takes for zero (ContactGeometry::rounding()).
double gap_rounding(const CompiledScene& compiled, const geometry::ContactKey& key) {
  const BlockModel& a = compiled.models[static_cast<std::size_t>(key.a)];
  const BlockModel& b = compiled.models[static_cast<std::size_t>(key.b)];
  const double rounding =
      std::max(a.coordinate_rounding + b.coordinate_rounding, compiled.scene.coordinate_rounding);
  const double of_steps = 4.0 * std::numeric_limits<double>::epsilon() * (a.size + b.size);
  return rounding > of_steps ? rounding : 0.0;
}

}  // namespace

void InitialDepths::remember(const CompiledScene& compiled, std::span<const ContactPoint> found,
                             std::span<const char> laid) {
  const auto is_laid = [&](const geometry::ContactKey& key) {
    return laid[static_cast<std::size_t>(key.a)] || laid[static_cast<std::size_t>(key.b)];
  };
  std::erase_if(entries, [&](const Entry& entry) { return is_laid(entry.key); });
  const bool all = compiled.scene.initial_overlap == InitialOverlap::Zero;
  for (auto from = found.begin(); from != found.end();) {
    const auto until = std::find_if(from, found.end(), [&](const ContactPoint& point) {
      return pair_of(point.key) != pair_of(from->key);
    });
    const double rounding = gap_rounding(compiled, from->key);
    const auto depth = [&](double gap) {
      return gap < 0.0 && (all || -gap <= rounding) ? -gap : 0.0;
    };
    const auto counts = [&](const ContactPoint& point) {
      return depth(point.gap) > 0.0 || (point.gap > 0.0 && point.gap <= rounding);
    };
    if (is_laid(from->key) && std::any_of(from, until, counts)) {
      for (auto point = from; point != until; ++point) {
        entries.push_back({.key = point->key, .place = point->point_a, .depth = depth(point->gap)});
      }
    }
    from = until;
  }
  std::ranges::sort(entries, {}, &Entry::key);
}

void InitialDepths::take_off(const CompiledScene& compiled, std::span<const BlockState> blocks,
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
    const Matrix3 linear = placement(compiled.models[a], pose(blocks[a])).linear;
    const bool rounded = std::abs(point.gap + nearest->depth) <= gap_rounding(compiled, point.key);
    const double depth = rounded ? -point.gap : nearest->depth;
    point.point_a -= linear.inverse() * (depth * point.normal);
    point.gap += depth;
  }
}

}  // namespace quoin::solver
