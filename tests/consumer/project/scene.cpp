#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
namespace geometry = quoin::geometry;
namespace solver = quoin::solver;

int main() {
  solver::Scene scene{.joint = {.friction_angle = 0.5}};         // rad
  scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));  // m
  scene.add_block(geometry::make_box({0, 0, 0}, {1, 1, 1}), {.density = 2700, .young = 5e10});
  solver::Simulation simulation(scene, {.time_step = 1e-3});  // s
  while (simulation.state().time < 0.5)
    if (simulation.advance().status != solver::StepStatus::Converged) return 1;
  solver::write_blocks("end.vtu", simulation);
}
