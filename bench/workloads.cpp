#include "workloads.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <quoin/geometry/build.hpp>

#include "referee/pairs/exact_arbiter.hpp"
#include "referee/pairs/random.hpp"

namespace quoin::bench {
namespace {

using referee::Random;
constexpr double kPi = 3.14159265358979323846;

int scaled_count(int usual, const WorkloadScale& scale) {
  return std::max(8, static_cast<int>(usual * scale.share));
}

BenchShape shape_of(const geometry::Shape& polyhedron) {
  return {polyhedron.vertices(), polyhedron.shared_topology(), false, Vector3::Zero()};
}

double diameter(const Points& vertices) {
  const Vector3 middle = 0.5 * (vertices.rowwise().minCoeff() + vertices.rowwise().maxCoeff());
  return 2.0 * (vertices.colwise() - middle).colwise().norm().maxCoeff();
}

BenchShape random_box(Random& random) {
  const Vector3 half(random.uniform(0.2, 0.6), random.uniform(0.2, 0.6), random.uniform(0.2, 0.6));
  return box_shape(half);
}

/// Hull with exactly `count` vertices: points on an ellipsoid, each of them a vertex.
BenchShape random_hull(Random& random, int count) {
  const Vector3 radii(random.uniform(0.35, 0.65), random.uniform(0.35, 0.65),
                      random.uniform(0.35, 0.65));
  Points points(3, count);
  for (int k = 0; k < count; ++k) points.col(k) = random.direction().cwiseProduct(radii);
  return shape_of(geometry::make_hull(points).polyhedron);
}

referee::ExactGap exact(const Workload& workload, const Pair& pair, int step) {
  const auto s = static_cast<std::size_t>(step);
  const Points a =
      pair.poses_a[s].apply(workload.shapes[static_cast<std::size_t>(pair.shape_a)].vertices);
  const Points b =
      pair.poses_b[s].apply(workload.shapes[static_cast<std::size_t>(pair.shape_b)].vertices);
  return referee::exact_gap(a, b);
}

void set_size(const Workload& workload, Pair& pair) {
  pair.size = std::min(diameter(workload.shapes[static_cast<std::size_t>(pair.shape_a)].vertices),
                       diameter(workload.shapes[static_cast<std::size_t>(pair.shape_b)].vertices));
}

/// Two random poses, then B is pushed along the normal until the gap is `gap` (m). Moving along the
/// normal of separated solids changes the distance by just the way moved.
void place_pair(Random& random, Workload& workload, Pair& pair, double gap_share) {
  set_size(workload, pair);
  pair.poses_a = {{random.rotation(), random.point(-0.1, 0.1)}};
  pair.poses_b = {{random.rotation(), 3.0 * random.direction()}};
  const referee::ExactGap start = exact(workload, pair, 0);
  const double way = gap_share * pair.size - static_cast<double>(start.gap);
  pair.poses_b[0].place += way * start.normal;
  pair.gap = {static_cast<double>(exact(workload, pair, 0).gap)};
}

using MakeShape = std::function<BenchShape(Random&)>;

void add_pairs(Random& random, Workload& workload, int count, const MakeShape& make, double low,
               double high) {
  constexpr int kShapes = 64;
  for (int k = 0; k < std::min(kShapes, count); ++k) workload.shapes.push_back(make(random));
  const int last = static_cast<int>(workload.shapes.size()) - 1;
  for (int k = 0; k < count; ++k) {
    Pair pair;
    pair.shape_a = random.integer(0, last);
    pair.shape_b = random.integer(0, last);
    const double share =
        workload.overlap ? -random.log_uniform(low, high) : random.log_uniform(low, high);
    place_pair(random, workload, pair, share);
    workload.pairs.push_back(std::move(pair));
  }
}

MakeShape maker(const std::string& family) {
  if (family == "box") return random_box;
  const int count = std::stoi(family);
  return [count](Random& random) { return random_hull(random, count); };
}

int usual_pairs(const std::string& family) {
  if (family == "box") return 1024;
  const int vertices = std::stoi(family);
  return vertices <= 32 ? 1024 : vertices <= 64 ? 512 : 256;
}

/// Turns and moves B by at most half a degree and half a percent of its size a step; what leaves
/// the band of gaps 0.1–10 % of the size is steered back.
void animate(Random& random, Workload& workload, Pair& pair) {
  constexpr double kTurn = 0.5 * kPi / 180.0, kShift = 0.005;
  const Vector3 axis = random.direction();
  const double turn = random.uniform(0.2, 1.0) * kTurn;
  const Vector3 drift = random.uniform(0.2, 0.6) * kShift * pair.size * random.direction();
  for (int s = 1; s < workload.steps; ++s) {
    Pose pose = pair.poses_b.back();
    pose.rotation = referee::rotation_about(axis, turn) * pose.rotation;
    pose.place += drift;
    pair.poses_a.push_back(pair.poses_a.back());
    pair.poses_b.push_back(pose);
    const referee::ExactGap now = exact(workload, pair, s);
    const double gap = static_cast<double>(now.gap);
    const double target = std::clamp(gap, 0.004 * pair.size, 0.096 * pair.size);
    const Vector3 step = drift + (target - gap) * now.normal;
    const double limit = kShift * pair.size;
    const double scale = std::min(1.0, limit / step.norm());
    pair.poses_b.back().place += scale * step - drift;
    pair.gap.push_back(
        target == gap && scale == 1.0 ? gap : static_cast<double>(exact(workload, pair, s).gap));
  }
}

Workload random_workload(const std::string& name, const std::string& family,
                         const WorkloadScale& scale) {
  Workload workload{.name = name, .family = family};
  Random random(1000 * static_cast<std::uint64_t>(name[1] - '0') +
                (family == "box" ? 1 : std::stoull(family)));
  if (name == "W5") {
    workload.overlap = true;
    add_pairs(random, workload, scaled_count(256, scale), maker(family), 0.01, 0.1);
    return workload;
  }
  const bool moving = name == "W3";
  add_pairs(random, workload,
            moving ? scaled_count(32, scale) : scaled_count(usual_pairs(family), scale),
            maker(family), moving ? 0.004 : 0.001, 0.1);
  if (moving) {
    workload.steps = scale.steps;
    workload.warm = true;
    for (Pair& pair : workload.pairs) animate(random, workload, pair);
  }
  return workload;
}

// ---- W6: the hard families
// -----------------------------------------------------------------------

/// Adds a pair given by world vertices (each its own shape, pose identity).
void add_world_pair(Workload& workload, BenchShape a, BenchShape b) {
  Pair pair;
  pair.shape_a = static_cast<int>(workload.shapes.size());
  pair.shape_b = pair.shape_a + 1;
  workload.shapes.push_back(std::move(a));
  workload.shapes.push_back(std::move(b));
  set_size(workload, pair);
  pair.poses_a = pair.poses_b = {Pose{}};
  pair.gap = {static_cast<double>(exact(workload, pair, 0).gap)};
  workload.pairs.push_back(std::move(pair));
}

BenchShape moved(const BenchShape& shape, const Pose& pose) {
  return {pose.apply(shape.vertices), shape.topology, false, Vector3::Zero()};
}

BenchShape scaled_shape(BenchShape shape, const Vector3& factors) {
  shape.vertices = factors.asDiagonal() * shape.vertices;
  shape.is_box = false;
  return shape;
}

/// Two solids in general position, pushed to a gap of `gap_share` of the smaller one, then carried
/// by `offset` (m).
void add_general(Random& random, Workload& workload, BenchShape a, BenchShape b, double gap_share,
                 const Vector3& offset) {
  Workload work;
  work.shapes = {std::move(a), std::move(b)};
  Pair pair{.shape_a = 0, .shape_b = 1};
  place_pair(random, work, pair, gap_share);
  pair.poses_a[0].place += offset;
  pair.poses_b[0].place += offset;
  add_world_pair(workload, moved(work.shapes[0], pair.poses_a[0]),
                 moved(work.shapes[1], pair.poses_b[0]));
}

/// Box on box, offset sideways, with a gap and a tilt (rad), both turned together.
void add_stacked(Random& random, Workload& workload, double gap, double tilt) {
  const BenchShape a = random_box(random), b = random_box(random);
  const Vector3 shift(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                      a.half_size.z() + b.half_size.z() + gap);
  const Pose turn{random.rotation(), Vector3::Zero()};
  const Pose above{referee::rotation_about(Vector3::UnitX(), tilt), shift};
  const Pose both{turn.rotation * above.rotation, turn.rotation * above.place};
  add_world_pair(workload, moved(a, turn), moved(b, both));
}

/// Two boxes with parallel axes sharing a whole, half or no edge at exactly the same doubles.
void add_touching(Random& random, Workload& workload) {
  const BenchShape a = random_box(random), b = random_box(random);
  const int axis = random.integer(0, 2);
  Vector3 shift = random.point(-0.3, 0.3);
  BenchShape right = moved(b, {Matrix3::Identity(), shift});
  const double face = a.vertices.row(axis).maxCoeff();
  const double low = right.vertices.row(axis).minCoeff();
  for (int v = 0; v < right.vertices.cols(); ++v) {  // the lower face exactly onto the upper one
    double& x = right.vertices(axis, v);
    x = x == low ? face : face + (x - low);
  }
  BenchShape left = a;
  left.is_box = right.is_box = false;
  add_world_pair(workload, left, right);
}

Workload hard_workload(const std::string& family, const WorkloadScale& scale) {
  Workload workload{.name = "W6", .family = family};
  Random random(6000 + family.size() * 31 + static_cast<std::uint64_t>(family[0]));
  const int count = scaled_count(128, scale);
  for (int k = 0; k < count; ++k) {
    if (family == "sliver") {
      const Vector3 thin(1.0, random.uniform(0.5, 1.0), 1e-3);
      add_general(random, workload, scaled_shape(random_hull(random, 12), thin),
                  scaled_shape(random_hull(random, 12), thin), random.log_uniform(1e-3, 0.1),
                  Vector3::Zero());
    } else if (family == "far") {
      add_general(random, workload, random_hull(random, 16), random_hull(random, 16),
                  random.log_uniform(1e-3, 0.1), 1e6 * random.direction());
    } else if (family == "parallel") {
      add_stacked(random, workload, random.log_uniform(1e-3, 0.1), 1e-9 * random.uniform(-1, 1));
    } else if (family == "touch") {
      add_touching(random, workload);
    } else if (family == "tiny-huge") {
      const double share = random.log_uniform(1e-3, 0.1);
      add_general(random, workload, scaled_shape(random_hull(random, 16), Vector3::Constant(1e-6)),
                  scaled_shape(random_hull(random, 16), Vector3::Constant(1e3)), share,
                  Vector3::Zero());
    } else {  // stacked at gap 0, turned
      add_stacked(random, workload, 0.0, 0.0);
    }
  }
  return workload;
}

// ---- W4: stacked blocks
// --------------------------------------------------------------------------

/// Area of the part that two convex polygons (counter-clockwise, m) share: Sutherland and Hodgman.
double shared_area(std::vector<Eigen::Vector2d> subject, const std::vector<Eigen::Vector2d>& clip) {
  const auto side = [](const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                       const Eigen::Vector2d& b) {
    return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
  };
  for (std::size_t k = 0; k < clip.size(); ++k) {
    const Eigen::Vector2d &a = clip[k], &b = clip[(k + 1) % clip.size()];
    std::vector<Eigen::Vector2d> kept;
    for (std::size_t i = 0; i < subject.size(); ++i) {
      const Eigen::Vector2d &p = subject[i], &q = subject[(i + 1) % subject.size()];
      const double sp = side(p, a, b), sq = side(q, a, b);
      if (sp >= 0) kept.push_back(p);
      if ((sp > 0 && sq < 0) || (sp < 0 && sq > 0)) kept.push_back(p + sp / (sp - sq) * (q - p));
    }
    subject = std::move(kept);
  }
  double twice = 0.0;
  for (std::size_t i = 0; i < subject.size(); ++i) {
    const Eigen::Vector2d &p = subject[i], &q = subject[(i + 1) % subject.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return 0.5 * twice;
}

std::vector<Eigen::Vector2d> footprint(Random& random, bool box) {
  if (box) return {{-0.5, -0.25}, {0.5, -0.25}, {0.5, 0.25}, {-0.5, 0.25}};
  const int corners = random.integer(5, 10);
  std::vector<Eigen::Vector2d> polygon;
  const double first = random.uniform(0, 2 * kPi);
  for (int k = 0; k < corners; ++k) {  // corners on an ellipse: convex
    const double angle = first + 2 * kPi * (k + random.uniform(-0.3, 0.3)) / corners;
    polygon.emplace_back(0.5 * std::cos(angle), 0.4 * std::sin(angle));
  }
  return polygon;
}

/// A prism given as triangles, which the builder merges to polygons.
BenchShape prism_shape(const std::vector<Eigen::Vector2d>& polygon, double half_height) {
  const int n = static_cast<int>(polygon.size());
  Points vertices(3, 2 * n);
  std::vector<std::vector<int>> triangles;
  for (int k = 0; k < n; ++k) {
    const auto& p = polygon[static_cast<std::size_t>(k)];
    vertices.col(k) = Vector3(p.x(), p.y(), -half_height);
    vertices.col(n + k) = Vector3(p.x(), p.y(), half_height);
    const int next = (k + 1) % n;
    triangles.push_back({k, next, n + next});
    triangles.push_back({k, n + next, n + k});
    if (k >= 2) {
      triangles.push_back({0, k, k - 1});
      triangles.push_back({n, n + k - 1, n + k});
    }
  }
  return shape_of(geometry::make_shape(vertices, triangles));
}

/// The families "box-tilt-1e-6" and "box-rock-1e-6": by how much one block leans against the other,
/// rad; 0 for others.
double tilt_of(const std::string& family) {
  const std::size_t at = std::min(family.find("-tilt-"), family.find("-rock-"));
  return at < family.size() ? std::stod(family.substr(at + 6)) : 0.0;
}

/// One block on another as in running bond, gap or overlap 1e-6 … 1e-3 of the size; where it leans,
/// an overlap deeper by so much that all of what both faces share overlaps.
Workload stacked_workload(const std::string& family, const WorkloadScale& scale) {
  Workload workload{.name = "W4", .family = family};
  const bool box = family.starts_with("box");
  const double tilt = tilt_of(family);
  workload.overlap = family.ends_with("overlap") || tilt > 0.0;
  Random random(4000 + (box ? 1 : 2) + (workload.overlap ? 10 : 20));
  const Vector3 half(0.5, 0.25, 0.2);
  std::vector<std::vector<Eigen::Vector2d>> footprints;
  for (int k = 0; k < (box ? 1 : 64); ++k) {
    footprints.push_back(footprint(random, box));
    workload.shapes.push_back(box ? box_shape(half) : prism_shape(footprints.back(), half.z()));
  }
  const int last = static_cast<int>(footprints.size()) - 1;
  for (int k = 0; k < scaled_count(512, scale); ++k) {
    Pair pair;
    pair.shape_a = random.integer(0, last);
    pair.shape_b = random.integer(0, last);
    const auto& lower = footprints[static_cast<std::size_t>(pair.shape_a)];
    const auto& upper = footprints[static_cast<std::size_t>(pair.shape_b)];
    set_size(workload, pair);
    const double length = pair.size * random.log_uniform(1e-6, 1e-3);
    const Eigen::Vector2d shift(random.uniform(-0.5, 0.5), random.uniform(-0.05, 0.05));
    const double gap = (workload.overlap ? -length : length) - tilt * pair.size;
    Matrix3 lean = Matrix3::Identity();  // about the middle of the upper one's lower face
    if (tilt > 0.0) {
      const double any = random.uniform(0, 2 * kPi);
      const double heading = family.starts_with("box-rock") ? 0.0 : any;  // about an edge
      lean = referee::rotation_about({std::cos(heading), std::sin(heading), 0.0}, tilt);
    }
    std::vector<Eigen::Vector2d> shifted = upper;
    for (Eigen::Vector2d& p : shifted) p = lean.topLeftCorner<2, 2>() * p + shift;
    pair.area = shared_area(lower, shifted);
    pair.rise = tilt * pair.size;
    const Pose turn{random.rotation(), random.point(-2, 2)};
    const Vector3 face(shift.x(), shift.y(), half.z() + gap);
    const Vector3 above = face + half.z() * lean.col(2);
    pair.poses_a = {turn};
    pair.poses_b = {{turn.rotation * lean, turn.place + turn.rotation * above}};
    pair.gap = {static_cast<double>(exact(workload, pair, 0).gap)};
    workload.pairs.push_back(std::move(pair));
  }
  return workload;
}

}  // namespace

bool Workload::boxes_only() const {
  return std::all_of(shapes.begin(), shapes.end(),
                     [](const BenchShape& shape) { return shape.is_box; });
}

double Workload::allowed_error(const Pair& pair, int step) const {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const auto s = static_cast<std::size_t>(step);
  const Points& a = shapes[static_cast<std::size_t>(pair.shape_a)].vertices;
  const Points& b = shapes[static_cast<std::size_t>(pair.shape_b)].vertices;
  const double coordinate = std::max(pair.poses_a[s].apply(a).cwiseAbs().maxCoeff(),
                                     pair.poses_b[s].apply(b).cwiseAbs().maxCoeff());
  return kWrongShare * std::abs(pair.gap[s]) + kWrongLength * pair.size +
         16 * kEpsilon * coordinate;
}

BenchShape box_shape(const Vector3& half_size) {
  BenchShape shape = shape_of(geometry::make_box(-half_size, half_size));
  shape.is_box = true;
  shape.half_size = half_size;
  return shape;
}

std::vector<std::string> distance_workload_names() {
  return {"W1/box", "W2/8",        "W2/16",    "W2/32",        "W2/64",     "W2/128", "W2/256",
          "W3/box", "W3/32",       "W3/128",   "W5/box",       "W5/16",     "W5/64",  "W6/sliver",
          "W6/far", "W6/parallel", "W6/touch", "W6/tiny-huge", "W6/stacked"};
}

std::vector<std::string> manifold_workload_names() {
  return {"W4/box-overlap",   "W4/box-gap",        "W4/prism-overlap", "W4/prism-gap",
          "W4/box-tilt-1e-9", "W4/box-tilt-1e-6",  "W4/box-tilt-1e-3", "W4/box-tilt-1e-2",
          "W4/box-rock-1e-3", "W4/prism-tilt-1e-3"};
}

Workload make_workload(const std::string& name, const WorkloadScale& scale) {
  const std::string kind = name.substr(0, 2), family = name.substr(3);
  if (kind == "W4") return stacked_workload(family, scale);
  if (kind == "W6") return hard_workload(family, scale);
  return random_workload(kind, family, scale);
}

}  // namespace quoin::bench
