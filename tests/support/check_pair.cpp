#include "support/check_pair.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace quoin::tests {
namespace {

using geometry::ContactPoint;
using geometry::Feature;
using geometry::FeatureHint;
using geometry::FeatureKind;
using geometry::Matrix3;
using geometry::NearestFeatures;
using geometry::PairStatus;
using geometry::Polyhedron;
using geometry::Vector3;

constexpr double kEps = std::numeric_limits<double>::epsilon();

/// Collects what does not hold.
class Faults {
 public:
  template <class... Parts>
  void expect(bool holds, const Parts&... parts) {
    if (!holds) {
      std::ostringstream out;
      out.precision(17);
      (out << ... << parts);
      list.push_back(out.str());
    }
  }
  std::vector<std::string> list;
};

double larger_diameter(const SolidPair& pair) {
  return std::max(diameter(pair.a), diameter(pair.b));
}

/// What the rounding of world coordinates takes from a point, m.
double coordinate_rounding(const SolidPair& pair) {
  return 4 * kEps * std::max(largest_coordinate(pair.a), largest_coordinate(pair.b));
}

double allowed_gap_error(const SolidPair& pair, long double gap) {
  return 1e-12 * std::abs(static_cast<double>(gap)) + 16 * kEps * larger_diameter(pair);
}

/// A length within which a witness or a support plane may be off, m.
double allowed_length(const SolidPair& pair) {
  return 16 * kEps * larger_diameter(pair) + coordinate_rounding(pair);
}

bool finite(const NearestFeatures& n) {
  return std::isfinite(n.gap) && n.normal.allFinite() && n.point_a.allFinite() &&
         n.point_b.allFinite() && std::isfinite(n.residual_a) && std::isfinite(n.residual_b);
}

int feature_count(const Polyhedron& solid, FeatureKind kind) {
  switch (kind) {
    case FeatureKind::Vertex:
      return solid.topology().vertex_count();
    case FeatureKind::Edge:
      return solid.topology().edge_count();
    default:
      return solid.topology().face_count();
  }
}

bool exists(const Polyhedron& solid, const Feature& feature) {
  return feature.index >= 0 && feature.index < feature_count(solid, feature.kind);
}

void check_certificate(const SolidPair& pair, const NearestFeatures& n, Faults& faults) {
  const double slack = allowed_length(pair);
  const double beyond_a = static_cast<double>(support(pair.a.vertices(), n.normal, n.point_a));
  const double beyond_b = static_cast<double>(support(pair.b.vertices(), -n.normal, n.point_b));
  faults.expect(n.residual_a >= 0 && n.residual_b >= 0, "negative residual");
  faults.expect(beyond_a <= n.residual_a + slack, "residual_a ", n.residual_a, " but A reaches ",
                beyond_a, " beyond its witness");
  faults.expect(beyond_b <= n.residual_b + slack, "residual_b ", n.residual_b, " but B reaches ",
                beyond_b, " beyond its witness");
  const double allowed = slack + 1e-12 * std::abs(n.gap);
  faults.expect(n.residual_a <= allowed, "residual_a ", n.residual_a, " > ", allowed);
  faults.expect(n.residual_b <= allowed, "residual_b ", n.residual_b, " > ", allowed);
}

void check_witnesses(const SolidPair& pair, const NearestFeatures& n, Faults& faults) {
  const double slack = allowed_length(pair) + 1e-12 * std::abs(n.gap);
  const double along = (n.point_b - n.point_a).dot(n.normal);
  faults.expect(std::abs(along - n.gap) <= slack, "(point_b - point_a)·normal ", along, " but gap ",
                n.gap);
  const double off_a = distance_to_hull(pair.a.vertices(), n.point_a);
  const double off_b = distance_to_hull(pair.b.vertices(), n.point_b);
  faults.expect(off_a <= slack, "point_a is ", off_a, " off A");
  faults.expect(off_b <= slack, "point_b is ", off_b, " off B");
  if (n.gap > slack) {
    const double apart = (n.point_b - n.point_a).norm();
    faults.expect(std::abs(apart - n.gap) <= slack, "witnesses ", apart, " apart but gap ", n.gap);
  }
}

void check_status(const SolidPair& pair, const NearestFeatures& n, Faults& faults) {
  const double tolerance = default_tolerance(pair.a, pair.b);
  const PairStatus expected = std::abs(n.gap) <= tolerance ? PairStatus::Touching
                              : n.gap > 0                  ? PairStatus::Separated
                                                           : PairStatus::Overlapping;
  faults.expect(n.status == expected, "status ", static_cast<int>(n.status), " at gap ", n.gap,
                " and tolerance ", tolerance);
  const double smaller = std::min(diameter(pair.a), diameter(pair.b));
  const double coordinate = std::max(largest_coordinate(pair.a), largest_coordinate(pair.b));
  const double stated = std::max(1e-9 * smaller, 16 * kEps * coordinate);
  faults.expect(tolerance >= 0.999 * stated && tolerance <= 2 * stated, "tolerance ", tolerance,
                " where ", stated, " is stated");
}

void check_point(const SolidPair& pair, const NearestFeatures& n, const ContactPoint& c,
                 double reach, Faults& faults) {
  const double slack = allowed_length(pair) + 1e-12 * std::abs(n.gap);
  const double tolerance = default_tolerance(pair.a, pair.b);
  const bool vertex_face =
      (c.key.feature_a.kind == FeatureKind::Vertex && c.key.feature_b.kind == FeatureKind::Face) ||
      (c.key.feature_a.kind == FeatureKind::Face && c.key.feature_b.kind == FeatureKind::Vertex);
  const bool edge_edge =
      c.key.feature_a.kind == FeatureKind::Edge && c.key.feature_b.kind == FeatureKind::Edge;
  faults.expect(vertex_face || edge_edge, "a contact point is neither vertex-face nor edge-edge");
  faults.expect(exists(pair.a, c.key.feature_a) && exists(pair.b, c.key.feature_b),
                "a contact point names a feature that is not there");
  faults.expect(c.point_a.allFinite() && c.point_b.allFinite() && std::isfinite(c.gap) &&
                    std::isfinite(c.area) && c.area >= 0,
                "a contact point is not finite");
  faults.expect(c.normal == n.normal, "a contact point's normal is not the pair's");
  faults.expect(std::abs((c.point_b - c.point_a).dot(c.normal) - c.gap) <= slack,
                "a contact point's gap ", c.gap, " is not that of its points");
  const double crossing =
      1e-3 * tolerance;  // nearly parallel edges cross in an ill-conditioned place
  faults.expect(c.gap >= n.gap - slack - crossing, "a contact point's gap ", c.gap,
                " below the least ", n.gap);
  faults.expect(c.gap <= n.gap + std::max(reach, 2 * tolerance) + slack, "a contact point's gap ",
                c.gap, " out of reach");
  const double off_a = distance_to_hull(pair.a.vertices(), c.point_a);
  const double off_b = distance_to_hull(pair.b.vertices(), c.point_b);
  const double roughness = tolerance + slack;  // a face label is not exactly planar
  faults.expect(off_a <= roughness, "a contact point is ", off_a, " off A");
  faults.expect(off_b <= roughness, "a contact point is ", off_b, " off B");
}

void check_points(const SolidPair& pair, const NearestFeatures& n, Faults& faults) {
  std::vector<ContactPoint> points;
  const double reach = 1e-3 * std::min(diameter(pair.a), diameter(pair.b));
  append_contact_points({0, 1}, pair.a, pair.b, n, {.reach = reach}, points);
  faults.expect(!points.empty(), "no contact points");
  double least = std::numeric_limits<double>::infinity();
  for (const ContactPoint& c : points) {
    check_point(pair, n, c, reach, faults);
    least = std::min(least, c.gap);
  }
  const double tolerance = default_tolerance(pair.a, pair.b) + allowed_length(pair);
  faults.expect(points.empty() || least <= n.gap + 2 * tolerance, "least gap of the points ", least,
                " but gap ", n.gap);
  const auto by_key = [](const ContactPoint& c, const ContactPoint& d) { return c.key < d.key; };
  faults.expect(std::is_sorted(points.begin(), points.end(), by_key), "points are not sorted");
  for (std::size_t i = 1; i < points.size(); ++i) {
    faults.expect(points[i - 1].key != points[i].key, "two points of one key");
  }
}

NearestFeatures swapped(const NearestFeatures& n) {
  NearestFeatures s = n;
  s.normal = -n.normal;
  std::swap(s.point_a, s.point_b);
  std::swap(s.feature_a, s.feature_b);
  std::swap(s.residual_a, s.residual_b);
  return s;
}

/// Bitwise, up to the sign of zero.
void expect_same(const NearestFeatures& n, const NearestFeatures& m, const char* after,
                 Faults& faults) {
  faults.expect(n.gap == m.gap && n.status == m.status, after, ": gap ", m.gap, " status ",
                static_cast<int>(m.status), ", was ", n.gap, " status ",
                static_cast<int>(n.status));
  if (n.indeterminate) {
    return;  // one of the optimal set
  }
  faults.expect(n.normal == m.normal, after, ": another normal, off by ",
                (n.normal - m.normal).norm());
  faults.expect(n.point_a == m.point_a && n.point_b == m.point_b, after, ": other witnesses, off ",
                (n.point_a - m.point_a).norm(), " and ", (n.point_b - m.point_b).norm());
  faults.expect(n.feature_a == m.feature_a && n.feature_b == m.feature_b, after,
                ": other features");
  faults.expect(n.residual_a == m.residual_a && n.residual_b == m.residual_b, after,
                ": other residuals");
}

void check_hints(const SolidPair& pair, const NearestFeatures& n, Random& random, Faults& faults) {
  const auto ask = [&](const FeatureHint& hint) {
    return nearest_features(pair.a, pair.b, {}, hint);
  };
  expect_same(n, ask(n.hint), "started from its own answer", faults);
  FeatureHint any;
  const auto vertex = [&](const Polyhedron& solid) {
    return random.integer(-1, solid.topology().vertex_count() - 1);
  };
  for (std::size_t k = 0; k < 4; ++k) {
    any.vertices_a[k] = vertex(pair.a);
    any.vertices_b[k] = vertex(pair.b);
  }
  any.normal = random.direction();
  expect_same(n, ask(any), "started from anywhere", faults);
  const SolidPair before = moved_on(pair, 0.01, random);
  const NearestFeatures then = nearest_features(before.a, before.b);
  expect_same(n, ask(then.hint), "started from a step before", faults);
}

bool same(const ContactPoint& c, const ContactPoint& d) {
  return c.key == d.key && c.type == d.type && c.point_a == d.point_a && c.point_b == d.point_b &&
         c.normal == d.normal && c.gap == d.gap && c.area == d.area;
}

/// Nearest features and points asked in one: the way there is another, the answer is not.
void check_in_one(const SolidPair& pair, const NearestFeatures& n, Faults& faults) {
  const double reach = n.gap + 1e-3 * std::min(diameter(pair.a), diameter(pair.b));
  std::vector<ContactPoint> points, expected;
  const NearestFeatures m =
      append_contacts_within_reach({0, 1}, pair.a, pair.b, {.reach = reach}, {}, points);
  expect_same(n, m, "asked with the points", faults);
  append_contact_points({0, 1}, pair.a, pair.b, m, {.reach = std::max(0.0, reach - m.gap)},
                        expected);
  if (m.gap > reach && m.status != PairStatus::Touching) expected.clear();
  faults.expect(std::equal(points.begin(), points.end(), expected.begin(), expected.end(), same),
                "other points when asked in one");
}

SolidPair both(const SolidPair& pair, double scale, const Matrix3& rotation, const Vector3& shift) {
  return {pair.family, transformed(pair.a, scale, rotation, shift),
          transformed(pair.b, scale, rotation, shift)};
}

void expect_near(const SolidPair& pair, const NearestFeatures& n, const SolidPair& other,
                 const char* after, Faults& faults) {
  const NearestFeatures m = nearest_features(other.a, other.b);
  // the motion itself rounds each coordinate
  const double moved = 8 * (coordinate_rounding(pair) + coordinate_rounding(other));
  const double allowed = moved + 2 * allowed_gap_error(pair, n.gap);
  faults.expect(std::abs(n.gap - m.gap) <= allowed, after, ": gap ", m.gap, ", was ", n.gap);
}

}  // namespace

std::vector<std::string> check_answer(const SolidPair& pair, const NearestFeatures& nearest) {
  Faults faults;
  faults.expect(finite(nearest), "not finite");
  faults.expect(nearest.status != PairStatus::NotConverged, "not converged");
  if (!faults.list.empty()) {
    return faults.list;
  }
  faults.expect(std::abs(nearest.normal.norm() - 1) <= 4 * kEps, "normal of length ",
                nearest.normal.norm());
  faults.expect(exists(pair.a, nearest.feature_a) && exists(pair.b, nearest.feature_b),
                "a feature that is not there");
  faults.expect(nearest.iterations >= 0 && nearest.iterations <= 256, nearest.iterations,
                " iterations");
  check_certificate(pair, nearest, faults);
  check_witnesses(pair, nearest, faults);
  check_status(pair, nearest, faults);
  check_points(pair, nearest, faults);
  return faults.list;
}

PairVerdict check_against_exact(const SolidPair& pair) {
  PairVerdict verdict;
  verdict.nearest = nearest_features(pair.a, pair.b);
  verdict.exact = exact_gap(pair.a.vertices(), pair.b.vertices());
  verdict.faults = check_answer(pair, verdict.nearest);
  verdict.allowed_error = allowed_gap_error(pair, verdict.exact.gap);
  verdict.gap_error = static_cast<double>(std::abs(verdict.nearest.gap - verdict.exact.gap));
  Faults faults;
  faults.expect(verdict.gap_error <= verdict.allowed_error, "gap ", verdict.nearest.gap, " exact ",
                static_cast<double>(verdict.exact.gap), " error ", verdict.gap_error, " allowed ",
                verdict.allowed_error);
  const double gap = static_cast<double>(verdict.exact.gap);
  if (gap > 1e3 * allowed_length(pair)) {  // the normal of a distance is unique
    const double off = (verdict.nearest.normal - verdict.exact.normal).norm();
    const double allowed = 16 * allowed_length(pair) / gap + 1e-12;
    faults.expect(off <= allowed, "normal off by ", off, " allowed ", allowed);
  }
  verdict.faults.insert(verdict.faults.end(), faults.list.begin(), faults.list.end());
  return verdict;
}

std::vector<std::string> check_symmetries(const SolidPair& pair, const NearestFeatures& nearest,
                                          Random& random) {
  Faults faults;
  expect_same(nearest, swapped(nearest_features(pair.b, pair.a)), "swapped", faults);
  const double scale = std::ldexp(1.0, random.integer(-30, 30));
  const SolidPair large = both(pair, scale, Matrix3::Identity(), Vector3::Zero());
  NearestFeatures scaled = nearest_features(large.a, large.b);
  scaled.gap /= scale;
  scaled.point_a /= scale;
  scaled.point_b /= scale;
  scaled.residual_a /= scale;
  scaled.residual_b /= scale;
  expect_same(nearest, scaled, "scaled by a power of two", faults);
  check_hints(pair, nearest, random, faults);
  check_in_one(pair, nearest, faults);
  const double size = larger_diameter(pair);
  expect_near(pair, nearest,
              both(pair, 1, Matrix3::Identity(), size * random.uniform() * random.direction()),
              "shifted", faults);
  expect_near(pair, nearest, both(pair, 1, random.rotation(), Vector3::Zero()), "turned", faults);
  expect_near(pair, nearest, {pair.family, renumbered(pair.a, random), renumbered(pair.b, random)},
              "renumbered", faults);
  return faults.list;
}

}  // namespace quoin::tests
