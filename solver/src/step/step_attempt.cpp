#include "step/step_attempt.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/index.hpp"
#include "base/rounding.hpp"
#include "contact/joint_failure.hpp"
#include "contact/joint_law.hpp"
#include "contact/joint_springs.hpp"
#include "iteration/contact_problem.hpp"
#include "step/linearise.hpp"

namespace quoin::solver {
namespace {

/// Both anchors to where the contact is now, `stretch` (place of b minus place of a) apart. The
/// anchor of a vertex stays on it.
void move_anchor(const Pose& a, const Pose& b, const ContactGeometry& now, const Vector3& stretch,
                 const BodyContact& contact, Contact& ended) {
  const Vector3 normal_part = now.gap * now.normal;
  if (contact.normal_on_a) {
    ended.anchor_b = contact.arm_b;
    ended.anchor_a = reference_arm(a, now.place_b - normal_part - stretch);
  } else {
    ended.anchor_a = contact.arm_a;
    ended.anchor_b = reference_arm(b, now.place_a + normal_part + stretch - now.between);
  }
}

/// The anchor follows: what stretch is left is the spring's at its limit (none for a multiplier).
Vector3 stretch_left(const Vector3& shear_force, const LinearContact& c, const Vector3& moved) {
  if (!c.compliant || !(c.shear_spring > 0.0)) return Vector3::Zero();
  return stretch_kept(c, moved) * shear_force / c.shear_spring;
}

/// What a spring of a joint with stiffness has stored goes by `stretch`; the anchors, held by
/// blocks that turn, have it but for the second order of the turn, and less well on crossed edges.
void keep_stretch(const Pose& a, const Pose& b, const ContactGeometry& now, const Vector3& stretch,
                  const BodyContact& contact, Contact& state) {
  const Vector3 along = stretch - stretch.dot(now.normal) * now.normal;
  const double size = along.norm();
  const Vector3 has = shear_stretch(a, b, now.normal, state);
  if (!(size > 0.0) || (has - along).norm() <= kRelativeRounding * size) return;
  move_anchor(a, b, now, stretch.norm() / size * along, contact, state);
}

void record_contact(const LinearContact& c, const StepPoses& poses, const BodyContact& contact,
                    Contact& state) {
  const Pose &a = poses.end[index(contact.a)], &b = poses.end[index(contact.b)];
  const ContactGeometry now = contact_geometry(contact, a, b);
  const Vector3 before =
      contact_normal(contact, poses.start[index(contact.a)], poses.start[index(contact.b)]);
  Vector3 t1, t2;
  tangent_frame(contact, 0.5 * (before + now.normal), t1, t2);
  state.mode = c.mode;
  state.next_normal_force = c.force[0];
  state.next_shear_force = -(c.force[1] * t1 + c.force[2] * t2);
  state.point.point_a = a.centroid + now.place_a;
  state.point.point_b = a.centroid + now.place_b;
  state.point.normal = now.normal;
  state.point.gap = now.gap;
  set_force_on_b(c.jacobian_b.rigid.leftCols<3>().transpose() * c.force, state);
  const Vector3 moved = moved_by(poses, contact, c);
  const double slip = slip_in_step(c, moved);
  if (wears_off(*contact.joint, state, slip)) weaken(*contact.joint, state);
  state.slip += slip;
  if (c.mode == ContactMode::Open) return;
  if (c.mode == ContactMode::Slip || (!contact.was_closed && !c.compliant)) {
    move_anchor(a, b, now, stretch_left(state.next_shear_force, c, moved), contact, state);
  } else if (state.spring_area > 0.0) {
    const Vector3 end = c.start + moved, along = end[1] * t1 + end[2] * t2;
    // The tangents of the end: half the turn on from those of the middle.
    keep_stretch(a, b, now, along + half_turn(contact, poses).cross(along), contact, state);
  }
}

/// What a solved sub-step leaves in its contacts: forces, modes, slips, anchors. `contacts`: as
/// they were at the start.
void record(std::span<const BodyContact> contacts, const StepPoses& poses, Attempt& attempt) {
  const auto is_hit = [&](int slot) { return slot >= 0 && attempt.hit[index(slot)]; };
  attempt.contacts.clear();
  attempt.contacts.reserve(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const LinearContact& c = attempt.linear[i];
    Contact& state = attempt.contacts.emplace_back(contacts[i].state);
    state.impact = is_hit(c.slot_a) || is_hit(c.slot_b);
    record_contact(c, poses, contacts[i], state);
  }
}

// Blocks that an impact of a sub-step hits. The impulse of an impact is no force of one step's
// length: it would load the strain of every block it passes through with energy that is not there.
// Hit blocks move rigidly through the step, where they can; their strain goes on in the next.

enum class Impacts { Expected, Solved };

/// Whether a contact ends closed to the gap tolerance, whatever its mode. Where blocks meet just as
/// a step ends nothing is left for forces to do, and which corners of a face these close is a
/// matter of rounding: an impulse at some of them alone would turn the blocks.
bool touches(const SubStep& step, const LinearContact& c) {
  return !c.compliant && c.relative[0] <= step.gap_tolerance();
}

/// A contact that closes faster than what the step does not resolve.
bool is_impact(const SubStep& step, const LinearContact& c, Impacts impacts) {
  if (!c.hits) return false;
  return impacts == Impacts::Expected || c.mode != ContactMode::Open || touches(step, c);
}

/// By slot: blocks that an impact hits, and those that lean on them or touch them: expected from
/// how they move before the step is solved, or as it was solved.
void find_hit_blocks(const SubStep& step, std::span<const BodyContact> contacts,
                     std::span<const LinearContact> linear, Impacts impacts,
                     std::vector<char>& hit) {
  hit.assign(step.island.slots.size.size(), 0);
  if (step.options.method == ContactMethod::Springs || !step.dynamic()) return;
  bool grows = false;
  const auto add = [&](int slot) {
    if (slot < 0 || hit[index(slot)]) return;
    hit[index(slot)] = 1;
    grows = true;
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!is_impact(step, linear[i], impacts)) continue;
    add(linear[i].slot_a);
    add(linear[i].slot_b);
  }
  const auto is_hit = [&](int slot) { return slot >= 0 && hit[index(slot)]; };
  while (grows) {
    grows = false;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (!contacts[i].was_closed && linear[i].start[0] > step.gap_tolerance()) continue;
      if (is_hit(linear[i].slot_a)) add(linear[i].slot_b);
      if (is_hit(linear[i].slot_b)) add(linear[i].slot_a);
    }
  }
}

/// Share of the step that had passed at the first impact that was solved; 0: there is none.
double first_impact(const SubStep& step, std::span<const LinearContact> linear) {
  if (step.options.method == ContactMethod::Springs || !step.dynamic()) return 0.0;
  double first = 0.0;
  for (const LinearContact& c : linear) {
    if (!is_impact(step, c, Impacts::Solved)) continue;
    first = first > 0.0 ? std::min(first, c.closing_share) : c.closing_share;
  }
  return first;
}

/// How far supports (fixed or prescribed blocks that hit blocks touch, points of these that are
/// held) move against each other in the step, m: moving rigidly hit blocks may have no way. `hit`
/// empty: all are.
double shift_of_supports(const SubStep& step, std::span<const BodyContact> contacts,
                         std::span<const LinearContact> linear, std::span<const char> hit,
                         const StepPoses& poses) {
  if (step.compiled.prescribed.empty() && step.compiled.held.empty()) return 0.0;  // none moves
  constexpr double none = std::numeric_limits<double>::infinity();
  const auto is_hit = [&](int slot) { return slot >= 0 && (hit.empty() || hit[index(slot)]); };
  Vector3 high = Vector3::Constant(-none), low = high;  // of their ways, and of these turned
  const auto bear = [&](int slot, const Vector3& way) {
    if (!is_hit(slot)) return;
    high = high.cwiseMax(way);
    low = low.cwiseMax(-way);
  };
  const auto way_of = [&](int block) { return poses.increment[index(block)].head<3>(); };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const LinearContact& c = linear[i];
    if (c.slot_b < 0) bear(c.slot_a, way_of(contacts[i].b));
    if (c.slot_a < 0) bear(c.slot_b, way_of(contacts[i].a));
  }
  for (std::size_t h = 0; h < step.island.held.size(); ++h) {
    const VectorOfTime& way = step.compiled.held[index(step.island.held[h])].displacement;
    bear(linear[contacts.size() + h].slot_b,
         way.at(step.end_time()) - way.at(step.end_time() - step.length));
  }
  Vector3 shift;
  for (int k = 0; k < 3; ++k) shift[k] = high[k] + low[k];
  return shift.minCoeff() >= 0.0 ? shift.norm() : 0.0;  // there are no supports
}

/// Their strain waits. True when there are any that deform.
bool hold_strain(const SubStep& step, std::span<const char> hit, StepPoses& poses) {
  bool any = false;
  for (std::size_t s = 0; s < hit.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    if (!hit[s] || !poses.deforms[b]) continue;
    poses.deforms[b] = 0;
    poses.increment[b].tail<6>().setZero();
    any = true;
  }
  return any;
}

constexpr int kLinearisations = 30;  // then the sub-step is halved
// Linearisations whose changes, above rounding, have not halved in so many go round in circles: of
// 150 000 attempts that end one had more than four such.
constexpr int kCircle = 5;
constexpr int kStrictLinearisations = 10;  // to the last bit; then to the tolerance
// Where contacts yield, of the smallest block. Changes go down quadratically: what the next
// linearisation would still mend is the square of it.
constexpr double kRough = 1e-3;      // one that changed blocks by more is followed by a rough one
constexpr double kAgreement = 1e-9;  // of two linearisations, and, from the fifth on:
constexpr int kQuickLinearisations = 4;
constexpr double kLooseAgreement = 1e-4;  // contacts that go to and fro are left, but for
constexpr int kMostLinearisations = 12;   // so many passes where the blocks end with overlaps of
constexpr double kUnforeseen = 0.3;  // times the crowd's tolerance beyond what the last one says
// Gaps that are mended apart keep linearisations from agreeing: of the smallest block.
constexpr double kMended = 1e-5;
// Of how far supports move against each other: overlaps that tell that hit blocks have no way. Of a
// block that a belt takes into a stop contacts that yield leave 7e-4 of it.
constexpr double kSqueezed = 0.1;
// Times what a crowd may leave of gaps: of held points and between supports more is no solution.
constexpr double kUnsolved = 10.0;

void by_slot(const Slots& slots, const BlockVector& blocks, BlockVector& by_slot) {
  by_slot.resize(slots.block_of_slot.size());
  for (std::size_t s = 0; s < by_slot.size(); ++s)
    by_slot[s] = blocks[index(slots.block_of_slot[s])];
}

void by_block(const Slots& slots, const BlockVector& by_slot, BlockVector& blocks) {
  for (std::size_t s = 0; s < by_slot.size(); ++s)
    blocks[index(slots.block_of_slot[s])] = by_slot[s];
}

/// The first linearisation of an attempt: hit blocks move rigidly from here on, if they are to.
void linearise_first(const SubStep& step, std::span<BodyContact> contacts, AttemptMemory& memory,
                     StepPoses& poses, std::span<LinearContact> linear) {
  BlockTerms& terms = memory.terms;
  set_end(step, poses);
  set_force(step, poses, terms);
  set_free_increment(step, poses, contacts, terms);
  linearise(step, terms, poses, memory.ties, contacts, linear);
  find_hit_blocks(step, contacts, linear, Impacts::Expected, memory.expected_hit);
  if (!memory.strain_waits || !hold_strain(step, memory.expected_hit, poses)) return;
  set_matrices(step, poses, terms);
  set_force(step, poses, terms);
  set_free_increment(step, poses, contacts, terms);
  linearise(step, terms, poses, memory.ties, contacts, linear);
}

void show_contact_problem(const SubStep& step, const BlockTerms& terms,
                          std::span<const LinearContact> linear, const BlockVector& guess) {
  if (!step.options.contact_problem) return;
  if (!std::ranges::all_of(linear, ConeProblem::follows_coulomb)) return;
  step.options.contact_problem(
      contact_problem(step.island.slots, terms.base, terms.force, linear, guess));
}

/// Largest overlap where the blocks end beyond what the linearisations say, m.
double unforeseen_overlap(const StepPoses& poses, std::span<const BodyContact> contacts,
                          std::span<const LinearContact> linear) {
  double largest = 0.0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const BodyContact& contact = contacts[i];
    const Pose &a = poses.end[index(contact.a)], &b = poses.end[index(contact.b)];
    const double gap = contact_geometry(contact, a, b).gap - contact.opening;
    largest = std::max(largest, std::min(linear[i].relative[0], 0.0) - gap);
  }
  return largest;
}

/// Whether what the last linearisation came to is as good for the next one. Changes go down
/// at least as the last two have: where a crowd moves it is enough that the next one would change
/// nothing. Of many blocks that deform, at rest, motions are good to the tolerance alone, as their
/// forces are. `before`: what the one before the last has changed, m.
bool agrees(int pass, const OpenCloseOptions& tuning, double before, double change) {
  const double next = pass > 0 ? change * (change / before) : change;
  if (tuning.moves && next <= tuning.gap_rounding) return true;
  const bool strict = pass < kStrictLinearisations && !tuning.redundant;
  return change <= (strict ? tuning.gap_rounding : tuning.gap_tolerance);
}

/// Linearisations that go to and fro between some never agree.
class Circle {
 public:
  /// `change`: of the last one, m.
  bool closes(double change) {
    since_ = change > 0.5 * halved_ ? since_ + 1 : 0;
    if (since_ == 0) halved_ = change;
    return since_ >= kCircle;
  }

 private:
  double halved_ = std::numeric_limits<double>::infinity();
  int since_ = 0;  ///< it was last halved
};

/// Likewise where contacts yield.
bool nearly_agrees(const SubStep& step, int pass, double change,
                   std::span<const BodyContact> contacts, const StepPoses& poses,
                   std::span<const LinearContact> linear) {
  const double size = step.island.smallest_size;
  if (change <= kAgreement * size) return true;
  if (change > kLooseAgreement * size) return false;
  const double overlap = kUnforeseen * crowd_tolerance(step.options.tolerance) * size;
  const bool foreseen = unforeseen_overlap(poses, contacts, linear) <= overlap;
  return pass >= (foreseen ? kQuickLinearisations : kMostLinearisations);
}

/// v dt by slot.
void set_coasting(const SubStep& step, const StepPoses& poses, BlockVector& coasting) {
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  coasting.resize(blocks.size());
  for (std::size_t s = 0; s < blocks.size(); ++s)
    coasting[s] = step.length * velocity_vector(start_state(step, poses, index(blocks[s])));
}

OpenCloseOptions tuning_of(const SubStep& step, std::span<const BodyContact> contacts) {
  OpenCloseOptions tuning{.force_tolerance = step.options.tolerance,
                          .gap_tolerance = step.gap_tolerance()};
  tuning.raise = step.options.method == ContactMethod::AugmentedLagrangian;
  tuning.at_rest = !step.dynamic();
  tuning.mended_apart = crowd_tolerance(step.options.tolerance) * step.island.smallest_size;
  tuning.breaks = may_fail(contacts);
  tuning.redundant = !step.dynamic() && many_deform(step.island.slots);
  return tuning;
}

/// Linearises where the blocks end, and solves. Of the first linearisation of an attempt or of a
/// later one: tuning.predicted.
OpenCloseResult solve_linearised(const SubStep& step, std::span<BodyContact> contacts,
                                 OpenCloseOptions& tuning, AttemptMemory& memory, StepPoses& poses,
                                 std::span<LinearContact> linear) {
  BlockTerms& terms = memory.terms;
  if (tuning.predicted) {
    linearise_first(step, contacts, memory, poses, linear);
  } else {
    set_force(step, poses, terms);
    linearise(step, terms, poses, memory.ties, contacts, linear);
  }
  tuning.gap_rounding = gap_rounding(linear);
  by_slot(step.island.slots, poses.increment, memory.increment);
  memory.clock.charge(&PhaseSeconds::assemble);
  if (tuning.predicted) {
    tuning.moves = step.dynamic() && is_moving(step.island.slots, memory.increment);
    if (step.dynamic()) set_coasting(step, poses, memory.coasting);
    show_contact_problem(step, terms, linear, memory.increment);
  }
  const FreeMotion free{terms.compliance, memory.coasting};
  if (step.dynamic()) tuning.free = &free;
  const OpenCloseResult solved = memory.solver.solve(step.options, {terms.base, terms.force},
                                                     linear, tuning, memory.increment);
  tuning.free = nullptr;
  memory.clock.charge(&PhaseSeconds::solve);
  by_block(step.island.slots, memory.increment, poses.increment);
  set_end(step, poses);
  measure_slips(poses, contacts, !memory.solver.yielding(), linear);
  return solved;
}

/// Linearise, solve, and again from where it ended, until the solution satisfies its own
/// linearisation.
OpenCloseResult solve_positions(const SubStep& step, std::span<BodyContact> contacts,
                                AttemptMemory& memory, StepPoses& poses,
                                std::span<LinearContact> linear) {
  OpenCloseOptions tuning = tuning_of(step, contacts);
  OpenCloseResult total;
  Circle circle;
  double change = std::numeric_limits<double>::infinity();  // by the last linearisation, m
  for (int pass = 0; pass < kLinearisations; ++pass) {
    tuning.predicted = pass == 0;
    tuning.rough = pass < kQuickLinearisations && !(change <= kRough * step.island.smallest_size);
    const OpenCloseResult solved = solve_linearised(step, contacts, tuning, memory, poses, linear);
    add(solved, total);
    total.closed = solved.closed;  // of the last linearisation
    if (!solved.converged) break;
    if (tuning.moves) tuning.softness = solved.softness;
    const double before = std::exchange(change, solved.change);
    const bool agreed =
        memory.solver.yielding()
            ? !tuning.rough && nearly_agrees(step, pass, change, contacts, poses, linear)
        : solved.closed ? agrees(pass, tuning, before, change)
                        : pass > 0 || change <= kMended * step.island.smallest_size;
    // Where a prediction is right the first linearisation changes nothing, and knows no slip yet.
    const bool lags = agreed && pass < kStrictLinearisations &&
                      slip_lags(step.options, contacts, linear, step.options.tolerance);
    if (agreed && !lags) break;
    total.converged = false;  // until the next linearisation agrees
    if (circle.closes(change) && change > tuning.mended_apart) break;
  }
  return total;
}

/// The state that the increments lead to.
BlockState end_state(const SubStep& step, const StepPoses& poses, std::size_t block) {
  const Vector12& d = poses.increment[block];
  BlockState end = displaced(step.state[block], d);
  if (!step.dynamic()) {
    end.velocity.setZero();
    end.angular_velocity.setZero();
    end.strain_rate.setZero();
    return end;
  }
  end = with_end_velocity(end, start_state(step, poses, block), d, step.length);
  if (!poses.deforms[block]) end.strain_rate.setZero();
  return end;
}

/// What is asked of the positions' contacts later.
void note_positions(const SubStep& step, Attempt& attempt) {
  const auto is_hit = [&](int slot) { return slot < 0 || attempt.hit[index(slot)]; };
  attempt.positions.clear();
  attempt.positions.reserve(attempt.linear.size());
  for (const LinearContact& c : attempt.linear) {
    const double change = attempt.solved.converged ? 0.0 : change_of_update(c);
    const bool struck = touches(step, c) && is_hit(c.slot_a) && is_hit(c.slot_b);
    attempt.positions.push_back({c.relative[0], change, c.mode, c.compliant, c.was_closed, struck,
                                 c.closing_share > 0.0, c.start[0]});
  }
}

/// Largest of a vertex, relative to its block's size.
double largest_displacement(const SubStep& step, const StepPoses& poses) {
  double largest = 0.0;
  for (const int block : step.island.slots.block_of_slot) {
    const double size = step.compiled.models[index(block)].size;
    const Vector12& d = poses.increment[index(block)];
    const double moved = d.head<3>().norm() + d.segment<3>(3).norm() * 0.5 * size;
    largest = std::max(largest, moved / size);
  }
  return largest;
}

/// Breaks those that the solution overloads; true when there are any. `ties`: at the start; a
/// broken one has the mean of what it bore in the step for its force.
bool break_ties(const SubStep& step, const StepPoses& poses, std::span<TieState> ties) {
  bool any = false;
  for (std::size_t t = 0; t < ties.size(); ++t) {
    const TieModel& model = step.compiled.ties[index(step.island.ties[t])];
    const TieState end = tie_at_end(model, ties[t], poses.end);
    if (!is_overloaded(model.tie, end)) continue;
    ties[t].force = step.dynamic() ? force_until_break(model.tie, ties[t], end.length) : 0.0;
    ties[t].broken = any = true;
  }
  return any;
}

// Unbalance of a static step up to which its forces break joints and ties: more of them holds up
// inertia, no load. On the way to rest a push at a wall's foot would part its top.
constexpr double kBalanced = 1e-3;

/// Until no joint or tie fails by the solution. Each failure has all iterations: there are no more
/// of them than contacts.
OpenCloseResult solve_and_judge(const SubStep& step, std::vector<BodyContact>& contacts,
                                AttemptMemory& memory, StepPoses& poses,
                                std::vector<LinearContact>& linear) {
  OpenCloseResult total;
  for (bool again = true; again;) {
    set_laws(step, contacts, linear);
    set_pairs(linear, memory.terms.base);
    add(solve_positions(step, contacts, memory, poses, linear), total);
    if (!total.converged) break;
    const std::span<const LinearContact> solved = std::span(linear).first(contacts.size());
    if (!step.dynamic() && !(unbalance(step, poses, linear) <= kBalanced)) break;
    again = fail_overloaded(contacts, solved, step.parting_gap());
    again = break_ties(step, poses, memory.ties) || again;
    if (again) memory.solver.allow(step.options.max_iterations);
  }
  return total;
}

constexpr int kMostDoublings = 100;  // of forces that grow for ever: 1e-30 to 1e30 of an update
constexpr double kSameLoad = 1.0 - 1e-6;  // of another joint: both are in one chain

/// Of each joint that is loaded beyond its strength, and more than all others of its two blocks:
/// its contacts.
std::vector<char> choose_weakest(const SubStep& step, std::span<const BodyContact> contacts,
                                 std::span<const double> loads) {
  const auto slot = [&](int block) { return step.slot_of_block[index(block)]; };
  std::vector<double> largest(step.island.slots.block_of_slot.size(), 0.0);
  const auto note = [&](int block, double load) {
    if (slot(block) < 0) return;
    double& of_block = largest[index(slot(block))];
    of_block = std::max(of_block, load);
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    note(contacts[i].a, loads[i]);
    note(contacts[i].b, loads[i]);
  }
  const auto is_largest = [&](int block, double load) {
    return slot(block) < 0 || load >= kSameLoad * largest[index(slot(block))];
  };
  std::vector<char> chosen(contacts.size(), 0);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    chosen[i] = loads[i] > 1.0 && is_largest(contacts[i].a, loads[i]) &&
                is_largest(contacts[i].b, loads[i]);
  }
  return chosen;
}

struct LoadedJoints {
  const SubStep& step;
  std::span<BodyContact> contacts;

  std::vector<double> loads(std::span<const LinearContact> linear) const {
    double largest = 0.0;
    for (const LinearContact& c : linear) largest = std::max(largest, c.force.norm());
    return joint_loads(contacts, linear, largest);
  }

  bool overloaded(std::span<const double> loads) const {
    return std::ranges::any_of(loads, [](double load) { return load > 1.0; });
  }

  /// Forces that grow for ever, from before they did, until the first joint has its strength, to a
  /// factor of two. Their loads.
  std::vector<double> grow(std::span<LinearContact> linear) const {
    std::vector<Vector3> before, growth;
    for (const LinearContact& c : linear) {
      growth.push_back(force_after_update(c) - c.force);
      before.push_back(c.force - double{kFixedUpdates} * growth.back());
    }
    const auto loads_after = [&](double updates) {
      for (std::size_t i = 0; i < linear.size(); ++i)
        linear[i].force = before[i] + updates * growth[i];
      return loads(linear);
    };
    double updates = 1.0;
    int left = kMostDoublings;
    while (overloaded(loads_after(updates)) && left-- > 0) updates *= 0.5;
    for (left = 2 * kMostDoublings; !overloaded(loads_after(updates)) && left-- > 0;)
      updates *= 2.0;
    return loads_after(updates);
  }
};

/// Weakens what the solved forces load most beyond strength, or else what has opened; true when
/// there is anything. `solved`: what the contacts are from. Forces that grow for ever are taken
/// where the first joint has its strength.
bool fail_weakest(const SubStep& step, const OpenCloseResult& solved,
                  std::span<BodyContact> contacts, std::span<const LinearContact> linear) {
  const LoadedJoints joints{step, contacts};
  std::vector<LinearContact> loaded(linear.begin(), linear.end());
  const std::vector<double> loads = solved.infeasible ? joints.grow(loaded) : joints.loads(loaded);
  if (fail_chosen(contacts, loaded, choose_weakest(step, contacts, loads))) return true;
  return !solved.infeasible && fail_opened(contacts, linear, step.parting_gap());
}

/// As long as joints hold without limit the conditions of a step may contradict each other: a
/// rebound parts two blocks that a third one joins; or corners that have opened, and still stick,
/// let a block tilt by first order alone. The joints that the first linearisation loads most break,
/// and then the next ones. What all that comes to; converged: the last one is solved.
OpenCloseResult break_weakest(const SubStep& step, const LastSubStep& last,
                              std::vector<BodyContact>& contacts, AttemptMemory& memory,
                              StepPoses& poses, std::vector<LinearContact>& linear) {
  OpenCloseResult total;
  for (bool again = true; again;) {
    memory.solver.allow(step.options.max_iterations);
    predict(step, last, poses);
    set_laws(step, contacts, linear);
    set_pairs(linear, memory.terms.base);
    OpenCloseOptions tuning = tuning_of(step, contacts);
    tuning.predicted = true;
    const OpenCloseResult solved = solve_linearised(step, contacts, tuning, memory, poses, linear);
    add(solved, total);
    again = (solved.converged || solved.infeasible) &&
            fail_weakest(step, solved, contacts, std::span(linear).first(contacts.size()));
  }
  predict(step, last, poses);
  return total;
}

/// The strain of blocks that are hit waits.
bool holds_strain(const SubStep& step, const AttemptMemory& memory, const StepPoses& poses) {
  if (step.island.slots.rigid()) return false;
  bool holds = false;
  for (std::size_t s = 0; s < memory.expected_hit.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    holds = holds || (step.compiled.models[b].unknowns == 12 && !poses.deforms[b]);
  }
  return holds;
}

/// What contacts that yield may leave of gaps where hard ones may have no solution, m.
double unsolved_gap(const SubStep& step) {
  return kUnsolved * crowd_tolerance(step.options.tolerance) * step.island.smallest_size;
}

/// Whether held points are where they are to be: contacts that yield leave them apart where motions
/// contradict each other.
bool holds_points(const SubStep& step, std::span<const LinearContact> held) {
  const double limit = unsolved_gap(step);
  return std::ranges::all_of(held,
                             [&](const LinearContact& c) { return c.relative.norm() <= limit; });
}

/// Whether contacts that yield make way for supports that close: these sink into blocks, or blocks
/// leave from between them along contacts that stick. Rigid ones have no way then, and there is no
/// solution.
bool makes_way(const SubStep& step, std::span<const BodyContact> contacts,
               std::span<const LinearContact> linear, const StepPoses& poses) {
  const double shift = shift_of_supports(step, contacts, linear, {}, poses);
  const double limit = unsolved_gap(step);
  const auto yields = [&](const LinearContact& c) {
    const double further = kSqueezed * shift;
    const double stretch = c.relative.tail<2>().norm(), before = c.start.tail<2>().norm();
    return c.relative[0] < std::min(-limit, c.start[0] - further) ||
           (c.mode == ContactMode::Stick && stretch > std::max(limit, before + further));
  };
  return shift > 0.0 && std::ranges::any_of(linear.first(contacts.size()), yields);
}

}  // namespace

bool is_squeezed(double shift, std::span<const LinearContact> linear) {
  const auto overlaps = [&](const LinearContact& c) { return c.relative[0] < -kSqueezed * shift; };
  return shift > 0.0 && std::ranges::any_of(linear, overlaps);
}

void attempt_positions(const SubStep& step, const LastSubStep& last,
                       std::vector<BodyContact>& contacts, AttemptMemory& memory,
                       BlocksAtEnd& blocks, Attempt& attempt) {
  StepPoses& poses = blocks.poses;
  int crowd = 0;
  for (const int block : step.island.slots.block_of_slot)
    crowd = std::max(crowd, static_cast<int>(last.crowded[index(block)]));
  memory.solver.start(crowd);
  memory.ties.clear();
  for (const int t : step.island.ties) memory.ties.push_back(step.ties[index(t)]);
  predict(step, last, poses);
  set_matrices(step, poses, memory.terms);
  OpenCloseResult total = solve_and_judge(step, contacts, memory, poses, attempt.linear);
  if (memory.solver.yielding() &&
      !holds_points(step,
                    std::span(attempt.linear).subspan(contacts.size(), step.island.held.size())))
    total.converged = false;
  attempt.shift =
      holds_strain(step, memory, poses)
          ? shift_of_supports(step, contacts, attempt.linear, memory.expected_hit, poses)
          : 0.0;
  attempt.squeezed = total.converged
                         ? memory.solver.yielding() && is_squeezed(attempt.shift, attempt.linear)
                         : attempt.shift > 0.0;
  if (total.converged && !attempt.squeezed && memory.solver.yielding() &&
      makes_way(step, contacts, attempt.linear, poses))
    total.converged = false;
  if (!total.converged && !attempt.squeezed && may_fail(contacts)) {
    add(break_weakest(step, last, contacts, memory, poses, attempt.linear), total);
    if (std::exchange(total.converged, false))
      add(solve_and_judge(step, contacts, memory, poses, attempt.linear), total);
  }
  memory.clock.charge(&PhaseSeconds::assemble);
  attempt.solved = total;
  attempt.quiet_forces.clear();
  for (std::size_t q = 0; q < step.island.quiet.size(); ++q) {
    const QuietPoint& point = step.compiled.quiet[index(step.island.quiet[q])];
    const LinearContact& c = attempt.linear[attempt.linear.size() - step.island.quiet.size() + q];
    const Matrix3 rows = quiet_frame(point, poses.start[index(point.block)]);
    attempt.quiet_forces.push_back(step.dynamic() ? step.quiet[index(step.island.quiet[q])]
                                                  : Vector3(rows.transpose() * c.force));
  }
  attempt.ties.clear();
  for (std::size_t t = 0; t < memory.ties.size(); ++t) {
    const TieModel& model = step.compiled.ties[index(step.island.ties[t])];
    attempt.ties.push_back(tie_at_end(model, memory.ties[t], poses.end));
  }
  account(step, poses, contacts, attempt.linear, attempt.ties, attempt.energy);
  attempt.unbalance = unbalance(step, poses, attempt.linear);
  attempt.stiffest_omega_dt = stiffest_omega_dt(attempt.linear, memory.terms.compliance);
  attempt.displacement = largest_displacement(step, poses);
  for (const int block : step.island.slots.block_of_slot)
    blocks.end[index(block)] = end_state(step, poses, index(block));
  attempt.held_forces.clear();
  for (std::size_t h = 0; h < step.island.held.size(); ++h)
    attempt.held_forces.push_back(attempt.linear[contacts.size() + h].force);
  attempt.first_impact = first_impact(step, std::span(attempt.linear).first(contacts.size()));
  find_hit_blocks(step, contacts, attempt.linear, Impacts::Solved, attempt.hit);
  attempt.rounding = gap_rounding(attempt.linear);
  note_positions(step, attempt);
  record(contacts, poses, attempt);
}

}  // namespace quoin::solver
