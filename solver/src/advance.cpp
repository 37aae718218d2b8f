#include "advance.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <sstream>

#include "checkpoint.hpp"
#include "contact/joint_law.hpp"
#include "entrance_plane.hpp"
#include "paper_step.hpp"
#include "step.hpp"

namespace quoin::solver {
namespace {

constexpr double kLargestHop = 0.1;   // of the smaller block of a pair
constexpr double kMissed = 1e-9;      // of the same: an overlap that is none
constexpr double kBesideFace = 1e-3;  // of the same: pairs farther apart at the end did not touch
constexpr int kStaticCuts = 10;       // halvings of a pseudo-step: to a millionth of its motion
constexpr double kFlat = 1e-9;    // of its volume: a block squeezed to less is turned inside out
constexpr double kThrough = 0.5;  // of the same: what is so deep has not passed beside

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// Of the smaller of two blocks, m.
double pair_size(const CompiledScene& compiled, int a, int b) {
  return std::min(compiled.models[index(a)].size, compiled.models[index(b)].size);
}

double vertex_speed(const BlockModel& model, const BlockState& block) {
  return block.velocity.norm() + 0.5 * model.size * block.angular_velocity.norm();
}

/// Twice what a vertex can move in a step (paper, section 3), and never less than a hair of a
/// block.
double wanted_reach(const CompiledScene& compiled, const StepOptions& options, const State& state) {
  if (options.analysis != Analysis::Dynamic) return static_reach(compiled);
  const double dt = options.time_step;
  const double fall = compiled.scene.gravity.at(state.time + dt).norm() * dt * dt;
  const double least = 1e-4 * compiled.smallest_size;
  double speed = 0.0;
  for (std::size_t b = 0; b < state.blocks.size(); ++b) {
    speed = std::max(speed, vertex_speed(compiled.models[b], state.blocks[b]));
  }
  return std::max(2.0 * (speed * dt + fall), least);
}

/// By at most an eighth: a speed that changes by a hair changes no reach, and what was found for
/// pairs that stand still stays good.
double rounded_up(double reach) {
  int exponent = 0;
  const double mantissa = std::frexp(reach, &exponent);  // 0.5 .. 1
  return std::ldexp(std::ceil(16.0 * mantissa) / 16.0, exponent);
}

/// A joint that has dilated is closed at a gap, and has not forgotten it when it comes down from a
/// hop that is small against the blocks.
double largest_opening(const CompiledScene& compiled, const State& state) {
  if (!compiled.dilates) return 0.0;
  double largest = 0.0;
  for (const Contact& c : state.contacts) {
    if (!(c.slip > 0.0)) continue;
    const Joint& joint = joint_between(compiled.scene, c.point.key.a, c.point.key.b);
    const double hop = kLargestHop * pair_size(compiled, c.point.key.a, c.point.key.b);
    largest = std::max({largest, opening(joint, c), std::min(c.point.gap, hop)});
  }
  return rounded_up(largest);
}

geometry::FindCounts find(const CompiledScene& compiled, const StepOptions& options,
                          const State& state, std::vector<geometry::ContactPoint>& found,
                          Workspace& work) {
  work.reach =
      options.reach > 0.0 ? options.reach : rounded_up(wanted_reach(compiled, options, state));
  work.reach += largest_opening(compiled, state);
  work.finder.set_reach(work.reach);
  const auto move = [&](int block) {
    const std::size_t b = index(block);
    work.finder.move(block, placement(compiled.models[b], pose(state.blocks[b])));
  };
  std::ranges::for_each(compiled.slots.block_of_slot, move);
  std::ranges::for_each(compiled.prescribed, move);
  const geometry::FindCounts counts = work.finder.find(found);
  // A placement holds what the rest of a centroid is not.
  for (geometry::ContactPoint& point : found) {
    const BlockState &a = state.blocks[index(point.key.a)], &b = state.blocks[index(point.key.b)];
    point.gap += point.normal.dot(b.centroid_rest - a.centroid_rest);
  }
  if (!work.initial_depths.empty()) work.initial_depths.take_off(compiled.models, state, found);
  return counts;
}

void begin(const CompiledScene& compiled, const State& state, Workspace& work) {
  work.poses.start.clear();
  for (const BlockState& block : state.blocks) work.poses.start.push_back(pose(block));
  carry_over({compiled.scene, work.poses.start, compiled.models, work.reach, work.laid}, work.found,
             state.contacts, work.contacts);
}

/// A step in which two blocks near each other move by more than half the smaller one can jump over
/// a contact: it is cut before it is tried.
bool too_fast(const CompiledScene& compiled, const State& state, double dt, const Workspace& work) {
  for (const BodyContact& contact : work.contacts) {
    const std::size_t a = index(contact.a), b = index(contact.b);
    const double speed = vertex_speed(compiled.models[a], state.blocks[a]) +
                         vertex_speed(compiled.models[b], state.blocks[b]);
    const double size = pair_size(compiled, contact.a, contact.b);
    if (speed * dt > 0.5 * size && contact.state.point.gap < speed * dt) return true;
  }
  return false;
}

/// `points` are sorted by key.
std::span<const geometry::ContactPoint> points_of_pair(
    const std::vector<geometry::ContactPoint>& points, int a, int b) {
  const auto pair = [](const geometry::ContactPoint& p) { return std::pair(p.key.a, p.key.b); };
  const auto range = std::ranges::equal_range(points, std::pair(a, b), {}, pair);
  return {range.begin(), range.end()};
}

/// Closed contacts of pairs that are apart at the end of the attempt: the plane of a face held a
/// vertex that passed beside it. They are dropped; true when there were any.
bool drop_ghosts(const CompiledScene& compiled, Workspace& work) {
  const auto apart = [&](const BodyContact& contact, const LinearContact& solved) {
    if (contact.was_closed || solved.mode == ContactMode::Open) return false;
    const double smaller = pair_size(compiled, contact.a, contact.b);
    if (solved.relative[0] < -kThrough * smaller) return false;  // a spring so soft: flagged
    double gap = work.reach;
    for (const geometry::ContactPoint& p : points_of_pair(work.found_end, contact.a, contact.b)) {
      gap = std::min(gap, p.gap);
    }
    const double rebound = contact.joint.restitution > 0.0 ? work.reach : 0.0;
    const double beside = kBesideFace * smaller;
    return gap > contact.opening + beside + rebound;
  };
  const std::size_t solved = work.linear.size() - compiled.held.size();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    if (i < solved && apart(work.contacts[i], work.linear[i])) continue;
    if (kept != i) work.contacts[kept] = work.contacts[i];
    ++kept;
  }
  const bool any = kept < work.contacts.size();
  work.contacts.resize(kept);
  return any;
}

BodyContact missed_contact(const CompiledScene& compiled, const geometry::ContactPoint& point,
                           const Workspace& work) {
  BodyContact added = make_body_contact({compiled.scene, compiled.models, work.poses.end}, point);
  added.state.failed = true;
  const auto points = points_of_pair(work.found_end, added.a, added.b);
  added.joint_points = static_cast<int>(points.size());
  for (const geometry::ContactPoint& p : points) added.joint_area += p.area;
  return added;
}

/// Contacts that overlap at the end of an attempt though the step did not hold them: added to the
/// list as the bodies hold them at the end. True when there are any.
bool add_missed(const CompiledScene& compiled, Workspace& work) {
  std::vector<geometry::ContactKey> keys;  // that the step knew
  std::vector<std::pair<int, int>> soft;   // pairs that a closed contact holds, but not exactly
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    const BodyContact& contact = work.contacts[i];
    const LinearContact& c = work.linear[i];
    keys.push_back(contact.state.point.key);
    if (c.mode == ContactMode::Open) continue;
    if (c.compliant || work.yielding) soft.emplace_back(contact.a, contact.b);
  }
  std::ranges::sort(keys);
  std::ranges::sort(soft);
  const std::size_t known = work.contacts.size();
  for (const geometry::ContactPoint& point : work.found_end) {
    if (!(point.gap < -kMissed * pair_size(compiled, point.key.a, point.key.b)) ||
        std::ranges::binary_search(keys, point.key) ||
        std::ranges::binary_search(soft, std::pair(point.key.a, point.key.b))) {
      continue;
    }
    work.missing = &point;
    work.contacts.push_back(missed_contact(compiled, point, work));
  }
  return work.contacts.size() > known;
}

void book(const CompiledScene& compiled, State& state, Workspace& work) {
  const Attempt& attempt = work.attempt;
  EnergyLedger& energy = state.energy;
  const double before = energy.mechanical();
  energy.kinetic = kinetic_energy(compiled, state);
  energy.strain = strain_energy(compiled, state);
  energy.contact = attempt.spring_energy;
  energy.potential -= attempt.gravity_work;
  energy.work += attempt.load_work;
  energy.friction_loss += attempt.friction_work;
  energy.impact_loss += attempt.impact_loss - attempt.contact_work;
  energy.algorithmic_loss += attempt.scheme_loss;
  work.energy_scale.note(energy);
  work.energy_growth =
      std::max(work.energy_growth, energy.mechanical() - before - attempt.load_work);
  energy.closure += before + attempt.load_work - energy.mechanical() - attempt.friction_work -
                    (attempt.impact_loss - attempt.contact_work) - attempt.scheme_loss;
}

bool constant_loads(const CompiledScene& compiled) {
  const auto constant = [](const auto& load) { return load.force.is_constant(); };
  const auto at_rest = [](const HeldPoint& held) { return held.displacement.is_constant(); };
  return compiled.scene.gravity.is_constant() && compiled.prescribed.empty() &&
         std::all_of(compiled.loads.begin(), compiled.loads.end(), constant) &&
         std::all_of(compiled.held.begin(), compiled.held.end(), at_rest);
}

bool at_rest(const BlockState& block) { return velocity_vector(block).isZero(0.0); }

/// The attempt took all forces as they were, and nothing moved, to the last bit.
bool stood_still(const CompiledScene& compiled, const State& start, const Workspace& work) {
  const Attempt& attempt = work.attempt;
  const auto zero = [](const Vector12& increment) { return increment.isZero(0.0); };
  return attempt.solved.solves == 0 && constant_loads(compiled) &&
         std::all_of(work.poses.increment.begin(), work.poses.increment.end(), zero) &&
         std::all_of(start.blocks.begin(), start.blocks.end(), at_rest) &&
         std::all_of(attempt.end.blocks.begin(), attempt.end.blocks.end(), at_rest);
}

/// Time is counted in steps, not added up: a million steps of dt end at a million dt.
double counted_end(const StepOptions& options, const State& state, Workspace& work) {
  Counted& clock = work.counted;
  const double step = duration(options, options.time_step);
  if (clock.time_step != step || clock.now != state.time) clock = {state.time, step, state.time, 0};
  ++clock.steps;
  return clock.start + static_cast<double>(clock.steps) * step;
}

/// A step like the last one, in which nothing moved.
StepReport stand(const StepOptions& options, State& state, Workspace& work) {
  const StepReport& last = work.report;
  state.time = counted_end(options, state, work);
  work.counted.now = state.time;
  ++state.step;
  StepReport report = last;
  report.time = state.time;
  report.candidate_pairs = report.searched_pairs = 0;
  report.seconds = {};
  return report;
}

void accept(const CompiledScene& compiled, const StepOptions& options, State& state,
            Workspace& work) {
  Attempt& attempt = work.attempt;
  work.still = stood_still(compiled, state, work);
  work.last_time_step = 0.0;
  if (options.analysis == Analysis::Dynamic) {
    work.last_time_step = attempt.end.time - state.time;
    work.last_velocity.clear();
    for (const int block : compiled.slots.block_of_slot) {
      work.last_velocity.push_back(velocity_vector(state.blocks[index(block)]));
    }
  }
  std::swap(state, attempt.end);
  work.motion = attempt.motion;
  book(compiled, state, work);
}

void add(const Attempt& attempt, const CompiledScene& compiled, StepReport& report) {
  report.iterations += attempt.solved.iterations;
  report.linear_solves += attempt.solved.solves;
  report.factorizations += attempt.solved.factorizations;
  report.residual = attempt.solved.residual;
  if (attempt.solved.condition > 0.0) report.condition = attempt.solved.condition;
  report.unbalance = attempt.unbalance;
  report.stiffest_omega_dt = std::max(report.stiffest_omega_dt, attempt.stiffest_omega_dt);
  for (std::size_t b = 0; b < attempt.end.blocks.size(); ++b) {
    report.largest_strain =
        std::max(report.largest_strain, attempt.end.blocks[b].strain.cwiseAbs().maxCoeff());
    report.largest_speed =
        std::max(report.largest_speed, vertex_speed(compiled.models[b], attempt.end.blocks[b]));
  }
}

void report_end(const State& state, const Workspace& work, StepReport& report) {
  report.time = state.time;
  report.contact_count = static_cast<int>(state.contacts.size());
  for (const Contact& contact : state.contacts) {
    report.closed_count += contact.mode != ContactMode::Open;
  }
  for (const geometry::ContactPoint& point : work.found) {
    report.largest_overlap = std::max(report.largest_overlap, -point.gap);
  }
}

/// Of all blocks that move, N.
double weight(const CompiledScene& compiled, double time) {
  double mass = 0.0;
  for (const int block : compiled.slots.block_of_slot) mass += compiled.models[index(block)].mass;
  return mass * compiled.scene.gravity.at(time).norm();
}

void report_flags(const CompiledScene& compiled, const StepOptions& options, const State& state,
                  const Workspace& work, StepReport& report) {
  if (options.scheme == TimeScheme::ConstantAcceleration) {
    report.numerical_damping = 0.25 * report.stiffest_omega_dt;  // [Doolin & Sitar 2004]
  }
  const bool dynamic = options.analysis == Analysis::Dynamic;
  const double gap_tolerance = options.tolerance * compiled.smallest_size;
  append_flags(
      compiled, state,
      {.energy_growth = dynamic ? work.energy_growth : 0.0,
       .energy_scale = work.energy_scale.value(),
       .energy_noise = gap_tolerance * weight(compiled, state.time),
       .rounding = gap_rounding(work.linear),
       .gap_tolerance = gap_tolerance,
       .found = work.found,
       .missing = work.missing != nullptr ? work.missing : vanished(state.contacts, work.found)},
      report);
}

/// A state that can be gone on with: finite, and no block turned inside out.
bool is_sound(const State& state) {
  for (const BlockState& block : state.blocks) {
    const double far = block.centroid.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
    const Matrix3 stretch = Matrix3::Identity() + strain_matrix(block.strain);
    if (!(far < geometry::kLargestCoordinate) || !(stretch.determinant() > kFlat) ||
        !block.velocity.allFinite() || !block.rotation.coeffs().allFinite() ||
        !block.strain.allFinite() || !block.angular_velocity.allFinite() ||
        !block.strain_rate.allFinite()) {
      return false;
    }
  }
  return true;
}

/// As the source: contacts are found once, before the step.
void attempt_as_the_source(const CompiledScene& compiled, const StepOptions& options,
                           const State& state, double dt, Workspace& work, StepReport& report) {
  work.yielding = false;
  attempt_paper_step(compiled, options, state, dt, work);
  work.clock.charge(&PhaseSeconds::update);
  if (!is_sound(work.attempt.end)) return;
  const geometry::FindCounts counts =
      find(compiled, options, work.attempt.end, work.found_end, work);
  report.candidate_pairs += counts.candidates;
  report.searched_pairs += counts.searched;
  work.clock.charge(&PhaseSeconds::detect);
}

/// Tries the step, and again with the contacts that it missed and without those that were none.
void attempt_with_all_contacts(const CompiledScene& compiled, const StepOptions& options,
                               const State& state, double dt, Workspace& work, StepReport& report) {
  constexpr int kRounds = 4;
  const Attempt& attempt = work.attempt;
  const double limit = kMissed * compiled.smallest_size;
  std::vector<PassingPair> passing = set_aside_passing(compiled, state, dt, limit, work.contacts);
  work.iterations_left = options.max_iterations;
  for (int round = 0; round < kRounds; ++round) {
    work.missing = nullptr;
    work.watch.look();
    attempt_step(compiled, options, state, dt, work);
    if (attempt.solved.converged && options.analysis == Analysis::Dynamic &&
        options.method != ContactMethod::Springs) {
      apply_velocity_law(compiled, options, state, dt, work);
    }
    work.clock.charge(&PhaseSeconds::update);
    if (!is_sound(attempt.end)) return;
    const geometry::FindCounts counts = find(compiled, options, attempt.end, work.found_end, work);
    report.candidate_pairs += counts.candidates;
    report.searched_pairs += counts.searched;
    work.clock.charge(&PhaseSeconds::detect);
    if (!attempt.solved.converged) return;
    const bool missed = add_missed(compiled, work);
    const bool dropped = drop_ghosts(compiled, work);
    const bool blocked =
        put_back_blocked(compiled, attempt.end, work.found_end, limit, passing, work.contacts);
    if (!missed && !dropped && !blocked) return;
  }
  work.attempt.solved.converged = false;  // contacts still come and go: a shorter step may tell
}

}  // namespace

Workspace::Workspace(const CompiledScene& compiled, int threads)
    : finder({.threads = threads, .frame = geometry::PointFrame::Bodies}),
      laid(compiled.models.size(), 1),
      motion(compiled.prescribed.size()),
      hit(compiled.models.size(), 0),
      open_close(compiled.slots, &watch),
      moving_contacts(compiled.slots, &watch),
      paper_open_close(compiled.slots, &watch) {
  for (std::size_t b = 0; b < compiled.models.size(); ++b) {
    const BlockModel& model = compiled.models[b];
    const bool absent = model.kind == BlockKind::Absent;
    finder.add(
        model.shape, placement(model, pose(model.start)),
        {.category = absent ? 0u : 1u,
         .motion = compiled.idle[b] ? geometry::BodyMotion::Idle : geometry::BodyMotion::Moving});
  }
}

void place_bodies(const CompiledScene& compiled, const State& state, Workspace& work) {
  for (std::size_t b = 0; b < compiled.models.size(); ++b) {
    work.finder.move(static_cast<int>(b), placement(compiled.models[b], pose(state.blocks[b])));
  }
}

namespace {

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

double initial_spring_energy(const CompiledScene& compiled, const StepOptions& options,
                             const State& state, Workspace& work) {
  if (options.method == ContactMethod::Paper) return 0.0;
  if (options.method == ContactMethod::Penalty) {
    return overlap_energy(contact_spring(compiled, options), work.found);
  }
  begin(compiled, state, work);
  return spring_energy_at_rest(compiled, options, work);
}

void detect(const CompiledScene& compiled, const StepOptions& options, const State& state,
            Workspace& work) {
  work.still = false;
  find(compiled, options, state, work.found, work);
}

namespace {

void note_before(const StepOptions& options, Workspace& work) {
  if (!options.watch) return;
  work.before.reach = work.reach;
  work.before.counted = work.counted;
  work.before.energy_scale = work.energy_scale;
  work.before.hit = work.hit;
  work.before.rest.clear();
}

/// Before the first of several sub-steps is accepted.
void note_rest(const StepOptions& options, const State& state, Workspace& work) {
  if (!options.watch) return;
  std::ostringstream out;
  write_checkpoint(out, state, work);
  work.before.rest = std::move(out).str();
}

void go_back(State& state, Workspace& work) {
  if (!work.before.rest.empty()) {
    std::istringstream in(work.before.rest);
    read_checkpoint(in, state, work);
  }
  work.reach = work.before.reach;
  work.counted = work.before.counted;
  work.energy_scale = work.before.energy_scale;
  work.hit = work.before.hit;
}

/// One attempt at [time, time + dt]. True when it solved the step.
bool try_step(const CompiledScene& compiled, const StepOptions& options, const State& state,
              double dt, Workspace& work, StepReport& report) {
  (is_paper_method(options.method) ? attempt_as_the_source : attempt_with_all_contacts)(
      compiled, options, state, dt, work, report);
  if (work.yielding) ++report.interior_point_attempts;
  if (!is_sound(work.attempt.end)) return false;
  add(work.attempt, compiled, report);
  return work.attempt.solved.converged;
}

void take_attempt(const CompiledScene& compiled, const StepOptions& options, State& state,
                  Workspace& work, StepReport& report) {
  accept(compiled, options, state, work);
  std::swap(work.found, work.found_end);
  ++report.sub_steps;
  work.clock.charge(&PhaseSeconds::update);
}

/// Of the last attempt: contacts whose force the next iteration would change most.
FightingContacts fighting(const State& state, const Workspace& work) {
  std::vector<FightingContact> all;  // the worst of each pair
  for (std::size_t i = 0; i < work.contacts.size() && i < work.linear.size(); ++i) {
    const BodyContact& contact = work.contacts[i];
    const LinearContact& c = work.linear[i];
    const double change = (force_after_update(c) - c.force).norm();
    if (!(change > 0.0)) continue;
    const FightingContact now{contact.a, contact.b, state.origin + contact.state.point.point(),
                              change};
    if (all.empty() || all.back().block != now.block || all.back().other != now.other) {
      all.push_back(now);
    } else if (now.change > all.back().change) {
      all.back() = now;
    }
  }
  std::ranges::stable_sort(all, std::greater{}, &FightingContact::change);
  FightingContacts worst;
  worst.count = std::min(all.size(), worst.contacts.size());
  std::copy_n(all.begin(), worst.count, worst.contacts.begin());
  return worst;
}

void give_up(const StepOptions& options, State& best, Workspace& work, StepReport& report) {
  if (!is_sound(work.attempt.end)) {
    report.status = StepStatus::Diverged;
    return;
  }
  report.status = StepStatus::NotConverged;
  best = work.attempt.end;
  work.best_motion = work.attempt.motion;
  if (!is_paper_method(options.method)) report.fighting = fighting(best, work);
}

/// One step towards equilibrium. `report` grows as it is done.
void take_static_step(const CompiledScene& compiled, const StepOptions& options, State& state,
                      State& best, Workspace& work, StepReport& report) {
  if (work.search.start.empty()) begin_search(compiled, state, work.search);
  double tau = work.search.pseudo_step;
  for (int cut = 0; cut <= kStaticCuts; ++cut, tau *= 0.5) {
    begin(compiled, state, work);
    const bool solved = try_step(compiled, options, state, tau, work, report);
    const double moved = solved ? stride(compiled, state, work.attempt.end) : 0.0;
    if (solved && (!too_long(moved) || cut == kStaticCuts)) {
      take_attempt(compiled, options, state, work, report);
      work.search.pseudo_step = tau;
      judge(compiled, options, moved, state, work.search, report);
      return;
    }
    (solved ? report.cuts_by_displacement : report.cuts_by_convergence)++;
  }
  give_up(options, best, work, report);
}

/// The sub-steps of one dynamic step. `report` grows as they are done.
void take_sub_steps(const CompiledScene& compiled, const StepOptions& options, State& state,
                    State& best, Workspace& work, StepReport& report) {
  const double smallest =
      options.smallest_time_step > 0.0 ? options.smallest_time_step : options.time_step / 1024.0;
  work.search = {};
  double dt = options.time_step;
  for (double done = 0.0; done < options.time_step * (1.0 - 1e-12);) {
    dt = std::min(dt, options.time_step - done);
    begin(compiled, state, work);
    if (0.5 * dt >= smallest && too_fast(compiled, state, dt, work)) {
      ++report.cuts_by_contact;
      dt *= 0.5;
      continue;
    }
    const bool solved = try_step(compiled, options, state, dt, work, report);
    const bool too_far = options.max_displacement_ratio > 0.0 &&
                         work.attempt.displacement > options.max_displacement_ratio;
    if (solved && !(too_far && 0.5 * dt >= smallest)) {
      if (done == 0.0 && dt < options.time_step) note_rest(options, state, work);
      take_attempt(compiled, options, state, work, report);
      done += dt;
      continue;
    }
    (solved ? report.cuts_by_displacement : report.cuts_by_convergence)++;
    dt *= 0.5;
    if (dt < smallest) return give_up(options, best, work, report);
  }
}

}  // namespace

StepReport advance(const CompiledScene& compiled, const StepOptions& options, State& state,
                   State& best, Workspace& work) {
  if (work.still) return stand(options, state, work);
  StepReport report;
  work.clock.start();
  work.energy_growth = 0.0;
  note_before(options, work);
  const double end = counted_end(options, state, work);
  work.open_close.linear_solver().choose(options.linear_solver);
  work.watch.begin(options, report);
  try {
    (options.analysis == Analysis::Dynamic ? take_sub_steps : take_static_step)(
        compiled, options, state, best, work, report);
    ++state.step;
    std::ranges::fill(work.laid, 0);
    if (report.status == StepStatus::Converged) state.time = work.counted.now = end;
  } catch (const StepStopped&) {
    go_back(state, work);
    report.status = StepStatus::Stopped;
  }
  work.watch.end();
  report.linear = work.open_close.linear_solver().counts();
  report_end(state, work, report);
  report_flags(compiled, options, state, work, report);
  work.clock.charge(&PhaseSeconds::update);
  report.seconds = work.clock.seconds;
  work.still = work.still && report.sub_steps == 1 && report.linear_solves == 0;
  if (work.still) work.report = report;
  return report;
}

}  // namespace quoin::solver
