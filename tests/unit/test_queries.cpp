#include <cmath>
#include <limits>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/queries.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

const double kInfinity = std::numeric_limits<double>::infinity();

/// Placements for closed forms: at home, turned, stretched and sheared, and 1e6 m away.
std::vector<Placement> placements() {
  Random random(3);
  Matrix3 strain;
  strain << 1.1, 0.05, 0, 0.02, 0.9, -0.03, 0, 0.01, 1.2;
  const Vector3 away(1e6, -2e6, 1.5e6);
  return {{},
          {random.rotation(), Vector3(1, 2, 3)},
          {random.rotation() * strain, Vector3(5, 0, 1)},
          {Matrix3::Identity(), away},
          {random.rotation(), away},
          {random.rotation() * strain, away}};
}

/// How far a place may be off in the world for its rounding there, m.
double rounding(const Placement& placement) {
  return 1e-14 + 1e-15 * placement.translation.cwiseAbs().maxCoeff();
}

Vector3 placed(const Placement& placement, const Vector3& own) {
  return placement.translation + placement.linear * own;
}

}  // namespace

TEST_CASE("ray: enters a cube where it should, turned, deformed and far away") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  for (const Placement& placement : placements()) {
    const Body body(cube, placement);
    // in the cube's own frame: from (-2, 0.25, 0.5) along (1, 0.125, 0), at s = 2 through x = 0
    Ray ray{placed(placement, {-2, 0.25, 0.5}), placement.linear * Vector3(1, 0.125, 0), kInfinity};
    const std::optional<RayHit> hit = first_hit(body, ray);
    REQUIRE(hit.has_value());
    CHECK_THAT(hit->s, WithinAbs(2.0, 8 * rounding(placement)));
    CHECK((hit->point - placed(placement, {0, 0.5, 0.5})).norm() < 8 * rounding(placement));
    // the image of a plane has the normal A^-T n
    const Vector3 normal =
        (placement.linear.inverse().transpose() * Vector3(-1, 0, 0)).normalized();
    CHECK((hit->normal - normal).norm() < 1e-14);
    CHECK((cube.face_normal(hit->face) - Vector3(-1, 0, 0)).norm() < 1e-15);
    ray.length = 1.9;
    CHECK(!first_hit(body, ray));
    ray.length = 2.1;
    CHECK(first_hit(body, ray).has_value());
    ray.direction = -ray.direction;
    CHECK(!first_hit(body, ray));
    ray = {placed(placement, {0.5, 0.5, 0.5}), Vector3(0, 3, 4), 1.0};
    const std::optional<RayHit> inside = first_hit(body, ray);
    REQUIRE(inside.has_value());
    CHECK(inside->s == 0.0);
    CHECK(inside->face == -1);
    CHECK(inside->point == ray.origin);
    // beside the cube, along one of its edges
    ray = {placed(placement, {-2, 1.001, 0.5}), placement.linear * Vector3(1, 0, 0), kInfinity};
    CHECK(!first_hit(body, ray));
    ray.origin = placed(placement, {-2, 0.999, 0.5});
    CHECK(first_hit(body, ray).has_value());
  }
}

TEST_CASE("ray: hits a hull of many faces where bisection of point in body says") {
  Random random(12);
  Points points(3, 40);
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) = random.direction();
  const Shape hull = quoin::geometry::make_hull(points).polyhedron;
  int hits = 0;
  for (const Placement& placement : placements()) {
    const Body body(hull, placement);
    for (int i = 0; i < 50; ++i) {
      const Vector3 from = 3 * random.direction(), to = 0.9 * random.direction();
      const Ray ray{placed(placement, from), placement.linear * (to - from), 1.0};
      const std::optional<RayHit> hit = first_hit(body, ray);
      if (!contains(body, placed(placement, to))) continue;
      REQUIRE(hit.has_value());
      ++hits;
      double outside = 0.0, inside = 1.0;
      for (int k = 0; k < 60; ++k) {
        const double s = 0.5 * (outside + inside);
        (contains(body, ray.origin + s * ray.direction) ? inside : outside) = s;
      }
      CHECK_THAT(hit->s, WithinAbs(inside, 1e-12 + 8 * rounding(placement)));
    }
  }
  CHECK(hits > 100);
}

TEST_CASE("ray: what is none is refused") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(first_hit(cube, Ray{{nan, 0, 0}, {1, 0, 0}, 1}), InputError);
  CHECK_THROWS_AS(first_hit(cube, Ray{{0, 0, 0}, {0, 0, 0}, 1}), InputError);
  CHECK_THROWS_AS(first_hit(cube, Ray{{0, 0, 0}, {kInfinity, 0, 0}, 1}), InputError);
  CHECK_THROWS_AS(first_hit(cube, Ray{{0, 0, 0}, {1, 0, 0}, -1}), InputError);
  CHECK_THROWS_AS(first_hit(cube, Ray{{0, 0, 0}, {1, 0, 0}, nan}), InputError);
}

TEST_CASE("ray: hits are at finite places") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  CHECK_FALSE(first_hit(cube, Ray{{-1, 0.5, 0.5}, {1e-310, 0, 0}, kInfinity}));
  const auto hit = first_hit(cube, Ray{{-1, 0.5, 0.5}, {1e-300, 0, 0}, kInfinity});
  REQUIRE(hit);
  CHECK_THAT(hit->point.x(), WithinAbs(0.0, 1e-15));
}

TEST_CASE("point: in a cube or not, by a billionth of its size") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  for (const Placement& placement : placements()) {
    const Body body(cube, placement);
    const double close = 1e-12 + 8 * rounding(placement);
    CHECK(contains(body, placed(placement, {0.5, 0.5, 0.5})));
    CHECK(contains(body, placed(placement, {close, 1 - close, 0.5})));
    CHECK(!contains(body, placed(placement, {-close, 0.5, 0.5})));
    CHECK(!contains(body, placed(placement, {0.5, 1 + close, 0.5})));
    CHECK(contains(body, placed(placement, {0.5, 1.0009, 0.5}), 2e-3));
    CHECK(!contains(body, placed(placement, {0.5, 1.0009, 0.5}), 1e-4));
    const Body own(cube, {placement.linear, Vector3::Zero()});
    const double stated = 16 * std::numeric_limits<double>::epsilon() * (cube.diameter() + 1);
    CHECK(!contains(own, placement.linear * Vector3(0.5, 0.5, 1 + 1.2 * stated)));
    CHECK(!contains(body, {std::numeric_limits<double>::quiet_NaN(), 0, 0}));
    CHECK(!contains(body, {kInfinity, 0, 0}));
  }
}

TEST_CASE(
    "point and ray: a wedge whose tip is thinner than labels are known holds its own vertices") {
  for (const double height : {1e-2, 1e-5, 1e-7}) {
    CAPTURE(height);
    constexpr double kTip = 5e-10;
    Points corners(3, 8);
    corners << 0, 0, 0, 0, 1, 1, 1, 1,  //
        0, 1, 0, 1, 0, 1, 0, 1,         //
        0, 0, height, height, 0, 0, kTip, kTip;
    const Shape wedge = make_hull(corners).polyhedron;
    for (int v = 0; v < wedge.vertex_count(); ++v) CHECK(contains(wedge, wedge.vertex(v)));
    CHECK(contains(wedge, {0.999, 0.5, 0.5 * kTip}));
    const auto hit =
        first_hit(wedge, {.origin = {2, 0.5, 0.5 * kTip}, .direction = {-1, 0, 0}, .length = 3});
    REQUIRE(hit.has_value());
    CHECK(hit->s <= 1.0 + 1e-9);  // 1.0025 by planes through the corners of the faces alone
  }
}

TEST_CASE("point, ray and overlap: a shape without thickness holds nothing") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  const Matrix3 plate = Vector3(1, 1, 0).asDiagonal(), segment = Vector3(1, 0, 0).asDiagonal();
  Matrix3 oblique = segment;
  oblique.col(0) = Vector3(1, 0.25, 0.5);
  for (const Matrix3& flattened : {plate, segment, oblique}) {
    Shape shape = cube;
    shape.set_vertices(flattened * cube.vertices());
    Random random(7);
    int apart = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vector3 place = random.point(-2, 2);
      const Body other(cube, {.translation = place});
      if (!(nearest_features(shape, other).gap > 1e-6)) continue;
      ++apart;
      CHECK_FALSE(overlap(shape, other));
      CHECK_FALSE(contains(shape, place));
      CHECK_FALSE(first_hit(shape, {.origin = place, .direction = {0, 0, 1}, .length = 1e-3}));
    }
    CHECK(apart > 500);
  }
}

TEST_CASE("overlap: yes and no on either side of touching") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  for (const Placement& placement : placements()) {
    const double close = 1e-12 + 8 * rounding(placement);
    const auto beside = [&](double gap) {
      return Placement{placement.linear, placed(placement, {1 + gap, 0.25, 0.5})};
    };
    CHECK(overlap({cube, placement}, {cube, beside(-0.5)}));
    CHECK(overlap({cube, placement}, {cube, beside(-close)}));
    CHECK(!overlap({cube, placement}, {cube, beside(close)}));
    CHECK(!overlap({cube, placement}, {cube, beside(3)}));
    CHECK(overlap({cube, placement}, {cube, placement}));
  }
  CHECK(overlap(cube, {cube, {Matrix3::Identity(), {1, 1, 1}}}));  // in one vertex
  CHECK(!overlap(cube, {cube, {Matrix3::Identity(), {1, 1, 1 + 0x1p-40}}}));
}

TEST_CASE("overlap: what the gap says, for all hints") {
  Random random(8);
  Points points(3, 24);
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) = random.direction();
  const Shape hull = quoin::geometry::make_hull(points).polyhedron;
  const Shape cube = make_box({-1, -1, -1}, {1, 1, 1});
  int yes = 0, no = 0;
  for (int i = 0; i < 400; ++i) {
    const Body a(hull, {random.rotation(), random.point(-1, 1)});
    const Body b(cube, {random.rotation(), 2.2 * random.direction()});
    const quoin::geometry::NearestFeatures nearest = nearest_features(a, b);
    quoin::geometry::FeatureHint hint = nearest.hint;
    hint.normal = random.direction();
    CHECK(overlap(a, b) == (nearest.gap <= 0.0));
    CHECK(overlap(a, b, nearest.hint) == (nearest.gap <= 0.0));
    CHECK(overlap(a, b, hint) == (nearest.gap <= 0.0));
    (nearest.gap <= 0.0 ? yes : no) += 1;
  }
  CHECK(yes > 50);
  CHECK(no > 50);
}

TEST_CASE(
    "overlap: a plate on a cube, turned alike, so far out that places are rounded to its size") {
  const Shape cube = make_box({0, 0, 0}, {2, 2, 2}), plate = make_box({0, 0, 0}, {2, 2, 2e-6});
  int apart = 0;
  for (const double far : {1e10, 1e12, 1e13}) {
    for (int i = 0; i < 400; ++i) {
      Placement placement;
      placement.linear =
          Eigen::AngleAxisd(0.005 * (i + 1), Vector3(1, 2, 3).normalized()).toRotationMatrix();
      placement.translation = {far, 2 * far, -far};
      const Body a(cube, placement);
      placement.translation += placement.linear * Vector3(0, 0, 2 + 1e-5 * (i % 6));
      const Body b(plate, placement);
      const double gap = nearest_features(a, b).gap;
      REQUIRE(overlap(a, b) == (gap <= 0.0));
      REQUIRE(overlap(b, a) == (gap <= 0.0));
      apart += gap > 0.0 ? 1 : 0;
    }
  }
  CHECK(apart > 100);
}

TEST_CASE("distance with a cut-off: the nearest features up to it, nothing beyond") {
  const Shape cube = make_box({0, 0, 0}, {1, 1, 1});
  const Placement above{Matrix3::Identity(), {0.5, 0.25, 1.25}};
  const auto within = [&](double cut_off) {
    return nearest_features_within(cube, {cube, above}, cut_off);
  };
  REQUIRE(within(0.25).has_value());
  CHECK(within(0.25)->gap == 0.25);
  CHECK(within(0.25)->normal == Vector3::UnitZ());
  CHECK(within(kInfinity)->gap == 0.25);
  CHECK(!within(std::nextafter(0.25, 0.0)));
  CHECK(!within(0.0));
  CHECK(!within(-1.0));
  CHECK_THROWS_AS(within(std::numeric_limits<double>::quiet_NaN()), InputError);
  const Placement sunk{Matrix3::Identity(), {0.5, 0.25, 0.75}};
  CHECK(nearest_features_within(cube, {cube, sunk}, 0.0)->gap == -0.25);
  CHECK(!nearest_features_within(cube, {cube, sunk}, -0.5));
  const Vector3 away(1e6, 1e6, -1e6);
  const Body far_a(cube, {Matrix3::Identity(), away});
  const Body far_b(cube, {Matrix3::Identity(), away + above.translation});
  CHECK(nearest_features_within(far_a, far_b, 0.25)->gap == 0.25);
  CHECK(!nearest_features_within(far_a, far_b, 0.125));
}
