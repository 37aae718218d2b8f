#pragma once
/// Checks a JSON document against a JSON Schema, as much of it as scene.schema.json uses: type,
/// enum, const, required, properties, additionalProperties, items, min/maxItems, min/maxLength
/// (text with a maxLength is one line: no control characters),
/// minimum, maximum, exclusiveMinimum, exclusiveMaximum, oneOf, $ref within the schema. Beside
/// these `x-instead`: keys that an object does not have, with what takes their place.

#include <nlohmann/json_fwd.hpp>

namespace quoin::scene_file {

/// Throws SceneError for the first breach: its place in the document and what is wrong there.
void check_schema(const nlohmann::json& schema, const nlohmann::json& document);

}  // namespace quoin::scene_file
