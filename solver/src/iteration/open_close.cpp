#include "iteration/open_close.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/index.hpp"
#include "contact/contact_jacobian.hpp"
#include "contact/joint_law.hpp"

namespace quoin::solver {
namespace {

// A sum of m rounded terms is off by m u of their magnitudes, u = eps / 2 [Higham 2002,
// section 3.1]: 24 terms of two blocks' increments, of which each has six more behind it: 32 u.
constexpr double kMotionRounding = 16.0 * std::numeric_limits<double>::epsilon();
constexpr double kAsGood = 1e-12;  // of the motion: what a guess may be off by

/// Of a contact in free motion, m.
struct FreeContact {
  Vector3 end;                         ///< d
  Vector3 by_loads = Vector3::Zero();  ///< part of its change
  Vector3 rounding = Vector3::Zero();  ///< of both
};

FreeContact free_contact(const FreeMotion& free, const BlockVector& force, const LinearContact& c) {
  FreeContact moved{.end = c.offset};
  c.each_side([&](std::size_t slot, const ContactJacobian& jacobian) {
    const Vector12 increment = free.compliance.times(slot, force[slot]);
    const Vector12& coasting = free.coasting[slot];
    moved.end += jacobian * increment;
    moved.by_loads += jacobian * (increment - coasting);
    moved.rounding +=
        kMotionRounding * (jacobian.magnitudes(increment) + jacobian.magnitudes(coasting));
  });
  return moved;
}

bool slides(const LinearContact& c, const FreeContact& moved) {
  const Vector3 slid = (moved.end - c.start).cwiseAbs() - moved.rounding;
  return slid.tail<2>().maxCoeff() > c.rounding;
}

bool is_left_alone(const LinearContact& c, const FreeContact& moved, double overlap) {
  if (c.compliant) return false;
  if (c.bonded || c.law == ContactLaw::Bilateral) {
    const Vector3 change = (moved.end - c.start).cwiseAbs() - moved.rounding;
    return (moved.by_loads.cwiseAbs() - moved.rounding).maxCoeff() <= 0.0 &&
           change.maxCoeff() <= c.rounding && moved.end.cwiseAbs().maxCoeff() <= overlap;
  }
  if (c.clings) {
    const Vector3 pulled = moved.by_loads.cwiseAbs() - moved.rounding;
    if (pulled.tail<2>().maxCoeff() > 0.0 || slides(c, moved)) return false;
  }
  const double rounding = moved.rounding[0];
  return moved.end[0] >= 0.0 || (moved.by_loads[0] >= -rounding && moved.end[0] >= -overlap &&
                                 c.start[0] - moved.end[0] <= c.rounding + rounding);
}

}  // namespace

bool is_unforced(const FreeMotion& free, const BlockVector& force,
                 std::span<const LinearContact> contacts, double overlap) {
  return std::ranges::all_of(contacts, [&](const LinearContact& c) {
    return is_left_alone(c, free_contact(free, force, c), overlap);
  });
}

namespace {

/// Whether what has pressed would slide: it may go on pressing, by friction, though all would come
/// free without.
bool slides_free(const FreeMotion& free, const BlockVector& force,
                 std::span<const LinearContact> contacts) {
  return std::ranges::any_of(contacts, [&](const LinearContact& c) {
    return c.multiplier[0] > 0.0 && c.law == ContactLaw::Coulomb &&
           slides(c, free_contact(free, force, c));
  });
}

/// Whether contacts bear more than this share of the largest force on a block.
bool bear(const BlockVector& force, std::span<const LinearContact> contacts, double share) {
  double largest = 0.0;
  for (const Vector12& on_block : force) largest = std::max(largest, on_block.head<3>().norm());
  return std::ranges::any_of(
      contacts, [&](const LinearContact& c) { return c.force.norm() > share * largest; });
}

}  // namespace

double coast(const FreeMotion& free, const Slots& slots, const BlockVector& force,
             BlockVector& increment) {
  double largest = 0.0;
  for (std::size_t s = 0; s < increment.size(); ++s) {
    const Vector12 next = free.compliance.times(s, force[s]);
    const double change = motion_of(next - increment[s], slots.length[s]);
    const double size = motion_of(next, slots.length[s]);
    if (std::isfinite(size) && change <= kAsGood * size) continue;
    largest = std::max(largest, change);
    increment[s] = next;
  }
  return largest;
}

namespace {

/// Increments of free motion, and contacts that bear nothing.
void move_freely(const FreeMotion& free, const BlockVector& force,
                 std::span<LinearContact> contacts, BlockVector& increment) {
  for (std::size_t s = 0; s < increment.size(); ++s)
    increment[s] = free.compliance.times(s, force[s]);
  for (LinearContact& c : contacts) {
    c.relative = free_contact(free, force, c).end;
    c.force.setZero();
    c.multiplier.setZero();
    const bool held = c.bonded || c.law == ContactLaw::Bilateral;
    c.assumed = c.mode = held ? ContactMode::Stick : ContactMode::Open;
  }
}

constexpr double kFarResidual = 1e-2;  // a guess that far out says nothing of the contacts' modes
constexpr double kAtRest = 10.0;       // tolerances: a guess this good needs no solve; solved is 1
constexpr double kLastPush = 10.0;     // of the force tolerance: an update that is not needed
constexpr double kStalled = 0.9;       // of the last gap is left: then
constexpr double kStalledPush = 1e6;   // of the force tolerance, and
constexpr double kStalledGap = 10.0;   // of the gap tolerance is enough
// Likewise of redundant contacts: with 1e-3 a wall near its limit load gained energy in the motion
// that followed. Where blocks begin to move 2 of 19 shaken walls did with 0.1, none with this.
constexpr double kSharedPush = 1e-4;
constexpr double kSlow = 0.5;  // of the last gap is left: augmentation is raised, by
constexpr double kRaise = 10.0;
constexpr double kRaiseGap = 0.1;       // where more than this share of the largest gap is left,
constexpr double kFixed = 0.999;        // but not for gaps that no force can close
constexpr double kConeRounding = 1e-6;  // of the largest change of a force
constexpr int kMostRaises = 6;          // mass ratios of 1e6, with what augmentation is already

// The softness of contacts. Chosen with the numbers of contact_newton.cpp, on the same sample.
constexpr double kSoft = 1e-4;   // after full stiffness failed
constexpr double kSofter = 0.1;  // after that failed, too, and of redundant contacts at once
constexpr double kSoftest = 1e-9;
constexpr double kStiffer = 5.0;  // after it was solved in
constexpr int kQuickSteps = 4;
// While gaps are above the tolerance, at most, and of the residual that the last update left. Of
// rigid blocks: chosen on the walls of bench/large.md.
struct Loose {
  double residual, share;
};
constexpr Loose kLoose{1e-4, 1e-2}, kLooseRigid{1e-2, 0.1};

constexpr double kMotion = 1e-9;  // of a block, in a step: it moves. Between 1e-11 of what rests
                                  // and 5e-5 where a shaken wall turns round
// Of many blocks that move.
constexpr double kCrowd = 1e4;      // times the tolerance: their forces, and gaps of what yields,
constexpr double kCoarsest = 1e-6;  // up to this; from there on what is asked for is enough
// Gaps, of their tolerance: with 1 a wall of 27 that sticks on a shaken base gains 8e-9 of its
// energy in 5 s, with this nothing. Where they fall no more: with 10 walls that rock gain up to
// 1e-8.
constexpr double kFine = 0.1, kStopped = 3.0;
constexpr double kSame = 1.5;  // of accepted gaps: the next linearisation's are as good

/// Takes the forces as the new multipliers.
void update_multipliers(std::span<LinearContact> contacts) {
  for (LinearContact& c : contacts)
    if (!c.compliant) c.multiplier = c.force;
}

/// A light block that carries a heavy one opposes to a contact much less than what must pass
/// through it: ten times stiffer where more than `gap` (m) is left.
void raise_augmentation(std::span<LinearContact> contacts, double gap) {
  for (LinearContact& c : contacts) {
    if (c.compliant || c.mode == ContactMode::Open) continue;
    if (!unpressed(c) && std::abs(c.relative[0]) > gap) c.normal_stiffness *= kRaise;
    if (c.mode == ContactMode::Stick && c.relative.tail<2>().norm() > gap)
      c.shear_stiffness *= kRaise;
  }
}

/// Whether the contact can bear what the next update adds as often as it comes. `noise`, N.
bool grows_on(const LinearContact& c, double noise) {
  const Vector3 growth = force_after_update(c) - c.force;
  if (growth.norm() <= noise || c.compliant) return true;
  if (!c.bonded && c.law != ContactLaw::Bilateral && growth[0] < -noise) return false;
  const bool sticks = c.law == ContactLaw::Stuck || c.law == ContactLaw::Bilateral;
  return sticks || growth.tail<2>().norm() <= c.friction * std::max(growth[0], 0.0) + noise;
}

/// `stands`, by slot: what touches a block that does not stand does not, either.
void spread(std::span<const LinearContact> contacts, std::vector<char>& stands) {
  for (bool spreads = true; spreads;) {
    spreads = false;
    for (const LinearContact& c : contacts) {
      if (c.mode == ContactMode::Open || c.slot_a < 0 || c.slot_b < 0) continue;
      char &a = stands[index(c.slot_a)], &b = stands[index(c.slot_b)];
      spreads = spreads || a != b;
      a = b = a && b;
    }
  }
}

bool moves(const Slots& slots, const BlockVector& increment, std::size_t slot) {
  return motion_of(increment[slot], slots.length[slot]) > kMotion * slots.length[slot];
}

bool all_move(const Slots& slots, const BlockVector& increment) {
  for (std::size_t s = 0; s < increment.size(); ++s)
    if (!moves(slots, increment, s)) return false;
  return true;
}

}  // namespace

double crowd_tolerance(double tolerance) {
  return std::max(tolerance, std::min(kCrowd * tolerance, kCoarsest));
}

void OpenClose::begin() {
  last_gap_ = last_loose_gap_ = std::numeric_limits<double>::infinity();
  loose_gap_ = accepted_gap_ = 0.0;
}

bool many_deform(const Slots& slots) { return slots.count() >= kMany && !slots.rigid(); }

bool is_moving(const Slots& slots, const BlockVector& increment) {
  if (!slots.rigid() || slots.count() < kMany) return false;
  for (std::size_t s = 0; s < increment.size(); ++s)
    if (moves(slots, increment, s)) return true;
  return false;
}

void add(const OpenCloseResult& later, OpenCloseResult& total) {
  total.converged = later.converged;
  total.count(later);
  total.residual = later.residual;
  total.closed = total.closed && later.closed;
  total.change = later.change;
  total.softness = later.softness;
  total.infeasible = later.infeasible;
  if (later.factorizations > 0) total.condition = later.condition;
}

void set_pairs(std::span<LinearContact> contacts, BlockSystem& base) {
  set_pairs(contacts, &LinearContact::slot_a, &LinearContact::slot_b, base.pairs);
}

/// Largest violation of the contact conditions that multipliers should remove, m.
double OpenClose::violation(std::span<const LinearContact> contacts) const {
  double worst = 0.0;
  for (const LinearContact& c : contacts) {
    if (c.compliant || c.mode == ContactMode::Open) continue;
    if (!unpressed(c)) worst = std::max(worst, std::abs(c.relative[0]));
    if (c.mode == ContactMode::Stick) worst = std::max(worst, c.relative.tail<2>().norm());
  }
  return worst;
}

/// Blocks that the forces known so far hold where they stand, and so all that they touch, do not
/// move to begin with: what they were guessed to do is rounding. Returns the largest motion taken
/// back, m.
double OpenClose::stand(const BlockEquations& blocks, std::span<LinearContact> contacts,
                        const OpenCloseOptions& options, BlockVector& guess) {
  still_.assign(guess.size(), Vector12::Zero());
  if (guess == still_) return 0.0;
  if (all_move(*slots_, guess)) return 0.0;
  newton_.set(blocks, contacts, still_, options.gap_rounding);
  newton_.evaluate(Law::True, 1.0);
  stands_.resize(guess.size());
  for (std::size_t s = 0; s < guess.size(); ++s)
    stands_[s] = newton_.equations().balanced(s, kAtRest * options.force_tolerance);
  spread(contacts, stands_);
  double taken_back = 0.0;
  for (std::size_t s = 0; s < guess.size(); ++s) {
    if (!stands_[s]) continue;
    taken_back = std::max(taken_back, motion_of(guess[s], slots_->length[s]));
    guess[s].setZero();
  }
  return taken_back;
}

/// Where the last forces hold all blocks where they stand, with gaps that the last step has left
/// within its tolerance, contacts bear what they bore: redundant ones cannot all close, and what
/// they would bear for that would be shifted between them in every step. Where a support moves gaps
/// are not those of the last step.
std::optional<OpenCloseResult> OpenClose::rests(const BlockEquations& blocks,
                                                std::span<LinearContact> contacts,
                                                const OpenCloseOptions& options,
                                                BlockVector& guess) {
  const double left = kStalledGap * options.gap_tolerance;
  OpenCloseResult result{{}, true};
  result.softness = options.softness;
  result.change = largest_motion(*slots_, guess);
  if (!(result.change <= left)) return {};
  const bool kept = std::ranges::all_of(contacts, [](const LinearContact& c) {
    return !c.compliant && (c.offset - c.start).cwiseAbs().maxCoeff() <= c.rounding;
  });
  if (!kept) return {};
  still_.assign(guess.size(), Vector12::Zero());
  newton_.set(blocks, contacts, still_, left);
  newton_.evaluate(Law::True, 1.0);
  result.residual = newton_.equations().relative_residual();
  if (result.residual <= kAtRest * options.force_tolerance && violation(contacts) == 0.0) {
    guess = still_;
    return result;
  }
  newton_.set(blocks, contacts, guess, options.gap_rounding);
  newton_.evaluate(Law::True, options.softness);
  return {};
}

/// A step with the modes that contacts are taken to have. From nothing, a course of a wall would
/// close in each of Newton's steps.
void OpenClose::step_assumed(double softness, SolveCount& count) {
  newton_.evaluate(Law::Assumed, softness);
  ++count.iterations;
  if (!newton_.step(Law::Assumed, softness, count)) newton_.evaluate(Law::True, softness);
}

/// Where Newton's method is not quick, or many blocks move. Soft contacts, and those of rigid
/// blocks at any stiffness, only hand their forces on as the next multipliers: good to a share is
/// enough until the gaps are within the tolerance.
double OpenClose::wanted_residual(std::span<const LinearContact> contacts,
                                  const OpenCloseOptions& options, const Progress& progress) const {
  const bool rigid = slots_->rigid();
  const bool opens = options.moves && progress.softened;  // gaps are those of stiffer contacts
  if ((progress.softness == 1.0 && !rigid) || (!opens && violation(contacts) <= loose_gap_))
    return options.force_tolerance;
  const Loose& loose = rigid ? kLooseRigid : kLoose;
  const double share = loose.share * newton_.equations().relative_residual();
  return std::max(options.force_tolerance, std::min(loose.residual, share));
}

/// Solves, takes the forces as multipliers and solves again until that changes nothing any more.
/// Stiff contacts change their mode one joint after the other and Newton's method may find no way;
/// soft ones all at once. Where it fails it goes back to the last solution with softer contacts,
/// and stiffer ones again as they are quickly solved.   [Rockafellar 1976]
bool OpenClose::converge(std::span<LinearContact> contacts, const OpenCloseOptions& options,
                         Progress& progress, SolveCount& count) {
  const auto is_spring = [](const LinearContact& c) { return c.compliant && !is_link(c); };
  const bool springs = std::ranges::any_of(contacts, is_spring);
  double& softness = progress.softness;
  progress.slow = options.moves || softness < 1.0;
  solved_.assign(newton_.change().size(), Vector12::Zero());
  while (count.iterations < options.max_iterations) {
    const int before = count.iterations;
    const bool exactly = softness == 1.0 && !progress.slow;
    const double wanted =
        exactly ? options.force_tolerance : wanted_residual(contacts, options, progress);
    const Relaxed relaxed = newton_.relax({wanted, softness, options.max_iterations}, count);
    progress.slow =
        progress.slow || relaxed == Relaxed::No || count.iterations - before > kQuickSteps;
    if (relaxed != Relaxed::No) {
      solved_ = newton_.change();
      progress.assumes = progress.softened = false;
      const bool exact = (relaxed == Relaxed::ToRounding && wanted == options.force_tolerance) ||
                         newton_.equations().relative_residual() <= options.force_tolerance;
      if (exact && (softness == 1.0 || !springs)) {
        if (settled(contacts, options, progress)) return true;
      } else if (!exact && (softness == 1.0 || options.moves)) {
        note_loose(contacts, options, progress);
      }
      if (infeasible(contacts, options, progress)) return false;
      update_multipliers(contacts);
      if (count.iterations - before <= kQuickSteps) softness = std::min(1.0, kStiffer * softness);
      count.iterations = std::max(count.iterations, before + 1);
    } else {
      newton_.set_change(solved_);
      progress.softened = true;
      const double first = options.redundant ? kSofter : kSoft;
      softness = softness == 1.0 ? first : std::max(kSoftest, kSofter * softness);
      if (progress.assumes) {
        step_assumed(softness, count);
        continue;
      }
    }
    newton_.evaluate(Law::True, softness);
  }
  return false;
}

/// What the next multipliers would do to the blocks, relative to the forces there. Parts that
/// cancel are left out: redundant contacts that disagree by less than the tolerance shift them for
/// ever.
double OpenClose::push_of_update(std::span<const LinearContact> contacts) {
  push_.assign(newton_.change().size(), Vector12::Zero());
  for (const LinearContact& c : contacts)
    if (!c.compliant) c.push(force_after_update(c) - c.force, push_);
  return newton_.equations().relative_push(push_);
}

/// Whether multipliers would grow for ever: an update leaves the gaps as they are, and what it adds
/// is in the recession cone of the forces that contacts bear, so that the next ones add the same.
/// Farkas' certificate that no motion meets the conditions.   [Rockafellar 1976]
bool OpenClose::infeasible(std::span<const LinearContact> contacts, const OpenCloseOptions& options,
                           Progress& progress) const {
  if (!options.breaks || progress.softness < 1.0) return false;
  const double gap = violation(contacts);
  const double before = std::exchange(progress.gap, gap);
  // Redundant bonds leave smaller gaps, by strain and by turns of second order.
  const double least = std::max(kStalledGap * options.gap_tolerance, options.mended_apart);
  const bool fixed = gap > least && gap >= kFixed * before && gap <= before / kFixed;
  progress.fixed = fixed ? progress.fixed + 1 : 0;
  if (progress.fixed < kFixedUpdates) return false;
  double largest = 0.0;
  for (const LinearContact& c : contacts) largest = std::max(largest, change_of_update(c));
  const double noise = kConeRounding * largest;
  progress.infeasible =
      std::ranges::all_of(contacts, [&](const LinearContact& c) { return grows_on(c, noise); });
  return progress.infeasible;
}

/// Solved for its multipliers: are these good? They are when the next update no longer matters, or
/// no longer helps and gaps are within the tolerance (what is left then lies in forces that nearly
/// cancel). The forces are then wrong by about the push over 1e2: by so much at least is the
/// augmentation stiffer than a block.
bool OpenClose::settled(std::span<LinearContact> contacts, const OpenCloseOptions& options,
                        Progress& progress) {
  const double gap = violation(contacts);
  if (gap <= options.gap_rounding) return true;
  const double left = gap / std::exchange(last_gap_, gap);
  const bool stops = std::exchange(progress.exact, true) && left > kSlow;
  if (options.moves && serves_motion(contacts, options, {gap, left}, stops)) return true;
  if (begins_to_move(contacts, options, gap)) return true;
  const bool stalled = progress.softness == 1.0 && left > kStalled;
  if (gap <= (stalled ? kStalledGap : 1.0) * options.gap_tolerance) {
    const double allowed = stalled ? kStalledPush : kLastPush;
    if (push_of_update(contacts) <= allowed * options.force_tolerance) return true;
  }
  if (options.redundant && (progress.slow || left > kSlow) &&
      gap <= kStalledGap * options.gap_tolerance && push_of_update(contacts) <= kSharedPush)
    return true;
  follow_gap(contacts, options, {gap, left}, progress);
  return false;
}

/// The same in a step that blocks begin to move in: gaps are closed, and what is left to share out
/// between redundant contacts would take many updates more.
bool OpenClose::begins_to_move(std::span<const LinearContact> contacts,
                               const OpenCloseOptions& options, double gap) {
  return options.free != nullptr && gap <= kFine * options.gap_tolerance &&
         is_moving(*slots_, newton_.change()) && push_of_update(contacts) <= kSharedPush;
}

/// The same where blocks move. Gaps that redundant contacts cannot all close stop falling near
/// the tolerance, while their multipliers go on by as much each time, until they leave
/// their cones. What the next update would push the blocks by is the augmentation over what the
/// blocks oppose times what their forces are wrong by.
bool OpenClose::serves_motion(std::span<const LinearContact> contacts,
                              const OpenCloseOptions& options, const GapLeft& gap, bool stops) {
  const double enough = (stops ? kStopped : kFine) * options.gap_tolerance;
  if (gap.most > std::max(accepted_gap_, enough)) return false;
  const double allowed = kAugmentation * crowd_tolerance(options.force_tolerance);
  if (push_of_update(contacts) > allowed) return false;
  accepted_gap_ = kSame * std::min(gap.most, kStopped * options.gap_tolerance);
  return true;
}

/// A loose solution only hands its forces on.
void OpenClose::note_loose(std::span<LinearContact> contacts, const OpenCloseOptions& options,
                           Progress& progress) {
  const double gap = violation(contacts);
  const double left = gap / std::exchange(last_loose_gap_, gap);
  const double enough = kStopped * options.gap_tolerance;
  if (options.moves && left > kSlow && gap <= enough) loose_gap_ = enough;
  if (progress.softness == 1.0) follow_gap(contacts, options, {gap, left}, progress);
}

/// Gaps that shrink slowly from update to update ask for a stiffer augmentation.
void OpenClose::follow_gap(std::span<LinearContact> contacts, const OpenCloseOptions& options,
                           const GapLeft& gap, Progress& progress) {
  const bool slow =
      gap.share > kSlow && gap.share < kFixed && progress.updates > 0 && progress.softness == 1.0;
  if (options.raise && slow && progress.raises < kMostRaises) {
    ++progress.raises;
    raise_augmentation(contacts, kRaiseGap * gap.most);
  }
  ++progress.updates;
}

std::optional<OpenCloseResult> OpenClose::fly(const BlockEquations& blocks,
                                              std::span<LinearContact> contacts,
                                              const OpenCloseOptions& options, double overlap,
                                              BlockVector& increment) {
  if (options.free == nullptr) return {};
  if (!is_unforced(*options.free, blocks.force, contacts, overlap)) return {};
  if (!options.moves && slides_free(*options.free, blocks.force, contacts)) return {};
  newton_.set(blocks, contacts, increment, options.gap_rounding);
  newton_.evaluate(Law::True, options.softness);
  const double residual = newton_.equations().relative_residual();
  if (residual <= kAtRest * options.force_tolerance &&
      bear(blocks.force, contacts, options.force_tolerance))
    return {};
  OpenCloseResult result{{}, true};
  result.softness = options.softness;
  guess_ = increment;
  move_freely(*options.free, blocks.force, contacts, increment);
  for (std::size_t s = 0; s < increment.size(); ++s) guess_[s] -= increment[s];
  result.change = largest_motion(*slots_, guess_);
  return result;
}

OpenCloseResult OpenClose::solve(const BlockSystem& base, const BlockVector& force,
                                 std::span<LinearContact> contacts, const OpenCloseOptions& options,
                                 BlockVector& increment) {
  const BlockEquations blocks{base, force};
  const ContactEquations& equations = newton_.equations();
  const double tolerance = options.force_tolerance;
  OpenCloseResult result;
  if (options.predicted || !options.raise)
    last_gap_ = last_loose_gap_ = std::numeric_limits<double>::infinity();
  if (options.predicted || !options.moves) {
    loose_gap_ = options.gap_tolerance;
    accepted_gap_ = 0.0;
  }
  loose_gap_ = std::max(loose_gap_, options.gap_tolerance);
  result.softness = options.softness;
  if (options.predicted) result.change = stand(blocks, contacts, options, increment);
  newton_.set(blocks, contacts, increment, options.gap_rounding);
  newton_.evaluate(Law::True, options.softness);
  result.residual = equations.relative_residual();
  if (result.residual <= kAtRest * tolerance && violation(contacts) <= options.gap_rounding) {
    result.converged = true;  // nothing has happened since the last step
    return result;
  }
  if (options.predicted && options.free != nullptr) {
    if (const auto rest = rests(blocks, contacts, options, increment)) return *rest;
  }
  const double overlap = kStalledGap * options.gap_tolerance;
  if (const auto free = fly(blocks, contacts, options, overlap, increment)) return *free;
  SolveCount count;
  const bool far = result.residual > kFarResidual;
  if (far) step_assumed(options.softness, count);
  Progress progress{.softness = options.softness, .assumes = far && slots_->rigid()};
  result.converged = converge(contacts, options, progress, count);
  result.softness = progress.softness;
  result.infeasible = progress.infeasible;
  result.count(count);
  result.residual = equations.relative_residual();
  for (LinearContact& c : contacts) c.assumed = c.mode;
  for (std::size_t s = 0; s < increment.size(); ++s) increment[s] += newton_.change()[s];
  result.change = std::max(result.change, largest_motion(*slots_, newton_.change()));
  if (newton_.factorized()) result.condition = newton_.condition_estimate();
  return result;
}

}  // namespace quoin::solver
