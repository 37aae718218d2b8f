/// What a document that breaks a schema is told, to the letter: a line of schema_check.jsonl each.

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "scene_file/scene_error.hpp"
#include "scene_file/schema_check.hpp"
#include "support/catch.hpp"

using nlohmann::json;

namespace {

std::string breach(const json& schema, const json& document) {
  try {
    quoin::scene_file::check_schema(schema, document);
  } catch (const quoin::scene_file::SceneError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("each document is told its breach, with its place, or nothing") {
  std::ifstream cases(QUOIN_SOURCE_DIR "/tests/unit/schema_check.jsonl");
  int count = 0;
  for (std::string text; std::getline(cases, text); ++count) {
    const json line = json::parse(text);
    INFO(text);
    CHECK(breach(line["schema"], line["document"]) == line["said"]);
  }
  CHECK(count >= 28);
  CHECK(breach({{"minimum", 0}}, std::nan("")) != "");
}
