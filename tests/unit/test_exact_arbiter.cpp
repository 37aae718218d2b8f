/// The judge is judged first: closed forms, and a search that knows nothing of hulls or features.
#include <cmath>
#include <numbers>

#include "referee/pairs/exact_arbiter.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/sanitized.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

constexpr int kTrials = quoin::tests::kSanitized ? 3 : 15;

Points box(const Vector3& half) {
  Points points(3, 8);
  for (int i = 0; i < 8; ++i) {
    points.col(i) =
        Vector3((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                (i & 4) != 0 ? half.z() : -half.z());
  }
  return points;
}

Points moved(const Points& points, const Matrix3& rotation, const Vector3& shift) {
  return (rotation * points).colwise() + shift;
}

Points hull_points(Random& random, int count, const Vector3& centre) {
  Points points(3, count);
  for (int i = 0; i < count; ++i)
    points.col(i) = centre + random.uniform(0.5, 1.0) * random.direction();
  return points;
}

double extent(const Points& a, const Points& b, const Vector3& n) {  // gap along n
  return (n.transpose() * b).minCoeff() - (n.transpose() * a).maxCoeff();
}

/// Largest gap over all directions, by random descent: no features, no hulls.
double gap_by_descent(Random& random, const Points& a, const Points& b) {
  Vector3 best = random.direction();
  for (int start = 0; start < 4000; ++start) {
    const Vector3 n = random.direction();
    best = extent(a, b, n) > extent(a, b, best) ? n : best;
  }
  for (double step = 0.1; step > 1e-9; step *= 0.97) {
    for (int turn = 0; turn < 60; ++turn) {
      const Vector3 n = (best + step * random.direction()).normalized();
      best = extent(a, b, n) > extent(a, b, best) ? n : best;
    }
  }
  return extent(a, b, best);
}

double gap_by_trial(Random& random, const Points& a, const Points& b) {
  double best = gap_by_descent(random, a, b);
  for (int again = 0; again < 4; ++again)  // the depth may have several local optima
    best = std::max(best, gap_by_descent(random, a, b));
  return best;
}

}  // namespace

TEST_CASE("arbiter: closed forms") {
  const Points cube = box(Vector3::Constant(0.5));
  const Matrix3 one = Matrix3::Identity();
  CHECK(exact_gap(cube, moved(cube, one, {1.25, 0, 0})).gap == 0.25L);
  CHECK(exact_gap(cube, moved(cube, one, {1, 0.5, 0})).gap == 0.0L);
  CHECK(exact_gap(cube, moved(cube, one, {1, 1, 1})).gap == 0.0L);
  CHECK(exact_gap(cube, moved(cube, one, {0.75, 0.25, 0})).gap == -0.25L);
  CHECK(exact_gap(cube, cube).gap == -1.0L);
  CHECK(exact_gap(cube, box(Vector3(0.25, 0.125, 0.25))).gap == -0.625L);
  CHECK(exact_gap(cube, moved(cube, one, {2, 2, 2})).gap == std::sqrt(3.0L));
  CHECK(exact_gap(cube, moved(cube, one, {1 + 0x1p-52, 0, 0})).gap == 0x1p-52L);
  CHECK(exact_gap(cube, moved(cube, one, {1.25, 0, 0})).normal == Vector3(1, 0, 0));
  CHECK(exact_gap(cube, moved(cube, one, {0, -0.75, 0})).normal == Vector3(0, -1, 0));
}

TEST_CASE("arbiter: coordinates farther apart than the range of a double") {
  const Points cube = moved(box(Vector3::Constant(0.5)), Matrix3::Identity(), {0x1p20, 0, 0});
  Points other(3, 9);
  other << moved(cube, Matrix3::Identity(), {1.25, 0, 0}), Vector3(0x1p20 + 1.25, 0x1p-1074, 0);
  CHECK(exact_gap(cube, other).gap == 0.25L);
  CHECK(exact_gap(other, cube).gap == 0.25L);
}

TEST_CASE("arbiter: cases G01, G02, G07, G08") {
  Points pyramid(3, 5), tetrahedron(3, 4);
  pyramid << -10, 10, 10, -10, 0, -10, -10, 10, 10, 0, 0, 0, 0, 0, -0.5;
  tetrahedron << 0, 1, -.5, -.5, 0, 0, .8, -.8, 0.005, 1, 1, 1;
  CHECK(exact_gap(pyramid, tetrahedron).gap == static_cast<long double>(0.005));

  const Points cube = box(Vector3::Constant(0.5));
  const double eighth = std::numbers::pi / 4;
  const Points lower = moved(cube, rotation_about(Vector3::UnitX(), eighth), Vector3::Zero());
  for (const double gap : {0.01, -0.01}) {
    const Points upper =
        moved(cube, rotation_about(Vector3::UnitY(), eighth), Vector3(0, 0, std::sqrt(2.0) + gap));
    CHECK_THAT(static_cast<double>(exact_gap(lower, upper).gap), WithinAbs(gap, 1e-15));
    const Vector3 far(512345.678, 4123456.789, 1500.25);
    CHECK_THAT(static_cast<double>(exact_gap(lower.colwise() + far, upper.colwise() + far).gap),
               WithinAbs(gap, 2e-9));
  }
  const Points turned =
      moved(cube, rotation_about(Vector3(1, 2, 3).normalized(), 40 * std::numbers::pi / 180),
            {1.3, 0.1, 1.3});
  const quoin::tests::ExactGap g08 = exact_gap(box(Vector3::Ones()), turned);
  CHECK_THAT(static_cast<double>(g08.gap), WithinAbs(-0.151702406, 1e-9));
  CHECK((g08.normal - Vector3(0.491577702, 0, 0.870833717)).norm() < 1e-8);
}

TEST_CASE("arbiter: placements are taken as they are, not rounded") {
  const Points cube = box(Vector3::Constant(0.5));
  const Matrix3 one = Matrix3::Identity();
  const auto gap = [&](const Placement& a, const Placement& b) {
    return ExactPair({cube, a}, {cube, b}).gap().gap;
  };
  CHECK(gap({}, {one, {1.25, 0, 0}}) == 0.25L);
  CHECK(gap({one, {1e6, 0, 0}}, {one, {1e6 + 1.25, 0, 0}}) == 0.25L);
  CHECK(gap({2 * one, {0, 0, 0}}, {one, {2, 0, 0}}) == 0.5L);
  Matrix3 turn;  // a quarter about z: exact
  turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Points brick = box({1, 0.5, 0.25});
  CHECK(ExactPair({brick, {turn, {0, 0, 0}}}, {brick, {}}).gap().gap == -0.5L);
  CHECK(ExactPair({brick, {turn, {0, 4, 0}}}, {brick, {}}).gap().gap == 2.5L);
  // 2^-40 of a corner times 1 + 2^-30 has more bits than a double near 1e6 has
  Matrix3 stretched = one;
  stretched(0, 0) += 0x1p-30;
  const long double thin = 0.5L * 0x1p-30L;
  CHECK(gap({stretched, {0x1p20, 0, 0}}, {one, {0x1p20 + 2, 0, 0}}) == 1 - thin);
}

TEST_CASE("arbiter: distance of a point, and width") {
  const Points cube = box(Vector3::Constant(0.5));
  const ExactPair pair({cube, {Matrix3::Identity(), {1e6, 0, 0}}}, {cube, {}});
  CHECK(pair.distance(0, {1e6 + 0.25, 0, 0}, 0.0) == 0);
  CHECK(pair.distance(0, {1e6 + 0.75, 0, 0}, 0.0) == 0.25);
  CHECK(pair.distance(1, {0.5 + 0x1p-50, 0, 0}, 0.0) == 0x1p-50);
  CHECK(std::isnan(pair.distance(1, {std::nan(""), 0, 0}, 1.0)));
  CHECK(quoin::tests::exact_width({box({1, 0.5, 0.25}), {}}) == 0.5L);
  CHECK_THROWS(quoin::tests::exact_width({box({1, 0.5, 0}), {}}));
  Points bent = cube;
  bent.row(2) *= std::numeric_limits<double>::denorm_min();  // its last bit is far from a metre's
  bent(2, 0) = -1;
  const ExactPair far({bent, {}}, {cube, {}});
  CHECK(far.place({0.5, 0, 0})[0] == 1);
  CHECK(far.distance(0, {-0.5, -0.5, -1.5}, 0.0) == 0.5);
}

TEST_CASE("arbiter: agrees with a blind search over directions") {
  Random random(quoin::tests::environment_number("QUOIN_SEED", 4));
  for (int i = 0; i < kTrials; ++i) {
    const Points a = hull_points(random, random.integer(4, 30), Vector3::Zero());
    const Points b =
        hull_points(random, random.integer(4, 30), random.uniform(0.3, 3.0) * random.direction());
    const double exact = static_cast<double>(exact_gap(a, b).gap);
    const double trial = gap_by_trial(random, a, b);
    CHECK(trial <= exact + 1e-14);
    CHECK_THAT(trial, WithinAbs(exact, 1e-5));
    CHECK_THAT(extent(a, b, exact_gap(a, b).normal), WithinAbs(exact, 1e-14));
    CHECK(exact_gap(b, a).gap == exact_gap(a, b).gap);
  }
}
