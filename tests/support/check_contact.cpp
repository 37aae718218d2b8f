#include "support/check_contact.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace quoin::tests {
namespace {

using namespace geometry;

using Real = long double;
constexpr double kEps = std::numeric_limits<double>::epsilon();

int feature_count(const Shape& shape, FeatureKind kind) {
  switch (kind) {
    case FeatureKind::Vertex:
      return shape.topology().vertex_count();
    case FeatureKind::Edge:
      return shape.topology().edge_count();
    default:
      return shape.topology().face_count();
  }
}

bool exists(const Shape& shape, const Feature& feature) {
  return feature.index >= 0 && feature.index < feature_count(shape, feature.kind);
}

bool vertex_face_or_edges(const ContactPoint& c) {
  const FeatureKind a = c.key.feature_a.kind, b = c.key.feature_b.kind;
  return (a == FeatureKind::Vertex && b == FeatureKind::Face) ||
         (a == FeatureKind::Face && b == FeatureKind::Vertex) ||
         (a == FeatureKind::Edge && b == FeatureKind::Edge);
}

void check_point(const Trial& trial, const NearestFeatures& n, const ContactPoint& c, double reach,
                 Faults& faults) {
  const double slack = trial.allowed_place(n.gap);
  faults.expect(vertex_face_or_edges(c), "point name", "neither vertex-face nor edge-edge");
  faults.expect(exists(trial.query.a().shape(), c.key.feature_a) &&
                    exists(trial.query.b().shape(), c.key.feature_b),
                "point name", "a feature that is not there");
  faults.expect(c.normal == n.normal, "point normal", "is not the pair's");
  const bool finite = c.point_a.allFinite() && c.point_b.allFinite() && std::isfinite(c.gap) &&
                      std::isfinite(c.area) && c.area >= 0;
  faults.expect(finite, "point not finite", "gap ", c.gap, " area ", c.area);
  if (!finite) return;
  const double apart = (c.point_b - c.point_a - c.gap * c.normal).norm();
  faults.expect(apart <= slack, "point gap", "points are not apart by gap ", c.gap,
                " along the normal, off by ", apart, ", allowed ", slack);
  faults.expect(c.gap >= n.gap - slack, "point below least gap", c.gap, " where the gap is ", n.gap,
                ", allowed ", slack);
  const double limit = n.gap + std::max(reach, trial.tolerance) + slack;
  faults.expect(c.gap <= limit, "point out of reach", "gap ", c.gap, " above ", limit);
  judge_places(trial.exact, {c.point_a, c.point_b}, slack, "point", trial.tolerance, faults);
}

std::vector<Place> places_of(const ExactPatch& patch) {
  std::vector<Place> places;
  for (const PatchCorner& corner : patch.corners) places.push_back(corner.place);
  return places;
}

Real extent_of(const std::vector<Place>& places) {
  Real most = 0;
  for (const Place& p : places)
    for (const Place& q : places) most = std::max(most, distance(p, q));
  return most;
}

/// Are there corners so near to each other that their points may be merged?
bool crowded(const std::vector<Place>& corners, double tolerance) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      if (distance(corners[i], corners[j]) <= 2 * Real(tolerance)) return true;
  }
  return false;
}

struct Polygon {
  std::vector<Place> corners;
  Real area = 0;
  Place centroid{};
};

/// The shares against the polygon that they share out.
void check_shares(const std::vector<ContactPoint>& points, const std::vector<Place>& places,
                  const Polygon& polygon, double off, double allowed_area, Faults& faults) {
  Real sum = 0;
  Place moment{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Real share = points[i].area;
    sum += share;
    moment[0] += share * (places[i][0] - polygon.centroid[0]);
    moment[1] += share * (places[i][1] - polygon.centroid[1]);
  }
  faults.expect(std::abs(sum - polygon.area) <= Real(allowed_area), "area", "the shares sum to ",
                sum, " of ", polygon.area, ", allowed ", allowed_area);
  const Real lever = std::max(extent_of(polygon.corners), extent_of(places));
  const Real allowed = Real(allowed_area) * lever + polygon.area * Real(off);
  const Real moved = std::hypot(moment[0], moment[1]);
  faults.expect(moved <= allowed, "moment", "the shares' first moment is off by ", moved,
                " m3, their centroid by ", moved / polygon.area, ", allowed ", allowed);
}

Polygon reported_polygon(const Trial& trial, const PlaneFrame& frame, const PairContact& contact) {
  Polygon polygon;
  for (const geometry::Vector3& corner : contact.polygon)
    polygon.corners.push_back(frame.place(trial.exact.place(corner)));
  polygon.area = polygon_area(polygon.corners, polygon.centroid);
  return polygon;
}

/// Sine between the sides at a place, within `allowed` of it, at which two polygons reach past each
/// other from opposite sides: what they share there is a sliver, and ends elsewhere by the allowed
/// over this as soon as either moves by what is allowed. 1: there are no such sides, as of edges,
/// which have no inside. Polygons counter-clockwise.
Real sliver_sine(const std::array<std::vector<Place>, 2>& polygons, const Place& place,
                 Real allowed) {
  if (polygons[0].size() < 3 || polygons[1].size() < 3) return 1;
  std::array<std::vector<Place>, 2> ways;  // unit, along the sides there
  for (const std::size_t side : {0u, 1u}) {
    const std::vector<Place>& corners = polygons[side];
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Place &from = corners[i], &to = corners[(i + 1) % corners.size()];
      const Real length = distance(from, to);
      if (!(length > 0) || distance_to_places({from, to}, place) > allowed) continue;
      ways[side].push_back({(to[0] - from[0]) / length, (to[1] - from[1]) / length});
    }
  }
  Real sine = 1;
  for (const Place& a : ways[0]) {
    for (const Place& b : ways[1]) {
      const bool opposite = a[0] * b[0] + a[1] * b[1] < 0;
      if (opposite) sine = std::min(sine, std::abs(a[0] * b[1] - a[1] * b[0]));
    }
  }
  return sine;
}

/// The polygon or segment as reported against the exact one. What it is allowed to be off is a
/// length on either border: where two sides cross at a small angle it moves the crossing by more.
/// So each corner has to lie on both support polygons (of parallel edges beside each other: midway,
/// within half of tol of either), and no corner of the exact patch outside by more than that makes.
void check_polygon(const Trial& trial, const Polygon& reported, const ExactPatch& patch,
                   double slack, Faults& faults) {
  if (patch.corners.size() == 1) return;
  const bool beside = patch.type == ContactType::EdgeEdgeParallel;
  const Real allowed = 2 * Real(slack) + (beside ? Real(trial.tolerance) / 2 : 0);
  for (const Place& corner : reported.corners) {
    for (const std::size_t side : {0u, 1u}) {
      const Real off = distance_to_places(patch.support[side], corner);
      faults.expect(off <= allowed, "polygon", "a corner of the polygon is ", off,
                    " outside the support polygon of ", side == 0 ? "A" : "B");
    }
  }
  for (const PatchCorner& corner : patch.corners) {
    const Real off = distance_to_places(reported.corners, corner.place);
    const Real sine = std::min(corner.sine, sliver_sine(patch.support, corner.place, allowed));
    const Real most = (2 * Real(slack) + patch.open_ends) / std::max(sine, Real(kEps));
    faults.expect(off <= most, "polygon", "a corner of the exact patch is ", off,
                  " outside the polygon, allowed ", most);
  }
}

/// Edges of a solid at the vertices within `band` (m) of its support plane, but for those that lean
/// by more than 30 degrees: these belong to another contact.
std::size_t level_edges(const geometry::Body& body, const geometry::Vector3& outward, double band) {
  const geometry::Topology& topology = body.shape().topology();
  const geometry::Vector3 local = body.placement().linear.transpose() * outward;
  const Eigen::VectorXd heights = body.shape().vertices().transpose() * local;
  const double top = heights.maxCoeff();
  std::set<int> edges;
  for (int v = 0; v < topology.vertex_count(); ++v) {
    if (heights[v] < top - band) continue;
    for (const int e : topology.vertex_edges(v)) {
      const auto [from, to] = topology.edge(e);
      const geometry::Vector3 line =
          body.placement().linear * (body.shape().vertex(to) - body.shape().vertex(from));
      if (std::abs(line.dot(outward)) <= 0.5 * line.norm()) edges.insert(e);
    }
  }
  return edges.size();
}

/// Within tol a point lies at a vertex that carries the contact or where two edges cross, each of
/// which has an end that does: the height along it is linear. The points that say nothing more lie
/// inside the hull of the others, and no line has more than two corners of that: so there are at
/// most two on each level edge of either solid, beside the vertices. Where there are fewer such
/// edges than vertices, tol cuts faces: as many edges as vertices are granted.
std::size_t most_points(const Trial& trial, const NearestFeatures& n, const ExactPatch& patch) {
  const double band = trial.tolerance + trial.allowed_place(n.gap);
  const auto vertices = static_cast<std::size_t>(patch.support_vertices);
  const std::size_t crossed = std::min(level_edges(trial.query.a(), n.normal, band),
                                       level_edges(trial.query.b(), -n.normal, band));
  return vertices + std::max(vertices, 2 * crossed);
}

}  // namespace

void check_points(const Trial& trial, const PairContact& contact, double reach, Faults& faults) {
  const std::vector<ContactPoint>& points = contact.points;
  const NearestFeatures& n = contact.nearest;
  faults.expect(!points.empty(), "no points", "type ", static_cast<int>(contact.type));
  double least = std::numeric_limits<double>::infinity();
  for (const ContactPoint& c : points) {
    check_point(trial, n, c, reach, faults);
    least = std::min(least, c.gap);
  }
  const double off = least - n.gap, slack = trial.allowed_place(n.gap);
  const char* kind =
      off <= trial.tolerance + slack ? "least gap off by less than tol" : "least gap missing";
  faults.expect(points.empty() || off <= slack, kind, "the points' least is ", least,
                " where the gap is ", n.gap);
  for (std::size_t i = 1; i < points.size(); ++i) {
    faults.expect(points[i - 1].key < points[i].key, "point order",
                  "two points of one key, or not sorted");
  }
}

void check_contact(const Trial& trial, const PairContact& contact, Faults& faults) {
  check_points(trial, contact, 0.0, faults);
  const NearestFeatures& n = contact.nearest;
  const double slack = trial.allowed_place(n.gap);
  const ExactPatch patch = judged_patch(trial.exact, n.normal, trial.tolerance, slack, trial);
  const PlaneFrame frame(n.normal);
  const std::vector<Place> places = middles(trial.exact, frame, contact.points);
  const Polygon reported = reported_polygon(trial, frame, contact);
  Polygon polygon{places_of(patch), patch.area, patch.centroid};
  if (patch.clear) {
    faults.expect(contact.type == patch.type, "type", name(contact.type), " for ",
                  name(patch.type));
    if (contact.type != patch.type) return;  // what follows would say the same again
    const CornerLengths lengths{trial.tolerance, trial.smaller, trial.allowed_gap(0)};
    judge_corners(trial.exact, n.normal, patch, places, lengths, slack, faults);
    check_polygon(trial, reported, patch, slack, faults);
  }
  if (!patch.clear || patch.corners.empty())  // open, or apart by no more than rounding
    polygon = reported;
  const Real area = patch.clear ? patch.area : polygon.area;
  if (contact.type != ContactType::FaceFace) {
    faults.expect(contact.area == 0, "area", contact.area, " but not face-face");
    return;
  }
  const double around = static_cast<double>(2 * extent_of(polygon.corners)) + 2 * slack;
  const double allowed_area = std::max(static_cast<double>(patch.perimeter), around) * 2 * slack;
  faults.expect(std::abs(contact.area - static_cast<double>(area)) <= allowed_area, "area",
                contact.area, " exact ", area, ", allowed ", allowed_area);
  const double merged = crowded(polygon.corners, trial.tolerance) ? trial.tolerance : 0.0;
  check_shares(contact.points, places, polygon, 2 * slack + merged, allowed_area, faults);
  const std::size_t most = most_points(trial, n, patch);
  faults.expect(contact.points.size() <= most, "many points", contact.points.size(), " where ",
                most, " may be, of ", patch.support_vertices, " vertices that carry the contact");
}

}  // namespace quoin::tests
