#include "iteration/cone_problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/index.hpp"
#include "linear/pair_stiffness.hpp"
#include "linear/small_matrices.hpp"

namespace quoin::solver {
namespace {

constexpr int kLocalSteps = 3;  // projections a contact in each pass

Admissible admissible_by(const LinearContact& c) {
  if (ConeProblem::follows_coulomb(c)) return {};
  Admissible forces{.pulls = c.bonded || c.law == ContactLaw::Bilateral};
  if (c.law == ContactLaw::Coulomb) {
    forces.shear = Admissible::Shear::Disc;
    forces.friction = c.friction;
    forces.cohesion = c.cohesion;
  } else {
    forces.shear = Admissible::Shear::All;
  }
  return forces;
}

/// 0: it bears none.
double shear_share(const LinearContact& c) {
  if (c.law == ContactLaw::Frictionless) return 0.0;
  return ConeProblem::follows_coulomb(c) ? c.friction : 1.0;
}

Vector3 shares(double shear) { return {1.0, shear, shear}; }

template <int n>
Eigen::Map<const ContactRows<n>> rows_of(const std::vector<double>& rows, std::size_t contact) {
  return Eigen::Map<const ContactRows<n>>(rows.data() + contact * 6 * n);
}

/// `rows` from column `first` on.
template <int n>
void push(const Eigen::Map<const ContactRows<n>>& rows, int first, const Vector3& x,
          Vector12& sum) {
  const double x0 = x[0], x1 = x[1], x2 = x[2];
  for (int k = 0; k < n; ++k)
    sum[k] += x0 * rows(0, first + k) + x1 * rows(1, first + k) + x2 * rows(2, first + k);
}

/// Projections of one contact's force, whose motion is u + w (x - before). In numbers: gcc 12 has
/// vectors of three in memory here, and waits for each to be written.
Vector3 local_steps(const Admissible& forces, const Matrix3& w, double relaxation, const Vector3& u,
                    const Vector3& before) {
  const bool cone = forces.shear == Admissible::Shear::Cone;
  double x0 = before[0], x1 = before[1], x2 = before[2];
  for (int step = 0; step < kLocalSteps; ++step) {
    const double d0 = x0 - before[0], d1 = x1 - before[1], d2 = x2 - before[2];
    const double u0 = u[0] + (w(0, 0) * d0 + w(0, 1) * d1 + w(0, 2) * d2);
    const double u1 = u[1] + (w(1, 0) * d0 + w(1, 1) * d1 + w(1, 2) * d2);
    const double u2 = u[2] + (w(2, 0) * d0 + (w(2, 1) * d1 + w(2, 2) * d2));
    const double slip = cone ? std::sqrt(u1 * u1 + u2 * u2) : 0.0;
    x0 -= relaxation * (u0 + slip);
    x1 -= relaxation * u1;
    x2 -= relaxation * u2;
    const double tangential = std::sqrt(x1 * x1 + x2 * x2);
    if (!cone) {
      const Vector3 force = project_by_parts(forces, {x0, x1, x2});
      x0 = force[0], x1 = force[1], x2 = force[2];
    } else if (x0 < tangential) {
      x0 = std::max(0.5 * (x0 + tangential), 0.0);
      const double along = x0 > 0.0 ? x0 / tangential : 0.0;
      x1 *= along;
      x2 *= along;
    }
  }
  return {x0, x1, x2};
}

}  // namespace

bool ConeProblem::follows_coulomb(const LinearContact& c) {
  const bool coulomb = c.law == ContactLaw::Coulomb || c.law == ContactLaw::Frictionless;
  return coulomb && !c.compliant && !c.bonded && c.cohesion == 0.0;
}

bool ConeProblem::suits(std::span<const LinearContact> contacts) {
  return std::ranges::none_of(contacts, &LinearContact::compliant);
}

void ConeProblem::set(const BlockSystem& base, const BlockVector& force,
                      std::span<const LinearContact> contacts, const BlockVector& guess,
                      double mended_apart) {
  base_ = &base;
  contacts_ = contacts;
  const std::size_t blocks = force.size();
  const bool known = inverted_.size() == blocks && inverted_.width() == base.diagonal.width();
  if (!known) compliance_.assign(blocks, Matrix12::Zero());
  free_ = force;
  threads_.each(blocks, [&](std::size_t s) {
    const bool same = known && std::as_const(inverted_)[s] == base.diagonal[s];
    set_block(s, same, guess[s]);
  });
  inverted_ = base.diagonal;
  cones_.assign(contacts.size(), {});
  admissible_.resize(contacts.size());
  rows_.assign(6 * index(slots_->width()) * contacts.size(), 0.0);
  mobility_.assign(rows_.size(), 0.0);
  threads_.each(contacts.size(), [&](std::size_t i) {
    const LinearContact& c = contacts[i];
    admissible_[i] = admissible_by(c);
    cones_[i].shear = shear_share(c);
    if (mended_apart > 0.0) cones_[i].unmended = c.start;
    if (!admissible_[i].pulls)
      cones_[i].unmended[0] = std::min(cones_[i].unmended[0], mended_apart);
    cones_[i].offset = c.offset - cones_[i].unmended;
    cones_[i].unmoved = c.start + c.left_out - cones_[i].unmended;
    c.each_side([&](std::size_t s, const auto& j) { cones_[i].offset += j * guess[s]; });
    slots_->rigid() ? set_contact<6>(i) : set_contact<12>(i);
  });
}

/// `same`: its K is that of the last problem, as in the next linearisation.
void ConeProblem::set_block(std::size_t s, bool same, const Vector12& guess) {
  const int n = slots_->size[s];
  if (!same)
    invert_symmetric(base_->diagonal[s].topLeftCorner(n, n), compliance_[s].topLeftCorner(n, n));
  free_[s] = compliance_[s] * (free_[s] - base_->diagonal.times(s, guess));
}

template <int n>
void ConeProblem::set_contact(std::size_t i) {
  Cone& cone = cones_[i];
  const LinearContact& c = contacts_[i];
  const Vector3 share = shares(cone.shear);
  Eigen::Map<ContactRows<n>> rows(rows_.data() + i * 6 * n), mobility(mobility_.data() + i * 6 * n);
  for (const int side : {0, 1}) {
    const int slot = side == 0 ? c.slot_a : c.slot_b;
    if (slot < 0) continue;
    const ContactJacobian& jacobian = side == 0 ? c.jacobian_a : c.jacobian_b;
    auto own = rows.template middleCols<n>(side * n);
    auto moved = mobility.template middleCols<n>(side * n);
    own = share.asDiagonal() * jacobian.columns<n>();
    moved = own.lazyProduct(compliance_[index(slot)].topLeftCorner<n, n>());
    cone.delassus += moved.lazyProduct(own.transpose());
  }
  const double directions = cone.shear > 0.0 ? 3.0 : 1.0;
  if (!(cone.delassus.trace() > 0.0)) return;  // neither side can move
  cone.scale = std::sqrt(directions / cone.delassus.trace());
  rows *= cone.scale;
  mobility *= cone.scale;
  cone.delassus *= cone.scale * cone.scale;
  cone.offset.array() *= cone.scale * share.array();
  cone.unmended.array() *= cone.scale * share.array();
  admissible_[i].cohesion /= cone.scale;
  cone.unmoved.array() *= cone.scale * share.array();
}

Vector3 ConeProblem::cone_force(std::size_t contact, const Vector3& force) const {
  const Cone& cone = cones_[contact];
  if (cone.shear == 0.0) return {force[0] / cone.scale, 0.0, 0.0};
  return force.cwiseQuotient(shares(cone.shear)) / cone.scale;
}

Vector3 ConeProblem::force(std::size_t contact, const Vector3& x) const {
  const Cone& cone = cones_[contact];
  return cone.scale * shares(cone.shear).cwiseProduct(x);
}

Vector3 ConeProblem::motion(std::size_t contact, const Vector3& y) const {
  const Cone& cone = cones_[contact];
  if (cone.shear == 0.0) return {y[0] / cone.scale, 0.0, 0.0};
  return y.cwiseQuotient(shares(cone.shear)) / cone.scale;
}

void ConeProblem::respond(std::span<const Vector3> x, std::span<Vector3> motion) {
  at_width(*slots_, [&](auto width) {
    constexpr int n = width;
    increment_ = free_;
    push_in<n>(mobility_, x, increment_);
    threads_.each(x.size(), [&](std::size_t i) {
      motion[i] = cones_[i].offset;
      add_motion<n>(i, motion[i]);
    });
  });
}

/// Adds what the contacts push each slot with. Every range of slots goes through all contacts, so
/// that a slot sums them in their order.
template <int n>
void ConeProblem::push_in(const std::vector<double>& rows, std::span<const Vector3> x,
                          BlockVector& sum) const {
  threads_.ranges(sum.size(), [&](std::size_t first, std::size_t end) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      const auto owns = [&](int slot) {
        return slot >= static_cast<int>(first) && slot < static_cast<int>(end);
      };
      const int a = contacts_[i].slot_a, b = contacts_[i].slot_b;
      if (owns(a)) push<n>(rows_of<n>(rows, i), 0, x[i], sum[index(a)]);
      if (owns(b)) push<n>(rows_of<n>(rows, i), n, x[i], sum[index(b)]);
    }
  });
}

/// A D of `increment_`.
template <int n>
void ConeProblem::add_motion(std::size_t contact, Vector3& motion) const {
  const Eigen::Map<const ContactRows<n>> rows = rows_of<n>(rows_, contact);
  const auto add = [&](int slot, int first) {
    if (slot < 0) return;
    for (int k = 0; k < 3; ++k)
      motion[k] += rows.row(k).template segment<n>(first).dot(increment_[index(slot)].head<n>());
  };
  add(contacts_[contact].slot_a, 0);
  add(contacts_[contact].slot_b, n);
}

void ConeProblem::sweep(int passes, std::span<Vector3> x) {
  const auto visit = [&](std::size_t i) {
    if (admissible_[i].pulls || !(cones_[i].delassus.trace() > 0.0)) return;
    slots_->rigid() ? sweep_in<6>(i, x) : sweep_in<12>(i, x);
  };
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t i = 0; i < x.size(); ++i) visit(i);
    for (std::size_t i = x.size(); i-- > 0;) visit(i);
  }
}

/// `increment_` follows x.
template <int n>
void ConeProblem::sweep_in(std::size_t contact, std::span<Vector3> x) {
  const LinearContact& c = contacts_[contact];
  Cone& cone = cones_[contact];
  Vector3 motion = cone.offset;
  add_motion<n>(contact, motion);
  const Vector3 before = x[contact];
  const bool opens = admissible_[contact].shear == Admissible::Shear::Cone;
  if (opens && before.isZero(0.0) && motion[0] >= 0.0) return;  // stays open
  if (cone.relaxation == 0.0) cone.relaxation = 1.0 / eigenvalues(cone.delassus)[2];
  x[contact] = local_steps(admissible_[contact], cone.delassus, cone.relaxation, motion, before);
  const Vector3 change = x[contact] - before;
  if (change.isZero(0.0)) return;
  const Eigen::Map<const ContactRows<n>> mobility = rows_of<n>(mobility_, contact);
  if (c.slot_a >= 0) push<n>(mobility, 0, change, increment_[index(c.slot_a)]);
  if (c.slot_b >= 0) push<n>(mobility, n, change, increment_[index(c.slot_b)]);
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
  // Every range of slots goes through all contacts, so that a block sums them in their order.
  at_width(*slots_, [&](auto width) {
    constexpr int n = width;
    threads_.ranges(free_.size(), [&](std::size_t first, std::size_t end) {
      PairStiffness<n> stiffness(system_, first, end);
      for (std::size_t i = 0; i < tangents.size(); ++i) {
        if (tangents[i].isZero(0.0) || !stiffness.next(contacts_[i])) continue;
        stiffness.add(rows_of<n>(rows_, i), tangents[i]);
      }
      stiffness.flush();
    });
  });
  return solver_.factorize(system_);
}

void ConeProblem::solve(std::span<const Vector3> right, std::span<Vector3> motion) {
  at_width(*slots_, [&](auto width) {
    constexpr int n = width;
    right_.assign(free_.size(), Vector12::Zero());
    push_in<n>(rows_, right, right_);
    increment_.resize(right_.size());
    solver_.solve(right_, increment_);
    threads_.each(motion.size(), [&](std::size_t i) {
      motion[i].setZero();
      add_motion<n>(i, motion[i]);
    });
  });
}

}  // namespace quoin::solver
