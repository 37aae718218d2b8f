#include "step/common_motion.hpp"

#include <vector>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

/// Of a group of blocks, about its centroid.
struct Momentum {
  double mass = 0.0;                  ///< kg
  Vector3 moment = Vector3::Zero();   ///< mass times centroid, kg m
  Vector3 linear = Vector3::Zero();   ///< kg m/s
  Vector3 angular = Vector3::Zero();  ///< kg m2/s
  Matrix3 inertia = Matrix3::Zero();  ///< kg m2
  Vector3 centroid() const { return moment / mass; }
  Vector3 velocity() const { return linear / mass; }
};

void add_turning(const BlockModel& model, const BlockState& block, Momentum& of) {
  const Vector3 arm = block.centroid - of.centroid();
  const Matrix3 turn = block.rotation.toRotationMatrix();
  const Vector3 spin =
      model.inertia * block.angular_velocity + model.inertia_coupling * block.strain_rate;
  of.angular += turn * spin + model.mass * arm.cross(block.velocity);
  of.inertia += turn * model.inertia * turn.transpose();
  of.inertia += model.mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
}

}  // namespace

void set_common_motion(const SubStep& step, std::span<const int> groups,
                       std::span<const char> grounded, std::span<const BlockState> end,
                       BlockVector& common) {
  const std::vector<int>& blocks = step.island.slots.block_of_slot;
  std::vector<Momentum> momenta(groups.size());
  const auto of = [&](std::size_t s) -> Momentum& { return momenta[index(groups[s])]; };
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const BlockState& block = end[index(blocks[s])];
    const double mass = step.compiled.models[index(blocks[s])].mass;
    of(s).mass += mass;
    of(s).moment += mass * block.centroid;
    of(s).linear += mass * block.velocity;
  }
  for (std::size_t s = 0; s < groups.size(); ++s) {
    add_turning(step.compiled.models[index(blocks[s])], end[index(blocks[s])], of(s));
  }
  common.assign(groups.size(), Vector12::Zero());
  for (std::size_t s = 0; s < groups.size(); ++s) {
    common[s].head<3>() = of(s).velocity();
    if (grounded[index(groups[s])]) continue;
    const BlockState& block = end[index(blocks[s])];
    const Vector3 spin = of(s).inertia.ldlt().solve(of(s).angular);
    common[s].head<3>() += spin.cross(block.centroid - of(s).centroid());
    common[s].segment<3>(3) = block.rotation.conjugate() * spin;
  }
}

void set_group_energy(const SubStep& step, std::span<const int> groups, const BlockVector& velocity,
                      std::span<const BlockState> end, std::vector<double>& energy) {
  energy.assign(groups.size(), 0.0);
  for (std::size_t s = 0; s < groups.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    energy[index(groups[s])] +=
        kinetic_energy(step.compiled.models[b], with_velocity(end[b], velocity[s]));
  }
}

}  // namespace quoin::solver
