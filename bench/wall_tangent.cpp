#include "wall_tangent.hpp"

#include <Eigen/LU>
#include <cmath>
#include <ctime>
#include <quoin/solver/contact_problem.hpp>
#include <random>

#include "contact/contact_jacobian.hpp"
#include "iteration/open_close.hpp"
#include "wall_scene.hpp"

namespace quoin::bench {
namespace {

using namespace quoin::solver;

/// Thrown when the problem is there: the step need not be solved.
struct Caught {};

/// The first problem of the wall's first step, and where its blocks stand.
ContactProblem first_problem(const Scene& scene, std::vector<Frame>& frames) {
  ContactProblem problem;
  StepOptions options{.time_step = 0.01};
  options.contact_problem = [&](const ContactProblem& first) {
    problem = first;
    throw Caught{};
  };
  Simulation simulation(scene, options);
  for (const BlockState& block : simulation.state().blocks)
    frames.push_back({block.centroid, block.rotation.toRotationMatrix()});
  try {
    static_cast<void>(simulation.advance());
  } catch (const Caught&) {
  }
  return problem;
}

enum class JointKind { Closed, Open, Hinge, Frictionless };

std::vector<JointKind> draw_joints(std::size_t count, double weak) {
  std::mt19937_64 random(1);
  std::vector<JointKind> kinds(count, JointKind::Closed);
  for (JointKind& kind : kinds) {
    const double drawn = static_cast<double>(random() >> 11) * 0x1p-53;
    if (drawn < weak) kind = static_cast<JointKind>(1 + static_cast<int>(3.0 * drawn / weak));
  }
  return kinds;
}

void add(const LinearContact& c, const Vector3& stiffness, BlockSystem& system) {
  const auto add_block = [&](const ContactJacobian& left, const ContactJacobian& right,
                             Part<6> block) {
    block += left.rigid.transpose() * stiffness.asDiagonal() * right.rigid;
  };
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  if (c.slot_a >= 0) add_block(c.jacobian_a, c.jacobian_a, system.diagonal.part<6>(at(c.slot_a)));
  if (c.slot_b >= 0) add_block(c.jacobian_b, c.jacobian_b, system.diagonal.part<6>(at(c.slot_b)));
  if (c.pair < 0) return;
  const Part<6> upper = system.off_diagonal.part<6>(at(c.pair));
  const bool ascending = c.slot_a < c.slot_b;
  ascending ? add_block(c.jacobian_a, c.jacobian_b, upper)
            : add_block(c.jacobian_b, c.jacobian_a, upper);
}

/// Blocks alone, and the inverses of their matrices.
SquareBlocks set_blocks(const ContactProblem& problem, WallTangent& wall) {
  SquareBlocks compliance;
  std::vector<double> lengths;
  compliance.resize(problem.blocks.size(), 6);
  wall.system.diagonal.resize(problem.blocks.size(), 6);
  for (const ContactProblem::Block& block : problem.blocks) {
    const std::size_t s = lengths.size();
    lengths.push_back(block.length);
    wall.system.diagonal[s] = block.matrix;
    compliance[s] = block.matrix.inverse();
    wall.right.emplace_back(Vector12::Zero()).head<6>() = block.force;
  }
  wall.slots = make_slots(std::vector<int>(lengths.size(), 6), lengths);
  return compliance;
}

std::vector<LinearContact> contacts_of(const ContactProblem& problem,
                                       const SquareBlocks& compliance) {
  std::vector<LinearContact> contacts;
  for (const ContactProblem::Contact& given : problem.contacts) {
    LinearContact& c = contacts.emplace_back();
    c.slot_a = given.a;
    c.slot_b = given.b;
    if (given.a >= 0) c.jacobian_a.rigid = given.rows_a;
    if (given.b >= 0) c.jacobian_b.rigid = given.rows_b;
    set_augmentation(compliance, c);
  }
  return contacts;
}

}  // namespace

WallTangent wall_tangent(int columns, int rows, double weak) {
  std::vector<Frame> frames;
  const ContactProblem problem = first_problem(wall_scene(columns, rows), frames);
  WallTangent wall;
  std::vector<LinearContact> contacts = contacts_of(problem, set_blocks(problem, wall));
  set_pairs(contacts, wall.system);
  wall.system.frames.assign(frames.begin() + problem.first_block, frames.end());
  wall.system.off_diagonal.resize(wall.system.pairs.size(), 6);
  const std::vector<JointKind> kinds = draw_joints(wall.system.pairs.size(), weak);
  std::vector<int> met(kinds.size(), 0);  // contacts of the joint so far
  for (const LinearContact& c : contacts) {
    Vector3 stiffness(c.normal_stiffness, c.shear_stiffness, c.shear_stiffness);
    if (c.pair >= 0) {
      const JointKind kind = kinds[static_cast<std::size_t>(c.pair)];
      const int before = met[static_cast<std::size_t>(c.pair)]++;
      if (kind == JointKind::Open || (kind == JointKind::Hinge && before >= 2)) continue;
      if (kind == JointKind::Frictionless) stiffness.tail<2>().setZero();
    }
    add(c, stiffness, wall.system);
  }
  return wall;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double relative_residual(const WallTangent& wall, const BlockVector& solution) {
  BlockVector rest = wall.right;
  for (std::size_t s = 0; s < rest.size(); ++s)
    rest[s].head<6>() -= wall.system.diagonal[s] * solution[s].head<6>();
  for (std::size_t p = 0; p < wall.system.pairs.size(); ++p) {
    const auto i = static_cast<std::size_t>(wall.system.pairs[p].first);
    const auto j = static_cast<std::size_t>(wall.system.pairs[p].second);
    rest[i].head<6>() -= wall.system.off_diagonal[p] * solution[j].head<6>();
    rest[j].head<6>() -= wall.system.off_diagonal[p].transpose() * solution[i].head<6>();
  }
  double left = 0.0, all = 0.0;
  for (std::size_t s = 0; s < rest.size(); ++s) {
    left += rest[s].squaredNorm();
    all += wall.right[s].squaredNorm();
  }
  return std::sqrt(left / all);
}

}  // namespace quoin::bench
