#pragma once
/// The graphs of a multigrid hierarchy on a wall in parts: what a part reads of others on each
/// level.

#include <compare>
#include <vector>

namespace quoin::bench {

/// Of each row the columns that it reads, ascending.
struct Graph {
  std::vector<int> start{0}, column{};
  int rows() const { return static_cast<int>(start.size()) - 1; }
  const int* begin(int row) const { return column.data() + start[static_cast<std::size_t>(row)]; }
  const int* end(int row) const { return column.data() + start[static_cast<std::size_t>(row) + 1]; }
};

struct Level {
  Graph matrix;              ///< blocks of the matrix by row, its own among them
  std::vector<int> part_of;  ///< by row: whose it is
  Graph prolongation;  ///< by row: the coarse rows that it takes from; empty on the last level
};

/// Which bricks of the wall of `wall_scene()` touch, and each brick itself, without the base.
Graph wall_graph(int columns, int rows);

/// The wall bisected by place, and coarser levels as smoothed aggregation [Vanek, Mandel & Brezina
/// 1996] has them: groups of rows of one part, on the first level groups of groups, as PETSc's GAMG
/// makes them. A level of fewer than 50 unknowns a part is on fewer parts; the last one has no more
/// than 50 and is on one.
std::vector<Level> wall_levels(int columns, int rows, int parts);

/// A row that a part reads of another.
struct Ghost {
  int owner = 0, reader = 0, row = 0;
  auto operator<=>(const Ghost&) const = default;
};

/// Ascending. By row and by column of `reads`: whose it is.
std::vector<Ghost> ghosts_of(const Graph& reads, const std::vector<int>& part_of_row,
                             const std::vector<int>& part_of_column);

}  // namespace quoin::bench
