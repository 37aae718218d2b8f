#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "scene_file/scene_error.hpp"
#include "scene_file/schema_check.hpp"
#include "support/catch.hpp"

using nlohmann::json;
using quoin::scene_file::check_schema;
using quoin::scene_file::SceneError;
using namespace quoin::tests;

namespace {

std::string breach(const json& schema, const json& document) {
  try {
    check_schema(schema, document);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

const json kShapes = json::parse(R"({
  "oneOf": [{"$ref": "#/$defs/ball"}, {"$ref": "#/$defs/cube"}, {"type": "number"}],
  "$defs": {
    "ball": {"type": "object", "required": ["type", "radius"], "additionalProperties": false,
             "properties": {"type": {"const": "ball"}, "radius": {"type": "number"}}},
    "cube": {"type": "object", "required": ["type", "side"], "additionalProperties": false,
             "properties": {"type": {"const": "cube"}, "side": {"type": "number"}}}}})");

}  // namespace

TEST_CASE("types") {
  CHECK(breach({{"type", "number"}}, 1) == "");
  CHECK(breach({{"type", "integer"}}, 1.5) == "/: must be of type integer, is number");
  CHECK(breach({{"type", {"string", "integer"}}}, json::array()) ==
        "/: must be of type string or integer, is array");
}

TEST_CASE("bounds of numbers") {
  CHECK(breach({{"minimum", 0}}, 0) == "");
  CHECK(breach({{"minimum", 0}}, -1) == "/: must be at least 0, is -1");
  CHECK(breach({{"exclusiveMinimum", 0}}, 0) == "/: must be greater than 0, is 0");
  CHECK(breach({{"maximum", 1}}, 2) == "/: must be at most 1, is 2");
  CHECK(breach({{"exclusiveMaximum", 0.5}}, 0.5) == "/: must be less than 0.5, is 0.5");
  CHECK(breach({{"minimum", 0}}, std::nan("")) != "");
}

TEST_CASE("arrays: length and place of the item that is wrong") {
  const json schema = {{"items", {{"type", "number"}}}, {"minItems", 2}, {"maxItems", 2}};
  CHECK(breach(schema, {1, 2}) == "");
  CHECK(breach(schema, {1}) == "/: must have 2 items, has 1");
  CHECK(breach(schema, {1, "x"}) == "/1: must be of type number, is string");
}

TEST_CASE("objects: keys unknown and missing, and the one that was meant") {
  const json schema = {{"properties", {{"density", {{"type", "number"}}}}},
                       {"required", {"density"}},
                       {"additionalProperties", false}};
  CHECK(breach(schema, {{"density", 1}}) == "");
  CHECK(breach(schema, {{"dnsity", 1}}) ==
        "/dnsity: unknown key \"dnsity\"; did you mean \"density\"?");
  CHECK(breach(schema, {{"density", 1}, {"a/b", 1}}) == "/a~1b: unknown key \"a/b\"");
  CHECK(breach(schema, json::object()) == "/: missing key \"density\"");
}

TEST_CASE("a key without its unit, or with words of a known one, is told which was meant") {
  json schema = {{"additionalProperties", false}, {"properties", json::object()}};
  for (const char* key : {"dilation_angle_deg", "friction_angle_deg", "normal_stiffness",
                          "residual_friction_angle_deg", "young"})
    schema["properties"][key] = {{"type", "number"}};
  const auto asked = [&](const char* key) { return breach(schema, {{key, 1}}); };
  CHECK(asked("friction_angle") ==
        "/friction_angle: unknown key \"friction_angle\"; did you mean \"friction_angle_deg\"?");
  for (const auto& [key, wanted] :
       std::map<const char*, const char*>{{"friction", "friction_angle_deg"},
                                          {"residual_friction", "residual_friction_angle_deg"},
                                          {"stiffness_normal", "normal_stiffness"},
                                          {"youngs_modulus", "young"}})
    CHECK(asked(key).ends_with("; did you mean \"" + std::string(wanted) + "\"?"));
  CHECK(asked("tilt_deg") == "/tilt_deg: unknown key \"tilt_deg\"");
}

TEST_CASE("a key of another kind of object is told what takes its place") {
  const json schema = {{"x-instead", {{"$ref", "#/$defs/no_time"}}},
                       {"additionalProperties", false},
                       {"properties", {{"max_steps", {{"type", "integer"}}}}},
                       {"$defs", {{"no_time", {{"time_step", "give \"max_steps\""}}}}}};
  CHECK(breach(schema, {{"time_step", 1}}) ==
        "/time_step: unknown key \"time_step\": give \"max_steps\"");
}

TEST_CASE("of several alternatives the message is about the one that was meant") {
  CHECK(breach(kShapes, {{"type", "ball"}, {"radius", 1}}) == "");
  CHECK(breach(kShapes, 3) == "");
  CHECK(breach(kShapes, {{"type", "ball"}, {"side", 1}}) == "/side: unknown key \"side\"");
  CHECK(breach(kShapes, {{"type", "cone"}}) == "/type: must be \"ball\" or \"cube\", is \"cone\"");
  CHECK(breach(kShapes, {{"side", 1}}) == "/: missing key \"type\" (\"ball\" or \"cube\")");
  CHECK(breach(kShapes, "ball") == "/: must be of type object or number, is string");
}
