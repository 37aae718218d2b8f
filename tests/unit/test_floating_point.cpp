/// A changed rounding mode is told where a shape is made. (-ffast-math: see CMakeLists.txt.)

#include "geometry/src/numeric/floating_point.hpp"

#include <cfenv>
#include <quoin/geometry/build.hpp>
#include <string>

#include "support/catch.hpp"
#include "support/message.hpp"

using namespace quoin;

namespace {

/// The message of the error, empty: none.
template <class Make>
std::string refusal_in_mode(int mode, const Make& make) {
  std::fesetround(mode);
  const std::string said = tests::message(make);
  std::fesetround(FE_TONEAREST);
  return said;
}

bool rounds_to_nearest_in(int mode) {
  std::fesetround(mode);
  const bool nearest = geometry::rounds_to_nearest();
  std::fesetround(FE_TONEAREST);
  return nearest;
}

}  // namespace

TEST_CASE("the rounding mode is told from any other") {
  CHECK(rounds_to_nearest_in(FE_TONEAREST));
  CHECK_FALSE(rounds_to_nearest_in(FE_UPWARD));
  CHECK_FALSE(rounds_to_nearest_in(FE_DOWNWARD));
  CHECK_FALSE(rounds_to_nearest_in(FE_TOWARDZERO));
}

TEST_CASE("no shape is made in a changed rounding mode") {
  const geometry::Shape box = geometry::make_box({0, 0, 0}, {1, 1, 1});
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    CHECK(refusal_in_mode(mode,
                          [&] {
                            geometry::make_box({0, 0, 0}, {1, 1, 1});
                          }) ==
          "the rounding mode of floating point is changed, limit round-to-nearest: "
          "std::fesetround(FE_TONEAREST)");
    CHECK(refusal_in_mode(mode, [&] { geometry::make_hull(box.vertices()); }) != "");
    CHECK(refusal_in_mode(mode, [&] { geometry::Shape(box.shared_topology(), box.vertices()); }) !=
          "");
  }
  CHECK(refusal_in_mode(FE_TONEAREST, [&] { geometry::make_hull(box.vertices()); }) == "");
}
