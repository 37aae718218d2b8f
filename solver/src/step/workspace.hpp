#pragma once
/// What is kept between steps.

#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/worker_pool.hpp>

#include "base/joined_groups.hpp"
#include "scene/initial_depths.hpp"
#include "statics/equilibrium_search.hpp"
#include "step/island.hpp"
#include "step/step_flags.hpp"

namespace quoin::solver {

/// Time counted in steps of one length.
struct Counted {
  double start = 0.0, time_step = 0.0, now = 0.0;  ///< s
  long steps = 0;                                  ///< of this length, from `start` to `now`
};

/// Of two blocks without unknowns of which one could move before: what they had with each other
/// then, and where they stood.
struct WaitingContact {
  Contact contact;
  BlockState a, b;
};

/// What the next step depends on, beside the state and its contact points.
struct StepMemory {
  bool still = false;  ///< nothing moved in the last step and no load changes: the next is the same
  StepReport report;   ///< of that step
  Counted counted;
  EquilibriumSearch search;               ///< of the static analysis that goes on
  std::vector<EnergyScale> energy_scale;  ///< by block
  LastSubStep last;
  std::vector<double> stored;            ///< by slot: StepEnergy::stored, J
  std::vector<char> at_rest;             ///< by block: its island stood still in the last step
  std::vector<char> laid;                ///< by block: Laying, in this step
  std::vector<WaitingContact> waiting;   ///< sorted by key
  std::vector<PrescribedMotion> motion;  ///< of compiled.prescribed, at the present state
};

/// Whose contact points a search lists: where few blocks move, theirs alone.
enum class Searched : char { AllBlocks, MovedBlocks };

/// Reaches of a search (Reach), without what all blocks have beside their own.
struct KnownReaches {
  std::vector<double> of_block{};  ///< m
  /// What they hang on, of all blocks alike, m: free fall in a step; openings of joints.
  double fall = -1.0, opening = 0.0;
};

/// StepMemory is in checkpoint.cpp; the rest changes the speed alone, or is made anew in each step.
struct Workspace : StepMemory {
  explicit Workspace(const CompiledScene& compiled, const StepOptions& options);

  int threads_wanted;  ///< no more than blocks that move
  geometry::WorkerPool threads;
  geometry::ContactFinder finder;  ///< of blocks by handle(); absent ones collide with none
  std::vector<int> handles;        ///< by block; empty: all are convex, and block b has handle b
  std::vector<int> owners_of_handles;  ///< block, by handle; likewise
  int handle(int block) const {
    return handles.empty() ? block : handles[static_cast<std::size_t>(block)];
  }
  InitialDepths initial_depths;  ///< taken off what is found
  /// At the present state, places in the frames of the reference shapes.
  std::vector<geometry::ContactPoint> found;
  /// At the end of the attempts: those of all blocks, or of all that this step has moved.
  std::vector<geometry::ContactPoint> found_end;
  std::vector<geometry::ContactPoint>
      found_last;                           ///< of the last search, where it is of few blocks
  Searched searched = Searched::AllBlocks;  ///< in this step

  /// Contact points of blocks that stand are the same while it is: their reaches are, and nobody
  /// changes the state from outside.
  long search_epoch = 0;
  KnownReaches known_reaches;  ///< of the last search
  KnownReaches start_reaches;  ///< memory of start_islands()
  bool islands_met = false;    ///< the last search found contacts between two islands

  StepMemory before;                          ///< as the step began
  std::vector<PrescribedMotion> best_motion;  ///< of the best attempt

  std::vector<int> slot_of_block;    ///< in its island; -1: no unknowns
  std::vector<int> island_of_block;  ///< -1: no unknowns
  std::vector<std::unique_ptr<Island>> islands;
  JoinedGroups joined;                         ///< blocks, by contacts of this step
  JoinedGroups joined_slots;                   ///< memory of form_islands()
  std::vector<int> next_island_of_block;       ///< memory of form_islands()
  std::vector<Island*> owners;                 ///< memory of share_out(), by island
  std::vector<int> changed;                    ///< blocks that the last step has moved
  bool all_changed = true;                     ///< or all, where the state was set from outside
  std::vector<Contact> taken;                  ///< memory of take_contacts()
  Islands awake;                               ///< those that take the step
  Islands group;                               ///< of these: that try one sub-step side by side
  Islands open;                                ///< of these: that try another round
  std::vector<int> moved;                      ///< memory of a search: blocks that do not stand
  std::vector<Vector12> increments;            ///< memory of place_idle(), of compiled.prescribed
  std::vector<std::pair<int, Vector3>> jumps;  ///< blocks whose velocity jumps as the sub-step
                                               ///< begins, and by how much, m/s
  State now;                                   ///< while a step is taken: its accepted sub-steps
  StepPoses poses;                             ///< of the sub-step that is tried, by block
  std::vector<BlockState> end;                 ///< likewise: at its end
  std::vector<PrescribedMotion> motion_end;    ///< likewise
  StepWatch watch;
  std::unique_ptr<AttemptMethod> other_method;  ///< of is_paper_method()
  PhaseClock clock;
};

/// Takes the finder's bodies to where the state has them, also those that no step moves.
void place_bodies(const CompiledScene& compiled, const State& state, Workspace& work);

struct StepRun {
  const CompiledScene& compiled;
  const StepOptions& options;
  const State& state;        ///< before the step
  const StepMemory& before;  ///< likewise
  Workspace& work;
  StepReport& report;
};

/// The next attempt of an island.
inline SubStep sub_step(const StepRun& run, const Island& island) {
  return {run.compiled,           run.options,         island.blocks,
          run.work.slot_of_block, run.work.now.blocks, island.time,
          island.length,          run.work.now.ties,   run.work.now.quiet_forces};
}

}  // namespace quoin::solver
