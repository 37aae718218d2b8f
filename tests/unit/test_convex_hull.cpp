/// The exact hull: every point on or below every triangle, exactly, whatever the points are.

#include "geometry/src/shape/convex_hull.hpp"

#include <algorithm>
#include <quoin/geometry/build.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using quoin::tests::Random;

/// Closed, oriented, and no point strictly outside any triangle.
void check_hull(const Points& points) {
  const HullTriangles hull = hull_triangles(points);
  REQUIRE(hull.dimension == 3);
  std::vector<std::array<int, 2>> sides;
  for (const std::array<int, 3>& t : hull.triangles) {
    for (int i = 0; i < points.cols(); ++i) {
      REQUIRE(orientation(points.col(t[0]), points.col(t[1]), points.col(t[2]), points.col(i)) <=
              0);
    }
    for (std::size_t k = 0; k < 3; ++k) sides.push_back({t[k], t[(k + 1) % 3]});
  }
  std::sort(sides.begin(), sides.end());
  CHECK(std::adjacent_find(sides.begin(), sides.end()) == sides.end());
  for (const std::array<int, 2>& side : sides)
    CHECK(std::binary_search(sides.begin(), sides.end(), std::array<int, 2>{side[1], side[0]}));
}

}  // namespace

TEST_CASE("hull: orientation is exact where doubles see nothing") {
  const Vector3 p(0, 0, 0), q(1, 0, 0), r(0, 1, 0);
  CHECK(orientation(p, q, r, Vector3(0.3, 0.3, 0x1p-1000)) == 1);
  CHECK(orientation(p, q, r, Vector3(0.3, 0.3, -0x1p-1000)) == -1);
  CHECK(orientation(p, q, r, Vector3(1e8, -1e8, 0)) == 0);
  // One unit in the last place beside the plane x + y + z = 1.5 far from the origin.
  const Vector3 far(1e8, 1e8, 1e8), a(0.5, 0.5, 0.5);
  const Vector3 b = far + Vector3(1, 0, -1), c = far + Vector3(-1, 1, 0), d = far;
  CHECK(orientation(d, b, c, far + Vector3(0, -1, 1)) == 0);
  CHECK(orientation(d, b, c, far + Vector3(0, -1, 1 + 0x1p-26)) == 1);
  CHECK(collinear(p, a, Vector3(1.5, 1.5, 1.5)));
  CHECK_FALSE(collinear(p, a, Vector3(1.5, 1.5, 1.5 + 0x1p-52)));
}

TEST_CASE("hull: random, gridded, cospherical, flat and far points") {
  Random random(31);
  for (int round = 0; round < 200; ++round) {
    const int count = random.integer(4, 60);
    Points points(3, count);
    const int kind = round % 5;
    for (int i = 0; i < count; ++i) {
      Vector3 x = random.point(-1, 1);
      if (kind == 1) x = Vector3((x * 2).array().round());             // many coplanar, collinear
      if (kind == 2) x.normalize();                                    // cospherical
      if (kind == 3) x.z() *= 1e-13;                                   // nearly flat
      if (kind == 4) x = (x * 1e-7 + Vector3(1e8, 2e8, -3e8)).eval();  // a few steps of a double
      points.col(i) = x;
    }
    if (hull_triangles(points).dimension == 3) check_hull(points);
  }
}

TEST_CASE("hull: what is no corner is left out, what is one stays") {
  Points points(3, 11);
  points << 0, 1, 0, 1, 0, 1, 0, 1, 0.5, 0.5, 0.5,  // a cube,
      0, 0, 1, 1, 0, 0, 1, 1, 0.5, 0.0, 0.5,        // the middle of a face, of an edge,
      0, 0, 0, 0, 1, 1, 1, 1, 0.0, 0.0, 0.5;        // and of the solid
  const quoin::geometry::Hull cube = make_hull(points);
  CHECK(cube.input_index == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7});
  CHECK(cube.polyhedron.topology().face_count() == 6);
  CHECK(cube.polyhedron.topology().edge_count() == 12);
  points(2, 8) = -1e-12;  // stays, though no label shows it
  const quoin::geometry::Hull bumped = make_hull(points);
  CHECK(bumped.input_index.size() == 9);
  const quoin::geometry::Topology& labels = bumped.polyhedron.topology();
  CHECK(labels.face_count() == 6);
  CHECK(labels.host(8).kind == quoin::geometry::FeatureKind::Face);
  CHECK(labels.face_set(labels.host(8).index).size() == 5);
  points(2, 8) = -1e-6;  // a corner of its own
  CHECK(make_hull(points).polyhedron.topology().vertex_faces(8).size() == 4);
}
