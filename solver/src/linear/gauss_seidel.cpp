#include "linear/gauss_seidel.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

// Rows of one colour stand apart in memory, where no hardware foresees the next one: they are asked
// for so many rows ahead. Takes 9 to 27 % off a solution (bench/tried.md).
constexpr std::size_t kAhead = 2;
constexpr std::size_t kCacheLine = 64;  // bytes

/// Asks for the values of the entries from `first` to before `end`.
template <class Block>
void prefetch(const std::vector<Block>& values, int first, int end) {
  const char* from = reinterpret_cast<const char*>(values.data() + first);
  const std::size_t bytes = sizeof(Block) * index(end - first);
  for (std::size_t at = 0; at < bytes; at += kCacheLine) __builtin_prefetch(from + at);
}

}  // namespace

template <int n>
bool GaussSeidel<n>::set(BlockRows<n, n> matrix, const Threads& threads) {
  matrix_ = std::move(matrix);
  set_colours();
  set_own();
  later_.resize(index(matrix_.rows()));
  return invert(threads);
}

/// Of each row the first colour that no neighbour before it has.
template <int n>
void GaussSeidel<n>::set_colours() {
  const std::size_t rows = index(matrix_.rows());
  colour_.assign(rows, -1);
  taken_.assign(rows + 1, -1);  // by colour, the last row that saw it
  int colours = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t k = index(matrix_.start[i]); k < index(matrix_.start[i + 1]); ++k) {
      const int other = colour_[index(matrix_.column[k])];
      if (other >= 0) taken_[index(other)] = static_cast<int>(i);
    }
    int free = 0;
    while (taken_[index(free)] == static_cast<int>(i)) ++free;
    colour_[i] = free;
    colours = std::max(colours, free + 1);
  }
  order_.resize(rows);
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::stable_sort(order_, {}, [&](int i) { return colour_[index(i)]; });
  colour_start_.assign(index(colours) + 1, 0);
  for (const int colour : colour_) ++colour_start_[index(colour) + 1];
  std::partial_sum(colour_start_.begin(), colour_start_.end(), colour_start_.begin());
}

/// Sorts the entries of each row by colour.
template <int n>
void GaussSeidel<n>::set_own() {
  own_.resize(index(matrix_.rows()));
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const int first = matrix_.start[i], end = matrix_.start[i + 1];
    const auto colour = [&](int k) { return colour_[index(matrix_.column[index(k)])]; };
    for (int k = first + 1; k < end; ++k) {  // few entries, nearly sorted
      for (int l = k; l > first && colour(l) < colour(l - 1); --l) matrix_.swap_entries(l, l - 1);
    }
    int own = first;
    while (matrix_.column[index(own)] != static_cast<int>(i)) ++own;
    own_[i] = own;
  }
}

template <int n>
bool GaussSeidel<n>::invert(const Threads& threads) {
  inverse_.resize(own_.size());
  threads.each(own_.size(),
               [&](std::size_t i) { inverse_[i] = matrix_.value[index(own_[i])].inverse(); });
  return std::ranges::all_of(inverse_, [](const Square& m) { return m.allFinite(); });
}

template <int n>
typename GaussSeidel<n>::Vector GaussSeidel<n>::times(int first, int end,
                                                      const Blocks<n>& x) const {
  Vector sum = Vector::Zero();
  for (std::size_t k = index(first); k < index(end); ++k) {
    sum.noalias() += matrix_.value[k] * x[index(matrix_.column[k])];
  }
  return sum;
}

template <int n>
void GaussSeidel<n>::there(const Threads& threads, const Blocks<n>& right, Blocks<n>& solution,
                           Blocks<n>& residual) const {
  for (std::size_t c = 0; c + 1 < colour_start_.size(); ++c) {
    threads.each(colour_start_[c + 1] - colour_start_[c], [&](std::size_t k) {
      const std::size_t at = colour_start_[c] + k, i = index(order_[at]);
      const std::size_t next = index(order_[std::min(at + kAhead, order_.size() - 1)]);
      prefetch(matrix_.value, matrix_.start[next], own_[next]);
      solution[i].noalias() = inverse_[i] * (right[i] - earlier(i, solution));
    });
  }
  threads.each(residual.size(), [&](std::size_t i) { residual[i] = -later(i, solution); });
}

template <int n>
void GaussSeidel<n>::back(const Threads& threads, const Blocks<n>& right, Blocks<n>& solution) {
  for (std::size_t c = colour_start_.size() - 1; c-- > 0;) {
    threads.each(colour_start_[c + 1] - colour_start_[c], [&](std::size_t k) {
      const std::size_t at = colour_start_[c] + k, i = index(order_[at]);
      const std::size_t next = index(order_[std::min(at + kAhead, order_.size() - 1)]);
      prefetch(matrix_.value, matrix_.start[next], matrix_.start[next + 1]);
      later_[i] = later(i, solution);
      solution[i].noalias() = inverse_[i] * (right[i] - earlier(i, solution) - later_[i]);
    });
  }
}

template <int n>
void GaussSeidel<n>::multiply(const Threads& threads, const Blocks<n>& solution,
                              Blocks<n>& product) const {
  threads.each(product.size(), [&](std::size_t i) {
    product[i] = times(matrix_.start[i], own_[i] + 1, solution) + later_[i];
  });
}

template class GaussSeidel<6>;
template class GaussSeidel<12>;

}  // namespace quoin::solver
