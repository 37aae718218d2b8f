#pragma once
/// One (sub-)step by the source's own method: Algorithm 1 of [Beyabanaki 2009], or its penalty
/// method.

#include "source_method/paper_open_close.hpp"
#include "step/step_attempt.hpp"

namespace quoin::solver {

/// Attempts on all blocks of a scene, which have these slots. Normals and T(x) are those of the
/// start of the step, v' = 2D/dt - v.
class PaperMethod : public AttemptMethod {
 public:
  PaperMethod(const Slots& slots, StepWatch* watch) : open_close_(slots, watch) {}
  void attempt(const SubStep& step, std::span<const BodyContact> contacts, PhaseClock& clock,
               BlocksAtEnd& blocks, Attempt& attempt) override;

 private:
  BlockSystem base_;
  BlockVector force_;
  PaperOpenClose open_close_;
};

}  // namespace quoin::solver
