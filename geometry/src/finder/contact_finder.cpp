#include <algorithm>
#include <map>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/worker_pool.hpp>
#include <tuple>
#include <utility>

#include "finder/body_store.hpp"
#include "finder/placed_box.hpp"

namespace quoin::geometry {
namespace {

FinderOptions checked(const FinderOptions& options) {
  require_length(options.reach, "finder: reach");
  require_length(options.tolerance, "finder: tolerance");
  require_length(options.coordinate_rounding, "finder: coordinate rounding");
  if (options.threads < 1 || options.threads > kMostThreads) {
    throw InputError("finder: threads is " + std::to_string(options.threads) +
                     ", must be from 1 to " + std::to_string(kMostThreads));
  }
  return options;
}

bool precedes(const BodyHit& x, const BodyHit& y) {
  return std::tie(x.hit.s, x.handle) < std::tie(y.hit.s, y.handle);
}

/// Where a part stands that stands at `own` in a compound.
Placement placed(const Placement& compound, const Placement& own) {
  return {compound.linear * own.linear, compound.translation + compound.linear * own.translation};
}

Body body_in_store(const void* owner, int slot) {
  const BodyStore& store = *static_cast<const BodyStore*>(owner);
  return {store.shape(slot), store.placement(slot)};
}

}  // namespace

struct ContactFinder::Memory {
  explicit Memory(const FinderOptions& given)
      : options(checked(given)),
        pool(given.executor == nullptr ? given.threads : 1),
        batch({.tolerance = given.tolerance,
               .reach = given.reach,
               .frame = given.frame,
               .coordinate_rounding = given.coordinate_rounding}) {}

  FinderOptions options;
  WorkerPool pool;
  std::function<bool(int, int)> filter;
  using Compounds =
      std::map<int, std::vector<Placement>>;  // by handle: where the parts stand in it
  Compounds compounds;
  int most_parts = 1;
  BodyStore store;
  BroadPhase broad_phase;
  bool boxes_are_whole = true;   // false: a call was stopped in the midst of setting them
  std::vector<BlockPair> pairs;  // slots of the call at hand, where not all near pairs are tested
  std::vector<int> asked;        // slots of contacts_of() and of queries
  std::vector<BroadPhase::Entry> entries;
  PairBatch batch;

  Compounds::const_iterator compound_with(int handle) const;
  std::span<const Placement> parts(int handle) const;
  template <class Work>
  void for_each_part(int handle, const Work& work) const;
  bool in_one_compound(int a, int b) const;
  int add_compound(std::span<const CompoundPart> parts, const Placement& placement,
                   const BodyOptions& body_options);
  void move(int handle, const Placement& placement);

  Executor& executor() { return options.executor == nullptr ? pool : *options.executor; }
  double box_reach() const;
  void update_boxes();
  void renew_boxes();
  template <class Search>
  const std::vector<BlockPair>& near_pairs(bool packed, const Search& search);
  BodySource source() const;
  std::span<const BlockPair> tested(const std::vector<BlockPair>& near);
  BoxUse use(int slot) const;
  bool has_changed(int slot) const {
    return store.changes()[static_cast<std::size_t>(slot)] != BodyChange::None;
  }
  void update_box(int slot);
  bool is_tested(const BlockPair& pair) const;
  bool is_asked(int slot, const QueryFilter& asks) const {
    return (store.category(slot) & asks.categories) != 0 &&
           (!asks.accepts || asks.accepts(store.handle(slot)));
  }
  template <class Search>
  void ask_boxes(const Search& search);
  void find_in_box(const Box& box, const QueryFilter& filter);
  template <class Take>
  void visit_hits(const Ray& ray, const QueryFilter& filter, const Take& take);
  FindCounts find(std::vector<ContactPoint>& contacts);
  FindCounts contacts_of(std::span<const int> handles, std::vector<ContactPoint>& contacts);
};

/// Up to where boxes may be apart from each other when their bodies are in contact, m.
double ContactFinder::Memory::box_reach() const {
  const double tolerance = options.tolerance > 0.0 ? options.tolerance : store.largest_tolerance();
  return std::max(options.reach, tolerance);
}

BoxUse ContactFinder::Memory::use(int slot) const {
  return store.motion(slot) == BodyMotion::Idle ? BoxUse::Idle : BoxUse::Moving;
}

void ContactFinder::Memory::update_box(int slot) {
  if (store.is_hole(slot)) {
    if (slot < broad_phase.size()) return broad_phase.remove(slot);
    // come and gone since the last call: a box that meets nothing keeps the slots in step
    broad_phase.set(slot, Box{});
    return broad_phase.remove(slot);
  }
  broad_phase.set(slot, placed_box(store.shape(slot), store.placement(slot)), use(slot),
                  store.reach(slot));
}

/// Of the bodies that have changed since this was done last.
void ContactFinder::Memory::update_boxes() {
  if (store.many_to_place()) {
    for (int slot = 0; slot < store.slots(); ++slot)
      if (has_changed(slot)) update_box(slot);
  } else {
    for (const int slot : store.to_place()) update_box(slot);
  }
  store.boxes_are_placed();
}

/// The row is packed: boxes have other numbers.
void ContactFinder::Memory::renew_boxes() {
  broad_phase = {};
  for (int slot = 0; slot < store.slots(); ++slot) update_box(slot);
  store.boxes_are_placed();
}

/// What `search` finds once the boxes stand where the bodies do. What is thrown meanwhile, for want
/// of memory, may leave boxes and tree half made: the next call begins with new ones.
template <class Search>
const std::vector<BlockPair>& ContactFinder::Memory::near_pairs(bool packed, const Search& search) {
  const bool whole = std::exchange(boxes_are_whole, false);
  if (!whole) broad_phase = BroadPhase();
  whole && !packed ? update_boxes() : renew_boxes();
  const std::vector<BlockPair>& near = search();
  boxes_are_whole = true;
  return near;
}

/// Runs a search that lists no pairs.
template <class Search>
void ContactFinder::Memory::ask_boxes(const Search& search) {
  near_pairs(
      false, [&]() -> auto& {
        search();
        return pairs;
      });
}

/// Slots of the bodies asked for whose boxes meet a box, into `asked`.
void ContactFinder::Memory::find_in_box(const Box& box, const QueryFilter& asks) {
  ask_boxes([&] { broad_phase.find_in_box(box, box_reach(), asked); });
  std::erase_if(asked, [&](int slot) { return !is_asked(slot, asks); });
}

/// Calls take(hit) for the bodies that a ray enters, in the order of their boxes; what it returns
/// is where the ray ends from there on.
template <class Take>
void ContactFinder::Memory::visit_hits(const Ray& ray, const QueryFilter& asks, const Take& take) {
  require_ray(ray);
  ask_boxes([&] {
    broad_phase.find_on_ray(ray.origin, ray.direction, ray.length, box_reach(), entries);
  });
  double end = ray.length;
  for (const auto& [s, slot] : entries) {
    if (s > end) break;
    if (!is_asked(slot, asks)) continue;
    const std::optional<RayHit> hit = first_hit(body_in_store(&store, slot), ray);
    if (hit) end = std::min(end, take(BodyHit{store.handle(slot), *hit}));
  }
}

/// The end: a body by itself.
ContactFinder::Memory::Compounds::const_iterator ContactFinder::Memory::compound_with(
    int handle) const {
  const auto next = compounds.upper_bound(handle);
  if (next == compounds.begin()) return compounds.end();
  const auto found = std::prev(next);
  return handle - found->first < static_cast<int>(found->second.size()) ? found : compounds.end();
}

/// Of the compound of that handle; none: a body by itself. Throws InputError for a part of one.
std::span<const Placement> ContactFinder::Memory::parts(int handle) const {
  const auto found = compound_with(handle);
  if (found == compounds.end()) return {};
  if (found->first == handle) return found->second;
  throw InputError("body " + std::to_string(handle) + " is a part of compound " +
                   std::to_string(found->first) + " and goes with it");
}

template <class Work>
void ContactFinder::Memory::for_each_part(int handle, const Work& work) const {
  const int count = static_cast<int>(parts(handle).size());
  for (int k = 0; k < std::max(1, count); ++k) work(handle + k);
}

bool ContactFinder::Memory::in_one_compound(int a, int b) const {
  if (std::abs(a - b) >= most_parts) return false;
  const auto found = compound_with(a);
  return found != compounds.end() && found == compound_with(b);
}

int ContactFinder::Memory::add_compound(std::span<const CompoundPart> given,
                                        const Placement& placement,
                                        const BodyOptions& body_options) {
  if (given.empty()) throw InputError("finder: the compound has no parts");
  std::vector<Placement> own;
  int handle = -1, added = 0;
  try {
    for (const CompoundPart& part : given) {
      own.push_back(part.placement);
      const int next = store.add(part.shape, placed(placement, part.placement), body_options);
      handle = added++ == 0 ? next : handle;
    }
    compounds.emplace(handle, std::move(own));
  } catch (...) {
    for (int k = 0; k < added; ++k) store.remove(handle + k);
    throw;
  }
  most_parts = std::max(most_parts, added);
  return handle;
}

void ContactFinder::Memory::move(int handle, const Placement& placement) {
  const std::span<const Placement> own = parts(handle);
  if (own.empty()) return store.move(handle, placement);
  require_placement(placement, handle);
  const int count = static_cast<int>(own.size());
  const auto place = [&](int k) { return placed(placement, own[static_cast<std::size_t>(k)]); };
  for (int k = 0; k < count; ++k) require_placement(place(k), handle + k);
  for (int k = 0; k < count; ++k) store.move(handle + k, place(k));
}

bool ContactFinder::Memory::is_tested(const BlockPair& pair) const {
  if (!store.may_touch(pair.a, pair.b)) return false;
  const int a = store.handle(pair.a), b = store.handle(pair.b);
  return !in_one_compound(a, b) && (!filter || filter(a, b));
}

std::span<const BlockPair> ContactFinder::Memory::tested(const std::vector<BlockPair>& near) {
  if (!filter && compounds.empty() && store.all_may_touch()) return near;
  pairs.clear();
  for (const BlockPair& pair : near)
    if (is_tested(pair)) pairs.push_back(pair);
  return pairs;
}

BodySource ContactFinder::Memory::source() const {
  BodySource source;
  source.owner = &store;
  source.body = body_in_store;
  source.count = store.slots();
  source.names = store.handles();
  source.changes = store.changes();
  source.reaches = store.reaches();
  return source;
}

FindCounts ContactFinder::Memory::find(std::vector<ContactPoint>& contacts) {
  const std::vector<BlockPair>& near = near_pairs(
      store.pack(), [&]() -> auto& { return broad_phase.find_candidates(box_reach()); });
  const FindCounts counts = batch.find(source(), tested(near), contacts, &executor());
  store.settle();
  return counts;
}

FindCounts ContactFinder::Memory::contacts_of(std::span<const int> handles,
                                              std::vector<ContactPoint>& contacts) {
  asked.clear();
  for (const int handle : handles) {
    const auto compound = compounds.find(handle);
    const int count = compound == compounds.end() ? 1 : static_cast<int>(compound->second.size());
    for (int k = 0; k < count; ++k) asked.push_back(store.slot(handle + k));
  }
  const std::vector<BlockPair>& near = near_pairs(
      false, [&]() -> auto& { return broad_phase.find_candidates_of(asked, box_reach()); });
  return batch.contacts_of(source(), tested(near), contacts, &executor());
}

ContactFinder::ContactFinder(const FinderOptions& options)
    : memory_(std::make_unique<Memory>(options)) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

ContactFinder::Memory& ContactFinder::memory() const {
  if (!memory_) throw InputError("finder: it was moved from");
  return *memory_;
}

int ContactFinder::add(std::shared_ptr<const Shape> shape, const Placement& placement,
                       const BodyOptions& options) {
  return memory().store.add(std::move(shape), placement, options);
}

int ContactFinder::add_compound(std::span<const CompoundPart> parts, const Placement& placement,
                                const BodyOptions& options) {
  return memory().add_compound(parts, placement, options);
}

PartName ContactFinder::part_name(int handle) const {
  const Memory& m = memory();
  m.store.slot(handle);
  const auto found = m.compound_with(handle);
  if (found == m.compounds.end()) return {handle, 0};
  return {found->first, handle - found->first};
}

void ContactFinder::remove(int handle) {
  Memory& m = memory();
  m.for_each_part(handle, [&](int part) { m.store.remove(part); });
  m.compounds.erase(handle);
}

void ContactFinder::move(int handle, const Placement& placement) {
  memory().move(handle, placement);
}

void ContactFinder::replace_shape(int handle, std::shared_ptr<const Shape> shape) {
  memory().store.replace_shape(handle, std::move(shape));
}

void ContactFinder::set_options(int handle, const BodyOptions& options) {
  Memory& m = memory();
  m.for_each_part(handle, [&](int part) { m.store.set_options(part, options); });
}

void ContactFinder::set_reach(int handle, double reach) {
  Memory& m = memory();
  require_length(reach, "finder: reach of a body");
  m.for_each_part(handle, [&](int part) { m.store.set_reach(part, reach); });
}

bool ContactFinder::contains(int handle) const { return memory().store.contains(handle); }

int ContactFinder::size() const { return memory().store.size(); }

Body ContactFinder::body(int handle) const {
  const BodyStore& store = memory().store;
  return body_in_store(&store, store.slot(handle));
}

void ContactFinder::set_filter(std::function<bool(int a, int b)> filter) {
  memory().filter = std::move(filter);
}

void ContactFinder::set_reach(double reach) {
  Memory& m = memory();
  require_length(reach, "finder: reach");
  m.options.reach = reach;
  m.batch.set_reach(reach);
}

int ContactFinder::threads() const { return memory().executor().workers(); }

FindCounts ContactFinder::find(std::vector<ContactPoint>& contacts) {
  return memory().find(contacts);
}

FindCounts ContactFinder::contacts_of(std::span<const int> handles,
                                      std::vector<ContactPoint>& contacts) {
  return memory().contacts_of(handles, contacts);
}

std::optional<BodyHit> ContactFinder::nearest_hit(const Ray& ray, const QueryFilter& filter) {
  std::optional<BodyHit> nearest;
  memory().visit_hits(ray, filter, [&](const BodyHit& found) {
    if (!nearest || precedes(found, *nearest)) nearest = found;
    return nearest->hit.s;
  });
  return nearest;
}

void ContactFinder::all_hits(const Ray& ray, std::vector<BodyHit>& hits,
                             const QueryFilter& filter) {
  hits.clear();
  memory().visit_hits(ray, filter, [&](const BodyHit& found) {
    hits.push_back(found);
    return ray.length;
  });
  std::sort(hits.begin(), hits.end(), precedes);
}

void ContactFinder::bodies_in_box(const Box& box, std::vector<int>& handles,
                                  const QueryFilter& filter) {
  Memory& m = memory();
  if (!((box.max - box.min).minCoeff() >= 0.0) || !(box.max - box.min).allFinite())
    throw InputError("finder: the box is not finite, or its max is below its min");
  m.find_in_box(box, filter);
  handles.clear();
  for (const int slot : m.asked) handles.push_back(m.store.handle(slot));
}

void ContactFinder::bodies_at(const Vector3& point, double tolerance, std::vector<int>& handles,
                              const QueryFilter& filter) {
  Memory& m = memory();
  require_length(tolerance, "finder: tolerance of a point");
  handles.clear();
  if (!point.allFinite()) return;
  const Vector3 room = Vector3::Constant(tolerance);
  m.find_in_box({point - room, point + room}, filter);
  for (const int slot : m.asked)
    if (geometry::contains(body_in_store(&m.store, slot), point, tolerance))
      handles.push_back(m.store.handle(slot));
}

std::span<const PairResult> ContactFinder::pairs() const { return memory().batch.pairs(); }

}  // namespace quoin::geometry
