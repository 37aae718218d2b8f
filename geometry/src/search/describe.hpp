#pragma once
/// An answer in full from the plane that is proved to be it: witnesses, features, certificate,
/// hint. Internal.

#include "certify/candidate.hpp"

namespace quoin::geometry {

/// Fills all but the status and the number of iterations of an answer whose normal and gap stand.
void describe(const Solid& p, const Solid& q, Optimum& optimum, const Lengths& length,
              NearestFeatures& answer);

}  // namespace quoin::geometry
