/// A block that rocks: what an impact leaves of its swing does not hang on where in the step it
/// comes.

#include <algorithm>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr double kHalfWidth = 0.2, kHeight = 1.6, kGravity = 9.81;
const double kStart = 7.0 * std::acos(-1.0) / 180.0;  // rad, about the right edge

/// Angle of the first swing to the other side, rad: what Housner's rate ratio leaves of the energy.
double exact_peak() {
  const double alpha = std::atan(2.0 * kHalfWidth / kHeight);
  const double ratio = 1.0 - 1.5 * std::pow(std::sin(alpha), 2);
  const double fall = std::cos(alpha - kStart) - std::cos(alpha);
  return alpha - std::acos(std::cos(alpha) + ratio * ratio * fall);
}

double relative_peak_error(double time_step) {
  Scene scene{.joint = {.friction_angle = 1.05}};  // the impact does not slip
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  const int block = scene.add_rigid(
      geometry::make_box({-kHalfWidth, -0.2, 0}, {kHalfWidth, 0.2, kHeight}), {.density = 2600});
  const Matrix3 tilt = Eigen::AngleAxisd(kStart, Vector3::UnitY()).toRotationMatrix();
  const Vector3 edge(kHalfWidth, 0, 0);
  scene.blocks[static_cast<std::size_t>(block)].placement = {.linear = tilt,
                                                             .translation = edge - tilt * edge};
  Simulation simulation(scene, {.time_step = time_step});
  double least = kStart;
  while (simulation.state().time < 1.1) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    const BlockState& now = simulation.state().blocks[1];
    const Vector3 turned = now.rotation * tilt * Vector3::UnitZ();
    least = std::min(least, std::atan2(turned.x(), turned.z()));
    const bool returns = least < 0.0 && now.angular_velocity.y() > 0.0;
    if (returns) break;
  }
  return -least / exact_peak() - 1.0;
}

}  // namespace

TEST_CASE(
    "The peak after an impact is good to 1e-4 at a step of 0.01 s, and falls with its square") {
  CHECK_THAT(relative_peak_error(0.01), WithinAbs(0.0, 1e-4));
  CHECK_THAT(relative_peak_error(0.005), WithinAbs(0.0, 2.5e-5));
  CHECK_THAT(relative_peak_error(0.0025), WithinAbs(0.0, 6.25e-6));
}

TEST_CASE("Wherever in the step the impact comes, at 0.4407 s") {
  for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9, 0.97}) {
    CAPTURE(share);
    CHECK_THAT(relative_peak_error(0.440674 / (48.0 + share)), WithinAbs(0.0, 6e-4));
  }
}
