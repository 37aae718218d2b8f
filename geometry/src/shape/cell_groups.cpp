#include "shape/cell_groups.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "numeric/numbers.hpp"

namespace quoin::geometry {
CellSurface::CellSurface(int vertex_count, IndexRows cells) : cells_(std::move(cells)) {
  find_sides(vertex_count);
  find_neighbours();
}

void CellSurface::find_sides(int vertex_count) {
  to_.reserve(cells_.values.size());
  cell_of_.reserve(cells_.values.size());
  for (int c = 0; c < cell_count(); ++c) {
    const std::span<const int> cycle = cell(c);
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      to_.push_back(cycle[k + 1 < cycle.size() ? k + 1 : 0]);
      cell_of_.push_back(c);
    }
  }
  sides_from_ = rows_by(vertex_count, [&](const auto& put) {
    for (int side = 0; side < static_cast<int>(to_.size()); ++side)
      put(cells_.values[at(side)], side);
  });
}

/// The other way along a side is looked for among the sides from the end where fewer of them meet.
void CellSurface::find_neighbours() {
  neighbours_.assign(to_.size(), -1);
  for (int side = 0; side < static_cast<int>(to_.size()); ++side) {
    const int from = cells_.values[at(side)];
    const std::span<const int> back = sides_from(to_[at(side)]);
    if (back.size() > sides_from(from).size()) continue;
    for (const int other : back) {
      if (to_[at(other)] != from) continue;
      neighbours_[at(side)] = cell_of(other);
      neighbours_[at(other)] = cell_of(side);
    }
  }
}

bool LoopJoiner::append(std::span<const BorderSide> sides, std::vector<BorderSide>& loops) {
  bool simple = sides.size() >= 2;
  int start = std::numeric_limits<int>::max();
  for (std::size_t i = 0; i < sides.size(); ++i) {
    int& place = side_from_[at(sides[i].from)];
    simple = simple && place < 0;
    place = static_cast<int>(i);
    start = std::min(start, sides[i].from);
  }
  const bool closed = simple && append_from(start, sides, loops);
  for (const BorderSide& side : sides) side_from_[at(side.from)] = -1;
  return closed;
}

bool LoopJoiner::append_from(int start, std::span<const BorderSide> sides,
                             std::vector<BorderSide>& loops) {
  int v = start;
  for (std::size_t count = 1; count <= sides.size(); ++count) {
    const int side = side_from_[at(v)];
    if (side < 0) return false;
    loops.push_back(sides[at(side)]);
    v = loops.back().to;
    if (v == start) return count == sides.size();
  }
  return false;
}

CellGroups::CellGroups(int vertex_count, IndexRows cells)
    : surface_(vertex_count, std::move(cells)), joiner_(vertex_count), group_(at(size()), -1) {}

void CellGroups::rename(int from, int to) { std::replace(group_.begin(), group_.end(), from, to); }

bool CellGroups::find_loops() {
  fill_rows(
      size(), [&](const auto& put) { visit_sides(put); }, loop_start_, sides_);
  std::vector<char> used(group_.size(), 0);
  for (const int g : group_) used[at(g)] = 1;
  loops_.clear();
  loops_.reserve(sides_.size());
  for (int g = 0; g < size(); ++g) {
    const std::size_t start = at(loop_start_[at(g)]), end = at(loop_start_[at(g) + 1]);
    if (!used[at(g)]) continue;
    if (!joiner_.append(std::span(sides_).subspan(start, end - start), loops_)) return false;
  }
  return true;
}

/// Those between different groups.
template <typename Put>
void CellGroups::visit_sides(const Put& put) const {
  for (int cell = 0; cell < size(); ++cell) {
    const std::span<const int> cycle = surface_.cell(cell), across = surface_.neighbours(cell);
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const int beyond = group(across[k]);
      if (beyond == group(cell)) continue;
      put(group(cell), BorderSide{cycle[k], cycle[k + 1 < cycle.size() ? k + 1 : 0], beyond});
    }
  }
}

std::vector<int> CellGroups::visits() const {
  std::vector<int> count(at(surface_.vertex_count()), 0);
  for (const BorderSide& side : loops_) ++count[at(side.from)];
  return count;
}

}  // namespace quoin::geometry
