/// B: the whole ContactFinder::find() of walls of 1e3, 1e4, 1e5 bricks, warm, a small motion each
/// step: against its parts, on one thread and two, with the allocations after the first step.

#include <chrono>
#include <cstdio>
#include <cstring>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/geometry/contact_finder.hpp>

#include "allocations.hpp"
#include "harness.hpp"
#include "walls.hpp"

namespace quoin::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kJoint = 1e-5;      // m, between the bricks
constexpr double kAmplitude = 2e-6;  // m a step
constexpr double kReach = 1e-4;      // m
constexpr int kSettle = 6;           // steps before timing starts

double nanoseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

bool same_bits(const std::vector<geometry::ContactPoint>& x,
               const std::vector<geometry::ContactPoint>& y) {
  if (x.size() != y.size()) return false;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (x[k].key != y[k].key || std::memcmp(&x[k].gap, &y[k].gap, sizeof(double)) != 0 ||
        std::memcmp(x[k].point_a.data(), y[k].point_a.data(), 3 * sizeof(double)) != 0) {
      return false;
    }
  }
  return true;
}

/// One pass over all vertices of the scene.
double vertex_pass(const std::vector<geometry::Shape>& solids) {
  double sum = 0.0;
  for (const geometry::Shape& solid : solids) {
    const Points& v = solid.vertices();
    for (Eigen::Index k = 0; k < v.size(); ++k) sum += v.data()[k];
  }
  return sum;
}

/// Each way of working takes its turn at every step of the same moving wall.
class WallRun {
 public:
  WallRun(int count, const std::string& name)
      : wall_(count, Motion::Jitter, kJoint, kAmplitude),
        brick_(wall_.shape()),
        solids_(wall_.solids()) {
    for (const char* peer : {"find", "find 2 threads", "pairs alone", "candidates alone",
                             "vertices once", "placing the bricks"}) {
      entries_.push_back({.workload = name, .peer = peer});
    }
    boxes_.resize(wall_.size());
    for (std::size_t i = 0; i < wall_.size(); ++i) {
      const geometry::Placement placement{.translation = wall_.place(i, 0)};
      bodies_.emplace_back(*brick_, placement);
      finder_.add(brick_, placement);
      finder_2_.add(brick_, placement);
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

  void advance(int step) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      bodies_[i].move({.translation = wall_.place(i, step)});
      finder_2_.move(static_cast<int>(i), bodies_[i].placement());
    }
    time(5, [&] {
      for (std::size_t i = 0; i < bodies_.size(); ++i) {
        finder_.move(static_cast<int>(i), bodies_[i].placement());
      }
    });
    time(0, [&] {
      const long before = allocation_count();
      finder_.find(one_);
      allocations_ += allocation_count() - before;
    });
    time(1, [&] { finder_2_.find(two_); });
    different_ = different_ || !same_bits(one_, two_);
    for (std::size_t i = 0; i < boxes_.size(); ++i) boxes_[i] = wall_.box(i, step);
    const std::vector<geometry::BlockPair>* pairs = nullptr;
    time(3, [&] { pairs = &broad_phase_.find_candidates(boxes_, kReach); });
    pair_count_ = pairs->size();
    hints_.resize(pairs->size());
    time(2, [&] { search(*pairs); });
    double sum = 0.0;
    time(4, [&] { sum = vertex_pass(solids_); });
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
  std::vector<geometry::Body> bodies_;
  std::vector<geometry::Shape> solids_;  // at step 0
  geometry::ContactFinder finder_{{.reach = kReach}};
  geometry::ContactFinder finder_2_{{.reach = kReach, .threads = 2}};
  geometry::BroadPhase broad_phase_;
  std::vector<geometry::Box> boxes_;
  std::vector<geometry::FeatureHint> hints_;
  std::vector<geometry::ContactPoint> one_, two_, points_;
  std::vector<Entry> entries_;
  std::size_t pair_count_ = 0;
  long allocations_ = 0;
  bool different_ = false;
};

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) {
  using namespace quoin::bench;
  std::vector<Contest> contests;
  for (const int count : {1000, 10000, 100000}) {
    const std::string name = "B/find-" + std::to_string(count);
    const auto run = [count, name](const Arguments& arguments) {
      return WallRun(count, name).run(arguments.quick ? 5 : count >= 100000 ? 15 : 41);
    };
    contests.push_back({name, "find", run, count > 10000});
  }
  return run_contests(argc, argv, contests);
}
