#include "step/step_control.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "base/index.hpp"
#include "step/attempt_rounds.hpp"
#include "step/contact_search.hpp"
#include "step/form_islands.hpp"
#include "step/step_report.hpp"

namespace quoin::solver {
namespace {

constexpr int kStaticCuts = 10;         // halvings of a pseudo-step: to a millionth of its motion
constexpr double kSmallestStep = 1024;  // sub-steps in a step, where the options name no smallest
constexpr double kEnd = 1e-12;          // of the step: what sub-steps may leave of it by rounding
// Of a sub-step: what is left to go until its first impact. Forces until then are carried into the
// impact's sub-step by a share (impact_law): that error goes with it, 1e-5 of a rocking block's
// peak.
constexpr double kBeforeImpact = 0.01;
// Of energy, that a sub-step may gain where contacts yield, of its scale, and of the step, the
// shortest such sub-step: walls and towers that gained 1e-3 to 1e-6 in a step gain 1e-9 in halves.
constexpr double kGrowth = 1e-8, kShortestForEnergy = 0.125;

/// Time is counted in steps, not added up: a million steps of dt end at a million dt.
double counted_end(const StepOptions& options, const State& state, Counted& clock) {
  const double step = duration(options, options.time_step);
  if (clock.time_step != step || clock.now != state.time) clock = {state.time, step, state.time, 0};
  ++clock.steps;
  return clock.start + static_cast<double>(clock.steps) * step;
}

/// A step like the last one, in which nothing moved.
StepReport stand(const StepOptions& options, State& state, Workspace& work) {
  state.time = work.counted.now = counted_end(options, state, work.counted);
  ++state.step;
  StepReport report = work.report;
  report.time = state.time;
  report.candidate_pairs = report.searched_pairs = 0;
  report.seconds = {};
  return report;
}

/// A block moved by a motion since `time`, as the step before this one left it.
PrescribedMotion motion_at(const StepRun& run, std::size_t p, double time) {
  const Motion& motion = run.compiled.scene.blocks[index(run.compiled.prescribed[p])].motion;
  return advance_motion(motion, run.work.motion[p], run.state.time, time);
}

BlockState prescribed_at(const StepRun& run, std::size_t p, const PrescribedMotion& motion) {
  const std::size_t b = index(run.compiled.prescribed[p]);
  BlockState block = run.state.blocks[b];
  move_along(run.compiled.models[b], run.compiled.scene.blocks[b].motion, run.work.motion[p],
             motion, run.compiled.origin, block);
  return block;
}

/// Blocks without unknowns where they are at `from`, and where they will be at `to`.
void place_idle(const StepRun& run, double from, double to) {
  Workspace& work = run.work;
  work.increments.clear();
  work.jumps.clear();
  for (std::size_t p = 0; p < run.compiled.prescribed.size(); ++p) {
    const std::size_t b = index(run.compiled.prescribed[p]);
    const PrescribedMotion now = motion_at(run, p, from);
    const Motion& motion = run.compiled.scene.blocks[b].motion;
    work.motion_end[p] = motion_at(run, p, to);
    if (from != run.state.time) work.now.blocks[b] = prescribed_at(run, p, now);
    if (from != to && motion.kind == MotionKind::Velocity && !motion.value.is_constant() &&
        motion.rotation.is_constant()) {
      Vector3& velocity = work.now.blocks[b].velocity;
      const Vector3 before = velocity;
      velocity = velocity_inside(motion.value, from, to);
      if (velocity != before) work.jumps.emplace_back(static_cast<int>(b), velocity - before);
    }
    work.end[b] = prescribed_at(run, p, work.motion_end[p]);
    Vector12& increment = work.increments.emplace_back(Vector12::Zero());
    increment.head<3>() = work.motion_end[p].displacement - now.displacement;
    if (motion.rotation.is_constant()) continue;
    const BlockState &start = work.now.blocks[b], &end = work.end[b];
    const Quaternion turn = start.rotation.conjugate() * end.rotation;
    increment.head<3>() =
        (end.centroid - start.centroid) + (end.centroid_rest - start.centroid_rest);
    increment.segment<3>(3) = 2.0 / turn.w() * turn.vec();
  }
  place_idle(run.compiled, work.now.blocks, work.end, work.increments, work.poses);
}

/// Of a block in free flight in the next sub-step of its island, rad; 0: something touches it.
double free_turn(const StepRun& run, const Island& island, int block) {
  const double turn = run.work.now.blocks[index(block)].angular_velocity.norm() * island.length;
  if (!(turn > kLargestTurn)) return turn;
  const bool touched = std::ranges::any_of(island.contacts, [&](const BodyContact& contact) {
    return contact.was_closed && (contact.a == block || contact.b == block);
  });
  return touched ? 0.0 : turn;
}

/// How often the next sub-step is halved before it is tried. Once: two blocks near each other that
/// move by more than half the smaller one can jump over a contact. More often: a block in free
/// flight turns by more than `kLargestTurn`, and so too little; until it is a third of that.
int halvings(const StepRun& run, const Island& island) {
  const auto speed = [&](int block) {
    return vertex_speed(run.compiled.models[index(block)], run.work.now.blocks[index(block)]);
  };
  const bool jumps = std::ranges::any_of(island.contacts, [&](const BodyContact& contact) {
    const double way = (speed(contact.a) + speed(contact.b)) * island.length;
    const double size = pair_size(run.compiled, contact.a, contact.b);
    return way > kFarthest * size && contact.state.point.gap < way;
  });
  double most = 0.0;
  if (!is_paper_method(run.options.method))
    for (const int block : island.own()) most = std::max(most, free_turn(run, island, block));
  const int turns = most > kLargestTurn ? std::ilogb(3.0 * most / kLargestTurn) + 1 : 0;
  return std::max(turns, jumps ? 1 : 0);
}

/// The attempt took all forces as they were, and nothing moved, to the last bit.
bool stood_still(const StepRun& run, const Island& island) {
  const Workspace& work = run.work;
  const auto at_rest = [&](int block) {
    return work.poses.increment[index(block)].isZero(0.0) &&
           velocity_vector(work.now.blocks[index(block)]).isZero(0.0) &&
           velocity_vector(work.end[index(block)]).isZero(0.0);
  };
  return island.attempt.solved.solves == 0 && constant_loads(run.compiled, island.blocks) &&
         std::ranges::all_of(island.own(), at_rest);
}

/// No contact slid, opened or closed in the attempt: the island moves as one body, if at all.
bool keeps_modes(const Island& island) {
  const auto keeps = [](const SolvedContact& c) {
    return c.mode == (c.was_closed ? ContactMode::Stick : ContactMode::Open);
  };
  return std::ranges::all_of(island.attempt.positions, keeps);
}

/// Energy in the springs that the island has from the last sub-step, J; `stored`: by slot.
double stored_energy(const CompiledScene& compiled, const Island& island,
                     std::span<const double> stored) {
  double sum = 0.0;
  for (const int block : island.own())
    sum += stored[index(compiled.slots.slot_of_block[index(block)])];
  return sum;
}

void set_forces(const Island& island, State& state) {
  for (std::size_t h = 0; h < island.attempt.held_forces.size(); ++h) {
    Vector3& force = state.held_forces[index(island.blocks.held[h])];
    force = island.mean(force, island.attempt.held_forces[h]);
  }
  for (std::size_t t = 0; t < island.attempt.ties.size(); ++t)
    state.ties[index(island.blocks.ties[t])] = island.attempt.ties[t];
  for (std::size_t q = 0; q < island.attempt.quiet_forces.size(); ++q)
    state.quiet_forces[index(island.blocks.quiet[q])] = island.attempt.quiet_forces[q];
}

/// What the blocks of the island gain in its next sub-step, where they stand before it.
void note_energy(const StepRun& run, const SubStep& step, const Island& island) {
  const Vector3 gravity = run.compiled.scene.gravity.at(step.load_time());
  for (std::size_t s = 0; s < island.own().size(); ++s) {
    const std::size_t b = index(island.own()[s]);
    const BlockModel& model = run.compiled.models[b];
    const BlockState &now = run.work.now.blocks[b], &end = run.work.end[b];
    const double spring = island.attempt.energy.stored[s] -
                          run.work.stored[index(run.compiled.slots.slot_of_block[b])];
    const double fall = model.mass * gravity.dot(run.work.poses.increment[b].head<3>());
    const double strain = strain_energy(model, end) - strain_energy(model, now);
    const double kinetic = std::max(kinetic_energy(model, now), kinetic_energy(model, end));
    run.work.energy_scale[b].note(kinetic, strain + spring - fall);
  }
}

/// Of the attempt, J.
double energy_growth(const StepRun& run, const Island& island) {
  return energy_growth(sub_step(run, island), island.attempt.energy, run.work.end,
                       stored_energy(run.compiled, island, run.work.stored));
}

/// What becomes of an attempt. `growth`: energy_growth() of it; `can_cut`: see AttemptOutcome.
Fate judge(const StepRun& run, Island& island, double growth, bool can_cut) {
  double scale = 0.0, mass = 0.0;
  for (const int block : island.own()) {
    scale += run.work.energy_scale[index(block)].value();
    mass += run.compiled.models[index(block)].mass;
  }
  const double gravity = run.compiled.scene.gravity.at(run.state.time).norm();
  double noise =  // what the tolerance of gaps leaves
      gravity * mass * run.options.tolerance * island.blocks.smallest_size;
  // The next step closes what velocities leave of gaps: beside that the energy of rigid blocks
  // that a support moves slowly is small.
  const auto driven = island.memory.impact.restitution.driven();
  const bool is_driven = std::ranges::any_of(driven, [](char moves) { return moves != 0; });
  if (is_driven && island.blocks.slots.rigid()) noise *= kVelocityGap;
  const StepEnergy& energy = island.attempt.energy;
  return island.memory.solver.judge({island.solved, island.attempt.solved.closed, can_cut, growth,
                                     std::max(kGrowth * scale, noise),
                                     energy.contact_work - energy.friction_work});
}

/// The largest value that a flag has been raised by, and where.
void note(double value, int block, int other, StepFlag& flag) {
  if (!(value > flag.value)) return;
  flag.value = value;
  flag.block = block;
  flag.other = other;
}

/// What the blocks of an island turn by in its attempt.
void note_turns(const StepRun& run, Island& island) {
  StepFlag& flag = island.count.turn;
  for (const int block : island.own()) {
    const double spin = std::min(run.work.now.blocks[index(block)].angular_velocity.norm(),
                                 run.work.end[index(block)].angular_velocity.norm());
    note(spin * island.length, block, -1, flag);
  }
  flag.fails = flag.value > kMeaninglessTurn;
}

/// Pairs that were apart, free flight keeps apart, and another impact has made meet in the attempt
/// of an island. Springs have no impacts.
void note_impacts(const StepRun& run, Island& island) {
  const std::vector<SolvedContact>& positions = island.attempt.positions;
  const std::vector<BodyContact>& contacts = island.contacts;
  const std::size_t count = std::min(contacts.size(), positions.size());
  for (std::size_t first = 0, next = 0; first < count; first = next) {
    const int a = contacts[first].a, b = contacts[first].b;
    bool apart = contacts[first].joint->restitution > 0.0, met = false;
    double gap = std::numeric_limits<double>::infinity();
    for (; next < count && contacts[next].a == a && contacts[next].b == b; ++next) {
      const SolvedContact& c = positions[next];
      apart = apart && !c.compliant && !c.was_closed && !c.closes;
      met = met || c.mode != ContactMode::Open;
      gap = std::min(gap, c.start);
    }
    if (apart && met) note(gap / pair_size(run.compiled, a, b), a, b, island.count.impacts);
  }
}

/// The attempt is the island's next sub-step. `growth`: energy_growth() of it.
void accept(const StepRun& run, Island& island, double growth) {
  Workspace& work = run.work;
  const SubStep step = sub_step(run, island);
  const StepEnergy& energy = island.attempt.energy;
  island.still = stood_still(run, island);
  const int crowd = keeps_modes(island) ? 0 : island.memory.solver.crowd();
  book(energy, growth, island.energy);
  if (step.dynamic()) {
    note_turns(run, island);
    note_impacts(run, island);
  }
  const bool first = island.count.sub_steps == 0;
  island.count.energy_growth = first ? growth : std::max(island.count.energy_growth, growth);
  note_energy(run, step, island);
  for (std::size_t s = 0; s < energy.stored.size(); ++s) {
    const int block = island.own()[s];
    const std::size_t slot = index(run.compiled.slots.slot_of_block[index(block)]);
    BlockState& now = work.now.blocks[index(block)];
    work.stored[slot] = energy.stored[s];
    work.last.length[slot] = step.dynamic() ? island.length : 0.0;
    work.last.velocity[slot] = velocity_vector(now);
    work.last.crowded[index(block)] = static_cast<char>(crowd);
    now = work.end[index(block)];
  }
  set_forces(island, work.now);
  island.time = step.end_time();
  island.done += island.length;
  if (island.length_after > 0.0) island.length = std::exchange(island.length_after, 0.0);
  island.memory.solver.move_on();
  ++island.count.sub_steps;
  island.history.exchange(island.attempt.contacts);
  std::swap(island.found, island.found_end);
  island.reach = island.reach_end;
}

/// Where the island stands, for another attempt.
void reject(const StepRun& run, Island& island, double length) {
  for (const int block : island.own())
    run.work.end[index(block)] = run.work.now.blocks[index(block)];
  island.length = length;
}

/// A step with an impact is parted shortly before its first one, once: until then contacts push, in
/// what is left the impact is all. In a crowd there are impacts in all of it. Length of that part,
/// s; 0: the attempt stands.
double part_before_impact(const Island& island, double smallest) {
  if (island.memory.solver.yielding()) return 0.0;
  const double part = island.length * (island.attempt.first_impact - kBeforeImpact);
  const bool worth = part >= std::max(kBeforeImpact * island.length, smallest);
  return island.solved && !island.parted && worth ? part : 0.0;
}

/// Islands that stand at the earliest time, and of these those with the longest next sub-step.
/// `jump`: of the step, s; there a sub-step ends.
void next_group(std::span<Island* const> islands, double time_step, double jump, Islands& group) {
  group.clear();
  const auto key = [&](const Island& island) { return std::pair(island.done, -island.length); };
  for (Island* island : islands) {
    if (!(island->done < time_step * (1.0 - kEnd))) continue;
    const double stop = island->done < jump * (1.0 - kEnd) ? jump : time_step;
    island->length = std::min(island->length, stop - island->done);
    if (!group.empty() && key(*island) < key(*group.front())) group.clear();
    if (group.empty() || key(*island) == key(*group.front())) group.push_back(island);
  }
}

/// Tries the next sub-step of islands that stand at one time and try one length.
void try_group(const StepRun& run, const Islands& group) {
  Workspace& work = run.work;
  attempt(run, group);
  for (Island* island : group) count_attempt(*island);
  work.clock.charge(&PhaseSeconds::update);
}

/// Contacts of each, and its blocks where they stand.
void begin_group(const StepRun& run, const Islands& group) {
  const SubStep step = sub_step(run, *group.front());
  place_idle(run, step.time, step.end_time());
  run.work.clock.charge(&PhaseSeconds::assemble);
  side_by_side(run, group, [&](Island& island) { begin(run, island); });
}

/// How much of the step goes before the velocity of a support jumps within it, s; all: none does.
double before_jump(const StepRun& run) {
  constexpr double kAtEnd = 1e-6;  // of the step: see velocity_inside()
  const double step = run.options.time_step, from = run.state.time, end = from + step;
  double first = end;
  for (const int block : run.compiled.prescribed)
    first = next_jump(run.compiled.scene.blocks[index(block)].motion, from, first);
  if (std::min(first - from, end - first) < kAtEnd * step) return step;
  double part = first - from;
  while (from + part < first) part = std::nextafter(part, step);
  return part;
}

/// All sub-steps of a dynamic step, of each island by itself. The island whose sub-step can't be
/// shortened any more, or null.
Island* take_sub_steps(const StepRun& run, std::span<Island* const> islands) {
  const StepOptions& options = run.options;
  StepReport& report = run.report;
  const double smallest = options.smallest_time_step > 0.0 ? options.smallest_time_step
                                                           : options.time_step / kSmallestStep;
  Islands& group = run.work.group;
  const double jump = before_jump(run);
  for (;;) {
    next_group(islands, options.time_step, jump, group);
    if (group.empty()) return nullptr;
    begin_group(run, group);
    const bool can_cut = 0.5 * group.front()->length >= smallest;
    if (can_cut) {
      report.cuts_by_contact += static_cast<int>(std::erase_if(group, [&](Island* island) {
        const int cuts = halvings(run, *island);
        island->length = std::max(std::ldexp(island->length, -cuts), smallest);
        return cuts > 0;
      }));
      if (group.empty()) continue;
    }
    try_group(run, group);
    for (Island* island : group) {
      if (const double part = part_before_impact(*island, smallest); part > 0.0) {
        island->parted = true;
        island->length_after = island->length;
        reject(run, *island, part);
        continue;
      }
      const bool too_far = options.max_displacement_ratio > 0.0 &&
                           island->attempt.displacement > options.max_displacement_ratio;
      const double growth = island->solved ? energy_growth(run, *island) : 0.0;
      const bool can_halve = can_cut && island->length > kShortestForEnergy * options.time_step;
      if (const Fate fate = judge(run, *island, growth, can_halve); fate != Fate::End) {
        reject(run, *island, (fate == Fate::Halved ? 0.5 : 1.0) * island->length);
        continue;
      }
      const double share = island->memory.solver.note(island->solved, can_cut);
      if (island->solved && !(too_far && can_cut)) {
        accept(run, *island, growth);
        const bool at_jump = std::abs(island->done - jump) <= kEnd * options.time_step;
        if (at_jump && jump < options.time_step) island->length = options.time_step - jump;
        continue;
      }
      (island->solved ? report.cuts_by_displacement : report.cuts_by_convergence)++;
      if (share < 1.0 && 0.5 * island->length < smallest) return island;
      reject(run, *island, share * island->length);
    }
  }
}

/// One step towards equilibrium, of each island by itself. The island that has none, or null.
Island* take_static_step(const StepRun& run, std::span<Island* const> islands) {
  EquilibriumSearch& search = run.work.search;
  StepReport& report = run.report;
  Islands open(islands.begin(), islands.end());
  double tau = search.pseudo_step;
  for (int cut = 0; cut <= kStaticCuts && !open.empty(); ++cut, tau *= 0.5) {
    for (Island* island : open) island->length = tau;
    begin_group(run, open);
    try_group(run, open);
    std::erase_if(open, [&](Island* island) {
      island->stride = island->solved
                           ? stride(run.compiled, island->own(), run.work.now.blocks, run.work.end)
                           : 0.0;
      const bool taken = island->solved && (!too_long(island->stride) || cut == kStaticCuts);
      if (taken) {
        accept(run, *island, energy_growth(run, *island));
        search.pseudo_step = std::min(search.pseudo_step, tau);
        return true;
      }
      (island->solved ? report.cuts_by_displacement : report.cuts_by_convergence)++;
      if (cut < kStaticCuts) reject(run, *island, tau);
      return false;
    });
  }
  return open.empty() ? nullptr : open.front();
}

/// Nothing moved in this step, and nothing will in the next.
bool stands(const StepRun& run) {
  const CompiledScene& compiled = run.compiled;
  return compiled.prescribed.empty() &&
         std::ranges::all_of(run.work.islands, [&](const auto& island) {
           return run.work.at_rest[index(island->own().front())] != 0;
         });
}

void add(const EnergyLedger& done, EnergyLedger& energy) {
  energy.potential += done.potential;
  energy.work += done.work;
  energy.friction_loss += done.friction_loss;
  energy.impact_loss += done.impact_loss;
  energy.algorithmic_loss += done.algorithmic_loss;
  energy.closure += done.closure;
}

/// Energies of the blocks of an island, at the end of the step.
EnergySums energy_sums(const StepRun& run, const Island& island, const State& state) {
  EnergySums sums;
  for (const int block : island.own()) {
    const std::size_t b = index(block);
    const BlockModel& model = run.compiled.models[b];
    // What is at rest has none.
    if (!run.work.at_rest[b]) sums.kinetic += kinetic_energy(model, state.blocks[b]);
    sums.strain += strain_energy(model, state.blocks[b]);
    sums.contact += run.work.stored[index(run.compiled.slots.slot_of_block[b])];
  }
  return sums;
}

/// Islands at rest keep their sums.
void sum_energies(const StepRun& run, State& state) {
  Workspace& work = run.work;
  EnergySums all;
  for (const auto& island : work.islands) {
    if (!island->at_rest || island->summed != work.search_epoch) {
      island->sums = energy_sums(run, *island, state);
      island->summed = work.search_epoch;
    }
    all.kinetic += island->sums.kinetic;
    all.strain += island->sums.strain;
    all.contact += island->sums.contact;
  }
  state.energy.kinetic = all.kinetic;
  state.energy.strain = all.strain;
  state.energy.contact = all.contact;
}

/// The sub-steps that were accepted become the state. `reached`: their time, s.
void commit(const StepRun& run, double reached, std::span<Island* const> islands, State& state) {
  Workspace& work = run.work;
  for (std::size_t p = 0; p < run.compiled.prescribed.size(); ++p) {
    const PrescribedMotion motion = motion_at(run, p, reached);
    const std::size_t b = index(run.compiled.prescribed[p]);
    if (reached != state.time) work.now.blocks[b] = prescribed_at(run, p, motion);
    work.motion_end[p] = motion;
  }
  std::swap(work.motion, work.motion_end);
  std::swap(state.blocks, work.now.blocks);
  std::swap(state.held_forces, work.now.held_forces);
  std::swap(state.ties, work.now.ties);
  std::swap(state.quiet_forces, work.now.quiet_forces);
  for (const Island* island : islands) {
    const bool still = island->still && island->count.sub_steps == 1 && island->count.solves == 0;
    for (const int block : island->own()) work.at_rest[index(block)] = still;
    add(island->energy, state.energy);
  }
  sum_energies(run, state);
  state.time = reached;
  take_contacts(run, state.contacts);
}

/// The attempt of `island`, and where all others stand.
State attempted(const StepRun& run, const Island& island) {
  State best;
  best.time = sub_step(run, island).end_time();
  best.step = run.state.step;
  best.origin = run.state.origin;
  best.energy = run.state.energy;
  add(island.energy, best.energy);
  best.blocks = run.work.end;
  best.held_forces = run.work.now.held_forces;
  best.ties = run.work.now.ties;
  best.quiet_forces = run.work.now.quiet_forces;
  set_forces(island, best);
  best.contacts = run.state.contacts;
  replace_awake(run, island.attempt.contacts, best.contacts);
  return best;
}

/// Says why there is no step, and keeps the best attempt.
void give_up(const StepRun& run, const Island& failed, State& best) {
  run.report.status = failed.sound ? StepStatus::NotConverged : StepStatus::Diverged;
  if (!failed.sound) return;
  best = attempted(run, failed);
  run.work.best_motion = run.work.motion_end;
  if (is_paper_method(run.options.method)) return;
  run.report.fighting = fighting(run, failed);
}

/// Where few blocks move, contact points of these alone are searched for and listed.
void choose_search(const CompiledScene& compiled, Workspace& work) {
  constexpr std::size_t kMany = 8;  // blocks for each that moves; changes no answer
  std::size_t awake = 0;
  for (const Island* island : work.awake) awake += island->own().size();
  const bool few = awake * kMany < compiled.models.size();
  work.searched = few ? Searched::MovedBlocks : Searched::AllBlocks;
  if (few) work.found_end.clear();
}

/// Takes the step of all islands that are not at rest, and again of those that have met in it. The
/// one that can't be solved, or null: where there are others it is tried with all of them, so that
/// what is reached is reached by all.
Island* take_islands(const StepRun& run) {
  const bool dynamic = run.options.analysis == Analysis::Dynamic;
  const auto take = dynamic ? take_sub_steps : take_static_step;
  Islands& islands = run.work.awake;
  form_islands(run);
  wake_islands(run);
  list_awake(run.work, islands);
  choose_search(run.compiled, run.work);
  while (!islands.empty()) {
    start_islands(run, islands);
    Island* failed = take(run, islands);
    list_awake(run.work, islands);
    if (failed != nullptr && islands.size() == 1) return failed;
    if (failed != nullptr)
      form_whole_scene(run);
    else if (!join_islands_that_met(run))
      return nullptr;
    list_awake(run.work, islands);
    std::erase_if(islands, [](const Island* island) { return island->begun; });
  }
  return nullptr;
}

/// Which blocks the next step finds otherwise than this one did; blocks that were laid are so no
/// more, or stand, which changes them all.
void note_changed(const StepRun& run) {
  Workspace& work = run.work;
  work.changed = run.compiled.prescribed;
  for (const Island* island : work.awake)
    work.changed.insert(work.changed.end(), island->own().begin(), island->own().end());
  if (!work.all_changed) return;
  for (std::size_t b = 0; b < work.laid.size(); ++b) {
    const bool stands = run.compiled.idle[b] != 0 && work.laid[b] != kMet;
    work.laid[b] = stands ? kStands : kMet;
  }
  work.all_changed = std::ranges::find(work.before.laid, kLaid) != work.before.laid.end();
}

/// A step begins: what it may change is kept, and blocks are where the state has them.
void keep_memory(const CompiledScene& compiled, const State& state, Workspace& work) {
  if (work.all_changed) {
    work.before = work;
    work.now.blocks = work.end = state.blocks;
    return;
  }
  StepMemory& before = work.before;
  before.still = work.still;
  before.report = work.report;
  before.counted = work.counted;
  before.search = work.search;
  before.motion = work.motion;
  for (const int block : work.changed) {
    const std::size_t b = index(block);
    work.now.blocks[b] = work.end[b] = state.blocks[b];
    before.energy_scale[b] = work.energy_scale[b];
    before.at_rest[b] = work.at_rest[b];
    before.last.hit[b] = work.last.hit[b];
    before.last.crowded[b] = work.last.crowded[b];
    const int slot = compiled.slots.slot_of_block[b];
    if (slot < 0) continue;
    before.last.length[index(slot)] = work.last.length[index(slot)];
    before.last.velocity[index(slot)] = work.last.velocity[index(slot)];
    before.stored[index(slot)] = work.stored[index(slot)];
  }
}

/// A motion given by the scene leads nowhere.
struct MotionDiverged {};

/// Asked for the very time that is committed, which differs from that of the last sub-step by
/// rounding, and where no block is awake.
void check_motions(const StepRun& run, double reached) {
  for (std::size_t p = 0; p < run.compiled.prescribed.size(); ++p)
    if (!is_sound(prescribed_at(run, p, motion_at(run, p, reached)))) throw MotionDiverged();
}

void take_step(const StepRun& run, State& state, State& best) {
  Workspace& work = run.work;
  const bool dynamic = run.options.analysis == Analysis::Dynamic;
  const double end = counted_end(run.options, state, work.counted);
  if (dynamic) work.search = {};
  if (!dynamic && work.search.start.empty()) begin_search(run.compiled, state, work.search);
  work.now.held_forces = state.held_forces;
  work.now.ties = state.ties;
  work.now.quiet_forces = state.quiet_forces;
  const Island* failed = take_islands(run);
  Islands& islands = work.awake;
  list_awake(work, islands);
  report_islands(islands, run.report);
  const double reached = failed != nullptr
                             ? failed->time
                             : run.state.time + duration(run.options, run.options.time_step);
  check_motions(run, reached);
  if (failed != nullptr) give_up(run, *failed, best);
  commit(run, reached, islands, state);
  ++state.step;
  note_changed(run);
  if (failed != nullptr) return detect(run.compiled, run.options, state, work);
  if (!islands.empty()) take_found(run);
  state.time = work.counted.now = end;
  work.still = stands(run);
  if (dynamic) return;
  double longest = 0.0;
  for (const Island* island : islands) longest = std::max(longest, island->stride);
  judge(run.compiled, run.options, longest, state, work.search, run.report);
}

/// In springs of one stiffness at contacts that overlap, J.
double overlap_energy(double spring, std::span<const geometry::ContactPoint> points) {
  double sum = 0.0;
  for (const geometry::ContactPoint& point : points) {
    const double overlap = std::min(point.gap, 0.0);
    sum += 0.5 * spring * overlap * overlap;
  }
  return sum;
}

}  // namespace

StepReport advance(const CompiledScene& compiled, const StepOptions& options, State& state,
                   State& best, Workspace& work) {
  if (work.still) return stand(options, state, work);
  StepReport report;
  work.clock.start();
  keep_memory(compiled, state, work);
  work.watch.begin(options, report);
  const auto take_back = [&] {
    static_cast<StepMemory&>(work) = work.before;
    place_bodies(compiled, state, work);
  };
  try {
    take_step({compiled, options, state, work.before, work, report}, state, best);
  } catch (const StepStopped&) {
    take_back();
    report.status = StepStatus::Stopped;
  } catch (const MotionDiverged&) {
    take_back();
    report.status = StepStatus::Diverged;
  } catch (...) {  // by a function of time, or for want of memory
    work.watch.end();
    take_back();
    throw;
  }
  work.watch.end();
  report_end(compiled, options, state, work, report);
  work.clock.charge(&PhaseSeconds::update);
  report.seconds = work.clock.seconds;
  if (work.still) work.report = report;
  return report;
}

namespace {

/// Of the springs by which the source's methods hold points, where these stand, J.
double held_energy(const CompiledScene& compiled, double penalty, const State& state) {
  double energy = 0.0;
  for (const HeldPoint& held : compiled.held) {
    const Pose at = pose(state.blocks[index(held.block)]);
    const Vector3 off = displacement(compiled, held, at) - held.displacement.at(state.time);
    energy += 0.5 * penalty * off.squaredNorm();
  }
  return energy;
}

}  // namespace

double initial_spring_energy(const CompiledScene& compiled, const StepOptions& options,
                             const State& state, Workspace& work) {
  std::ranges::fill(work.stored, 0.0);
  if (work.stored.empty()) return 0.0;
  if (is_paper_method(options.method)) {
    const double penalty = contact_spring(compiled, options);
    double& stored = work.stored.front();
    stored = held_energy(compiled, penalty, state);
    if (options.method == ContactMethod::Penalty) stored += overlap_energy(penalty, work.found);
    return stored;
  }
  std::vector<Pose> poses;
  for (const BlockState& block : state.blocks) poses.push_back(pose(block));
  std::vector<BodyContact> contacts;
  const double opening = largest_opening(compiled, state.contacts);
  const SearchedState searched{state.blocks, opening, state.time};
  KnownReaches reaches;
  const double reach = Reach(compiled, options, searched, {}, reaches).largest();
  std::vector<int> previous;
  carry_over({compiled.scene, poses, compiled.models, reach, work.laid,
              options.analysis == Analysis::Dynamic},
             work.found, state.contacts, previous, contacts);
  store_at_rest(compiled, options, poses, contacts, work.stored);
  for (std::size_t t = 0; t < compiled.ties.size(); ++t) {
    const Tie& tie = compiled.ties[t].tie;
    const int a = tie.a < 0 ? -1 : compiled.slots.slot_of_block[index(tie.a)];
    const int slot = a >= 0 ? a : compiled.slots.slot_of_block[index(tie.b)];
    work.stored[index(slot)] += stored_energy(tie, state.ties[t]);
  }
  return std::accumulate(work.stored.begin(), work.stored.end(), 0.0);
}

}  // namespace quoin::solver
