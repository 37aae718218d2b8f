#include "finder/point_history.hpp"

#include <limits>

namespace quoin::geometry {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

}  // namespace

void PointHistory::make_room(std::size_t places) {
  const std::size_t size = points_.size() + places;
  if (size > points_.capacity()) points_.reserve(size + points_.size() / 8);
}

HistorySlot PointHistory::take(std::size_t count) {
  const std::size_t half = (count + 1) / 2;
  const auto room = static_cast<int>(2 * half);
  if (half < unused_slots_.size() && unused_slots_[half].bits != kNone) {
    const HistorySlot slot{static_cast<int>(unused_slots_[half].bits), room};
    unused_slots_[half] = points(slot, 1).front().feature_a;
    unused_ -= 2 * half;
    return slot;
  }
  const HistorySlot slot{static_cast<int>(points_.size()), room};
  make_room(2 * half);
  points_.resize(points_.size() + 2 * half);
  return slot;
}

void PointHistory::give_back(const HistorySlot& slot) {
  if (slot.room == 0) return;
  const auto room = static_cast<std::size_t>(slot.room), half = room / 2;
  PackedFeature none;
  none.bits = kNone;
  if (unused_slots_.size() <= half) unused_slots_.resize(half + 1, none);
  points(slot, 1).front().feature_a = unused_slots_[half];
  unused_slots_[half].bits = static_cast<std::uint32_t>(slot.first);
  unused_ += room;
}

void PointHistory::clear() { *this = PointHistory(); }

}  // namespace quoin::geometry
