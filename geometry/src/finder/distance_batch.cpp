#include <quoin/geometry/distance_batch.hpp>
#include <string>

#include "finder/pair_checks.hpp"
#include "numeric/numbers.hpp"

namespace quoin::geometry {
namespace {

constexpr std::size_t kDistancesPerWorker = 256;  // fewer are not worth waking a thread for

}  // namespace

void update_nearest_features(std::span<const Body> bodies, std::span<const BlockPair> pairs,
                             std::span<NearestFeatures> answers, const SearchOptions& options,
                             Executor* executor) {
  require_length(options.tolerance, "distance batch: tolerance");
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
    for (std::size_t i = pairs.size() * w / workers; i < pairs.size() * (w + 1) / workers; ++i)
      answers[i] = nearest_features(bodies[at(pairs[i].a)], bodies[at(pairs[i].b)], options,
                                    answers[i].hint);
  };
  workers > 1 ? executor->run_each(update) : update(0);
}

}  // namespace quoin::geometry
