/// Solids whose coordinates were rounded in a file.
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

}  // namespace

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
