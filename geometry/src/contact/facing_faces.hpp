#pragma once
/// Which faces of two solids face each other. Internal.

#include "polygon/contact_polygon.hpp"

namespace quoin::geometry {

/// Which faces of a solid look at the other one: none that is steeper than 30 degrees. The
/// direction is turned into the shape's frame once; only what lies near the limit there is asked as
/// placed.
class LooksAlong {
 public:
  LooksAlong(const Solid& solid, const Vector3& outward)
      : solid_(solid), outward_(outward), local_(solid.turned_back(outward)) {}
  bool operator()(int face) const;
  /// Does `face`, and none that shares a vertex with it?
  bool alone(int face) const { return (*this)(face) && !others_do(face); }

 private:
  bool others_do(int face) const;
  /// Of the angle between a face of a rigid solid and the direction.
  double own_cosine(int face) const { return dot(Vec3(solid_.shape().face_normal(face)), local_); }

  const Solid& solid_;
  const Vector3& outward_;
  Vec3 local_;
};

/// The face that has all of some vertices (ascending) and looks along `outward`, if none around it
/// does; else -1.
int only_facing(const Solid& solid, const VertexSet& vertices, const Vector3& outward);

/// Are two whole faces all there is within the band?
bool faces_alone(const Solid& p, const Solid& q, const ContactPolygon& part, double band);

}  // namespace quoin::geometry
