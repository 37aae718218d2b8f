#pragma once
/// Direct solution of K x = f for a sparse matrix of blocks.

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "block/block_system.hpp"
#include "linear/dense_front.hpp"
#include "linear/elimination.hpp"

namespace quoin::solver {

/// Multifrontal elimination: each supernode is a dense matrix, the front, of which the columns of
/// its own are eliminated and the rest is handed to its parent.   [Duff & Reid 1983; Liu 1992]
/// Of a large matrix threads eliminate parts of the tree side by side, then share the fronts above
/// them; the same bits for any number.
/// Keeps its memory, and order and supernodes while the pattern stays. Where many pairs are zero,
/// order and supernodes are of the others alone; the same matrix is always eliminated in the same
/// order.
class Multifrontal {
 public:
  /// `watch`, where there is one, is looked at during factorize(), which then throws StepStopped.
  explicit Multifrontal(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), watch_(watch) {}

  /// From the next factorize() on.
  void use(const Threads& threads) { next_threads_ = threads; }

  /// L L^T for a symmetric matrix; for another L U with row exchanges inside a supernode. False
  /// when it is singular to working accuracy, or symmetric and not positive definite.
  /// `only`: the matrix is solved once, for it: of one that is not symmetric L is used as it comes,
  /// and half of the factors are not kept.
  bool factorize(const BlockSystem& system, const BlockVector* only = nullptr);
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
    std::vector<int> start;       ///< first unknown of each place, and the total
    ListsOf<Coupling> couplings;  ///< by place
    std::vector<Front> fronts;    ///< by supernode
    double work = 0.0;            ///< multiplications, about, of a matrix that is not symmetric
  };

  /// Neighbouring unknowns of a child's rest that stand side by side in the front of its parent.
  struct Run {
    int from = 0, to = 0, count = 0;
  };

  /// Fronts that one thread eliminates: from `first` up to `end`, the last of which is the root.
  struct Subtree {
    std::size_t first = 0, end = 0;
    std::size_t rest = 0;    ///< in rests_: what its root leaves
    std::size_t pushes = 0;  ///< in pushes_: what its fronts take off unknowns beyond it
    int beyond = 0;          ///< the first of these
  };

  /// What a front has left for its parent.
  struct Waiting {
    std::size_t front = 0;
    const double* rest = nullptr;
    bool on_stack = false;  ///< of its lane
  };

  /// Memory of one thread.
  struct Lane {
    std::vector<int> local;        // of each place, its first unknown in the present front
    std::vector<Run> runs;         // of the child that is being added
    std::vector<Waiting> waiting;  // children of fronts to come
    std::vector<double> stack;     // their rests, up to `top`
    std::size_t top = 0;
    std::vector<double> columns;  // of the present front, where L is not kept
    Eigen::VectorXd below;
  };

  /// Where what is taken off unknowns from `first` on goes instead.
  struct Beyond {
    int first = std::numeric_limits<int>::max();
    double* to = nullptr;
  };
  void analyse(const BlockSystem& system, const std::vector<int>& coupled, Analysis& result);
  void analyse_pattern(const BlockSystem& system);
  void choose_analysis(const BlockSystem& system);
  Analysis& analysis() { return in_part_ ? part_ : whole_; }
  const Analysis& analysis() const { return in_part_ ? part_ : whole_; }
  void part_tree();
  void place_factors();
  void place_lane(std::size_t first, std::size_t end, std::vector<Subtree>::const_iterator subtree,
                  Lane& lane);
  DenseFront dense(const Front& front, Lane& lane);
  void add_own_blocks(const BlockSystem& system, std::size_t node, Lane& lane,
                      const DenseFront& front);
  void find_runs(std::size_t child, int own, Lane& lane);
  void add_rest(const Waiting& child, std::size_t node, Lane& lane, const DenseFront& front);
  void add_children(std::size_t node, Lane& lane, const DenseFront& front);
  bool eliminate(const BlockSystem& system, std::size_t node, const Threads& threads, Lane& lane,
                 Beyond& beyond);
  bool eliminate_subtree(const BlockSystem& system, const Subtree& subtree, Lane& lane);
  bool eliminate_subtrees(const BlockSystem& system);
  bool eliminate_rest(const BlockSystem& system);
  template <class OnFront, class OnSubtree>
  void walk(const OnFront& front, const OnSubtree& leave_out) const;
  void take(const BlockVector& right);
  void take_off_beyond(const Subtree& subtree);
  void forward(std::size_t node, Lane& lane, Beyond& beyond);
  void backward(std::size_t node, Lane& lane);
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
  std::vector<double> factor_;
  std::vector<int> exchanges_;  // of each place in the elimination, the row it changed with
  Eigen::VectorXd pivots_;      // by elimination
  Eigen::VectorXd vector_;
  Threads threads_, next_threads_;      ///< of this factorize() and solve(), and of the next ones
  int workers_ = 0;                     // that subtrees_ are made for
  std::vector<Subtree> subtrees_;       // in the order of their fronts
  std::vector<Lane> lanes_;             // of the fronts that are in none, then of each worker
  std::vector<double> rests_, pushes_;  // of subtrees_
  std::vector<std::size_t> taken_;      // memory of place_lane(), part_tree()
  std::vector<double> subtree_work_;    // likewise
};

}  // namespace quoin::solver
