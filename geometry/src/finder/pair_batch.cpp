#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <quoin/geometry/pair_batch.hpp>

#include "contact/contact_tracking.hpp"
#include "finder/placed_box.hpp"
#include "numeric/numbers.hpp"
#include "search/still_apart.hpp"

namespace quoin::geometry {
namespace {

// Fewer are not worth waking a thread for.
constexpr std::size_t kPairsPerWorker = 64, kDistancesPerWorker = 256;

/// All workers, or one where each would have fewer than `least` of the items.
std::size_t workers_for(const Executor* executor, std::size_t items, std::size_t least) {
  const auto workers =
      static_cast<std::size_t>(executor == nullptr ? 1 : std::max(1, executor->workers()));
  return items >= workers * least ? workers : 1;
}

/// What a pair keeps from call to call, besides its hint.
struct PairState {
  int listed = -1;  // among the results of the last call, -1: not in contact
  int kept = -1;    // where its contact points begin in `remembered`, -1: not remembered
};

/// Behind those of all pairs.
constexpr BlockPair kLastNames{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};

Body body_in_row(const void* owner, int index) { return static_cast<const Body*>(owner)[index]; }

/// The bodies of the pair at hand: pairs come in the order of a, which is made once.
class PairBodies {
 public:
  void start(const BodySource& source) {
    source_ = &source;
    row_ = source.body == body_in_row ? static_cast<const Body*>(source.owner) : nullptr;
    first_ = second_ = {};
  }
  const Body& first(int index) { return take(index, first_); }
  const Body& second(int index) { return take(index, second_); }

 private:
  struct Made {
    int index = -1;
    std::optional<Body> body{};
  };
  const Body& take(int index, Made& made) {
    if (row_ != nullptr) return row_[index];
    if (made.index != index) made = {index, source_->body(source_->owner, index)};
    return *made.body;
  }

  const BodySource* source_ = nullptr;
  const Body* row_ = nullptr;  // null: they are made
  Made first_{}, second_{};
};

/// A pair in contact.
struct FoundPair {
  std::size_t pair = 0;
  PairResult result{};
};

/// What one worker finds, in the order of pairs.
struct WorkerPart {
  std::size_t start = 0;  // of its points in the list of all
  std::vector<ContactPoint> points{};
  std::vector<TrackedPoint> tracked{};  // the points as the next call is to see them
  std::vector<FoundPair> found{};
  PairTracking tracking{};
  std::vector<int> previous{};
  PairBodies bodies{};

  void begin(const BodySource& source) {
    start = 0;
    points.clear();
    tracked.clear();
    found.clear();
    bodies.start(source);
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

void check_sizes(const BodySource& bodies) {
  if (bodies.count > 0 && bodies.body == nullptr) {
    throw InputError("pair batch: there is no function that gives the " +
                     std::to_string(bodies.count) + " bodies");
  }
  const auto fits = [&](std::size_t size, const char* what) {
    if (size != 0 && size != static_cast<std::size_t>(bodies.count))
      throw InputError("pair batch: " + std::to_string(size) + " " + what + " for " +
                       std::to_string(bodies.count) + " bodies");
  };
  fits(bodies.names.size(), "names");
  fits(bodies.changes.size(), "changes");
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
  BodySource bodies;                            // of the call at hand
  std::vector<BlockPair> sorted;                // the caller's pairs, where they are in no order
  std::span<const BlockPair> pairs;             // of the call at hand, by index
  std::vector<BlockPair> renamed;               // the same by name, where names are not the indices
  std::vector<BlockPair> named;                 // of the last find(), by name
  std::vector<PairState> states, next_states;   // one a pair of the last find()
  std::vector<FeatureHint> hints, next_hints;   // likewise
  std::vector<PairResult> listed, next_listed;  // in contact, or no longer
  std::vector<TrackedPoint> tracked;            // points of the last call
  std::vector<WorkerPart> parts{1};             // one a worker

  // Contact points of the pairs of which neither body moved, and the reach they were found with.
  std::vector<ContactPoint> remembered, next_remembered;
  std::size_t remembered_pairs = 0, standing_pairs = 0, kept_pairs = 0;
  double remembered_reach = -1.0;

  void take_pairs(std::span<const BlockPair> given);
  void check_row() const;
  std::span<const BlockPair> named_now() const {
    return bodies.names.empty() ? pairs : std::span<const BlockPair>(renamed);
  }
  void carry();
  void forget_changed();
  void remember(const std::vector<ContactPoint>& contacts);
  void search(std::size_t first, std::size_t last, WorkerPart& part);
  void ask(std::size_t first, std::size_t last, WorkerPart& part);
  double tolerance_of(const Body& a, const Body& b) const {
    return options.tolerance > 0.0 ? options.tolerance : default_tolerance(a, b);
  }
  bool stay_apart(std::size_t i, const Body& a, const Body& b, const FeatureHint& hint,
                  const PairState& state) const;
  PairResult search_pair(std::size_t i, WorkerPart& part, FeatureHint& hint,
                         const PairState& state) const;
  PairResult repeat(std::size_t i, WorkerPart& part);
  void list(std::size_t i, std::size_t start, WorkerPart& part, PairResult& result);
  void follow(std::size_t i, std::span<ContactPoint> points, WorkerPart& part);
  void match(std::size_t i, const Body& a, std::span<const TrackedPoint> was,
             std::span<ContactPoint> points, WorkerPart& part);
  template <class Search>
  void search_all(std::vector<ContactPoint>& contacts, Executor* executor, const Search& search);
  void list_results();
  void find(std::vector<ContactPoint>& contacts, Executor* executor);
  void contacts_of(std::vector<ContactPoint>& contacts, Executor* executor);
  void forget();

  int name(int body) const {
    return bodies.names.empty() ? body : bodies.names[static_cast<std::size_t>(body)];
  }
  BodyChange change(int body) const {
    return bodies.changes.empty() ? BodyChange::Moved
                                  : bodies.changes[static_cast<std::size_t>(body)];
  }
  PairResult& listed_of(const PairState& pair) {
    return listed[static_cast<std::size_t>(pair.listed)];
  }
  /// Of a pair's points.
  int count_of(const PairState& pair) { return pair.listed < 0 ? 0 : listed_of(pair).count; }
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
  const std::span<const BlockPair> now = named_now();
  if (std::ranges::equal(now, named)) return;
  next_states.resize(now.size());
  next_hints.resize(now.size());
  std::size_t old = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    while (old < named.size() && named[old] < now[i]) ++old;
    const bool is_known = old < named.size() && named[old] == now[i];
    next_states[i] = is_known ? states[old] : PairState{};
    next_hints[i] = is_known ? hints[old] : FeatureHint{};
  }
  std::swap(states, next_states);
  std::swap(hints, next_hints);
  named.assign(now.begin(), now.end());
}

/// Forgets what was found for pairs that have changed since, or with another reach.
void PairBatch::Memory::forget_changed() {
  standing_pairs = kept_pairs = 0;
  const auto still = std::ranges::count(bodies.changes, BodyChange::None);
  const auto other_shapes = std::ranges::count(bodies.changes, BodyChange::Shape);
  if (still < 2 && other_shapes == 0 && remembered_pairs == 0) return;
  const bool same_reach = remembered_reach == options.reach;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const bool stand = both_stand(pairs[i]);
    if (!stand || !same_reach) states[i].kept = -1;
    if (reshaped(pairs[i])) {
      hints[i] = {};
    }
    standing_pairs += stand;
    kept_pairs += states[i].kept >= 0;
  }
}

/// Keeps the contact points of all pairs that stand, sorted by key as they are in `contacts`.
void PairBatch::Memory::remember(const std::vector<ContactPoint>& contacts) {
  if (standing_pairs == kept_pairs && kept_pairs == remembered_pairs)
    return;  // all of them are there already
  std::size_t total = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (both_stand(pairs[i])) total += static_cast<std::size_t>(count_of(states[i]));
  next_remembered.clear();
  next_remembered.reserve(total);
  auto contact = contacts.begin();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto first = contact;
    contact += count_of(states[i]);
    if (!both_stand(pairs[i])) continue;
    states[i].kept = static_cast<int>(next_remembered.size());
    next_remembered.insert(next_remembered.end(), first, contact);
  }
  std::swap(remembered, next_remembered);
  remembered_pairs = standing_pairs;
  remembered_reach = options.reach;
}

/// The points of one pair among those that it had: by their features, and where these have changed
/// by their places as seen from body a: within the tolerance rounding may give a corner another
/// name.
void PairBatch::Memory::match(std::size_t i, const Body& a, std::span<const TrackedPoint> was,
                              std::span<ContactPoint> points, WorkerPart& part) {
  part.previous.resize(points.size());
  const double reach =
      std::max(reach_of(pairs[i]), tolerance_of(a, part.bodies.second(pairs[i].b)));
  part.tracking.match(std::span(part.tracked).last(points.size()), was, reach, part.previous);
  const int first = listed_of(states[i]).first;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (part.previous[k] >= 0) points[k].previous = first + part.previous[k];
}

/// Finds the points' predecessors, and keeps the points for the next call.
void PairBatch::Memory::follow(std::size_t i, std::span<ContactPoint> points, WorkerPart& part) {
  const bool in_world = options.frame == PointFrame::World;
  const Placement own;
  const Body& a = part.bodies.first(pairs[i].a);
  const Placement& frame = in_world ? a.placement() : own;
  for (ContactPoint& point : points) {
    point.previous = -1;
    part.tracked.push_back(
        geometry::tracked(point.key, in_world ? point.point() : point.point_a, frame));
  }
  if (states[i].listed < 0 || reshaped(pairs[i])) return;
  const PairResult& last = listed_of(states[i]);
  const auto was = std::span<const TrackedPoint>(tracked).subspan(
      static_cast<std::size_t>(last.first), static_cast<std::size_t>(last.count));
  match(i, a, was, points, part);
}

/// Does last step's plane still part two bodies that were not in contact? They have no points then.
bool PairBatch::Memory::stay_apart(std::size_t i, const Body& a, const Body& b,
                                   const FeatureHint& hint, const PairState& state) const {
  if (state.listed >= 0 || hint.vertices_a[0] < 0) return false;
  const double near = std::max(reach_of(pairs[i]), tolerance_of(a, b));
  return apart_beyond(a, b, hint.normal, near) > 0.0;
}

/// Appends the points of a pair to those of the worker.
PairResult PairBatch::Memory::search_pair(std::size_t i, WorkerPart& part, FeatureHint& hint,
                                          const PairState& state) const {
  PairResult result;
  const Body& a = part.bodies.first(pairs[i].a);
  const Body& b = part.bodies.second(pairs[i].b);
  if (stay_apart(i, a, b, hint, state)) return result;
  const std::size_t first = part.points.size();
  const BlockPair names = named_now()[i];
  const NearestFeatures nearest = append_contacts_within_reach(
      {names.a, names.b}, a, b, options_of(pairs[i]), hint, part.points);
  hint = nearest.hint;
  describe(nearest, std::span(part.points).subspan(first), result);
  return result;
}

/// The answer of a pair of which neither body has moved.
PairResult PairBatch::Memory::repeat(std::size_t i, WorkerPart& part) {
  if (states[i].listed < 0) return {};
  const PairResult& result = listed_of(states[i]);
  const auto point = remembered.begin() + states[i].kept;
  part.points.insert(part.points.end(), point, point + result.count);
  return result;
}

/// A pair in contact, its points from `start` on.
void PairBatch::Memory::list(std::size_t i, std::size_t start, WorkerPart& part,
                             PairResult& result) {
  result.a = named[i].a;
  result.b = named[i].b;
  result.first = static_cast<int>(start);
  result.event = states[i].listed >= 0 ? PairEvent::Persist : PairEvent::Begin;
  part.found.push_back({i, result});
}

/// Pairs first … last - 1 for find().
void PairBatch::Memory::search(std::size_t first, std::size_t last, WorkerPart& part) {
  for (std::size_t i = first; i < last; ++i) {
    PairState& state = states[i];
    const std::size_t start = part.points.size();
    PairResult result = state.kept >= 0 ? repeat(i, part) : search_pair(i, part, hints[i], state);
    if (part.points.size() > start) {
      follow(i, std::span(part.points).subspan(start), part);
      list(i, start, part, result);
    } else {
      state.listed = -1;
    }
  }
}

/// The same for contacts_of(). Pairs that find() does not know start cold, and a body of another
/// shape has features of other names until find() has seen it.
void PairBatch::Memory::ask(std::size_t first, std::size_t last, WorkerPart& part) {
  const std::span<const BlockPair> now = named_now();
  for (std::size_t i = first; i < last; ++i) {
    const auto known = std::lower_bound(named.begin(), named.end(), now[i]);
    const bool is_known = known != named.end() && *known == now[i] && !reshaped(pairs[i]);
    const auto place = known - named.begin();
    PairState new_state;
    FeatureHint no_hint;
    PairState& state = is_known ? states.begin()[place] : new_state;
    search_pair(i, part, is_known ? hints.begin()[place] : no_hint, state);
  }
}

/// Each worker takes a run of neighbouring pairs; what they find is put one behind the other.
template <class Search>
void PairBatch::Memory::search_all(std::vector<ContactPoint>& contacts, Executor* executor,
                                   const Search& search) {
  const std::size_t workers = workers_for(executor, pairs.size(), kPairsPerWorker);
  parts.resize(std::max(parts.size(), workers));
  for (WorkerPart& part : parts) part.begin(bodies);
  const auto part_of = [&](int worker) -> WorkerPart& {
    return parts[static_cast<std::size_t>(worker)];
  };
  if (workers == 1) {
    WorkerPart& part = parts[0];
    part.points.swap(contacts);
    part.points.clear();
    search(0, pairs.size(), part);
    part.points.swap(contacts);
    return;
  }
  auto find_part = [&](int worker) {
    const auto w = static_cast<std::size_t>(worker);
    search(pairs.size() * w / workers, pairs.size() * (w + 1) / workers, part_of(worker));
  };
  executor->run_each(find_part);
  std::size_t total = 0;
  for (WorkerPart& part : parts) {
    part.start = total;
    total += part.points.size();
  }
  contacts.resize(total);
  auto put = [&](int worker) {
    const WorkerPart& part = part_of(worker);
    std::ranges::copy(part.points, contacts.begin() + static_cast<std::ptrdiff_t>(part.start));
  };
  executor->run_each(put);
}

/// Pairs in contact, and those of the last call that are so no more.
void PairBatch::Memory::list_results() {
  next_listed.clear();
  tracked.clear();
  auto old = listed.begin();
  const auto end_those_before = [&](const BlockPair& names) {
    for (; old != listed.end() && names_of(*old) < names; ++old) {
      if (old->event == PairEvent::End) continue;
      old->event = PairEvent::End;
      old->first = old->count = 0;
      next_listed.push_back(*old);
    }
  };
  for (WorkerPart& part : parts) {
    for (auto& [pair, result] : part.found) {
      end_those_before(names_of(result));
      if (old != listed.end() && names_of(*old) == names_of(result)) ++old;
      result.first += static_cast<int>(part.start);
      states[pair].listed = static_cast<int>(next_listed.size());
      next_listed.push_back(result);
    }
    tracked.insert(tracked.end(), part.tracked.begin(), part.tracked.end());
  }
  end_those_before(kLastNames);
  std::swap(listed, next_listed);
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
  memory().options.reach = reach;
}

void PairBatch::Memory::find(std::vector<ContactPoint>& contacts, Executor* executor) {
  carry();
  forget_changed();
  search_all(contacts, executor,
             [this](auto first, auto last, WorkerPart& part) { search(first, last, part); });
  list_results();
  remember(contacts);
}

void PairBatch::Memory::contacts_of(std::vector<ContactPoint>& contacts, Executor* executor) {
  search_all(contacts, executor,
             [this](auto first, auto last, WorkerPart& part) { ask(first, last, part); });
  for (ContactPoint& point : contacts) point.previous = -1;
}

/// After a call that could not be finished.
void PairBatch::Memory::forget() {
  for (std::vector<BlockPair>* list : {&named, &renamed}) list->clear();
  states.clear();
  hints.clear();
  listed.clear();
  tracked.clear();
  remembered.clear();
  for (WorkerPart& part : parts) part = {};
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
  const std::size_t workers = workers_for(executor, pairs.size(), kDistancesPerWorker);
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
