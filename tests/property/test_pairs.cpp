/// Seeded random pairs of all families against the exact arbiter and against themselves.
///
/// QUOIN_SEED and QUOIN_CASES widen the search, QUOIN_FIRST is the number of the first pair asked;
/// QUOIN_FAMILY names one family ("every": each in turn, open or not). A failing pair is printed as
/// C++ that rebuilds it, and as text for tests/regressions; QUOIN_SHOW says how many of each kind
/// of fault.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <set>

#include "referee/pairs/families.hpp"
#include "support/catch.hpp"
#include "support/check_pair.hpp"
#include "support/random.hpp"
#include "support/sanitized.hpp"

namespace {

using namespace quoin::tests;

constexpr std::uint64_t kCases = unless_sanitized(30000, 5000);

struct Tally {
  long pairs = 0, failed = 0, refused = 0, undecided = 0;
  double worst = 0.0;  // gap error as a part of the allowed one
  std::map<std::string, long> kinds;
};

/// Which pairs are drawn: one family, each in turn, or all as often as they weigh.
class Source {
 public:
  Source() {
    const char* name = std::getenv("QUOIN_FAMILY");
    const std::vector<std::string>& names = quoin::tests::family_names();
    if (name != nullptr && std::string(name) == "every") {
      for (std::size_t i = 0; i < names.size(); ++i) chosen_.push_back(static_cast<int>(i));
    } else if (name != nullptr) {
      const auto place = std::find(names.begin(), names.end(), name);
      REQUIRE(place != names.end());
      chosen_.push_back(static_cast<int>(place - names.begin()));
    }
  }
  SolidPair draw(std::uint64_t number, Random& random) const {
    return chosen_.empty() ? quoin::tests::make_pair(random)
                           : quoin::tests::make_pair(chosen_[number % chosen_.size()], random);
  }

 private:
  std::vector<int> chosen_;
};

void show(const SolidPair& pair, std::uint64_t number, const std::vector<Fault>& faults) {
  std::printf("---- pair %llu\n", static_cast<unsigned long long>(number));
  for (const Fault& fault : faults)
    std::printf("  // %s: %s\n", fault.kind.c_str(), fault.text.c_str());
  std::printf("%s---- as text\n%s----\n", rebuild_code(pair).c_str(), to_text(pair).c_str());
}

std::set<std::string> count(const PairVerdict& verdict, Tally& tally) {
  std::set<std::string> kinds;
  for (const Fault& fault : verdict.faults) kinds.insert(fault.kind);
  ++tally.pairs;
  tally.failed += kinds.empty() ? 0 : 1;
  tally.refused += verdict.answered ? 0 : 1;
  tally.undecided += verdict.contact.nearest.indeterminate ? 1 : 0;
  if (verdict.answered && kinds.count("not converged") + kinds.count("not finite") == 0)
    tally.worst = std::max(tally.worst, verdict.gap_error / verdict.allowed_error);
  for (const std::string& kind : kinds) ++tally.kinds[kind];
  return kinds;
}

void print(const std::map<std::string, Tally>& tallies) {
  for (const auto& [name, tally] : tallies) {
    std::printf(
        "%-30s %8ld pairs %6ld failed %6ld refused %6ld indeterminate, worst gap error "
        "%.3g of allowed\n",
        name.c_str(), tally.pairs, tally.failed, tally.refused, tally.undecided, tally.worst);
  }
  for (const auto& [name, tally] : tallies)
    for (const auto& [kind, pairs] : tally.kinds)
      std::printf("%-30s %8ld  %s\n", name.c_str(), pairs, kind.c_str());
}

}  // namespace

TEST_CASE("pairs: exact gap, proof, exact patch, and the same answer however it is asked") {
  const std::uint64_t seed = environment_number("QUOIN_SEED", 1);
  const std::uint64_t cases = environment_number("QUOIN_CASES", kCases);
  const std::uint64_t first = environment_number("QUOIN_FIRST", 0);
  const std::uint64_t shown = environment_number("QUOIN_SHOW", 1);
  const Source source;
  std::map<std::string, Tally> tallies;
  std::map<std::string, std::uint64_t> examples;
  long failed = 0;
  const auto start = std::chrono::steady_clock::now();
  for (std::uint64_t i = first; i < cases; ++i) {
    Random random(seed * 1000003 + i);
    const SolidPair pair = source.draw(i, random);
    const PairVerdict verdict = quoin::tests::check_pair(pair, random);
    bool fresh = false;
    const bool placed = !stands_in_own_frame(pair.a) || !stands_in_own_frame(pair.b);
    const std::string row = pair.family + (placed ? ", placed" : "");
    for (const std::string& kind : count(verdict, tallies[row]))
      fresh = examples[row + kind]++ < shown || fresh;
    failed += verdict.faults.empty() ? 0 : 1;
    if (fresh) show(pair, i, verdict.faults);
  }
  const std::chrono::duration<double, std::ratio<60>> minutes =
      std::chrono::steady_clock::now() - start;
  print(tallies);
  std::printf("%.0f pairs a minute\n", static_cast<double>(cases) / minutes.count());
  CHECK(failed == 0);
}
