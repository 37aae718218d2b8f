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

/// One field: quoted when it holds a comma, a quote or an end of line; behind an apostrophe when a
/// spreadsheet would take it for a formula.
std::string csv_field(std::string_view value);

}  // namespace quoin::scene_file
