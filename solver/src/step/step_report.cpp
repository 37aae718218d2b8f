#include "step/step_report.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "base/index.hpp"
#include "block/block_terms.hpp"
#include "step/contact_search.hpp"
#include "step/form_islands.hpp"

namespace quoin::solver {
namespace {

void note_blocks(const CompiledScene& compiled, const State& state, std::span<const int> blocks,
                 Extremes& extremes) {
  for (const int block : blocks) {
    const BlockState& now = state.blocks[index(block)];
    note_block(now, block, vertex_speed(compiled.models[index(block)], now), extremes);
  }
}

/// The points and contacts of islands that are at rest and not known, from those of the scene.
void give_unknown(const State& state, Workspace& work) {
  work.owners.assign(work.islands.size(), nullptr);
  for (std::size_t i = 0; i < work.islands.size(); ++i) {
    Island& island = *work.islands[i];
    if (island.at_rest && !is_known(work, island)) work.owners[i] = &island;
  }
  share_out(work, work.found, Sharing::Referred, &Island::found);
  share_out(work, state.contacts, Sharing::Referred, &Island::history);
}

// What islands show where they stand. It is kept while an island does: a step looks at those alone
// that were awake in it.

/// After a step that was taken: of islands that were awake, and of those that the last search knows
/// otherwise than the one before.
void note_islands(const CompiledScene& compiled, const State& state, Workspace& work) {
  if (work.islands_met) return;
  const auto stale = [&](const auto& island) {
    return island->at_rest && !is_known(work, *island);
  };
  if (std::ranges::any_of(work.islands, stale)) give_unknown(state, work);
  for (const auto& island : work.islands) {
    if (island->at_rest ? is_known(work, *island) : island->searched != work.search_epoch) continue;
    island->known = work.search_epoch;
    island->extremes = {};
    note_blocks(compiled, state, island->own(), island->extremes);
    note_contacts(compiled, island->history, island->found, island->extremes);
  }
}

/// Of the whole scene.
Extremes extremes(const CompiledScene& compiled, const State& state, const Workspace& work) {
  Extremes all;
  if (all_known(work)) {
    for (const auto& island : work.islands) add(island->extremes, all);
    note_blocks(compiled, state, compiled.prescribed, all);
    return all;
  }
  for (std::size_t b = 0; b < state.blocks.size(); ++b) {
    const BlockState& now = state.blocks[b];
    note_block(now, static_cast<int>(b), vertex_speed(compiled.models[b], now), all);
  }
  note_contacts(compiled, state.contacts, work.found, all);
  return all;
}

// Damping ratio of the constant acceleration scheme by omega dt.   [Doolin & Sitar 2004]
constexpr double kDampingOfScheme = 0.25;

/// What weighs on an island: weights and loads, N. `gravity`: m/s2.
double weight_of(const CompiledScene& compiled, const Island& island, double gravity, double time) {
  double sum = 0.0;
  for (const int block : island.own()) sum += gravity * compiled.models[index(block)].mass;
  for (const int l : island.blocks.loads) {
    const PointForce& load = compiled.loads[index(l)];
    sum += load.at(pose(compiled.models[index(load.block)].start), time).norm();
  }
  return sum;
}

/// What rounding makes of an island's strain energy in a step, J: a block that is stressed and does
/// nothing has no other scale.
double rounding_of_strain(const CompiledScene& compiled, const Workspace& work,
                          const Island& island) {
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  double sum = 0.0;
  for (const int block : island.own())
    sum += strain_energy(compiled.models[index(block)], work.now.blocks[index(block)]);
  return kRounding * sum;
}

/// The growth of energy that is most of its island's scale.
void note_growth(const Workspace& work, const Island& island, double noise,
                 StepEvidence& evidence) {
  double scale = 0.0;
  for (const int block : island.own()) scale += work.energy_scale[index(block)].value();
  const double growth = island.count.energy_growth;
  if (!(growth > noise && growth * evidence.energy_scale > evidence.energy_growth * scale)) return;
  evidence.energy_growth = growth;
  evidence.energy_scale = scale;
  evidence.energy_noise = noise;
  evidence.energy_block = island.own().front();
}

void append_flags(const CompiledScene& compiled, const StepOptions& options, double time,
                  const Workspace& work, const Extremes& extremes, StepReport& report) {
  StepEvidence evidence{
      .gap_tolerance = options.tolerance * compiled.smallest_size,
      .springs = options.method != ContactMethod::AugmentedLagrangian,
  };
  // Of a ramp down to nothing the weight under which gaps were left is that of the step's start.
  const double start = std::max(0.0, time - options.time_step);
  const double gravity =
      std::max(compiled.scene.gravity.at(start).norm(), compiled.scene.gravity.at(time).norm());
  for (const auto& island : work.islands) {
    if (island->missing) evidence.missing = &*island->missing;
    const double tolerance = options.tolerance * island->blocks.smallest_size;
    const double rounding = island->count.rounding;
    if (rounding / tolerance > evidence.rounding / evidence.gap_tolerance) {
      evidence.rounding = rounding;
      evidence.gap_tolerance = tolerance;
    }
    if (options.analysis != Analysis::Dynamic) continue;
    if (island->count.turn.value > evidence.turn.value) evidence.turn = island->count.turn;
    if (island->count.impacts.value > evidence.impacts.value)
      evidence.impacts = island->count.impacts;
    if (!(island->count.energy_growth > 0.0)) continue;
    // What the tolerance of gaps leaves, and rounding of what strain holds.
    const double noise = tolerance * weight_of(compiled, *island, gravity, time) +
                         rounding_of_strain(compiled, work, *island);
    note_growth(work, *island, noise, evidence);
  }
  append_flags(compiled, extremes, evidence, report);
}

}  // namespace

void count_attempt(Island& island) {
  const Attempt& attempt = island.attempt;
  IslandCount& total = island.count;
  const OpenCloseResult& solved = attempt.solved;
  total.iterations += solved.iterations;
  total.solves += solved.solves;
  total.factorizations += solved.factorizations;
  total.residual = solved.residual;
  if (!island.sound) {  // what its blocks came to says nothing, though equations may balance
    total.residual = std::numeric_limits<double>::infinity();
    return;
  }
  total.proximal_newton_attempts += island.memory.solver.yielding() ? 1 : 0;
  if (solved.condition > 0.0) total.condition = solved.condition;
  total.unbalance = attempt.unbalance;
  total.rounding = attempt.rounding;
  total.stiffest_omega_dt = std::max(total.stiffest_omega_dt, attempt.stiffest_omega_dt);
}

void report_islands(std::span<Island* const> islands, StepReport& report) {
  report.sub_steps = islands.empty() ? 1 : 0;
  for (Island* const island : islands) {
    const IslandCount& count = island->count;
    report.block_solves += static_cast<long>(island->own().size()) * count.solves;
    report.sub_steps = std::max(report.sub_steps, count.sub_steps);
    report.iterations = std::max(report.iterations, count.iterations);
    report.linear_solves = std::max(report.linear_solves, count.solves);
    report.factorizations = std::max(report.factorizations, count.factorizations);
    report.proximal_newton_attempts =
        std::max(report.proximal_newton_attempts, count.proximal_newton_attempts);
    report.linear.add(island->memory.solver.linear_solver().counts());
    report.residual = worse_residual(report.residual, count.residual);
    report.condition = std::max(report.condition, count.condition);
    report.unbalance = std::max(report.unbalance, count.unbalance);
    report.stiffest_omega_dt = std::max(report.stiffest_omega_dt, count.stiffest_omega_dt);
  }
}

FightingContacts fighting(const StepRun& run, const Island& island) {
  std::vector<FightingContact> all;  // the worst of each pair
  const std::vector<SolvedContact>& positions = island.attempt.positions;
  for (std::size_t i = 0; i < island.contacts.size() && i < positions.size(); ++i) {
    const BodyContact& contact = island.contacts[i];
    const double change = positions[i].change;
    if (!(change > 0.0)) continue;
    const Vector3 place = run.state.origin + contact.state.point.point();
    const FightingContact now{contact.a, contact.b, place, change};
    if (all.empty() || all.back().block != now.block || all.back().other != now.other)
      all.push_back(now);
    else if (now.change > all.back().change)
      all.back() = now;
  }
  std::ranges::stable_sort(all, std::greater{}, &FightingContact::change);
  FightingContacts worst;
  worst.count = std::min(all.size(), worst.contacts.size());
  std::copy_n(all.begin(), worst.count, worst.contacts.begin());
  return worst;
}

void report_end(const CompiledScene& compiled, const StepOptions& options, const State& state,
                Workspace& work, StepReport& report) {
  report.time = state.time;
  report.islands = static_cast<int>(work.islands.size());
  report.islands_at_rest = static_cast<int>(
      std::ranges::count_if(work.islands, [](const auto& island) { return island->at_rest; }));
  report.contact_count = static_cast<int>(state.contacts.size());
  if (report.status == StepStatus::Converged) note_islands(compiled, state, work);
  const Extremes all = extremes(compiled, state, work);
  report.closed_count = all.closed;
  report.largest_overlap = std::max(report.largest_overlap, all.overlap);
  report.largest_strain = std::max(report.largest_strain, all.strain);
  report.largest_speed = std::max(report.largest_speed, all.speed);
  if (options.scheme == TimeScheme::ConstantAcceleration)
    report.numerical_damping = kDampingOfScheme * report.stiffest_omega_dt;
  append_flags(compiled, options, state.time, work, all, report);
}

}  // namespace quoin::solver
