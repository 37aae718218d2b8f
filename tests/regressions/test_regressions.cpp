/// Every pair that ever failed (tests/regressions/pairs.txt), asked again.

#include <fstream>

#include "support/catch.hpp"
#include "support/check_pair.hpp"

TEST_CASE("regressions: every pair that ever failed") {
  std::ifstream in(QUOIN_SOURCE_DIR "/tests/regressions/pairs.txt");
  int pairs = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.front() == '#') continue;
    const std::size_t end_of_name = line.find(' ');
    CAPTURE(line.substr(0, end_of_name));
    const quoin::tests::SolidPair pair = quoin::tests::from_text(line.substr(end_of_name));
    for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
      quoin::tests::Random random(seed);
      for (const quoin::tests::Fault& fault : quoin::tests::check_pair(pair, random).faults)
        FAIL_CHECK(fault.kind << ": " << fault.text);
    }
    ++pairs;
  }
  CHECK(pairs > 70);
}
