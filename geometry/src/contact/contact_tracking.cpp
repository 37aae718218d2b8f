#include "contact/contact_tracking.hpp"

#include <algorithm>
#include <tuple>

namespace quoin::geometry {
namespace {

std::pair<const Feature&, const Feature&> features(const TrackedPoint& point) {
  return {point.feature_a, point.feature_b};
}

bool same_blocks(const ContactKey& k, const ContactKey& l) { return k.a == l.a && k.b == l.b; }

/// The run of points of one pair from `first` on.
std::size_t end_of_pair(const std::vector<ContactPoint>& points, std::size_t first) {
  std::size_t last = first + 1;
  while (last < points.size() && same_blocks(points[last].key, points[first].key)) ++last;
  return last;
}

void track(const std::vector<ContactPoint>& points, std::size_t first, std::size_t last,
           std::vector<TrackedPoint>& tracked) {
  tracked.clear();
  for (std::size_t i = first; i < last; ++i) {
    tracked.push_back({points[i].key.feature_a, points[i].key.feature_b, points[i].point()});
  }
}

}  // namespace

/// The two nearest first; one that lies at NaN inherits nothing.
void PairTracking::hand_over(std::span<const TrackedPoint> now,
                             std::span<const TrackedPoint> before, double reach,
                             std::span<int> previous) {
  offers_.clear();
  for (const int i : young_) {
    for (const int j : old_) {
      const Vector3 between =
          now[static_cast<std::size_t>(i)].place - before[static_cast<std::size_t>(j)].place;
      if (between.squaredNorm() <= reach * reach) {
        offers_.push_back({between.squaredNorm(), i, j});
      }
    }
  }
  std::sort(offers_.begin(), offers_.end(), [](const Offer& x, const Offer& y) {
    return std::tie(x.squared_distance, x.now, x.before) <
           std::tie(y.squared_distance, y.now, y.before);
  });
  for (const Offer& offer : offers_) {
    const auto place = std::find(old_.begin(), old_.end(), offer.before);
    if (previous[static_cast<std::size_t>(offer.now)] < 0 && place != old_.end()) {
      previous[static_cast<std::size_t>(offer.now)] = offer.before;
      old_.erase(place);
    }
  }
}

void PairTracking::match(std::span<const TrackedPoint> now, std::span<const TrackedPoint> before,
                         double reach, std::span<int> previous) {
  young_.clear();
  old_.clear();
  std::size_t i = 0, j = 0;
  while (i < now.size() || j < before.size()) {
    if (j == before.size() || (i < now.size() && features(now[i]) < features(before[j]))) {
      previous[i] = -1;
      young_.push_back(static_cast<int>(i++));
    } else if (i == now.size() || features(before[j]) < features(now[i])) {
      old_.push_back(static_cast<int>(j++));
    } else {
      previous[i++] = static_cast<int>(j++);
    }
  }
  if (!young_.empty() && !old_.empty()) hand_over(now, before, reach, previous);
}

std::vector<int> match_previous(const std::vector<ContactPoint>& now,
                                const std::vector<ContactPoint>& before, double reach) {
  std::vector<int> match(now.size(), -1);
  std::vector<TrackedPoint> tracked_now, tracked_before;
  PairTracking tracking;
  const auto blocks_less = [](const ContactKey& k, const ContactKey& l) {
    return std::pair(k.a, k.b) < std::pair(l.a, l.b);
  };
  std::size_t i = 0, j = 0;
  while (i < now.size() && j < before.size()) {
    const std::size_t end_now = end_of_pair(now, i), end_before = end_of_pair(before, j);
    if (blocks_less(now[i].key, before[j].key)) {
      i = end_now;
    } else if (blocks_less(before[j].key, now[i].key)) {
      j = end_before;
    } else {
      track(now, i, end_now, tracked_now);
      track(before, j, end_before, tracked_before);
      const std::span<int> previous = std::span(match).subspan(i, end_now - i);
      tracking.match(tracked_now, tracked_before, reach, previous);
      for (int& p : previous) p += p < 0 ? 0 : static_cast<int>(j);
      i = end_now;
      j = end_before;
    }
  }
  return match;
}

}  // namespace quoin::geometry
