#pragma once
/// The linearised contact problem of a step as numbers of its own. As text:
/// tools/scene_file/contact_problem_file.hpp.
///
///   M v = f + H r,   u = Hᵀ v + w,   and at each contact Coulomb's law:
///   0 <= r_n ⊥ u_n >= 0,   |r_t| <= mu r_n,   r_t against u_t at the limit.
///
/// v are increments of the step (m, turns, strains), u gaps and slips at its end, r forces: the
/// names of fclib's global problem [Acary, Brémond, Koziara & Pérignon 2014].

#include <quoin/solver/simulation.hpp>

namespace quoin::solver {

struct ContactProblem {
  /// Not aligned: so code that is compiled for other instructions can give them back.
  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor | Eigen::DontAlign>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor | Eigen::DontAlign>;
  struct Block {
    double length = 0.0;  ///< size, m: turns moments into forces
    Matrix matrix;        ///< M, 6×6 or 12×12, symmetric positive definite
    Vector force;         ///< f
    Vector guess;         ///< v that the iteration starts from
  };
  struct Contact {
    int a = -1, b = -1;     ///< its blocks, not the same; -1: none with unknowns
    double friction = 0.0;  ///< mu
    Vector3 offset;         ///< w: gap and two slips, m
    Matrix rows_a, rows_b;  ///< Hᵀ, 3×6 or 3×12; empty without a block
    Vector3 force;          ///< r that the iteration starts from: normal and two tangents, N
  };
  std::vector<Block> blocks{};
  std::vector<Contact> contacts{};
  int first_block = -1;  ///< lowest of its blocks in the scene: names the island; -1: from a file
};

struct ContactSolution {
  bool converged = false;
  int solves = 0;  ///< right-hand sides
  int factorizations = 0;
  std::vector<Vector3> forces;  ///< r, by contact, N
};

/// Solves it as a step would; Automatic: as ProximalNewton does, which is not exact where friction
/// is above 4 (solver/README.md, "Steep friction"). `tolerance`: as StepOptions::tolerance.
/// Throws InputError naming the block or contact that is not as described above.
ContactSolution solve(const ContactProblem& problem, ContactIteration iteration, double tolerance);

/// How far forces are from the law when the blocks bear them exactly. Throws as `solve` does.
struct ContactError {
  double force = 0.0;  ///< largest |x - P(x - y)| on the cone, contacts scaled by their own
                       ///< Delassus block, by the largest x
  double gap = 0.0;    ///< largest overlap, or gap under a force, m
};
ContactError contact_error(const ContactProblem& problem, const std::vector<Vector3>& forces);

}  // namespace quoin::solver
