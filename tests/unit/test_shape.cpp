/// Topology, and what a polyhedron derives from its vertices.

#include <algorithm>
#include <quoin/geometry/build.hpp>

#include "referee/pairs/families.hpp"
#include "support/catch.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;
using namespace quoin::referee;

}  // namespace

TEST_CASE("topology: edges, faces and neighbours of a box agree") {
  const Shape box = make_box({0, 0, 0}, {1, 1, 1});
  const Topology& topology = box.topology();
  CHECK(topology.vertex_count() == 8);
  CHECK(topology.edge_count() == 12);
  CHECK(topology.face_count() == 6);
  for (int f = 0; f < topology.face_count(); ++f) {
    const std::span<const int> cycle = topology.face(f), edges = topology.face_edges(f);
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const int v = cycle[k], w = cycle[(k + 1) % cycle.size()];
      CHECK(topology.find_edge(v, w) == edges[k]);
      CHECK(topology.find_edge(w, v) == edges[k]);
      const std::array<int, 2>& pair = topology.edge_faces(edges[k]);
      CHECK((pair[0] == f || pair[1] == f));
      CHECK((pair[0] == f) == (v < w));  // the first face runs along the edge from first to second
    }
  }
  for (int v = 0; v < 8; ++v) {
    CHECK(topology.neighbours(v).size() == 3);
    CHECK(topology.vertex_faces(v).size() == 3);
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(topology.find_edge(v, topology.neighbours(v)[k]) == topology.vertex_edges(v)[k]);
  }
  CHECK(topology.find_edge(0, 7) == -1);
}

TEST_CASE("topology: a face's vertices in ascending order, and the face across each of its edges") {
  const Shape box = make_box({0, 0, 0}, {1, 1, 1});
  const Topology& topology = box.topology();
  for (int f = 0; f < 6; ++f) {
    const std::span<const int> face = topology.face(f), set = topology.face_set(f);
    CHECK(std::is_permutation(face.begin(), face.end(), set.begin(), set.end()));
    CHECK(std::is_sorted(set.begin(), set.end()));
    for (std::size_t k = 0; k < face.size(); ++k) {
      const auto [left, right] = topology.edge_faces(topology.face_edges(f)[k]);
      CHECK(topology.face_neighbours(f)[k] == (left == f ? right : left));
    }
  }
  CHECK(topology.three_faces_at_vertices());
  CHECK(!Topology(5, {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}})
             .three_faces_at_vertices());
}

TEST_CASE("topology: edges are found between few vertices and between many") {
  Random random(9);
  for (const int count : {4, 64, 65, 100}) {
    Points points(3, count);
    for (int k = 0; k < count; ++k) points.col(k) = random.direction();
    const Shape solid = make_hull(points).polyhedron;
    const Topology& topology = solid.topology();
    REQUIRE(topology.vertex_count() == count);
    int found = 0;
    for (int v = 0; v < count; ++v) {
      for (int w = 0; w < count; ++w) {
        const int edge = topology.find_edge(v, w);
        found += edge >= 0 ? 1 : 0;
        if (edge >= 0) CHECK(topology.edge(edge) == std::array{std::min(v, w), std::max(v, w)});
      }
    }
    CHECK(found == 2 * topology.edge_count());
  }
}

TEST_CASE("topology: an open surface is refused and the edge named") {
  CHECK_THROWS_WITH(Topology(4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}}), ContainsSubstring("edge 0-2"));
}

TEST_CASE("polyhedron: normals, diameter and box follow the vertices") {
  Random random(8);
  const Shape box = make_box({-1, -2, -3}, {1, 2, 3});
  const Matrix3 turn = random.rotation();
  const Shape turned = transformed(box, 1.0, turn, {7, 8, 9});
  CHECK_THAT(turned.diameter(), WithinRel(2.0 * std::sqrt(14.0), 1e-14));
  CHECK_THAT((turned.vertex_mean() - Vector3(7, 8, 9)).norm(), WithinAbs(0.0, 1e-14));
  for (int f = 0; f < 6; ++f)
    CHECK_THAT((turned.face_normal(f) - turn * box.face_normal(f)).norm(), WithinAbs(0.0, 1e-15));
  for (int v = 0; v < 8; ++v) {
    CHECK((turned.vertex(v).array() >= turned.box().min.array()).all());
    CHECK((turned.vertex(v).array() <= turned.box().max.array()).all());
  }
}

TEST_CASE("polyhedron: the normal of a sliver is right to the last places") {
  Points points(3, 4);  // a triangle 1 long and 1e-7 wide, nearly collinear from its first vertex
  points << 0, 1, 0.5, 0.5, 0, 1, 0.5 + 1e-7, 0.5, 0, 0, 0, -1;
  const Shape solid = make_hull(points).polyhedron;
  double best = 0.0;
  for (int f = 0; f < solid.topology().face_count(); ++f)
    best = std::max(best, solid.face_normal(f).z());
  CHECK(best == 1.0);
}
