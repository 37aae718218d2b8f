#pragma once
/// One contact of a linearised step: what contact_jacobian makes and open_close works on.

#include <memory>
#include <quoin/solver/state.hpp>

#include "base/index.hpp"
#include "block/block_system.hpp"

namespace quoin::solver {

enum class ContactLaw : std::uint8_t {
  Coulomb,
  Frictionless,
  Stuck,      ///< what bonds or clings cannot slide
  Bilateral,  ///< a held point: all three components vanish
  Tie         ///< f_n of a tie, at most `cohesion`: bonded, of either sign; see tie.hpp
};

/// 3×6, or nothing where no block deforms; copied with what it holds.
class StrainColumns {
 public:
  StrainColumns() = default;
  StrainColumns(const StrainColumns& other)
      : matrix_(other ? std::make_unique<Matrix3x6>(*other) : nullptr) {}
  StrainColumns(StrainColumns&& other) noexcept = default;
  StrainColumns& operator=(StrainColumns other) noexcept {
    matrix_.swap(other.matrix_);
    return *this;
  }
  explicit operator bool() const { return matrix_ != nullptr; }
  const Matrix3x6& operator*() const { return *matrix_; }
  const Matrix3x6* operator->() const { return matrix_.get(); }
  Matrix3x6& make() {
    if (matrix_ == nullptr) matrix_ = std::make_unique<Matrix3x6>(Matrix3x6::Zero());
    return *matrix_;
  }

 private:
  std::unique_ptr<Matrix3x6> matrix_;
};

/// Rows of d by the increment of one block.
struct ContactJacobian {
  Matrix3x6 rigid = Matrix3x6::Zero();  ///< by (u | theta)
  StrainColumns strain;                 ///< by e

  Vector3 operator*(const Vector12& increment) const {
    Vector3 d = rigid * increment.head<6>();
    if (strain) d += *strain * increment.tail<6>();
    return d;
  }
  /// |J| |D|: the sum of magnitudes that d is rounded by, m.
  Vector3 magnitudes(const Vector12& increment) const {
    Vector3 size = rigid.cwiseAbs() * increment.head<6>().cwiseAbs();
    if (strain) size += strain->cwiseAbs() * increment.tail<6>().cwiseAbs();
    return size;
  }
  /// What a contact force pushes the block with.
  Vector12 push(const Vector3& force) const {
    Vector12 result = Vector12::Zero();
    result.head<6>() = rigid.transpose() * force;
    if (strain) result.tail<6>() = strain->transpose() * force;
    return result;
  }
  /// The first row times an increment.
  double normal(const Vector12& increment) const {
    const double d = rigid.row(0).dot(increment.head<6>());
    return strain ? d + strain->row(0).dot(increment.tail<6>()) : d;
  }
  bool deforms() const { return strain && (strain->array() != 0.0).any(); }
  /// All columns; `n`: 6 or 12.
  template <int n>
  Eigen::Matrix<double, 3, n> columns() const {
    if constexpr (n == 6) {
      return rigid;
    } else {
      Eigen::Matrix<double, 3, n> all = Eigen::Matrix<double, 3, n>::Zero();
      all.template leftCols<6>() = rigid;
      if (strain) all.template rightCols<6>() = *strain;
      return all;
    }
  }
  void set(const Matrix3x12& all, bool deforms) {
    rigid = all.leftCols<6>();
    if (deforms || strain) strain.make() = all.rightCols<6>();
  }
};

/// What a contact after linearisation holds, but for its Jacobians. Rows of d: gap beyond the
/// joint's opening, two slips.
struct ContactTerms {
  int slot_a = -1, slot_b = -1;  ///< -1: that side has no unknowns
  int pair = -1;  ///< off-diagonal block of (slot_a, slot_b); below 0: none, another for each
                  ///< block without unknowns
  ContactLaw law = ContactLaw::Coulomb;
  bool compliant = false;   ///< a spring: its multiplier stays zero
  bool bonded = false;      ///< bears tension without limit: judged when the step is solved
  bool clings = false;      ///< bears shear though nothing presses it: judged likewise
  bool was_bonded = false;  ///< at the start of the step
  bool was_closed = false;  ///< likewise
  bool hits = false;        ///< closes faster than what the step does not resolve
  ContactMode assumed = ContactMode::Open;  ///< what the first linear solve takes for granted
  ContactMode mode = ContactMode::Open;     ///< result
  Vector3 offset = Vector3::Zero();
  double friction = 0.0;          ///< tan of the friction angle
  double cohesion = 0.0;          ///< N
  double normal_stiffness = 0.0;  ///< N/m: spring, or augmentation
  double shear_stiffness = 0.0;
  double normal_spring = 0.0;  ///< N/m, of the joint; 0: rigid
  double shear_spring = 0.0;
  double slip = 0.0;      ///< in this step, by the last solution, m
  double dilation = 0.0;  ///< further opening in this step that goes with it, m
  // Where opening goes with the slip of the solution:
  double dilation_slope = 0.0;  ///< opening per slip, for so much more slip:
  double dilating_slip = 0.0;   ///< m
  Vector3 start =
      Vector3::Zero();    ///< d at the start of the step: gap and stretch of the anchors, m
  double rounding = 0.0;  ///< m: a gap or slip this small is zero for all that doubles can tell
  Vector3 left_out = Vector3::Zero();  ///< m: what d has beside the motion of the step and `start`
  double turn_correction = 0.0;        ///< m: the turn of crossed edges' normal beyond second order
  double closing_share = 0.0;  ///< of the step that had passed when it closed; 0: closed all along
  Vector3 multiplier = Vector3::Zero();  ///< N, what the last iteration took as known

  Vector3 guess = Vector3::Zero();     ///< d of the first guess, m
  Vector3 relative = Vector3::Zero();  ///< result: d, m
  Vector3 force = Vector3::Zero();     ///< result: f, N
};

/// One contact after linearisation.
struct LinearContact : ContactTerms {
  ContactJacobian jacobian_a, jacobian_b;

  /// Of its first block that has unknowns.
  int first_slot() const { return slot_a >= 0 ? slot_a : slot_b; }
  /// Calls `visit` with the slot and the Jacobian of each of its blocks that has unknowns.
  template <class Visit>
  void each_side(const Visit& visit) const {
    if (slot_a >= 0) visit(index(slot_a), jacobian_a);
    if (slot_b >= 0) visit(index(slot_b), jacobian_b);
  }
  /// Adds what this force pushes the blocks with to `sum`, by slot.
  void push(const Vector3& force_on_b, BlockVector& sum) const {
    each_side([&](std::size_t s, const ContactJacobian& j) { sum[s] += j.push(force_on_b); });
  }
};

}  // namespace quoin::solver
