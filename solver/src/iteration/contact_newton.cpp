#include "iteration/contact_newton.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "base/index.hpp"
#include "contact/joint_law.hpp"
#include "linear/pair_stiffness.hpp"

namespace quoin::solver {
namespace {

// A sum of m rounded terms is off by m u of their magnitudes, u = eps / 2 [Higham 2002,
// section 3.1]. The motion of a contact has 25 terms, 12 of each block and its guess; stiffness,
// multiplier, push and the rounding of the increment itself make 29: 32 u.
constexpr double kTermRounding = 16.0 * std::numeric_limits<double>::epsilon();
// Contacts that open and close between two iterations are rounded by what they bear while closed.
// So much of its own forces may be lost in that of a block's contacts while they are open: that of
// stiff, light blocks near others is more than their weight.
constexpr double kOpenRounding = 1e-8;
constexpr double kNoForce = 1e-300;  // N: keeps a quotient finite where no force acts

/// Between blocks that stand gaps and slips within their rounding are zero: redundant contacts then
/// agree. What they would bear for such gaps finds no end.
void round_to_zero(Vector3& relative, double rounding) {
  for (double& d : relative)
    if (std::abs(d) <= rounding) d = 0.0;
}

}  // namespace

ContactEquations::ContactEquations(const Slots& slots) : slots_(&slots) {}

void ContactEquations::shift(const BlockEquations& blocks, std::span<LinearContact> contacts,
                             const BlockVector& guess, double gap_rounding) {
  right_.resize(guess.size());
  block_floor_.resize(guess.size());
  all_noise_.assign(guess.size(), 0.0);
  noise_.clear();
  for (std::size_t s = 0; s < guess.size(); ++s) {
    const Vector12 inner = blocks.base.diagonal.times(s, guess[s]);
    right_[s] = blocks.force[s] - inner;
    const double length = slots_->length[s];
    block_floor_[s] =
        kTermRounding * (force_size(blocks.force[s], length) + force_size(inner, length));
  }
  for (LinearContact& c : contacts) {
    c.guess = c.offset;
    double size = 0.0;  // sum of magnitudes in J D: what its rounding is measured against, m
    c.each_side([&](std::size_t slot, const ContactJacobian& jacobian) {
      c.guess += jacobian * guess[slot];
      size += jacobian.magnitudes(guess[slot]).maxCoeff();
    });
    if (size == 0.0) round_to_zero(c.guess, gap_rounding);
    noise_.push_back(kTermRounding * std::max(c.normal_stiffness, c.shear_stiffness) * size);
    c.each_side([&](std::size_t slot, const auto&) { all_noise_[slot] += noise_.back(); });
  }
}

void ContactEquations::evaluate(const BlockSystem& base, std::span<LinearContact> contacts,
                                const BlockVector& change, Law law, double softness) {
  residual_.resize(change.size());
  scale_.resize(change.size());
  floor_.assign(change.size(), 0.0);
  threads_.each(contacts.size(),
                [&](std::size_t i) { evaluate_contact(change, law, softness, contacts[i]); });
  threads_.ranges(change.size(), [&](std::size_t first, std::size_t end) {
    evaluate_blocks(base, change, first, end);
    push_blocks(contacts, first, end);
    for (std::size_t s = first; s < end; ++s) floor_[s] += floor_beside(s);
  });
}

/// Of a slot what its closed contacts, in floor_, have not.
double ContactEquations::floor_beside(std::size_t slot) const {
  constexpr double kMost = kOpenRounding / kTermRounding;
  const double open = std::max(0.0, all_noise_[slot] - floor_[slot]);
  return block_floor_[slot] + std::min(open, kMost * block_floor_[slot]);
}

void ContactEquations::evaluate_contact(const BlockVector& change, Law law, double softness,
                                        LinearContact& c) const {
  c.relative = c.guess;
  c.each_side([&](std::size_t slot, const ContactJacobian& jacobian) {
    c.relative += jacobian.rigid.lazyProduct(change[slot].head<6>());
    if (jacobian.strain) c.relative += jacobian.strain->lazyProduct(change[slot].tail<6>());
  });
  open_by_slip(c);
  law == Law::Assumed ? apply_assumed(softness, c) : apply_law(softness, c);
}

/// Of slots from `first` on, up to `end`.
void ContactEquations::evaluate_blocks(const BlockSystem& base, const BlockVector& change,
                                       std::size_t first, std::size_t end) {
  for (std::size_t s = first; s < end; ++s) {
    const Vector12 inner = base.diagonal.times(s, change[s]);
    residual_[s] = right_[s] - inner;
    const double length = slots_->length[s];
    scale_[s] = force_size(right_[s], length) + force_size(inner, length);
  }
}

/// What the contacts push those slots with. Every range goes through all contacts, so that a slot
/// sums them in their order.
void ContactEquations::push_blocks(std::span<const LinearContact> contacts, std::size_t first,
                                   std::size_t end) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const LinearContact& c = contacts[i];
    if (c.mode == ContactMode::Open) continue;
    c.each_side([&](std::size_t slot, const ContactJacobian& jacobian) {
      if (slot < first || slot >= end) return;
      Vector12& residual = residual_[slot];
      residual.head<6>().noalias() += jacobian.rigid.transpose() * c.force;
      if (jacobian.strain) residual.tail<6>().noalias() += jacobian.strain->transpose() * c.force;
      scale_[slot] += c.force.norm();
      floor_[slot] += noise_[i];
    });
  }
}

double ContactEquations::residual_beyond_rounding(const BlockSystem& base,
                                                  std::span<const LinearContact> contacts,
                                                  const BlockVector& change,
                                                  double softness) const {
  std::vector<double> floor = floor_;
  add_rounding(base, contacts, change, softness, floor);
  return worst_residual(floor);
}

/// Adds kTermRounding |K| |D|, row by row, closed contacts' stiffness included: what a residual is
/// computed to, and so where Newton's steps end, as refinement does [Skeel 1980].
void ContactEquations::add_rounding(const BlockSystem& base,
                                    std::span<const LinearContact> contacts,
                                    const BlockVector& change, double softness,
                                    std::vector<double>& floor) const {
  for (std::size_t s = 0; s < change.size(); ++s) {
    Vector12 inner = Vector12::Zero();
    const SquareBlocks::ConstBlock block = base.diagonal[s];
    for (Eigen::Index column = 0; column < block.cols(); ++column)
      for (Eigen::Index row = 0; row < block.rows(); ++row)
        inner[row] += std::abs(block(row, column) * change[s][column]);
    floor[s] += kTermRounding * force_size(inner, slots_->length[s]);
  }
  for (const LinearContact& c : contacts) {
    if (c.mode == ContactMode::Open) continue;
    const double stiffness = softness * std::max(c.normal_stiffness, c.shear_stiffness);
    double size = 0.0;
    c.each_side([&](std::size_t slot, const ContactJacobian& jacobian) {
      size += jacobian.magnitudes(change[slot]).maxCoeff();
    });
    const double noise = kTermRounding * stiffness * size;
    c.each_side([&](std::size_t slot, const auto&) { floor[slot] += noise; });
  }
}

/// Infinite where forces overflow, which balance nothing.
double ContactEquations::unbalanced(std::size_t s, double floor) const {
  const double size = force_size(residual_[s], slots_->length[s]);
  if (!std::isfinite(size) || !std::isfinite(scale_[s]))
    return std::numeric_limits<double>::infinity();
  return std::max(0.0, size - floor);
}

double ContactEquations::worst_residual(std::span<const double> floor) const {
  double worst = 0.0;
  for (std::size_t s = 0; s < residual_.size(); ++s) {
    const double size = unbalanced(s, floor[s]);
    if (!std::isfinite(size)) return size;
    if (!(size <= worst * scale_[s])) worst = size / std::max(scale_[s], kNoForce);
  }
  return worst;
}

bool ContactEquations::balanced(std::size_t slot, double tolerance) const {
  const double size = unbalanced(slot, floor_[slot]);
  return std::isfinite(size) && size <= tolerance * scale_[slot];
}

double ContactEquations::squared_residual() const {
  double sum = 0.0;
  for (std::size_t s = 0; s < residual_.size(); ++s) {
    const double length = slots_->length[s];
    sum += residual_[s].head<3>().squaredNorm() +
           residual_[s].tail<9>().squaredNorm() / (length * length);
  }
  return sum;
}

double ContactEquations::relative_push(const BlockVector& push) const {
  double worst = 0.0;
  for (std::size_t s = 0; s < push.size(); ++s)
    worst = std::max(worst, force_size(push[s], slots_->length[s]) / std::max(scale_[s], kNoForce));
  return worst;
}

namespace {

constexpr double kNegligible = 1e-10;  // of the largest contact force: no friction worth following
// Chosen on a sample of falling and standing arches, tilted walls and heaps, rigid and deformable;
// twice or half of any of them took up to a tenth more solves.
constexpr int kMostSteps = 30;
constexpr int kNewtonPatience = 5;  // steps, in which the residual must come down to
constexpr double kProgress = 0.7;   // of what it was
// A block that is pushed and by nothing else is out of balance by all of it: 1, less what rounding
// and the corners of a face make of it.
constexpr double kReached = 0.99;
constexpr int kMostHalvings = 8;     // of a step: the last leaves 1/128 of it
constexpr double kEnoughFall = 0.5;  // of what the tangent promises the squared residual to fall by

bool is_symmetric(const Matrix3& matrix) {
  return matrix.topRightCorner<1, 2>().isZero(0.0) && matrix.bottomLeftCorner<2, 1>().isZero(0.0);
}

}  // namespace

void ContactNewton::set(const BlockEquations& blocks, std::span<LinearContact> contacts,
                        const BlockVector& guess, double gap_rounding) {
  base_ = &blocks.base;
  contacts_ = contacts;
  factorized_ = false;
  change_.assign(guess.size(), Vector12::Zero());
  trial_.resize(guess.size());
  step_.resize(guess.size());
  equations_.shift(blocks, contacts, guess, gap_rounding);
}

void ContactNewton::evaluate(Law law, double softness) {
  equations_.evaluate(*base_, contacts_, change_, law, softness);
}

/// A tangent that is not symmetric is taken for another one each time: what slides has turned since
/// the last one, and the matrix is solved once.
bool ContactNewton::same_tangent(Law law, double softness) {
  TangentOptions options{.assumed = law == Law::Assumed, .softness = softness};
  for (const LinearContact& c : contacts_)
    options.negligible = std::max(options.negligible, kNegligible * c.force.norm());
  std::atomic<bool> same = factorized_ && system_.symmetric && tangent_.size() == contacts_.size();
  tangent_.resize(contacts_.size(), Matrix3::Zero());
  threads_.each(contacts_.size(), [&](std::size_t c) {
    const Matrix3 next = tangent(contacts_[c], options);
    if (next == tangent_[c]) return;
    tangent_[c] = next;
    same.store(false, std::memory_order_relaxed);
  });
  return same;
}

void ContactNewton::assemble() {
  system_.pairs = base_->pairs;
  system_.frames = base_->frames;
  const std::size_t pairs = system_.pairs.size();
  const bool symmetric = system_.symmetric =
      std::all_of(tangent_.begin(), tangent_.end(), is_symmetric);
  const int width = base_->diagonal.width();
  system_.diagonal.resize(base_->diagonal.size(), width);
  system_.off_diagonal.resize(pairs, width);
  system_.mirrored.resize(symmetric ? 0 : pairs, width);
  threads_.each(pairs, [&](std::size_t p) {
    system_.off_diagonal[p].setZero();
    if (!symmetric) system_.mirrored[p].setZero();
  });
  threads_.ranges(system_.diagonal.size(), [&](std::size_t first, std::size_t end) {
    for (std::size_t s = first; s < end; ++s) system_.diagonal[s] = base_->diagonal[s];
    slots_->rigid() ? add_contacts<6>(first, end) : add_contacts<12>(first, end);
  });
}

/// Every range of slots goes through all contacts, so that a block sums them in their order.
/// `n`: the unknowns of each block, at most.
template <int n>
void ContactNewton::add_contacts(std::size_t first, std::size_t end) {
  PairStiffness<n> stiffness(system_, first, end);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const LinearContact& c = contacts_[i];
    if (c.mode == ContactMode::Open || !stiffness.next(c)) continue;
    ContactRows<n> rows;
    rows << c.jacobian_a.columns<n>(), c.jacobian_b.columns<n>();
    stiffness.add(rows, tangent_[i]);
  }
  stiffness.flush();
}

bool ContactNewton::step(Law law, double softness, SolveCount& count) {
  if (watch_ != nullptr) watch_->look();
  if (!same_tangent(law, softness)) {
    assemble();
    factorized_ = solver_.factorize(system_);
    ++count.factorizations;
    if (!factorized_) return false;
  }
  factorized_ = solver_.solve(equations_.residual(), step_);
  if (!factorized_) return false;
  ++count.solves;
  law == Law::Assumed || system_.symmetric ? move(softness, 1.0) : search(softness);
  std::swap(change_, trial_);
  return true;
}

void ContactNewton::move(double softness, double share) {
  for (std::size_t s = 0; s < step_.size(); ++s) trial_[s] = change_[s] + share * step_[s];
  equations_.evaluate(*base_, contacts_, trial_, Law::True, softness);
}

/// Of unsymmetric steps: halved until the residual falls, or the share that comes nearest to that.
/// Others are taken whole: with a search along them 24 scenes took -1 % to 2 % more solutions.
void ContactNewton::search(double softness) {
  const double before = equations_.squared_residual();
  double best = std::numeric_limits<double>::infinity(), best_share = 1.0, share = 1.0;
  for (int search = 0; search < kMostHalvings; ++search, share *= 0.5) {
    move(softness, share);
    const double now = equations_.squared_residual();
    if (now < best) {
      best = now;
      best_share = share;
    }
    if (now <= (1.0 - kEnoughFall * share) * before) return;
  }
  move(softness, best_share);
}

/// Where a row of blocks is hit a joint closes in each step, and the next block is out of balance
/// by all that acts on it. The residual itself, N2, says that there is progress; `least`: so far.
/// Of unsymmetric tangents, which no convex function stands behind, it does not: a boulder that
/// slides on pebbles took two thirds more solves.
bool ContactNewton::reaches_on(double residual, double& least) const {
  const double now = equations_.squared_residual();
  const bool falls = now <= kProgress * kProgress * least;
  if (falls || residual < kReached) least = now;
  return falls && residual >= kReached && system_.symmetric;
}

Relaxed ContactNewton::relax(const RelaxOptions& options, SolveCount& count) {
  const double tolerance = options.tolerance, softness = options.softness;
  double reached = std::numeric_limits<double>::infinity();
  double least = equations_.squared_residual();
  int waited = 0;
  for (int i = 0; i < kMostSteps && count.iterations < options.most_iterations; ++i) {
    const double residual = equations_.relative_residual();
    if (residual <= tolerance) return Relaxed::ToTolerance;
    if (residual <= kProgress * reached) {
      reached = residual;
      waited = 0;
    } else if (reaches_on(residual, least)) {
      waited = 0;
      --i;  // as many as there are joints
    } else if (++waited == kNewtonPatience) {
      const double left = equations_.residual_beyond_rounding(*base_, contacts_, change_, softness);
      return left <= tolerance ? Relaxed::ToRounding : Relaxed::No;
    }
    ++count.iterations;
    if (!step(Law::True, softness, count)) return Relaxed::No;
  }
  const bool solved = equations_.relative_residual() <= tolerance;
  return solved ? Relaxed::ToTolerance : Relaxed::No;
}

}  // namespace quoin::solver
