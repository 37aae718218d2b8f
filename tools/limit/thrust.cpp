#include "limit/thrust.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <quoin/geometry/mass_properties.hpp>
#include <stdexcept>

namespace quoin::limit_analysis {
namespace {

constexpr double kLeastShrink = 1e-3;
constexpr int kMostThrust = 100;  // of all weights and loads

int fixed_block(const Scene& scene, const std::string& name) {
  for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
    if (scene.blocks[b].name != name) continue;
    if (scene.blocks[b].kind == solver::BlockKind::Fixed) return static_cast<int>(b);
    throw std::invalid_argument("--thrust " + name + ": the block has to be fixed");
  }
  throw std::invalid_argument("--thrust " + name + ": there is no block of that name");
}

/// Horizontal, from the blocks that move to the support.
Vector3 outwards(const Scene& scene, const EquilibriumProblem& problem, std::size_t support) {
  Vector3 middle = Vector3::Zero();
  double count = 0.0;
  for (const solver::EquilibriumBlock& block : problem.blocks) {
    if (!block.moves) continue;
    middle += block.place;
    count += 1.0;
  }
  const Vector3 down = scene.gravity.at(0.0);
  Vector3 way = problem.blocks[support].place - middle / std::max(count, 1.0);
  if (down.norm() > 0.0) way -= way.dot(down) / down.squaredNorm() * down;
  if (!(way.norm() > 1e-9 * problem.blocks[support].size))
    throw std::invalid_argument("--thrust: the support stands right below the structure");
  return way.normalized();
}

/// The support slides along the way and does nothing else.
void guide(EquilibriumProblem& problem, int support, const Vector3& way) {
  solver::EquilibriumBlock& block = problem.blocks[static_cast<std::size_t>(support)];
  block.moves = true;
  const Vector3 side = way.unitOrthogonal(), up = way.cross(side);
  const auto add = [&](const Vector3& arm, const Vector3& normal) {
    solver::EquilibriumContact contact;
    contact.b = support;
    contact.point = block.place + block.size * arm;
    contact.normal = normal;
    contact.guided = true;
    problem.contacts.push_back(contact);
  };
  for (const Vector3& arm : {way, Vector3(-way), side}) add(arm, up);
  for (const Vector3& arm : {way, Vector3(-way)}) add(arm, side);
}

double all_loads(const EquilibriumProblem& problem) {
  double sum = 0.0;
  for (const solver::EquilibriumBlock& block : problem.blocks) sum += block.load.head<3>().norm();
  return sum;
}

/// Of a push of the support along `sign` times the way against the structure.
Limit extreme(const Scene& scene, EquilibriumProblem problem, int support, const Vector3& push,
              double start, double tolerance) {
  solver::EquilibriumBlock& block = problem.blocks[static_cast<std::size_t>(support)];
  const double range = kMostThrust * std::max(all_loads(problem), 1e-300);
  block.load.setZero();
  block.load.head<3>() = start * push;
  block.live.head<3>() = push;
  const auto at = [&](double value) {
    Trial trial{value, scene, problem, value - start};
    trial.found = solver::find_equilibrium(problem, trial.factor);
    return trial;
  };
  Limit limit = prove_factor(at, solver::largest_load_factor(problem, range), start, start + range,
                             tolerance);
  limit.everywhere = limit.stands && limit.stands->value >= start + range;
  if (limit.everywhere)
    limit.why =
        "it is admissible up to " + std::to_string(kMostThrust) + " times all weights and loads";
  else if (limit.stands && !limit.falls && limit.why.empty())
    limit.why = "no mechanism is proved";
  return limit;
}

EquilibriumProblem shrunk(EquilibriumProblem problem, double share) {
  std::map<std::pair<int, int>, std::pair<Vector3, double>> middles;
  for (const auto& contact : problem.contacts) {
    if (contact.held) continue;
    auto& [sum, count] =
        middles.try_emplace({contact.a, contact.b}, Vector3::Zero(), 0.0).first->second;
    sum += contact.point;
    count += 1.0;
  }
  for (auto& contact : problem.contacts) {
    if (contact.held) continue;
    const auto& [sum, count] = middles.at({contact.a, contact.b});
    const Vector3 middle = sum / count;
    contact.point = middle + share * (contact.point - middle);
  }
  return problem;
}

}  // namespace

Thrust thrust_on(const Scene& scene, const std::string& name, double tolerance) {
  const int support = fixed_block(scene, name);
  const EquilibriumProblem problem = solver::equilibrium_problem(scene);
  Thrust result{.direction = outwards(scene, problem, static_cast<std::size_t>(support))};
  const Equilibrium found = solver::find_equilibrium(problem);
  double start = 0.0;  // some thrust that is admissible
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const auto& contact = problem.contacts[i];
    if (contact.b == support) start += found.forces[i].dot(result.direction);
    if (contact.a == support) start -= found.forces[i].dot(result.direction);
  }
  if (found.verdict == EquilibriumVerdict::Admissible) {
    EquilibriumProblem guided = problem;
    guide(guided, support, result.direction);
    const Vector3 inwards = -result.direction;
    result.greatest = extreme(scene, guided, support, inwards, start, tolerance);
    result.least = extreme(scene, guided, support, result.direction, -start, tolerance);
  } else {
    result.least.why = result.greatest.why = "no forces balance the loads of the scene";
  }
  const auto at = [&](double share) {
    Trial trial{share, scene, shrunk(problem, share)};
    trial.shrink = share;
    trial.found = solver::find_equilibrium(trial.problem);
    return trial;
  };
  result.shrink = prove_between(at, 1.0, kLeastShrink, tolerance);
  return result;
}

}  // namespace quoin::limit_analysis
