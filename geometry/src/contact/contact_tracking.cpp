#include <algorithm>
#include <quoin/geometry/contact_point.hpp>
#include <tuple>

namespace quoin::geometry {
namespace {

struct Offer {
  double squared_distance;  // m2
  int now;
  int before;
  bool operator<(const Offer& other) const {
    return std::tie(squared_distance, now, before) <
           std::tie(other.squared_distance, other.now, other.before);
  }
};

bool same_blocks(const ContactKey& k, const ContactKey& l) { return k.a == l.a && k.b == l.b; }

/// Pairs off the contacts of `now` without a namesake and those of `before` that no key claims, the
/// two nearest first. All belong to the same two blocks; both lists are emptied.
void hand_over(const std::vector<ContactPoint>& now, const std::vector<ContactPoint>& before,
               double reach, std::vector<int>& young, std::vector<int>& old,
               std::vector<int>& match) {
  std::vector<Offer> offers;
  for (int i : young) {
    for (int j : old) {
      const Vector3 between =
          now[static_cast<std::size_t>(i)].point() - before[static_cast<std::size_t>(j)].point();
      if (between.squaredNorm() <= reach * reach) {
        offers.push_back({between.squaredNorm(), i, j});
      }
    }
  }
  std::sort(offers.begin(), offers.end());
  for (const Offer& offer : offers) {
    const auto place = std::find(old.begin(), old.end(), offer.before);
    if (match[static_cast<std::size_t>(offer.now)] < 0 && place != old.end()) {
      match[static_cast<std::size_t>(offer.now)] = offer.before;
      old.erase(place);
    }
  }
  young.clear();
  old.clear();
}

}  // namespace

std::vector<int> match_previous(const std::vector<ContactPoint>& now,
                                const std::vector<ContactPoint>& before, double reach) {
  std::vector<int> match(now.size(), -1);
  std::vector<int> young, old;  // of the blocks at hand, without a namesake
  const ContactKey* blocks = nullptr;
  const auto turn_to = [&](const ContactKey& key) {
    if (blocks != nullptr && !same_blocks(*blocks, key)) {
      hand_over(now, before, reach, young, old, match);
    }
    blocks = &key;
  };
  std::size_t i = 0, j = 0;
  while (i < now.size() || j < before.size()) {
    if (j == before.size() || (i < now.size() && now[i].key < before[j].key)) {
      turn_to(now[i].key);
      young.push_back(static_cast<int>(i++));
    } else if (i == now.size() || before[j].key < now[i].key) {
      turn_to(before[j].key);
      old.push_back(static_cast<int>(j++));
    } else {
      turn_to(now[i].key);
      match[i++] = static_cast<int>(j++);
    }
  }
  hand_over(now, before, reach, young, old, match);
  return match;
}

}  // namespace quoin::geometry
