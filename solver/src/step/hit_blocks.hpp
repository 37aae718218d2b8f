#pragma once
/// Blocks that an impact of a sub-step hits.
///
/// The impulse of an impact is no force of one step's length: it would load the strain of every
/// block it passes through with energy that is not there. Hit blocks move rigidly through the step,
/// where they can; their strain goes on in the next.

#include "contact/contact_jacobian.hpp"
#include "step/sub_step.hpp"

namespace quoin::solver {

enum class Impacts { Expected, Solved };

/// Whether a contact ends closed to the gap tolerance, whatever its mode. Where blocks meet just as
/// a step ends nothing is left for forces to do, and which corners of a face these close is a
/// matter of rounding: an impulse at some of them alone would turn the blocks.
bool touches(const SubStep& step, const LinearContact& contact);

/// By slot: blocks that an impact hits, and those that lean on them or touch them: expected from
/// how they move before the step is solved, or as it was solved.
void find_hit_blocks(const SubStep& step, std::span<const BodyContact> contacts,
                     std::span<const LinearContact> linear, Impacts impacts,
                     std::vector<char>& hit);

/// Share of the step that had passed at the first impact that was solved; 0: there is none.
double first_impact(const SubStep& step, std::span<const LinearContact> linear);

/// How far supports (fixed or prescribed blocks that hit blocks touch, points of these that are
/// held) move against each other in the step, m: moving rigidly hit blocks may have no way. `hit`
/// empty: all are.
double shift_of_supports(const SubStep& step, std::span<const BodyContact> contacts,
                         std::span<const LinearContact> linear, std::span<const char> hit,
                         const StepPoses& poses);

/// Their strain waits. True when there are any that deform.
bool hold_strain(const SubStep& step, std::span<const char> hit, StepPoses& poses);

}  // namespace quoin::solver
