#include "simulation/left_out.hpp"

#include <algorithm>
#include <quoin/geometry/broad_phase.hpp>

#include "linear/linear_solver.hpp"
#include "source_method/paper_step.hpp"

namespace quoin::solver {
namespace {

template <typename Has>
bool any_joint(const Scene& scene, const Has& has) {
  const auto of_pair = [&](const auto& pair) { return has(pair.joint); };
  return has(scene.joint) || std::ranges::any_of(scene.pair_joints, of_pair) ||
         std::ranges::any_of(scene.block_joints, of_pair);
}

std::string of_blocks(std::ptrdiff_t count) {
  return " of " + std::to_string(count) + (count == 1 ? " block" : " blocks");
}

void say_blocks(const CompiledScene& compiled, std::vector<std::string>& out) {
  const std::vector<BlockModel>& models = compiled.models;
  const auto count = [&](int unknowns) {
    return std::ranges::count(models, unknowns, &BlockModel::unknowns);
  };
  const auto absent = std::ranges::count(models, BlockKind::Absent, &BlockModel::kind);
  const auto held = count(0) - absent, rigid = count(6);
  if (held > 0)
    out.push_back("unknowns and mass terms" + of_blocks(held) + ": fixed or prescribed");
  if (absent > 0) out.push_back("all" + of_blocks(absent) + ": absent");
  if (held > 1) out.push_back("contact search between blocks that are fixed or prescribed");
  if (rigid > 0) out.push_back("strain and elasticity" + of_blocks(rigid) + ": rigid");
  if (geometry::tries_all_pairs(models.size())) {
    out.push_back("tree of the broad phase: " + std::to_string(models.size()) +
                  (models.size() == 2 ? " blocks are one pair" : " blocks, all pairs are tried"));
  }
}

void say_forces(const CompiledScene& compiled, const StepOptions& options,
                std::vector<std::string>& out) {
  const Scene& scene = compiled.scene;
  const bool rough =
      any_joint(scene, [](const Joint& j) { return j.friction_angle > 0.0 || j.cohesion > 0.0; });
  if (!rough && options.analysis != Analysis::Settle)
    out.push_back("shear forces and friction limits: no joint has friction or cohesion");
  if (options.method == ContactMethod::Springs || options.method == ContactMethod::Penalty)
    out.push_back("multipliers and velocity law: contacts are springs");
  if (options.method == ContactMethod::Paper) out.push_back("velocity law: the source has none");
  if (is_paper_method(options.method) && any_joint(scene, [](const Joint& j) {
        return j.restitution > 0.0 || j.dilation_angle > 0.0;
      }))
    out.push_back("restitution and dilation: the source has none");
  if (is_paper_method(options.method) && any_joint(scene, [](const Joint& j) {
        return j.normal_stiffness > 0.0 || j.residual_friction_angle >= 0.0 ||
               j.softening_slip > 0.0 || j.residual_cohesion > 0.0 || j.residual_tension > 0.0;
      }))
    out.push_back("stiffness of joints, softening and residual values: the source has none");
  if (options.method == ContactMethod::AugmentedLagrangian)
    out.push_back("contact springs: contacts are exact, penalty and shear_ratio are not used");
  if (compiled.loads.empty()) out.push_back("load terms: no point, face, body or pressure load");
  if (is_paper_method(options.method) && !(compiled.ties.empty() && compiled.quiet.empty()))
    out.push_back("ties and quiet faces: the source has none");
  if (compiled.held.empty()) out.push_back("held points: none in the scene");
  if (compiled.prescribed.empty()) out.push_back("prescribed motion: no block has one");
}

}  // namespace

std::vector<std::string> left_out(const CompiledScene& compiled, const StepOptions& options) {
  std::vector<std::string> out;
  say_blocks(compiled, out);
  say_forces(compiled, options, out);
  if (options.analysis != Analysis::Dynamic)
    out.push_back("velocities, kinetic energy, restitution: the analysis is static");
  if (options.threads == 1) out.push_back("worker threads: one thread is asked for");
  return out;
}

}  // namespace quoin::solver
