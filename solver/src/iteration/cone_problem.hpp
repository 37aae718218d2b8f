#pragma once
/// One linearised contact problem, its contacts softened.
///
///   K D = F + sum Aᵀ x,   u = A D + c + eps (x - bar),   x = P(x - y),
///
/// P the projection on the forces that the contact can bear, y as corrected() has it (cone.hpp).
/// With mu = 1 where Coulomb's law is not all, x = (f_n, f_t / mu) / s and u = (d_n, mu d_t) s of
/// the contact's force f and motion d; s makes the mean eigenvalue of the contact's own Delassus
/// block one, so that eps is a share of it and x, y have one unit, sqrt(J).

#include <span>
#include <vector>

#include "base/threads.hpp"
#include "contact/linear_contact.hpp"
#include "iteration/cone.hpp"
#include "linear/linear_solver.hpp"

namespace quoin::solver {

/// Of the contacts, in the matrix of a step of Newton's method; symmetric ones are positive
/// semidefinite.
enum class Tangents { Symmetric, General };

class ConeProblem {
 public:
  explicit ConeProblem(const Slots& slots, StepWatch* watch)
      : slots_(&slots), solver_(slots, watch) {}

  /// From here on; passes of Gauss–Seidel take one.
  void use(const Threads& threads) {
    threads_ = threads;
    solver_.use(threads);
  }
  const Threads& threads() const { return threads_; }

  /// Rigid and without cohesion.
  static bool follows_coulomb(const LinearContact& contact);
  /// Whether none is a spring.
  static bool suits(std::span<const LinearContact> contacts);

  /// The unknown is the change against `guess`, so that forces and motions are rounded like it.
  /// `mended_apart`: see OpenCloseOptions.
  /// All arguments must outlive the use of this object.
  void set(const BlockSystem& base, const BlockVector& force,
           std::span<const LinearContact> contacts, const BlockVector& guess,
           double mended_apart = 0.0);

  std::size_t count() const { return cones_.size(); }
  std::span<const Admissible> admissible() const { return admissible_; }  ///< by contact
  Vector3 cone_force(std::size_t contact, const Vector3& force) const;    ///< x of f
  Vector3 force(std::size_t contact, const Vector3& x) const;             ///< f of x
  Vector3 motion(std::size_t contact, const Vector3& y) const;            ///< d of A D + c
  /// What c leaves out of the gap and the stretch that the step starts with.
  const Vector3& unmended(std::size_t contact) const { return cones_[contact].unmended; }

  /// What A D + c has beside the motion of the step.
  const Vector3& unmoved(std::size_t contact) const { return cones_[contact].unmoved; }

  /// A D + c with D the answer to the forces x.
  void respond(std::span<const Vector3> x, std::span<Vector3> motion);
  const BlockVector& increment() const { return increment_; }  ///< D of the last respond()

  /// Passes of Gauss–Seidel over the hard contacts, there and back.   [Jean 1999] Bonds keep
  /// theirs: swept one after the other the first ones of a joint would bear most, and break.
  void sweep(int passes, std::span<Vector3> x);

  /// K + sum Aᵀ T A, to be solved with. False when it is singular to working accuracy, or symmetric
  /// and not positive definite.
  bool factorize(std::span<const Matrix3> tangents, Tangents kind);
  /// A D of (K + sum Aᵀ T A) D = sum Aᵀ right. `motion` may be `right`.
  void solve(std::span<const Vector3> right, std::span<Vector3> motion);
  double condition_estimate() const { return solver_.condition_estimate(); }

 private:
  struct Cone {
    double scale = 1.0;
    double shear = 0.0;                ///< mu of the cone, else 1, or 0 without friction
    Vector3 offset = Vector3::Zero();  ///< c
    Vector3 unmended = Vector3::Zero(), unmoved = Vector3::Zero();
    Matrix3 delassus = Matrix3::Zero();  ///< of the contact alone
    double relaxation = 0.0;             ///< 1 / its largest eigenvalue; 0: not yet known
  };
  void set_block(std::size_t s, bool same, const Vector12& guess);
  template <int n>
  void set_contact(std::size_t i);
  template <int n>
  void push_in(const std::vector<double>& rows, std::span<const Vector3> x, BlockVector& sum) const;
  template <int n>
  void add_motion(std::size_t contact, Vector3& motion) const;
  template <int n>
  void sweep_in(std::size_t contact, std::span<Vector3> x);

  const Slots* slots_;
  Threads threads_;
  LinearSolver solver_;
  const BlockSystem* base_ = nullptr;
  std::span<const LinearContact> contacts_;
  BlockVector free_;                  ///< the answer to no contact forces, by slot
  std::vector<Matrix12> compliance_;  ///< K⁻¹, by slot
  SquareBlocks inverted_;             ///< the K that it is of
  std::vector<double> rows_;          ///< A, by contact, both sides: 3×2n by rows
  std::vector<double> mobility_;      ///< A K⁻¹, likewise
  std::vector<Cone> cones_;
  std::vector<Admissible> admissible_;
  BlockVector increment_, right_;
  BlockSystem system_;
};

}  // namespace quoin::solver
