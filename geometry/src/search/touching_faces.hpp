#pragma once
/// Solids that touch with two faces which lie on each other only within some noise: less than the
/// size of the faces by far, more than rounding. Internal.

#include "certify/candidate.hpp"

namespace quoin::geometry {

/// What two faces have to share. Where it is narrow their edges may come as near within rounding,
/// and touching_edges has to be asked first.
enum class SharedWidth { Any, Wide };

/// The answer carried by the corner of what the two faces that look along `across` share where they
/// come nearest, if that is proved to be the best. See geometry/README.md, "Touching faces".
bool touching_faces(const Solid& p, const Solid& q, const Lengths& length, const Vector3& across,
                    SharedWidth least, Optimum& optimum);

/// What a feature puts into the sets of a plane: its vertices, ascending, and its label.
void take_feature(const Solid& solid, const Feature& feature, VertexSet& set, int& face);

/// A settled plane that is known to be the best. Where no other vertex comes near it, last step's
/// features lead to it without a search: it is then described as they do.
bool take_settled(const Solid& p, const Solid& q, const Lengths& length, Optimum& optimum);

}  // namespace quoin::geometry
