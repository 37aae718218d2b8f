#include "block_rows.hpp"

#include <numeric>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

/// An entry of a row: which block of the system, and whether its transpose.
struct Source {
  const SquareBlocks* blocks;
  std::size_t block;
  bool transposed;
};

/// Where the system has entries: of each row its own first, then in the order of the pairs.
template <int n>
BlockRows<n> pattern(const BlockSystem& system, const std::vector<char>& coupled,
                     std::vector<Source>& sources) {
  BlockRows<n> rows;
  const std::size_t count = system.diagonal.size();
  rows.columns = static_cast<int>(count);
  rows.start.assign(count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) ++rows.start[i + 1];
  for (std::size_t p = 0; p < coupled.size(); ++p) {
    rows.start[index(system.pairs[p].first) + 1] += coupled[p];
    rows.start[index(system.pairs[p].second) + 1] += coupled[p];
  }
  std::partial_sum(rows.start.begin(), rows.start.end(), rows.start.begin());
  rows.column.resize(index(rows.start.back()));
  rows.value.resize(rows.column.size());
  sources.resize(rows.column.size());
  std::vector<int> next(rows.start.begin(), rows.start.end() - 1);
  const auto put = [&](int row, int column, Source source) {
    const std::size_t at = index(next[index(row)]++);
    rows.column[at] = column;
    sources[at] = source;
  };
  for (int i = 0; i < rows.columns; ++i) put(i, i, {&system.diagonal, index(i), false});
  for (std::size_t p = 0; p < coupled.size(); ++p) {
    if (!coupled[p]) continue;
    const auto [i, j] = system.pairs[p];
    put(i, j, {&system.off_diagonal, p, false});
    put(j, i, {system.symmetric ? &system.off_diagonal : &system.mirrored, p, system.symmetric});
  }
  return rows;
}

}  // namespace

template <int n>
BlockRows<n> block_rows(const BlockSystem& system, const Slots& slots) {
  std::vector<char> coupled(system.pairs.size());
  for (std::size_t p = 0; p < coupled.size(); ++p) {
    const bool none =
        system.off_diagonal[p].isZero(0.0) && (system.symmetric || system.mirrored[p].isZero(0.0));
    coupled[p] = none ? 0 : 1;
  }
  std::vector<Source> sources;
  BlockRows<n> rows = pattern<n>(system, coupled, sources);
  for (std::size_t i = 0; i < index(rows.columns); ++i) {
    for (std::size_t k = index(rows.start[i]); k < index(rows.start[i + 1]); ++k) {
      auto& block = rows.value[k];
      block = sources[k].blocks->template part<n>(sources[k].block);
      if (sources[k].transposed) block.transposeInPlace();
      const int size = slots.size[i], width = slots.size[index(rows.column[k])];
      if (size < n) block.bottomRows(n - size).setZero();
      if (width < n) block.rightCols(n - width).setZero();
      if (rows.column[k] != static_cast<int>(i)) continue;
      for (int d = size; d < n; ++d) block(d, d) = 1.0;
    }
  }
  return rows;
}

template BlockRows<6> block_rows<6>(const BlockSystem&, const Slots&);
template BlockRows<12> block_rows<12>(const BlockSystem&, const Slots&);

}  // namespace quoin::solver
