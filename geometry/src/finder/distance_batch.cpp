#include "finder/distance_batch.hpp"

#include <string>

#include "certify/certificate_lanes.hpp"
#include "finder/pair_checks.hpp"
#include "search/prefetch.hpp"

namespace quoin::geometry {
namespace {

constexpr std::size_t kDistancesPerWorker = 256;  // fewer are not worth waking a thread for
/// Pairs of the same kinds that wait for each other: each kind has code of 17 KB, so that the kinds
/// in turns would drive each other out of the first cache.
constexpr std::size_t kWaiting = 32;
/// How many pairs ahead answers and bodies are fetched, and then their shapes.
constexpr std::size_t kFarAhead = 12, kAhead = 8;
constexpr std::size_t kKinds = 9;  // of two features

struct WaitingPair {
  const Body *a, *b;
  NearestFeatures* answer;
};

struct WaitingPairs {
  std::array<WaitingPair, kWaiting> pairs;
  std::size_t count = 0;
};

template <class T>
void fetch_record(const T& record) {
  constexpr int kDoubles = sizeof(T) / sizeof(double);
  fetch(reinterpret_cast<const double*>(&record), kDoubles);
}

/// Answers a run of pairs.
class PairRun {
 public:
  PairRun(std::span<const Body> bodies, const SearchOptions& options)
      : bodies_(bodies), options_(options) {}

  void update(std::span<const BlockPair> pairs, std::span<NearestFeatures> answers) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (i + kFarAhead < pairs.size()) {
        fetch_record(answers[i + kFarAhead]);
        for_both(pairs[i + kFarAhead], [](const Body& body) { fetch_record(body); });
      }
      if (i + kAhead < pairs.size()) {
        for_both(pairs[i + kAhead], [](const Body& body) { fetch_record(body.shape()); });
      }
      for_both(pairs[i], [](const Body& body) {
        fetch(body.shape());
        fetch_vertices(body.shape());
      });
      take(body(pairs[i].a), body(pairs[i].b), answers[i]);
    }
    for (std::size_t kinds = 0; kinds < kKinds; ++kinds) answer_waiting(kinds);
  }

 private:
  const Body& body(int i) const { return bodies_[static_cast<std::size_t>(i)]; }
  template <class Do>
  void for_both(const BlockPair& pair, const Do& what) const {
    what(body(pair.a));
    what(body(pair.b));
  }

  /// A cold pair at once, and one with whole faces and edges on each other; others wait.
  void take(const Body& a, const Body& b, NearestFeatures& answer) {
    const FeatureHint& hint = answer.hint;
    Carrier by_a, by_b;
    const bool known = hinted_carrier(a.shape(), hint.vertices_a, hint.face_a, by_a) &&
                       hinted_carrier(b.shape(), hint.vertices_b, hint.face_b, by_b);
    const auto kind_a = static_cast<std::size_t>(by_a.kind);
    const auto kind_b = static_cast<std::size_t>(by_b.kind);
    if (!known || kind_a + kind_b > 2) return answer_alone({&a, &b, &answer});
    const std::size_t kinds = 3 * kind_a + kind_b;
    WaitingPairs& waiting = waiting_[kinds];
    waiting.pairs[waiting.count++] = {&a, &b, &answer};
    if (waiting.count == kWaiting) answer_waiting(kinds);
  }
  void answer_alone(const WaitingPair& pair) const {
    *pair.answer = nearest_features(*pair.a, *pair.b, options_, pair.answer->hint);
  }
  /// Lanes that are left over repeat the first pair.
  void answer_waiting(std::size_t kinds) {
    constexpr std::size_t kPairs = HintedPairs::kPairs;
    WaitingPairs& waiting = waiting_[kinds];
    HintedPairs four;
    four.kind_a = static_cast<FeatureKind>(kinds / 3);
    four.kind_b = static_cast<FeatureKind>(kinds % 3);
    for (std::size_t first = 0; first < waiting.count; first += kPairs) {
      const std::size_t count = std::min(kPairs, waiting.count - first);
      for (std::size_t k = 0; k < kPairs; ++k) {
        const WaitingPair& pair = waiting.pairs[first + (k < count ? k : 0)];
        four.a[k] = pair.a;
        four.b[k] = pair.b;
        four.answers[k] = pair.answer;
      }
      const unsigned proved = certify_hints(four, options_.tolerance);
      for (std::size_t k = 0; k < count; ++k) {
        if ((proved >> k & 1) == 0) answer_alone(waiting.pairs[first + k]);
      }
    }
    waiting.count = 0;
  }

  const std::span<const Body> bodies_;
  const SearchOptions& options_;
  std::array<WaitingPairs, kKinds> waiting_;
};

}  // namespace

void answer_pairs(std::span<const Body> bodies, std::span<const BlockPair> pairs,
                  std::span<NearestFeatures> answers, const SearchOptions& options) {
  PairRun(bodies, options).update(pairs, answers);
}

void update_nearest_features(std::span<const Body> bodies, std::span<const BlockPair> pairs,
                             std::span<NearestFeatures> answers, const SearchOptions& options,
                             Executor* executor) {
  check_pairs(pairs, static_cast<int>(bodies.size()));
  if (answers.size() != pairs.size()) {
    throw InputError("distance batch: " + std::to_string(answers.size()) + " answers for " +
                     std::to_string(pairs.size()) + " pairs");
  }
  check_placements(pairs, bodies.data(), [](int body) { return body; });
  const auto most =
      static_cast<std::size_t>(executor == nullptr ? 1 : std::max(1, executor->workers()));
  const std::size_t workers = pairs.size() >= most * kDistancesPerWorker ? most : 1;
  auto update = [&](int worker) {
    const auto w = static_cast<std::size_t>(worker);
    if (w >= workers) return;
    const std::size_t first = pairs.size() * w / workers;
    const std::size_t count = pairs.size() * (w + 1) / workers - first;
    answer_pairs(bodies, pairs.subspan(first, count), answers.subspan(first, count), options);
  };
  workers > 1 ? executor->run_each(update) : update(0);
}

}  // namespace quoin::geometry
