/// Seeded random pairs of all families against the exact arbiter and against themselves.
///
/// QUOIN_SEED and QUOIN_CASES widen the search; QUOIN_FAMILY names one family. A failing pair is
/// printed as C++ that rebuilds it, and as text for tests/regressions.

#include <cstdio>
#include <map>

#include "support/catch.hpp"
#include "support/check_pair.hpp"

namespace {

using quoin::tests::environment_number;
using quoin::tests::PairVerdict;
using quoin::tests::Random;
using quoin::tests::SolidPair;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kCases = 5000;
#else
constexpr std::uint64_t kCases = 100000;
#endif
constexpr int kShown = 5;  // failing pairs printed in full

struct Tally {
  long pairs = 0, failed = 0, undecided = 0;
  double worst = 0.0;  // gap error as a part of the allowed one
};

int family_number(const char* name) {
  const std::vector<std::string>& names = quoin::tests::family_names();
  for (std::size_t i = 0; name != nullptr && i < names.size(); ++i) {
    if (names[i] == name) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

void show(const SolidPair& pair, std::uint64_t number, const std::vector<std::string>& faults) {
  std::printf("---- pair %llu\n", static_cast<unsigned long long>(number));
  for (const std::string& fault : faults) {
    std::printf("  // %s\n", fault.c_str());
  }
  std::printf("%s---- as text\n%s----\n", rebuild_code(pair).c_str(), to_text(pair).c_str());
}

}  // namespace

TEST_CASE("pairs: exact gap, proof, and the same answer however it is asked") {
  const std::uint64_t seed = environment_number("QUOIN_SEED", 1);
  const std::uint64_t cases = environment_number("QUOIN_CASES", kCases);
  const int family = family_number(std::getenv("QUOIN_FAMILY"));
  std::map<std::string, Tally> tallies;
  std::map<std::string, long> kinds;
  long failed = 0;
  for (std::uint64_t i = 0; i < cases; ++i) {
    Random random(seed * 1000003 + i);
    const SolidPair pair =
        family < 0 ? quoin::tests::make_pair(random) : quoin::tests::make_pair(family, random);
    PairVerdict verdict = check_against_exact(pair);
    const std::vector<std::string> more = check_symmetries(pair, verdict.nearest, random);
    verdict.faults.insert(verdict.faults.end(), more.begin(), more.end());
    Tally& tally = tallies[pair.family];
    ++tally.pairs;
    tally.undecided += verdict.nearest.indeterminate ? 1 : 0;
    tally.worst = std::max(tally.worst, verdict.gap_error / verdict.allowed_error);
    if (!verdict.faults.empty()) {
      ++tally.failed;
      for (const std::string& fault : verdict.faults) {
        ++kinds[pair.family + ": " + fault.substr(0, fault.find_first_of("0123456789-"))];
      }
      if (++failed <= kShown) {
        show(pair, i, verdict.faults);
      }
    }
  }
  for (const auto& [name, tally] : tallies) {
    std::printf("%-16s %8ld pairs %6ld failed %6ld indeterminate, worst error %.3g of allowed\n",
                name.c_str(), tally.pairs, tally.failed, tally.undecided, tally.worst);
  }
  for (const auto& [kind, count] : kinds) {
    std::printf("%8ld  %s\n", count, kind.c_str());
  }
  CHECK(failed == 0);
}
