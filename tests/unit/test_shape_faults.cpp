/// What is wrong with solids in words, and solids whose coordinates were rounded in a file.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;
using Faces = std::vector<std::vector<int>>;

const Faces kCubeFaces{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

Points cube() {
  Points points(3, 8);
  for (int i = 0; i < 8; ++i) points.col(i) = Vector3(i & 1, i >> 1 & 1, i >> 2 & 1);
  return points;
}

struct Solid {
  Points points;
  Faces faces;
};

/// A prism over a polygon of n corners on an ellipse, all faces cut into triangles, turned.
Solid prism(int n, Random& random) {
  Solid solid{Points(3, 2 * n), {}};
  const double a = std::exp(random.uniform(-2, 1)), b = std::exp(random.uniform(-2, 1)),
               height = std::exp(random.uniform(-2, 1));
  double angle = 0.0;
  for (int k = 0; k < n; ++k) {
    angle += 2 * std::numbers::pi / n * random.uniform(0.3, 1.0);
    solid.points.col(k) = Vector3(a * std::cos(angle), b * std::sin(angle), 0);
    solid.points.col(n + k) = solid.points.col(k) + Vector3(0, 0, height);
  }
  for (int k = 2; k < n; ++k) {
    solid.faces.push_back({0, k, k - 1});
    solid.faces.push_back({n, n + k - 1, n + k});
  }
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    solid.faces.push_back({k, next, n + next});
    solid.faces.push_back({k, n + next, n + k});
  }
  const Vector3 shift = random.point(-3, 3);
  solid.points = ((random.rotation() * solid.points).colwise() + shift).eval();
  return solid;
}

/// As a file with six digits behind the point has them.
Points written(const Points& points) {
  Points read = points;
  for (double& x : read.reshaped()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6f", x);
    x = std::strtod(text, nullptr);
  }
  return read;
}

std::string first_fault(const Points& points, const Faces& faces) {
  const std::vector<ShapeFault> faults = shape_faults(points, faces);
  return faults.empty() ? "" : faults[0].text;
}

}  // namespace

TEST_CASE("shape faults: none of a cube; inside out is told and taken") {
  CHECK(shape_faults(cube(), kCubeFaces).empty());
  Faces inverted = kCubeFaces;
  for (std::vector<int>& face : inverted) std::reverse(face.begin(), face.end());
  const std::vector<ShapeFault> faults = shape_faults(cube(), inverted);
  REQUIRE(faults.size() == 1);
  CHECK_THAT(faults[0].text, ContainsSubstring("inside out"));
  CHECK(!faults[0].refused);
  CHECK_NOTHROW(make_shape(cube(), inverted));
}

TEST_CASE("shape faults: not closed, flat, NaN, equal points, dents") {
  Points points = cube();
  points(1, 5) = std::nan("");
  CHECK_THAT(first_fault(points, kCubeFaces), ContainsSubstring("point 5"));
  Faces open = kCubeFaces;
  open.pop_back();
  CHECK_THAT(first_fault(cube(), open), ContainsSubstring("edge"));
  points = cube();
  points.col(7) = points.col(3);
  CHECK_THAT(first_fault(points, kCubeFaces), ContainsSubstring("points 3 and 7 are equal"));
  points = cube();
  points.row(2) *= 1e-12;
  const std::string flat = first_fault(points, kCubeFaces);
  CHECK_THAT(flat, ContainsSubstring("plane"));
  points = cube();
  points.col(7) = Vector3(0.6, 0.6, 0.6);  // three faces are bent, and all see others outside
  const std::vector<ShapeFault> dents = shape_faults(points, kCubeFaces);
  CHECK(dents.size() >= 3);
  CHECK_THAT(dents[0].text, ContainsSubstring("face 1 is off its plane by"));
  CHECK_THAT(dents[0].text, ContainsSubstring("limit"));
  CHECK_THROWS_AS(make_shape(points, kCubeFaces), InputError);
  CHECK_THROWS_AS(make_shape(cube(), kCubeFaces, {.coordinate_rounding = -1.0}), InputError);
}

TEST_CASE("coordinate rounding: no triangulated prism of six digits is refused") {
  Random random(12);
  const ShapeOptions rounded{.coordinate_rounding = 0.5e-6};
  int refused_without = 0;
  const auto cases = environment_number("QUOIN_CASES", 1000);
  for (std::uint64_t i = 0; i < cases; ++i) {
    const Solid exact = prism(3 + static_cast<int>(i % 14), random);
    const Points points = written(exact.points);
    refused_without += !shape_faults(points, exact.faces).empty();
    const std::vector<ShapeFault> faults = shape_faults(points, exact.faces, rounded);
    INFO(i << ": " << (faults.empty() ? "" : faults[0].text));
    REQUIRE(faults.empty());
    const Shape shape = make_shape(points, exact.faces, rounded);
    CHECK(shape.vertex_count() == points.cols());
    // what is answered for is the hull
    CHECK_THAT(mass_properties(shape).volume,
               WithinRel(mass_properties(make_hull(points).polyhedron).volume, 1e-9));
  }
  CHECK(refused_without > 0);
}

TEST_CASE("coordinate rounding: dents that it does not explain are refused") {
  Random random(13);
  const ShapeOptions rounded{.coordinate_rounding = 0.5e-6};
  for (int i = 0; i < 100; ++i) {
    Solid solid = prism(6, random);
    const Vector3 middle = solid.points.rowwise().mean();
    solid.points.col(i % 12) += 0.2 * (middle - solid.points.col(i % 12));
    const bool refused = !shape_faults(written(solid.points), solid.faces, rounded).empty();
    // a corner may be pulled in and the solid be convex still: then no hull face is cut off
    const double own = [&] {
      double six = 0.0;
      for (const auto& f : solid.faces)
        six += (solid.points.col(f[0]) - middle)
                   .dot((solid.points.col(f[1]) - middle).cross(solid.points.col(f[2]) - middle));
      return std::abs(six) / 6;
    }();
    const double hull = mass_properties(make_hull(solid.points).polyhedron).volume;
    if (own < 0.99 * hull) CHECK(refused);
  }
}
