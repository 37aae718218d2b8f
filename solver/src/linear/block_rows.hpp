#pragma once
/// Sparse matrices of dense blocks, kept by rows, and their products.

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "base/step_watch.hpp"
#include "base/threads.hpp"

namespace quoin::solver {

/// A vector of blocks of n unknowns.
template <int n>
using Blocks = std::vector<Eigen::Matrix<double, n, 1>>;

template <int r, int c>
struct BlockRows {
  using Block = Eigen::Matrix<double, r, c>;

  int columns = 0;
  std::vector<int> start{0};  ///< first entry of each row, and the number of all
  std::vector<int> column;    ///< by entry
  std::vector<Block> value;   ///< by entry

  int rows() const { return static_cast<int>(start.size()) - 1; }
  void push_back(int at, const Block& block) {
    column.push_back(at);
    value.push_back(block);
  }
  void end_row() { start.push_back(static_cast<int>(column.size())); }
  void swap_entries(int k, int l) {
    std::swap(column[static_cast<std::size_t>(k)], column[static_cast<std::size_t>(l)]);
    std::swap(value[static_cast<std::size_t>(k)], value[static_cast<std::size_t>(l)]);
  }

  /// Row i times x.
  Eigen::Matrix<double, r, 1> times(int i, const Blocks<c>& x) const {
    Eigen::Matrix<double, r, 1> sum = Eigen::Matrix<double, r, 1>::Zero();
    for (auto k = static_cast<std::size_t>(start[static_cast<std::size_t>(i)]);
         k < static_cast<std::size_t>(start[static_cast<std::size_t>(i) + 1]); ++k) {
      sum.noalias() += value[k] * x[static_cast<std::size_t>(column[k])];
    }
    return sum;
  }
};

/// Where a b has entries, of a row in the order in which they are met; their values are not set.
template <int r, int m, int c>
BlockRows<r, c> product_pattern(const BlockRows<r, m>& a, const BlockRows<m, c>& b) {
  BlockRows<r, c> result;
  result.columns = b.columns;
  std::vector<int> entry(static_cast<std::size_t>(b.columns), -1);  // of each column, in this row
  for (std::size_t i = 0; i + 1 < a.start.size(); ++i) {
    for (int k = a.start[i]; k < a.start[i + 1]; ++k) {
      const auto middle = static_cast<std::size_t>(a.column[static_cast<std::size_t>(k)]);
      for (int l = b.start[middle]; l < b.start[middle + 1]; ++l) {
        const int column = b.column[static_cast<std::size_t>(l)];
        int& at = entry[static_cast<std::size_t>(column)];
        if (at >= result.start.back()) continue;
        at = static_cast<int>(result.column.size());
        result.column.push_back(column);
      }
    }
    result.end_row();
  }
  result.value.resize(result.column.size());
  return result;
}

/// Row i of a b, whose pattern is there. `places`, by column: memory.
template <int r, int m, int c>
void set_product_row(std::size_t i, const BlockRows<r, m>& a, const BlockRows<m, c>& b,
                     std::vector<std::size_t>& places, BlockRows<r, c>& result) {
  for (auto k = static_cast<std::size_t>(result.start[i]);
       k < static_cast<std::size_t>(result.start[i + 1]); ++k) {
    result.value[k].setZero();
    places[static_cast<std::size_t>(result.column[k])] = k;
  }
  for (auto k = static_cast<std::size_t>(a.start[i]); k < static_cast<std::size_t>(a.start[i + 1]);
       ++k) {
    const auto middle = static_cast<std::size_t>(a.column[k]);
    for (auto l = static_cast<std::size_t>(b.start[middle]);
         l < static_cast<std::size_t>(b.start[middle + 1]); ++l) {
      const std::size_t at = places[static_cast<std::size_t>(b.column[l])];
      result.value[at].noalias() += a.value[k] * b.value[l];
    }
  }
}

/// a b. `watch`, where there is one, is looked at in each row.
template <int r, int m, int c>
BlockRows<r, c> product(const Threads& threads, const BlockRows<r, m>& a, const BlockRows<m, c>& b,
                        StepWatch* watch = nullptr) {
  BlockRows<r, c> result = product_pattern(a, b);
  threads.ranges(static_cast<std::size_t>(result.rows()), [&](std::size_t first, std::size_t end) {
    std::vector<std::size_t> places(static_cast<std::size_t>(result.columns));
    for (std::size_t i = first; i < end; ++i) {
      if (watch != nullptr) watch->look();
      set_product_row(i, a, b, places, result);
    }
  });
  return result;
}

template <int r, int c>
BlockRows<c, r> transposed(const BlockRows<r, c>& a) {
  BlockRows<c, r> result;
  result.columns = a.rows();
  result.start.assign(static_cast<std::size_t>(a.columns) + 1, 0);
  for (const int column : a.column) ++result.start[static_cast<std::size_t>(column) + 1];
  for (std::size_t i = 1; i < result.start.size(); ++i) result.start[i] += result.start[i - 1];
  result.column.resize(a.column.size());
  result.value.resize(a.value.size());
  std::vector<int> next(result.start.begin(), result.start.end() - 1);
  for (std::size_t i = 0; i + 1 < a.start.size(); ++i) {
    for (auto k = static_cast<std::size_t>(a.start[i]);
         k < static_cast<std::size_t>(a.start[i + 1]); ++k) {
      const auto to = static_cast<std::size_t>(next[static_cast<std::size_t>(a.column[k])]++);
      result.column[to] = static_cast<int>(i);
      result.value[to] = a.value[k].transpose();
    }
  }
  return result;
}

}  // namespace quoin::solver
