/// Several processes that solve together, each with the contacts of its own blocks: what they come
/// to is what one comes to, to the bit. Threads stand for the processes.

#include <barrier>
#include <functional>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <quoin/solver/parts.hpp>
#include <sstream>
#include <thread>

#include "solver/src/distributed/distributed_solver.hpp"
#include "support/catch.hpp"
#include "support/sanitized.hpp"

using namespace quoin::solver;
using quoin::tests::unless_sanitized;
namespace geometry = quoin::geometry;

namespace {

/// What the threads tell each other.
class Table {
 public:
  explicit Table(int count) : told_(static_cast<std::size_t>(count)), all_here_(count) {}

  std::vector<char> of_all(int rank, std::span<const char> mine) {
    told_[static_cast<std::size_t>(rank)].assign(mine.begin(), mine.end());
    all_here_.arrive_and_wait();
    std::vector<char> all;
    for (const std::vector<char>& part : told_) all.insert(all.end(), part.begin(), part.end());
    all_here_.arrive_and_wait();
    return all;
  }
  /// The others do not wait for this one any more.
  void leave() { all_here_.arrive_and_drop(); }

 private:
  std::vector<std::vector<char>> told_;
  std::barrier<> all_here_;
};

/// Systems as small as these are solved by each process.
class Process : public DistributedSolver {
 public:
  Process(int rank, int count, std::vector<int> rank_of_block, Table& table)
      : rank_(rank), count_(count), rank_of_block_(std::move(rank_of_block)), table_(table) {}
  int rank() const override { return rank_; }
  int count() const override { return count_; }
  int rank_of(int block) const override { return rank_of_block_[static_cast<std::size_t>(block)]; }
  std::vector<char> of_all(std::span<const char> mine) const override {
    return table_.of_all(rank_, mine);
  }
  bool factorize(const BlockSystem&, const Slots&, LinearSolverKind) override { return false; }
  bool solve(const BlockVector&, BlockVector&, LinearSolverCounts&) override { return false; }

 private:
  int rank_, count_;
  std::vector<int> rank_of_block_;
  Table& table_;
};

struct Outcome {
  State state;
  StepReport last;
  std::vector<Contact> contacts;
  bool flagged = false;
  std::string error;
};

Outcome run(const Scene& scene, const StepOptions& options, int steps) {
  Outcome outcome;
  Simulation simulation(scene, options);
  for (int step = 0; step < steps; ++step) {
    outcome.last = simulation.advance();
    outcome.flagged = outcome.flagged || outcome.last.flags.begin() != outcome.last.flags.end();
  }
  outcome.state = simulation.state();
  outcome.contacts = simulation.all_contacts([](const Contact&) { return true; });
  return outcome;
}

std::vector<Outcome> run_shared(const Scene& scene, const StepOptions& options, int steps,
                                int count) {
  Table table(count);
  std::vector<Outcome> outcomes(static_cast<std::size_t>(count));
  std::vector<std::thread> threads;
  for (int rank = 0; rank < count; ++rank) {
    threads.emplace_back([&, rank, own = options]() mutable {
      Outcome& outcome = outcomes[static_cast<std::size_t>(rank)];
      own.distributed_solver =
          std::make_shared<Process>(rank, count, parts_of_blocks(scene, count), table);
      try {
        outcome = run(scene, own, steps);
      } catch (const std::exception& error) {
        outcome.error = error.what();
        table.leave();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  return outcomes;
}

/// Contacts that an attempt found too late stand elsewhere in the list of all than in that of one
/// process: the proximal Newton method, and sums of energy, are then the same to rounding.
enum class Same { Bits, ToRounding };

struct Comparison {
  Same same;
  bool operator()(const auto& one, const auto& other) const {
    return same == Same::Bits ? one == other : (one - other).norm() <= 1e-9 * (1.0 + one.norm());
  }
  bool operator()(double one, double other) const {
    return same == Same::Bits ? one == other
                              : std::abs(one - other) <= 1e-9 * (1.0 + std::abs(one));
  }
};

void check_same(const State& one, const State& other, const Comparison& same) {
  REQUIRE(one.blocks.size() == other.blocks.size());
  for (std::size_t b = 0; b < one.blocks.size(); ++b) {
    const BlockState &x = one.blocks[b], &y = other.blocks[b];
    INFO("block " << b);
    CHECK(same(x.centroid, y.centroid));
    CHECK(same(x.rotation.coeffs(), y.rotation.coeffs()));
    CHECK(same(x.strain, y.strain));
    CHECK(same(x.velocity, y.velocity));
    CHECK(same(x.angular_velocity, y.angular_velocity));
  }
  CHECK(same(one.energy.friction_loss, other.energy.friction_loss));
  CHECK(same(one.energy.impact_loss, other.energy.impact_loss));
  CHECK(same(one.energy.contact, other.energy.contact));
  CHECK(same(one.energy.kinetic, other.energy.kinetic));
}

void check_same(const Outcome& one, const Outcome& other, const Comparison& same) {
  REQUIRE(other.error.empty());
  check_same(one.state, other.state, same);
  CHECK(one.last.status == other.last.status);
  CHECK(one.last.contact_count == other.last.contact_count);
  CHECK(one.last.closed_count == other.last.closed_count);
  CHECK(same(one.last.largest_overlap, other.last.largest_overlap));
  CHECK(one.last.islands == other.last.islands);
  CHECK(one.flagged == other.flagged);
  REQUIRE(one.contacts.size() == other.contacts.size());
  for (std::size_t c = 0; c < one.contacts.size(); ++c) {
    CHECK(one.contacts[c].point.key == other.contacts[c].point.key);
    CHECK(same(one.contacts[c].point.gap, other.contacts[c].point.gap));
    CHECK(same(one.contacts[c].slip, other.contacts[c].slip));
    if (same.same == Same::ToRounding) continue;  // redundant ones share their forces as they may
    CHECK(one.contacts[c].normal_force == other.contacts[c].normal_force);
    CHECK(one.contacts[c].shear_force == other.contacts[c].shear_force);
  }
}

void check_shared(const Scene& scene, const StepOptions& options, int steps,
                  Same same = Same::ToRounding) {
  const Outcome one = run(scene, options, steps);
  REQUIRE_FALSE(one.contacts.empty());
  for (const int count : {2, 3}) {
    INFO(count << " processes");
    const std::vector<int> rank_of = parts_of_blocks(scene, count);
    const std::vector<Outcome> shared = run_shared(scene, options, steps, count);
    for (int rank = 0; rank < count; ++rank) {
      INFO("rank " << rank);
      const Outcome& other = shared[static_cast<std::size_t>(rank)];
      check_same(one, other, {same});
      check_same(shared.front(), other, {Same::Bits});
      const auto is_own = [&](int block) {
        const auto b = static_cast<std::size_t>(block);
        return rank_of[b] == rank && scene.blocks[b].kind != BlockKind::Fixed;
      };
      for (const Contact& contact : other.state.contacts) {
        CHECK((is_own(contact.point.key.a) || is_own(contact.point.key.b)));
      }
      CHECK(other.state.contacts.size() < one.contacts.size());
    }
  }
}

constexpr Material kRigid{.density = 2400}, kSoft{.density = 2400, .young = 1e8, .poisson = 0.2};

int add(Scene& scene, const Vector3& low, const Vector3& size, const Material& stone) {
  const geometry::Shape shape = geometry::make_box(low, low + size);
  return stone.young > 0.0 ? scene.add_block(shape, stone) : scene.add_rigid(shape, stone);
}

/// Courses of bricks in bond on the ground, the upper ones thrown.
Scene wall(const Material& stone) {
  Scene scene;
  scene.joint.friction_angle = 0.6;
  scene.add_fixed(geometry::make_box({-2, -1, -1}, {4, 2, 0}));
  for (int course = 0; course < 4; ++course) {
    for (int k = 0; k < 3; ++k) {
      const Vector3 low(0.8 * k + (course % 2 == 0 ? 0.0 : 0.4), 0.0, 0.25 * course);
      const int b = add(scene, low, {0.8, 0.3, 0.25}, stone);
      scene.blocks[static_cast<std::size_t>(b)].velocity = Vector3(0.1 * course, 0.02 * k, 0.0);
    }
  }
  return scene;
}

/// Boxes that fall on the ground and on each other, and rebound.
Scene falling(const Material& stone) {
  Scene scene;
  scene.joint.friction_angle = 0.5;
  scene.joint.restitution = 0.3;
  scene.add_fixed(geometry::make_box({-4, -4, -1}, {6, 6, 0}));
  for (int k = 0; k < 6; ++k) {
    const Vector3 low(0.35 * k, 0.1 * (k % 3), 0.02 + 0.52 * (k % 2));
    const int b = add(scene, low, {0.5, 0.5, 0.5}, stone);
    scene.blocks[static_cast<std::size_t>(b)].velocity = Vector3(0, 0, -0.5 - 0.1 * k);
    scene.blocks[static_cast<std::size_t>(b)].angular_velocity = Vector3(0.1 * k, 0.2, 0);
  }
  return scene;
}

}  // namespace

TEST_CASE("a wall that slides is the same on several processes") {
  check_shared(wall(kRigid), {.time_step = 2e-3}, unless_sanitized(12, 5));
  check_shared(wall(kSoft), {.time_step = 2e-3}, unless_sanitized(4, 2));
}

TEST_CASE("a wall in static analysis is the same on several processes") {
  check_shared(wall(kRigid), {.analysis = Analysis::Static}, 2, Same::Bits);
}

TEST_CASE("blocks that fall and rebound are the same on several processes") {
  check_shared(falling(kRigid),
               {.time_step = 5e-3, .contact_iteration = ContactIteration::OpenClose},
               unless_sanitized(20, 14), Same::Bits);
  check_shared(falling(kSoft), {.time_step = 5e-3}, 8);
}

TEST_CASE("contacts that yield are the same on several processes") {
  check_shared(falling(kRigid),
               {.time_step = 5e-3, .contact_iteration = ContactIteration::ProximalNewton}, 16);
  check_shared(falling(kRigid), {.time_step = 5e-3}, 16);
}

TEST_CASE("springs and joints that dilate and break are the same on several processes") {
  Scene scene = wall(kRigid);
  check_shared(scene, {.time_step = 2e-3, .method = ContactMethod::Springs},
               unless_sanitized(6, 3));
  scene.joint.cohesion = 2e3;
  scene.joint.tension = 1e3;
  scene.joint.dilation_angle = 0.1;
  check_shared(scene, {.time_step = 2e-3}, unless_sanitized(8, 4));
}

TEST_CASE("what one process refuses all refuse alike") {
  Scene scene = wall(kRigid);
  add(scene, {0.1, 0.05, 0.9}, {0.8, 0.3, 0.3}, kRigid);
  std::string one;
  try {
    run(scene, {}, 1);
  } catch (const InputError& error) {
    one = error.what();
  }
  REQUIRE(one.find("overlap") != std::string::npos);
  for (const Outcome& outcome : run_shared(scene, {}, 1, 3)) CHECK(outcome.error == one);
  for (const Outcome& outcome :
       run_shared(wall(kRigid), {.method = ContactMethod::Penalty}, 1, 2)) {
    CHECK(outcome.error.find("knows one process alone") != std::string::npos);
  }
}

TEST_CASE("A process of several neither saves its part of the state nor loads one") {
  Scene scene;
  scene.add_fixed(geometry::make_box({-3, -3, -1}, {3, 3, 0}));
  scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), {.density = 2600});
  scene.add_rigid(geometry::make_box({-2, 0, 0}, {-1, 1, 1}), {.density = 2600});
  std::stringstream whole;
  Simulation(scene, {}).save(whole);
  Table table(2);
  std::vector<std::string> refused(4);
  std::vector<std::thread> threads;
  for (int rank = 0; rank < 2; ++rank) {
    threads.emplace_back([&, rank] {
      const auto told = [&](std::size_t slot, const auto& act) {
        try {
          act();
        } catch (const geometry::InputError& error) {
          refused[slot] = error.what();
        }
      };
      StepOptions options;
      options.distributed_solver =
          std::make_shared<Process>(rank, 2, parts_of_blocks(scene, 2), table);
      Simulation simulation(scene, options);
      std::stringstream out, in(whole.str());
      const auto first = static_cast<std::size_t>(2 * rank);
      told(first, [&] { simulation.save(out); });
      told(first + 1, [&] { simulation.load(in); });
      if (!out.str().empty()) refused[first] += " after writing";
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < refused.size(); ++i) {
    INFO(refused[i]);
    CHECK(refused[i].starts_with(i % 2 == 0 ? "save: of several processes"
                                            : "load: of several processes"));
    CHECK(refused[i].find("after writing") == std::string::npos);
  }
}
