#include "polygon/projected_feature.hpp"

#include <cmath>
#include <limits>

#include "polygon/line_normal.hpp"

namespace quoin::geometry {
namespace {

inline void add_corner(const Solid& polyhedron, int v, int edge, const LocalPlane& local,
                       ProjectedFeature& patch) {
  const double* x = polyhedron.shape().vertices().data() + 3 * v;
  const Vec3 vertex(x[0], x[1], x[2]);
  const Vector2 place = local.place(vertex);
  const double height = local.height(vertex);
  patch.corners.add() = {v, edge, place, height};
}

void set_slope(const Solid& polyhedron, const ContactPlane& plane, ProjectedFeature& patch) {
  patch.slope.setZero();
  if (patch.corners.size() < 3) return;
  const Vector3 normal = polyhedron.face_normal(patch.face);
  const double facing = normal.dot(plane.normal);
  if (std::abs(facing) < 1e-3) return;
  patch.slope = -Vector2(normal.dot(plane.axis_u), normal.dot(plane.axis_v)) / facing;
}

}  // namespace

ContactPlane::ContactPlane(const Vector3& origin_in, const Vector3& normal_in)
    : origin(origin_in), normal(normal_in) {
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(normal[i]) < std::abs(normal[k])) k = i;
  axis_u = normal.cross(Vector3::Unit(k)).normalized();
  axis_v = normal.cross(axis_u);
}

int facing_face(const Solid& polyhedron, std::span<const int> faces, const Vector3& direction) {
  int best = -1;
  double greatest = -kInfinity;
  for (const int f : faces) {
    const double facing = polyhedron.face_normal(f).dot(direction);
    best = facing > greatest ? f : best;
    greatest = std::max(greatest, facing);
  }
  return best;
}

void lay_feature(const Solid& polyhedron, const Feature& feature, const ContactPlane& plane,
                 double outward, ProjectedFeature& patch) {
  const Topology& topology = polyhedron.topology();
  const LocalPlane local(polyhedron, plane);
  patch.corners.clear();
  patch.label = feature;
  const Vector3 facing = outward * plane.normal;
  if (feature.kind == FeatureKind::Vertex) {
    patch.face = facing_face(polyhedron, topology.vertex_faces(feature.index), facing);
    add_corner(polyhedron, feature.index, -1, local, patch);
  } else if (feature.kind == FeatureKind::Edge) {
    patch.face = facing_face(polyhedron, topology.edge_faces(feature.index), facing);
    for (const int v : topology.edge(feature.index))
      add_corner(polyhedron, v, feature.index, local, patch);
  } else {
    patch.face = feature.index;
    const std::span<const int> cycle = topology.face(feature.index);
    const std::span<const int> edges = topology.face_edges(feature.index);
    const std::size_t n = cycle.size();
    for (std::size_t k = 0; k < n; ++k) {  // Q's faces look the other way: run backwards
      const std::size_t i = outward > 0.0 ? k : n - 1 - k;
      const std::size_t e = outward > 0.0 ? i : (i > 0 ? i : n) - 1;
      add_corner(polyhedron, cycle[i], edges[e], local, patch);
    }
  }
  set_slope(polyhedron, plane, patch);
}

bool is_flat(const ProjectedFeature& patch, double rounding) {
  return patch.corners.size() < 3 ||
         std::all_of(patch.corners.begin(), patch.corners.end(), [&](const ProjectedCorner& c) {
           return std::abs(c.height - patch.surface_height(c.place)) <= rounding;
         });
}

bool is_just(const Solid& polyhedron, const Feature& feature, const VertexSet& vertices) {
  const Topology& topology = polyhedron.topology();
  const auto are = [&](std::span<const int> set) {
    return std::is_permutation(set.begin(), set.end(), vertices.begin(), vertices.end());
  };
  if (feature.kind == FeatureKind::Face) {
    const std::span<const int> set = topology.face_set(feature.index);
    return topology.face(feature.index).size() == vertices.size() &&
           polyhedron.shape().label_fit(feature.index).outside < kInfinity &&
           std::equal(set.begin(), set.end(), vertices.begin(), vertices.end());
  }
  if (feature.kind == FeatureKind::Edge) return are(topology.edge(feature.index));
  return are({&feature.index, 1});
}

namespace {

/// Lays the hull of a support set that spans a polygon into the plane.
void lay_support_polygon(const Solid& polyhedron, const VertexSet& vertices,
                         const ContactPlane& plane, double outward, ProjectedFeature& patch) {
  const Topology& topology = polyhedron.topology();
  patch.label = name_support_set(polyhedron, vertices, FeatureKind::Face, outward * plane.normal);
  patch.face = patch.label.index;
  if (is_just(polyhedron, patch.label, vertices))
    return lay_feature(polyhedron, patch.label, plane, outward, patch);
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

}  // namespace

void lay_support_set(const Solid& polyhedron, const VertexSet& vertices, FeatureKind kind,
                     const ContactPlane& plane, double outward, ProjectedFeature& patch) {
  if (kind == FeatureKind::Face)
    return lay_support_polygon(polyhedron, vertices, plane, outward, patch);
  const Feature name = name_support_set(polyhedron, vertices, kind, outward * plane.normal);
  if (name.kind == kind && is_just(polyhedron, name, vertices))
    return lay_feature(polyhedron, name, plane, outward, patch);
  patch.corners.clear();
  patch.label = name;
  if (kind == FeatureKind::Vertex)
    return lay_feature(polyhedron, {FeatureKind::Vertex, vertices[0]}, plane, outward, patch);
  const std::array<int, 2> ends = segment_ends(polyhedron, vertices);
  const int edge = polyhedron.topology().find_edge(ends[0], ends[1]);
  patch.face =
      facing_face(polyhedron, polyhedron.topology().vertex_faces(ends[0]), outward * plane.normal);
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
  for (const ProjectedCorner& c : vertices)
    if (below(c) <= 0.0) tops.push_back(c);
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
  for (const Vector3& place : places) most = std::max(most, line.cross(place - from).squaredNorm());
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
  if (&far != &places[0] && reach_aside(places, places[0], far) > 4.0 * tolerance)
    return FeatureKind::Face;
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
    if (!std::includes(cycle.begin(), cycle.end(), vertices.begin(), vertices.end())) continue;
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
  if (const int f = face_with_all(polyhedron, vertices, outward); f >= 0)
    return {FeatureKind::Face, f};
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
