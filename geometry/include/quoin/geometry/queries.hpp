#pragma once
/// Lesser questions than contact: overlap yes or no, distance up to a limit, rays and points.
///
/// Answers of two bodies are those of nearest_features(), found sooner where they are clear. Rays
/// and points are held against the planes of the face labels, each laid through the vertex of the
/// solid that is farthest out: these enclose the solid, by no more than its labels are off their
/// planes. A shape that is flat to rounding contains no point, and no ray hits it.

#include <limits>
#include <optional>
#include <quoin/geometry/nearest_features.hpp>

namespace quoin::geometry {

/// Whether two solids have a point in common, that is whether their gap is at most 0. Ends as soon
/// as a plane clearly parts them or a point clearly lies in both; only else the gap decides.
/// `hint` changes the speed, never the answer. Throws nothing.
bool overlap(const Body& a, const Body& b, const FeatureHint& hint = {});

/// The nearest features of two solids whose gap is at most `cut_off` (m), nothing for others. Ends
/// as soon as a plane clearly keeps them farther apart. Throws InputError for a cut_off of NaN and
/// as nearest_features() does.
std::optional<NearestFeatures> nearest_features_within(const Body& a, const Body& b, double cut_off,
                                                       const SearchOptions& options = {},
                                                       const FeatureHint& hint = {});

/// The points origin + s direction, 0 <= s <= length.
struct Ray {
  Vector3 origin = Vector3::Zero();                         ///< m
  Vector3 direction = Vector3::UnitX();                     ///< not zero; need not be a unit vector
  double length = std::numeric_limits<double>::infinity();  ///< in units of the direction
};

/// Throws InputError for a ray that is none, as first_hit() does.
void require_ray(const Ray& ray);

struct RayHit {
  double s = 0.0;                    ///< where the ray enters; 0: it starts in the solid
  Vector3 point = Vector3::Zero();   ///< m
  Vector3 normal = Vector3::Zero();  ///< outward unit normal of the face; zero: starts inside
  int face = -1;                     ///< where it enters; -1: starts inside
};

/// Where a ray enters a solid. A ray that passes within rounding of an edge may hit or miss; one
/// with a direction so short that `s` or `point` is no finite number misses, and so does every ray
/// at a body whose placement is not finite. Throws
/// InputError for a ray that is not finite (but for its length), has no direction or a negative
/// length.
std::optional<RayHit> first_hit(const Body& body, const Ray& ray);

/// Whether a point (m) lies in the solid or within `tolerance` (m) of all its planes; on a face
/// rounding decides: 16 eps of the diameter and of the shape's own largest coordinate. A point that
/// is not finite lies nowhere. Throws InputError for a tolerance that is negative or not finite.
bool contains(const Body& body, const Vector3& point, double tolerance = 0.0);

}  // namespace quoin::geometry
