#include "contact/contact_tracking.hpp"

#include <algorithm>
#include <tuple>

namespace quoin::geometry {
namespace {

std::pair<PackedFeature, PackedFeature> features(const TrackedPoint& point) {
  return {point.feature_a, point.feature_b};
}

bool same_blocks(const ContactKey& k, const ContactKey& l) { return k.a == l.a && k.b == l.b; }

const ContactKey& key(const ContactPointList& points, std::size_t i) {
  return points.at(points.owner, i).key;
}

/// The run of points of one pair from `first` on.
std::size_t end_of_pair(const ContactPointList& points, std::size_t first) {
  std::size_t last = first + 1;
  while (last < points.size && same_blocks(key(points, last), key(points, first))) ++last;
  return last;
}

void track(const ContactPointList& points, std::size_t first, std::size_t last,
           std::vector<TrackedPoint>& run) {
  const Placement world;
  run.clear();
  for (std::size_t i = first; i < last; ++i) {
    const ContactPoint& point = points.at(points.owner, i);
    run.push_back(tracked(point.key, point.point(), world));
  }
}

/// Places of a run in its list.
struct Run {
  std::size_t first = 0, end = 0;
};

bool same_keys(const ContactPointList& now, const Run& new_run, const ContactPointList& before,
               const Run& old_run) {
  if (new_run.end - new_run.first != old_run.end - old_run.first) return false;
  for (std::size_t i = new_run.first, j = old_run.first; i < new_run.end; ++i, ++j)
    if (key(now, i) != key(before, j)) return false;
  return true;
}

ContactPointList in_a_row(const std::vector<ContactPoint>& points) {
  return {&points, points.size(), [](const void* owner, std::size_t i) -> const ContactPoint& {
            return (*static_cast<const std::vector<ContactPoint>*>(owner))[i];
          }};
}

}  // namespace

/// The two nearest first; one that lies at NaN inherits nothing.
void PairTracking::hand_over(double reach, std::span<int> previous) {
  offers_.clear();
  for (const Single& now : young_) {
    for (const Single& before : old_) {
      const double squared_distance = (now.place - before.place).squaredNorm();
      if (squared_distance <= reach * reach)
        offers_.push_back({squared_distance, now.index, before.index});
    }
  }
  std::sort(offers_.begin(), offers_.end(), [](const Offer& x, const Offer& y) {
    return std::tie(x.squared_distance, x.now, x.before) <
           std::tie(y.squared_distance, y.now, y.before);
  });
  for (const Offer& offer : offers_) {
    int& match = previous[static_cast<std::size_t>(offer.now)];
    const auto place = std::find_if(old_.begin(), old_.end(), [&](const Single& before) {
      return before.index == offer.before;
    });
    if (match < 0 && place != old_.end()) {
      match = offer.before;
      old_.erase(place);
    }
  }
}

void PairTracking::match(std::span<const TrackedPoint> now, std::span<const TrackedPoint> before,
                         double reach, std::span<int> previous) {
  young_.clear();
  old_.clear();
  const auto add = [](std::vector<Single>& singles, std::span<const TrackedPoint> points,
                      std::size_t i) {
    singles.push_back({static_cast<int>(i), points[i].place});
  };
  const std::size_t end_now = now.size(), end_before = before.size();
  std::size_t i = 0, j = 0;
  while (i < end_now || j < end_before) {
    if (j == end_before || (i < end_now && features(now[i]) < features(before[j]))) {
      previous[i] = -1;
      add(young_, now, i++);
    } else if (i == end_now || features(before[j]) < features(now[i])) {
      add(old_, before, j++);
    } else {
      previous[i++] = static_cast<int>(j++);
    }
  }
  if (!young_.empty() && !old_.empty()) hand_over(reach, previous);
}

std::vector<int> match_previous(const std::vector<ContactPoint>& now,
                                const std::vector<ContactPoint>& before, double reach) {
  std::vector<int> match;
  match_previous(in_a_row(now), in_a_row(before), reach, match);
  return match;
}

void match_previous(const ContactPointList& now, const ContactPointList& before, double reach,
                    std::vector<int>& match) {
  match.assign(now.size, -1);
  std::vector<TrackedPoint> tracked_now, tracked_before;
  PairTracking tracking;
  const auto blocks_less = [](const ContactKey& k, const ContactKey& l) {
    return std::pair(k.a, k.b) < std::pair(l.a, l.b);
  };
  std::size_t i = 0, j = 0;
  while (i < now.size && j < before.size) {
    const std::size_t end_now = end_of_pair(now, i), end_before = end_of_pair(before, j);
    if (blocks_less(key(now, i), key(before, j))) {
      i = end_now;
    } else if (blocks_less(key(before, j), key(now, i))) {
      j = end_before;
    } else if (same_keys(now, {i, end_now}, before, {j, end_before})) {
      for (; i < end_now; ++i, ++j) match[i] = static_cast<int>(j);
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
}

}  // namespace quoin::geometry
