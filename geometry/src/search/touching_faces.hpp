#pragma once
/// Solids that touch with two faces which lie on each other only within some noise: less than the
/// size of the faces by far, more than rounding. Internal.

#include "certify/candidate.hpp"

namespace quoin::geometry {

/// The answer carried by the corner of what the two faces that look along `across` share where they
/// come nearest, if that is proved to be the best. See geometry/README.md, "Touching faces".
bool touching_faces(const Solid& p, const Solid& q, const Lengths& length, const Vector3& across,
                    Optimum& optimum);

}  // namespace quoin::geometry
