/// Structures that come down: many contacts that slide, open and meet again in each step.

#include <cmath>
#include <numbers>

#include <quoin/geometry/build.hpp>

#include "stability/cell.hpp"

namespace quoin::stability {
namespace {

solver::Material stone(double young) {
  return {.density = 2400, .young = young, .poisson = 0.2};
}

/// Exact is no overlap; relative to the block. Allowed is more than elsewhere: the normal of a face turns
/// with its block, but not with the strain of the step, through which a contact slides.
Result run_down(solver::Scene scene, double time_step, long steps) {
  Run run(std::move(scene), {.time_step = time_step});
  run.watches_energy = true;
  run.steps(steps);
  return {run.evidence.largest_overlap / run.evidence.block_size, run.evidence};
}

/// Nine voussoirs of a semicircle of 1 m, thinner (0.095 of the radius) than what stands.
Result run_arch(double young) {
  constexpr int kCount = 9;
  constexpr double kThickness = 0.095, kPi = std::numbers::pi;
  solver::Scene scene;
  scene.joint.friction_angle = radians(35);
  scene.add_fixed(geometry::make_box({-2, -2, -0.5}, {2, 2, 0}));
  const auto corner = [](double radius, double angle) {
    return Vector3(radius * std::cos(angle), -0.25, std::abs(radius * std::sin(angle)));
  };
  for (int i = 0; i < kCount; ++i) {
    const double from = kPi * i / kCount, to = kPi * (i + 1) / kCount;
    const double inner = 1.0 - 0.5 * kThickness, outer = 1.0 + 0.5 * kThickness;
    geometry::Points polygon(3, 4);
    polygon << corner(outer, from), corner(inner, from), corner(inner, to), corner(outer, to);
    if (i + 1 == kCount) polygon.row(2).tail<2>().setZero();
    scene.add_block(geometry::make_prism(polygon, {0, 0.5, 0}), stone(young));
  }
  return run_down(std::move(scene), 0.01, 60);
}

/// Four courses in running bond; gravity turned by 28 degrees out of the wall's plane, friction 20.
Result run_wall(double young) {
  solver::Scene scene;
  scene.joint.friction_angle = radians(20);
  scene.gravity = Vector3(0, kGravity * std::sin(radians(28)), -kGravity * std::cos(radians(28)));
  scene.add_fixed(geometry::make_box({-3, -3, -0.5}, {4, 4, 0}));
  constexpr double kLength = 0.24, kWidth = 0.12, kHeight = 0.08;
  for (int course = 0; course < 4; ++course) {
    const double bond = course % 2 == 0 ? 0.0 : 0.5 * kLength;
    for (int i = 0; i < 4; ++i) {
      const Vector3 low(bond + i * kLength, 0, course * kHeight);
      scene.add_block(geometry::make_box(low, low + Vector3(kLength, kWidth, kHeight)), stone(young));
    }
  }
  return run_down(std::move(scene), 0.005, 40);
}

}  // namespace

void append_collapse_cells(std::vector<Cell>& cells) {
  for (int exponent = 8; exponent <= 13; ++exponent) {
    const double young = std::pow(10.0, exponent);
    cells.push_back({"falling arch", {{"young", young}}, 1e-6, [=] { return run_arch(young); }});
    cells.push_back({"sliding wall", {{"young", young}}, 1e-6, [=] { return run_wall(young); }});
  }
}

}  // namespace quoin::stability
