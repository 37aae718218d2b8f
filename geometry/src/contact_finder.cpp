#include <algorithm>
#include <cmath>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <string>

#include "worker_pool.hpp"

namespace quoin::geometry {
namespace {

constexpr std::size_t kPairsPerWorker = 64;  // fewer are not worth waking a thread for

void require_length(double value, const char* what) {
  if (!(value >= 0.0) || !std::isfinite(value)) {
    throw InputError(std::string("finder: ") + what + " is " + std::to_string(value) +
                     " m, must be finite and not negative");
  }
}

FinderOptions checked(const FinderOptions& options) {
  require_length(options.reach, "reach");
  require_length(options.tolerance, "tolerance");
  if (options.threads < 1) {
    throw InputError("finder: threads is " + std::to_string(options.threads) +
                     ", must be at least 1");
  }
  return options;
}

}  // namespace

struct ContactFinder::Memory {
  explicit Memory(const FinderOptions& given) : options(checked(given)), workers(given.threads) {
    parts.resize(static_cast<std::size_t>(given.threads));
  }

  FinderOptions options;
  WorkerPool workers;
  BroadPhase broad_phase;
  std::vector<Box> boxes;
  std::vector<BlockPair> pairs;                  // of the last call
  std::vector<FeatureHint> hints, carried;       // one a pair
  std::vector<std::vector<ContactPoint>> parts;  // what each worker found

  void carry_hints(const std::vector<BlockPair>& candidates);
  void search(std::span<const Polyhedron> blocks, std::size_t first, std::size_t last,
              std::vector<ContactPoint>& contacts);
  void search_in_parallel(std::span<const Polyhedron> blocks, std::vector<ContactPoint>& contacts);
};

/// Each pair of the last call keeps its hint; a new one starts cold.
void ContactFinder::Memory::carry_hints(const std::vector<BlockPair>& candidates) {
  if (candidates == pairs) {
    return;
  }
  carried.resize(candidates.size());
  std::size_t old = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    while (old < pairs.size() && pairs[old] < candidates[i]) {
      ++old;
    }
    const bool known = old < pairs.size() && pairs[old] == candidates[i];
    carried[i] = known ? hints[old] : FeatureHint{};
  }
  std::swap(hints, carried);
  pairs = candidates;
}

/// Appends the contact points of pairs first … last - 1, sorted by key.
void ContactFinder::Memory::search(std::span<const Polyhedron> blocks, std::size_t first,
                                   std::size_t last, std::vector<ContactPoint>& contacts) {
  const SearchOptions search_options{.tolerance = options.tolerance};
  for (std::size_t i = first; i < last; ++i) {
    const Polyhedron& a = blocks[static_cast<std::size_t>(pairs[i].a)];
    const Polyhedron& b = blocks[static_cast<std::size_t>(pairs[i].b)];
    const NearestFeatures nearest = nearest_features(a, b, search_options, hints[i]);
    hints[i] = nearest.hint;
    if (nearest.gap <= options.reach || nearest.status == PairStatus::Touching) {
      append_contact_points(
          {pairs[i].a, pairs[i].b}, a, b, nearest,
          {.tolerance = options.tolerance, .reach = std::max(0.0, options.reach - nearest.gap)},
          contacts);
    }
  }
}

/// Each worker takes a run of neighbouring pairs and finds its part of the list; the parts are then
/// copied behind each other, by all workers again. What `contacts` held is overwritten in place: a
/// vector that is emptied first would write all its elements once more.
void ContactFinder::Memory::search_in_parallel(std::span<const Polyhedron> blocks,
                                               std::vector<ContactPoint>& contacts) {
  const auto count = static_cast<std::size_t>(workers.count());
  auto find_part = [&](int worker) {
    const auto w = static_cast<std::size_t>(worker);
    parts[w].clear();
    search(blocks, pairs.size() * w / count, pairs.size() * (w + 1) / count, parts[w]);
  };
  workers.run(find_part);
  std::size_t total = 0;
  for (const std::vector<ContactPoint>& part : parts) {
    total += part.size();
  }
  contacts.resize(total);
  auto copy_part = [&](int worker) {
    const auto w = static_cast<std::size_t>(worker);
    std::size_t before = 0;
    for (std::size_t i = 0; i < w; ++i) {
      before += parts[i].size();
    }
    std::copy(parts[w].begin(), parts[w].end(),
              contacts.begin() + static_cast<std::ptrdiff_t>(before));
  };
  workers.run(copy_part);
}

ContactFinder::ContactFinder(const FinderOptions& options)
    : memory_(std::make_unique<Memory>(options)) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

void ContactFinder::set_reach(double reach) {
  require_length(reach, "reach");
  memory_->options.reach = reach;
}

void ContactFinder::find(std::span<const Polyhedron> blocks, std::span<const char> idle,
                         std::vector<ContactPoint>& contacts) {
  Memory& m = *memory_;
  m.boxes.resize(blocks.size());
  double reach = std::max(m.options.reach, m.options.tolerance);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    m.boxes[i] = blocks[i].box();
    if (m.options.tolerance == 0.0) {
      reach = std::max(reach, default_tolerance(blocks[i], blocks[i]));
    }
  }
  m.carry_hints(m.broad_phase.find_candidates(m.boxes, reach, idle));
  const auto workers = static_cast<std::size_t>(m.workers.count());
  if (workers > 1 && m.pairs.size() >= workers * kPairsPerWorker) {
    m.search_in_parallel(blocks, contacts);
  } else {
    contacts.clear();
    m.search(blocks, 0, m.pairs.size(), contacts);
  }
}

}  // namespace quoin::geometry
