#include <cmath>

#include "solver/src/contact/joint_area.hpp"
#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
using Eigen::Vector2d;

namespace {

std::vector<Vector2d> rectangle(double x, double y) { return {{0, 0}, {x, 0}, {x, y}, {0, y}}; }

}  // namespace

TEST_CASE("Mean distance of a polygon's points from a place") {
  const double square = (std::sqrt(2.0) + std::log(1.0 + std::sqrt(2.0))) / 6.0;  // from its centre
  CHECK_THAT(mean_distance(rectangle(1, 1), {0.5, 0.5}), WithinRel(square, 1e-12));
  CHECK_THAT(mean_distance(rectangle(1, 1), {0, 0}), WithinRel(2.0 * square, 1e-12));
  // From beside it: by the four squares that have the place as a corner.
  CHECK_THAT(mean_distance(rectangle(1, 1), {-1, 0}),
             WithinRel(2.0 * mean_distance(rectangle(2, 1), {0, 0}) - 2.0 * square, 1e-12));
}
