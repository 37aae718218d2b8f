#pragma once
/// Solids that touch with two whole faces, the ordinary contact of masonry, in straight code.
/// Internal.

#include <quoin/geometry/nearest_features.hpp>

#include "certify/certificate.hpp"
#include "numeric/late_init.hpp"
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

 private:
  const Solid& solid_;
  const Vector3& outward_;
  Vec3 local_;
};

/// Are two whole faces all there is within the band?
bool faces_alone(const Solid& p, const Solid& q, const ContactPolygon& part, double band);

/// The answer for two solids whose contact features are two whole faces, beyond doubt, and what
/// these share. False: ask the general way, which comes to the same bits where this one does. The
/// faces of the hint are tried, or where it is empty those that look at each other.
bool flush_answer(const Solid& a, const Solid& b, double tolerance, const FeatureHint& hint,
                  LateInit<ContactPolygon>& part, NearestFeatures& answer);

}  // namespace quoin::geometry
