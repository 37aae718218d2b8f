#pragma once
/// The pairs that every peer is asked about, the same for all, and their exact answers.

#include <memory>
#include <quoin/geometry/shape.hpp>
#include <string>
#include <vector>

namespace quoin::bench {

using geometry::Matrix3;
using geometry::Points;
using geometry::Topology;
using geometry::Vector3;

/// A convex polyhedron in its own frame.
struct BenchShape {
  Points vertices;  ///< 3 × vertex_count, m
  std::shared_ptr<const Topology> topology;
  bool is_box = false;
  Vector3 half_size = Vector3::Zero();  ///< of a box, centred at the origin, m
};

struct Pose {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 place = Vector3::Zero();  ///< m
  Points apply(const Points& local) const { return (rotation * local).colwise() + place; }
};

/// Two shapes, their poses at each step and the exact signed gap there.
struct Pair {
  int shape_a = 0, shape_b = 0;  ///< indices into Workload::shapes
  double size = 1.0;             ///< diameter of the smaller solid, m
  std::vector<Pose> poses_a{}, poses_b{};
  std::vector<double> gap{};  ///< exact, rounded to double, m
  double area = 0.0;          ///< of the shared face, m2 (W4 only)
  double rise = 0.0;          ///< of the gap over the shared face, at most, m (W4 only)
};

struct Workload {
  std::string name;    ///< "W1", …
  std::string family;  ///< "box", "16", …
  std::vector<BenchShape> shapes{};
  std::vector<Pair> pairs{};
  int steps = 1;
  bool warm = false;     ///< the steps follow each other: hints are allowed
  bool overlap = false;  ///< the pairs overlap: depth is asked
  /// An answer is wrong when it is off by more than this share of the exact gap (0 for a pair said
  /// to overlap when it does not, or the other way round) …
  static constexpr double kWrongShare = 1e-3;
  /// … and by more than this share of the smaller size plus the rounding of the coordinates.
  static constexpr double kWrongLength = 1e-9;
  /// How far an answer may be off and still count as right, m.
  double allowed_error(const Pair& pair, int step) const;
  bool boxes_only() const;
};

/// What to make. Fewer pairs for a quick look.
struct WorkloadScale {
  double share = 1.0;  ///< of the usual number of pairs
  int steps = 100;     ///< of W3
};

std::vector<std::string> distance_workload_names();  ///< W1, W2, W3, W5, W6: "W2/16", …
std::vector<std::string> manifold_workload_names();  ///< W4

/// Seeded: the same pairs on every machine.
Workload make_workload(const std::string& name, const WorkloadScale& scale);

/// A box of the given half size centred at the origin.
BenchShape box_shape(const Vector3& half_size);

}  // namespace quoin::bench
