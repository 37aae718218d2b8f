#pragma once
/// Nearest features of one pair of convex polyhedra: signed gap, witnesses, normal, certificate.

#include <quoin/geometry/body.hpp>
#include <string_view>

namespace quoin::geometry {

enum class PairStatus : std::uint8_t { Separated, Touching, Overlapping, NotConverged };

/// How the contact plane was chosen where the features leave it open.
enum class PlaneRule : std::uint8_t {
  Unique,         ///< a face or two crossed edges fix the plane
  ShortestLine,   ///< vertex-vertex, vertex-edge, parallel edges: across the shortest line between
                  ///< them
  LeastOverlap,   ///< several directions of equal least overlap: the first in the order of the
                  ///< features
  MiddleOfPlanes  ///< touching at a vertex or an edge: the mean of the planes that keep them apart
};

/// Where to start the search: vertices of the last answer. It changes `iterations`, never the
/// answer.
struct FeatureHint {
  std::array<int, 4> vertices_a{-1, -1, -1, -1};
  std::array<int, 4> vertices_b{-1, -1, -1, -1};
  int face_a = -1, face_b = -1;  ///< face labels that carried the plane
  Vector3 normal = Vector3::Zero();
};

struct SearchOptions {
  double tolerance = 0.0;    ///< contact length tol, m; 0: default_tolerance(a, b)
  int max_iterations = 256;  ///< of the search in double-double; all others have their own limits
};

/// The optimum of one pair. gap > 0: distance; gap < 0: minus the least translation that parts
/// them. A vertex belongs to the contact feature when it lies within tol of its support plane.
struct NearestFeatures {
  PairStatus status = PairStatus::NotConverged;
  double gap = 0.0;                   ///< (point_b - point_a)·normal, m
  Vector3 normal = Vector3::UnitX();  ///< unit, from A to B
  Vector3 point_a = Vector3::Zero();  ///< witness on A, m
  Vector3 point_b = Vector3::Zero();  ///< witness on B, m
  Feature feature_a, feature_b;
  double residual_a = 0.0;     ///< how far A reaches beyond point_a along the normal, m (>= 0)
  double residual_b = 0.0;     ///< how far B reaches beyond point_b against the normal, m (>= 0)
  int iterations = 0;          ///< steps of all searches together
  bool indeterminate = false;  ///< the normal is one choice among several
  PlaneRule rule = PlaneRule::Unique;
  FeatureHint hint;  ///< start the next search of this pair here
};

std::string_view name(
    PairStatus status);                 ///< "separated", "touching", "overlapping", "not-converged"
std::string_view name(PlaneRule rule);  ///< "unique", "shortest-line", …

/// The larger of 1e-9 of the smaller diameter and 16 eps of the largest coordinate, m: of the
/// shapes, with the diameter times what the placement stretches it by at most (Body::stretch()).
/// What counts is a length of the pair, not where it stands.
double default_tolerance(const Body& a, const Body& b);

/// Nearest features of two convex solids, or shapes as they are. `hint` is where to start; it
/// changes `iterations`, never the answer. Exact for the doubles given, within 1e-12 of the gap and
/// 16 eps of the larger diameter: what double arithmetic cannot decide is decided in a wider one.
/// Throws InputError for a tolerance that is negative or not finite, nothing else. A placement that
/// is not finite: NotConverged, the gap is NaN. Method, proof of termination and sources:
/// geometry/README.md.
NearestFeatures nearest_features(const Body& a, const Body& b, const SearchOptions& options = {},
                                 const FeatureHint& hint = {});

}  // namespace quoin::geometry
