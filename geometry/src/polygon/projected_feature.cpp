#include "polygon/projected_feature.hpp"

#include <cmath>
#include <limits>

#include "polygon/cross2.hpp"
#include "polygon/line_normal.hpp"

namespace quoin::geometry {
namespace {

/// The face around a vertex or an edge that faces most along `outward`.
int most_facing(const Solid& polyhedron, std::span<const int> faces, const Vector3& outward) {
  int best = faces.empty() ? 0 : faces[0];
  double greatest = -2.0;
  for (const int f : faces) {
    const double facing = polyhedron.face_normal(f).dot(outward);
    if (facing > greatest) {
      greatest = facing;
      best = f;
    }
  }
  return best;
}

void add_corner(const Solid& polyhedron, int v, int edge, const LocalPlane& local,
                ProjectedFeature& patch) {
  const Vec3 x = polyhedron.shape().vertex(v);
  patch.corners.push_back({v, edge, local.place(x), local.height(x)});
}

void set_slope(const Solid& polyhedron, const ContactPlane& plane, ProjectedFeature& patch) {
  patch.slope.setZero();
  if (patch.corners.size() < 3) return;
  const Vector3 normal = polyhedron.face_normal(patch.face);
  const double facing = normal.dot(plane.normal);
  if (std::abs(facing) < 1e-3) return;
  patch.slope = -Vector2(normal.dot(plane.axis_u), normal.dot(plane.axis_v)) / facing;
}

/// Signed distance of a place from the line through side k of a polygon, inside positive.
double inside(const ProjectedFeature& patch, std::size_t k, const Vector2& place) {
  const Vector2& a = patch.corners[k].place;
  const Vector2& b = patch.corners[(k + 1) % patch.corners.size()].place;
  const Vector2 side = b - a;
  const double length = side.norm();
  return length > 0.0 ? cross2(side, place - a) / length : 0.0;
}

double distance_to_segment(const Vector2& a, const Vector2& b, const Vector2& place) {
  const Vector2 side = b - a;
  const double squared = side.squaredNorm();
  const double t = squared > 0.0 ? std::clamp(side.dot(place - a) / squared, 0.0, 1.0) : 0.0;
  return (place - a - t * side).norm();
}

bool covers(const ProjectedFeature& patch, const Vector2& place, double rounding) {
  const std::size_t n = patch.corners.size();
  if (n == 1) return (place - patch.corners[0].place).norm() <= rounding;
  if (n == 2) {
    return distance_to_segment(patch.corners[0].place, patch.corners[1].place, place) <= rounding;
  }
  bool within = false;  // as in contact_polygon.cpp, is_beside
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < n; ++k) {
    const Vector2 &from = patch.corners[k].place, &to = patch.corners[(k + 1) % n].place;
    nearest = std::min(nearest, distance_to_segment(from, to, place));
    const bool rises = to.y() > place.y();
    if (rises != (from.y() > place.y())) within ^= (cross2(to - from, place - from) > 0.0) == rises;
  }
  return within || nearest <= kBesideBorder * rounding;
}

/// Height of a polygon over a place that it covers: a mean of its corners' heights, hence between
/// them, however badly the slope of a sliver is known.
double polygon_height(const ProjectedFeature& patch, const Vector2& place) {
  double low = patch.corners[0].height, high = low;
  for (const ProjectedCorner& c : patch.corners) {
    low = std::min(low, c.height);
    high = std::max(high, c.height);
  }
  return std::clamp(patch.surface_height(place), low, high);
}

/// Height of a patch over a place that it covers.
double height_at(const ProjectedFeature& patch, const Vector2& place) {
  if (patch.corners.size() != 2) return polygon_height(patch, place);
  const ProjectedCorner &a = patch.corners[0], &b = patch.corners[1];
  const Vector2 side = b.place - a.place;
  const double squared = side.squaredNorm();
  const double t = squared > 0.0 ? std::clamp(side.dot(place - a.place) / squared, 0.0, 1.0) : 0.0;
  return a.height + t * (b.height - a.height);
}

/// How far along a side a place on it lies, 0 to 1.
double share_along(const Vector2& from, const Vector2& to, const Vector2& place) {
  const Vector2 side = to - from;
  return std::clamp(side.dot(place - from) / side.squaredNorm(), 0.0, 1.0);
}

/// Where side i of P crosses side j of Q, `share` of the way along P's. Nearly parallel sides cross
/// in an ill-conditioned place: Q's height is taken there, not where its own crossing would be.
SharedCorner crossing_corner(const ProjectedFeature& p, std::size_t i, const ProjectedFeature& q,
                             std::size_t j, double share) {
  const ProjectedCorner &p0 = p.corners[i], &p1 = p.corners[i + 1 < p.corners.size() ? i + 1 : 0];
  const ProjectedCorner &q0 = q.corners[j], &q1 = q.corners[j + 1 < q.corners.size() ? j + 1 : 0];
  const Vector2 place = p0.place + share * (p1.place - p0.place);
  return {place,
          p0.height + share * (p1.height - p0.height),
          q0.height + share_along(q0.place, q1.place, place) * (q1.height - q0.height),
          {FeatureKind::Edge, p0.edge},
          {FeatureKind::Edge, q0.edge}};
}

struct Crossing {
  bool found = false;
  double share = 0.0;  // of the way along P's side
};

/// Do two sides cross in their inner parts, by more than rounding on each side?
Crossing crossing(const Vector2& p0, const Vector2& p1, const Vector2& q0, const Vector2& q1,
                  double rounding) {
  const Vector2 side_p = p1 - p0, side_q = q1 - q0;
  const double length_p = side_p.norm(), length_q = side_q.norm();
  const double a = cross2(side_q, p0 - q0), b = cross2(side_q, p1 - q0);
  const double c = cross2(side_p, q0 - p0), d = cross2(side_p, q1 - p0);
  const double slack_q = rounding * length_q, slack_p = rounding * length_p;
  const bool p_crosses = (a > slack_q && b < -slack_q) || (a < -slack_q && b > slack_q);
  const bool q_crosses = (c > slack_p && d < -slack_p) || (c < -slack_p && d > slack_p);
  if (!p_crosses || !q_crosses) return {};
  return {true, a / (a - b)};
}

void append_crossings(const ProjectedFeature& p, const ProjectedFeature& q, double rounding,
                      SharedCorners& corners) {
  const std::size_t sides_p = p.corners.size() == 2 ? 1 : p.corners.size();
  const std::size_t sides_q = q.corners.size() == 2 ? 1 : q.corners.size();
  for (std::size_t i = 0; i < sides_p; ++i) {
    const ProjectedCorner& p0 = p.corners[i];
    const ProjectedCorner& p1 = p.corners[(i + 1) % p.corners.size()];
    for (std::size_t j = 0; j < sides_q; ++j) {
      const ProjectedCorner& q0 = q.corners[j];
      const ProjectedCorner& q1 = q.corners[(j + 1) % q.corners.size()];
      const Crossing at = crossing(p0.place, p1.place, q0.place, q1.place, rounding);
      if (at.found) corners.push_back(crossing_corner(p, i, q, j, at.share));
    }
  }
}

bool lay_rows(const ProjectedFeature& patch, PolygonRows& rows) {
  if (patch.corners.size() > PolygonRows::kMost) return false;
  rows.count = patch.corners.count();
  rows.face = patch.face;
  for (int k = 0; k < rows.count; ++k) {
    const ProjectedCorner& c = patch.corners[static_cast<std::size_t>(k)];
    rows.x[k] = c.place.x();
    rows.y[k] = c.place.y();
    rows.height[k] = c.height;
    rows.vertex[k] = c.vertex;
    rows.edge[k] = c.edge;
  }
  rows.slope_x = patch.slope.x();
  rows.slope_y = patch.slope.y();
  find_sides(rows);
  return true;
}

SharedCorner corner_of_p(const ProjectedCorner& c, const ProjectedFeature& q) {
  return {c.place,
          c.height,
          height_at(q, c.place),
          {FeatureKind::Vertex, c.vertex},
          {FeatureKind::Face, q.face}};
}

SharedCorner corner_of_q(const ProjectedCorner& c, const ProjectedFeature& p) {
  return {c.place,
          height_at(p, c.place),
          c.height,
          {FeatureKind::Face, p.face},
          {FeatureKind::Vertex, c.vertex}};
}

void append_shared_of_any(const ProjectedFeature& p, const ProjectedFeature& q, double rounding,
                          SharedCorners& corners) {
  for (const ProjectedCorner& c : p.corners) {
    if (covers(q, c.place, rounding)) corners.push_back(corner_of_p(c, q));
  }
  for (const ProjectedCorner& c : q.corners) {
    if (covers(p, c.place, rounding)) corners.push_back(corner_of_q(c, p));
  }
  if (p.corners.size() > 1 && q.corners.size() > 1) append_crossings(p, q, rounding, corners);
}

}  // namespace

ContactPlane::ContactPlane(const Vector3& origin_in, const Vector3& normal_in)
    : origin(origin_in), normal(normal_in) {
  int k = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(normal[i]) < std::abs(normal[k])) k = i;
  }
  axis_u = normal.cross(Vector3::Unit(k)).normalized();
  axis_v = normal.cross(axis_u);
}

void lay_feature(const Solid& polyhedron, const Feature& feature, const ContactPlane& plane,
                 double outward, ProjectedFeature& patch) {
  const Topology& topology = polyhedron.topology();
  const LocalPlane local(polyhedron, plane);
  patch.corners.clear();
  patch.label = feature;
  const Vector3 facing = outward * plane.normal;
  if (feature.kind == FeatureKind::Vertex) {
    patch.face = most_facing(polyhedron, topology.vertex_faces(feature.index), facing);
    add_corner(polyhedron, feature.index, -1, local, patch);
  } else if (feature.kind == FeatureKind::Edge) {
    patch.face = most_facing(polyhedron, topology.edge_faces(feature.index), facing);
    for (const int v : topology.edge(feature.index)) {
      add_corner(polyhedron, v, feature.index, local, patch);
    }
  } else {
    patch.face = feature.index;
    const std::span<const int> cycle = topology.face(feature.index);
    const std::span<const int> edges = topology.face_edges(feature.index);
    const std::size_t n = cycle.size();
    for (std::size_t k = 0; k < n; ++k) {  // Q's faces look the other way: run backwards
      const std::size_t i = outward > 0.0 ? k : n - 1 - k;
      const std::size_t e = outward > 0.0 ? i : (i + n - 1) % n;
      add_corner(polyhedron, cycle[i], edges[e], local, patch);
    }
  }
  set_slope(polyhedron, plane, patch);
}

void append_shared_corners(const ProjectedFeature& p, const ProjectedFeature& q, double rounding,
                           SharedCorners& corners) {
  PolygonRows rows_p, rows_q;
  if (p.corners.size() > 2 && q.corners.size() > 2 && lay_rows(p, rows_p) && lay_rows(q, rows_q)) {
    append_shared_of_polygons(rows_p, rows_q, rounding, corners);
  } else {
    append_shared_of_any(p, q, rounding, corners);
  }
}

namespace {

/// How far the other patch reaches past either end of an edge, inwards: two edges of one line can
/// be apart along it alone.
double reach_along(const ProjectedFeature& edge, const ProjectedFeature& other) {
  const Vector2 &first = edge.corners[0].place, &last = edge.corners[1].place;
  const Vector2 direction = (last - first).normalized();
  double past_first = -std::numeric_limits<double>::infinity(), past_last = past_first;
  for (const ProjectedCorner& c : other.corners) {
    past_first = std::max(past_first, (c.place - first).dot(direction));
    past_last = std::max(past_last, (last - c.place).dot(direction));
  }
  return std::min(past_first, past_last);
}

/// Least over the sides of a patch (an edge has two) of how far the other reaches inside it.
double reach_inside(const ProjectedFeature& patch, const ProjectedFeature& other) {
  double least = std::numeric_limits<double>::infinity();
  if (patch.corners.size() < 2) return least;
  for (std::size_t k = 0; k < patch.corners.size(); ++k) {
    double farthest = -std::numeric_limits<double>::infinity();
    for (const ProjectedCorner& c : other.corners) {
      farthest = std::max(farthest, inside(patch, k, c.place));
    }
    least = std::min(least, farthest);
  }
  return patch.corners.size() == 2 ? std::min(least, reach_along(patch, other)) : least;
}

}  // namespace

double overlap_margin(const ProjectedFeature& p, const ProjectedFeature& q) {
  if (p.corners.size() == 1 && q.corners.size() == 1) {
    return -(p.corners[0].place - q.corners[0].place).norm();
  }
  return std::min(reach_inside(p, q), reach_inside(q, p));
}

Vector2 nearest_place(const ProjectedFeature& p, const ProjectedFeature& q) {
  Vector2 best = p.corners[0].place;
  double least = std::numeric_limits<double>::infinity();
  const auto outside = [](const ProjectedFeature& patch, const Vector2& place) {
    if (patch.corners.size() == 1) return (place - patch.corners[0].place).norm();
    if (patch.corners.size() == 2) {
      return distance_to_segment(patch.corners[0].place, patch.corners[1].place, place);
    }
    double worst = 0.0;
    for (std::size_t k = 0; k < patch.corners.size(); ++k) {
      worst = std::max(worst, -inside(patch, k, place));
    }
    return worst;
  };
  for (const ProjectedCorner& c : p.corners) {
    const double distance = outside(q, c.place);
    if (distance < least) {
      least = distance;
      best = c.place;
    }
  }
  for (const ProjectedCorner& c : q.corners) {
    const double distance = outside(p, c.place);
    if (distance < least) {
      least = distance;
      best = c.place;
    }
  }
  return best;
}

namespace {

/// Are the vertices of a feature just these?
bool has_just(const Topology& topology, const Feature& feature, const VertexSet& vertices) {
  const auto are = [&](std::span<const int> set) {
    return set.size() == vertices.size() &&
           std::all_of(set.begin(), set.end(), [&](int v) { return vertices.contains(v); });
  };
  if (feature.kind == FeatureKind::Face) return are(topology.face_set(feature.index));
  if (feature.kind == FeatureKind::Edge) return are(topology.edge(feature.index));
  return are({&feature.index, 1});
}

}  // namespace

void lay_support_polygon(const Solid& polyhedron, const VertexSet& vertices,
                         const ContactPlane& plane, double outward, ProjectedFeature& patch) {
  const Topology& topology = polyhedron.topology();
  patch.label = name_support_set(polyhedron, vertices, FeatureKind::Face, outward * plane.normal);
  patch.face = patch.label.index;
  const std::size_t corners = topology.face(patch.face).size();
  if (corners == vertices.size() && polyhedron.shape().is_convex(patch.face) &&
      has_just(topology, patch.label, vertices)) {
    return lay_feature(polyhedron, patch.label, plane, outward, patch);
  }
  SmallVector<int, 32> order;
  SmallVector<Vector2, 32> places;
  const LocalPlane local(polyhedron, plane);
  for (const int v : vertices) places.push_back(local.place(polyhedron.shape().vertex(v)));
  hull_order(places, order);
  patch.corners.clear();
  for (std::size_t k = 0; k < order.size(); ++k) {
    const int v = vertices[static_cast<std::size_t>(order[k])];
    const int w = vertices[static_cast<std::size_t>(order[(k + 1) % order.size()])];
    add_corner(polyhedron, v, topology.find_edge(v, w), local, patch);
  }
  set_slope(polyhedron, plane, patch);
}

void lay_support_set(const Solid& polyhedron, const VertexSet& vertices, FeatureKind kind,
                     const ContactPlane& plane, double outward, ProjectedFeature& patch) {
  if (kind == FeatureKind::Edge && vertices.size() == 2) {
    const int edge = polyhedron.topology().find_edge(vertices[0], vertices[1]);
    const bool whole = edge >= 0 && has_just(polyhedron.topology(), {kind, edge}, vertices);
    if (whole) return lay_feature(polyhedron, {kind, edge}, plane, outward, patch);
  }
  const Feature name = name_support_set(polyhedron, vertices, kind, outward * plane.normal);
  if (name.kind == kind && has_just(polyhedron.topology(), name, vertices)) {
    return lay_feature(polyhedron, name, plane, outward, patch);
  }
  if (kind == FeatureKind::Face) {
    return lay_support_polygon(polyhedron, vertices, plane, outward, patch);
  }
  patch.corners.clear();
  patch.label = name;
  if (kind == FeatureKind::Vertex) {
    return lay_feature(polyhedron, {FeatureKind::Vertex, vertices[0]}, plane, outward, patch);
  }
  const std::array<int, 2> ends = segment_ends(polyhedron, vertices);
  const int edge = polyhedron.topology().find_edge(ends[0], ends[1]);
  patch.face =
      most_facing(polyhedron, polyhedron.topology().vertex_faces(ends[0]), outward * plane.normal);
  const LocalPlane local(polyhedron, plane);
  for (const int v : ends) add_corner(polyhedron, v, edge, local, patch);
  set_slope(polyhedron, plane, patch);
}

void lay_top(const Solid& polyhedron, int face, const ContactPlane& plane, double outward,
             double depth, ProjectedFeature& patch) {
  const LocalPlane local(polyhedron, plane);
  SmallVector<ProjectedCorner, 32> vertices, tops;
  double top = -std::numeric_limits<double>::infinity();
  for (int v = 0; v < polyhedron.vertex_count(); ++v) {
    const Vec3 x = polyhedron.shape().vertex(v);
    vertices.push_back({v, -1, local.place(x), local.height(x)});
    top = std::max(top, outward * vertices[static_cast<std::size_t>(v)].height);
  }
  const auto below = [&](const ProjectedCorner& c) { return top - outward * c.height - depth; };
  for (const ProjectedCorner& c : vertices) {
    if (below(c) <= 0.0) tops.push_back(c);
  }
  for (const std::array<int, 3>& t : polyhedron.topology().triangles()) {
    for (std::size_t k = 0; k < 3; ++k) {
      const ProjectedCorner& c = vertices[static_cast<std::size_t>(t[k])];
      const ProjectedCorner& d = vertices[static_cast<std::size_t>(t[(k + 1) % 3])];
      const double here = below(c), there = below(d);
      if (!(here <= 0.0 && there > 0.0)) continue;
      const double share = here / (here - there);
      tops.push_back({-1, -1, c.place + share * (d.place - c.place),
                      c.height + share * (d.height - c.height)});
    }
  }
  SmallVector<Vector2, 32> places;
  for (const ProjectedCorner& c : tops) places.push_back(c.place);
  SmallVector<int, 32> order;
  hull_order(places, order);
  patch = {};
  patch.label = {FeatureKind::Face, face};
  patch.face = face;
  for (const int k : order) patch.corners.push_back(tops[static_cast<std::size_t>(k)]);
}

std::array<int, 2> segment_ends(const Solid& polyhedron, const VertexSet& vertices) {
  std::array<int, 2> ends{vertices[0], vertices[vertices.size() - 1]};
  if (vertices.size() <= 2) return ends;
  DoubleDouble longest = -1.0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t j = i + 1; j < vertices.size(); ++j) {
      const WideVector line =
          wide_difference(polyhedron.vertex(vertices[i]), polyhedron.vertex(vertices[j]));
      const DoubleDouble length = dot(line, line);
      if (!(longest < length)) continue;
      longest = length;
      ends = {vertices[i], vertices[j]};
    }
  }
  return ends;
}

namespace {

/// The place farthest from the first one.
const Vector3& farthest(std::span<const Vector3> places) {
  const Vector3* far = &places[0];
  double longest = 0.0;
  for (const Vector3& place : places) {
    const double length = (place - places[0]).squaredNorm();
    if (length <= longest) continue;
    longest = length;
    far = &place;
  }
  return *far;
}

/// How far places reach to the side of the line through two of them.
double reach_aside(std::span<const Vector3> places, const Vector3& from, const Vector3& to) {
  const Vector3 line = to - from;
  double most = 0.0;
  for (const Vector3& place : places) {
    most = std::max(most, line.cross(place - from).squaredNorm());
  }
  return std::sqrt(most / line.squaredNorm());
}

}  // namespace

FeatureKind span_kind(const Solid& polyhedron, const VertexSet& vertices, double tolerance) {
  if (vertices.size() == 1) return FeatureKind::Vertex;
  if (vertices.size() == 2) {
    const Vector3 line = polyhedron.vertex(vertices[1]) - polyhedron.vertex(vertices[0]);
    return line.norm() <= tolerance ? FeatureKind::Vertex : FeatureKind::Edge;
  }
  // A set reaches at most twice its width to the side of its longest line, and of a line of at
  // least half that length, as this one is, four times.
  SmallVector<Vector3, 32> places;
  for (const int v : vertices) places.push_back(polyhedron.vertex(v));
  const Vector3& far = farthest(places);
  if (&far != &places[0] && reach_aside(places, places[0], far) > 4.0 * tolerance) {
    return FeatureKind::Face;
  }
  const std::array<int, 2> ends = segment_ends(polyhedron, vertices);
  const Vector3 from = polyhedron.vertex(ends[0]), to = polyhedron.vertex(ends[1]);
  if ((to - from).norm() <= tolerance) return FeatureKind::Vertex;
  const bool wide = reach_aside(places, from, to) > tolerance;
  return wide ? FeatureKind::Face : FeatureKind::Edge;
}

namespace {

/// The face around the first vertex that has all vertices of the set, or -1: no face can have more.
int face_with_all(const Solid& polyhedron, const VertexSet& vertices, const Vector3& outward) {
  const Topology& topology = polyhedron.topology();
  int best = -1;
  double facing = -2.0;
  for (const int f : topology.vertex_faces(vertices[0])) {
    const std::span<const int> cycle = topology.face_set(f);
    if (cycle.size() < vertices.size()) continue;
    std::size_t members = 0;
    for (const int w : cycle) members += vertices.contains(w) ? 1 : 0;
    if (members != vertices.size()) continue;
    const double along = polyhedron.face_normal(f).dot(outward);
    if (along > facing) {
      facing = along;
      best = f;
    }
  }
  return best;
}

}  // namespace

Feature name_support_set(const Solid& polyhedron, const VertexSet& vertices, FeatureKind kind,
                         const Vector3& outward) {
  const Topology& topology = polyhedron.topology();
  if (kind == FeatureKind::Vertex) return {kind, vertices[0]};
  if (kind == FeatureKind::Edge) {
    const std::array<int, 2> ends = segment_ends(polyhedron, vertices);
    const int edge = topology.find_edge(ends[0], ends[1]);
    if (edge >= 0) return {kind, edge};
  }
  if (const int f = face_with_all(polyhedron, vertices, outward); f >= 0) {
    return {FeatureKind::Face, f};
  }
  Feature best{FeatureKind::Vertex, vertices[0]};
  std::size_t most = 0;
  double facing = -2.0;
  for (const int v : vertices) {
    for (const int f : topology.vertex_faces(v)) {
      std::size_t members = 0;
      for (const int w : topology.face_set(f)) members += vertices.contains(w) ? 1 : 0;
      const double along = polyhedron.face_normal(f).dot(outward);
      if (members < most || (members == most && along <= facing)) continue;
      most = members;
      facing = along;
      best = {FeatureKind::Face, f};
    }
  }
  return best;
}

ContactType type_of(const Solid& p, const Solid& q, const VertexSet& set_p, const VertexSet& set_q,
                    FeatureKind kind_p, FeatureKind kind_q, double tolerance) {
  const auto [low, high] = std::minmax(kind_p, kind_q);
  if (low == FeatureKind::Vertex) {
    if (high == FeatureKind::Vertex) return ContactType::VertexVertex;
    return high == FeatureKind::Edge ? ContactType::VertexEdge : ContactType::VertexFace;
  }
  if (low == FeatureKind::Face) return ContactType::FaceFace;
  if (high == FeatureKind::Face) return ContactType::EdgeFace;
  const std::array<int, 2> e = segment_ends(p, set_p), f = segment_ends(q, set_q);
  return parallel(Side(p, e[0], e[1]), Side(q, f[0], f[1]), tolerance)
             ? ContactType::EdgeEdgeParallel
             : ContactType::EdgeEdgeCrossing;
}

}  // namespace quoin::geometry
