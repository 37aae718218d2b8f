/// B: candidate pairs of walls of 1e3, 1e4, 1e5 bricks, a small motion each step.

#include <algorithm>
#include <cstdio>
#include <quoin/geometry/broad_phase.hpp>

#include "boxes_peer.hpp"
#include "harness.hpp"
#include "walls.hpp"

namespace quoin::bench {
namespace {

constexpr int kSteps = 60;

class QuoinBoxes final : public BoxesPeer {
 public:
  using BoxesPeer::BoxesPeer;
  void load(std::span<const geometry::Box> boxes) override {
    broad_phase_ = {};
    broad_phase_.find_candidates(boxes, 0.0);
  }
  std::size_t step(std::span<const geometry::Box> boxes) override {
    return broad_phase_.find_candidates(boxes, 0.0).size();
  }

 private:
  geometry::BroadPhase broad_phase_;
};

BoxesPeers make_peers() {
  BoxesPeers peers;
  peers.push_back(std::make_unique<QuoinBoxes>("quoin"));
#ifdef QUOIN_BENCH_FCL
  append_fcl(peers);
#endif
#ifdef QUOIN_BENCH_BULLET
  append_bullet(peers);
#endif
  return peers;
}

std::vector<geometry::Box> boxes_at(const Wall& wall, int step) {
  std::vector<geometry::Box> boxes(wall.size());
  for (std::size_t i = 0; i < wall.size(); ++i) boxes[i] = wall.box(i, step);
  return boxes;
}

/// Peers take turns at every step; each entry gets one number: the mean over the coherent run. The
/// first step is not timed: Bullet puts off to it what loading began.
std::vector<Entry> run_wall(int count, Motion motion, const std::string& name, int runs) {
  const double shift = 1e-3 * 2 * Vector3(0.2, 0.1, 0.1).norm();
  const Wall wall({.count = count, .motion = motion, .shift = shift});
  BoxesPeers peers = make_peers();
  std::vector<Entry> entries;
  for (const auto& peer : peers) entries.push_back({.workload = name, .peer = peer->name()});
  std::vector<std::size_t> pairs(peers.size());
  for (int run = 0; run < runs; ++run) {
    std::vector<std::vector<double>> seconds(peers.size());
    for (const auto& peer : peers) peer->load(boxes_at(wall, 0));
    for (int step = 1; step <= kSteps; ++step) {
      const std::vector<geometry::Box> boxes = boxes_at(wall, step);
      for (std::size_t p = 0; p < peers.size(); ++p) {
        const double start = thread_seconds();
        pairs[p] = peers[p]->step(boxes);
        if (step > 1) seconds[p].push_back(thread_seconds() - start);
      }
    }
    for (std::size_t p = 0; p < peers.size(); ++p) {
      double sum = 0.0;
      for (const double s : seconds[p]) sum += s;
      const double a_step = sum / static_cast<double>(seconds[p].size());
      entries[p].nanoseconds.push_back(1e9 * a_step / static_cast<double>(wall.size()));
    }
  }
  for (std::size_t p = 0; p < peers.size(); ++p) {
    entries[p].pairs = static_cast<int>(wall.size());
    entries[p].note = std::to_string(pairs[p]) + " pairs listed at the end";
  }
  return entries;
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) {
  using namespace quoin::bench;
  std::vector<Contest> contests;
  for (const int count : {1000, 10000, 100000}) {
    for (const auto& [motion, word] :
         {std::pair{Motion::Jitter, "jitter"}, {Motion::Drift, "drift"}}) {
      const std::string name = "B/broad-" + std::string(word) + "-" + std::to_string(count);
      const auto run = [count, motion = motion, name](const Arguments& arguments) {
        return run_wall(count, motion, name, arguments.quick ? 3 : count >= 100000 ? 3 : 15);
      };
      contests.push_back({name, "Bullet dbvt", run, count > 10000});
    }
  }
  return run_contests(argc, argv, contests);
}
