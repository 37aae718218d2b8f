#pragma once
/// Newton's method on the smoothed projection of softened contacts.

#include "moving/soft_contacts.hpp"

namespace quoin::solver {

/// Solves x = P_e(x - y) for a smoothing e that falls with the residual, superlinearly at the end.
/// It needs a start that is near; [Fukushima, Luo & Tseng 2002; Hayashi, Yamashita & Fukushima
/// 2005].
class SmoothedNewton {
 public:
  IterationCount solve(ConeProblem& problem, const Softness& softness, const IterationLimit& limit,
                       std::vector<Vector3>& x);

 private:
  bool find_step(ConeProblem& problem, const Softness& softness, std::span<const Vector3> x,
                 double smoothing);
  double search(const Softness& softness, std::vector<Vector3>& x, double smoothing);

  std::vector<Vector3> u_, rest_, right_, motion_, step_, trial_x_, trial_u_;
  std::vector<Matrix3> tangents_, inverse_;
};

}  // namespace quoin::solver
