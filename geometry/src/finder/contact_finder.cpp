#include <algorithm>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/worker_pool.hpp>

#include "finder/body_store.hpp"
#include "finder/placed_box.hpp"

namespace quoin::geometry {
namespace {

FinderOptions checked(const FinderOptions& options) {
  require_length(options.reach, "finder: reach");
  require_length(options.tolerance, "finder: tolerance");
  if (options.threads < 1) {
    throw InputError("finder: threads is " + std::to_string(options.threads) +
                     ", must be at least 1");
  }
  return options;
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
        batch({.tolerance = given.tolerance, .reach = given.reach, .frame = given.frame}) {}

  FinderOptions options;
  WorkerPool pool;
  std::function<bool(int, int)> filter;
  BodyStore store;
  BroadPhase broad_phase;
  std::vector<BlockPair> pairs;  // slots of the call at hand, where not all near pairs are tested
  PairBatch batch;

  Executor& executor() { return options.executor == nullptr ? pool : *options.executor; }
  double box_reach() const;
  bool many_leave() const;
  void update_boxes();
  void update_box(int slot);
  bool is_tested(const BlockPair& pair) const;
  void choose_tested(const std::vector<BlockPair>& near);
  FindCounts find(std::vector<ContactPoint>& contacts);
};

/// Up to where boxes may be apart from each other when their bodies are in contact, m.
double ContactFinder::Memory::box_reach() const {
  const double tolerance = options.tolerance > 0.0 ? options.tolerance : store.largest_tolerance();
  return std::max(options.reach, tolerance);
}

void ContactFinder::Memory::update_box(int slot) {
  if (store.is_hole(slot)) {
    if (slot < broad_phase.size()) return broad_phase.remove(slot);
    // come and gone since the last call: a box that meets nothing keeps the slots in step
    broad_phase.set(slot, Box{});
    return broad_phase.remove(slot);
  }
  const bool idle = store.motion(slot) == BodyMotion::Idle;
  broad_phase.set(slot, placed_box(store.shape(slot), store.placement(slot)),
                  idle ? BoxUse::Idle : BoxUse::Moving, store.reach(slot));
}

/// Do so many bodies leave the room that their boxes have that all had better get new room?
bool ContactFinder::Memory::many_leave() const {
  std::size_t leaving = 0;
  for (int slot = 0; slot < store.slots(); slot += BroadPhase::kSample) {
    if (store.changes()[static_cast<std::size_t>(slot)] == BodyChange::None) continue;
    leaving += !store.is_hole(slot) &&
               broad_phase.leaves_room(slot, placed_box(store.shape(slot), store.placement(slot)));
  }
  const auto slots = static_cast<std::size_t>(store.slots());
  return leaving * BroadPhase::kSample * BroadPhase::kBulk > slots;
}

void ContactFinder::Memory::update_boxes() {
  const bool all = store.pack();
  if (all) broad_phase.clear();
  if (many_leave()) broad_phase.renew_all();
  for (int slot = 0; slot < store.slots(); ++slot) {
    if (all || store.changes()[static_cast<std::size_t>(slot)] != BodyChange::None) {
      update_box(slot);
    }
  }
}

bool ContactFinder::Memory::is_tested(const BlockPair& pair) const {
  if (!store.may_touch(pair.a, pair.b)) return false;
  return !filter || filter(store.handle(pair.a), store.handle(pair.b));
}

void ContactFinder::Memory::choose_tested(const std::vector<BlockPair>& near) {
  pairs.clear();
  for (const BlockPair& pair : near) {
    if (is_tested(pair)) pairs.push_back(pair);
  }
}

FindCounts ContactFinder::Memory::find(std::vector<ContactPoint>& contacts) {
  update_boxes();
  const std::vector<BlockPair>& near = broad_phase.find_candidates(box_reach());
  const bool all = !filter && store.all_may_touch();
  if (!all) choose_tested(near);
  BodySource source;
  source.owner = &store;
  source.body = body_in_store;
  source.count = store.slots();
  source.names = store.handles();
  source.changes = store.changes();
  source.ways = store.ways();
  source.reaches = store.reaches();
  const FindCounts counts = batch.find(source, all ? near : pairs, contacts, &executor());
  store.settle();
  return counts;
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

void ContactFinder::remove(int handle) { memory().store.remove(handle); }

void ContactFinder::move(int handle, const Placement& placement) {
  memory().store.move(handle, placement);
}

void ContactFinder::replace_shape(int handle, std::shared_ptr<const Shape> shape) {
  memory().store.replace_shape(handle, std::move(shape));
}

void ContactFinder::set_options(int handle, const BodyOptions& options) {
  memory().store.set_options(handle, options);
}

void ContactFinder::set_reach(int handle, double reach) {
  Memory& m = memory();
  require_length(reach, "finder: reach of a body");
  m.store.set_reach(handle, reach);
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

std::span<const PairResult> ContactFinder::pairs() const { return memory().batch.pairs(); }

}  // namespace quoin::geometry
