#pragma once
/// Contacts that an attempt should have held and did not.

#include "step/island.hpp"

namespace quoin::solver {

/// An overlap by less than this is none, m. `size`: of the smaller block, m.
double overlap_limit(double size);

/// Contacts that overlap at the end of an attempt though it did not hold them: added to the
/// island's contacts as the bodies hold them at the end. True when there are any. `tolerance`: what
/// contacts that yield or have turned may overlap by, of the smaller block.
bool add_missed(const CompiledScene& compiled, const StepPoses& poses, double tolerance,
                Island& island);

}  // namespace quoin::solver
