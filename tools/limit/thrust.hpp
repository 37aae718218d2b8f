#pragma once
/// Least and greatest thrust on a support, and the geometric factor of safety.

#include "limit/proofs.hpp"

namespace quoin::limit_analysis {

struct Thrust {
  Vector3 direction = Vector3::UnitX();  ///< unit, from the structure towards the support
  /// N along `direction`; values of `stands` are admissible, no larger or smaller one than that of
  /// `falls` is. Of the least one, values are of its opposite sign.
  Limit least{}, greatest{};
  /// Contact areas shrunk about their middles: the smallest share that stands, the largest that
  /// falls. The inverse is the geometric factor of safety [Heyman 1982].
  Limit shrink{};
};

/// On a fixed block, which the problem lets slide along `direction` alone, horizontal
/// from the blocks that move to the support. Throws std::invalid_argument for a block
/// that is not fixed or is not there.
Thrust thrust_on(const Scene& scene, const std::string& support, double tolerance);

}  // namespace quoin::limit_analysis
