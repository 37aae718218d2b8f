#pragma once
/// Solids that touch with two faces which lie on each other only within some noise: less than the
/// size of the faces by far, more than rounding. Internal.

#include <span>

#include "certify/candidate.hpp"
#include "certify/canonical_order.hpp"

namespace quoin::geometry {

/// Two faces that look at each other along a direction, and the corners of what they share as seen
/// along P's normal: places where both solids have a point.
struct FacingFaces {
  int p = -1, q = -1;
  Vector3 normal = Vector3::UnitX();  // of P's face
  bool flat = false;  // all corners of the faces lie in their planes: there is something shared
  SharedCorners corners;
  std::size_t lowest = 0;   // where the faces come nearest
  double gap = kInfinity;   // there, m
  double next = kInfinity;  // at the next lowest corner, m
  double high = 0.0;        // greatest difference of heights of the two faces, m
  double span = 0.0;        // twice the area of a wide triangle of corners, m2

  /// Those that look along `across`. False: they do not look at each other (the cosine between
  /// their normals is above `opposite`), share nothing, or are not flat. The same ones are not laid
  /// again.
  bool find(const Solid& solid_p, const Solid& solid_q, const Vector3& across, double opposite,
            double rounding);
};

/// Of some faces of P the one that parts it most from Q, and by how much, m; -1: none looks at Q.
struct PartingFace {
  int face = -1;
  double gap = -kInfinity;
};
PartingFace parting_face(const Solid& p, const Solid& q, std::span<const int> faces);

/// What two faces have to share. Where it is narrow their edges may come as near within rounding,
/// and touching_edges has to be asked first.
enum class SharedWidth { Any, Wide };

/// The features over which the two faces come nearest, as an ordinary answer.
bool lowest_corner(const CanonicalPair& pair, const FacingFaces& faces, NearestFeatures& answer);

/// The same as a plane, if that is proved to be the best, by itself or by how near the faces lie to
/// each other. See geometry/README.md, "Touching faces".
bool touching_faces(const Solid& p, const Solid& q, const Lengths& length, const FacingFaces& faces,
                    SharedWidth least, Optimum& optimum);

/// What a feature puts into the sets of a plane: its vertices, ascending, and its label.
void take_feature(const Solid& solid, const Feature& feature, VertexSet& set, int& face);

/// A settled plane that is known to be the best. Where no other vertex comes near it, last step's
/// features lead to it without a search: it is then described as they do.
bool take_settled(const Solid& p, const Solid& q, const Lengths& length, Optimum& optimum);

}  // namespace quoin::geometry
