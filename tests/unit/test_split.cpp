#include <algorithm>
#include <cmath>
#include <limits>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/split.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

double volume(const std::optional<SplitPart>& part) {
  return part ? mass_properties(part->shape).volume : 0.0;
}

Shape turned(const Shape& shape, const Matrix3& turn, const Vector3& shift) {
  const Points places = (turn * shape.vertices()).colwise() + shift;
  return make_hull(places).polyhedron;
}

bool has_vertex(const Shape& shape, const Vector3& place) {
  for (int v = 0; v < shape.vertex_count(); ++v)
    if (shape.vertex(v) == place) return true;
  return false;
}

/// Everything that is promised of a split.
void check_split(const Shape& shape, const Plane& plane) {
  const Split parts = split(shape, plane);
  const double whole = mass_properties(shape).volume, size = shape.diameter();
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * shape.largest_coordinate();
  CHECK_THAT(volume(parts.below) + volume(parts.above),
             WithinAbs(whole, 1e-12 * whole + 6 * size * size * rounding));
  if (parts.below && parts.above) {
    for (const auto* part : {&*parts.below, &*parts.above}) {
      const auto& other = (part == &*parts.below ? parts.above : parts.below)->shape;
      for (int v = 0; v < part->shape.vertex_count(); ++v) {
        const Vector3 place = part->shape.vertex(v);
        if (!has_vertex(shape, place)) CHECK(has_vertex(other, place));
      }
    }
  }
  for (const auto& part : {parts.below, parts.above}) {
    if (!part) continue;
    const Topology& topology = part->shape.topology();
    REQUIRE(static_cast<int>(part->old_faces.size()) == topology.face_count());
    for (int f = 0; f < topology.face_count(); ++f) {
      const int old = part->old_faces[static_cast<std::size_t>(f)];
      Vector3 normal = old < 0 ? plane.normal.normalized() : shape.face_normal(old);
      if (old < 0 && part->shape.face_normal(f).dot(normal) < 0.0) normal = -normal;
      double least = std::numeric_limits<double>::infinity();  // slivers have vague normals
      for (const int e : topology.face_edges(f)) {
        const auto [v, w] = topology.edge(e);
        least = std::min(least, (part->shape.vertex(v) - part->shape.vertex(w)).norm());
      }
      CHECK((part->shape.face_normal(f) - normal).norm() * least < 1e-9 * size + 100 * rounding);
    }
  }
}

}  // namespace

TEST_CASE("split: a cube across, by its diagonal, at a corner; at home, turned and far away") {
  Random random(5);
  for (const double away : {0.0, 1.0, 1e5}) {
    const Matrix3 turn = away == 0.0 ? Matrix3(Matrix3::Identity()) : random.rotation();
    const Vector3 shift = away * Vector3(1, -2, 3);
    const Shape cube = turned(make_box({0, 0, 0}, {1, 1, 1}), turn, shift);
    const double within = 1e-13 + 1e-14 * away;
    const auto cut = [&](const Vector3& point, const Vector3& normal) {
      const Plane plane{turn * point + shift, turn * normal};
      check_split(cube, plane);
      return split(cube, plane);
    };
    const Split across = cut({0, 0, 0.25}, {0, 0, 2});
    CHECK_THAT(volume(across.below), WithinAbs(0.25, within));
    CHECK_THAT(volume(across.above), WithinAbs(0.75, within));
    CHECK(across.below->shape.topology().face_count() == 6);
    CHECK(std::ranges::count(across.below->old_faces, -1) == 1);
    const Split diagonal = cut({0, 0, 0}, {1, -1, 0});
    CHECK_THAT(volume(diagonal.below), WithinAbs(0.5, within));
    CHECK(diagonal.above->shape.vertex_count() == 6);
    const Split corner = cut({0.5, 0, 0}, {1, 1, 1});
    CHECK_THAT(volume(corner.below), WithinAbs(1.0 / 48, within));
    CHECK(corner.below->shape.topology().face_count() == 4);
    CHECK(corner.above->shape.topology().face_count() == 7);
    const Split edge = cut({0, 0, 0}, {1, 1, 0});  // touches it along an edge
    CHECK(!edge.below);
    CHECK(edge.above->shape.vertices() == cube.vertices());
    CHECK(edge.above->old_faces == std::vector<int>{0, 1, 2, 3, 4, 5});
    CHECK(!cut({0, 0, 2}, {0, 0, 1}).above);
    CHECK(!cut({0, 0, 1}, {0, 0, 1}).above);
  }
}

TEST_CASE("split: neighbours that share an edge have the same places on it") {
  const Shape left = make_box({0, 0, 0}, {1, 1, 1}), right = make_box({1, 0, 0}, {2, 1, 1});
  const Plane plane{{0.3, 0.1, 0.7}, {0.1, 0.2, 0.9}};
  const Split a = split(left, plane), b = split(right, plane);
  int common = 0;
  for (int v = 0; v < a.above->shape.vertex_count(); ++v) {
    const Vector3 place = a.above->shape.vertex(v);
    common += place.x() == 1.0 && has_vertex(b.above->shape, place);
  }
  CHECK(common == 4);
}

TEST_CASE("split: random hulls by random planes, some through a vertex or beside one") {
  Random random(7);
  for (int i = 0; i < 300; ++i) {
    Points points(3, 4 + i % 40);
    for (double& x : points.reshaped()) x = random.uniform(-1, 1);
    if (i % 3 == 1) points.colwise() += Vector3(1e3, -1e4, 10);
    const Shape shape = make_hull(points).polyhedron;
    Plane plane{shape.vertex_mean(), random.rotation().col(0)};
    if (i % 4 == 1) plane.point = shape.vertex(0);
    if (i % 4 == 2) plane.point = shape.vertex(0) + std::exp(random.uniform(-40, 0)) * plane.normal;
    if (i % 4 == 3) plane.normal = shape.face_normal(0) + 1e-13 * plane.normal;
    INFO(i);
    check_split(shape, plane);
  }
}

TEST_CASE("split: a block cut again and again keeps its volume") {
  Random random(9);
  std::vector<Shape> blocks{make_box({0, 0, 0}, {1, 1, 1})};
  for (int k = 0; k < 16; ++k) {
    const Plane plane{0.5 * Vector3::Ones() + 0.3 * random.rotation().col(1),
                      random.rotation().col(0)};
    std::vector<Shape> next;
    for (const Shape& block : blocks) {
      const Split parts = split(block, plane);
      for (const auto& part : {parts.below, parts.above})
        if (part) next.push_back(part->shape);
    }
    blocks = next;
  }
  double sum = 0.0;
  for (const Shape& block : blocks) sum += mass_properties(block).volume;
  CHECK(blocks.size() > 100);
  CHECK_THAT(sum, WithinRel(1.0, 1e-12));
}

TEST_CASE("split: planes that are none") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  CHECK_THROWS_AS(split(cube, {{0, 0, 0}, {0, 0, 0}}), InputError);
  CHECK_THROWS_AS(split(cube, {{0, std::nan(""), 0}, {0, 0, 1}}), InputError);
}
