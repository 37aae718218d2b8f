#pragma once
/// The cells of a closed surface, gathered into groups, and the borders of these. Internal.

#include <span>
#include <vector>

#include "shape/rows.hpp"

namespace quoin::geometry {

/// A closed surface of polygons, the cells: each side is a side of just one other cell, run through
/// the other way.
class CellSurface {
 public:
  CellSurface(int vertex_count, IndexRows cells);

  int vertex_count() const { return sides_from_.size(); }
  int cell_count() const { return cells_.size(); }
  const IndexRows& cells() const { return cells_; }
  std::span<const int> cell(int c) const { return cells_[c]; }
  /// Across the side from each vertex to the next.
  std::span<const int> neighbours(int c) const {
    const int* const start = cells_.start.data() + c;
    return {neighbours_.data() + start[0], neighbours_.data() + start[1]};
  }
  /// A side from v in each cell around it, by cells ascending; the cell of a side.
  std::span<const int> sides_from(int v) const { return sides_from_[v]; }
  int cell_of(int side) const { return cell_of_[static_cast<std::size_t>(side)]; }

 private:
  void find_sides(int vertex_count);
  void find_neighbours();

  // Sides are numbered as the vertices that they start from.
  IndexRows cells_, sides_from_;
  std::vector<int> to_, cell_of_, neighbours_;  // by side
};

/// A side of a border, run along in its direction, and the group beyond it.
struct BorderSide {
  int from = 0, to = 0, beyond = 0;
};

/// A border: sides in order, each from where the one before ends.
using Loop = std::span<const BorderSide>;

/// Brings sides in order.
class LoopJoiner {
 public:
  explicit LoopJoiner(int vertex_count) : side_from_(static_cast<std::size_t>(vertex_count), -1) {}

  /// Appends the closed loop through all sides, from its least vertex on; false: there is none
  /// (holes, or a border that touches itself).
  bool append(std::span<const BorderSide> sides, std::vector<BorderSide>& loops);

 private:
  bool append_from(int start, std::span<const BorderSide> sides, std::vector<BorderSide>& loops);

  std::vector<int> side_from_;  // by vertex; -1: none
};

/// The cells of a surface in groups, which have the numbers of cells as names.
class CellGroups {
 public:
  CellGroups(int vertex_count, IndexRows cells);

  const CellSurface& surface() const { return surface_; }
  int size() const { return surface_.cell_count(); }
  int group(int cell) const { return group_[static_cast<std::size_t>(cell)]; }  ///< -1: none yet
  void put(int cell, int group) { group_[static_cast<std::size_t>(cell)] = group; }
  void rename(int from, int to);
  LoopJoiner& joiner() { return joiner_; }

  /// The border of every group; false where one is no single simple loop.
  bool find_loops();
  /// Empty: there is no such group.
  Loop loop(int group) const {
    const int* const start = loop_start_.data() + group;
    return {loops_.data() + start[0], loops_.data() + start[1]};
  }
  /// How many loops pass through each vertex.
  std::vector<int> visits() const;

 private:
  template <typename Put>
  void visit_sides(const Put& put) const;

  CellSurface surface_;
  LoopJoiner joiner_;
  std::vector<int> group_;
  std::vector<int> loop_start_;            // by group
  std::vector<BorderSide> sides_, loops_;  // between groups, of one after another; in order
};

}  // namespace quoin::geometry
