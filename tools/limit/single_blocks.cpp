#include "limit/single_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <quoin/geometry/mass_properties.hpp>
#include <tuple>
#include <utility>

namespace quoin::limit_analysis {
namespace {

/// The block is number 1; number 0 stands for all of its neighbours.
EquilibriumProblem alone(const EquilibriumProblem& problem, int block,
                         const std::vector<int>& contacts) {
  EquilibriumProblem result{.origin = problem.origin};
  result.blocks = {{}, problem.blocks[static_cast<std::size_t>(block)]};
  for (const int i : contacts) {
    solver::EquilibriumContact contact = problem.contacts[static_cast<std::size_t>(i)];
    if (contact.a >= 0) contact.a = contact.a == block ? 1 : 0;
    contact.b = contact.b == block ? 1 : 0;
    result.contacts.push_back(contact);
  }
  return result;
}

EquilibriumProblem weakened(EquilibriumProblem problem, double divisor) {
  for (solver::EquilibriumContact& contact : problem.contacts) {
    contact.friction /= divisor;
    contact.cohesion /= divisor;
    contact.tension /= divisor;
  }
  return problem;
}

constexpr double kNone = std::numeric_limits<double>::infinity();  // divisor of no strength

EquilibriumVerdict verdict(const EquilibriumProblem& problem) {
  return solver::find_equilibrium(problem).verdict;
}

/// Loaded by a push of 1 N off every contact, without friction: a motion that opens one exists.
bool opens(EquilibriumProblem problem) {
  solver::EquilibriumBlock& block = problem.blocks[1];
  block.load.setZero();
  for (const solver::EquilibriumContact& contact : problem.contacts) {
    if (contact.held) continue;
    const Vector3 push = (contact.b == 1 ? 1.0 : -1.0) * contact.normal;
    block.load.head<3>() += push;
    block.load.tail<3>() += (contact.point - block.place).cross(push);
  }
  return verdict(problem) == EquilibriumVerdict::Mechanism;
}

void find_strength(const EquilibriumProblem& problem, double tolerance, SingleBlock& result) {
  double low = kLeastStrength, high = kMostStrength;
  if (verdict(weakened(problem, low)) != EquilibriumVerdict::Admissible) {
    result.falls = low;
    return;
  }
  result.stands = low;
  while (high > low * (1.0 + tolerance)) {
    const double middle = std::sqrt(low * high);
    const EquilibriumVerdict at = verdict(weakened(problem, middle));
    if (at == EquilibriumVerdict::Admissible) result.stands = low = middle;
    if (at == EquilibriumVerdict::Mechanism) result.falls = middle;
    if (at != EquilibriumVerdict::Admissible) high = middle;
  }
}

/// A problem and which of its contacts each block has.
struct ProblemOfBlocks {
  EquilibriumProblem problem;
  std::vector<std::vector<int>> contacts;

  explicit ProblemOfBlocks(EquilibriumProblem given)
      : problem(std::move(given)), contacts(problem.blocks.size()) {
    for (int i = 0; i < static_cast<int>(problem.contacts.size()); ++i) {
      const auto& contact = problem.contacts[static_cast<std::size_t>(i)];
      if (contact.a >= 0) contacts[static_cast<std::size_t>(contact.a)].push_back(i);
      contacts[static_cast<std::size_t>(contact.b)].push_back(i);
    }
  }
  EquilibriumProblem of(int block) const {
    return alone(problem, block, contacts[static_cast<std::size_t>(block)]);
  }
};

}  // namespace

std::vector<SingleBlock> single_blocks(const Scene& scene, double tolerance) {
  const ProblemOfBlocks all(problem_of(scene, Joints::Yield));
  std::vector<ProblemOfBlocks> brittle;
  if (has_tension(scene))
    for (const Joints joints : {Joints::Whole, Joints::Broken})
      brittle.emplace_back(problem_of(scene, joints));
  std::vector<SingleBlock> result;
  for (std::size_t b = 0; b < all.problem.blocks.size(); ++b) {
    if (!all.problem.blocks[b].moves) continue;
    const int block = static_cast<int>(b);
    SingleBlock single{block, geometry::mass_properties(scene.blocks[b].body()).volume};
    const EquilibriumProblem own = all.of(block);
    const EquilibriumProblem smooth = weakened(own, kNone);
    single.key = verdict(smooth) == EquilibriumVerdict::Mechanism;
    single.removable = single.key || opens(smooth);
    if (single.key) find_strength(own, tolerance, single);
    if (single.key && !brittle.empty()) single.stands.reset();
    for (const ProblemOfBlocks& other : brittle) {
      SingleBlock found;
      if (single.key) find_strength(other.of(block), tolerance, found);
      single.stands = std::max(single.stands, found.stands);
    }
    result.push_back(single);
  }
  std::ranges::sort(result, [](const SingleBlock& x, const SingleBlock& y) {
    return std::tuple(!x.key, -x.volume, x.block) < std::tuple(!y.key, -y.volume, y.block);
  });
  return result;
}

}  // namespace quoin::limit_analysis
