#include "finder/body_store.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "finder/largest_move.hpp"
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
  make_room_in(kind_of_);
  make_room_in(changes_);
  make_room_in(ways_);
  const std::size_t most = most_to_place();
  if (to_place_.capacity() <= most) to_place_.reserve(most + most / 4);
  if (!reaches_.empty()) make_room_in(reaches_);
}

/// One more user of a kind, which is made if there is none like it.
int BodyStore::join_kind(std::shared_ptr<const Shape> shape, const BodyOptions& options) {
  Kind made{std::move(shape), options.category, options.collides_with, options.motion};
  const auto [place, is_new] = kind_by_key_.try_emplace(key_of(made), -1);
  if (is_new) {
    try {
      make_room_in(kinds_);
      // So that leave_kind() cannot fail.
      if (free_kinds_.capacity() <= kinds_.size()) free_kinds_.reserve(2 * kinds_.size() + 1);
    } catch (...) {
      kind_by_key_.erase(place);
      throw;
    }
    if (free_kinds_.empty()) {
      free_kinds_.push_back(static_cast<int>(kinds_.size()));
      kinds_.emplace_back();
    }
    place->second = free_kinds_.back();
    free_kinds_.pop_back();
    kinds_[at(place->second)] = std::move(made);
    survey_.reset();
  }
  ++kinds_[at(place->second)].users;
  return place->second;
}

void BodyStore::leave_kind(int kind) {
  Kind& left = kinds_[at(kind)];
  if (--left.users > 0) return;
  kind_by_key_.erase(key_of(left));
  left.shape.reset();
  survey_.reset();
  free_kinds_.push_back(kind);
}

int BodyStore::add(std::shared_ptr<const Shape> shape, const Placement& placement,
                   const BodyOptions& options) {
  const int handle = given();
  if (handle == std::numeric_limits<int>::max())
    throw InputError("finder: no handle is left after 2147483647 bodies");
  require_shape(shape, handle);
  require_placement(placement, handle);
  make_room();
  const int kind = join_kind(std::move(shape), options);
  if (was_packed()) {
    slot_of_.push_back(slots());
    handles_.push_back(handle);
  }
  placements_.push_back(placement);
  kind_of_.push_back(kind);
  changes_.push_back(BodyChange::None);
  ways_.push_back(0.0);
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
  leave_kind(kind_of_[at(place)]);
  kind_of_[at(place)] = -1;
  if (was_packed()) slot_of_[at(handle)] = -1;
  changes_[at(place)] = BodyChange::Moved;  // whatever its shape was
  note_change(place, BodyChange::Moved);
  --present_;
}

void BodyStore::move(int handle, const Placement& placement) {
  const int place = slot(handle);
  require_placement(placement, handle);
  if (same_placement(placements_[at(place)], placement)) return;
  ways_[at(place)] =
      longer_way(ways_[at(place)], largest_move(shape(place), placements_[at(place)], placement));
  placements_[at(place)] = placement;
  note_change(place, BodyChange::Moved);
}

void BodyStore::replace_shape(int handle, std::shared_ptr<const Shape> shape) {
  const int place = slot(handle);
  require_shape(shape, handle);
  const Kind& old = kind(place);
  const BodyOptions options{old.category, old.collides_with, old.motion};
  // Features keep their names: it has moved, freely.
  const bool moved = changes_[at(place)] != BodyChange::Shape &&
                     old.shape->shared_topology() == shape->shared_topology();
  if (moved) {
    ways_[at(place)] =
        longer_way(ways_[at(place)], largest_move(*old.shape, *shape, placement(place)));
  }
  const int next = join_kind(std::move(shape), options);
  leave_kind(kind_of_[at(place)]);
  kind_of_[at(place)] = next;
  note_change(place, moved ? BodyChange::Moved : BodyChange::Shape);
}

void BodyStore::set_options(int handle, const BodyOptions& options) {
  const int place = slot(handle);
  const int next = join_kind(kind(place).shape, options);
  leave_kind(kind_of_[at(place)]);
  kind_of_[at(place)] = next;
  note_change(place, BodyChange::Moved);
}

/// A longer reach uses up what pairs were apart, as if the body had come nearer by as much: the
/// reach of a pair, the larger of two, grows by no more than both together.
void BodyStore::set_reach(int handle, double reach) {
  const int place = slot(handle);
  if (reaches_.empty()) reaches_.assign(at(slots()), 0.0);
  double& now = reaches_[at(place)];
  if (reach == now) return;
  if (reach > now) ways_[at(place)] = longer_way(ways_[at(place)], reach - now);
  now = reach;
  note_change(place, BodyChange::Moved);
}

const BodyStore::Survey& BodyStore::survey() const {
  if (survey_) return *survey_;
  std::uint32_t category = ~0u, collides_with = ~0u;
  double largest = 0.0;
  for (const Kind& kind : kinds_) {
    if (kind.users == 0) continue;
    category &= kind.category;
    collides_with &= kind.collides_with;
    largest = std::max(largest, default_tolerance(*kind.shape, *kind.shape));
  }
  return survey_.emplace(Survey{(category & collides_with) != 0, largest});
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
    kind_of_[at(next)] = kind_of_[at(from)];
    changes_[at(next)] = changes_[at(from)];
    ways_[at(next)] = ways_[at(from)];
    if (!reaches_.empty()) reaches_[at(next)] = reaches_[at(from)];
    slot_of_[at(handles_[at(next)])] = next;
    ++next;
  }
  placements_.resize(at(next));
  handles_.resize(at(next));
  kind_of_.resize(at(next));
  changes_.resize(at(next));
  ways_.resize(at(next));
  if (!reaches_.empty()) reaches_.resize(at(next));
  return true;
}

void BodyStore::settle() { std::fill(changes_.begin(), changes_.end(), BodyChange::None); }

}  // namespace quoin::geometry
