#pragma once
/// Solids that touch with two faces which lie on each other only within some noise: less than the
/// size of the faces by far, more than rounding. Internal.

#include <span>

#include "certify/candidate.hpp"

namespace quoin::geometry {

/// Of some faces of P the one that parts it most from Q, and by how much, m; -1: none looks at Q.
struct PartingFace {
  int face = -1;
  double gap = -kInfinity;
};
PartingFace parting_face(const Solid& p, const Solid& q, std::span<const int> faces);

/// The plane of the features over which two faces that look along `across` come nearest, if it is
/// proved to be the best: by itself, or by how near the faces lie to each other. See
/// geometry/README.md, "Touching faces".
bool touching_faces(const Solid& p, const Solid& q, const Lengths& length, const Vector3& across,
                    Optimum& optimum);

/// What a feature puts into the sets of a plane: its vertices, ascending, and its label.
void take_feature(const Solid& solid, const Feature& feature, VertexSet& set, int& face);

}  // namespace quoin::geometry
