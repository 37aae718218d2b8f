#include "certify/feature_normal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polygon/line_normal.hpp"

namespace quoin::geometry {
namespace {

/// Normal of three vertices, on the side of `guess`.
Vector3 triangle_normal(const Solid& owner, const VertexSet& set) {
  return Vector3(accurate_cross(Side(owner, set[0], set[1]), Side(owner, set[0], set[2])))
      .normalized();
}

FeatureNormal closed(const LineNormal& form) {
  const double across = form.crossed ? form.reach_across() : 0.0;
  return {form.found, form.normal, form.joined, form.crossed, form.share_p, form.from_ends, across};
}

}  // namespace

int covered_face(const Solid& polyhedron, const VertexSet& set, const Vector3& outward) {
  const Topology& topology = polyhedron.topology();
  if (set.size() < 3) return -1;
  int best = -1;
  double greatest = 0.5;
  for (const int v : set) {  // a face that is covered may miss at most the vertices of the others
    for (const int f : topology.vertex_faces(v)) {
      const double facing = polyhedron.face_normal(f).dot(outward);
      if (facing <= greatest) continue;
      const std::span<const int> cycle = topology.face_set(f);
      if (cycle.size() > set.size()) continue;
      if (!std::all_of(cycle.begin(), cycle.end(), [&](int w) { return set.contains(w); }))
        continue;
      if (cycle.size() == set.size()) return f;
      greatest = facing;
      best = f;
    }
  }
  return best;
}

int common_face(const Topology& topology, std::span<const int> vertices) {
  if (vertices.size() < 3) return -1;
  const int edge = topology.find_edge(vertices[0], vertices[1]);  // most often there is one
  const std::span<const int> faces =
      edge >= 0 ? topology.edge_faces(edge) : topology.vertex_faces(vertices[0]);
  for (const int f : faces) {
    const std::span<const int> cycle = topology.face_set(f);
    const auto in_cycle = [&](int v) {
      return std::find(cycle.begin(), cycle.end(), v) != cycle.end();
    };
    if (std::all_of(vertices.begin(), vertices.end(), in_cycle)) return f;
  }
  return -1;
}

FeatureNormal feature_normal(const Solid& p, const Solid& q, const ContactSets& sets,
                             const Vector3& guess, double rounding) {
  FeatureNormal form;
  const std::size_t count_p = sets.p.size(), count_q = sets.q.size();
  if (sets.face_p >= 0 || sets.face_q >= 0) {
    // Two faces: the larger one's plane is the better known.
    const bool by_p = sets.face_q < 0 || (sets.face_p >= 0 && p.diameter() >= q.diameter());
    form.normal = by_p ? p.face_normal(sets.face_p) : Vector3(-q.face_normal(sets.face_q));
    form.found = true;
  } else if (count_p == 1 && count_q == 1) {
    form = closed(line_normal(place(q, sets.q[0]) - place(p, sets.p[0]), true));
  } else if (count_p == 1 && count_q == 2) {
    form = closed(vertex_edge<false>(place(p, sets.p[0]), Side(q, sets.q[0], sets.q[1])));
  } else if (count_p == 2 && count_q == 1) {
    form = closed(reversed(vertex_edge<false>(place(q, sets.q[0]), Side(p, sets.p[0], sets.p[1]))));
  } else if (count_p == 2 && count_q == 2) {
    form = closed(
        edge_edge<false>(Side(p, sets.p[0], sets.p[1]), Side(q, sets.q[0], sets.q[1]), rounding));
  } else if (count_p == 3 && count_q <= 2) {
    form.normal = triangle_normal(p, sets.p);
    form.found = form.normal.allFinite();
  } else if (count_q == 3 && count_p <= 2) {
    form.normal = triangle_normal(q, sets.q);
    form.found = form.normal.allFinite();
  }
  if (form.normal.dot(guess) < 0.0) form.normal = -form.normal;
  return form;
}

Vec3 wide_cross(Side e, Side f) { return cross(e.wide(), f.wide()).rounded(); }

}  // namespace quoin::geometry
