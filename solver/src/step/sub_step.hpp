#pragma once
/// What all stages of a sub-step read, and none of them changes.

#include <quoin/solver/simulation.hpp>
#include <span>

#include "scene/compiled_scene.hpp"

namespace quoin::solver {

/// Time that a step of this length takes, s: a static one none.
inline double duration(const StepOptions& options, double length) {
  return options.analysis == Analysis::Dynamic ? length : 0.0;
}

/// ContactMethod::Paper and ContactMethod::Penalty.
inline bool is_paper_method(ContactMethod method) {
  return method == ContactMethod::Paper || method == ContactMethod::Penalty;
}

/// Blocks that are solved together, and what acts on them.
struct IslandBlocks {
  Slots slots{};               ///< of these blocks alone; slot_of_block: see SubStep
  std::vector<int> loads{};    ///< of CompiledScene::loads, ascending
  std::vector<int> held{};     ///< of CompiledScene::held, ascending
  std::vector<int> ties{};     ///< of CompiledScene::ties, ascending
  std::vector<int> quiet{};    ///< of CompiledScene::quiet, ascending
  double smallest_size = 0.0;  ///< m
};

/// One try at [time, time + length] for one island.
struct SubStep {
  const CompiledScene& compiled;
  const StepOptions& options;
  const IslandBlocks& island;
  std::span<const int> slot_of_block;  ///< in its island; -1: no unknowns
  std::span<const BlockState> state;   ///< by block, at the start
  double time = 0.0;                   ///< at the start, s
  double length = 0.0;                 ///< s; static: the pseudo-step tau
  std::span<const TieState> ties{};    ///< of CompiledScene::ties, at the start
  std::span<const Vector3> quiet{};    ///< State::quiet_forces

  bool dynamic() const { return options.analysis == Analysis::Dynamic; }
  double end_time() const { return time + duration(options, length); }
  /// Loads stand for the middle of a dynamic step; a static one takes no time.
  double load_time() const { return time + 0.5 * duration(options, length); }
  double gap_tolerance() const { return options.tolerance * island.smallest_size; }
  /// A contact that cannot bear tension has parted where it opens by more, m.
  double parting_gap() const { return kParted * gap_tolerance(); }
  /// Rebounds slower than gravity's own speed in two steps are not resolved by the step.
  double bounce_speed() const { return 2.0 * compiled.scene.gravity.at(time).norm() * length; }
  StepScheme scheme(bool deforms = true) const {
    const bool undamped = options.scheme == TimeScheme::EnergyMomentum && dynamic();
    return {length, undamped ? kUndamped : kImplicit, deforms};
  }

 private:
  static constexpr double kParted = 10.0;   // closed contacts are good to one tolerance
  static constexpr double kUndamped = 0.5;  // share of elastic forces taken at the end of the step
  static constexpr double kImplicit = 1.0;
};

}  // namespace quoin::solver
