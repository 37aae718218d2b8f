/// Every pair that ever failed (tests/regressions/*.txt), asked again.
///
/// A file: comment lines (#), the name of the family, then for each of the two solids the numbers
/// of vertices and faces, the vertices in hexadecimal floats (m), the faces as counts and indices
/// (no faces: the hull of the points), and perhaps "placed" with translation and matrix by rows.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/catch.hpp"
#include "support/check_pair.hpp"

namespace {

std::vector<std::filesystem::path> files() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry :
       std::filesystem::directory_iterator(QUOIN_SOURCE_DIR "/tests/regressions"))
    if (entry.path().extension() == ".txt") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::ostringstream text;
  for (std::string line; std::getline(in, line);)
    if (line.empty() || line.front() != '#') text << line << '\n';
  return text.str();
}

}  // namespace

TEST_CASE("regressions: every pair that ever failed") {
  const std::vector<std::filesystem::path> paths = files();
  REQUIRE(!paths.empty());
  for (const std::filesystem::path& path : paths) {
    CAPTURE(path.filename().string());
    const quoin::tests::SolidPair pair = quoin::tests::from_text(text_of(path));
    for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
      quoin::tests::Random random(seed);
      for (const quoin::tests::Fault& fault : quoin::tests::check_pair(pair, random).faults)
        FAIL_CHECK(fault.kind << ": " << fault.text);
    }
  }
}
