#pragma once
/// The first half of reading a scene: text to a JSON document, changed, expanded and checked.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene_file/formula.hpp"

namespace quoin::scene_file {

/// JSON with comments; a key given twice in one object is refused. Throws SceneError, FileError.
nlohmann::json read_json(const std::string& path);

/// Makes the changes "NAME=VALUE", then puts a number in place of each string that begins with "="
/// (an expression of the scene's parameters). Returns the parameters.
Parameters expand(nlohmann::json& document, const std::vector<std::string>& changes);

}  // namespace quoin::scene_file
