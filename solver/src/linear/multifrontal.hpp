#pragma once
/// Direct solution of K x = f for a sparse matrix of blocks.

#include <Eigen/Core>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/step_watch.hpp"
#include "base/threads.hpp"
#include "block/block_system.hpp"
#include "linear/front_kernels.hpp"

namespace quoin::solver {

/// Lists, one after another.
template <class Item>
struct ListsOf {
  std::vector<int> start{0};  ///< of each list in `entries`, and the end of the last
  std::vector<Item> entries;

  std::size_t size() const { return start.size() - 1; }
  std::span<const Item> operator[](std::size_t list) const {
    return {entries.data() + start[list], entries.data() + start[list + 1]};
  }
};
using Lists = ListsOf<int>;

/// `entries` calls what it is given with (list, item) for each entry, twice the same.
template <class Item = int, class Entries>
ListsOf<Item> make_lists(std::size_t count, const Entries& entries) {
  const auto at = [](int list) { return static_cast<std::size_t>(list); };
  ListsOf<Item> lists;
  lists.start.assign(count + 1, 0);
  entries([&](int list, const Item&) { ++lists.start[at(list) + 1]; });
  std::partial_sum(lists.start.begin(), lists.start.end(), lists.start.begin());
  lists.entries.resize(at(lists.start.back()));
  std::vector<int> next(lists.start.begin(), lists.start.end() - 1);
  entries([&](int list, const Item& item) { lists.entries[at(next[at(list)]++)] = item; });
  return lists;
}

/// Neighbouring places of the order that are eliminated together, as one dense matrix.
struct Supernode {
  int first = 0, end = 0;  ///< its places
  int parent = -1;         ///< supernode that takes what is left of it; -1: none is left
};

/// In which order the blocks of a sparse matrix are eliminated, and in which groups.
struct Elimination {
  std::vector<int> node_at;   ///< by place
  std::vector<int> place_of;  ///< by node
  std::vector<Supernode>
      supernodes;  ///< children before parents, the last child right before its parent
  Lists below;     ///< by supernode: later places that it couples, ascending
};

/// Multifrontal elimination: each supernode is a dense matrix, the front, of which the columns of
/// its own are eliminated and the rest is handed to its parent.   [Duff & Reid 1983; Liu 1992]
/// Threads share the rows of large fronts; the same bits for any number.
/// Keeps its memory, and order and supernodes while the pattern stays. Where many pairs are zero,
/// order and supernodes are of the others alone; the same matrix is always eliminated in the same
/// order.
class Multifrontal {
 public:
  /// `watch`, where there is one, is looked at during factorize(), which then throws StepStopped.
  explicit Multifrontal(const Slots& slots, StepWatch* watch = nullptr)
      : slots_(&slots), watch_(watch) {}

  /// From the next factorize() on.
  void use(const Threads& threads) { threads_ = threads; }

  /// L L^T for a symmetric matrix; for another L U with row exchanges inside a supernode. False
  /// when it is singular to working accuracy, or symmetric and not positive definite.
  bool factorize(const BlockSystem& system);
  void solve(const BlockVector& right, BlockVector& solution);

  /// Gives the memory of the factors back; no more solve() until the next factorize().
  void release();

  /// Multiplications that the factors of such a matrix take, about, where no pair is zero: reads
  /// the pattern alone.
  double work(const BlockSystem& system);

  /// Ratio of the largest to the smallest pivot: a lower estimate of the condition number.
  double condition_estimate() const;

 private:
  using Matrix = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

  /// A pair of the system as the front of the earlier of its two slots sees it.
  struct Coupling {
    int pair = 0;
    int other = 0;         ///< place of the later slot
    bool forward = false;  ///< the later slot is pair.first
  };

  /// One supernode: sizes in unknowns, and where its factors stand in factor_.
  struct Front {
    int first = 0, own = 0, below = 0;
    std::size_t columns = 0;  ///< (own + below) × own
    std::size_t rows = 0;     ///< below × own, transposed; where not symmetric
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

  /// What a front has left for its parent, in stack_.
  struct Waiting {
    std::size_t front = 0, rest = 0;
  };

  /// A front as dense matrices: what becomes its factors, and what they leave.
  struct Dense {
    Matrix columns, rows, rest;
  };

  void analyse(const BlockSystem& system, const std::vector<int>& coupled, Analysis& result);
  void analyse_pattern(const BlockSystem& system);
  void choose_analysis(const BlockSystem& system);
  const Analysis& analysis() const { return in_part_ ? part_ : whole_; }
  int size_at(int place) const;
  void place_factors();
  Dense dense(const Front& front);
  bool eliminate(const BlockSystem& system, std::size_t node);
  bool eliminate_symmetric(Dense& front, double* pivots) const;
  bool eliminate_general(Dense& front, double* pivots, int* exchanges) const;
  template <class Work>
  void each_strip(long rows, const Work& work) const;
  void add_own_blocks(const BlockSystem& system, std::size_t node, Dense& front);
  void add_rest(const Waiting& child, std::size_t node, Dense& front);
  void forward(std::size_t node);
  void backward(std::size_t node);
  Eigen::VectorBlock<Eigen::VectorXd> unknowns_of(std::size_t slot);

  const Slots* slots_;
  StepWatch* watch_;
  Threads threads_;
  bool symmetric_ = true;  // what was factorized last
  bool placed_ = false;
  std::vector<std::pair<int, int>> pairs_;  // that whole_ is made for
  Analysis whole_, part_;                   // of all pairs, and of those that are not zero
  bool in_part_ = false;                    // what is factorized
  std::vector<int> coupled_;                // memory of choose_analysis()
  std::vector<double> factor_, stack_;
  std::size_t top_ = 0;             // of stack_
  std::vector<Waiting> waiting_;    // children of fronts to come
  std::vector<std::size_t> taken_;  // of each front, by the rests of its children
  std::vector<int> local_;          // of each place, its first unknown in the present front
  std::vector<int> exchanges_;      // of each place in the elimination, the row it changed with
  Eigen::VectorXd pivots_, vector_, below_;
};

}  // namespace quoin::solver
