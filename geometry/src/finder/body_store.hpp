#pragma once
/// The bodies of a finder, in rows.

#include <map>
#include <quoin/geometry/contact_finder.hpp>

#include "numeric/numbers.hpp"

namespace quoin::geometry {

/// Bodies stand in slots in the order of their handles. A removed one leaves a hole; once there are
/// more holes than bodies the slots are packed. The promises are those of ContactFinder.
class BodyStore {
 public:
  int add(std::shared_ptr<const Shape> shape, const Placement& placement,
          const BodyOptions& options);
  void remove(int handle);
  void move(int handle, const Placement& placement);
  void replace_shape(int handle, std::shared_ptr<const Shape> shape);
  void set_options(int handle, const BodyOptions& options);
  void set_reach(int handle, double reach);

  bool contains(int handle) const { return handle >= 0 && handle < given() && find(handle) >= 0; }
  int slot(int handle) const;
  int size() const { return present_; }
  int slots() const { return static_cast<int>(placements_.size()); }
  bool is_hole(int slot) const { return shapes_[at(slot)] == nullptr; }
  BodyMotion motion(int slot) const { return options(slot).motion; }
  std::uint32_t category(int slot) const { return options(slot).category; }
  const Shape& shape(int slot) const { return *shapes_[at(slot)]; }
  const Placement& placement(int slot) const { return placements_[at(slot)]; }
  /// Whether the masks of two bodies let them touch.
  bool may_touch(int slot_a, int slot_b) const {
    const BodyOptions a = options(slot_a), b = options(slot_b);
    return (a.category & b.collides_with) != 0 && (b.category & a.collides_with) != 0;
  }
  int handle(int slot) const { return was_packed() ? handles_[at(slot)] : slot; }
  std::span<const int> handles() const { return handles_; }  ///< ascending; empty: those of slots
  /// One a slot, since the last settle(). New, removed and otherwise used bodies have moved, and so
  /// have those with another reach.
  std::span<const BodyChange> changes() const { return changes_; }
  std::span<const double> reaches() const { return reaches_; }  ///< one a slot, m; empty: all 0
  double reach(int slot) const { return reaches_.empty() ? 0.0 : reaches_[at(slot)]; }
  /// Whether the masks of no two bodies can keep them apart.
  bool all_may_touch() const { return options_.empty(); }
  /// default_tolerance of any two bodies is no larger, m
  double largest_tolerance() const { return largest_tolerance_; }

  /// Slots that have changed since boxes_are_placed(): in a list, or, where they are
  /// many, among those that changes() names.
  bool many_to_place() const { return many_to_place_; }
  std::span<const int> to_place() const { return to_place_; }
  void boxes_are_placed();

  bool pack();    ///< true: bodies stand in other slots, and all boxes are to be placed
  void settle();  ///< changes are counted anew from here

 private:
  bool was_packed() const { return !slot_of_.empty(); }
  int given() const { return was_packed() ? static_cast<int>(slot_of_.size()) : slots(); }
  int find(int handle) const {  // -1: removed
    if (was_packed()) return slot_of_[at(handle)];
    return is_hole(handle) ? -1 : handle;
  }
  /// A shape and how many bodies have it.
  struct Owned {
    std::shared_ptr<const Shape> shape{};
    int users = 0;
  };
  BodyOptions options(int slot) const {
    return options_.empty() ? BodyOptions{} : options_[at(slot)];
  }
  const Shape* take(std::shared_ptr<const Shape> shape);
  void drop(const Shape* shape);
  void make_room();
  std::size_t most_to_place() const { return placements_.size() / 8 + 16; }
  void note_change(int slot, BodyChange change);

  std::map<const Shape*, Owned> owned_;
  double largest_tolerance_ = 0.0;  // m
  std::vector<int>
      slot_of_;  // of each handle ever given, -1: removed; empty until slots are packed
  std::vector<int> handles_;  // one a slot, empty until then
  // One a slot:
  std::vector<Placement> placements_;
  std::vector<const Shape*> shapes_;  // null: a hole
  std::vector<BodyOptions> options_;  // empty: all as by default
  std::vector<BodyChange> changes_;
  std::vector<double> reaches_;  // empty until one is set
  std::vector<int> to_place_;
  bool many_to_place_ = false;
  int present_ = 0;
};

}  // namespace quoin::geometry
