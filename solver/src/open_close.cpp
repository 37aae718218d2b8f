#include "open_close.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/joint_law.hpp"

namespace quoin::solver {
namespace {

constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();  // a sum of 12 products
constexpr double kFarResidual = 1e-2;  // a guess that far out says nothing of the contacts' modes
constexpr double kAtRest = 10.0;       // tolerances: a guess this good needs no solve; solved is 1
constexpr double kLastPush = 10.0;     // of the force tolerance: an update that is not needed
constexpr double kStalled = 0.9;       // of the last gap is left: then
constexpr double kStalledPush = 1e6;   // of the force tolerance, and
constexpr double kStalledGap = 10.0;   // of the gap tolerance is enough
constexpr double kSlow = 0.5;          // of the last gap is left: augmentation is raised, by 10,
constexpr double kFixed = 0.999;       // but not for gaps that no force can close
constexpr int kMostRaises = 6;         // mass ratios of 1e6, with what augmentation is already
constexpr double kNegligible = 1e-10;  // of the largest contact force: no friction worth following

// Newton's method and the softness of contacts. Chosen on a sample of falling and standing arches,
// tilted walls and heaps, rigid and deformable; twice or half of any of them took up to a tenth
// more solves.
constexpr int kMostSteps = 30;
constexpr int kPatience = 5;       // steps, in which the residual must come down to
constexpr double kProgress = 0.7;  // of what it was
constexpr double kSoft = 1e-4;     // after full stiffness failed
constexpr double kSofter = 0.1;    // after that failed, too
constexpr double kSoftest = 1e-9;
constexpr double kStiffer = 5.0;  // after it was solved in
constexpr int kQuickSteps = 4;
constexpr double kLooseResidual = 1e-4;  // while gaps are above the tolerance, at most, and
constexpr double kLooseShare = 1e-2;     // of the residual that the last update left

std::size_t index(int i) { return static_cast<std::size_t>(i); }

bool is_symmetric(const Matrix3& matrix) { return matrix(1, 0) == 0.0 && matrix(2, 0) == 0.0; }

/// Largest violation of the contact conditions that multipliers should remove, m.
double violation(std::span<const LinearContact> contacts) {
  double worst = 0.0;
  for (const LinearContact& c : contacts) {
    if (c.compliant || c.mode == ContactMode::Open) continue;
    worst = std::max(worst, std::abs(c.relative[0]));
    if (c.mode == ContactMode::Stick) worst = std::max(worst, c.relative.tail<2>().norm());
  }
  return worst;
}

/// Between blocks that stand gaps and slips within their rounding are zero: redundant contacts then
/// agree. What they would bear for such gaps finds no end.
void round_to_zero(Vector3& relative, double rounding) {
  for (double& d : relative) {
    if (std::abs(d) <= rounding) d = 0.0;
  }
}

}  // namespace

void set_pairs(std::span<LinearContact> contacts, BlockSystem& base) {
  auto& pairs = base.pairs;
  pairs.clear();
  for (const LinearContact& c : contacts) {
    if (c.slot_a >= 0 && c.slot_b >= 0) pairs.push_back(std::minmax(c.slot_a, c.slot_b));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  for (LinearContact& c : contacts) {
    if (c.slot_a < 0 || c.slot_b < 0) continue;
    const std::pair<int, int> pair = std::minmax(c.slot_a, c.slot_b);
    c.pair = static_cast<int>(std::lower_bound(pairs.begin(), pairs.end(), pair) - pairs.begin());
  }
}

/// Blocks that the forces known so far hold where they stand, and so all that they touch, do not
/// move to begin with: what they were guessed to do is rounding. Returns the largest motion taken
/// back, m.
double OpenClose::stand(const BlockSystem& base, const BlockVector& force,
                        std::span<LinearContact> contacts, double tolerance, BlockVector& guess) {
  still_.assign(guess.size(), Vector12::Zero());
  if (guess == still_) return 0.0;
  shift(base, force, contacts, still_);
  evaluate(base, contacts, change_, Law::True);
  stands_.resize(guess.size());
  for (std::size_t s = 0; s < guess.size(); ++s) stands_[s] = balanced(s, tolerance);
  for (bool spreads = true; spreads;) {
    spreads = false;
    for (const LinearContact& c : contacts) {
      if (c.mode == ContactMode::Open || c.slot_a < 0 || c.slot_b < 0) continue;
      char &a = stands_[index(c.slot_a)], &b = stands_[index(c.slot_b)];
      spreads = spreads || a != b;
      a = b = a && b;
    }
  }
  double taken_back = 0.0;
  for (std::size_t s = 0; s < guess.size(); ++s) {
    if (!stands_[s]) continue;
    taken_back = std::max(taken_back, motion_of(guess[s], slots_->length[s]));
    guess[s].setZero();
  }
  return taken_back;
}

/// From here on the unknown is the change against the first guess: forces and gaps are then rounded
/// like the change and not like the whole motion of the step.
void OpenClose::shift(const BlockSystem& base, const BlockVector& force,
                      std::span<LinearContact> contacts, const BlockVector& guess) {
  rigid_ ? shift_in<6>(base, force, contacts, guess) : shift_in<12>(base, force, contacts, guess);
}

/// `n`: the unknowns of each block, at most.
template <int n>
void OpenClose::shift_in(const BlockSystem& base, const BlockVector& force,
                         std::span<LinearContact> contacts, const BlockVector& guess) {
  right_.resize(guess.size());
  change_.assign(guess.size(), Vector12::Zero());
  floor_.resize(guess.size());
  for (std::size_t s = 0; s < guess.size(); ++s) {
    Vector12 inner = Vector12::Zero();
    inner.head<n>() = base.diagonal[s].topLeftCorner<n, n>() * guess[s].head<n>();
    right_[s] = force[s] - inner;
    const double length = slots_->length[s];
    floor_[s] = kRounding * (force_size(force[s], length) + force_size(inner, length));
  }
  for (LinearContact& c : contacts) {
    c.guess = c.offset;
    double size = 0.0;  // sum of magnitudes in J D: what its rounding is measured against, m
    const auto move = [&](int slot, const Matrix3x12& jacobian) {
      if (slot < 0) return;
      const auto part = jacobian.leftCols<n>();
      const auto motion = guess[index(slot)].head<n>();
      c.guess.noalias() += part * motion;
      size += (part.cwiseAbs() * motion.cwiseAbs()).maxCoeff();
    };
    move(c.slot_a, c.jacobian_a);
    move(c.slot_b, c.jacobian_b);
    if (size == 0.0) round_to_zero(c.guess, rounding_);
    const double noise = kRounding * std::max(c.normal_stiffness, c.shear_stiffness) * size;
    if (c.slot_a >= 0) floor_[index(c.slot_a)] += noise;
    if (c.slot_b >= 0) floor_[index(c.slot_b)] += noise;
  }
}

void OpenClose::evaluate(const BlockSystem& base, std::span<LinearContact> contacts,
                         const BlockVector& change, Law law) {
  rigid_ ? evaluate_in<6>(base, contacts, change, law)
         : evaluate_in<12>(base, contacts, change, law);
}

/// `n`: the unknowns of each block, at most.
template <int n>
void OpenClose::evaluate_in(const BlockSystem& base, std::span<LinearContact> contacts,
                            const BlockVector& change, Law law) {
  for (std::size_t s = 0; s < change.size(); ++s) {
    Vector12 inner = Vector12::Zero();
    inner.head<n>() = base.diagonal[s].topLeftCorner<n, n>() * change[s].head<n>();
    residual_[s] = right_[s] - inner;
    const double length = slots_->length[s];
    scale_[s] = force_size(right_[s], length) + force_size(inner, length);
  }
  for (LinearContact& c : contacts) {
    c.relative = c.guess;
    const auto move = [&](int slot, const Matrix3x12& jacobian) {
      if (slot >= 0) c.relative.noalias() += jacobian.leftCols<n>() * change[index(slot)].head<n>();
    };
    move(c.slot_a, c.jacobian_a);
    move(c.slot_b, c.jacobian_b);
    if (law == Law::Assumed) {
      apply_assumed(softness_, c);
    } else {
      apply_law(softness_, c);
    }
    if (c.mode == ContactMode::Open) continue;
    const double size = c.force.norm();
    const auto push = [&](int slot, const Matrix3x12& jacobian) {
      if (slot < 0) return;
      residual_[index(slot)].head<n>().noalias() += jacobian.leftCols<n>().transpose() * c.force;
      scale_[index(slot)] += size;
    };
    push(c.slot_a, c.jacobian_a);
    push(c.slot_b, c.jacobian_b);
  }
}

double OpenClose::relative_residual() const {
  double worst = 0.0;
  for (std::size_t s = 0; s < residual_.size(); ++s) {
    const double size = std::max(0.0, force_size(residual_[s], slots_->length[s]) - floor_[s]);
    if (!(size <= worst * scale_[s])) worst = size / std::max(scale_[s], 1e-300);
  }
  return worst;
}

bool OpenClose::balanced(std::size_t slot, double tolerance) const {
  return force_size(residual_[slot], slots_->length[slot]) - floor_[slot] <=
         tolerance * scale_[slot];
}

double OpenClose::slope(const BlockVector& direction) const {
  double sum = 0.0;
  for (std::size_t s = 0; s < direction.size(); ++s) sum += residual_[s].dot(direction[s]);
  return sum;
}

bool OpenClose::same_tangent(std::span<const LinearContact> contacts, Law law) {
  next_tangent_.resize(contacts.size());
  TangentOptions options{law == Law::Assumed, softness_, 0.0};
  for (const LinearContact& c : contacts) {
    options.negligible = std::max(options.negligible, kNegligible * c.force.norm());
  }
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    next_tangent_[c] = tangent(contacts[c], options);
  }
  const bool same = factorized_ && next_tangent_ == tangent_;
  std::swap(tangent_, next_tangent_);
  return same;
}

void OpenClose::assemble(const BlockSystem& base, std::span<const LinearContact> contacts) {
  system_.diagonal = base.diagonal;
  system_.pairs = base.pairs;
  system_.frames = base.frames;
  system_.off_diagonal.assign(base.pairs.size(), Matrix12::Zero());
  const bool symmetric = system_.symmetric =
      std::all_of(tangent_.begin(), tangent_.end(), is_symmetric);
  system_.mirrored.clear();
  if (!symmetric) system_.mirrored.assign(base.pairs.size(), Matrix12::Zero());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].mode == ContactMode::Open) continue;
    rigid_ ? add_contact<6>(contacts[i], tangent_[i]) : add_contact<12>(contacts[i], tangent_[i]);
  }
}

/// `n`: the unknowns of each of its blocks, at most.
template <int n>
void OpenClose::add_contact(const LinearContact& c, const Matrix3& tangent) {
  using Jacobian = Eigen::Matrix<double, 3, n>;
  const Jacobian a = c.jacobian_a.leftCols<n>(), b = c.jacobian_b.leftCols<n>();
  const Jacobian stiff_a = tangent * a, stiff_b = tangent * b;
  const auto add = [](const Jacobian& left, const Jacobian& right, Matrix12& block) {
    block.topLeftCorner<n, n>().noalias() += left.transpose() * right;
  };
  if (c.slot_a >= 0) add(a, stiff_a, system_.diagonal[index(c.slot_a)]);
  if (c.slot_b >= 0) add(b, stiff_b, system_.diagonal[index(c.slot_b)]);
  if (c.pair < 0) return;
  Matrix12& upper = system_.off_diagonal[index(c.pair)];
  const bool ascending = c.slot_a < c.slot_b;
  ascending ? add(a, stiff_b, upper) : add(b, stiff_a, upper);
  if (system_.symmetric) return;
  Matrix12& lower = system_.mirrored[index(c.pair)];
  ascending ? add(b, stiff_a, lower) : add(a, stiff_b, lower);
}

/// One Newton step with a search along it.
bool OpenClose::newton_step(const BlockSystem& base, std::span<LinearContact> contacts, Law law,
                            OpenCloseResult& result) {
  if (watch_ != nullptr) watch_->look();
  if (!same_tangent(contacts, law)) {
    assemble(base, contacts);
    factorized_ = solver_.factorize(system_);
    ++result.factorizations;
    if (!factorized_) return false;
  }
  const BlockVector& right = residual_;
  if (!solver_.solve(right, step_)) return false;
  ++result.solves;
  if (law == Law::Assumed) {
    move(base, contacts, Law::True, 1.0);
  } else if (system_.symmetric) {
    search_slope(base, contacts, law);
  } else {
    search_residual(base, contacts, law);
  }
  std::swap(change_, trial_);
  return true;
}

void OpenClose::move(const BlockSystem& base, std::span<LinearContact> contacts, Law law,
                     double share) {
  for (std::size_t s = 0; s < step_.size(); ++s) trial_[s] = change_[s] + share * step_[s];
  evaluate(base, contacts, trial_, law);
}

/// Squared residual, moments and strain moments by block length, N2.
double OpenClose::squared_residual() const {
  double sum = 0.0;
  for (std::size_t s = 0; s < residual_.size(); ++s) {
    const double length = slots_->length[s];
    sum += residual_[s].head<3>().squaredNorm() +
           residual_[s].tail<9>().squaredNorm() / (length * length);
  }
  return sum;
}

/// No convex function stands behind an unsymmetric step: halve it until the residual falls, or take
/// the share that comes nearest to that.
void OpenClose::search_residual(const BlockSystem& base, std::span<LinearContact> contacts,
                                Law law) {
  const double before = squared_residual();
  double best = std::numeric_limits<double>::infinity(), best_share = 1.0, share = 1.0;
  for (int search = 0; search < 8; ++search, share *= 0.5) {
    move(base, contacts, law, share);
    const double now = squared_residual();
    if (now < best) {
      best = now;
      best_share = share;
    }
    if (now <= (1.0 - 0.5 * share) * before) return;
  }
  move(base, contacts, law, best_share);
}

/// The residual is minus the gradient of a convex function: its slope along the step falls and
/// crosses zero once.
void OpenClose::search_slope(const BlockSystem& base, std::span<LinearContact> contacts, Law law) {
  const double slope_start = slope(step_);
  double low = 0.0, high = 1.0;
  double at = 1.0;
  for (int search = 0; search < 30; ++search) {
    move(base, contacts, law, at);
    const double slope_now = slope(step_);
    if (std::abs(slope_now) <= 0.1 * std::abs(slope_start)) break;
    if (slope_now > 0.0) {
      if (at >= 1.0) break;
      low = at;
    } else {
      high = at;
    }
    at = 0.5 * (low + high);
  }
}

/// Takes the forces as the new multipliers.
void OpenClose::update_multipliers(std::span<LinearContact> contacts) {
  for (LinearContact& c : contacts) {
    if (!c.compliant) c.multiplier = c.force;
  }
}

/// Newton steps until the residual is small. False when it does not fall any more.
bool OpenClose::relax(const BlockSystem& base, std::span<LinearContact> contacts, double tolerance,
                      OpenCloseResult& result) {
  double reached = std::numeric_limits<double>::infinity();
  int waited = 0;
  for (int i = 0; i < kMostSteps && result.iterations < most_; ++i) {
    const double residual = relative_residual();
    if (residual <= tolerance) return true;
    if (residual <= kProgress * reached) {
      reached = residual;
      waited = 0;
    } else if (++waited == kPatience) {
      return false;
    }
    ++result.iterations;
    if (!newton_step(base, contacts, Law::True, result)) return false;
  }
  return relative_residual() <= tolerance;
}

/// Soft contacts only hand their forces on as the next multipliers: good to a share is enough until
/// the gaps are within the tolerance.
double OpenClose::wanted_residual(std::span<const LinearContact> contacts,
                                  const OpenCloseOptions& options) const {
  if (softness_ == 1.0 || violation(contacts) <= options.gap_tolerance) {
    return options.force_tolerance;
  }
  return std::max(options.force_tolerance,
                  std::min(kLooseResidual, kLooseShare * relative_residual()));
}

/// Solves, takes the forces as multipliers and solves again until that changes nothing any more.
/// Stiff contacts change their mode one joint after the other and Newton's method may find no way;
/// soft ones all at once. Where it fails it goes back to the last solution with softer contacts,
/// and stiffer ones again as they are quickly solved.   [Rockafellar 1976]
bool OpenClose::converge(const BlockSystem& base, std::span<LinearContact> contacts,
                         const OpenCloseOptions& options, OpenCloseResult& result) {
  const bool springs = std::ranges::any_of(contacts, &LinearContact::compliant);
  solved_.assign(change_.size(), Vector12::Zero());
  while (result.iterations < options.max_iterations) {
    const int before = result.iterations;
    if (relax(base, contacts, wanted_residual(contacts, options), result)) {
      solved_ = change_;
      const bool exact = relative_residual() <= options.force_tolerance;
      if (exact && (softness_ == 1.0 || !springs) && settled(contacts, options)) return true;
      update_multipliers(contacts);
      if (result.iterations - before <= kQuickSteps) {
        softness_ = std::min(1.0, kStiffer * softness_);
      }
      result.iterations = std::max(result.iterations, before + 1);
    } else {
      change_ = solved_;
      softness_ = softness_ == 1.0 ? kSoft : std::max(kSoftest, kSofter * softness_);
    }
    evaluate(base, contacts, change_, Law::True);
  }
  return false;
}

/// What the next multipliers would do to the blocks, relative to the forces there. Parts that
/// cancel are left out: redundant contacts that disagree by less than the tolerance shift them for
/// ever.
double OpenClose::push_of_update(std::span<const LinearContact> contacts) {
  for (Vector12& push : trial_) push.setZero();
  for (const LinearContact& c : contacts) {
    if (c.compliant) continue;
    const Vector3 push = force_after_update(c) - c.force;
    if (c.slot_a >= 0) trial_[index(c.slot_a)].noalias() += c.jacobian_a.transpose() * push;
    if (c.slot_b >= 0) trial_[index(c.slot_b)].noalias() += c.jacobian_b.transpose() * push;
  }
  double worst = 0.0;
  for (std::size_t s = 0; s < trial_.size(); ++s) {
    worst = std::max(worst, force_size(trial_[s], slots_->length[s]) / std::max(scale_[s], 1e-300));
  }
  return worst;
}

/// A light block that carries a heavy one opposes to a contact much less than what must pass
/// through it: ten times stiffer where more than `gap` (m) is left.
void OpenClose::raise_augmentation(std::span<LinearContact> contacts, double gap) {
  for (LinearContact& c : contacts) {
    if (c.compliant || c.mode == ContactMode::Open) continue;
    if (std::abs(c.relative[0]) > gap) c.normal_stiffness *= 10.0;
    if (c.mode == ContactMode::Stick && c.relative.tail<2>().norm() > gap) {
      c.shear_stiffness *= 10.0;
    }
  }
}

/// Solved for its multipliers: are these good? They are when the next update no longer matters, or
/// no longer helps and gaps are within the tolerance (what is left then lies in forces that nearly
/// cancel). The forces are then wrong by about the push over 1e2: by so much at least is the
/// augmentation stiffer than a block.
bool OpenClose::settled(std::span<LinearContact> contacts, const OpenCloseOptions& options) {
  const double gap = violation(contacts);
  if (gap <= options.gap_rounding) return true;
  const double left = gap / last_gap_;
  last_gap_ = gap;
  const bool stalled = softness_ == 1.0 && left > kStalled;
  if (gap <= (stalled ? kStalledGap : 1.0) * options.gap_tolerance) {
    const double allowed = stalled ? kStalledPush : kLastPush;
    if (push_of_update(contacts) <= allowed * options.force_tolerance) return true;
  }
  const bool slow = left > kSlow && left < kFixed && updates_ > 0 && softness_ == 1.0;
  if (options.raise && slow && raises_ < kMostRaises) {
    ++raises_;
    raise_augmentation(contacts, 0.1 * gap);
  }
  ++updates_;
  return false;
}

OpenCloseResult OpenClose::solve(const BlockSystem& base, const BlockVector& force,
                                 std::span<LinearContact> contacts, const OpenCloseOptions& options,
                                 BlockVector& increment) {
  OpenCloseResult result;
  const double tolerance = options.force_tolerance;
  const std::size_t n = increment.size();
  residual_.resize(n);
  step_.resize(n);
  trial_.resize(n);
  scale_.resize(n);
  factorized_ = false;
  solver_.forget();
  raises_ = updates_ = 0;
  most_ = options.max_iterations;
  rounding_ = options.gap_rounding;
  softness_ = 1.0;
  if (options.predicted || !options.raise) last_gap_ = std::numeric_limits<double>::infinity();
  if (options.predicted) {
    result.change = stand(base, force, contacts, kAtRest * tolerance, increment);
  }
  shift(base, force, contacts, increment);
  evaluate(base, contacts, change_, Law::True);
  result.residual = relative_residual();
  if (result.residual <= kAtRest * tolerance && violation(contacts) <= options.gap_rounding) {
    result.converged = true;  // nothing has happened since the last step
    return result;
  }
  if (result.residual > kFarResidual) {
    evaluate(base, contacts, change_, Law::Assumed);
    ++result.iterations;
    if (!newton_step(base, contacts, Law::Assumed, result)) {
      evaluate(base, contacts, change_, Law::True);
    }
  }
  result.converged = converge(base, contacts, options, result);
  result.residual = relative_residual();
  for (LinearContact& c : contacts) c.assumed = c.mode;
  for (std::size_t s = 0; s < n; ++s) {
    increment[s] += change_[s];
    result.change = std::max(result.change, motion_of(change_[s], slots_->length[s]));
  }
  if (factorized_) result.condition = solver_.condition_estimate();
  return result;
}

}  // namespace quoin::solver
