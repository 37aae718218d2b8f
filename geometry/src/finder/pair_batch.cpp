#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <quoin/geometry/pair_batch.hpp>

#include "contact/contact_tracking.hpp"
#include "finder/pair_checks.hpp"
#include "finder/placed_box.hpp"
#include "finder/point_history.hpp"
#include "numeric/numbers.hpp"
#include "search/still_apart.hpp"

namespace quoin::geometry {
namespace {

constexpr std::size_t kPairsPerWorker = 64;  // fewer are not worth waking a thread for
constexpr std::size_t kFewStrangers = 1024;  // pairs that only contacts_of() knows, at least kept
constexpr std::size_t kPairsInCache = 128;   // their points are copied while still in cache
/// Pairs come in the order of a, and bodies near each other have numbers not far apart as a rule:
/// so many are kept made, 240 bytes each. A power of two.
constexpr std::size_t kBodiesKept = 512;

/// What is read of every pair in every call.
struct PairState {
  // Of the bodies' ways summed: the pair is out of reach so long; 0: not known; negative: it had
  // points when contacts_of() searched it.
  double apart_until = 0.0;
  int listed = -1;  // among the results of the last call, -1: not in contact
  int kept = -1;    // where its contact points begin in `remembered`, -1: not remembered
};

/// Behind those of all pairs.
constexpr BlockPair kLastNames{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};

constexpr double kInContact = -1.0;  // PairState::apart_until

/// What else a pair keeps from call to call.
struct PairMemory {
  FeatureHint hint{};
  HistorySlot slot{};  // its contact points of the last call, if it had any
};

/// A pair that contacts_of() alone has been asked for since the last find().
struct Stranger {
  BlockPair names;
  PairState state{};
  PairMemory memory{};
};

/// Empties a list that will be as long as before or nearly: what it holds far beyond that is given
/// back.
template <class T>
void start_list(std::vector<T>& list, std::size_t expected) {
  constexpr std::size_t kFew = 64;
  list.clear();
  if (list.capacity() <= expected + expected / 4 + kFew) return;
  std::vector<T>().swap(list);
  list.reserve(expected + expected / 32);
}

Body body_in_row(const void* owner, int index) { return static_cast<const Body*>(owner)[index]; }

/// As many items as said, and not much more room.
template <class T>
void resize_list(std::vector<T>& list, std::size_t size) {
  constexpr std::size_t kFew = 64;
  if (size > list.capacity()) list.reserve(size + list.size() / 32);
  list.resize(size);
  if (list.capacity() > size + size / 4 + kFew) list.shrink_to_fit();
}

/// Empties a list that is short as a rule; room for what the last call needed is kept.
template <class T>
void start_short_list(std::vector<T>& list, std::size_t most) {
  most = std::max(most, 4 * list.size());
  list.clear();
  if (list.capacity() > most) std::vector<T>().swap(list);
}

/// Bodies lately asked for, so that one in many pairs is made once.
class RecentBodies {
 public:
  void start(const BodySource& source) {
    source_ = &source;
    row_ = source.body == body_in_row ? static_cast<const Body*>(source.owner) : nullptr;
    if (row_ != nullptr) return;
    const std::size_t size = std::min(kBodiesKept, std::bit_ceil(at(std::max(source.count, 1))));
    indices_.assign(size + 1, -1);
    bodies_.resize(size + 1);
  }
  /// Until the next call of first().
  const Body& first(int index) {
    return row_ != nullptr ? row_[index] : in_place(home(index), index);
  }
  /// Until the next call of either; leaves the first one, `other`, as it is.
  const Body& second(int index, int other) {
    if (row_ != nullptr) return row_[index];
    const std::size_t place = home(index);
    return in_place(place == home(other) ? bodies_.size() - 1 : place, index);
  }

 private:
  std::size_t home(int index) const { return at(index) & (bodies_.size() - 2); }
  const Body& in_place(std::size_t place, int index) {
    if (indices_[place] != index) {
      bodies_[place].emplace(source_->body(source_->owner, index));
      indices_[place] = index;
    }
    return *bodies_[place];
  }

  const BodySource* source_ = nullptr;
  const Body* row_ = nullptr;                  // null: they are made
  std::vector<int> indices_{};                 // -1: none
  std::vector<std::optional<Body>> bodies_{};  // the last one: for a home that is taken
};

/// A pair in contact that was not so in the last call.
struct BegunPair {
  std::size_t pair = 0;
  PairResult result{};
};

/// A pair whose points need another slot.
struct OutgrownPair {
  std::size_t pair = 0, count = 0;
};

/// What one worker finds: points in the list at `start`, as many as it found there in the call
/// before (`room`), and those beyond; and what it keeps for the next call.
struct WorkerPart {
  std::size_t start = 0, room = 0, count = 0;
  std::vector<ContactPoint> fresh{}, beyond{};
  std::size_t first_point = 0;           // place in the list of all of what is found next
  std::ptrdiff_t shift = 0;              // by how much the part has been moved in the end
  std::size_t lasting = 0;               // pairs in contact that were so in the last call, too
  std::vector<BegunPair> begun{};        // pairs that were not
  std::vector<TrackedPoint> now{};       // contact points of the pair at hand
  std::vector<OutgrownPair> outgrown{};  // pairs with more points than their slot has room for
  std::vector<TrackedPoint> overflow{};  // the points of these
  PairTracking tracking{};
  std::vector<int> previous{};
  RecentBodies bodies{};

  std::size_t total() const { return count + beyond.size(); }
  /// `few`: as many pairs as may begin in each call.
  void begin(const BodySource& source, std::size_t few) {
    start_short_list(begun, few);
    start_short_list(outgrown, few);
    start_short_list(overflow, 4 * few);
    lasting = first_point = 0;
    shift = 0;
    bodies.start(source);
  }
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

void describe(const NearestFeatures& answer, std::span<const ContactPoint> points,
              PairResult& result) {
  result.status = answer.status;
  result.gap = answer.gap;
  result.normal = answer.normal;
  result.indeterminate = answer.indeterminate;
  result.count = static_cast<int>(points.size());
  if (!points.empty()) result.type = points.front().type;
  for (const ContactPoint& point : points) result.area += point.area;
}

BlockPair names_of(const PairResult& result) { return {result.a, result.b}; }

bool same_pairs(std::span<const BlockPair> x, std::span<const BlockPair> y) {
  static_assert(sizeof(BlockPair) == 2 * sizeof(int));
  return x.size() == y.size() &&
         (x.empty() || std::memcmp(x.data(), y.data(), x.size_bytes()) == 0);
}

void check_sizes(const BodySource& bodies) {
  if (bodies.count > 0 && bodies.body == nullptr) {
    throw InputError("pair batch: there is no function that gives the " +
                     std::to_string(bodies.count) + " bodies");
  }
  const auto fits = [&](std::size_t size, const char* what) {
    if (size != 0 && size != static_cast<std::size_t>(bodies.count)) {
      throw InputError("pair batch: " + std::to_string(size) + " " + what + " for " +
                       std::to_string(bodies.count) + " bodies");
    }
  };
  fits(bodies.names.size(), "names");
  fits(bodies.changes.size(), "changes");
  fits(bodies.ways.size(), "ways");
  fits(bodies.reaches.size(), "reaches");
}

void check(const BodySource& bodies) {
  check_sizes(bodies);
  for (const double reach : bodies.reaches) require_length(reach, "pair batch: reach of a body");
  check_names(bodies.names);
}

}  // namespace

void check_names(std::span<const int> names) {
  for (std::size_t i = 1; i < names.size(); ++i) {
    if (names[i] > names[i - 1]) continue;
    throw InputError("pair batch: body " + std::to_string(i) + " is named " +
                     std::to_string(names[i]) + ", must be more than " +
                     std::to_string(names[i - 1]));
  }
}

void refuse_pair(std::size_t i, const BlockPair& pair, int count) {
  throw InputError("pair " + std::to_string(i) + " is (" + std::to_string(pair.a) + ", " +
                   std::to_string(pair.b) + "), must name two of " + std::to_string(count) +
                   " bodies");
}

void check_pairs(std::span<const BlockPair> pairs, int count) {
  for (std::size_t i = 0; i < pairs.size(); ++i) check_pair(i, pairs[i], count);
}

BodySource::BodySource(std::span<const Body> bodies)
    : owner(bodies.data()), body(body_in_row), count(static_cast<int>(bodies.size())) {}

struct PairBatch::Memory {
  ContactOptions options;
  BodySource bodies;                 // of the call at hand
  std::vector<BlockPair> sorted;     // the caller's pairs, where they are in no order
  std::span<const BlockPair> pairs;  // of the call at hand, by index
  std::vector<BlockPair> renamed;    // the same by name, where names are not the indices
  std::vector<BlockPair> named;      // of the last find(), by name
  bool by_the_way = false;           // the call at hand is contacts_of()
  std::vector<std::size_t> places;   // of its pairs in `named`; behind these, in `strangers`
  std::vector<Stranger> strangers, next_strangers;  // ascending by names
  std::vector<PairState> states, next_states;       // one a pair
  std::vector<PairMemory> known, next_known;        // one a pair
  std::vector<PairResult> listed;                   // in contact, or no longer
  std::size_t live = 0;                             // in contact, of `listed`
  PointHistory history;                             // points of the last call
  std::vector<WorkerPart> parts{1};                 // one a worker

  // Contact points of the pairs of which neither body moved, and the reach they were found with.
  std::vector<ContactPoint> remembered, next_remembered;
  std::size_t remembered_pairs = 0, standing_pairs = 0, kept_pairs = 0;
  double remembered_reach = -1.0;

  void take_pairs(std::span<const BlockPair> given);
  void check_row() const;
  void carry();
  void find_places();
  void admit(std::span<const BlockPair> asked);
  void forget_changed();
  void remember(const std::vector<ContactPoint>& contacts);
  void drop_ended();
  void pack_history();
  void start_parts(std::size_t workers);
  void search(std::size_t first, std::size_t last, std::size_t worker,
              std::vector<ContactPoint>& contacts);
  double tolerance_of(const Body& a, const Body& b) const {
    return options.tolerance > 0.0 ? options.tolerance : default_tolerance(a, b);
  }
  bool stay_apart(std::size_t i, const Body& a, const Body& b);
  void search_pair(std::size_t i, WorkerPart& part, const Body& a,
                   std::vector<ContactPoint>& contacts, PairResult& result);
  void repeat(std::size_t i, std::vector<ContactPoint>& contacts, PairResult& result);
  void list(std::size_t i, WorkerPart& part, PairResult& result);
  void follow(std::size_t i, WorkerPart& part, const Body& a, std::span<ContactPoint> points);
  void match(std::size_t i, WorkerPart& part, const Body& a, std::span<const TrackedPoint> was,
             std::span<ContactPoint> points);
  void keep_points(std::size_t i, WorkerPart& part);
  void settle_history(std::size_t workers);
  void search_in_parallel(Executor& executor, std::size_t workers,
                          std::vector<ContactPoint>& contacts);
  void join_parts(std::size_t workers, std::vector<ContactPoint>& contacts);
  std::size_t first_pair(std::size_t worker, std::size_t workers) const {
    return pairs.size() * worker / workers;
  }
  void list_results(std::size_t workers);
  void shift_results(std::size_t worker, std::size_t workers);
  void merge_results(std::size_t workers, std::size_t begun);
  std::size_t workers_for(const Executor* executor) const;
  void search_all(std::vector<ContactPoint>& contacts, Executor* executor, std::size_t workers);
  void find(std::vector<ContactPoint>& contacts, Executor* executor);
  void contacts_of(std::vector<ContactPoint>& contacts, Executor* executor);
  void forget();

  /// Of a pair of the call at hand.
  bool is_stranger(std::size_t i) const { return by_the_way && places[i] >= named.size(); }
  std::size_t place(std::size_t i) const { return by_the_way ? places[i] : i; }
  PairState& state_of(std::size_t i) {
    return is_stranger(i) ? strangers[places[i] - named.size()].state : states[place(i)];
  }
  PairMemory& memory_of(std::size_t i) {
    return is_stranger(i) ? strangers[places[i] - named.size()].memory : known[place(i)];
  }
  BlockPair names_of_pair(std::size_t i) const {
    return is_stranger(i) ? strangers[places[i] - named.size()].names : named[place(i)];
  }
  static bool in_contact(const PairState& state) {
    return state.listed >= 0 || state.apart_until < 0.0;
  }

  int name(int body) const {
    return bodies.names.empty() ? body : bodies.names[static_cast<std::size_t>(body)];
  }
  BodyChange change(int body) const {
    return bodies.changes.empty() ? BodyChange::Moved
                                  : bodies.changes[static_cast<std::size_t>(body)];
  }
  Body body(int index) const { return bodies.body(bodies.owner, index); }
  PairResult& listed_of(const PairState& pair) {
    return listed[static_cast<std::size_t>(pair.listed)];
  }
  /// Of a pair's points.
  int count_of(const PairState& pair) { return pair.listed < 0 ? 0 : listed_of(pair).count; }
  /// How far the two have come. Where nobody tells, nothing is known to last.
  double ways_of(const BlockPair& pair) const {
    if (bodies.ways.empty()) return std::numeric_limits<double>::infinity();
    return bodies.ways[static_cast<std::size_t>(pair.a)] +
           bodies.ways[static_cast<std::size_t>(pair.b)];
  }
  double reach_of(const BlockPair& pair) const {
    if (bodies.reaches.empty()) return options.reach;
    return std::max({options.reach, bodies.reaches[static_cast<std::size_t>(pair.a)],
                     bodies.reaches[static_cast<std::size_t>(pair.b)]});
  }
  ContactOptions options_of(const BlockPair& pair) const {
    ContactOptions own = options;
    own.reach = reach_of(pair);
    return own;
  }
  bool both_stand(const BlockPair& pair) const {
    return change(pair.a) == BodyChange::None && change(pair.b) == BodyChange::None;
  }
  bool reshaped(const BlockPair& pair) const {
    return change(pair.a) == BodyChange::Shape || change(pair.b) == BodyChange::Shape;
  }
};

/// Pairs ascending, each once, a < b, as indices and by name.
void PairBatch::Memory::take_pairs(std::span<const BlockPair> given) {
  const auto count = static_cast<unsigned>(bodies.count);
  bool ordered = true;
  std::uint64_t last = 0;  // less than any pair
  for (const BlockPair& pair : given) {
    const auto a = static_cast<unsigned>(pair.a), b = static_cast<unsigned>(pair.b);
    const std::uint64_t place = static_cast<std::uint64_t>(a) << 32 | b;
    ordered = ordered & (a < b) & (b < count) & (last < place);
    last = place;
  }
  if (!ordered) check_pairs(given, bodies.count);
  pairs = given;
  if (!ordered) {
    sorted.assign(given.begin(), given.end());
    for (BlockPair& pair : sorted) pair = {std::min(pair.a, pair.b), std::max(pair.a, pair.b)};
    std::sort(sorted.begin(), sorted.end());
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    pairs = sorted;
  }
  renamed.clear();
  if (bodies.names.empty()) return;
  for (const BlockPair& pair : pairs) renamed.push_back({name(pair.a), name(pair.b)});
}

/// Whoever makes bodies of his own has checked them.
void PairBatch::Memory::check_row() const {
  if (bodies.body != body_in_row) return;
  check_placements(pairs, static_cast<const Body*>(bodies.owner), [&](int i) { return name(i); });
}

/// Each pair of the last call keeps what it knows; a new one starts cold.
void PairBatch::Memory::carry() {
  const std::span<const BlockPair> now = bodies.names.empty() ? pairs : renamed;
  if (same_pairs(now, named)) return strangers.clear();
  next_states.resize(now.size());
  next_known.resize(now.size());
  std::size_t old = 0;
  auto stranger = strangers.begin();
  const auto leave_until = [&](const BlockPair& names) {
    for (; old < named.size() && named[old] < names; ++old) history.give_back(known[old].slot);
  };
  for (std::size_t i = 0; i < now.size(); ++i) {
    leave_until(now[i]);
    const bool is_known = old < named.size() && named[old] == now[i];
    next_states[i] = is_known ? states[old] : PairState{};
    next_known[i] = is_known ? known[old] : PairMemory{};
    old += is_known;
    while (stranger != strangers.end() && stranger->names < now[i]) ++stranger;
    if (is_known || stranger == strangers.end() || stranger->names != now[i]) continue;
    next_states[i] = stranger->state;
    next_known[i] = stranger->memory;
  }
  leave_until(kLastNames);
  strangers.clear();
  std::swap(states, next_states);
  std::swap(known, next_known);
  named.assign(now.begin(), now.end());
}

/// Of the pairs of contacts_of(), all of which are known afterwards.
void PairBatch::Memory::find_places() {
  const std::span<const BlockPair> now = bodies.names.empty() ? pairs : renamed;
  places.assign(now.size(), named.size());
  auto from = named.begin();
  for (std::size_t i = 0; i < now.size(); ++i) {
    from = std::lower_bound(from, named.end(), now[i]);
    if (from != named.end() && *from == now[i])
      places[i] = static_cast<std::size_t>(from - named.begin());
  }
  admit(now);
  std::size_t stranger = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (places[i] < named.size()) continue;
    while (strangers[stranger].names != now[i]) ++stranger;
    places[i] = named.size() + stranger;
  }
}

/// Pairs that find() was not asked for come in. Where they have become many, those go that are not
/// asked for.
void PairBatch::Memory::admit(std::span<const BlockPair> asked) {
  const bool crowded = strangers.size() > kFewStrangers;
  next_strangers.clear();
  auto old = strangers.begin();
  const auto keep_until = [&](const BlockPair& names) {
    for (; old != strangers.end() && old->names < names; ++old) {
      if (!crowded) next_strangers.push_back(*old);
    }
  };
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (places[i] < named.size()) continue;
    keep_until(asked[i]);
    const bool is_known = old != strangers.end() && old->names == asked[i];
    next_strangers.push_back(is_known ? *old++ : Stranger{.names = asked[i]});
  }
  keep_until(kLastNames);
  std::swap(strangers, next_strangers);
}

/// Forgets what was found for pairs that have changed since, or with another reach.
void PairBatch::Memory::forget_changed() {
  standing_pairs = kept_pairs = 0;
  const auto still = std::ranges::count(bodies.changes, BodyChange::None);
  const auto other_shapes = std::ranges::count(bodies.changes, BodyChange::Shape);
  if (still < 2 && other_shapes == 0 && remembered_pairs == 0) {
    return;
  }
  const bool same_reach = remembered_reach == options.reach;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const bool stand = both_stand(pairs[i]);
    if (!stand || !same_reach) {
      states[i].kept = -1;
    }
    if (reshaped(pairs[i])) {
      known[i].hint = {};
      states[i].apart_until = 0.0;
    }
    standing_pairs += stand;
    kept_pairs += states[i].kept >= 0;
  }
}

/// Keeps the contact points of all pairs that stand, sorted by key as they are in `contacts`.
void PairBatch::Memory::remember(const std::vector<ContactPoint>& contacts) {
  if (standing_pairs == kept_pairs && kept_pairs == remembered_pairs) {
    return;  // all of them are there already
  }
  std::size_t total = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (both_stand(pairs[i])) total += static_cast<std::size_t>(count_of(states[i]));
  }
  next_remembered.clear();
  next_remembered.reserve(total);
  auto contact = contacts.begin();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto first = contact;
    contact += count_of(states[i]);
    if (!both_stand(pairs[i])) {
      continue;
    }
    states[i].kept = static_cast<int>(next_remembered.size());
    next_remembered.insert(next_remembered.end(), first, contact);
  }
  std::swap(remembered, next_remembered);
  remembered_pairs = standing_pairs;
  remembered_reach = options.reach;
}

void PairBatch::Memory::start_parts(std::size_t workers) {
  if (parts.size() < workers) parts.resize(workers);
  const std::size_t few = pairs.size() / 8 + kPairsInCache;
  for (WorkerPart& part : parts) part.begin(bodies, few);
}

/// Those that the last call listed for the last time.
void PairBatch::Memory::drop_ended() {
  if (listed.size() == live) return;
  int next = 0;
  for (PairState& pair : states) {
    if (pair.listed < 0) continue;
    listed[static_cast<std::size_t>(next)] = listed_of(pair);
    pair.listed = next++;
  }
  listed.resize(live);
}

/// Once pairs have come and gone, and left too much behind.
void PairBatch::Memory::pack_history() {
  if (!history.is_wasteful()) return;
  PointHistory packed;
  packed.make_room(history.used());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto count = static_cast<std::size_t>(count_of(states[i]));
    const auto points = history.points(known[i].slot, count);
    known[i].slot = count == 0 ? HistorySlot{} : packed.take(count);
    std::ranges::copy(points, packed.points(known[i].slot, count).begin());
  }
  std::swap(history, packed);
}

/// The points of one pair among those that it had: by their features, and where these have changed
/// by their places as seen from body a: within the tolerance rounding may give a corner another
/// name.
void PairBatch::Memory::match(std::size_t i, WorkerPart& part, const Body& a,
                              std::span<const TrackedPoint> was, std::span<ContactPoint> points) {
  part.previous.resize(points.size());
  const double reach =
      std::max(reach_of(pairs[i]), tolerance_of(a, part.bodies.second(pairs[i].b, pairs[i].a)));
  part.tracking.match(part.now, was, reach, part.previous);
  const int first = listed_of(states[i]).first;
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k].previous = part.previous[k] < 0 ? -1 : first + part.previous[k];
  }
}

/// Finds the points' predecessors, and keeps the points for the next call.
void PairBatch::Memory::follow(std::size_t i, WorkerPart& part, const Body& a,
                               std::span<ContactPoint> points) {
  const bool in_world = options.frame == PointFrame::World;
  const Placement own;
  const Placement& frame = in_world ? a.placement() : own;
  const auto seen = [&](const ContactPoint& point) {
    return tracked(point.key, in_world ? point.point() : point.point_a, frame);
  };
  const bool has_history = states[i].listed >= 0 && !reshaped(pairs[i]);
  const auto was = history.points(known[i].slot,
                                  has_history ? static_cast<std::size_t>(count_of(states[i])) : 0);
  const auto same_features = [](const ContactPoint& x, const TrackedPoint& y) {
    return PackedFeature(x.key.feature_a) == y.feature_a &&
           PackedFeature(x.key.feature_b) == y.feature_b;
  };
  if (std::equal(points.begin(), points.end(), was.begin(), was.end(), same_features)) {
    int previous = listed_of(states[i]).first;
    for (std::size_t k = 0; k < points.size(); ++k) {
      points[k].previous = previous++;
      was[k] = seen(points[k]);
    }
    return;
  }
  part.now.clear();
  for (ContactPoint& point : points) {
    point.previous = -1;
    part.now.push_back(seen(point));
  }
  if (has_history) match(i, part, a, was, points);
  keep_points(i, part);
}

/// In the pair's own slot, or aside until it gets another one.
void PairBatch::Memory::keep_points(std::size_t i, WorkerPart& part) {
  const HistorySlot& slot = known[i].slot;
  const std::size_t count = part.now.size();
  if (count <= static_cast<std::size_t>(slot.room)) {
    std::ranges::copy(part.now, history.points(slot, count).begin());
  } else {
    part.outgrown.push_back({i, count});
    part.overflow.insert(part.overflow.end(), part.now.begin(), part.now.end());
  }
}

/// Other slots for those pairs that need them.
void PairBatch::Memory::settle_history(std::size_t workers) {
  std::size_t more = 0;
  for (std::size_t w = 0; w < workers; ++w) {
    for (const OutgrownPair& pair : parts[w].outgrown) more += pair.count + pair.count % 2;
  }
  if (more > 0) history.make_room(more);
  for (std::size_t w = 0; w < workers; ++w) {
    auto point = parts[w].overflow.begin();
    for (const auto& [pair, count] : parts[w].outgrown) {
      HistorySlot& slot = known[pair].slot;
      history.give_back(slot);
      slot = history.take(count);
      std::copy_n(point, count, history.points(slot, count).begin());
      point += static_cast<std::ptrdiff_t>(count);
    }
  }
}

/// Does last step's plane still part two bodies that were not in contact? They have no points then,
/// nor will they before their ways have used up what they are apart beyond the reach.
bool PairBatch::Memory::stay_apart(std::size_t i, const Body& a, const Body& b) {
  PairState& state = state_of(i);
  const FeatureHint& hint = memory_of(i).hint;
  if (in_contact(state) || hint.vertices_a[0] < 0) return false;
  const double near = std::max(reach_of(pairs[i]), tolerance_of(a, b));
  const double beyond = apart_beyond(a, b, hint.normal, near);
  if (!(beyond > 0.0)) return false;
  if (!bodies.ways.empty()) {
    state.apart_until = (ways_of(pairs[i]) + beyond) * (1.0 - 4 * kEpsilon);
  }
  return true;
}

void PairBatch::Memory::search_pair(std::size_t i, WorkerPart& part, const Body& a,
                                    std::vector<ContactPoint>& contacts, PairResult& result) {
  const Body& b = part.bodies.second(pairs[i].b, pairs[i].a);
  if (stay_apart(i, a, b)) return;
  const std::size_t first = contacts.size();
  FeatureHint& hint = memory_of(i).hint;
  const BlockPair names = names_of_pair(i);
  const NearestFeatures nearest =
      append_contacts_within_reach({names.a, names.b}, a, b, options_of(pairs[i]), hint, contacts);
  hint = nearest.hint;
  describe(nearest, std::span(contacts).subspan(first), result);
}

/// The answer of a pair of which neither body has moved.
void PairBatch::Memory::repeat(std::size_t i, std::vector<ContactPoint>& contacts,
                               PairResult& result) {
  if (states[i].listed < 0) return;
  result = listed_of(states[i]);
  const auto point = remembered.begin() + states[i].kept;
  contacts.insert(contacts.end(), point, point + result.count);
}

/// A pair in contact: in its place among the results, if it has one.
void PairBatch::Memory::list(std::size_t i, WorkerPart& part, PairResult& result) {
  result.a = named[i].a;
  result.b = named[i].b;
  if (states[i].listed >= 0) {
    result.event = PairEvent::Persist;
    listed_of(states[i]) = result;
    ++part.lasting;
  } else {
    result.event = PairEvent::Begin;
    part.begun.push_back({i, result});
  }
}

/// Appends the contact points of pairs first … last - 1, sorted by key.
void PairBatch::Memory::search(std::size_t first, std::size_t last, std::size_t worker,
                               std::vector<ContactPoint>& contacts) {
  WorkerPart& part = parts[worker];
  for (std::size_t i = first; i < last; ++i) {
    PairState& state = state_of(i);
    if (state.apart_until > ways_of(pairs[i])) continue;
    const std::size_t start = contacts.size();
    const Body& a = part.bodies.first(pairs[i].a);
    PairResult result;
    if (!by_the_way && state.kept >= 0) {
      repeat(i, contacts, result);
    } else {
      search_pair(i, part, a, contacts, result);
    }
    const bool has_points = contacts.size() > start;
    if (by_the_way) {
      state.apart_until = has_points ? kInContact : std::max(state.apart_until, 0.0);
    } else if (has_points) {
      follow(i, part, a, std::span(contacts).subspan(start));
      result.first = static_cast<int>(part.first_point + start);
      list(i, part, result);
    } else {
      state.listed = -1;
      state.apart_until = std::max(state.apart_until, 0.0);
    }
  }
}

/// Each worker takes a run of neighbouring pairs and writes its part of the list where it stood in
/// the call before: as a rule no point is written twice.
void PairBatch::Memory::search_in_parallel(Executor& executor, std::size_t workers,
                                           std::vector<ContactPoint>& contacts) {
  std::size_t expected = 0;
  for (std::size_t w = 0; w < workers; ++w) {
    parts[w].room = parts[w].total();
    parts[w].start = expected;
    expected += parts[w].room;
  }
  contacts.resize(expected);
  auto find_part = [&](int worker) {
    const auto w = static_cast<std::size_t>(worker);
    WorkerPart& part = parts[w];
    part.count = 0;
    start_list(part.beyond, part.room / 8);
    part.fresh.clear();
    const std::size_t last = first_pair(w + 1, workers);
    for (std::size_t first = first_pair(w, workers); first < last; first += kPairsInCache) {
      part.first_point = part.start + part.total();
      search(first, std::min(first + kPairsInCache, last), w, part.fresh);
      part.put(contacts);
    }
  };
  executor.run_each(find_part);
  join_parts(workers, contacts);
}

/// Where a part has become longer or shorter, those behind it move: to the right from the last to
/// the first, to the left from the first to the last, so that none is written over.
void PairBatch::Memory::join_parts(std::size_t workers, std::vector<ContactPoint>& contacts) {
  const auto at = [&](std::size_t i) { return contacts.begin() + static_cast<std::ptrdiff_t>(i); };
  std::size_t total = 0;
  for (std::size_t w = 0; w < workers; ++w) total += parts[w].total();
  contacts.resize(std::max(total, contacts.size()));
  std::size_t place = total;
  for (std::size_t w = workers; w-- > 0;) {
    WorkerPart& part = parts[w];
    place -= part.total();
    if (place <= part.start) continue;
    std::move_backward(at(part.start), at(part.start + part.count), at(place + part.count));
    part.shift = static_cast<std::ptrdiff_t>(place - part.start);
    part.start = place;
  }
  for (std::size_t w = 0; w < workers; ++w) {
    WorkerPart& part = parts[w];
    if (place < part.start) {
      std::move(at(part.start), at(part.start + part.count), at(place));
      part.shift = -static_cast<std::ptrdiff_t>(part.start - place);
    }
    part.start = place;
    place += part.total();
  }
  for (std::size_t w = 0; w < workers; ++w) {
    const WorkerPart& part = parts[w];
    std::copy(part.beyond.begin(), part.beyond.end(), at(part.start + part.count));
  }
  contacts.resize(total);
}

/// Those with points, and those of the last call that have none any more. As a rule none has begun
/// or ended, and each stands in its place already.
void PairBatch::Memory::list_results(std::size_t workers) {
  std::size_t lasting = 0, begun = 0;
  for (std::size_t w = 0; w < workers; ++w) {
    lasting += parts[w].lasting;
    begun += parts[w].begun.size();
    if (parts[w].shift != 0) shift_results(w, workers);
  }
  const std::size_t ended = live - lasting;
  live = lasting + begun;
  if (begun + ended > 0) merge_results(workers, begun);
}

/// The points of a part stand elsewhere than they were thought to.
void PairBatch::Memory::shift_results(std::size_t worker, std::size_t workers) {
  WorkerPart& part = parts[worker];
  const auto shift = static_cast<int>(part.shift);
  for (std::size_t i = first_pair(worker, workers); i < first_pair(worker + 1, workers); ++i) {
    if (states[i].listed >= 0) listed_of(states[i]).first += shift;
  }
  for (BegunPair& pair : part.begun) pair.result.first += shift;
}

/// Pairs that begin get a place among the others, which make room from the last to the first. Those
/// of them that no pair of this call calls its own have ended.
void PairBatch::Memory::merge_results(std::size_t workers, std::size_t begun) {
  std::size_t old = listed.size(), place = old + begun, pair = named.size();
  resize_list(listed, place);
  const auto move_those_behind = [&](const BlockPair& names) {
    for (; old > 0 && names < names_of(listed[old - 1]); --old) {
      PairResult& result = listed[--place];
      if (place != old - 1) result = listed[old - 1];
      while (pair > 0 && names_of(result) < named[pair - 1]) --pair;
      if (pair > 0 && named[pair - 1] == names_of(result) && states[pair - 1].listed >= 0) {
        states[pair - 1].listed = static_cast<int>(place);
      } else {
        result.event = PairEvent::End;
        result.first = result.count = 0;
      }
    }
  };
  for (std::size_t w = workers; w-- > 0;) {
    for (std::size_t k = parts[w].begun.size(); k-- > 0;) {
      const BegunPair& next = parts[w].begun[k];
      move_those_behind(names_of(next.result));
      listed[--place] = next.result;
      states[next.pair].listed = static_cast<int>(place);
    }
  }
  constexpr int kLeast = std::numeric_limits<int>::min();
  move_those_behind({kLeast, kLeast});
}

PairBatch::PairBatch(const ContactOptions& options) {
  require_length(options.reach, "pair batch: reach");
  require_length(options.tolerance, "pair batch: tolerance");
  require_length(options.coordinate_rounding, "pair batch: coordinate rounding");
  memory_ = std::make_unique<Memory>();
  memory_->options = options;
}
PairBatch::~PairBatch() = default;
PairBatch::PairBatch(PairBatch&&) noexcept = default;
PairBatch& PairBatch::operator=(PairBatch&&) noexcept = default;

PairBatch::Memory& PairBatch::memory() const {
  if (!memory_) throw InputError("pair batch: it was moved from");
  return *memory_;
}

std::span<const PairResult> PairBatch::pairs() const { return memory().listed; }

void PairBatch::set_reach(double reach) {
  require_length(reach, "pair batch: reach");
  Memory& m = memory();
  if (reach > m.options.reach) {
    for (PairState& pair : m.states) pair.apart_until = std::min(pair.apart_until, 0.0);
    for (Stranger& pair : m.strangers) {
      pair.state.apart_until = std::min(pair.state.apart_until, 0.0);
    }
  }
  m.options.reach = reach;
}

void PairBatch::Memory::search_all(std::vector<ContactPoint>& contacts, Executor* executor,
                                   std::size_t workers) {
  if (workers > 1) return search_in_parallel(*executor, workers, contacts);
  contacts.clear();
  for (std::size_t first = 0; first < pairs.size(); first += kPairsInCache) {
    search(first, std::min(first + kPairsInCache, pairs.size()), 0, contacts);
  }
}

/// That are worth it.
std::size_t PairBatch::Memory::workers_for(const Executor* executor) const {
  const auto workers =
      static_cast<std::size_t>(executor == nullptr ? 1 : std::max(1, executor->workers()));
  return pairs.size() >= workers * kPairsPerWorker ? workers : 1;
}

void PairBatch::Memory::find(std::vector<ContactPoint>& contacts, Executor* executor) {
  by_the_way = false;
  drop_ended();
  carry();
  pack_history();
  forget_changed();
  const std::size_t workers = workers_for(executor);
  start_parts(workers);
  search_all(contacts, executor, workers);
  settle_history(workers);
  list_results(workers);
  remember(contacts);
}

/// A body of another shape has features of other names until find() has seen it.
void PairBatch::Memory::contacts_of(std::vector<ContactPoint>& contacts, Executor* executor) {
  by_the_way = true;
  find_places();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!reshaped(pairs[i])) continue;
    memory_of(i).hint = {};
    state_of(i).apart_until = 0.0;
  }
  const std::size_t workers = workers_for(executor);
  if (parts.size() < workers) parts.resize(workers);
  for (std::size_t w = 0; w < workers; ++w) parts[w].bodies.start(bodies);
  search_all(contacts, executor, workers);
  for (ContactPoint& point : contacts) point.previous = -1;
}

/// After a call that could not be finished.
void PairBatch::Memory::forget() {
  for (std::vector<BlockPair>* list : {&named, &renamed}) list->clear();
  for (std::vector<PairState>* list : {&states, &next_states}) list->clear();
  for (std::vector<PairMemory>* list : {&known, &next_known}) list->clear();
  strangers.clear();
  listed.clear();
  history.clear();
  for (std::vector<ContactPoint>* list : {&remembered, &next_remembered}) list->clear();
  for (WorkerPart& part : parts) part = {};
  live = 0;
  remembered_pairs = 0;
}

FindCounts PairBatch::find(const BodySource& bodies, std::span<const BlockPair> pairs,
                           std::vector<ContactPoint>& contacts, Executor* executor) {
  Memory& m = memory();
  check(bodies);
  m.bodies = bodies;
  m.take_pairs(pairs);
  m.check_row();
  try {
    m.find(contacts, executor);
  } catch (...) {
    m.forget();
    throw;
  }
  return {static_cast<int>(m.pairs.size()), static_cast<int>(m.pairs.size() - m.kept_pairs)};
}

FindCounts PairBatch::contacts_of(const BodySource& bodies, std::span<const BlockPair> pairs,
                                  std::vector<ContactPoint>& contacts, Executor* executor) {
  Memory& m = memory();
  check_sizes(bodies);
  m.bodies = bodies;
  m.take_pairs(pairs);
  m.check_row();
  try {
    m.contacts_of(contacts, executor);
  } catch (...) {
    m.forget();
    throw;
  }
  return {static_cast<int>(m.pairs.size()), static_cast<int>(m.pairs.size())};
}

}  // namespace quoin::geometry
