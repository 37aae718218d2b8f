/// Double-double against whole numbers: what is said to be exact is, the rest to 1e-31.

#include "geometry/src/numeric/double_double.hpp"

#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

__extension__ typedef __int128 Whole;

using namespace quoin::geometry;
using quoin::tests::Random;

}  // namespace

TEST_CASE("double-double: sums, differences and products of doubles are exact") {
  Random random(3);
  for (int round = 0; round < 10000; ++round) {
    const double a = random.log_uniform(1e-8, 1e8), b = -random.log_uniform(1e-8, 1e8);
    const Whole wide_a = static_cast<Whole>(a * 0x1p62), wide_b = static_cast<Whole>(b * 0x1p62);
    const DoubleDouble sum = two_sum(a, b);
    const auto whole = [](const DoubleDouble& x) {
      return static_cast<Whole>(x.high * 0x1p62) + static_cast<Whole>(x.low * 0x1p62);
    };
    if (a * 0x1p62 == static_cast<double>(wide_a) && b * 0x1p62 == static_cast<double>(wide_b)) {
      REQUIRE(whole(sum) == wide_a + wide_b);
      REQUIRE(whole(two_difference(a, b)) == wide_a - wide_b);
    }
    const long long p = random.integer(1, 1 << 30) * 4194301LL,
                    q = random.integer(1, 1 << 30) * 4194301LL;
    const DoubleDouble product = two_product(static_cast<double>(p), static_cast<double>(q));
    REQUIRE(static_cast<Whole>(product.high) + static_cast<Whole>(product.low) ==
            static_cast<Whole>(p) * q);
  }
}

TEST_CASE("double-double: division and square root undo multiplication") {
  Random random(4);
  for (int round = 0; round < 10000; ++round) {
    const DoubleDouble a = two_product(random.uniform(0.5, 2), random.uniform(0.5, 2));
    const DoubleDouble b = two_product(random.uniform(0.5, 2), random.uniform(0.5, 2));
    const DoubleDouble back = (a * b) / b - a;
    REQUIRE(std::abs(back.high) < 1e-30);
    const DoubleDouble root = square_root(a * a) - a;
    REQUIRE(std::abs(root.high) < 1e-30);
  }
}
