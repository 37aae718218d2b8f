#include "step/predict.hpp"

#include <cmath>

#include "base/index.hpp"
#include "base/rounding.hpp"

namespace quoin::solver {

void resize(std::size_t blocks, StepPoses& poses) {
  poses.start.resize(blocks);
  poses.end.resize(blocks);
  poses.increment.resize(blocks);
  poses.deforms.resize(blocks);
  poses.moves.resize(blocks);
}

void place_idle(const CompiledScene& compiled, std::span<const BlockState> state,
                std::span<const BlockState> end, std::span<const Vector12> prescribed_increments,
                StepPoses& poses) {
  for (const int block : compiled.idle_blocks) {
    const std::size_t b = index(block);
    poses.start[b] = poses.end[b] = pose(state[b]);
    poses.increment[b].setZero();
    poses.deforms[b] = poses.moves[b] = 0;
  }
  for (std::size_t p = 0; p < compiled.prescribed.size(); ++p) {
    const std::size_t b = index(compiled.prescribed[p]);
    poses.increment[b] = prescribed_increments[p];
    const bool goes = !poses.increment[b].isZero(0.0);
    poses.moves[b] = goes || !state[b].velocity.isZero(0.0) || !end[b].velocity.isZero(0.0);
    if (goes) poses.end[b] = pose(displaced(state[b], poses.increment[b]));
  }
}

void set_start(const SubStep& step, StepPoses& poses) {
  for (const int block : step.island.slots.block_of_slot)
    poses.start[index(block)] = pose(step.state[index(block)]);
}

BlockState start_state(const SubStep& step, const StepPoses& poses, std::size_t block) {
  const BlockModel& model = step.compiled.models[block];
  const bool held = model.unknowns == 12 && !poses.deforms[block];
  return held ? with_held_strain(model, step.state[block]) : step.state[block];
}

Vector3 force(const SubStep& step, const StepPoses& poses, const PointForce& load) {
  const std::size_t b = index(load.block);
  if (!load.pressure || !step.dynamic()) return load.at(poses.start[b], step.load_time());
  Vector12 half_way = 0.5 * step.length * velocity_vector(step.state[b]);
  if (step.compiled.models[b].unknowns == 6) half_way.tail<6>().setZero();
  return load.at(pose(displaced(step.state[b], half_way)), step.load_time());
}

void predict(const SubStep& step, const LastSubStep& last, StepPoses& poses) {
  for (const int block : step.island.slots.block_of_slot) {
    const std::size_t b = index(block);
    const int unknowns = step.compiled.models[b].unknowns;
    Vector12& increment = poses.increment[b];
    increment.setZero();
    poses.deforms[b] = unknowns == 12;
    poses.moves[b] = 1;
    if (!step.dynamic()) continue;
    const Vector12 velocity = velocity_vector(step.state[b]);
    increment = step.length * velocity;
    const std::size_t slot = index(step.compiled.slots.slot_of_block[b]);
    const bool steady = std::abs(last.length[slot] - step.length) < kRelativeRounding * step.length;
    if (steady && !last.hit[b]) increment += 0.5 * step.length * (velocity - last.velocity[slot]);
    if (unknowns == 6) increment.tail<6>().setZero();
  }
}

void set_end(const SubStep& step, StepPoses& poses) {
  for (const int block : step.island.slots.block_of_slot) {
    const std::size_t b = index(block);
    poses.end[b] = pose(displaced(step.state[b], poses.increment[b]));
  }
}

}  // namespace quoin::solver
