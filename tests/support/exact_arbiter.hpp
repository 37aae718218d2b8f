#pragma once
/// The exact signed gap of two convex hulls, to judge the library by. It shares no code with it:
/// any good guess is made in long double and then *proved* in whole numbers of any size (GMP).

#include <quoin/geometry/types.hpp>

namespace quoin::tests {

struct ExactGap {
  long double gap = 0;  ///< m; the exact number rounded to long double
  geometry::Vector3 normal = geometry::Vector3::Zero();  ///< unit, from A to B; one of the optimal
  int exact_steps = 0;  ///< how often the guess had to be mended in exact arithmetic
};

/// Signed gap of the convex hulls of two point sets (3 × n, m; finite, each of full dimension):
/// their distance, or minus the least translation that parts them. Exact: separated hulls by
/// Wolfe's criterion in integers (min over all vertices of x·w >= x·x), overlapping ones by the
/// planes of all face normals and all edge-edge crosses, those that may be least evaluated in
/// integers.
ExactGap exact_gap(const geometry::Points& a, const geometry::Points& b);

/// Largest of n·x over the points less n·origin, summed in long double.
long double support(const geometry::Points& points, const geometry::Vector3& n,
                    const geometry::Vector3& origin);

/// Distance of a point from the convex hull of a point set, m; 0 inside.
double distance_to_hull(const geometry::Points& points, const geometry::Vector3& point);

}  // namespace quoin::tests
