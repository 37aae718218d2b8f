#pragma once
/// Proofs on both sides of a limit.

#include <functional>
#include <limits>
#include <memory>

#include "limit/varied_scene.hpp"

namespace quoin::limit_analysis {

/// What is known: where it stands, where it falls.
struct Limit {
  std::unique_ptr<Trial> stands{}, falls{};
  std::vector<Vector6> strict{};  ///< a mechanism far from the limit: it opens contacts widely
  double convex = std::numeric_limits<double>::quiet_NaN();  ///< of a load: the problem's answer
  std::string why{};  ///< why the two are farther apart than the tolerance; empty: they are not
  bool everywhere = false;  ///< of a thrust: it stands at the end of what is tried
};

/// An undecided trial is proved to fall, where it can be, with help of the velocities of a
/// mechanism far from the limit, or, if they are none, of a motion that opens contacts, which they
/// then are.
void decide(Trial& trial, std::vector<Vector6>& strict);

/// `tolerance`: how far apart the two may be, relative.
Limit prove(VariedScene& scenes, double tolerance);

/// Stands with joints that break where they reach their tension: the farther one of forces that all
/// bear while they are whole, and that all bear once they are broken. None: neither is proved.
std::unique_ptr<Trial> stands_brittle(VariedScene& scenes, double tolerance);

/// The same of any problem by value: `at` solves it, `largest` where the factor is a variable.
Limit prove_factor(const std::function<Trial(double)>& at, const Equilibrium& largest, double from,
                   double to, double tolerance);
Limit prove_between(const std::function<Trial(double)>& at, double from, double to,
                    double tolerance);

}  // namespace quoin::limit_analysis
