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

/// Angle of the swing after an impact, rad: what Housner's rate ratio leaves of the energy.
double exact_peak(double before) {
  const double alpha = std::atan(2.0 * kHalfWidth / kHeight);
  const double ratio = 1.0 - 1.5 * std::pow(std::sin(alpha), 2);
  const double fall = std::cos(alpha - before) - std::cos(alpha);
  return alpha - std::acos(std::cos(alpha) + ratio * ratio * fall);
}

Matrix3 tilted(double angle) {
  return Eigen::AngleAxisd(angle, Vector3::UnitY()).toRotationMatrix();
}

Scene rocking_block(double start) {
  Scene scene{.joint = {.friction_angle = 1.05}};  // the impact does not slip
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  const int block = scene.add_rigid(
      geometry::make_box({-kHalfWidth, -0.2, 0}, {kHalfWidth, 0.2, kHeight}), {.density = 2600});
  const Matrix3 tilt = tilted(start);
  const Vector3 edge(kHalfWidth, 0, 0);
  scene.blocks[static_cast<std::size_t>(block)].placement = {.linear = tilt,
                                                             .translation = edge - tilt * edge};
  return scene;
}

/// How far a block leans that has started so, rad.
double lean(const Simulation& simulation, double start) {
  const Vector3 turned = simulation.state().blocks[1].rotation * tilted(start) * Vector3::UnitZ();
  return std::atan2(turned.x(), turned.z());
}

double relative_peak_error(double time_step) {
  Simulation simulation(rocking_block(kStart), {.time_step = time_step});
  double least = kStart;
  while (simulation.state().time < 1.1) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    const BlockState& now = simulation.state().blocks[1];
    least = std::min(least, lean(simulation, kStart));
    const bool returns = least < 0.0 && now.angular_velocity.y() > 0.0;
    if (returns) break;
  }
  return -least / exact_peak(kStart) - 1.0;
}

/// Of the swing after the fourth impact.
double relative_fourth_peak_error(double start, double time_step) {
  Simulation simulation(rocking_block(start), {.time_step = time_step});
  double last = start, peak = 0.0, exact = start;
  for (int impacts = 0; impacts < 5;) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
    REQUIRE(simulation.state().time < 10.0);
    const double now = lean(simulation, start);
    const bool upright = now * last < 0.0;
    if (upright && ++impacts == 5) break;
    if (upright) exact = exact_peak(exact);
    peak = upright ? std::abs(now) : std::max(peak, std::abs(now));
    last = now;
  }
  return peak / exact - 1.0;
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

TEST_CASE("Swings whose edge lands slower than what gravity does in two steps") {
  const double alpha = std::atan(2.0 * kHalfWidth / kHeight);
  for (const double time_step : {0.0025, 0.005, 0.01}) {
    CAPTURE(time_step);
    CHECK_THAT(relative_fourth_peak_error(0.05 * alpha, time_step),
               WithinAbs(0.0, 60.0 * time_step * time_step));
  }
}
