/// The case files of tools/scenes/cases come to what they say, also under sanitizers;
/// tests/tools/test_case_scenes.py runs them elsewhere.

#include "scene_file/cases.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/catch.hpp"
#include "support/sanitized.hpp"

TEST_CASE("case files come to what they say") {
  int runs = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(QUOIN_SOURCE_DIR "/tools/scenes/cases")) {
    std::stringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    if (text.str().find("\"cases\"") == std::string::npos) continue;
    CAPTURE(entry.path());
    const quoin::scene_file::CaseFile file(entry.path().string());
    for (const auto& run : file.runs(quoin::tests::kSanitized)) {
      const auto outcome = file.run(run);
      CHECK(outcome.flags == run.flags);
      for (const auto& row : outcome.rows) {
        CAPTURE(row.quantity, row.result, row.exact, row.error, row.allowed);
        CHECK(row.ok);
      }
      ++runs;
    }
  }
  CHECK(runs > 100);
}
