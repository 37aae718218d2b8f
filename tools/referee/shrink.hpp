#pragma once
/// A failing pair made smaller: fewer points and shorter numbers that still show the fault.

#include <functional>
#include <string>

#include "referee/pairs/solids.hpp"

namespace quoin::referee {

/// `fails`: whether a pair still shows the fault; asked at most `most_questions` times. The result
/// fails, and has no faces of its own (it is the hull of its points).
SolidPair shrink(const SolidPair& pair, const std::function<bool(const SolidPair&)>& fails,
                 int most_questions);

}  // namespace quoin::referee
