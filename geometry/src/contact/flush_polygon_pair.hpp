#pragma once
/// A pair that lay with two faces of any number of corners on each other last step: all of the
/// proof but what the faces share, which is found side by side (flush_polygons). Internal.

#include <optional>
#include <quoin/geometry/contact_point.hpp>

#include "certify/certificate.hpp"
#include "contact/flush_points.hpp"
#include "search/flush_polygons.hpp"

namespace quoin::geometry {

struct PolygonPair {
  std::size_t number = 0;  ///< the caller's
  FlushFaces faces;
  double reach = 0.0;              ///< ContactOptions, m
  std::optional<Body> a, b;        ///< kept where points are told in the bodies' frames
  Vector3 middle, between;         ///< in the world; from the centre of A to that of B, m
  double contact = 0.0;            ///< Lengths, m
  double clear = 0.0;              ///< all vertices beside the faces lie so far below them, m
  double wide = 0.0;               ///< the shared part must be larger, m2
  double margin = 0.0;             ///< and the corners reach so far inside, m
  double gap = 0.0, border = 0.0;  ///< m
  ContactPlane plane;

  /// Is it clear that the faces of the hint alone carry the plane? Then it is in that lane of the
  /// question, which refers to its shapes. Every number is as in face_face.cpp.
  bool take(const Body& body_a, const Body& body_b, const FeatureHint& hint, double tolerance,
            std::size_t lane, PolygonQuestion& question);
  /// Do the faces share a part that is wide, and is no other plane better?
  bool proved(double area, double of_margin) const { return area > wide && of_margin >= margin; }
};

}  // namespace quoin::geometry
