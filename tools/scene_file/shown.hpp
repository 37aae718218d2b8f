#pragma once
/// What others wrote, as a message may show it.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace quoin::scene_file {

/// Without control characters and bytes that are no UTF-8 (\xNN in their place), cut behind `most`
/// bytes.
std::string printable(std::string_view text, std::size_t most);

/// A JSON value on one line, cut where it is long.
std::string shown(const nlohmann::json& value);

}  // namespace quoin::scene_file
