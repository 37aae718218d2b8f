#include "moving/cone_problem.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "moving/cone.hpp"

namespace quoin::solver {
namespace {

constexpr int kLocalSteps = 3;  // projections a contact in each pass

/// diag(1, mu, mu)
Vector3 shares(double friction) { return {1.0, friction, friction}; }

}  // namespace

bool ConeProblem::suits(std::span<const LinearContact> contacts) {
  return std::ranges::all_of(contacts, [](const LinearContact& c) {
    const bool coulomb = c.law == ContactLaw::Coulomb || c.law == ContactLaw::Frictionless;
    return coulomb && !c.compliant && !c.bonded && c.cohesion == 0.0;
  });
}

void ConeProblem::set(const BlockSystem& base, const BlockVector& force,
                      std::span<const LinearContact> contacts, const BlockVector& guess,
                      double mended_apart) {
  base_ = &base;
  contacts_ = contacts;
  const std::size_t blocks = force.size();
  compliance_.assign(blocks, Matrix12::Zero());
  free_.resize(blocks);
  threads_.each(blocks, [&](std::size_t s) {
    const int n = slots_->size[s];
    const auto block = base.diagonal[s].topLeftCorner(n, n);
    compliance_[s].topLeftCorner(n, n) = block.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
    Vector12 left = force[s];
    left.head(n) -= block * guess[s].head(n);
    free_[s] = compliance_[s] * left;
  });
  cones_.assign(contacts.size(), {});
  rows_.assign(2 * contacts.size(), Matrix3x12::Zero());
  mobility_.assign(2 * contacts.size(), Matrix3x12::Zero());
  threads_.each(contacts.size(), [&](std::size_t i) {
    const LinearContact& c = contacts[i];
    cones_[i].friction = c.law == ContactLaw::Frictionless ? 0.0 : c.friction;
    if (mended_apart > 0.0) cones_[i].unmended = c.start;
    cones_[i].unmended[0] = std::min(cones_[i].unmended[0], mended_apart);
    cones_[i].offset = c.offset - cones_[i].unmended;
    cones_[i].unmoved = c.start + c.left_out - cones_[i].unmended;
    if (c.slot_a >= 0) cones_[i].offset += c.jacobian_a * guess[index(c.slot_a)];
    if (c.slot_b >= 0) cones_[i].offset += c.jacobian_b * guess[index(c.slot_b)];
    slots_->rigid() ? set_contact<6>(i) : set_contact<12>(i);
  });
}

template <int n>
void ConeProblem::set_contact(std::size_t i) {
  Cone& cone = cones_[i];
  const LinearContact& c = contacts_[i];
  const Vector3 share = shares(cone.friction);
  for (const int side : {0, 1}) {
    const int slot = side == 0 ? c.slot_a : c.slot_b;
    if (slot < 0) continue;
    const ContactJacobian& jacobian = side == 0 ? c.jacobian_a : c.jacobian_b;
    auto rows = rows_[2 * i + index(side)].leftCols<n>();
    auto mobility = mobility_[2 * i + index(side)].leftCols<n>();
    rows = share.asDiagonal() * jacobian.columns<n>();
    mobility.noalias() = rows * compliance_[index(slot)].topLeftCorner<n, n>();
    cone.delassus.noalias() += mobility * rows.transpose();
  }
  const double directions = cone.friction > 0.0 ? 3.0 : 1.0;
  if (!(cone.delassus.trace() > 0.0)) return;  // neither side can move
  cone.scale = std::sqrt(directions / cone.delassus.trace());
  for (const std::size_t side : {2 * i, 2 * i + 1}) {
    rows_[side] *= cone.scale;
    mobility_[side] *= cone.scale;
  }
  cone.delassus *= cone.scale * cone.scale;
  cone.offset.array() *= cone.scale * share.array();
  cone.unmended.array() *= cone.scale * share.array();
  cone.unmoved.array() *= cone.scale * share.array();
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(cone.delassus, Eigen::EigenvaluesOnly);
  cone.relaxation = 1.0 / eigen.eigenvalues()[2];
}

Vector3 ConeProblem::cone_force(std::size_t contact, const Vector3& force) const {
  const Cone& cone = cones_[contact];
  if (cone.friction == 0.0) return {force[0] / cone.scale, 0.0, 0.0};
  return force.cwiseQuotient(shares(cone.friction)) / cone.scale;
}

Vector3 ConeProblem::force(std::size_t contact, const Vector3& x) const {
  const Cone& cone = cones_[contact];
  return cone.scale * shares(cone.friction).cwiseProduct(x);
}

Vector3 ConeProblem::motion(std::size_t contact, const Vector3& y) const {
  const Cone& cone = cones_[contact];
  if (cone.friction == 0.0) return {y[0] / cone.scale, 0.0, 0.0};
  return y.cwiseQuotient(shares(cone.friction)) / cone.scale;
}

void ConeProblem::respond(std::span<const Vector3> x, std::span<Vector3> motion) {
  slots_->rigid() ? respond_in<6>(x, motion) : respond_in<12>(x, motion);
}

template <int n>
void ConeProblem::respond_in(std::span<const Vector3> x, std::span<Vector3> motion) {
  increment_ = free_;
  push_in<n>(mobility_, x, increment_);
  threads_.each(x.size(), [&](std::size_t i) {
    motion[i] = cones_[i].offset;
    add_motion<n>(i, motion[i]);
  });
}

/// Adds what the contacts push each slot with. Every range of slots goes through all contacts, so
/// that a slot sums them in their order.
template <int n>
void ConeProblem::push_in(std::span<const Matrix3x12> rows, std::span<const Vector3> x,
                          BlockVector& sum) const {
  threads_.ranges(sum.size(), [&](std::size_t first, std::size_t end) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      const auto push = [&](int slot, const Matrix3x12& row) {
        if (slot < static_cast<int>(first) || slot >= static_cast<int>(end)) return;
        sum[index(slot)].head<n>().noalias() += row.leftCols<n>().transpose() * x[i];
      };
      push(contacts_[i].slot_a, rows[2 * i]);
      push(contacts_[i].slot_b, rows[2 * i + 1]);
    }
  });
}

/// A D of `increment_`.
template <int n>
void ConeProblem::add_motion(std::size_t contact, Vector3& motion) const {
  const auto add = [&](int slot, const Matrix3x12& row) {
    if (slot >= 0) motion.noalias() += row.leftCols<n>() * increment_[index(slot)].head<n>();
  };
  add(contacts_[contact].slot_a, rows_[2 * contact]);
  add(contacts_[contact].slot_b, rows_[2 * contact + 1]);
}

void ConeProblem::sweep(std::span<Vector3> x) {
  const auto visit = [&](std::size_t i) {
    slots_->rigid() ? sweep_in<6>(i, x) : sweep_in<12>(i, x);
  };
  for (std::size_t i = 0; i < x.size(); ++i) visit(i);
  for (std::size_t i = x.size(); i-- > 0;) visit(i);
}

/// `increment_` follows x.
template <int n>
void ConeProblem::sweep_in(std::size_t contact, std::span<Vector3> x) {
  const LinearContact& c = contacts_[contact];
  const Cone& cone = cones_[contact];
  const Matrix3x12 &rows_a = rows_[2 * contact], &rows_b = rows_[2 * contact + 1];
  Vector3 motion = cone.offset;
  if (c.slot_a >= 0)
    motion.noalias() += rows_a.leftCols<n>() * increment_[index(c.slot_a)].head<n>();
  if (c.slot_b >= 0)
    motion.noalias() += rows_b.leftCols<n>() * increment_[index(c.slot_b)].head<n>();
  const Vector3 before = x[contact];
  if (before.isZero(0.0) && motion[0] >= 0.0) return;  // stays open
  for (int step = 0; step < kLocalSteps; ++step) {
    Vector3 corrected = motion + cone.delassus * (x[contact] - before);
    corrected[0] += corrected.tail<2>().norm();
    x[contact] = project_on_cone(x[contact] - cone.relaxation * corrected);
  }
  const Vector3 change = x[contact] - before;
  if (change.isZero(0.0)) return;
  const auto push = [&](int slot, const Matrix3x12& mobility) {
    if (slot < 0) return;
    increment_[index(slot)].head<n>().noalias() += mobility.leftCols<n>().transpose() * change;
  };
  push(c.slot_a, mobility_[2 * contact]);
  push(c.slot_b, mobility_[2 * contact + 1]);
}

bool ConeProblem::factorize(std::span<const Matrix3> tangents, Tangents kind) {
  system_.diagonal = base_->diagonal;
  system_.pairs = base_->pairs;
  system_.symmetric = kind == Tangents::Symmetric;
  const std::size_t pairs = base_->pairs.size();
  system_.off_diagonal.resize(pairs, base_->diagonal.width());
  system_.mirrored.resize(system_.symmetric ? 0 : pairs, base_->diagonal.width());
  system_.off_diagonal.set_zero();
  system_.mirrored.set_zero();
  slots_->rigid() ? assemble_in<6>(tangents) : assemble_in<12>(tangents);
  return solver_.factorize(system_);
}

/// Every range of slots goes through all contacts; a pair is the range's of its earlier slot.
template <int n>
void ConeProblem::assemble_in(std::span<const Matrix3> tangents) {
  using Rows = Eigen::Matrix<double, 3, n>;
  const auto add = [](const Rows& left, const Rows& right, Part<n> block) {
    block.noalias() += left.transpose() * right;
  };
  threads_.ranges(free_.size(), [&](std::size_t first, std::size_t end) {
    const auto owns = [&](int slot) {
      return slot >= static_cast<int>(first) && slot < static_cast<int>(end);
    };
    for (std::size_t i = 0; i < tangents.size(); ++i) {
      const LinearContact& c = contacts_[i];
      const bool owns_a = owns(c.slot_a), owns_b = owns(c.slot_b);
      if (!(owns_a || owns_b) || tangents[i].isZero(0.0)) continue;  // another range's, or open
      const Rows a = rows_[2 * i].leftCols<n>(), b = rows_[2 * i + 1].leftCols<n>();
      const Rows stiff_a = tangents[i] * a, stiff_b = tangents[i] * b;
      if (owns_a) add(a, stiff_a, system_.diagonal.part<n>(index(c.slot_a)));
      if (owns_b) add(b, stiff_b, system_.diagonal.part<n>(index(c.slot_b)));
      if (c.pair < 0) continue;
      const bool ascending = c.slot_a < c.slot_b;
      if (!(ascending ? owns_a : owns_b)) continue;
      const Part<n> upper = system_.off_diagonal.part<n>(index(c.pair));
      ascending ? add(a, stiff_b, upper) : add(b, stiff_a, upper);
      if (system_.symmetric) continue;
      const Part<n> lower = system_.mirrored.part<n>(index(c.pair));
      ascending ? add(b, stiff_a, lower) : add(a, stiff_b, lower);
    }
  });
}

void ConeProblem::solve(std::span<const Vector3> right, std::span<Vector3> motion) {
  slots_->rigid() ? solve_in<6>(right, motion) : solve_in<12>(right, motion);
}

template <int n>
void ConeProblem::solve_in(std::span<const Vector3> right, std::span<Vector3> motion) {
  right_.assign(free_.size(), Vector12::Zero());
  push_in<n>(rows_, right, right_);
  increment_.resize(right_.size());
  solver_.solve(right_, increment_);
  threads_.each(motion.size(), [&](std::size_t i) {
    motion[i].setZero();
    add_motion<n>(i, motion[i]);
  });
}

}  // namespace quoin::solver
