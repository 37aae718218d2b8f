#pragma once
/// Blocks that are solved together, and where they stand in the step.

#include <memory>
#include <optional>

#include "step/step_attempt.hpp"

namespace quoin::solver {

/// What an island's step took, and what its last attempt came to.
struct IslandCount {
  int sub_steps = 0, iterations = 0, solves = 0, factorizations = 0;
  int interior_point_attempts = 0;
  double residual = 0.0, condition = 0.0, unbalance = 0.0, stiffest_omega_dt = 0.0;
  double energy_growth = 0.0;  ///< largest of its sub-steps, J
};

struct Island {
  Island(IslandBlocks island_blocks, StepWatch* watch)
      : blocks(std::move(island_blocks)), memory(blocks.slots, watch) {}
  Island(const Island&) = delete;  // `memory` knows where the slots are
  Island& operator=(const Island&) = delete;

  const IslandBlocks blocks;

  double time = 0.0;                              ///< where it stands, s
  double done = 0.0;                              ///< of the step, s
  double length = 0.0;                            ///< of the next attempt, s
  bool parted = false;                            ///< this step, before an impact
  double length_after = 0.0;                      ///< of the attempt after that part, s; 0: no part
  std::vector<geometry::ContactPoint> found;      ///< where it stands
  std::vector<Contact> history;                   ///< as the last accepted sub-step left them
  std::vector<BodyContact> contacts;              ///< that the attempt holds
  std::vector<geometry::ContactPoint> found_end;  ///< at the end of the attempt
  std::vector<Contact> history_end;               ///< likewise
  std::optional<geometry::ContactPoint> missing;  ///< one of found_end that no attempt held
  bool solved = false;                            ///< the attempt, with all contacts
  bool sound = true;    ///< its end can be gone on with: finite, and no block squeezed flat
  IslandCount count;    ///< of this step
  double stride = 0.0;  ///< static: of the step, by block size
  bool still = false;   ///< nothing moved in the sub-step, and no load on it changes
  AttemptMemory memory;
  Attempt attempt;
};

/// All blocks with unknowns as one island.
IslandBlocks whole_scene(const CompiledScene& compiled);

}  // namespace quoin::solver
