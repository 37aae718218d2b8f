#pragma once
/// The exact signed gap of two convex hulls, to judge the library by. It shares no code with it:
/// any good guess is made in long double and then *proved* in whole numbers of any size (GMP).

#include <array>
#include <memory>
#include <quoin/geometry/body.hpp>
#include <string>
#include <vector>

namespace quoin::referee {

/// The solid: the convex hull of the points t + A X under the twelve doubles as given, not rounded.
struct PlacedPoints {
  geometry::Points points;  ///< X: 3 × n, m; finite, of full dimension, repeated points allowed
  geometry::Placement placement;
};

struct ExactGap {
  long double gap = 0;  ///< m; the exact number rounded to long double
  geometry::Vector3 normal = geometry::Vector3::Zero();  ///< unit, from A to B; one of the optimal
  int exact_steps = 0;  ///< how often the guess had to be mended in exact arithmetic
};

using RealPoint = std::array<long double, 3>;  ///< m

/// Two solids in whole numbers, and beside them rounded to long double relative to the first point
/// of A: what is read off there is right within 2^-60 of the pair's extent.
class ExactPair {
 public:
  ExactPair(const PlacedPoints& a, const PlacedPoints& b);
  ~ExactPair();
  ExactPair(ExactPair&&) noexcept;

  /// Distance of the solids, or minus the least translation that parts them. Exact: separated hulls
  /// by Wolfe's criterion in integers (min over all vertices of x·w >= x·x), overlapping ones by
  /// the planes of all face normals and all edge-edge crosses, those that may be least evaluated in
  /// integers.
  ExactGap gap() const;

  /// The square of the gap, m2, as a fraction p/q in lowest terms: exactly.
  std::string squared_gap() const;

  /// The points of A (side 0) or B (side 1), relative to the first point of A, m.
  const std::vector<RealPoint>& places(int side) const;
  /// Is a point a vertex of its solid? Exactly: it lies outside the hull of all points elsewhere.
  /// Remembered of each point: one pair is not for several threads.
  bool is_vertex(int side, std::size_t point) const;
  /// A point of the world likewise.
  RealPoint place(const geometry::Vector3& point) const;

  /// Distance of a point of the world from a solid, m; 0 inside; NaN for NaN. Where a point of the
  /// solid within `enough` is found in long double, its distance; else the exact one.
  double distance(int side, const geometry::Vector3& point, double enough) const;
  /// Of a point relative to the first point of A, within the rounding of long double.
  long double distance_in_long_double(int side, const RealPoint& place) const;

 private:
  struct Numbers;
  struct Proof;
  Proof proof() const;
  std::unique_ptr<Numbers> numbers_;
};

/// The gap of two point sets where they stand (3 × n, m).
ExactGap exact_gap(const geometry::Points& a, const geometry::Points& b);

/// Least distance of two parallel planes with the solid between them, m: what must be pushed to
/// part the solid from itself. Throws std::invalid_argument when the points lie in one plane.
long double exact_width(const PlacedPoints& solid);

/// Largest of n·x over the points less n·origin, summed in long double.
long double support(const geometry::Points& points, const geometry::Vector3& n,
                    const geometry::Vector3& origin);

}  // namespace quoin::referee
