/// libccd and FCL are asked the same questions. Where they and quoin differ the exact arbiter
/// decides; the counts are printed. quoin may never be the one who is wrong.

#include <cmath>
#include <cstdio>
#include <map>
#include <quoin/geometry/gjk_oracle.hpp>

#include "support/catch.hpp"
#include "support/check_pair.hpp"

namespace {

using quoin::geometry::OracleAnswer;
using quoin::tests::diameter;
using quoin::tests::environment_number;
using quoin::tests::exact_gap;
using quoin::tests::Random;
using quoin::tests::SolidPair;

constexpr std::uint64_t kCases = 10000;
constexpr double kDisagreement = 1e-9;  // of the smaller diameter

struct Score {
  long asked = 0, silent = 0, agreed = 0, peer_wrong = 0, quoin_wrong = 0;
  double worst = 0.0;  // error of the peer as a part of the smaller diameter
};

void judge(Score& score, const OracleAnswer& answer, double gap, long double exact, double size) {
  ++score.asked;
  if (!answer.answered || !std::isfinite(answer.gap)) {
    ++score.silent;
    return;
  }
  const double peer_error = static_cast<double>(std::abs(answer.gap - exact)) / size;
  const double own_error = static_cast<double>(std::abs(gap - exact)) / size;
  score.worst = std::max(score.worst, peer_error);
  if (std::abs(answer.gap - gap) <= kDisagreement * size) {
    ++score.agreed;
  } else if (peer_error >= own_error) {
    ++score.peer_wrong;
  } else {
    ++score.quoin_wrong;
  }
}

}  // namespace

TEST_CASE("oracle: where libccd or FCL disagree with quoin the arbiter finds them wrong") {
  const std::uint64_t seed = environment_number("QUOIN_SEED", 1);
  const std::uint64_t cases = environment_number("QUOIN_CASES", kCases);
  std::map<std::string, Score> scores;
  Score overlap_test;
  for (std::uint64_t i = 0; i < cases; ++i) {
    Random random(seed * 7000003 + i);
    const SolidPair pair = quoin::tests::make_pair(random);
    const double size = std::min(diameter(pair.a), diameter(pair.b));
    const double gap = nearest_features(pair.a, pair.b).gap;
    const quoin::tests::ExactGap exact = exact_gap(pair.a.vertices(), pair.b.vertices());
    const bool overlapping = exact.gap < 0;
    ++overlap_test.asked;
    (gjk_overlap(pair.a, pair.b) == overlapping ? overlap_test.agreed : overlap_test.peer_wrong)++;
    const double tolerance = 1e-12 * size;
    if (overlapping) {
      judge(scores["libccd EPA depth"], epa_depth(pair.a, pair.b, tolerance), gap, exact.gap, size);
      judge(scores["libccd MPR depth"], mpr_depth(pair.a, pair.b, tolerance), gap, exact.gap, size);
    } else {
      judge(scores["FCL GJK distance"], gjk_distance(pair.a, pair.b, tolerance), gap, exact.gap,
            size);
    }
  }
  std::printf("%-18s %8s %8s %8s %11s %12s %s\n", "", "asked", "silent", "agreed", "peer wrong",
              "quoin wrong", "peer's worst error / smaller diameter");
  long quoin_wrong = 0;
  for (const auto& [name, s] : scores) {
    std::printf("%-18s %8ld %8ld %8ld %11ld %12ld %.2g\n", name.c_str(), s.asked, s.silent,
                s.agreed, s.peer_wrong, s.quoin_wrong, s.worst);
    quoin_wrong += s.quoin_wrong;
    CHECK(s.asked > 0);
    CHECK(s.agreed > s.asked / 10);  // an oracle that never agrees is none
  }
  std::printf("libccd GJK overlap %8ld %8s %8ld %11ld\n", overlap_test.asked, "",
              overlap_test.agreed, overlap_test.peer_wrong);
  CHECK(quoin_wrong == 0);
}
