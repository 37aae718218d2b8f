#include "iteration/contact_problem.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"
#include "base/messages.hpp"
#include "base/rounding.hpp"
#include "iteration/cone.hpp"
#include "iteration/moving_contacts.hpp"
#include "linear/small_matrices.hpp"

namespace quoin::solver {
namespace {

void require(bool good, const std::string& place, const std::string& what) {
  if (!good) throw InputError("contact problem: " + place + ": " + what);
}

void check(const ContactProblem::Block& block, const std::string& place) {
  const Eigen::Index n = block.force.size();
  require(n == 6 || n == 12, place,
          "its force has " + std::to_string(n) + " numbers, 6 or 12 are expected");
  require(block.matrix.rows() == n && block.matrix.cols() == n, place,
          "its matrix must have as many rows and columns as its force has numbers");
  require(block.guess.size() == n, place, "its guess must have as many numbers as its force");
  require(std::isfinite(block.length) && block.length > 0.0, place,
          "length " + text_of(block.length) + " must be finite and greater than 0");
  require(block.matrix.allFinite() && block.force.allFinite() && block.guess.allFinite(), place,
          "its matrix, force or guess is not finite");
  Matrix12 inverse;
  const ContactProblem::Matrix& m = block.matrix;
  require(invert_symmetric(m, inverse.topLeftCorner(n, n)), place,
          "its matrix must be positive definite");
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      require(std::abs(m(i, j) - m(j, i)) <= kRelativeRounding * std::sqrt(m(i, i) * m(j, j)),
              place, "its matrix must be symmetric");
}

void check(const ContactProblem& problem, const ContactProblem::Contact& contact,
           const std::string& place) {
  const int count = static_cast<int>(problem.blocks.size());
  const auto check_side = [&](int block, const ContactProblem::Matrix& rows) {
    require(block >= -1 && block < count, place,
            "block " + std::to_string(block) + " does not exist (the problem has " +
                std::to_string(count) + ")");
    if (block < 0) return;
    require(rows.rows() == 3 && rows.cols() == problem.blocks[index(block)].force.size(), place,
            "its rows of block " + std::to_string(block) +
                " must be 3, with a column for each of its unknowns");
    require(rows.allFinite(), place, "its rows are not finite");
  };
  check_side(contact.a, contact.rows_a);
  check_side(contact.b, contact.rows_b);
  require(contact.a >= 0 || contact.b >= 0, place, "it must have a block");
  require(contact.a != contact.b, place,
          "its blocks are one and the same, " + std::to_string(contact.a));
  require(std::isfinite(contact.friction) && contact.friction >= 0.0, place,
          "friction " + text_of(contact.friction) + " must be finite and not negative");
  require(contact.offset.allFinite() && contact.force.allFinite(), place,
          "its offset or force is not finite");
}

void check(const ContactProblem& problem) {
  for (std::size_t i = 0; i < problem.blocks.size(); ++i)
    check(problem.blocks[i], "block " + std::to_string(i));
  for (std::size_t i = 0; i < problem.contacts.size(); ++i)
    check(problem, problem.contacts[i], "contact " + std::to_string(i));
}

/// What the iterations work on.
struct Compiled {
  Slots slots;
  BlockSystem base;
  BlockVector force, increment;
  std::vector<LinearContact> contacts;
};

void set_jacobian(const ContactProblem::Matrix& rows, ContactJacobian& jacobian) {
  Matrix3x12 all = Matrix3x12::Zero();
  all.leftCols(rows.cols()) = rows;
  jacobian.set(all, rows.cols() == 12);
}

LinearContact compiled_contact(const ContactProblem::Contact& contact,
                               const SquareBlocks& compliance) {
  LinearContact c;
  c.slot_a = contact.a;
  c.slot_b = contact.b;
  c.law = contact.friction > 0.0 ? ContactLaw::Coulomb : ContactLaw::Frictionless;
  c.friction = contact.friction;
  c.offset = contact.offset;
  c.multiplier = contact.force;
  c.assumed = contact.force[0] > 0.0 ? ContactMode::Stick : ContactMode::Open;
  if (contact.a >= 0) set_jacobian(contact.rows_a, c.jacobian_a);
  if (contact.b >= 0) set_jacobian(contact.rows_b, c.jacobian_b);
  set_augmentation(compliance, c);
  return c;
}

Compiled compile(const ContactProblem& problem) {
  check(problem);
  Compiled result;
  std::vector<int> unknowns;
  std::vector<double> lengths;
  for (const ContactProblem::Block& block : problem.blocks) {
    const Eigen::Index n = block.force.size();
    unknowns.push_back(static_cast<int>(n));
    lengths.push_back(block.length);
    result.force.emplace_back(Vector12::Zero()).head(n) = block.force;
    result.increment.emplace_back(Vector12::Zero()).head(n) = block.guess;
  }
  result.slots = make_slots(unknowns, lengths);
  SquareBlocks compliance;
  const int width = result.slots.width();
  result.base.diagonal.resize(problem.blocks.size(), width);
  compliance.resize(problem.blocks.size(), width);
  for (std::size_t s = 0; s < problem.blocks.size(); ++s) {
    const ContactProblem::Matrix& matrix = problem.blocks[s].matrix;
    const Eigen::Index n = matrix.rows();
    result.base.diagonal[s].topLeftCorner(n, n) = matrix;
    invert_symmetric(matrix, compliance[s].topLeftCorner(n, n));
  }
  for (const ContactProblem::Contact& contact : problem.contacts)
    result.contacts.push_back(compiled_contact(contact, compliance));
  set_pairs(result.contacts, result.base);
  return result;
}

}  // namespace

ContactProblem contact_problem(const Slots& slots, const BlockSystem& base,
                               const BlockVector& force, std::span<const LinearContact> contacts,
                               const BlockVector& guess) {
  ContactProblem problem;
  problem.first_block = slots.block_of_slot.front();
  for (std::size_t s = 0; s < force.size(); ++s) {
    const int n = slots.size[s];
    problem.blocks.push_back({slots.length[s], base.diagonal[s].topLeftCorner(n, n),
                              force[s].head(n), guess[s].head(n)});
  }
  for (const LinearContact& c : contacts) {
    ContactProblem::Contact& contact = problem.contacts.emplace_back();
    contact.a = c.slot_a;
    contact.b = c.slot_b;
    contact.friction = c.law == ContactLaw::Frictionless ? 0.0 : c.friction;
    contact.offset = c.offset;
    contact.force = c.multiplier;
    if (c.slot_a >= 0)
      contact.rows_a = c.jacobian_a.columns<12>().leftCols(slots.size[index(c.slot_a)]);
    if (c.slot_b >= 0)
      contact.rows_b = c.jacobian_b.columns<12>().leftCols(slots.size[index(c.slot_b)]);
  }
  return problem;
}

ContactSolution solve(const ContactProblem& problem, ContactIteration iteration, double tolerance) {
  if (!(tolerance > 0.0 && tolerance < 1e-2))
    throw InputError("contact problem: tolerance " + text_of(tolerance) + " must lie in (0, 0.01)");
  Compiled compiled = compile(problem);
  const auto solve_by = [&](auto solver) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const ContactProblem::Block& block : problem.blocks)
      smallest = std::min(smallest, block.length);
    OpenCloseOptions options;
    options.force_tolerance = tolerance;
    options.gap_tolerance = tolerance * smallest;
    options.max_iterations = StepOptions{}.max_iterations;
    options.raise = options.predicted = true;
    return solver.solve(compiled.base, compiled.force, compiled.contacts, options,
                        compiled.increment);
  };
  const OpenCloseResult result = iteration == ContactIteration::OpenClose
                                     ? solve_by(OpenClose(compiled.slots))
                                     : solve_by(MovingContacts(compiled.slots));
  ContactSolution solution{result.converged, result.solves, result.factorizations, {}};
  for (const LinearContact& c : compiled.contacts) solution.forces.push_back(c.force);
  return solution;
}

ContactError contact_error(const ContactProblem& problem, const std::vector<Vector3>& forces) {
  const Compiled compiled = compile(problem);
  if (forces.size() != problem.contacts.size()) {
    throw InputError("contact problem: " + std::to_string(forces.size()) +
                     " forces are given for " + std::to_string(problem.contacts.size()) +
                     " contacts");
  }
  for (std::size_t i = 0; i < forces.size(); ++i)
    require(forces[i].allFinite(), "force " + std::to_string(i), "it is not finite");
  ConeProblem cones(compiled.slots, nullptr);
  cones.set(compiled.base, compiled.force, compiled.contacts, compiled.increment);
  std::vector<Vector3> x(forces.size()), motion(forces.size());
  for (std::size_t i = 0; i < forces.size(); ++i) x[i] = cones.cone_force(i, forces[i]);
  cones.respond(x, motion);
  ContactError error{relative_residual(cones.admissible(), x, motion), 0.0};
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const double gap = cones.motion(i, motion[i])[0];
    error.gap = std::max(error.gap, forces[i][0] > 0.0 ? std::abs(gap) : -gap);
  }
  return error;
}

}  // namespace quoin::solver
