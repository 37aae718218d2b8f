#pragma once
/// The contact points of pairs as the next call is to see them: one list, in which each pair has a
/// slot of its own. Internal.

#include <span>
#include <vector>

#include "contact/contact_tracking.hpp"

namespace quoin::geometry {

/// Where the points of one pair stand: `room` places from `first` on; no room: nowhere.
struct HistorySlot {
  int first = 0, room = 0;
};

/// A slot that is given back serves the next pair that asks for as many places. Workers may write
/// to slots of different pairs at the same time; all else is for one thread.
class PointHistory {
 public:
  std::span<TrackedPoint> points(const HistorySlot& slot, std::size_t count) {
    return std::span(points_).subspan(static_cast<std::size_t>(slot.first), count);
  }
  /// So that slots with so many places in all can be taken without further ado.
  void make_room(std::size_t places);
  /// Room for at least `count` points.
  HistorySlot take(std::size_t count);
  void give_back(const HistorySlot& slot);
  /// Whether more than half of it is in no slot: it had better be made anew.
  bool is_wasteful() const { return 2 * unused_ > points_.size(); }
  std::size_t used() const { return points_.size() - unused_; }  ///< places in slots
  void clear();

 private:
  std::vector<TrackedPoint> points_;
  /// Of the slots with 2 k places that nobody has, the first; it names the next one, as a feature.
  std::vector<PackedFeature> unused_slots_;
  std::size_t unused_ = 0;  // places in these
};

}  // namespace quoin::geometry
