#include "iteration/contact_equations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"
#include "contact/joint_law.hpp"

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
    const auto move = [&](int slot, const ContactJacobian& jacobian) {
      if (slot < 0) return;
      c.guess += jacobian * guess[index(slot)];
      size += jacobian.magnitudes(guess[index(slot)]).maxCoeff();
    };
    move(c.slot_a, c.jacobian_a);
    move(c.slot_b, c.jacobian_b);
    if (size == 0.0) round_to_zero(c.guess, gap_rounding);
    noise_.push_back(kTermRounding * std::max(c.normal_stiffness, c.shear_stiffness) * size);
    if (c.slot_a >= 0) all_noise_[index(c.slot_a)] += noise_.back();
    if (c.slot_b >= 0) all_noise_[index(c.slot_b)] += noise_.back();
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
  const auto move = [&](int slot, const ContactJacobian& jacobian) {
    if (slot < 0) return;
    c.relative.noalias() += jacobian.rigid * change[index(slot)].head<6>();
    if (jacobian.strain) c.relative.noalias() += *jacobian.strain * change[index(slot)].tail<6>();
  };
  move(c.slot_a, c.jacobian_a);
  move(c.slot_b, c.jacobian_b);
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
    const auto push = [&](int slot, const ContactJacobian& jacobian) {
      if (slot < static_cast<int>(first) || slot >= static_cast<int>(end)) return;
      Vector12& residual = residual_[index(slot)];
      residual.head<6>().noalias() += jacobian.rigid.transpose() * c.force;
      if (jacobian.strain) residual.tail<6>().noalias() += jacobian.strain->transpose() * c.force;
      scale_[index(slot)] += c.force.norm();
      floor_[index(slot)] += noise_[i];
    };
    push(c.slot_a, c.jacobian_a);
    push(c.slot_b, c.jacobian_b);
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
    const auto size = [&](int slot, const ContactJacobian& jacobian) {
      return slot < 0 ? 0.0 : jacobian.magnitudes(change[index(slot)]).maxCoeff();
    };
    const double noise =
        kTermRounding * stiffness * (size(c.slot_a, c.jacobian_a) + size(c.slot_b, c.jacobian_b));
    if (c.slot_a >= 0) floor[index(c.slot_a)] += noise;
    if (c.slot_b >= 0) floor[index(c.slot_b)] += noise;
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

double ContactEquations::slope(const BlockVector& direction) const {
  double sum = 0.0;
  for (std::size_t s = 0; s < direction.size(); ++s) sum += residual_[s].dot(direction[s]);
  return sum;
}

double ContactEquations::relative_push(const BlockVector& push) const {
  double worst = 0.0;
  for (std::size_t s = 0; s < push.size(); ++s)
    worst = std::max(worst, force_size(push[s], slots_->length[s]) / std::max(scale_[s], kNoForce));
  return worst;
}

}  // namespace quoin::solver
