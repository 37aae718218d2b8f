#pragma once
/// What static stages do beside coming to rest: blocks that have come loose are taken away,
/// tractions of what is removed are given back, loads grow step by step.

#include "scene_file/run_scene.hpp"

namespace quoin::scene_file {

/// Takes out loads, held points, quiet faces and ties of blocks that are absent or can't move.
void drop_unborne(solver::Scene& scene);

class StagedWork {
 public:
  /// Contact forces of blocks that `next` removes on those that stay, and can move, are loads from
  /// now on.
  void take_tractions(const solver::Simulation& simulation, const solver::Scene& next);
  /// Blocks that have moved by at least half of what the block of a mechanism has, since the
  /// present round began; ascending.
  std::vector<int> loose(const solver::Simulation& simulation, int farthest) const;
  /// Notes where blocks stand and how many steps the stage has taken.
  void begin_round(const solver::State& state, long steps);
  long steps_before() const { return steps_before_; }

  /// Begins a stage: its own loads are as stated, unless they grow in it.
  void begin_stage(const Stage& stage);
  /// The next part of what is given back, or of the loads: false, there is none.
  bool next_share(const Stage& stage);
  double share() const { return *share_; }
  void remove(std::span<const int> blocks);

  /// A scene with what this has changed: `scene` as its stage states it.
  solver::Scene worked(solver::Scene scene) const;

  template <class Archive>
  void transfer(Archive& archive) {
    archive(removed_, tractions_, from_, steps_before_, *share_, ramps_);
  }

 private:
  struct Traction {
    int block = 0;
    Vector3 point = Vector3::Zero();  ///< of the material, at the start of the run, m
    Vector3 force = Vector3::Zero();  ///< N
  };
  std::vector<int> removed_;
  std::vector<Traction> tractions_;
  std::vector<solver::BlockState> from_;
  long steps_before_ = 0;
  bool ramps_ = false;
  std::shared_ptr<double> share_ = std::make_shared<double>(1.0);
};

}  // namespace quoin::scene_file
