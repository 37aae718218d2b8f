#include "step/weakest_joint.hpp"

#include <algorithm>
#include <vector>

#include "base/index.hpp"
#include "contact/joint_failure.hpp"
#include "contact/joint_law.hpp"

namespace quoin::solver {
namespace {

constexpr int kMostDoublings = 100;  // of forces that grow for ever: 1e-30 to 1e30 of an update
constexpr double kSameLoad = 1.0 - 1e-6;  // of another joint: both are in one chain

/// Of each joint that is loaded beyond its strength, and more than all others of its two blocks:
/// its contacts.
std::vector<char> choose_weakest(const SubStep& step, std::span<const BodyContact> contacts,
                                 std::span<const double> loads) {
  const auto slot = [&](int block) { return step.slot_of_block[index(block)]; };
  std::vector<double> largest(step.island.slots.block_of_slot.size(), 0.0);
  const auto note = [&](int block, double load) {
    if (slot(block) < 0) return;
    double& of_block = largest[index(slot(block))];
    of_block = std::max(of_block, load);
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    note(contacts[i].a, loads[i]);
    note(contacts[i].b, loads[i]);
  }
  const auto is_largest = [&](int block, double load) {
    return slot(block) < 0 || load >= kSameLoad * largest[index(slot(block))];
  };
  std::vector<char> chosen(contacts.size(), 0);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    chosen[i] = loads[i] > 1.0 && is_largest(contacts[i].a, loads[i]) &&
                is_largest(contacts[i].b, loads[i]);
  }
  return chosen;
}

struct LoadedJoints {
  const SubStep& step;
  std::span<BodyContact> contacts;

  std::vector<double> loads(std::span<const LinearContact> linear) const {
    double largest = 0.0;
    for (const LinearContact& c : linear) largest = std::max(largest, c.force.norm());
    return joint_loads(contacts, linear, largest);
  }

  bool overloaded(std::span<const double> loads) const {
    return std::ranges::any_of(loads, [](double load) { return load > 1.0; });
  }

  /// Forces that grow for ever, from before they did, until the first joint has its strength, to a
  /// factor of two. Their loads.
  std::vector<double> grow(std::span<LinearContact> linear) const {
    std::vector<Vector3> before, growth;
    for (const LinearContact& c : linear) {
      growth.push_back(force_after_update(c) - c.force);
      before.push_back(c.force - kFixedUpdates * growth.back());
    }
    const auto loads_after = [&](double updates) {
      for (std::size_t i = 0; i < linear.size(); ++i)
        linear[i].force = before[i] + updates * growth[i];
      return loads(linear);
    };
    double updates = 1.0;
    int left = kMostDoublings;
    while (overloaded(loads_after(updates)) && left-- > 0) updates *= 0.5;
    for (left = 2 * kMostDoublings; !overloaded(loads_after(updates)) && left-- > 0;)
      updates *= 2.0;
    return loads_after(updates);
  }
};

}  // namespace

bool fail_weakest(const SubStep& step, const OpenCloseResult& solved,
                  std::span<BodyContact> contacts, std::span<const LinearContact> linear) {
  const LoadedJoints joints{step, contacts};
  std::vector<LinearContact> loaded(linear.begin(), linear.end());
  const std::vector<double> loads = solved.infeasible ? joints.grow(loaded) : joints.loads(loaded);
  if (fail_chosen(contacts, loaded, choose_weakest(step, contacts, loads))) return true;
  return !solved.infeasible && fail_opened(contacts, linear, step.parting_gap());
}

}  // namespace quoin::solver
