#include "statics/equilibrium_search.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/index.hpp"
#include "contact/contact_history.hpp"
#include "contact/joint_law.hpp"
#include "iteration/open_close.hpp"

namespace quoin::solver {
namespace {

constexpr double kStride = 0.0025;  // of a block, in one step: forty steps tell a mechanism
constexpr double kMechanism = 0.1;  // of a block: no longer the structure that was asked about
constexpr double kLongest = 1e3;    // first pseudo-steps: an unbalance of 1e-6 moves a full stride
// Times the first pseudo-step where many blocks deform. What inertia bears in it goes through the
// contacts in the next one, which of walls then takes as long again.
// Chosen with four walls (bench/README.md, Mechanisms).
constexpr double kOfMany = 8.0;
// Of the sizes of loads, their sum: they balance. Rounding leaves m u of m loads
// [Higham 2002, section 4.2], areas and loads that are known to a few digits leave more; an
// unbalance of this is at rest (StepOptions::rest_unbalance).
constexpr double kBalance = 1e-6;
// Residual, and of the smaller block and the largest force, gap times force of a contact. Where
// forces are inexact (ContactSolver) they may balance across gaps, and are those of no state.
constexpr double kExactForces = 1e-6;
constexpr double kStillFalling = 0.5;  // of the last unbalance

/// Edge of the cube with the block's mean second moment, m: the same in every frame.
double extent(const BlockModel& model) {
  return 2.0 * std::sqrt(model.second_moment.trace() / model.mass);
}

/// Of the centroid, and of a vertex by the turn or the strain.
double motion(double way, double angle, double extent) { return way / extent + 0.5 * angle; }

/// What strains of these blocks can move one by in a chain, m.
double elastic_motion(const CompiledScene& compiled, std::span<const int> blocks,
                      std::span<const BlockState> from, std::span<const BlockState> to) {
  double sum = 0.0;
  for (const int b : blocks)
    sum += (to[index(b)].strain - from[index(b)].strain).norm() * extent(compiled.models[index(b)]);
  return sum;
}

/// Loads of a block, N.
struct LoadSum {
  Vector3 sum = Vector3::Zero();
  double parts = 0.0;  ///< sum of their sizes

  void add(const Vector3& load) {
    sum += load;
    parts += load.norm();
  }
};

/// What stresses push a block's faces with, N: elastic and initial ones together, and their sizes.
struct StressSum {
  double sum = 0.0, parts = 0.0;
};

StressSum stress_sum(const BlockModel& model, const BlockState& block) {
  const Vector6 together = static_block_force(model, block).tail<6>();
  const double elastic = (model.elasticity * block.strain).norm();
  return {together.norm() / extent(model),
          model.volume * (elastic + model.initial_stress.norm()) / extent(model)};
}

/// 0 where the parts balance: what is left of them is rounding, which is no scale.
double net_of(double sum, double parts) { return sum > kBalance * parts ? sum : 0.0; }

}  // namespace

double static_reach(const BlockModel& model) { return 4.0 * kStride * extent(model); }

void begin_search(const CompiledScene& compiled, const State& state, EquilibriumSearch& search) {
  std::vector<LoadSum> loads(compiled.models.size());
  for (const PointForce& point : compiled.loads) {
    const Pose now = pose(state.blocks[index(point.block)]);
    loads[index(point.block)].add(point.at(now, state.time));
  }
  double fastest = 0.0, fastest_apart = 0.0;  // 1/s2, by net loads and by sizes of their parts
  for (const int b : compiled.slots.block_of_slot) {
    const BlockModel& model = compiled.models[index(b)];
    LoadSum& load = loads[index(b)];
    load.add(model.mass * compiled.scene.gravity.at(state.time));
    const StressSum stress = stress_sum(model, state.blocks[index(b)]);
    const double inertia = model.mass * extent(model);
    const double net =
        std::max(net_of(load.sum.norm(), load.parts), net_of(stress.sum, stress.parts));
    fastest = std::max(fastest, net / inertia);
    fastest_apart = std::max(fastest_apart, std::max(load.parts, stress.parts) / inertia);
  }
  if (!(fastest > 0.0)) fastest = fastest_apart;
  search.pseudo_step = fastest > 0.0 ? std::sqrt(2.0 * kStride / fastest) : 1.0;
  if (many_deform(compiled.slots)) search.pseudo_step *= kOfMany;
  search.longest = kLongest * search.pseudo_step;
  search.unbalance = 0.0;
  search.start = state.blocks;
}

/// What closed contacts give is left in, unlike in judge(): it can only shorten pseudo-steps, and
/// no verdict depends on it.
double stride(const CompiledScene& compiled, std::span<const int> blocks,
              std::span<const BlockState> from, std::span<const BlockState> to) {
  const double elastic = elastic_motion(compiled, blocks, from, to);
  double longest = 0.0;
  for (const int b : blocks) {
    const BlockState &start = from[index(b)], &end = to[index(b)];
    const double change =
        end.rotation.angularDistance(start.rotation) + (end.strain - start.strain).norm();
    const double way = std::max((end.centroid - start.centroid).norm() - elastic, 0.0);
    longest = std::max(longest, motion(way, change, extent(compiled.models[index(b)])));
  }
  return longest;
}

bool too_long(double stride) { return stride > 2.0 * kStride; }

void judge(const CompiledScene& compiled, const StepOptions& options, double stride,
           const State& state, EquilibriumSearch& search, StepReport& report) {
  double explained =
      elastic_motion(compiled, compiled.slots.block_of_slot, search.start, state.blocks);
  const bool overlaps = options.method != ContactMethod::AugmentedLagrangian;
  double largest = 0.0, open = 0.0;  // N, N
  for (const Contact& contact : state.contacts) {
    if (contact.mode == ContactMode::Open) continue;
    const std::size_t a = index(contact.point.key.a), b = index(contact.point.key.b);
    const Joint& joint = joint_between(compiled.scene, contact.point.key.a, contact.point.key.b);
    const double gap = std::abs(contact.point.gap - opening(joint, contact));
    const double force = std::abs(contact.normal_force);
    explained += gap;
    largest = std::max(largest, force);
    if (overlaps || joint.normal_stiffness > 0.0) continue;
    const double size = std::min(compiled.models[a].size, compiled.models[b].size);
    open = std::max(open, force * gap / size);
  }
  for (const int b : compiled.slots.block_of_slot) {
    const BlockState &from = search.start[index(b)], &now = state.blocks[index(b)];
    const double size = extent(compiled.models[index(b)]);
    const double travel = motion((now.centroid - from.centroid).norm() - explained,
                                 now.rotation.angularDistance(from.rotation), size);
    if (!(travel > report.travel)) continue;
    report.travel = travel;
    report.travel_block = b;
  }
  const bool balanced = report.unbalance <= options.rest_unbalance &&
                        report.residual <= kExactForces && open <= kExactForces * largest;
  const bool falling =
      report.unbalance > 0.0 && !(report.unbalance > kStillFalling * search.unbalance);
  if (balanced && !falling) report.verdict = StaticVerdict::Rest;
  if (!balanced && report.travel > kMechanism) report.verdict = StaticVerdict::Mechanism;
  search.unbalance = report.unbalance;
  if (balanced) return;
  for (const double short_of : {4.0, 16.0})  // the stride goes with tau2
    if (short_of * stride < kStride) search.pseudo_step *= 2.0;
  search.pseudo_step = std::min(search.pseudo_step, search.longest);
}

}  // namespace quoin::solver
