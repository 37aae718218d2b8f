#include "iteration/moving_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace quoin::solver {
namespace {

// Of contacts in their cones, by their own Delassus block: of 100, 250 and 400 the one with which
// shaken walls gain least.
constexpr double kStiffness = 250.0;
// Of gaps, likewise. Chosen on shaken walls of 27 and 105: 100 leaves ten times the overlaps,
// sticking contacts of 10 take a third more steps.
constexpr double kStiff = 1e3, kStick = 1.0;
constexpr int kSearch = 12;         // values of the slope along a step, at most; it ends at
constexpr double kFlatCone = 1e-2;  // of the slope that the step begins with

/// Where along a step, at most 1, a slope that never falls is zero: false position, the slope of
/// the end that stays halved.   [Dowell & Jarratt 1971]
template <class Slope>
double flat_share(const Slope& slope) {
  double low = 0.0, high = 1.0, low_slope = slope(0.0), high_slope = slope(1.0);
  if (!(high_slope > 0.0) || !(low_slope < 0.0)) return 1.0;
  const double enough = -kFlatCone * low_slope;
  int last = 0;  // the end that moved
  for (int k = 0; k < kSearch; ++k) {
    const double share = (low * high_slope - high * low_slope) / (high_slope - low_slope);
    const double at = slope(share);
    if (std::abs(at) <= enough) return share;
    const int side = at < 0.0 ? 1 : -1;
    (side > 0 ? low : high) = share;
    (side > 0 ? low_slope : high_slope) = at;
    if (last == side) (side > 0 ? high_slope : low_slope) *= 0.5;
    last = side;
  }
  return high;
}

}  // namespace

void ConvexNewton::start(std::size_t contacts, const AddedForces& guess) {
  moved_.assign(guess.motion.begin(), guess.motion.end());
  forces_.assign(guess.x.begin(), guess.x.end());
  for (auto* memory : {&moved_, &forces_, &next_moved_, &next_forces_})
    memory->resize(contacts, Vector3::Zero());
  tangents_.resize(contacts);
}

template <class Force>
bool ConvexNewton::step(ConeProblem& problem, const Force& force) {
  const std::size_t contacts = forces_.size();
  if (!problem.factorize(tangents_, Tangents::Symmetric)) return false;
  problem.solve(next_forces_, next_moved_);
  for (std::size_t i = 0; i < contacts; ++i) next_forces_[i] -= tangents_[i] * next_moved_[i];
  const double share = flat_share([&](double at) {  // K D is what the forces are
    double sum = 0.0;
    for (std::size_t i = 0; i < contacts; ++i) {
      const Vector3 way = next_moved_[i] - moved_[i];
      const Vector3 now = forces_[i] + at * (next_forces_[i] - forces_[i]);
      sum += (now - force(i, moved_[i] + at * way)).dot(way);
    }
    return sum;
  });
  for (std::size_t i = 0; i < contacts; ++i) {
    forces_[i] += share * (next_forces_[i] - forces_[i]);
    moved_[i] += share * (next_moved_[i] - moved_[i]);
  }
  return true;
}

void ConeProjection::freeze(std::span<const Admissible> admissible) {
  admissible_.assign(admissible.begin(), admissible.end());
  for (std::size_t i = 0; i < admissible_.size(); ++i) {
    Admissible& forces = admissible_[i];
    forces.cohesion = forces.shear_limit(x_[i][0]);
    forces.friction = 0.0;
  }
}

Vector3 ConeProjection::trial(std::size_t contact, const Vector3& moved) const {
  return x_[contact] - kStiffness * (start_[contact] + moved);
}

/// How far the forces that give D are from P(x - r y), by the largest.
double ConeProjection::update_trials() {
  double left = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    trial_[i] = trial(i, moved_[i]);
    const Vector3 pushed = pushed_[i] = project_on(admissible_[i], trial_[i]);
    left = std::max(left, (pushed - x_[i] - forces_[i]).norm());
    largest = std::max(largest, pushed.norm());
  }
  return left / std::max(largest, 1e-300);
}

bool ConeProjection::take_step(ConeProblem& problem) {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const auto [pushed, derivative] = project_smoothly(admissible_[i], trial_[i], 0.0);
    tangents_[i] = kStiffness * derivative;
    next_forces_[i] = pushed - x_[i] + tangents_[i] * moved_[i];
  }
  return step(problem, [&](std::size_t i, const Vector3& moved) -> Vector3 {
    return project_on(admissible_[i], trial(i, moved)) - x_[i];
  });
}

IterationCount ConeProjection::solve(ConeProblem& problem, std::span<const Vector3> x,
                                     std::span<const Vector3> apart, const AddedForces& guess,
                                     const IterationLimit& limit) {
  IterationCount count;
  x_ = x;
  freeze(problem.admissible());
  start_.resize(x.size());
  std::ranges::transform(admissible_, apart, start_.begin(), corrected);
  start(x.size(), guess);
  trial_ = pushed_ = moved_;
  for (;;) {
    count.residual = update_trials();
    count.converged = count.residual <= limit.residual;
    if (count.converged || count.iterations >= limit.iterations) return count;
    ++count.iterations;
    ++count.factorizations;
    if (!take_step(problem)) return count;
    ++count.solves;
  }
}

void GapProjection::set_gaps(std::span<const Vector3> x, std::span<const ContactMode> modes,
                             std::span<const Vector3> motion) {
  gap_.assign(motion.begin(), motion.end());
  borne_.resize(x.size());
  sticks_.resize(x.size());
  closed_.assign(x.size(), 0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    borne_[i] = modes[i] == ContactMode::Open ? 0.0 : x[i][0];
    sticks_[i] = modes[i] == ContactMode::Stick;
  }
  multiplier_ = borne_;
}

/// x_n that the contact bears of what presses it.
double GapProjection::normal_force(std::size_t contact, double trial) const {
  return admissible_[contact].pulls ? trial : std::max(0.0, trial);
}

Vector3 GapProjection::force(std::size_t contact, const Vector3& moved) const {
  const Vector3 left = gap_[contact] + moved;
  Vector3 force = Vector3::Zero();
  force[0] = normal_force(contact, multiplier_[contact] - kStiff * left[0]) - borne_[contact];
  if (sticks_[contact]) force.tail<2>() = -kStick * left.tail<2>();
  return force;
}

bool GapProjection::pressed(std::size_t contact) const {
  if (admissible_[contact].pulls) return true;
  return kStiff * (gap_[contact][0] + moved_[contact][0]) < multiplier_[contact];
}

/// m
double GapProjection::largest_stretch(const ConeProblem& problem) const {
  double most = 0.0;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    if (!sticks_[i]) continue;
    most = std::max(most, problem.motion(i, gap_[i] + moved_[i]).tail<2>().norm());
  }
  return most;
}

/// Of contacts that are pressed, m.
double GapProjection::largest_gap(const ConeProblem& problem) const {
  double most = 0.0;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    if (!pressed(i)) continue;
    most = std::max(most, std::abs(problem.motion(i, gap_[i] + moved_[i])[0]));
  }
  return most;
}

/// The first one takes all that bear forces for closed.
bool GapProjection::take_step(ConeProblem& problem, bool first) {
  changed_ = first;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    const double stick = sticks_[i] ? kStick : 0.0;
    const bool closed = pressed(i) || (first && borne_[i] > 0.0);
    changed_ = changed_ || closed != (closed_[i] != 0);
    closed_[i] = closed;
    tangents_[i] = Vector3(closed ? kStiff : 0.0, stick, stick).asDiagonal();
    next_forces_[i] = -tangents_[i] * gap_[i];
    next_forces_[i][0] += (closed ? multiplier_[i] : 0.0) - borne_[i];
  }
  return step(problem, [&](std::size_t i, const Vector3& moved) { return force(i, moved); });
}

/// Where the function has its minimum: its forces are the next multipliers.
void GapProjection::update_multipliers() {
  for (std::size_t i = 0; i < gap_.size(); ++i)
    multiplier_[i] = normal_force(i, borne_[i] + forces_[i][0]);
}

IterationCount GapProjection::solve(ConeProblem& problem, std::span<const Vector3> x,
                                    std::span<const ContactMode> modes,
                                    std::span<const Vector3> motion, const AddedForces& guess,
                                    const IterationLimit& limit) {
  IterationCount count;
  admissible_ = problem.admissible();
  set_gaps(x, modes, motion);
  start(x.size(), guess);
  if (!guess.x.empty()) update_multipliers();
  bool apart = std::max(largest_gap(problem), largest_stretch(problem)) > limit.residual;
  while (apart && count.iterations < limit.iterations) {
    ++count.iterations;
    ++count.factorizations;
    if (!take_step(problem, count.iterations == 1 && guess.x.empty())) break;
    ++count.solves;
    apart = largest_gap(problem) > limit.residual;
    if (!changed_) update_multipliers();
  }
  count.converged = !apart;
  return count;
}

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
  total.count(part);
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
    total.count(count);
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
    Vector3 u = motion_[i] + to_mend(i, keeps_gaps_);
    if (!admissible(i).pulls) u[0] = std::min(u[0], x_[i][0]);
    if (std::abs(problem_.motion(i, u)[0]) > gap_) return true;
  }
  return false;
}

/// Of the gap and the stretch that the step began with; of gaps that are kept what is beyond the
/// limit. Were overlaps alone kept, blocks would sink by the gaps of other contacts that bear them,
/// until all are at the limit and are lifted again.
Vector3 MovingContacts::to_mend(std::size_t contact, bool keeps_gaps) const {
  const Vector3& unmended = problem_.unmended(contact);
  if (!keeps_gaps) return unmended;
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
std::span<const Vector3> MovingContacts::all_to_mend(bool keeps_gaps) {
  apart_.resize(x_.size());
  for (std::size_t i = 0; i < x_.size(); ++i) apart_[i] = motion_[i] + to_mend(i, keeps_gaps);
  return apart_;
}

/// Stiffer contacts, whose forces stay in their cones, about those that yield. They are as good as
/// these: to 1e-3 of the largest they left gaps of a tenfold, and work, where there were hardly
/// any.
IterationCount MovingContacts::stiffen(std::span<LinearContact> contacts) {
  const AddedForces start = guess(stiffened_);
  const IterationLimit limit{std::min(forces_, kConeForces),
                             std::min(kMostConeSteps, iterations_left_)};
  IterationCount count =
      cone_projection_.solve(problem_, x_, all_to_mend(keeps_gaps_), start, limit);
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

/// Forces that move the blocks least so that what is to be mended is closed to within `gap`, m.
IterationCount MovingContacts::project(const AddedForces& start, double gap, bool keeps_gaps) {
  const IterationLimit limit{gap, std::min(kMostMending, iterations_left_)};
  const IterationCount count =
      projection_.solve(problem_, x_, modes_, all_to_mend(keeps_gaps), start, limit);
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
  IterationCount count = project(guess(closed_), gap_, keeps_gaps_);
  const bool whole = softness_ > 0.0 && !keeps_gaps_;
  const double paid = whole ? 1.0 : closed_share();
  double share = within_limit(paid);
  if (share > paid && softness_ == 0.0) {
    add(project({}, kFineGap * gap_, true), count);
    share = within_limit(closed_share());
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
  forces_ = crowd_tolerance(options.force_tolerance);
  IterationCount count = iterate(options.rough ? std::max(forces_, kRoughForces) : forces_);
  if (!positions && count.converged) add(harden(), count);
  record(contacts);
  if (positions) yielded_ = softness_ > 0.0;
  OpenCloseResult result;
  if (count.converged && positions && !options.rough) {
    gap_ = kGap * forces_ * *std::ranges::min_element(slots_->length);
    IterationCount mended = mend(contacts);
    result.closed = mended.converged;
    mended.converged = true;  // what is left of the gaps is the next step's
    mended.residual = count.residual;
    add(mended, count);
  }
  bar_force_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) bar_force_[i] = problem_.force(i, bar_[i]);
  result.converged = count.converged;
  result.count(count);
  result.residual = count.residual;
  result.change = largest_motion(*slots_, problem_.increment());
  for (std::size_t s = 0; s < increment.size(); ++s) increment[s] += problem_.increment()[s];
  for (LinearContact& c : contacts) {
    c.relative = c.offset;
    c.each_side([&](std::size_t s, const auto& j) { c.relative += j * increment[s]; });
  }
  if (count.factorizations > 0) result.condition = problem_.condition_estimate();
  return result;
}

}  // namespace quoin::solver
