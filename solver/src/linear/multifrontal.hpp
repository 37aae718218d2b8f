#pragma once
/// Direct solution of K x = f for a sparse matrix of blocks.

#include <Eigen/Core>

#include "block_system.hpp"
#include "elimination.hpp"
#include "front_kernels.hpp"
#include "step_watch.hpp"

namespace quoin::solver {

/// Multifrontal elimination: each supernode is a dense matrix, the front, of which the columns of
/// its own are eliminated and the rest is handed to its parent.   [Duff & Reid 1983; Liu 1992]
/// Keeps its memory, and order and supernodes while the pattern stays. Where many pairs are zero,
/// order and supernodes are of the others alone; the same matrix is always eliminated in the same
/// order.
class Multifrontal {
 public:
  /// `watch`, where there is one, is looked at during factorize(), which then throws StepStopped.
  explicit Multifrontal(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), watch_(watch) {}

  /// L L^T for a symmetric matrix; for another L U with row exchanges inside a supernode. False
  /// when it is singular to working accuracy, or symmetric and not positive definite.
  bool factorize(const BlockSystem& system);
  /// The same of a matrix that is solved once, for `only`: of one that is not symmetric L is used
  /// as it comes, and half of the factors are not kept.
  bool factorize(const BlockSystem& system, const BlockVector& only);
  /// `right`: after factorize() with it, `only`.
  void solve(const BlockVector& right, BlockVector& solution);

  /// Gives the memory of the factors back; no more solve() until the next factorize().
  void release();

  /// Multiplications that the factors of such a matrix take, about, where no pair is zero: reads
  /// the pattern alone.
  double work(const BlockSystem& system);

  /// Ratio of the largest to the smallest pivot: a lower estimate of the condition number.
  double condition_estimate() const;

 private:
  /// A pair of the system as the front of the earlier of its two slots sees it.
  struct Coupling {
    int pair = 0;
    int other = 0;         ///< place of the later slot
    bool forward = false;  ///< the later slot is pair.first
  };

  /// One supernode: sizes in unknowns, and where its numbers stand.
  struct Front {
    int first = 0, own = 0, below = 0;
    std::size_t columns = 0;  ///< in factor_: (own + below) × own; the upper own × own, where L
                              ///< is not kept
    std::size_t rows = 0;     ///< in factor_: below × own, transposed; where not symmetric
  };

  /// What hangs on which blocks are coupled.
  struct Analysis {
    bool made = false;
    std::vector<int> coupled;  ///< pairs of the system that it is made for
    Elimination elimination;
    std::vector<int> start;                        ///< first unknown of each place, and the total
    std::vector<std::vector<Coupling>> couplings;  ///< by place
    std::vector<Front> fronts;                     ///< by supernode
    double work = 0.0;  ///< multiplications, about, of a matrix that is not symmetric
  };

  /// The numbers of a front while it is assembled and eliminated.
  struct Parts {
    Columns columns, rows, rest;  ///< rows: transposed
  };

  /// Neighbouring unknowns of a child's rest that stand side by side in the front of its parent.
  struct Run {
    int from = 0, to = 0, count = 0;
  };

  void look() const {
    if (watch_ != nullptr) watch_->look();
  }
  bool factorize(const BlockSystem& system, const BlockVector* only);
  void analyse(const BlockSystem& system, const std::vector<int>& coupled, Analysis& result);
  void analyse_pattern(const BlockSystem& system);
  void choose_analysis(const BlockSystem& system);
  Analysis& analysis() { return in_part_ ? part_ : whole_; }
  void place_factors();
  Parts parts(const Front& front, double* rest);
  void add_own_blocks(const BlockSystem& system, std::size_t node, const Parts& front);
  void find_runs(std::size_t child, int own);
  void add_rest(std::size_t child, const double* rest, std::size_t node, const Parts& front);
  bool eliminate_symmetric(std::size_t node, const Parts& parts);
  bool eliminate_general(std::size_t node, const Parts& parts);
  void take(const BlockVector& right);
  void forward(std::size_t node);
  void backward(std::size_t node);
  Eigen::VectorBlock<Eigen::VectorXd> unknowns_of(std::size_t slot);

  const Slots* slots_;
  StepWatch* watch_;
  bool symmetric_ = true;    // what was factorized last
  bool keeps_lower_ = true;  // of it
  bool placed_ = false;
  std::vector<std::pair<int, int>> pairs_;  // that whole_ is made for
  Analysis whole_, part_;                   // of all pairs, and of those that are not zero
  bool in_part_ = false;                    // what is factorized
  std::vector<int> coupled_;                // memory of choose_analysis()
  std::vector<int> local_;                  // of each place, its first unknown in the present front
  std::vector<Run> runs_;                   // of the child that is being added
  std::vector<std::size_t> waiting_;        // memory of factorize(), place_factors()
  std::vector<double> factor_, stack_;      // stack_: rests that wait for their parent
  std::vector<double> columns_;             // of the present front, where L is not kept
  std::vector<int> exchanges_;  // of each place in the elimination, the row it changed with
  Eigen::VectorXd pivots_;      // by elimination
  Eigen::VectorXd vector_, below_;
};

}  // namespace quoin::solver
