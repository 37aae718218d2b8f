#include "iteration/moving_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace quoin::solver {
namespace {

// Chosen on single steps of piles, shaken walls, towers, arches and slopes, and on runs of them.
constexpr int kSweeps = 10;
constexpr double kRoughForces = 1e-3;  // of the forces, while linearisations are far from agreeing
constexpr int kMostHard = 20;          // steps on hard contacts before they yield by
constexpr double kSoftness = 0.03;     // and, where Newton's method does not end in
constexpr int kMostSoft = 12;          // steps, by
constexpr double kSofterCone = 4.0;    // times as much, up to
constexpr double kSoftestCone = 2.0;
// Velocities: times their softness, the next one, while residuals are above what forces are wanted
// to; where the last one took so few steps, while they are above this share of that.
constexpr double kHarder = 0.01, kFineVelocity = 0.01;
constexpr int kQuickConeSteps = 6;
constexpr double kNearHard =
    1e-3;  // the residual from which hard contacts are what they yield about
constexpr int kMostConeSteps = 25;    // of contacts in cones, or where these have come to
constexpr double kConeForces = 1e-3;  // of the largest: what is worse is left out
constexpr int kMostMending = 20;      // steps of the projection of gaps, to
constexpr double kGap = 0.5;          // of the tolerance of gaps
constexpr double kLimit = 2.0;        // times that: the most that is left or kept
constexpr double kFineGap = 0.1;      // likewise: what is beyond the limit is mended to

/// Of what a force is the projection of.
ContactMode mode_of(const Admissible& forces, const Vector3& trial, double friction) {
  if (forces.shear == Admissible::Shear::All) return ContactMode::Stick;
  const double tangential = trial.tail<2>().norm();
  if (forces.shear == Admissible::Shear::Disc)
    return tangential > forces.shear_limit(trial[0]) ? ContactMode::Slip : ContactMode::Stick;
  if (trial[0] <= -tangential) return ContactMode::Open;
  return trial[0] < tangential || !(friction > 0.0) ? ContactMode::Slip : ContactMode::Stick;
}

void add(const IterationCount& part, IterationCount& total) {
  total.converged = part.converged;
  total.residual = part.residual;
  total.iterations += part.iterations;
  total.solves += part.solves;
  total.factorizations += part.factorizations;
}

}  // namespace

void MovingContacts::begin() { yielded_ = keeps_gaps_ = false; }

/// `first`: the first linearisation of a step, which sweeps; the others are near their solution.
/// Velocities yield at once where the positions have: of 57 that tried hard contacts in a wall of
/// 105, 54 did not find them.
void MovingContacts::start(std::span<const LinearContact> contacts, bool first) {
  x_.resize(contacts.size());
  motion_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i)
    x_[i] = project_on(admissible(i), problem_.cone_force(i, contacts[i].multiplier));
  bar_ = x_;
  if (!first) {
    for (std::size_t i = 0; i < bar_.size(); ++i) bar_[i] = problem_.cone_force(i, bar_force_[i]);
    return;
  }
  softness_ = yielded_ ? kSoftness : 0.0;
  stiffened_.clear();
  closed_.clear();
  problem_.respond(x_, motion_);
  problem_.sweep(kSweeps, x_);
  bar_ = x_;
}

IterationCount MovingContacts::solve_soft(double tolerance) {
  IterationCount total;
  while (iterations_left_ > 0) {
    const IterationLimit limit{tolerance, std::min(kMostSoft, iterations_left_)};
    const IterationCount count = newton_.solve_soft(problem_, softness_, bar_, limit, x_);
    iterations_left_ -= count.iterations;
    add(count, total);
    if (count.converged || softness_ * kSofterCone > kSoftestCone) break;
    softness_ *= kSofterCone;
    x_ = bar_;
  }
  return total;
}

/// Hard contacts; where these are not found contacts yield, about forces that push no block out:
/// those of the sweeps while hard ones are far from a solution.
IterationCount MovingContacts::iterate(double tolerance) {
  if (softness_ > 0.0) return solve_soft(tolerance);
  IterationCount total =
      newton_.solve_hard(problem_, {tolerance, std::min(kMostHard, iterations_left_)}, x_);
  iterations_left_ -= total.iterations;
  if (total.residual <= kNearHard) bar_ = x_;
  if (total.converged) return total;
  softness_ = kSoftness;
  add(solve_soft(tolerance), total);
  return total;
}

/// Contacts of velocities yield about their last forces, less and less, while that is soon solved:
/// what they yield adds up along a row of blocks, and no later step closes it.
IterationCount MovingContacts::harden() {
  IterationCount total;
  total.converged = true;
  bool quick = true;
  while (softness_ > 0.0 && iterations_left_ > 0) {
    problem_.respond(x_, motion_);
    total.residual = relative_residual(problem_.admissible(), x_, motion_);
    if (total.residual <= (quick ? kFineVelocity : 1.0) * forces_) break;
    moved_ = bar_;
    bar_ = x_;
    const IterationLimit limit{kFineVelocity * forces_, std::min(kMostSoft, iterations_left_),
                               true};
    const IterationCount count = newton_.solve_soft(problem_, kHarder * softness_, bar_, limit, x_);
    iterations_left_ -= count.iterations;
    total.iterations += count.iterations;
    total.solves += count.solves;
    total.factorizations += count.factorizations;
    if (!(count.residual <= forces_)) {
      std::swap(x_, bar_);
      std::swap(bar_, moved_);
      break;
    }
    softness_ *= kHarder;
    quick = count.iterations <= kQuickConeSteps;
  }
  return total;
}

/// Forces, motions and modes of the contacts.
void MovingContacts::record(std::span<LinearContact> contacts) {
  problem_.respond(x_, motion_);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    LinearContact& c = contacts[i];
    const Vector3 yield = softness_ * (x_[i] - bar_[i]);
    const Vector3 trial = x_[i] - corrected(admissible(i), motion_[i] + yield);
    c.mode = mode_of(admissible(i), trial, c.friction);
    c.assumed = c.mode;
    c.force = c.mode == ContactMode::Open ? Vector3(Vector3::Zero()) : problem_.force(i, x_[i]);
    c.multiplier = c.force;
  }
}

/// Whether contacts overlap, or bear forces and are apart, by more than gap_.
bool MovingContacts::apart() const {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    Vector3 u = motion_[i] + to_mend(i);
    if (!admissible(i).pulls) u[0] = std::min(u[0], x_[i][0]);
    if (std::abs(problem_.motion(i, u)[0]) > gap_) return true;
  }
  return false;
}

/// Of the gap and the stretch that the step began with; of gaps that are kept what is beyond the
/// limit. Were overlaps alone kept, blocks would sink by the gaps of other contacts that bear them,
/// until all are at the limit and are lifted again.
Vector3 MovingContacts::to_mend(std::size_t contact) const {
  const Vector3& unmended = problem_.unmended(contact);
  if (!keeps_gaps_) return unmended;
  const double most = softness_ > 0.0 ? kLimit : kLimit - kFineGap;
  const double kept = most * gap_ / problem_.motion(contact, Vector3::UnitX())[0];
  return {unmended[0] - std::clamp(unmended[0], -kept, kept), 0.0, 0.0};
}

/// Of the contacts' forces in the step, J: what it gains, and the size of its parts.
MovingContacts::Work MovingContacts::work() const {
  Work work;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const double part = x_[i].dot(motion_[i] - problem_.unmoved(i));
    work.sum += part;
    work.parts += std::abs(part);
  }
  return work;
}

/// What the last linearisation has added to the forces x_, which leave contacts at motion_.
AddedForces MovingContacts::guess(std::span<const Vector3> added) {
  if (added.empty()) return {};
  added_.resize(x_.size());
  moved_.resize(x_.size());
  for (std::size_t i = 0; i < x_.size(); ++i) added_[i] = x_[i] + problem_.cone_force(i, added[i]);
  problem_.respond(added_, moved_);
  for (std::size_t i = 0; i < x_.size(); ++i) {
    added_[i] -= x_[i];
    moved_[i] -= motion_[i];
  }
  return {added_, moved_};
}

/// How contacts lie apart once what there is to mend is added to their motion.
std::span<const Vector3> MovingContacts::all_to_mend() {
  apart_.resize(x_.size());
  for (std::size_t i = 0; i < x_.size(); ++i) apart_[i] = motion_[i] + to_mend(i);
  return apart_;
}

/// Stiffer contacts, whose forces stay in their cones, about those that yield. They are as good as
/// these: to 1e-3 of the largest they left gaps of a tenfold, and work, where there were hardly
/// any.
IterationCount MovingContacts::stiffen(std::span<LinearContact> contacts) {
  const AddedForces start = guess(stiffened_);
  const IterationLimit limit{std::min(forces_, kConeForces),
                             std::min(kMostConeSteps, iterations_left_)};
  IterationCount count = cone_projection_.solve(problem_, x_, all_to_mend(), start, limit);
  iterations_left_ -= count.iterations;
  count.converged = count.residual <= kConeForces;
  stiffened_.assign(count.converged ? x_.size() : 0, Vector3::Zero());
  for (std::size_t i = 0; i < stiffened_.size(); ++i) {
    const Vector3& trial = cone_projection_.trials()[i];
    LinearContact& c = contacts[i];
    const Vector3& pushed = cone_projection_.forces()[i];
    stiffened_[i] = problem_.force(i, pushed - x_[i]);
    x_[i] = pushed;
    c.mode = mode_of(admissible(i), trial, c.friction);
    c.force = problem_.force(i, x_[i]);
  }
  problem_.respond(x_, motion_);
  return count;
}

/// The largest share of the forces that close gaps with which the work of all is not positive.
/// moved_: A D of these forces.
double MovingContacts::closed_share() const {
  const std::span<const Vector3> change = projection_.forces();
  double work = 0.0, slope = 0.0, bend = 0.0;  // work + slope s + bend s2
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const Vector3 motion = motion_[i] - problem_.unmoved(i);
    work += x_[i].dot(motion);
    slope += x_[i].dot(moved_[i]) + change[i].dot(motion);
    bend += change[i].dot(moved_[i]);
  }
  if (work + slope + bend <= 0.0) return 1.0;
  const double root = std::sqrt(std::max(0.0, slope * slope - 4.0 * bend * work));
  return slope > 0.0 ? -2.0 * std::min(work, 0.0) / (slope + root)
                     : std::min(1.0, (root - slope) / (2.0 * bend));
}

/// `share`, or as much more as leaves no overlap beyond the limit.
double MovingContacts::within_limit(double share) const {
  const double limit = kLimit * gap_;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const double gap = problem_.motion(i, motion_[i] + problem_.unmended(i))[0];
    const double rise = problem_.motion(i, moved_[i])[0];
    if (gap + share * rise < -limit && rise > 0.0) share = std::min(1.0, (-limit - gap) / rise);
  }
  return share;
}

/// Forces that move the blocks least so that gaps are closed to within `gap`, m.
IterationCount MovingContacts::project(const AddedForces& start, double gap) {
  const IterationLimit limit{gap, std::min(kMostMending, iterations_left_)};
  const IterationCount count = projection_.solve(problem_, x_, modes_, all_to_mend(), start, limit);
  iterations_left_ -= count.iterations;
  const std::span<const Vector3> change = projection_.forces();
  added_.resize(x_.size());
  moved_.resize(x_.size());
  for (std::size_t i = 0; i < x_.size(); ++i) added_[i] = x_[i] + change[i];
  problem_.respond(added_, moved_);
  for (std::size_t i = 0; i < x_.size(); ++i) moved_[i] -= motion_[i];
  return count;
}

/// Moves the blocks least so that gaps are closed; forces may leave their cones a little. Where
/// hard contacts' overlaps are beyond the limit, and to mend all would make energy, they alone are
/// mended: a share of all gaps would lift all blocks.
IterationCount MovingContacts::close(std::span<LinearContact> contacts) {
  modes_.clear();
  for (const LinearContact& c : contacts) modes_.push_back(c.mode);
  IterationCount count = project(guess(closed_), gap_);
  const bool whole = softness_ > 0.0 && !keeps_gaps_;
  const double paid = whole ? 1.0 : closed_share();
  double share = within_limit(paid);
  if (share > paid && softness_ == 0.0) {
    keeps_gaps_ = true;
    add(project({}, kFineGap * gap_), count);
    share = within_limit(closed_share());
    keeps_gaps_ = false;
  }
  const std::span<const Vector3> change = projection_.forces();
  closed_.resize(x_.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    closed_[i] = problem_.force(i, change[i]);
    if (share == 0.0 || change[i].isZero(0.0)) continue;
    LinearContact& c = contacts[i];
    x_[i] += share * change[i];
    c.force = problem_.force(i, x_[i]);
    if (c.mode == ContactMode::Open) c.mode = ContactMode::Slip;
  }
  problem_.respond(x_, motion_);
  return count;
}

/// Of contacts that yield. Where these forces make energy it is left to another try.
IterationCount MovingContacts::mend_yielded(std::span<LinearContact> contacts) {
  IterationCount total = stiffen(contacts);
  total.converged = !apart();
  const bool again = !keeps_gaps_ && work().sum > 0.0;
  if (!total.converged && !again) add(close(contacts), total);
  return total;
}

/// Closes the gaps that the forces have left. The forces of that are added to those of the
/// contacts, so that velocities get none of it; the iteration goes on from its own. Where all these
/// forces would make energy, overlaps that the step began with are kept.
IterationCount MovingContacts::mend(std::span<LinearContact> contacts) {
  IterationCount total;
  total.converged = !apart() && !(softness_ > 0.0 && work().sum > 0.0);
  if (total.converged) return total;
  if (softness_ == 0.0) return close(contacts);
  yielded_forces_ = x_;
  if (!keeps_gaps_) {
    total = mend_yielded(contacts);
    if (!(work().sum > 0.0)) return total;
    keeps_gaps_ = true;
    x_ = yielded_forces_;
    record(contacts);
  }
  add(mend_yielded(contacts), total);
  return total;
}

OpenCloseResult MovingContacts::solve(const BlockSystem& base, const BlockVector& force,
                                      std::span<LinearContact> contacts,
                                      const OpenCloseOptions& options, BlockVector& increment) {
  const bool positions = options.mended_apart > 0.0;
  const bool first = options.predicted || bar_force_.size() != contacts.size();
  if (positions && first) begin();
  problem_.set(base, force, contacts, increment, options.mended_apart);
  start(contacts, first);
  iterations_left_ = options.max_iterations;
  const double crowd = crowd_tolerance(options.force_tolerance);
  forces_ = options.fine ? options.force_tolerance : crowd;
  IterationCount count = iterate(options.rough ? std::max(forces_, kRoughForces) : forces_);
  if (!positions && count.converged) add(harden(), count);
  record(contacts);
  if (positions) yielded_ = softness_ > 0.0;
  OpenCloseResult result;
  if (count.converged && positions && !options.rough) {
    gap_ = kGap * crowd * *std::ranges::min_element(slots_->length);
    IterationCount mended = mend(contacts);
    result.closed = mended.converged;
    mended.converged = true;  // what is left of the gaps is the next step's
    mended.residual = count.residual;
    add(mended, count);
  }
  bar_force_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) bar_force_[i] = problem_.force(i, bar_[i]);
  result.converged = count.converged;
  result.iterations = count.iterations;
  result.solves = count.solves;
  result.factorizations = count.factorizations;
  result.residual = count.residual;
  result.change = largest_motion(*slots_, problem_.increment());
  for (std::size_t s = 0; s < increment.size(); ++s) increment[s] += problem_.increment()[s];
  for (LinearContact& c : contacts) {
    c.relative = c.offset;
    if (c.slot_a >= 0) c.relative += c.jacobian_a * increment[static_cast<std::size_t>(c.slot_a)];
    if (c.slot_b >= 0) c.relative += c.jacobian_b * increment[static_cast<std::size_t>(c.slot_b)];
  }
  if (count.factorizations > 0) result.condition = problem_.condition_estimate();
  return result;
}

}  // namespace quoin::solver
