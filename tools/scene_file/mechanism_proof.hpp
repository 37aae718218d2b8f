#pragma once
/// Whether a static stage can come to rest at all: a proof before its first step.

#include <memory>
#include <quoin/solver/equilibrium.hpp>
#include <quoin/solver/simulation.hpp>

#include "scene_file/scene_file.hpp"

namespace quoin::scene_file {

/// The scene with its blocks where the run has them, and gravity as it is now.
solver::Scene standing_scene(const solver::Simulation& run);

/// Of a static stage that no forces hold.
struct MechanismProof {
  solver::Scene scene{};  ///< its blocks as they stand
  solver::EquilibriumProblem problem{};
  solver::Equilibrium found{};

  int fastest() const;  ///< block
};

/// Whether a mechanism can be asked for: not of stages whose blocks shall move, of the source's
/// methods and of several processes.
bool may_be_proved(const solver::Simulation& run, const Stage& stage);

/// A mechanism of the run as it stands, which leaves what a tenth of the blocks' sizes can reach;
/// null: forces may exist, or there are soft springs, which blocks load by moving.
std::shared_ptr<const MechanismProof> find_mechanism(const solver::Simulation& run);

/// Whether admissible forces hold the run as it stands; false where there are soft springs.
bool is_admissible(const solver::Simulation& run);

}  // namespace quoin::scene_file
