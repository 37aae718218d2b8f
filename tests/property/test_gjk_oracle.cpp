/// libccd and FCL are asked the same questions. Where they and quoin differ the exact arbiter
/// decides; the counts are printed. quoin may never be the one who is wrong.

#include <cmath>
#include <cstdio>
#include <map>
#include <quoin/geometry/gjk_oracle.hpp>

#include "referee/pairs/families.hpp"
#include "support/catch.hpp"
#include "support/check_pair.hpp"
#include "support/random.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kCases = 1000;
#else
constexpr std::uint64_t kCases = 10000;
#endif
constexpr double kPeerAllowed = 1e-9;  // error that a peer is granted, of the smaller diameter

struct Score {
  long asked = 0, silent = 0, agreed = 0, peer_wrong = 0, quoin_wrong = 0;
  double worst = 0.0;  // error of the peer as a part of the smaller diameter
};

/// What is asked of one pair, and the right answer.
struct Question {
  double gap = 0.0;  // quoin's, m
  long double exact = 0.0;
  double allowed = 0.0;  // error of quoin, m
  double size = 0.0;     // smaller diameter, m
};

void judge(Score& score, const OracleAnswer& answer, const Question& question) {
  ++score.asked;
  if (!answer.answered || !std::isfinite(answer.gap)) {
    ++score.silent;
    return;
  }
  const double peer_error = static_cast<double>(std::abs(answer.gap - question.exact));
  const double own_error = static_cast<double>(std::abs(question.gap - question.exact));
  score.worst = std::max(score.worst, peer_error / question.size);
  if (!(own_error <= question.allowed))
    ++score.quoin_wrong;
  else if (!(peer_error <= kPeerAllowed * question.size + question.allowed))
    ++score.peer_wrong;
  else
    ++score.agreed;
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
    const quoin::tests::PairVerdict verdict = quoin::tests::check_against_exact(pair);
    const Shape a = polyhedron_of(pair.a), b = polyhedron_of(pair.b);
    const Question question{verdict.contact.nearest.gap, verdict.exact.gap, verdict.allowed_error,
                            std::min(diameter(a), diameter(b))};
    const bool overlapping = verdict.exact.gap < 0;
    const double tolerance = 1e-12 * question.size;
    if (std::abs(question.gap) > kPeerAllowed * question.size + question.allowed) {
      const bool right = gjk_overlap(a, b) == overlapping;
      ++overlap_test.asked;
      (right ? overlap_test.agreed : overlap_test.peer_wrong)++;
    }
    if (overlapping) {
      judge(scores["libccd EPA depth"], epa_depth(a, b, tolerance), question);
      judge(scores["libccd MPR depth"], mpr_depth(a, b, tolerance), question);
    } else {
      judge(scores["FCL GJK distance"], gjk_distance(a, b, tolerance), question);
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
