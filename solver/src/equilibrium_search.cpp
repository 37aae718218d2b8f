#include "equilibrium_search.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "distributed/agreement.hpp"
#include "index.hpp"
#include "iteration/open_close.hpp"

namespace quoin::solver {
namespace {

constexpr double kStride = 0.0025;  // of a block, in one step: forty steps tell a mechanism
constexpr double kMechanism = 0.1;  // of a block: no longer the structure that was asked about
constexpr double kLongest = 1e3;    // first pseudo-steps: an unbalance of 1e-6 moves a full stride
// Times the first pseudo-step where many blocks deform. What inertia bears in it goes through the
// contacts in the next one, which of walls then takes as long again.
constexpr double kOfMany = 4.0;
constexpr double kStillFalling = 0.5;  // of the last unbalance

/// Edge of the cube with the block's mean second moment, m: the same in every frame.
double extent(const BlockModel& model) {
  return 2.0 * std::sqrt(model.second_moment.trace() / model.mass);
}

/// Of the centroid, and of a vertex by the turn.
double motion(double way, double angle, double extent) { return way / extent + 0.5 * angle; }

bool many_deform(const CompiledScene& compiled) {
  return compiled.slots.count() >= kMany && !compiled.slots.rigid();
}

/// What strains of all blocks and springs of all contacts can move a block by in a chain, m.
double elastic_motion(const CompiledScene& compiled, const StepOptions& options, const State& state,
                      std::span<const BlockState> start) {
  double sum = 0.0;
  for (const int b : compiled.slots.block_of_slot) {
    const Vector6 strain = state.blocks[index(b)].strain - start[index(b)].strain;
    sum += strain.norm() * extent(compiled.models[index(b)]);
  }
  const Agreement all = agreement(options);
  double gaps = 0.0;  // of several processes: of this one
  double& gap_sum = all.shares() ? gaps : sum;
  for (const Contact& contact : state.contacts) {
    if (!all.owns(first_with_unknowns(compiled, contact.point.key))) continue;
    if (contact.mode != ContactMode::Open) gap_sum += std::abs(contact.point.gap);
  }
  return sum + all.sum(gaps);
}

}  // namespace

double static_reach(const BlockModel& model) { return 4.0 * kStride * extent(model); }

void begin_search(const CompiledScene& compiled, const State& state, EquilibriumSearch& search) {
  std::vector<Vector3> load(compiled.models.size(), Vector3::Zero());
  for (const PointForce& point : compiled.loads) {
    load[index(point.block)] += point.factor * point.force.at(state.time);
  }
  double fastest = 0.0;  // 1/s2
  for (const int b : compiled.slots.block_of_slot) {
    const BlockModel& model = compiled.models[index(b)];
    const Vector12 stressed = static_block_force(model, state.blocks[index(b)]);
    const double force =
        (load[index(b)] + model.mass * compiled.scene.gravity.at(state.time)).norm();
    const double strain_force = stressed.tail<6>().norm() / extent(model);
    fastest = std::max(fastest, std::max(force, strain_force) / (model.mass * extent(model)));
  }
  search.pseudo_step = fastest > 0.0 ? std::sqrt(2.0 * kStride / fastest) : 1.0;
  if (many_deform(compiled)) search.pseudo_step *= kOfMany;
  search.longest = kLongest * search.pseudo_step;
  search.unbalance = 0.0;
  search.start = state.blocks;
}

double stride(const CompiledScene& compiled, std::span<const int> blocks,
              std::span<const BlockState> from, std::span<const BlockState> to) {
  double longest = 0.0;
  for (const int b : blocks) {
    const BlockState &start = from[index(b)], &end = to[index(b)];
    longest = std::max(longest, motion((end.centroid - start.centroid).norm(),
                                       end.rotation.angularDistance(start.rotation),
                                       extent(compiled.models[index(b)])));
  }
  return longest;
}

bool too_long(double stride) { return stride > 2.0 * kStride; }

void judge(const CompiledScene& compiled, const StepOptions& options, double stride,
           const State& state, EquilibriumSearch& search, StepReport& report) {
  const double explained = elastic_motion(compiled, options, state, search.start);
  for (const int b : compiled.slots.block_of_slot) {
    const BlockState &from = search.start[index(b)], &now = state.blocks[index(b)];
    const double size = extent(compiled.models[index(b)]);
    const double travel = motion((now.centroid - from.centroid).norm() - explained,
                                 now.rotation.angularDistance(from.rotation), size);
    if (!(travel > report.travel)) continue;
    report.travel = travel;
    report.travel_block = b;
  }
  const bool balanced = report.unbalance <= options.rest_unbalance;
  const bool falling =
      report.unbalance > 0.0 && !(report.unbalance > kStillFalling * search.unbalance);
  if (balanced && !falling) report.verdict = StaticVerdict::Rest;
  if (!balanced && report.travel > kMechanism) report.verdict = StaticVerdict::Mechanism;
  search.unbalance = report.unbalance;
  if (balanced) return;
  for (const double short_of : {4.0, 16.0}) {  // the stride goes with tau2
    if (short_of * stride < kStride) search.pseudo_step *= 2.0;
  }
  search.pseudo_step = std::min(search.pseudo_step, search.longest);
}

}  // namespace quoin::solver
