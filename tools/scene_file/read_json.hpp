#pragma once
/// The first half of reading a scene: text to a JSON document, changed, expanded and checked.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene_file/formula.hpp"

namespace quoin::scene_file {

/// What the JSON package says, without its own numbering, on one line.
std::string plain_message(const nlohmann::json::exception& error);

/// JSON with comments; a key given twice in one object is refused, and lists nested
/// more than 64 deep. Throws SceneError, FileError.
nlohmann::json read_json(const std::string& path);
nlohmann::json parse_json(const std::string& text);

/// Makes the changes "NAME=VALUE", then puts a number in place of each string that begins with "="
/// (an expression of the scene's parameters). Returns the parameters.
Parameters expand(nlohmann::json& document, const std::vector<std::string>& changes);

}  // namespace quoin::scene_file
