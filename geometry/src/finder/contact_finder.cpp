#include <algorithm>
#include <cmath>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <string>

#include "finder/worker_pool.hpp"

namespace quoin::geometry {
namespace {

constexpr std::size_t kPairsPerWorker = 64;  // fewer are not worth waking a thread for
constexpr std::size_t kPairsInCache = 128;   // whose contact points are copied while still in cache

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

bool same_box(const Box& x, const Box& y) { return x.min == y.min && x.max == y.max; }

/// What a pair keeps from call to call.
struct PairMemory {
  FeatureHint hint{};
  std::ptrdiff_t first = 0;   // of its contact points in `remembered`
  std::ptrdiff_t count = -1;  // -1: not remembered
};

/// What one worker finds: points in the list at `start`, as many as it found there in the call
/// before
/// (`room`), and those beyond.
struct WorkerPart {
  std::size_t start = 0, room = 0, count = 0;
  std::vector<ContactPoint> fresh{}, beyond{};

  std::size_t total() const { return count + beyond.size(); }
  /// Puts what was found last into its place.
  void put(std::vector<ContactPoint>& contacts) {
    const std::size_t fits = beyond.empty() ? std::min(fresh.size(), room - count) : 0;
    const auto split = fresh.begin() + static_cast<std::ptrdiff_t>(fits);
    std::copy(fresh.begin(), split, contacts.begin() + static_cast<std::ptrdiff_t>(start + count));
    beyond.insert(beyond.end(), split, fresh.end());
    count += fits;
    fresh.clear();
  }
};

/// A block as it was when its box was last seen to be the same as in the call before.
struct Standing {
  std::shared_ptr<const Topology> topology{};
  Points vertices{};

  bool is(const Polyhedron& block) const {
    return topology == block.shared_topology() && vertices == block.vertices();
  }
};

}  // namespace

struct ContactFinder::Memory {
  explicit Memory(const FinderOptions& given) : options(checked(given)), workers(given.threads) {
    parts.resize(static_cast<std::size_t>(given.threads));
  }

  FinderOptions options;
  WorkerPool workers;
  BroadPhase broad_phase;
  std::vector<Box> boxes;          // of the last call
  std::vector<Standing> standing;  // one a block
  std::vector<char> stands;        // since the last call, to the bit
  std::size_t standing_blocks = 0;
  std::vector<BlockPair> pairs;            // of the last call
  std::vector<PairMemory> known, carried;  // one a pair
  std::vector<WorkerPart> parts;           // one a worker

  // Contact points of the pairs of which neither block moved, and the reach they were found with.
  std::vector<ContactPoint> remembered, next_remembered;
  std::size_t remembered_pairs = 0, standing_pairs = 0, kept_pairs = 0;
  double remembered_reach = -1.0;

  void note_standing(std::span<const Polyhedron> blocks);
  void carry(const std::vector<BlockPair>& candidates);
  bool both_stand(const BlockPair& pair) const {
    return stands[static_cast<std::size_t>(pair.a)] != 0 &&
           stands[static_cast<std::size_t>(pair.b)] != 0;
  }
  void forget_moved();
  void remember(const std::vector<ContactPoint>& contacts);
  void search(std::span<const Polyhedron> blocks, std::size_t first, std::size_t last,
              std::vector<ContactPoint>& contacts);
  void search_in_parallel(std::span<const Polyhedron> blocks, std::vector<ContactPoint>& contacts);
  void join_parts(std::vector<ContactPoint>& contacts);
};

/// Vertices are compared only where the box is that of the last call: a block that moves costs
/// nothing more.
void ContactFinder::Memory::note_standing(std::span<const Polyhedron> blocks) {
  if (boxes.size() != blocks.size()) {
    boxes.assign(blocks.size(), Box{});
    standing.assign(blocks.size(), Standing{});
    stands.resize(blocks.size());
  }
  standing_blocks = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const bool same = same_box(boxes[i], blocks[i].box());
    stands[i] = same && standing[i].is(blocks[i]) ? 1 : 0;
    standing_blocks += stands[i] != 0;
    if (same && stands[i] == 0) {
      standing[i] = {blocks[i].shared_topology(), blocks[i].vertices()};
    }
    boxes[i] = blocks[i].box();
  }
}

/// Forgets what was found for pairs that have moved since, or with another reach.
void ContactFinder::Memory::forget_moved() {
  standing_pairs = kept_pairs = 0;
  if (standing_blocks < 2 && remembered_pairs == 0) {
    return;
  }
  const bool same_reach = remembered_reach == options.reach;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const bool stand = both_stand(pairs[i]);
    if (!stand || !same_reach) {
      known[i].count = -1;
    }
    standing_pairs += stand;
    kept_pairs += known[i].count >= 0;
  }
}

/// Keeps the contact points of all pairs that stand, sorted by key as they are in `contacts`.
void ContactFinder::Memory::remember(const std::vector<ContactPoint>& contacts) {
  if (standing_pairs == kept_pairs && kept_pairs == remembered_pairs) {
    return;  // all of them are there already
  }
  next_remembered.clear();
  auto contact = contacts.begin();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto first = contact;
    while (contact != contacts.end() && contact->key.a == pairs[i].a &&
           contact->key.b == pairs[i].b) {
      ++contact;
    }
    if (!both_stand(pairs[i])) {
      continue;
    }
    known[i].first = std::ssize(next_remembered);
    known[i].count = contact - first;
    next_remembered.insert(next_remembered.end(), first, contact);
  }
  std::swap(remembered, next_remembered);
  remembered_pairs = standing_pairs;
  remembered_reach = options.reach;
}

/// Each pair of the last call keeps what it knows; a new one starts cold.
void ContactFinder::Memory::carry(const std::vector<BlockPair>& candidates) {
  if (candidates == pairs) {
    return;
  }
  carried.resize(candidates.size());
  std::size_t old = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    while (old < pairs.size() && pairs[old] < candidates[i]) {
      ++old;
    }
    const bool is_known = old < pairs.size() && pairs[old] == candidates[i];
    carried[i] = is_known ? known[old] : PairMemory{};
  }
  std::swap(known, carried);
  pairs = candidates;
}

/// Appends the contact points of pairs first … last - 1, sorted by key.
void ContactFinder::Memory::search(std::span<const Polyhedron> blocks, std::size_t first,
                                   std::size_t last, std::vector<ContactPoint>& contacts) {
  const ContactOptions contact_options{.tolerance = options.tolerance, .reach = options.reach};
  for (std::size_t i = first; i < last; ++i) {
    if (known[i].count >= 0) {
      const auto point = remembered.begin() + known[i].first;
      contacts.insert(contacts.end(), point, point + known[i].count);
      continue;
    }
    const auto [a, b] = pairs[i];
    known[i].hint = append_contacts_within_reach({a, b}, blocks[static_cast<std::size_t>(a)],
                                                 blocks[static_cast<std::size_t>(b)],
                                                 contact_options, known[i].hint, contacts)
                        .hint;
  }
}

/// Each worker takes a run of neighbouring pairs and writes its part of the list where it stood in
/// the call before: as a rule no point is written twice.
void ContactFinder::Memory::search_in_parallel(std::span<const Polyhedron> blocks,
                                               std::vector<ContactPoint>& contacts) {
  const auto count = static_cast<std::size_t>(workers.count());
  std::size_t expected = 0;
  for (WorkerPart& part : parts) {
    part.room = part.total();
    part.start = expected;
    expected += part.room;
  }
  contacts.resize(expected);
  auto find_part = [&](int worker) {
    const auto w = static_cast<std::size_t>(worker);
    WorkerPart& part = parts[w];
    part.count = 0;
    part.beyond.clear();
    const std::size_t last = pairs.size() * (w + 1) / count;
    for (std::size_t first = pairs.size() * w / count; first < last; first += kPairsInCache) {
      search(blocks, first, std::min(first + kPairsInCache, last), part.fresh);
      part.put(contacts);
    }
  };
  workers.run(find_part);
  join_parts(contacts);
}

/// Where a part has become longer or shorter, those behind it move: to the right from the last to
/// the first, to the left from the first to the last, so that none is written over.
void ContactFinder::Memory::join_parts(std::vector<ContactPoint>& contacts) {
  const auto at = [&](std::size_t i) { return contacts.begin() + static_cast<std::ptrdiff_t>(i); };
  std::size_t total = 0;
  for (const WorkerPart& part : parts) total += part.total();
  contacts.resize(std::max(total, contacts.size()));
  std::size_t place = total;
  for (std::size_t w = parts.size(); w-- > 0;) {
    WorkerPart& part = parts[w];
    place -= part.total();
    if (place <= part.start) continue;
    std::move_backward(at(part.start), at(part.start + part.count), at(place + part.count));
    part.start = place;
  }
  for (WorkerPart& part : parts) {
    if (place < part.start) std::move(at(part.start), at(part.start + part.count), at(place));
    part.start = place;
    place += part.total();
  }
  for (const WorkerPart& part : parts) {
    std::copy(part.beyond.begin(), part.beyond.end(), at(part.start + part.count));
  }
  contacts.resize(total);
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

FindCounts ContactFinder::find(std::span<const Polyhedron> blocks, std::span<const char> idle,
                               std::vector<ContactPoint>& contacts) {
  Memory& m = *memory_;
  m.note_standing(blocks);
  double reach = std::max(m.options.reach, m.options.tolerance);
  if (m.options.tolerance == 0.0) {
    for (const Polyhedron& block : blocks) {
      reach = std::max(reach, default_tolerance(block, block));
    }
  }
  m.carry(m.broad_phase.find_candidates(m.boxes, reach, idle));
  m.forget_moved();
  const auto workers = static_cast<std::size_t>(m.workers.count());
  if (workers > 1 && m.pairs.size() >= workers * kPairsPerWorker) {
    m.search_in_parallel(blocks, contacts);
  } else {
    contacts.clear();
    m.search(blocks, 0, m.pairs.size(), contacts);
  }
  m.remember(contacts);
  return {static_cast<int>(m.pairs.size()), static_cast<int>(m.pairs.size() - m.kept_pairs)};
}

}  // namespace quoin::geometry
