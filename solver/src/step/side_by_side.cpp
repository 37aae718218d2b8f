#include "step/side_by_side.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>

namespace quoin::solver {
namespace {

// Contacts and blocks: some 20 us of work, what it takes to wake a thread.
constexpr std::size_t kWorthThreads = 32;
constexpr std::chrono::microseconds kBetweenLooks{500};
// An island of more than this share of the contacts and blocks, and of so many, has all threads to
// itself, before the others: of two threads it takes 0.6 to 0.7 of the time of one.
constexpr double kLargeShare = 0.6;
constexpr std::size_t kLarge = 2048;

/// Formulas of loads are the user's functions: they are asked on one thread. Processes that solve
/// together do so in one order.
bool can_share(const StepRun& run) {
  const CompiledScene& compiled = run.compiled;
  const auto constant_load = [](const PointForce& load) {
    return !load.pressure && load.force.is_constant();
  };
  const auto constant_held = [](const HeldPoint& held) { return held.displacement.is_constant(); };
  return run.work.threads.workers() > 1 && !run.options.contact_problem &&
         !run.options.distributed_solver && compiled.scene.gravity.is_constant() &&
         std::ranges::all_of(compiled.loads, constant_load) && compiled.quiet.empty() &&
         std::ranges::all_of(compiled.held, constant_held);
}

std::size_t size(const Island& island) { return island.own().size() + island.contacts.size(); }

/// The largest islands first: the last to end is then a small one.
std::vector<Island*> by_size(std::span<Island* const> islands) {
  std::vector<Island*> sorted(islands.begin(), islands.end());
  std::ranges::stable_sort(sorted, std::greater{}, [](const Island* i) { return size(*i); });
  return sorted;
}

/// An island has all threads; no more, whatever its task throws: the next one may be a worker's.
class AllThreads {
 public:
  AllThreads(const StepRun& run, Island& island) : solver_(island.memory.solver) {
    solver_.use(Threads(&run.work.threads));
  }
  ~AllThreads() { solver_.use(Threads()); }
  AllThreads(const AllThreads&) = delete;
  AllThreads& operator=(const AllThreads&) = delete;

 private:
  ContactSolver& solver_;
};

void take_alone(const StepRun& run, Island& island, const std::function<void(Island&)>& task) {
  const AllThreads has(run, island);
  task(island);
}

/// The first worker looks at the watch while others work.
void share_out(const StepRun& run, std::span<Island* const> islands,
               const std::function<void(Island&)>& task) {
  std::atomic<std::size_t> next{0}, left{islands.size()};
  std::atomic<bool> thrown{false};
  StepWatch& watch = run.work.watch;
  auto take = [&](int worker) {
    try {
      for (std::size_t i; (i = next++) < islands.size(); --left) task(*islands[i]);
    } catch (...) {
      thrown = true;
      throw;
    }
    while (worker == 0 && watch.watches() && left > 0 && !thrown) {
      std::this_thread::sleep_for(kBetweenLooks);
      watch.look();
    }
  };
  run.work.threads.run_each(take);
}

}  // namespace

void side_by_side(const StepRun& run, std::span<Island* const> islands,
                  const std::function<void(Island&)>& task) {
  const auto timed = [&](Island& island) {
    island.memory.clock.start();
    task(island);
  };
  std::size_t work = 0;
  for (const Island* island : islands) work += size(*island);
  if (islands.size() > 1 && work >= kWorthThreads && can_share(run)) {
    const std::vector<Island*> sorted = by_size(islands);
    const std::size_t largest = size(*sorted.front());
    const bool alone =
        largest >= kLarge && static_cast<double>(largest) > kLargeShare * static_cast<double>(work);
    if (alone) take_alone(run, *sorted.front(), timed);
    share_out(run, std::span(sorted).subspan(alone ? 1 : 0), timed);
  } else {
    for (Island* island : islands) take_alone(run, *island, timed);
  }
  for (Island* island : islands) run.work.clock.add(island->memory.clock.seconds);
}

}  // namespace quoin::solver
