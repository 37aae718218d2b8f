/// The pairs of W3 asked for nearest features with last step's hints, one by one and in one call of
/// update_nearest_features: bodies by the places of their vertices in the world, a shape each, and
/// as a few shared shapes and placements. Medians over the steps, ns a pair; the ways take turns.
///
///     bench_distance_batch [box|16|32|64|128] [pairs] [what the way's name has in it]

#include <chrono>
#include <cmath>
#include <cstdio>
#include <quoin/geometry/distance_batch.hpp>

#include "guarded_main.hpp"
#include "harness.hpp"
#include "workloads.hpp"

namespace quoin::bench {
namespace {

using geometry::Body;
using geometry::NearestFeatures;
using geometry::Shape;

constexpr int kDrawn = 200, kUsual = 32, kSteps = 25;  // kUsual: pairs of W3
constexpr int kLeastRounds = 2, kQuestions = 400'000;  // of each way, about

/// More pairs than were drawn repeat these.
class Crowd {
 public:
  Crowd(const Workload& workload, int count, bool in_world)
      : workload_(workload), count_(count), in_world_(in_world) {
    for (const BenchShape& shape : workload.shapes) {
      shapes_.emplace_back(shape.topology, shape.vertices);
    }
    if (in_world) world_.reserve(2 * static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) {
      for (const int shape : {pair(k).shape_a, pair(k).shape_b}) {
        const Shape& own = shapes_[static_cast<std::size_t>(shape)];
        if (in_world) world_.push_back(own);
        bodies.emplace_back(in_world ? world_.back() : own);
      }
      pairs.push_back({2 * k, 2 * k + 1});
    }
  }
  void place(int step) {
    const auto s = static_cast<std::size_t>(step);
    for (int k = 0; k < count_; ++k) {
      const auto a = 2 * static_cast<std::size_t>(k);
      place(a, pair(k).shape_a, pair(k).poses_a[s]);
      place(a + 1, pair(k).shape_b, pair(k).poses_b[s]);
    }
  }
  const Pair& pair(int k) const {
    return workload_.pairs[static_cast<std::size_t>(k) % workload_.pairs.size()];
  }

  std::vector<Body> bodies{};
  std::vector<geometry::BlockPair> pairs{};

 private:
  void place(std::size_t body, int shape, const Pose& pose) {
    if (!in_world_) return bodies[body].move({pose.rotation, pose.place});
    world_[body].set_vertices(
        pose.apply(workload_.shapes[static_cast<std::size_t>(shape)].vertices));
    bodies[body] = Body(world_[body]);
  }
  const Workload& workload_;
  int count_;
  bool in_world_;
  std::vector<Shape> shapes_{}, world_{};
};

struct Way {
  const char* name;
  Crowd* crowd;
  bool batch;
  std::vector<NearestFeatures> answers{};
  std::vector<double> nanoseconds{};
  int wrong = 0;

  void ask() {
    if (batch) return update_nearest_features(crowd->bodies, crowd->pairs, answers);
    for (std::size_t k = 0; k < answers.size(); ++k) {
      answers[k] =
          nearest_features(crowd->bodies[2 * k], crowd->bodies[2 * k + 1], {}, answers[k].hint);
    }
  }
  void ask_at(const Workload& workload, int step) {
    const auto start = std::chrono::steady_clock::now();
    ask();
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
    for (std::size_t k = 0; k < answers.size(); ++k) {
      const Pair& pair = crowd->pair(static_cast<int>(k));
      const double error = std::abs(answers[k].gap - pair.gap[static_cast<std::size_t>(step)]);
      wrong += !(error <= workload.allowed_error(pair, step));
    }
    if (step > 0) nanoseconds.push_back(taken.count() / static_cast<double>(answers.size()));
  }
};

void run(const std::string& family, int count, const std::string& wanted) {
  const Workload workload =
      make_workload("W3/" + family, {static_cast<double>(kDrawn) / kUsual, kSteps});
  Crowd world(workload, count, true), placed(workload, count, false);
  std::vector<Way> ways{{"alone, world vertices", &world, false},
                        {"batch, world vertices", &world, true},
                        {"alone, placements", &placed, false},
                        {"batch, placements", &placed, true}};
  std::erase_if(ways, [&](const Way& way) {
    return std::string(way.name).find(wanted) == std::string::npos;
  });
  for (Way& way : ways) way.answers.resize(world.pairs.size());
  const int rounds = std::max(kLeastRounds, kQuestions / kSteps / count);
  for (int round = 0; round < rounds; ++round) {
    for (int step = 0; step < kSteps; ++step) {
      world.place(step);
      placed.place(step);
      for (std::size_t k = 0; k < ways.size(); ++k) {
        ways[(k + static_cast<std::size_t>(step)) % ways.size()].ask_at(workload, step);
      }
    }
  }
  std::printf("%s, %d pairs, %d rounds of %d steps\n", family.c_str(), count, rounds, kSteps);
  for (const Way& way : ways) {
    std::printf("  %-24s %7.1f ns, least %7.1f, wrong %d\n", way.name, median(way.nanoseconds),
                quantile(way.nanoseconds, 0.0), way.wrong);
  }
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) {
  return quoin::bench::guarded(argv[0], [&] {
    const int count = argc > 2 ? std::stoi(argv[2]) : 200;
    if (count < 1) throw std::invalid_argument("pairs: " + std::to_string(count) + ", at least 1");
    quoin::bench::run(argc > 1 ? argv[1] : "box", count, argc > 3 ? argv[3] : "");
  });
}
