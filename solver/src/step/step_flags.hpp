#pragma once
/// What a step's result should not be trusted for: found by the run itself.

#include <quoin/solver/simulation.hpp>
#include <span>
#include <utility>

#include "scene/compiled_scene.hpp"

namespace quoin::solver {

/// Growth of mechanical energy in a step, of its scale, that is flagged: what conservation is
/// tested to.
inline constexpr double kEnergyGrowth = 1e-6;

/// Turn of a block in a sub-step, rad: of it a twelfth of its square is lost, 1 %; 8 % are not to
/// be trusted.
inline constexpr double kLargestTurn = 0.3, kMeaninglessTurn = 1.0;

/// Gap that is closed by one impact and struck by the next in one sub-step, by the smaller block:
/// beneath, blocks count as touching.
inline constexpr double kGapBetweenImpacts = 1e-4;

/// What a change of a block's energy is measured against, J.
class EnergyScale {
 public:
  /// `gain`: of potential, strain and spring energy since the last call.
  void note(double kinetic, double gain);
  /// Largest kinetic energy so far and the swing of the rest.
  double value() const { return kinetic_ + highest_ - lowest_; }

 private:
  double kinetic_ = 0.0, rest_ = 0.0, highest_ = 0.0, lowest_ = 0.0;
};

struct StepEvidence {
  /// Of a sub-step of the island where it is worst, J: mechanical energy less the work of loads.
  double energy_growth = 0.0;
  double energy_scale = 1.0;                        ///< of that island, J
  double energy_noise = 0.0;                        ///< what the tolerance of gaps leaves of it, J
  int energy_block = -1;                            ///< its first block
  double rounding = 0.0;                            ///< of a gap, m
  double gap_tolerance = 0.0;                       ///< m
  const geometry::ContactPoint* missing = nullptr;  ///< an overlap that no contact held
  bool springs = false;                             ///< contacts are springs by their method
  StepFlag turn{}, impacts{};                       ///< of the islands where they are worst
};

/// Hard ones come before any that joints close by their law.
struct WorstOverlap {
  bool hard = false;                              ///< beyond what the joint explains
  double share = 0.0;                             ///< of the smaller block
  const geometry::ContactPoint* point = nullptr;  ///< the first one with it
  std::pair<bool, double> size() const { return {hard, share}; }
};

/// What blocks and contacts show where they stand.
struct Extremes {
  int closed = 0;        ///< contacts
  double overlap = 0.0;  ///< of points found, m
  double strain = 0.0;   ///< component
  double speed = 0.0;    ///< of a vertex, m/s
  int strained = -1;     ///< the first block with `strain`
  /// Of points found, and of what the step's own springs let through: a block that has sunk right
  /// through another one is not found any more.
  WorstOverlap found, held;
  const geometry::ContactPoint* vanished = nullptr;  ///< see vanished()
};

void note_block(const BlockState& state, int block, double speed, Extremes& extremes);
/// Once; both are sorted by key.
void note_contacts(const CompiledScene& compiled, std::span<const Contact> contacts,
                   std::span<const geometry::ContactPoint> found, Extremes& extremes);
/// Of other blocks and contacts.
void add(const Extremes& part, Extremes& total);

/// The first closed contact whose blocks `found` does not know near each other, but for those that
/// an impact has thrown apart; null: none. Both are sorted by key.
const geometry::ContactPoint* vanished(const CompiledScene& compiled,
                                       std::span<const Contact> contacts,
                                       std::span<const geometry::ContactPoint> found);

/// Appends to report.flags.
void append_flags(const CompiledScene& compiled, const Extremes& extremes,
                  const StepEvidence& evidence, StepReport& report);

}  // namespace quoin::solver
