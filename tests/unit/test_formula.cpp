#include <numbers>

#include "scene_file/formula.hpp"
#include "support/catch.hpp"

using quoin::scene_file::Formula;
using namespace quoin::tests;

TEST_CASE("a formula of t with constants and parameters") {
  const Formula fall("-g/2 * t^2 + rise", {{"rise", 3.0}});
  CHECK_THAT(fall.at(0.0), WithinAbs(3.0, 0.0));
  CHECK_THAT(fall.at(2.0), WithinRel(3.0 - 9.81 * 2, 1e-15));
  CHECK_THAT(Formula("sin(30*deg) + cos(pi)", {}).at(0.0), WithinRel(-0.5, 1e-15));
  CHECK_THAT(Formula("t < 1 ? 5 : 7", {}).at(0.5), WithinAbs(5.0, 0.0));
}

TEST_CASE("a parameter may stand in for a constant") {
  CHECK_THAT(Formula("g", {{"g", 10.0}}).at(0.0), WithinAbs(10.0, 0.0));
}

TEST_CASE("a copied formula keeps its own time") {
  Formula first("t", {});
  Formula copy = first;
  CHECK(first.at(1.0) == 1.0);
  CHECK(copy.at(2.0) == 2.0);
  CHECK(first.at(3.0) == 3.0);
  copy = Formula("2*t", {});
  CHECK(copy.at(3.0) == 6.0);
}

TEST_CASE("what is no formula is refused, naming it") {
  for (const char* text : {"", "sin(", "2*x", "t t"})
    CHECK_THROWS_AS(Formula(text, {}), std::invalid_argument);
  CHECK_THROWS_WITH(Formula("2*x", {}), ContainsSubstring("2*x") && ContainsSubstring("\"x\""));
}
