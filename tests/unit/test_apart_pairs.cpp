/// Pairs that last step's plane parts are found when their bodies meet.

#include <quoin/geometry.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

constexpr double kReach = 1e-3;

/// A bar askew, so that its box meets that of a bar beside it, 0.3 m away.
const Matrix3 kHeading = rotation_about(Vector3::UnitZ(), 0.8);
const Shape kBar = make_box({2.0, 1.0, 1.0}, {4.0, 1.2, 1.2});
constexpr double kGap = 0.3;

Placement beside(double nearer) {
  return {kHeading, kHeading * Vector3(0, 0.2 + kGap - nearer, 0)};
}

/// Turned about a point of its own far from the shape's origin.
Placement turned(double angle) {
  const Placement still = beside(0);
  const Vector3 pivot(4.0, 1.0, 1.0);
  const Matrix3 linear = kHeading * rotation_about(Vector3::UnitZ(), angle);
  return {linear, still.linear * pivot + still.translation - linear * pivot};
}

Placement stretched(double strain) {
  Matrix3 stretch = Matrix3::Identity();
  stretch(1, 1) += strain;
  const Placement still = beside(0);
  const Vector3 top(0, 1.2, 0);  // stays; the other side comes nearer
  return {kHeading * stretch, still.translation + kHeading * (top - stretch * top)};
}

std::shared_ptr<const Shape> thickened(double by) {
  Shape bar = kBar;
  Points vertices = bar.vertices();
  for (Eigen::Index v = 0; v < vertices.cols(); ++v)
    if (vertices(1, v) < 1.1) vertices(1, v) -= by;
  bar.set_vertices(vertices);
  return std::make_shared<const Shape>(bar);
}

/// The second of two bars that come together by about kGap and a little more, and part again.
struct SecondBar {
  Placement placement = beside(0);
  std::shared_ptr<const Shape> shape = std::make_shared<const Shape>(kBar);
};
SecondBar second_bar(int kind, double way) {
  if (kind == 0) return {.placement = beside(way)};
  if (kind == 1) return {.placement = turned(way / 2)};
  if (kind == 2) return {.placement = stretched(way / 0.2)};
  return {.shape = thickened(way)};
}

void check_same(const std::vector<ContactPoint>& found, const std::vector<ContactPoint>& expected) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    CHECK(found[k].key == expected[k].key);
    CHECK(found[k].gap == expected[k].gap);
    CHECK(found[k].point_a == expected[k].point_a);
  }
}

}  // namespace

TEST_CASE("pairs apart: bars that come nearer are found when they come into reach") {
  constexpr int kSteps = 150;
  for (int kind = 0; kind < 4; ++kind) {
    CAPTURE(kind);
    ContactFinder warm({.reach = kReach});
    const auto bar = std::make_shared<const Shape>(kBar);
    warm.add(bar, {kHeading, Vector3::Zero()});
    const int second = warm.add(bar, beside(0));
    std::vector<ContactPoint> found, expected;
    int in_contact = 0, apart = 0;
    for (int step = 0; step < 2 * kSteps; ++step) {
      const double share = 1.0 - std::abs(step - kSteps) / static_cast<double>(kSteps);
      const SecondBar next = second_bar(kind, 1.1 * kGap * share);
      if (kind == 3) warm.replace_shape(second, next.shape);
      warm.move(second, next.placement);
      warm.find(found);
      ContactFinder cold({.reach = kReach});
      cold.add(bar, {kHeading, Vector3::Zero()});
      cold.add(next.shape, next.placement);
      cold.find(expected);
      check_same(found, expected);
      ++(found.empty() ? apart : in_contact);
    }
    CHECK(in_contact > 10);
    CHECK(apart > 100);
  }
}

TEST_CASE("pairs apart: a longer reach finds what was out of reach of a shorter one") {
  ContactFinder finder({.reach = kReach});
  const auto bar = std::make_shared<const Shape>(kBar);
  finder.add(bar, {kHeading, Vector3::Zero()});
  finder.add(bar, beside(0));
  std::vector<ContactPoint> contacts;
  for (int step = 0; step < 3; ++step) finder.find(contacts);
  CHECK(contacts.empty());
  finder.set_reach(1.01 * kGap);
  finder.find(contacts);
  CHECK_FALSE(contacts.empty());
}

TEST_CASE("pairs apart: a crowd is answered as its pairs are alone, on any number of threads") {
  Random random(32);
  const auto cube = std::make_shared<const Shape>(make_box({0, 0, 0}, {0.5, 0.5, 0.25}));
  Points corners(3, 12);
  for (Eigen::Index k = 0; k < 12; ++k) corners.col(k) = 0.3 * random.direction();
  const auto stone = std::make_shared<const Shape>(quoin::geometry::make_hull(corners).polyhedron);
  const auto place = [&](int i, int step) {  // bricks that touch; stones that tumble between them
    Placement at;
    at.translation = Vector3(0.5 * (i % 4), 0.5 * (i / 4 % 4), 0.25 * (i / 16));
    if (i % 5 != 0) return at;
    const double time = 0.05 * step + i;
    at.linear = rotation_about(Vector3(0.6, 0.0, 0.8), time);
    at.translation += Vector3(0.1, 0.2, 0.6) * std::sin(time);
    return at;
  };
  constexpr int kCount = 48, kSteps = 25;
  std::vector<ContactFinder> finders;
  for (const int threads : {1, 2, 3}) {
    ContactFinder& finder =
        finders.emplace_back(quoin::geometry::FinderOptions{.reach = kReach, .threads = threads});
    for (int i = 0; i < kCount; ++i) finder.add(i % 5 == 0 ? stone : cube, place(i, 0));
  }
  for (int step = 0; step < kSteps; ++step) {
    std::vector<Body> bodies;
    std::vector<ContactPoint> expected, found;
    for (int i = 0; i < kCount; ++i)
      bodies.emplace_back(i % 5 == 0 ? *stone : *cube, place(i, step));
    for (int i = 0; i < kCount; ++i) {
      for (int k = i + 1; k < kCount; ++k) {
        append_contacts_within_reach({i, k}, bodies[static_cast<std::size_t>(i)],
                                     bodies[static_cast<std::size_t>(k)], {.reach = kReach}, {},
                                     expected);
      }
    }
    REQUIRE(expected.size() > 100);
    for (ContactFinder& finder : finders) {
      for (int i = 0; i < kCount; ++i) finder.move(i, place(i, step));
      finder.find(found);
      check_same(found, expected);
    }
  }
}
