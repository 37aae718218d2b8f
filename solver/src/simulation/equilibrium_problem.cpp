#include <algorithm>
#include <quoin/solver/simulation.hpp>

#include "base/index.hpp"
#include "statics/equilibrium.hpp"
#include "step/contact_search.hpp"

namespace quoin::solver {

EquilibriumProblem equilibrium_problem(const Scene& scene, double reach, JointStress stress) {
  StepOptions options;
  options.analysis = Analysis::Static;
  options.reach = reach;
  const CompiledScene compiled = compile(scene);
  const State state = initial_state(compiled);
  Workspace work(compiled, options);
  detect(compiled, options, state, work);
  work.initial_depths.remember(compiled, work.found, work.laid);
  work.initial_depths.take_off(compiled, state.blocks, work.found);
  const bool elastic = stress == JointStress::Elastic;
  return equilibrium_problem(compiled, state, work.found, reach,
                             elastic ? StrengthPoints::OfCore : StrengthPoints::ShareArea);
}

EquilibriumProblem equilibrium_problem(const Simulation& simulation, double share) {
  const CompiledScene compiled = compile(simulation.scene());
  const State& state = simulation.state();
  const auto way = [&](int b) {
    return compiled.idle[index(b)] ? 0.0 : share * compiled.models[index(b)].size;
  };
  StepOptions options;
  options.analysis = Analysis::Static;
  for (int b = 0; b < static_cast<int>(compiled.models.size()); ++b)
    options.reach = std::max(options.reach, 2.0 * way(b));
  Workspace work(compiled, options);
  detect(compiled, options, state, work);
  std::erase_if(work.found, [&](const geometry::ContactPoint& point) {
    return point.gap > way(point.key.a) + way(point.key.b);
  });
  return equilibrium_problem(compiled, state, work.found, options.reach, StrengthPoints::OfSteps);
}

std::vector<Vector6> block_loads(const Scene& scene) {
  const CompiledScene compiled = compile(scene);
  return block_loads(compiled, initial_state(compiled));
}

}  // namespace quoin::solver
