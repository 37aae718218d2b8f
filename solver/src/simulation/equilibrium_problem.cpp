#include "statics/equilibrium.hpp"
#include "step/contact_search.hpp"

namespace quoin::solver {

EquilibriumProblem equilibrium_problem(const Scene& scene, double reach) {
  StepOptions options;
  options.analysis = Analysis::Static;
  options.reach = reach;
  const CompiledScene compiled = compile(scene);
  const State state = initial_state(compiled);
  Workspace work(compiled, options);
  detect(compiled, options, state, work);
  work.initial_depths.remember(compiled, work.found, work.laid);
  work.initial_depths.take_off(compiled, state.blocks, work.found);
  return equilibrium_problem(compiled, state, work.found, reach);
}

std::vector<Vector6> block_loads(const Scene& scene) {
  const CompiledScene compiled = compile(scene);
  return block_loads(compiled, initial_state(compiled));
}

}  // namespace quoin::solver
