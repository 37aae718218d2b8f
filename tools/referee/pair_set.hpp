#pragma once
/// Pairs with their exact answers as plain text: the format of tests/pairs/README.md.

#include <string>

#include "referee/pairs/solids.hpp"

namespace quoin::referee {

/// One line of JSON: the pair, its exact gap, an optimal normal, the contact length, and, where no
/// length is too near to that to say, type and area of the patch. Of gaps that could be taken for
/// rounding the square too, as a fraction. Throws std::invalid_argument for a flat solid.
std::string pair_with_answer(const SolidPair& pair, const std::string& id);

}  // namespace quoin::referee
