/// The points of the last call: a slot a pair, given back and taken again.

#include "geometry/src/finder/point_history.hpp"

#include <array>
#include <map>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using quoin::geometry::HistorySlot;
using quoin::geometry::PointHistory;
using quoin::geometry::TrackedPoint;
using quoin::tests::Random;

void write(PointHistory& history, const HistorySlot& slot, std::size_t count, double value) {
  for (TrackedPoint& point : history.points(slot, count)) point.place.setConstant(value);
}

}  // namespace

TEST_CASE("point history: slots that come and go keep their points apart") {
  Random random(61);
  PointHistory history;
  std::array<HistorySlot, 200> slots;
  std::array<std::size_t, 200> counts{};
  for (int step = 0; step < 5000; ++step) {
    const auto i = static_cast<std::size_t>(random.integer(0, 199));
    history.give_back(slots[i]);
    counts[i] = static_cast<std::size_t>(random.integer(0, 9));
    slots[i] = counts[i] == 0 ? HistorySlot{} : history.take(counts[i]);
    REQUIRE(static_cast<std::size_t>(slots[i].room) >= counts[i]);
    REQUIRE(static_cast<std::size_t>(slots[i].room) <= counts[i] + 1);
    write(history, slots[i], counts[i], static_cast<double>(i));
    std::size_t places = 0;
    for (const HistorySlot& slot : slots) places += static_cast<std::size_t>(slot.room);
    REQUIRE(history.used() == places);
  }
  for (std::size_t i = 0; i < slots.size(); ++i) {
    for (const TrackedPoint& point : history.points(slots[i], counts[i])) {
      REQUIRE(point.place.x() == static_cast<double>(i));
    }
  }
}

TEST_CASE("point history: what is given back is taken again, and does not grow") {
  PointHistory history;
  history.give_back(HistorySlot{});
  CHECK(history.used() == 0);
  std::map<int, int> rooms;  // by where they begin
  for (const std::size_t count : {4, 3, 1, 8, 4}) {
    const HistorySlot slot = history.take(count);
    rooms[slot.first] = slot.room;
  }
  CHECK_FALSE(history.is_wasteful());
  for (const auto& [first, room] : rooms) history.give_back({first, room});
  CHECK(history.used() == 0);
  CHECK(history.is_wasteful());
  for (const std::size_t count : {8, 4, 4, 4, 2}) {
    const HistorySlot slot = history.take(count);
    REQUIRE(rooms.count(slot.first) == 1);
    CHECK(rooms[slot.first] == slot.room);
    rooms.erase(slot.first);
  }
  CHECK(rooms.empty());
  CHECK(history.take(2).first == 22);
  history.clear();
  CHECK(history.take(2).first == 0);
}
