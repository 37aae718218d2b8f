#pragma once
/// Forces of hard contacts with Coulomb friction from nothing: a primal-dual interior point method.
///
///   y = A D + c + s n,   x and y in the cone,   x o y -> 0,
///
/// s the slip |u_t| of an earlier iterate (cone_problem.hpp has the rest). With s fixed that is the
/// convex second-order cone program of [Acary, Cadoux, Lemaréchal & Malick 2011], whose matrices
/// are symmetric whatever slides; here s follows the iterates once these are near, and where steps
/// are long its change is part of them (unsymmetric). Held contacts have y = 0. Directions are
/// Nesterov and Todd's with Mehrotra's predictor and corrector [Vandenberghe 2010]. Iterates stay
/// inside the cones, so that redundant contacts are left with forces away from their rims.

#include "iteration/open_close.hpp"
#include "iteration/proximal_newton.hpp"

namespace quoin::solver {

class InteriorPoint {
 public:
  explicit InteriorPoint(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), problem_(slots, watch) {}

  /// From the next solve() on.
  void use(const Threads& threads) { problem_.use(threads); }

  /// Coulomb's law without cohesion, or held without limit.
  static bool suits(const LinearContact& contact);

  /// As OpenClose::solve, for contacts that suit; converged: near enough to begin another iteration
  /// with. Where it is not nothing is changed.
  OpenCloseResult solve(const BlockSystem& base, const BlockVector& force,
                        std::span<LinearContact> contacts, int most, BlockVector& increment);

 private:
  /// Of a contact, W with W y = W⁻¹ x = lambda.
  struct Scaling {
    Matrix3 scale, unscale;
    Vector3 lambda;
  };
  enum class Part { Predictor, Corrector, Centre };
  struct Residuals {
    double frozen;  ///< natural map, with s as it is
    double real;    ///< with the iterate's own slip
  };
  void begin();
  IterationCount iterate(int most);
  Residuals residuals() const;
  double duality(double step) const;
  void set_scalings();
  double direction(Part part, double mean);
  Vector3 pressed(std::size_t contact) const;
  void follow_slip(bool wanted);
  bool held(std::size_t contact) const;
  ContactMode mode(std::size_t contact) const;

  const Slots* slots_;
  ConeProblem problem_;
  std::vector<Vector3> x_, y_, u_, dx_, dy_, right_, motion_, best_, coupled_;
  std::vector<double> slip_;  ///< s
  std::vector<Scaling> scalings_;
  std::vector<Matrix3> tangents_;          ///< W²
  std::vector<Matrix3> tangents_of_slip_;  ///< with the slope of s
};

}  // namespace quoin::solver
