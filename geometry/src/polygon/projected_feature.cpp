#include "polygon/projected_feature.hpp"

#include <cmath>
#include <limits>

#include "polygon/line_normal.hpp"

namespace quoin::geometry {
namespace {

inline ProjectedCorner laid(const Solid& polyhedron, int v, int edge, const LocalPlane& local) {
  const double* x = polyhedron.shape().vertices().data() + 3 * v;
  const Vec3 vertex(x[0], x[1], x[2]);
  return {v, edge, local.place(vertex), local.height(vertex)};
}

void set_slope(const Solid& polyhedron, const LocalPlane& local, const ContactPlane& plane,
               ProjectedFeature& patch) {
  patch.slope.setZero();
  if (patch.corners.size() < 3) return;
  const auto set = [&](const Vec3& face, const Vec3& u, const Vec3& v, const Vec3& normal) {
    const double facing = dot(face, normal);
    if (std::abs(facing) >= 1e-3) patch.slope = {-dot(face, u) / facing, -dot(face, v) / facing};
  };
  if (polyhedron.is_rigid())
    set(polyhedron.shape().face_normal(patch.face), local.axis_u, local.axis_v, local.normal);
  else
    set(polyhedron.face_normal(patch.face), plane.axis_u, plane.axis_v, plane.normal);
}

}  // namespace

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
    patch.corners.push_back(laid(polyhedron, feature.index, -1, local));
  } else if (feature.kind == FeatureKind::Edge) {
    patch.face = facing_face(polyhedron, topology.edge_faces(feature.index), facing);
    for (const int v : topology.edge(feature.index))
      patch.corners.push_back(laid(polyhedron, v, feature.index, local));
  } else {
    patch.face = feature.index;
    const std::span<const int> cycle = topology.face(feature.index);
    const std::span<const int> edges = topology.face_edges(feature.index);
    const std::size_t n = cycle.size();
    patch.corners.resize(n);
    ProjectedCorner* corner = patch.corners.begin();
    if (outward > 0.0) {
      for (std::size_t k = 0; k < n; ++k) *corner++ = laid(polyhedron, cycle[k], edges[k], local);
    } else {  // Q's faces look the other way: run backwards
      for (std::size_t k = n; k-- > 0;)
        *corner++ = laid(polyhedron, cycle[k], edges[(k > 0 ? k : n) - 1], local);
    }
  }
  set_slope(polyhedron, local, plane, patch);
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
    patch.corners.push_back(laid(polyhedron, v, topology.find_edge(v, w), local));
  }
  set_slope(polyhedron, local, plane, patch);
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
  for (const int v : ends) patch.corners.push_back(laid(polyhedron, v, edge, local));
  set_slope(polyhedron, local, plane, patch);
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

bool is_wide(const Solid& polyhedron, int face, double tolerance) {
  // Of a strip around the longest line that holds the set no less than half reaches to one side.
  if (polyhedron.is_rigid() && polyhedron.shape().label_fit(face).width > 2.001 * tolerance)
    return true;
  VertexSet vertices;
  vertices.assign(polyhedron.topology().face_set(face));
  return span_kind(polyhedron, vertices, tolerance) == FeatureKind::Face;
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
