/// Pairs that last step's plane parts are found when their bodies meet.

#include <quoin/geometry.hpp>

#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/same_contacts.hpp"

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
      REQUIRE(same_but_previous(found, expected));
      ++(found.empty() ? apart : in_contact);
    }
    CHECK(in_contact > 10);
    CHECK(apart > 100);
  }
}
