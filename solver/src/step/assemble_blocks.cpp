#include "step/assemble_blocks.hpp"

#include <Eigen/LU>

#include "base/index.hpp"
#include "linear/small_matrices.hpp"
#include "step/predict.hpp"

namespace quoin::solver {
namespace {

void set_rigid_inverse(const Matrix12& matrix, Matrix12& inverse) {
  inverse.diagonal().head<3>() = matrix.diagonal().head<3>().cwiseInverse();
  inverse.block<3, 3>(3, 3) = matrix.block<3, 3>(3, 3).inverse();
}

bool same(const StepScheme& x, const StepScheme& y) {
  return x.time_step == y.time_step && x.end_share == y.end_share && x.deforms == y.deforms;
}

}  // namespace

void set_matrices(const SubStep& step, const StepPoses& poses, BlockTerms& terms) {
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  const int width = step.island.slots.width();
  terms.base.diagonal.resize(blocks.size(), width);
  terms.base.frames.resize(blocks.size());
  terms.compliance.resize(blocks.size(), width);
  terms.scheme.resize(blocks.size());
  for (std::size_t s = 0; s < blocks.size(); ++s) {
    const std::size_t b = index(blocks[s]);
    const bool deforms = poses.deforms[b] != 0;
    terms.base.frames[s] = {poses.start[b].centroid, poses.start[b].rotation};
    const StepScheme scheme = step.scheme(deforms);
    if (same(scheme, terms.scheme[s])) continue;
    terms.scheme[s] = scheme;
    const Matrix12 matrix = block_matrix(step.compiled.models[b], scheme);
    Matrix12 inverse = Matrix12::Zero();
    if (deforms)
      invert_symmetric(matrix, inverse);
    else
      set_rigid_inverse(matrix, inverse);
    terms.base.diagonal[s] = matrix.topLeftCorner(width, width);
    terms.compliance[s] = inverse.topLeftCorner(width, width);
  }
}

void set_force(const SubStep& step, const StepPoses& poses, BlockTerms& terms) {
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  const double time = step.load_time();
  const Vector3 gravity = step.compiled.scene.gravity.at(time);
  terms.force.resize(blocks.size());
  for (std::size_t s = 0; s < blocks.size(); ++s) {
    const std::size_t b = index(blocks[s]);
    const BlockModel& model = step.compiled.models[b];
    const StepScheme scheme = step.scheme(poses.deforms[b] != 0);
    terms.force[s] =
        step.dynamic() ? block_force(model, start_state(step, poses, b), scheme, poses.increment[b])
                       : static_block_force(model, step.state[b]);
    terms.force[s].head<3>() += model.mass * gravity;
  }
  for (const int l : step.island.loads) {
    const PointForce& load = step.compiled.loads[index(l)];
    const std::size_t b = index(load.block);
    const Matrix3x12 motion =
        mean_motion(poses.start[b], poses.end[b], poses.increment[b].segment<3>(3), load.arm,
                    poses.deforms[b] != 0);
    terms.force[index(step.slot_of_block[b])] += motion.transpose() * force(step, poses, load);
  }
}

}  // namespace quoin::solver
