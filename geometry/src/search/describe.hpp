#pragma once
/// An answer in full from the plane that is proved to be it: witnesses, features, certificate,
/// hint. Internal.

#include "certify/candidate.hpp"

namespace quoin::geometry {

/// Fills all of an answer but the number of iterations, in the names of P and Q.
void describe(const Solid& p, const Solid& q, Optimum& optimum, const Lengths& length,
              NearestFeatures& answer);

}  // namespace quoin::geometry
