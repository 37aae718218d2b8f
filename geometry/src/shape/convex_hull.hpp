#pragma once
/// The exact convex hull of points: every side-of-plane question is answered exactly for the
/// doubles given. Internal to the narrow phase.

#include <array>
#include <quoin/geometry/types.hpp>
#include <vector>

namespace quoin::geometry {

/// Sign of det[q-p, r-p, s-p]: +1 when s lies on the side of (q-p)×(r-p), 0 when exactly coplanar.
/// Source: [Shewchuk 1997], a floating-point filter backed by expansion arithmetic.
int orientation(const Vector3& p, const Vector3& q, const Vector3& r, const Vector3& s);

/// True when p, q, r lie exactly on one line.
bool collinear(const Vector3& p, const Vector3& q, const Vector3& r);

/// What the points span (0 point, 1 line, 2 plane, 3 space) and, when space, the triangles of their
/// hull, counter-clockwise seen from outside. Points on the hull that are no corner may be left out
/// or, when met early, stay in as vertices of coplanar triangles.
struct HullTriangles {
  int dimension = 0;
  std::vector<std::array<int, 3>> triangles;
};

/// The points by the power of two that brings their largest coordinate between 1 and 2, coordinates
/// below 2^-200 of that as zeros: nothing is rounded otherwise, and no product of three differences
/// under- or overflows (each part of a difference is a multiple of 2^-252, of a product of 2^-756).
/// `exponent`: the power, at most 1000.
Points scaled_points(const Eigen::Ref<const Points>& points, int& exponent);

/// Source: [Barber, Dobkin, Huhdanpaa 1996] with exact predicates. points: 3 × n, scaled as above.
HullTriangles hull_triangles(const Eigen::Ref<const Points>& points);

}  // namespace quoin::geometry
