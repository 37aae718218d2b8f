/// B: the whole ContactFinder::find() of walls of bricks, warm, a small motion each step: against
/// its parts, on one thread and two, with the allocations after the first steps. Bricks with joints
/// that shift, or turn as well; and a wall of three leaves whose bricks touch exactly. And the
/// bytes that the finder holds.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/contact_finder.hpp>
#include <sstream>
#include <utility>

#include "allocations.hpp"
#include "boxes_peer.hpp"
#include "harness.hpp"
#include "walls.hpp"

namespace quoin::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kJoint = 1e-5;      // m, between the bricks
constexpr double kAmplitude = 2e-6;  // m a step
constexpr double kTurn = 2e-6;       // rad a step
constexpr double kReach = 1e-4;      // m
constexpr int kSettle = 6;           // steps before timing starts

double nanoseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

bool same_bits(const std::vector<geometry::ContactPoint>& x,
               const std::vector<geometry::ContactPoint>& y) {
  if (x.size() != y.size()) return false;
  for (std::size_t k = 0; k < x.size(); ++k)
    if (x[k].key != y[k].key || std::memcmp(&x[k].gap, &y[k].gap, sizeof(double)) != 0 ||
        std::memcmp(x[k].point_a.data(), y[k].point_a.data(), 3 * sizeof(double)) != 0)
      return false;
  return true;
}

std::shared_ptr<const geometry::Shape> shape_of(const Wall& wall) {
  return std::make_shared<const geometry::Shape>(wall.shape().topology, wall.shape().vertices);
}

geometry::Box box_of(const geometry::Body& body) {
  geometry::Box box{body.vertex(0), body.vertex(0)};
  for (int v = 1; v < body.shape().vertex_count(); ++v) {
    box.min = box.min.cwiseMin(body.vertex(v));
    box.max = box.max.cwiseMax(body.vertex(v));
  }
  return box;
}

/// One pass over all placements of the scene, as find() cannot do without.
double placement_pass(const std::vector<geometry::Placement>& placements) {
  double sum = 0.0;
  for (const geometry::Placement& placement : placements)
    sum += placement.linear.sum() + placement.translation.sum();
  return sum;
}

/// Two workers one after the other on the caller's thread: what the two would take on cores of
/// their own is shown by the clock of that thread, whatever else the machine does.
class InTurns final : public geometry::Executor {
 public:
  int workers() const override { return 2; }
  void run(Task task, void* context) override {
    std::array<double, 2> seconds{};
    for (int worker = 0; worker < 2; ++worker) {
      const double start = thread_seconds();
      task(context, worker);
      seconds[static_cast<std::size_t>(worker)] = thread_seconds() - start;
    }
    hidden_ += std::min(seconds[0], seconds[1]);
  }
  /// Of the shorter parts since the last call, s.
  double take_hidden() { return std::exchange(hidden_, 0.0); }

 private:
  double hidden_ = 0.0;
};

/// Each way of working takes its turn at every step of the same moving wall.
class WallRun {
 public:
  WallRun(const WallOptions& options, const std::string& name)
      : wall_(options), brick_(shape_of(wall_)), placements_(wall_.size()) {
    for (const char* peer : {"find", "find 2 threads", "pairs alone", "candidates alone",
                             "placements once", "moving the bricks", "2 workers in turns"})
      entries_.push_back({.workload = name, .peer = peer});
#ifdef QUOIN_BENCH_BULLET
    entries_.push_back({.workload = name, .peer = "Bullet's collision step"});
    for (std::size_t i = 0; i < wall_.size(); ++i) placements_[i] = wall_.placement(i, 0);
    // Bullet lists points of boxes that overlap alone: these do by as much as others are apart.
    const geometry::Vector3 size = options.brick + geometry::Vector3::Constant(options.joint);
    bullet_ = std::make_unique<BulletCollisionStep>(size, placements_);
#endif
    boxes_.resize(wall_.size());
    bodies_.assign(wall_.size(), geometry::Body(*brick_));
    for (std::size_t i = 0; i < wall_.size(); ++i) {
      finder_.add(brick_, wall_.placement(i, 0));
      finder_2_.add(brick_, wall_.placement(i, 0));
      finder_in_turns_.add(brick_, wall_.placement(i, 0));
    }
  }

  std::vector<Entry> run(int steps) {
    for (int step = 0; step < kSettle + steps; ++step) {
      if (step == kSettle) {
        for (Entry& entry : entries_) entry.nanoseconds.clear();
        allocations_ = 0;
      }
      advance(step);
    }
    for (Entry& entry : entries_) {
      entry.pairs = static_cast<int>(pair_count_);
      entry.note = "ns a pair";
    }
    entries_[0].note += ", " + std::to_string(one_.size()) + " contacts, " +
                        std::to_string(allocations_) + " allocations after the first steps";
    entries_[6].note += ", the longer of two parts and what is in series";
    entries_[1].note += different_ ? ", other bits than one thread" : ", same bits";
    return entries_;
  }

 private:
  /// Two threads are timed by the clock on the wall, everything else by the thread's own.
  template <class Work>
  void time(std::size_t entry, Work&& work) {
    const auto start = Clock::now();
    const double thread_start = thread_seconds();
    work();
    const double thread_time = 1e9 * (thread_seconds() - thread_start);
    entries_[entry].nanoseconds.push_back(entry == 1 ? nanoseconds_since(start) : thread_time);
  }

  void move(geometry::ContactFinder& finder) const {
    for (std::size_t i = 0; i < placements_.size(); ++i)
      finder.move(static_cast<int>(i), placements_[i]);
  }

  void advance(int step) {
    for (std::size_t i = 0; i < wall_.size(); ++i) placements_[i] = wall_.placement(i, step);
    move(finder_2_);
    move(finder_in_turns_);
    time(5, [&] { move(finder_); });
    time(0, [&] {
      const long before = allocation_count();
      finder_.find(one_);
      allocations_ += allocation_count() - before;
    });
    time(1, [&] { finder_2_.find(two_); });
    time(6, [&] { finder_in_turns_.find(two_in_turns_); });
    entries_[6].nanoseconds.back() -= 1e9 * in_turns_.take_hidden();
    different_ = different_ || !same_bits(one_, two_);
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      bodies_[i].move(placements_[i]);
      boxes_[i] = box_of(bodies_[i]);
    }
    const std::vector<geometry::BlockPair>* pairs = nullptr;
    time(3, [&] { pairs = &broad_phase_.find_candidates(boxes_, kReach); });
    pair_count_ = pairs->size();
    hints_.resize(pairs->size());
    time(2, [&] { search(*pairs); });
#ifdef QUOIN_BENCH_BULLET
    time(7, [&] { bullet_->step(placements_); });
#endif
    double sum = 0.0;
    time(4, [&] { sum = placement_pass(placements_); });
    benchmark::DoNotOptimize(sum);
    for (Entry& entry : entries_) entry.nanoseconds.back() /= static_cast<double>(pair_count_);
  }

  /// What the finder does with each pair, one after the other and without the rest.
  void search(const std::vector<geometry::BlockPair>& pairs) {
    points_.clear();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const geometry::Body& a = bodies_[static_cast<std::size_t>(pairs[k].a)];
      const geometry::Body& b = bodies_[static_cast<std::size_t>(pairs[k].b)];
      hints_[k] = append_contacts_within_reach({pairs[k].a, pairs[k].b}, a, b, {.reach = kReach},
                                               hints_[k], points_)
                      .hint;
    }
  }

  Wall wall_;
  std::shared_ptr<const geometry::Shape> brick_;
  std::vector<geometry::Placement> placements_;
  std::vector<geometry::Body> bodies_;
  geometry::ContactFinder finder_{{.reach = kReach}};
  geometry::ContactFinder finder_2_{{.reach = kReach, .threads = 2}};
  InTurns in_turns_;
  geometry::ContactFinder finder_in_turns_{{.reach = kReach, .executor = &in_turns_}};
#ifdef QUOIN_BENCH_BULLET
  std::unique_ptr<BulletCollisionStep> bullet_;
#endif
  geometry::BroadPhase broad_phase_;
  std::vector<geometry::Box> boxes_;
  std::vector<geometry::FeatureHint> hints_;
  std::vector<geometry::ContactPoint> one_, two_, two_in_turns_, points_;
  std::vector<Entry> entries_;
  std::size_t pair_count_ = 0;
  long allocations_ = 0;
  bool different_ = false;
};

/// Bricks of a running bond with joints; `turn` rad a step.
WallOptions jointed(int count, double turn) {
  return {.count = count, .joint = kJoint, .shift = kAmplitude, .turn = turn};
}

/// A wall askew, with joints wider than the reach: boxes meet, no bricks are in contact.
WallOptions apart(int count) {
  return {.count = count,
          .leaves = 3,
          .joint = 20 * kReach,
          .shift = kAmplitude,
          .turn = kTurn,
          .heading = 0.6};
}

/// Three leaves of bricks whose sides are powers of two, so that they touch exactly at faces, edges
/// and vertices; the wall is carried along by whole bits, and each brick shaken by `noise` m, rad.
WallOptions touching(double noise) {
  return {.count = 1000,
          .leaves = 3,
          .brick = {0.5, 0.25, 0.25},
          .shift = noise,
          .turn = noise,
          .carry = 0x1p-12};
}

/// The time of a finder that works alone on a moving wall, and the bytes that it holds, its list of
/// contacts left out.
std::vector<Entry> memory_of(const WallOptions& options, const std::string& name, int steps) {
  const Wall wall(options);
  const auto brick = shape_of(wall);
  std::vector<geometry::ContactPoint> contacts;
  const long before = bytes_in_use();
  geometry::ContactFinder finder({.reach = kReach});
  for (std::size_t i = 0; i < wall.size(); ++i) finder.add(brick, wall.placement(i, 0));
  Entry entry{.workload = name, .peer = "find"};
  for (int step = 0; step < kSettle + steps; ++step) {
    if (step == kSettle) entry.nanoseconds.clear();
    for (std::size_t i = 0; i < wall.size(); ++i)
      finder.move(static_cast<int>(i), wall.placement(i, step));
    const double start = thread_seconds();
    entry.pairs = finder.find(contacts).candidates;
    entry.nanoseconds.push_back(1e9 * (thread_seconds() - start) / entry.pairs);
  }
  const auto list = static_cast<long>(contacts.capacity() * sizeof(geometry::ContactPoint));
  const long bytes = (bytes_in_use() - before - list) / static_cast<long>(wall.size());
  entry.note = "ns a pair, " + std::to_string(bytes) + " bytes a brick";
  return {entry};
}

/// Moves and lists of a finder that works alone on a moving wall, for callgrind.
std::vector<Entry> count_find(const WallOptions& options, const std::string& name) {
  constexpr int kCounted = 10;
  const Wall wall(options);
  const auto brick = shape_of(wall);
  geometry::ContactFinder finder({.reach = kReach});
  for (std::size_t i = 0; i < wall.size(); ++i) finder.add(brick, wall.placement(i, 0));
  std::vector<geometry::ContactPoint> contacts;
  std::size_t candidates = 0;
  const auto step = [&](int number) {
    for (std::size_t i = 0; i < wall.size(); ++i)
      finder.move(static_cast<int>(i), wall.placement(i, number));
    return static_cast<std::size_t>(finder.find(contacts).candidates);
  };
  for (int k = 0; k < kSettle; ++k) step(k);
  counted([&] {
    for (int k = 0; k < kCounted; ++k) candidates += step(kSettle + k);
  });
  print_counted(name, "find", candidates);
  return {};
}

std::string short_name(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) {
  using namespace quoin::bench;
  std::vector<Contest> contests;
  const auto add = [&](const std::string& name, const WallOptions& options) {
    const auto run = [options, name](const Arguments& arguments) {
      if (arguments.count == "find") return count_find(options, name);
      return WallRun(options, name).run(arguments.quick ? 5 : options.count >= 100000 ? 15 : 41);
    };
    contests.push_back({name, "find", run, options.count > 10000, true});
  };
  for (const int count : {1000, 10000, 100000}) {
    add("B/find-" + std::to_string(count), jointed(count, 0.0));
    add("B/turning-" + std::to_string(count), jointed(count, kTurn));
  }
  for (const double tilt : {1e-9, 1e-6, 1e-3, 1e-2})
    add("B/tilted-" + short_name(tilt), jointed(1000, tilt));
  for (const int count : {1000, 100000}) add("B/apart-" + std::to_string(count), apart(count));
  for (const int count : {10000, 100000, 1000000}) {
    const std::string name = "B/memory-" + std::to_string(count);
    const auto run = [=](const Arguments& arguments) {
      return memory_of(jointed(count, 0.0), name, arguments.quick ? 1 : 15);
    };
    contests.push_back({name, "find", run, true});
  }
  for (const double noise : {0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9})
    add("B/touching-" + short_name(noise), touching(noise));
  return run_contests(argc, argv, contests);
}
