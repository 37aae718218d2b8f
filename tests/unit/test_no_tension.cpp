#include <Eigen/Geometry>
#include <numbers>
#include <random>
#include <vector>

#include "scene_file/no_tension.hpp"
#include "support/catch.hpp"

using Eigen::Vector2d;
using quoin::scene_file::no_tension_edge_stress;
using quoin::tests::WithinRel;

namespace {

/// 3 m by 2 m about a place, turned.
struct Rectangle {
  Vector2d place{1e3, -2e2};
  Eigen::Matrix2d turn = Eigen::Rotation2Dd(0.7).toRotationMatrix();
  Vector2d at(double x, double y) const { return place + turn * Vector2d(x, y); }
  std::vector<Vector2d> corners() const {  // in no order, one twice, one on a side
    return {at(-1.5, -1), at(1.5, 1), at(1.5, -1), at(-1.5, 1), at(1.5, 1), at(0, 1)};
  }
};

}  // namespace

TEST_CASE("the edge stress of a rectangle is that of the books, in the kern and out of it") {
  const Rectangle rectangle;
  const double force = 6e4;
  for (const double e : {0.0, 0.2, 0.49, 0.51, 0.9, 1.2, 1.49}) {
    const double exact = e <= 0.5 ? force / 6 * (1 + 6 * e / 3) : 2 * force / (3 * (1.5 - e) * 2);
    for (const double side : {-1.0, 1.0}) {
      const auto found =
          no_tension_edge_stress(rectangle.corners(), rectangle.at(side * e, 0), force);
      REQUIRE(found);
      CHECK_THAT(*found, WithinRel(exact, 1e-9));
    }
  }
}

TEST_CASE("eccentric both ways: a corner alone bears") {
  // A pyramid of pressure on the triangle with legs u, v at a corner: N = s u v / 6, at u/4, v/4.
  const Rectangle rectangle;
  const double u = 2.0, v = 1.2, stress = 3e5;
  const auto found = no_tension_edge_stress(
      rectangle.corners(), rectangle.at(1.5 - u / 4, 1 - v / 4), stress * u * v / 6);
  REQUIRE(found);
  CHECK_THAT(*found, WithinRel(stress, 1e-9));
}

TEST_CASE("what no pressure bears has none") {
  const Rectangle rectangle;
  CHECK(!no_tension_edge_stress(rectangle.corners(), rectangle.at(1.6, 0), 1.0));
  CHECK(!no_tension_edge_stress(rectangle.corners(), rectangle.at(1.5, 0), 1.0));
  CHECK(!no_tension_edge_stress(rectangle.corners(), rectangle.at(0, 0), 0.0));
  const std::vector<Vector2d> line{{0, 0}, {1, 1}, {2, 2}};
  CHECK(!no_tension_edge_stress(line, {1, 1}, 1.0));
  CHECK(!no_tension_edge_stress({}, {0, 0}, 1.0));
}

TEST_CASE("any polygon and place inside: the pressure is found, and above the mean") {
  std::mt19937_64 random(3);
  const auto uniform = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
  for (int i = 0; i < 300; ++i) {
    std::vector<Vector2d> corners;
    for (int k = 0; k < 5; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.9 * uniform()) / 5;
      corners.emplace_back(std::cos(angle), std::sin(angle));
    }
    Vector2d centre = Vector2d::Zero();
    double sum = 0.0;
    for (const Vector2d& corner : corners) {
      const double weight = uniform() * uniform();
      centre += weight * corner;
      sum += weight;
    }
    const auto found = no_tension_edge_stress(corners, centre / sum, 1.0);
    REQUIRE(found);
    CHECK(*found > 1.0 / std::numbers::pi);
  }
}
