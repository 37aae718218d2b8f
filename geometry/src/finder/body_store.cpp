#include "finder/body_store.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "finder/placed_box.hpp"

namespace quoin::geometry {
namespace {

constexpr int kFewHoles = 64;  // are not worth packing

/// So that the next push_back cannot fail.
template <class T>
void make_room_in(std::vector<T>& values) {
  if (values.size() == values.capacity())
    values.reserve(std::max<std::size_t>(16, 2 * values.size()));
}

void require_shape(const std::shared_ptr<const Shape>& shape, int handle) {
  if (shape == nullptr) throw InputError("body " + std::to_string(handle) + " has no shape");
}

}  // namespace

int BodyStore::slot(int handle) const {
  if (!contains(handle)) {
    const bool was_given = handle >= 0 && handle < given();
    throw InputError("body " + std::to_string(handle) +
                     (was_given ? " has been removed" : " does not exist"));
  }
  return find(handle);
}

void BodyStore::make_room() {
  if (was_packed()) {
    make_room_in(slot_of_);
    make_room_in(handles_);
  }
  make_room_in(placements_);
  make_room_in(shapes_);
  make_room_in(changes_);
  const std::size_t most = most_to_place();
  if (to_place_.capacity() <= most) to_place_.reserve(most + most / 4);
  if (!reaches_.empty()) make_room_in(reaches_);
}

/// One more body has a shape. Of what is known of all, that of bodies that are gone stays: only
/// speed hangs on it.
const Shape* BodyStore::take(std::shared_ptr<const Shape> shape) {
  Owned& owned = owned_[shape.get()];
  ++owned.users;
  owned.shape = std::move(shape);
  largest_tolerance_ = std::max(largest_tolerance_, default_tolerance(*owned.shape, *owned.shape));
  return owned.shape.get();
}

void BodyStore::drop(const Shape* shape) {
  const auto owned = owned_.find(shape);
  if (--owned->second.users == 0) owned_.erase(owned);
}

int BodyStore::add(std::shared_ptr<const Shape> shape, const Placement& placement,
                   const BodyOptions& options) {
  const int handle = given();
  if (handle == std::numeric_limits<int>::max())
    throw InputError("finder: no handle is left after 2147483647 bodies");
  require_shape(shape, handle);
  require_placement(placement, handle);
  const bool own_options = !options_.empty() || options != BodyOptions{};
  if (own_options) options_.resize(at(slots()));
  if (own_options) make_room_in(options_);
  make_room();
  const Shape* const own = take(std::move(shape));
  if (was_packed()) {
    slot_of_.push_back(slots());
    handles_.push_back(handle);
  }
  placements_.push_back(placement);
  shapes_.push_back(own);
  if (own_options) options_.push_back(options);
  changes_.push_back(BodyChange::None);
  if (!reaches_.empty()) reaches_.push_back(0.0);
  ++present_;
  note_change(slots() - 1, BodyChange::Moved);
  return handle;
}

void BodyStore::note_change(int slot, BodyChange change) {
  BodyChange& now = changes_[at(slot)];
  if (now == BodyChange::None || change == BodyChange::Shape) now = change;
  const bool is_last = !to_place_.empty() && to_place_.back() == slot;
  if (many_to_place_ || is_last) return;
  if (to_place_.size() < most_to_place()) {
    to_place_.push_back(slot);
  } else {
    boxes_are_placed();
    many_to_place_ = true;
  }
}

void BodyStore::boxes_are_placed() {
  to_place_.clear();
  many_to_place_ = false;
}

void BodyStore::remove(int handle) {
  const int place = slot(handle);
  drop(std::exchange(shapes_[at(place)], nullptr));
  if (was_packed()) slot_of_[at(handle)] = -1;
  changes_[at(place)] = BodyChange::Moved;  // whatever its shape was
  note_change(place, BodyChange::Moved);
  --present_;
}

void BodyStore::move(int handle, const Placement& placement) {
  const int place = slot(handle);
  require_placement(placement, handle);
  if (same_placement(placements_[at(place)], placement)) return;
  placements_[at(place)] = placement;
  note_change(place, BodyChange::Moved);
}

void BodyStore::replace_shape(int handle, std::shared_ptr<const Shape> shape) {
  const int place = slot(handle);
  require_shape(shape, handle);
  // Features keep their names: it has moved, freely.
  const bool moved = changes_[at(place)] != BodyChange::Shape &&
                     this->shape(place).shared_topology() == shape->shared_topology();
  drop(std::exchange(shapes_[at(place)], take(std::move(shape))));
  note_change(place, moved ? BodyChange::Moved : BodyChange::Shape);
}

void BodyStore::set_options(int handle, const BodyOptions& options) {
  const int place = slot(handle);
  if (options_.empty()) options_.resize(at(slots()));
  options_[at(place)] = options;
  note_change(place, BodyChange::Moved);
}

void BodyStore::set_reach(int handle, double reach) {
  const int place = slot(handle);
  if (reaches_.empty()) reaches_.assign(at(slots()), 0.0);
  double& now = reaches_[at(place)];
  if (reach == now) return;
  now = reach;
  note_change(place, BodyChange::Moved);
}

bool BodyStore::pack() {
  if (slots() - present_ <= present_ + kFewHoles) return false;
  boxes_are_placed();
  many_to_place_ = true;
  if (!was_packed()) {
    handles_.resize(at(slots()));
    std::iota(handles_.begin(), handles_.end(), 0);
    slot_of_.assign(at(slots()), -1);
  }
  int next = 0;
  for (int from = 0; from < slots(); ++from) {
    if (is_hole(from)) continue;
    placements_[at(next)] = placements_[at(from)];
    handles_[at(next)] = handles_[at(from)];
    shapes_[at(next)] = shapes_[at(from)];
    if (!options_.empty()) options_[at(next)] = options_[at(from)];
    changes_[at(next)] = changes_[at(from)];
    if (!reaches_.empty()) reaches_[at(next)] = reaches_[at(from)];
    slot_of_[at(handles_[at(next)])] = next;
    ++next;
  }
  placements_.resize(at(next));
  handles_.resize(at(next));
  shapes_.resize(at(next));
  if (!options_.empty()) options_.resize(at(next));
  changes_.resize(at(next));
  if (!reaches_.empty()) reaches_.resize(at(next));
  return true;
}

void BodyStore::settle() { std::fill(changes_.begin(), changes_.end(), BodyChange::None); }

}  // namespace quoin::geometry
