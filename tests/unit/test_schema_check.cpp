/// What a document that breaks a schema is told, to the letter: a line of schema_check.jsonl each.

#include <cmath>
#include <nlohmann/json.hpp>

#include "scene_file/scene_error.hpp"
#include "scene_file/schema_check.hpp"
#include "support/catch.hpp"
#include "support/json_lines.hpp"
#include "support/message.hpp"

using nlohmann::json;

namespace {

std::string breach(const json& schema, const json& document) {
  return quoin::tests::message<quoin::scene_file::SceneError>(
      [&] { quoin::scene_file::check_schema(schema, document); });
}

}  // namespace

TEST_CASE("each document is told its breach, with its place, or nothing") {
  quoin::tests::for_each_line(
      QUOIN_SOURCE_DIR "/tests/unit/schema_check.jsonl", 28,
      [](const json& line) { CHECK(breach(line["schema"], line["document"]) == line["said"]); });
  CHECK(breach({{"minimum", 0}}, std::nan("")) != "");
}
