#include "step/hit_blocks.hpp"

#include <algorithm>
#include <limits>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

/// A contact that closes faster than what the step does not resolve.
bool is_impact(const SubStep& step, const LinearContact& c, Impacts impacts) {
  if (!c.hits) return false;
  return impacts == Impacts::Expected || c.mode != ContactMode::Open || touches(step, c);
}

}  // namespace

bool touches(const SubStep& step, const LinearContact& c) {
  return !c.compliant && c.relative[0] <= step.gap_tolerance();
}

void find_hit_blocks(const SubStep& step, std::span<const BodyContact> contacts,
                     std::span<const LinearContact> linear, Impacts impacts,
                     std::vector<char>& hit) {
  hit.assign(step.island.slots.size.size(), 0);
  if (step.options.method == ContactMethod::Springs || !step.dynamic()) return;
  bool grows = false;
  const auto add = [&](int slot) {
    if (slot < 0 || hit[index(slot)]) return;
    hit[index(slot)] = 1;
    grows = true;
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!is_impact(step, linear[i], impacts)) continue;
    add(linear[i].slot_a);
    add(linear[i].slot_b);
  }
  const auto is_hit = [&](int slot) { return slot >= 0 && hit[index(slot)]; };
  while (grows) {
    grows = false;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (!contacts[i].was_closed && linear[i].start[0] > step.gap_tolerance()) continue;
      if (is_hit(linear[i].slot_a)) add(linear[i].slot_b);
      if (is_hit(linear[i].slot_b)) add(linear[i].slot_a);
    }
  }
}

double first_impact(const SubStep& step, std::span<const LinearContact> linear) {
  if (step.options.method == ContactMethod::Springs || !step.dynamic()) return 0.0;
  double first = 0.0;
  for (const LinearContact& c : linear) {
    if (!is_impact(step, c, Impacts::Solved)) continue;
    first = first > 0.0 ? std::min(first, c.closing_share) : c.closing_share;
  }
  return first;
}

double shift_of_supports(const SubStep& step, std::span<const BodyContact> contacts,
                         std::span<const LinearContact> linear, std::span<const char> hit,
                         const StepPoses& poses) {
  if (step.compiled.prescribed.empty() && step.compiled.held.empty()) return 0.0;  // none moves
  constexpr double none = std::numeric_limits<double>::infinity();
  const auto is_hit = [&](int slot) { return slot >= 0 && (hit.empty() || hit[index(slot)]); };
  Vector3 high = Vector3::Constant(-none), low = high;  // of their ways, and of these turned
  const auto bear = [&](int slot, const Vector3& way) {
    if (!is_hit(slot)) return;
    high = high.cwiseMax(way);
    low = low.cwiseMax(-way);
  };
  const auto way_of = [&](int block) { return poses.increment[index(block)].head<3>(); };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const LinearContact& c = linear[i];
    if (c.slot_b < 0) bear(c.slot_a, way_of(contacts[i].b));
    if (c.slot_a < 0) bear(c.slot_b, way_of(contacts[i].a));
  }
  for (std::size_t h = 0; h < step.island.held.size(); ++h) {
    const VectorOfTime& way = step.compiled.held[index(step.island.held[h])].displacement;
    bear(linear[contacts.size() + h].slot_b,
         way.at(step.end_time()) - way.at(step.end_time() - step.length));
  }
  Vector3 shift;
  for (int k = 0; k < 3; ++k) shift[k] = high[k] + low[k];
  return shift.minCoeff() >= 0.0 ? shift.norm() : 0.0;  // there are no supports
}

bool hold_strain(const SubStep& step, std::span<const char> hit, StepPoses& poses) {
  bool any = false;
  for (std::size_t s = 0; s < hit.size(); ++s) {
    const std::size_t b = index(step.island.slots.block_of_slot[s]);
    if (!hit[s] || !poses.deforms[b]) continue;
    poses.deforms[b] = 0;
    poses.increment[b].tail<6>().setZero();
    any = true;
  }
  return any;
}

}  // namespace quoin::solver
