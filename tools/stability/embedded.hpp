#pragma once
/// Data of this folder, as text of JSON.

#include <string_view>

namespace quoin::stability {

std::string_view expected_flags();  ///< expected_flags.json
std::string_view limit_loads();     ///< limit_loads.json, by linear programming

}  // namespace quoin::stability
