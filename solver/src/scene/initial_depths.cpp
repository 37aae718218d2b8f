#include "scene/initial_depths.hpp"

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

/// By the entries of the point's pair, with which `entries` begins, m.
double nearest_depth(std::span<const InitialDepths::Entry> entries, const ContactPoint& point,
                     double rounding) {
  const auto end = std::ranges::find_if(entries, [&](const InitialDepths::Entry& entry) {
    return pair_of(entry.key) != pair_of(point.key);
  });
  const auto distance = [&](const InitialDepths::Entry& entry) {
    return entry.key == point.key ? -1.0 : (entry.place - point.point_a).squaredNorm();
  };
  const double depth = std::ranges::min_element(entries.begin(), end, {}, distance)->depth;
  return std::abs(point.gap + depth) <= rounding ? -point.gap : depth;
}

}  // namespace

bool InitialDepths::remember(const CompiledScene& compiled, std::span<const ContactPoint> found,
                             std::span<const char> laid) {
  const auto is_laid = [&](const geometry::ContactKey& key) {
    return are_laid(laid, key.a, key.b);
  };
  std::erase_if(entries, [&](const Entry& entry) { return is_laid(entry.key); });
  const std::size_t kept = entries.size();
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
    if (is_laid(from->key) && std::any_of(from, until, counts))
      for (auto point = from; point != until; ++point)
        entries.push_back({.key = point->key, .place = point->point_a, .depth = depth(point->gap)});
    from = until;
  }
  if (entries.size() == kept) return false;
  std::ranges::sort(entries, {}, &Entry::key);
  return true;
}

void InitialDepths::take_off(const CompiledScene& compiled, std::span<const BlockState> blocks,
                             std::vector<ContactPoint>& found) const {
  auto from = entries.begin();
  int inverted = -1;  // the block A that `inverse` is of
  Matrix3 inverse = Matrix3::Identity();
  for (ContactPoint& point : found) {
    const auto pair = pair_of(point.key);
    while (from != entries.end() && pair_of(from->key) < pair) ++from;
    if (from == entries.end()) return;
    if (pair_of(from->key) != pair) continue;
    const double rounding = gap_rounding(compiled, point.key);
    const double depth = std::abs(point.gap) <= rounding
                             ? -point.gap
                             : nearest_depth({from, entries.end()}, point, rounding);
    if (depth == 0.0) continue;
    if (point.key.a != inverted) {
      const auto a = static_cast<std::size_t>(inverted = point.key.a);
      inverse = placement(compiled.models[a], pose(blocks[a])).linear.inverse();
    }
    point.point_a -= inverse * (depth * point.normal);
    point.gap += depth;
  }
}

}  // namespace quoin::solver
