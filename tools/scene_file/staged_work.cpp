#include "scene_file/staged_work.hpp"

#include <algorithm>

namespace quoin::scene_file {
namespace {

using solver::BlockKind;

/// How far a block has come, by its centroid and its turn, m.
double way(const solver::BlockState& from, const solver::BlockState& to, double size) {
  return (to.centroid - from.centroid).norm() +
         0.5 * size * from.rotation.angularDistance(to.rotation);
}

solver::VectorOfTime scaled(const solver::VectorOfTime& value,
                            std::shared_ptr<const double> share) {
  return {[value, share](double time) -> Vector3 { return *share * value.at(time); }};
}

}  // namespace

void drop_unborne(solver::Scene& scene) {
  using enum BlockKind;
  const auto is = [&](int block, auto... kinds) {
    return block >= 0 && ((scene.blocks[static_cast<std::size_t>(block)].kind == kinds) || ...);
  };
  const auto bears_none = [&](const auto& load) { return !is(load.block, Rigid, Deformable); };
  std::erase_if(scene.point_loads, bears_none);
  std::erase_if(scene.face_loads, bears_none);
  std::erase_if(scene.body_loads, bears_none);
  std::erase_if(scene.fixed_points, bears_none);
  std::erase_if(scene.pressure_loads, bears_none);
  std::erase_if(scene.quiet_faces, bears_none);
  std::erase_if(scene.ties, [&](const solver::Tie& tie) {
    return is(tie.a, Absent) || is(tie.b, Absent) ||
           !(is(tie.a, Rigid, Deformable) || is(tie.b, Rigid, Deformable));
  });
}

void StagedWork::take_tractions(const solver::Simulation& simulation, const solver::Scene& next) {
  const auto kind = [](const solver::Scene& scene, int block) {
    return scene.blocks[static_cast<std::size_t>(block)].kind;
  };
  const solver::State& state = simulation.state();
  tractions_.clear();
  for (const solver::Contact& contact : state.contacts) {
    const Vector3 on_b = contact.normal_force * contact.point.normal - contact.shear_force;
    const auto take = [&](int stays, int leaves, const Vector3& force) {
      if (kind(next, leaves) != BlockKind::Absent || kind(next, stays) >= BlockKind::Fixed) return;
      const Vector3 arm = simulation.reference_arm(stays, state.origin + contact.point.point());
      // An arm is that of the material at the start.
      const Vector3 vertex =
          simulation.scene().blocks[static_cast<std::size_t>(stays)].body().vertex(0);
      const Vector3 of_vertex = simulation.reference_arms(stays).col(0);
      tractions_.push_back({stays, vertex + (arm - of_vertex), force});
    };
    if (on_b.isZero(0.0)) continue;
    take(contact.point.key.b, contact.point.key.a, on_b);
    take(contact.point.key.a, contact.point.key.b, -on_b);
  }
}

std::vector<int> StagedWork::loose(const solver::Simulation& simulation, int farthest) const {
  const std::vector<solver::BlockState>& now = simulation.state().blocks;
  const auto moved = [&](std::size_t b) {
    const solver::Block& block = simulation.scene().blocks[b];
    if (block.kind >= BlockKind::Fixed) return 0.0;
    return way(from_[b], now[b], block.body().stretch() * block.shape->diameter());
  };
  const double least = 0.5 * moved(static_cast<std::size_t>(farthest));
  std::vector<int> blocks;
  for (std::size_t b = 0; b < now.size(); ++b)
    if (moved(b) >= least && moved(b) > 0.0) blocks.push_back(static_cast<int>(b));
  return blocks;
}

void StagedWork::begin_round(const solver::State& state, long steps) {
  from_ = state.blocks;
  steps_before_ = steps;
}

void StagedWork::begin_stage(const Stage& stage) {
  ramps_ = ramps_ && !stage.scene;
  if (stage.relax == 0) tractions_.clear();
  if (stage.relax > 0) *share_ = 1.0 - 1.0 / stage.relax;
  if (!(stage.ramp_to > 0.0)) return;
  ramps_ = true;
  *share_ = std::min(stage.ramp_by, stage.ramp_to);
}

bool StagedWork::next_share(const Stage& stage) {
  constexpr double kRounding = 1e-9;  // of a part
  const bool relaxes = stage.relax > 0;
  const double by = relaxes ? 1.0 / stage.relax : stage.ramp_by;
  const double left = relaxes ? *share_ : stage.ramp_to - *share_;
  if (!(left > kRounding * by)) return false;
  const bool last = left <= (1.0 + kRounding) * by;
  if (last) *share_ = relaxes ? 0.0 : stage.ramp_to;
  if (!last) *share_ += relaxes ? -by : by;
  return true;
}

void StagedWork::remove(std::span<const int> blocks) {
  removed_.insert(removed_.end(), blocks.begin(), blocks.end());
}

solver::Scene StagedWork::worked(solver::Scene scene) const {
  const auto is_gone = [&](int block) {
    return scene.blocks[static_cast<std::size_t>(block)].kind == BlockKind::Absent;
  };
  for (const int block : removed_)
    scene.blocks[static_cast<std::size_t>(block)].kind = BlockKind::Absent;
  drop_unborne(scene);
  if (ramps_) {
    for (solver::PointLoad& load : scene.point_loads) load.force = scaled(load.force, share_);
    for (solver::FaceLoad& load : scene.face_loads) load.traction = scaled(load.traction, share_);
    for (solver::BodyLoad& load : scene.body_loads) load.force = scaled(load.force, share_);
  }
  for (const Traction& traction : tractions_) {
    if (is_gone(traction.block)) continue;
    scene.point_loads.push_back({.block = traction.block,
                                 .point = traction.point,
                                 .force = scaled(traction.force, share_)});
  }
  return scene;
}

}  // namespace quoin::scene_file
