/// Pairs in coherent motion: each step started from the last one's features gives, to the bit, the
/// answer of a cold start. QUOIN_SEED and QUOIN_CASES (runs of 50 steps) widen the search.

#include <cstdio>
#include <quoin/geometry/nearest_features.hpp>

#include "referee/pairs/families.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"
#include "support/sanitized.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

constexpr std::uint64_t kRuns = unless_sanitized(10000, 100);
constexpr int kSteps = 50;
constexpr int kShown = 3;

bool same(const NearestFeatures& n, const NearestFeatures& m) {
  const bool answer = n.gap == m.gap && n.status == m.status && n.indeterminate == m.indeterminate;
  return answer && (n.indeterminate ||
                    (n.normal == m.normal && n.point_a == m.point_a && n.point_b == m.point_b &&
                     n.feature_a == m.feature_a && n.feature_b == m.feature_b));
}

}  // namespace

TEST_CASE("coherent motion: warm and cold agree to the bit") {
  const std::uint64_t seed = environment_number("QUOIN_SEED", 1);
  const std::uint64_t runs = environment_number("QUOIN_CASES", kRuns);
  long differing = 0, steps = 0, cold_iterations = 0, warm_iterations = 0;
  for (std::uint64_t run = 0; run < runs; ++run) {
    Random random(seed * 3000017 + run);
    SolidPair pair = quoin::tests::make_pair(random);
    pair = {pair.family, polyhedron_of(pair.a), polyhedron_of(pair.b)};
    const double amount = random.log_uniform(1e-5, 1e-2);
    FeatureHint hint;
    for (int step = 0; step < kSteps; ++step) {
      const Shape a = shape_of(pair.a), b = shape_of(pair.b);
      const NearestFeatures cold = nearest_features(a, b);
      const NearestFeatures warm = nearest_features(a, b, {}, hint);
      ++steps;
      cold_iterations += cold.iterations;
      warm_iterations += warm.iterations;
      if (!same(cold, warm) && ++differing <= kShown) {
        std::printf("---- run %llu step %d: gap %.17g cold, %.17g warm\n%s----\n",
                    static_cast<unsigned long long>(run), step, cold.gap, warm.gap,
                    to_text(pair).c_str());
      }
      hint = warm.hint;
      pair = moved_on(pair, amount, random);
    }
  }
  std::printf("%ld steps, iterations a step: cold %.2f, warm %.2f\n", steps,
              static_cast<double>(cold_iterations) / static_cast<double>(steps),
              static_cast<double>(warm_iterations) / static_cast<double>(steps));
  CHECK(differing == 0);
  CHECK(warm_iterations < cold_iterations);
}
