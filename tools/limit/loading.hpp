#pragma once
/// What loading reaches: runs of the solver itself, and mechanisms under Coulomb friction.

#include <optional>
#include <quoin/solver/simulation.hpp>

#include "limit/proofs.hpp"

namespace quoin::limit_analysis {

/// Of runs of the solver. Observed, not proved.
struct Reached {
  std::optional<double> holds{};  ///< largest (or last) value that came to rest
  std::optional<double> lost{};   ///< nearest value that did not
  int runs = 0;
  std::string why{};  ///< why the two are farther apart than kRunTolerance
};

enum class Outcome : std::uint8_t { Holds, Lost, Unsolved, OutOfTime };

/// Static steps of a run until it rests. OutOfTime: the watch of its options has ended it.
Outcome come_to_rest(solver::Simulation& run, const solver::StepOptions& options);

inline constexpr double kRunTolerance = 5e-3;  // of the value

/// Of what stands on one side at least: whether larger values are worse.
bool rises(const Vary& vary, const Limit& limit);

/// Each value from the unloaded start, by bisection; where none falls, to the end of the range.
/// `seconds`: of wall time, for all runs.
Reached sudden_loading(const VariedScene& scenes, const Limit& limit, double seconds,
                       const Progress& progress);
/// One path from the value that holds: a sixth of the way at a time, halved where rest is lost.
Reached gradual_loading(const VariedScene& scenes, const Limit& limit, double seconds,
                        const Progress& progress);

/// A state in which all forces lie within Coulomb friction, and a mechanism that slips without
/// dilation where friction is exhausted. Not the lowest one, of which no algorithm is sure.
struct CoulombMechanism {
  double value = 0.0;
  double excess = 0.0;  ///< farthest that friction exceeds its limit, by the largest load
};

/// The lowest one found, by limits of friction that are fixed in each round to what the normal
/// forces of the last ones allow [Gilbert, Casapulla & Ahmed 2006]. Loads, strength and friction
/// are variables of that; other values are bisected. None: no round agreed to kCoulombExcess.
/// `limit`: of the same scenes, both sides known. `seconds`: of wall time.
std::optional<CoulombMechanism> coulomb_mechanism(VariedScene& scenes, const Limit& limit,
                                                  double seconds, const Progress& progress);

inline constexpr double kCoulombExcess = 1e-3;

}  // namespace quoin::limit_analysis
