#include "scene_file/mechanism_proof.hpp"

#include <algorithm>

namespace quoin::scene_file {
namespace {

constexpr double kNear = 0.1;  // of a block: steps call a mechanism what leaves that
// Of the smallest block: what all loads together may press springs by that stand for rigid joints.
constexpr double kStiff = 1e-4;

/// Of such springs at least, N/m3.
double least_stiffness(const solver::EquilibriumProblem& problem) {
  double load = 0.0, size = geometry::kLargestCoordinate;
  for (const solver::EquilibriumBlock& block : problem.blocks) {
    load += block.load.head<3>().norm();
    if (block.moves) size = std::min(size, block.size);
  }
  return load / (kStiff * size * size * size);
}

/// Whether a joint has springs that blocks load by moving, or that break as they are loaded.
bool has_soft_springs(const solver::Scene& scene, const solver::EquilibriumProblem& problem) {
  const double least = least_stiffness(problem);
  const auto soft = [&](const solver::Joint& joint) {
    return joint.normal_stiffness > 0.0 &&
           (joint.tension > 0.0 || joint.cohesion > 0.0 ||
            std::min(joint.normal_stiffness, joint.shear_stiffness) < least);
  };
  return soft(scene.joint) ||
         std::ranges::any_of(scene.pair_joints, soft, &solver::PairJoint::joint) ||
         std::ranges::any_of(scene.block_joints, soft, &solver::BlockJoint::joint);
}

}  // namespace

solver::Scene standing_scene(const solver::Simulation& run) {
  solver::Scene scene = run.scene();
  scene.initial_overlap = solver::InitialOverlap::Keep;
  scene.gravity = solver::Vector3(scene.gravity.at(run.state().time));
  for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
    solver::Block& block = scene.blocks[b];
    const geometry::Points vertices = run.vertices(static_cast<int>(b));
    const auto at = [&](const geometry::Shape& shape, int first) {
      return geometry::Shape(shape.shared_topology(),
                             vertices.middleCols(first, shape.vertex_count()));
    };
    if (block.parts) {  // their vertices are those of the whole, one after the other
      std::vector<geometry::Shape> parts;
      for (int first = 0; const geometry::Shape& part : *block.parts) {
        parts.push_back(at(part, first));
        first += part.vertex_count();
      }
      block.parts = std::make_shared<const std::vector<geometry::Shape>>(std::move(parts));
    }
    block.shape = std::make_shared<const geometry::Shape>(at(*block.shape, 0));
    block.placement = {};
  }
  return scene;
}

int MechanismProof::fastest() const {
  const auto speed = [](const solver::Vector6& v) { return v.head<3>().norm(); };
  return static_cast<int>(std::ranges::max_element(found.velocities, {}, speed) -
                          found.velocities.begin());
}

bool may_be_proved(const solver::Simulation& run, const Stage& stage) {
  const solver::Scene& scene = run.scene();
  return stage.analysis == solver::Analysis::Static && !(stage.until_moved > 0.0) &&
         run.options().method == solver::ContactMethod::AugmentedLagrangian &&
         !run.options().distributed_solver && scene.ties.empty() && scene.quiet_faces.empty() &&
         scene.pressure_loads.empty();  // they change as blocks move
}

std::shared_ptr<const MechanismProof> find_mechanism(const solver::Simulation& run) {
  solver::EquilibriumProblem problem = solver::equilibrium_problem(run, kNear);
  if (has_soft_springs(run.scene(), problem)) return nullptr;
  solver::Equilibrium found = solver::find_mechanism(problem);
  if (found.verdict != solver::EquilibriumVerdict::Mechanism) return nullptr;
  return std::make_shared<const MechanismProof>(standing_scene(run), std::move(problem),
                                                std::move(found));
}

bool is_admissible(const solver::Simulation& run) {
  const auto problem = solver::equilibrium_problem(run, kNear);
  return !has_soft_springs(run.scene(), problem) &&
         solver::find_equilibrium(problem).verdict == solver::EquilibriumVerdict::Admissible;
}

}  // namespace quoin::scene_file
