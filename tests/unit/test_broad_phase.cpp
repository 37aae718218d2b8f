#include <algorithm>
#include <limits>
#include <quoin/geometry/broad_phase.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using quoin::tests::Random;

bool near(const Box& a, const Box& b, double reach) {
  return (a.min - b.max).maxCoeff<Eigen::PropagateNaN>() <= reach &&
         (b.min - a.max).maxCoeff<Eigen::PropagateNaN>() <= reach;
}

std::vector<BlockPair> all_pairs(const std::vector<Box>& boxes, double reach,
                                 const std::vector<char>& idle) {
  std::vector<BlockPair> pairs;
  for (std::size_t a = 0; a < boxes.size(); ++a) {
    for (std::size_t b = a + 1; b < boxes.size(); ++b) {
      const bool both_idle = !idle.empty() && idle[a] != 0 && idle[b] != 0;
      if (!both_idle && near(boxes[a], boxes[b], reach))
        pairs.push_back({static_cast<int>(a), static_cast<int>(b)});
    }
  }
  return pairs;
}

std::vector<Box> random_boxes(Random& random, int count, double world) {
  std::vector<Box> boxes;
  for (int i = 0; i < count; ++i) {
    const Vector3 corner = random.point(0, world);
    const Vector3 extent(random.log_uniform(0.01, 2), random.log_uniform(0.01, 2),
                         random.log_uniform(0.01, 2));
    boxes.push_back({corner, corner + extent});
  }
  return boxes;
}

}  // namespace

TEST_CASE("broad phase: the pairs are those of trying all, whatever happened before") {
  Random random(11);
  for (const int count : {0, 1, 2, 15, 16, 17, 60, 200}) {
    std::vector<Box> boxes = random_boxes(random, count, 6.0);
    std::vector<char> idle(boxes.size(), 0);
    BroadPhase kept;
    for (int step = 0; step < 60; ++step) {
      const double reach = step < 20 ? 0.01 : (step < 40 ? 0.2 : random.log_uniform(1e-6, 1.0));
      const double speed = random.log_uniform(1e-5, 0.5);
      const bool all_move = random.chance(0.3);
      for (Box& box : boxes) {
        if (all_move || random.chance(0.1)) {
          const Vector3 move = speed * random.direction();
          box.min += move;
          box.max += move;
        }
      }
      for (char& flag : idle) flag = random.chance(0.3) ? 1 : 0;
      const std::vector<BlockPair> expected = all_pairs(boxes, reach, idle);
      REQUIRE(kept.find_candidates(boxes, reach, idle) == expected);
      BroadPhase fresh;
      REQUIRE(fresh.find_candidates(boxes, reach, idle) == expected);
    }
  }
}

TEST_CASE("broad phase: steady motion, jumps and resizing") {
  Random random(5);
  std::vector<Box> boxes = random_boxes(random, 120, 8.0);
  std::vector<Vector3> velocity;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    velocity.push_back(random.log_uniform(1e-3, 0.3) * random.direction());
  BroadPhase kept;
  for (int step = 0; step < 150; ++step) {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      boxes[i].min += velocity[i];
      boxes[i].max += velocity[i];
      if (random.chance(0.01)) {
        const Vector3 jump = 5.0 * random.direction();
        boxes[i] = {boxes[i].min + jump, boxes[i].max + 1.1 * jump.cwiseAbs() + jump};
      }
    }
    REQUIRE(kept.find_candidates(boxes, 0.05) == all_pairs(boxes, 0.05, {}));
  }
}

TEST_CASE("broad phase: exactly at reach counts, the next number beyond does not") {
  for (const int count : {2, 40}) {
    std::vector<Box> boxes;
    for (int i = 0; i < count; ++i)
      boxes.push_back({Vector3(0, 0, 4.0 * i), Vector3(1, 1, 4.0 * i + 1)});
    BroadPhase phase;
    CHECK(phase.find_candidates(boxes, 3.0).size() == static_cast<std::size_t>(count - 1));
    CHECK(phase.find_candidates(boxes, std::nextafter(3.0, 0.0)).empty());
    CHECK(phase.find_candidates(boxes, 0.0).empty());
  }
}

TEST_CASE("broad phase: far from the origin nothing is lost") {
  Random random(3);
  std::vector<Box> boxes = random_boxes(random, 80, 4.0);
  for (Box& box : boxes) {
    box.min += Vector3(1e8, -1e8, 5e7);
    box.max += Vector3(1e8, -1e8, 5e7);
  }
  BroadPhase phase;
  for (const double reach : {0.0, 1e-9, 1e-3})
    CHECK(phase.find_candidates(boxes, reach) == all_pairs(boxes, reach, {}));
}

TEST_CASE("broad phase: a box that is not finite meets nothing and spoils nothing") {
  Random random(7);
  std::vector<Box> boxes = random_boxes(random, 50, 3.0);
  BroadPhase phase;
  phase.find_candidates(boxes, 0.01);
  boxes[7].min.setConstant(std::numeric_limits<double>::quiet_NaN());
  boxes[7].max.setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<BlockPair> expected = all_pairs(boxes, 0.01, {});
  CHECK(phase.find_candidates(boxes, 0.01) == expected);
  CHECK(BroadPhase().find_candidates(boxes, 0.01) == expected);
  boxes[7] = boxes[8];
  CHECK(phase.find_candidates(boxes, 0.01) == all_pairs(boxes, 0.01, {}));
}

TEST_CASE("broad phase: flags that do not fit the boxes are refused") {
  const std::vector<Box> boxes(3);
  const std::vector<char> idle(2, 0);
  CHECK_THROWS_AS(BroadPhase().find_candidates(boxes, 0.0, idle), quoin::geometry::InputError);
}

TEST_CASE("broad phase: one that was moved from says so") {
  BroadPhase first;
  const BroadPhase second = std::move(first);
  CHECK(second.size() == 0);
  CHECK_THROWS_AS(first.size(), quoin::geometry::InputError);  // NOLINT: meant
  CHECK_THROWS_AS(first.set(0, Box{}), quoin::geometry::InputError);
  CHECK_THROWS_AS(first.find_candidates(0.0), quoin::geometry::InputError);
}

TEST_CASE("broad phase: boxes one at a time, that come, go, move, rest and jump") {
  using quoin::geometry::BoxUse;
  Random random(23);
  for (const Vector3& away : {Vector3(0, 0, 0), Vector3(1e6, -1e6, 1e6)}) {
    BroadPhase kept;
    std::vector<Box> boxes;
    std::vector<char> idle, present;
    for (int step = 0; step < 120; ++step) {
      const double share = step % 4 == 0 ? 0.5 : 0.02;
      const double speed = random.log_uniform(1e-4, 0.5);
      const int more = step == 0 ? 100 : random.chance(0.3) ? 5 : 0;
      for (int k = 0; k < more; ++k) {
        const Vector3 corner = away + random.point(0, 6);
        boxes.push_back({corner, corner + random.point(0.01, 1)});
        idle.push_back(random.chance(0.3) ? 1 : 0);
        present.push_back(1);
        kept.set(kept.size(), boxes.back(), idle.back() ? BoxUse::Idle : BoxUse::Moving);
      }
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const double fate = random.uniform();
        if (fate < 0.1 * share || (step == 60 && fate < 0.95)) {
          present[i] = 0;
          kept.remove(static_cast<int>(i));
        } else if (fate < share) {
          const Vector3 move = (random.chance(0.05) ? 4.0 : speed) * random.direction();
          boxes[i] = {boxes[i].min + move, boxes[i].max + move};
          if (random.chance(0.1)) idle[i] = static_cast<char>(1 - idle[i]);
          present[i] = 1;
          kept.set(static_cast<int>(i), boxes[i], idle[i] ? BoxUse::Idle : BoxUse::Moving);
        }
      }
      const double reach = step % 40 < 20 ? 0.01 : random.log_uniform(1e-4, 0.3);
      const double looser = reach + 1e-5;  // single precision, 10 m around the first box
      const auto all = [&](double limit) {
        std::vector<BlockPair> pairs = all_pairs(boxes, limit, idle);
        std::erase_if(pairs, [&](const BlockPair& pair) {
          return !present[static_cast<std::size_t>(pair.a)] ||
                 !present[static_cast<std::size_t>(pair.b)];
        });
        return pairs;
      };
      const std::vector<BlockPair> least = all(reach), most = all(looser);
      const std::vector<BlockPair>& found = kept.find_candidates(reach);
      REQUIRE(std::is_sorted(found.begin(), found.end()));
      REQUIRE(std::includes(found.begin(), found.end(), least.begin(), least.end()));
      REQUIRE(std::includes(most.begin(), most.end(), found.begin(), found.end()));
    }
  }
}

TEST_CASE("broad phase: boxes that single precision cannot hold lose no pair") {
  for (const double size : {1e-60, 1e-42, 1e35, 1e60}) {
    std::vector<Box> boxes;
    for (int i = 0; i < 40; ++i)
      boxes.push_back({size * Vector3(i, 0, 0), size * Vector3(i + 1, 1, 1)});
    BroadPhase phase;
    for (int step = 0; step < 3; ++step)
      CHECK(phase.find_candidates(boxes, 0.0) == all_pairs(boxes, 0.0, {}));
    CHECK(phase.find_candidates(boxes, 1e300).size() == 40 * 39 / 2);
  }
}
