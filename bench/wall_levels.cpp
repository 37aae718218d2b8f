#include "wall_levels.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <quoin/solver/parts.hpp>
#include <random>
#include <utility>

namespace quoin::bench {
namespace {

constexpr int kUnknowns = 6;      // of a row on every level: GAMG keeps six rigid motions
constexpr int kLeastOfPart = 50;  // unknowns: -pc_gamg_process_eq_limit
constexpr int kMostOfLast = 50;   // -pc_gamg_coarse_eq_limit

using geometry::Vector3;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// Of odd courses the bricks at both ends are halves.
int bricks_of_course(int columns, int course) { return columns + course % 2; }

int first_of_course(int columns, int course) { return course * columns + course / 2; }

std::vector<Vector3> centroids(int columns, int rows) {
  std::vector<Vector3> places;
  for (int course = 0; course < rows; ++course) {
    for (int i = 0; i < bricks_of_course(columns, course); ++i) {
      const double from = course % 2 == 0 ? i : std::max(0.0, i - 0.5);
      const double to = course % 2 == 0 ? i + 1.0 : std::min<double>(columns, i + 0.5);
      places.emplace_back(0.2 * (from + to), 0.1, 0.2 * (course + 0.5));
    }
  }
  return places;
}

void end_row(Graph& graph) {
  std::sort(graph.column.begin() + graph.start.back(), graph.column.end());
  graph.start.push_back(static_cast<int>(graph.column.size()));
}

/// Marks that are taken off all at once.
class Seen {
 public:
  explicit Seen(int count) : last_(index(count), -1) {}
  void clear() { ++round_; }
  bool first(int i) { return std::exchange(last_[index(i)], round_) != round_; }

 private:
  std::vector<int> last_;
  int round_ = 0;
};

/// The numbers below `count`, shuffled.
std::vector<int> shuffled(int count) {
  std::vector<int> order(index(count));
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(1);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  return order;
}

/// By row: its group. A row that is in none makes one, of all rows of its part that it is coupled
/// with and that are in none. Rows come by chance.
std::vector<int> groups(const Graph& matrix, const std::vector<int>& part_of) {
  std::vector<int> group(part_of.size(), -1);
  int next = 0;
  for (const int row : shuffled(matrix.rows())) {
    if (group[index(row)] >= 0) continue;
    for (const int* c = matrix.begin(row); c != matrix.end(row); ++c) {
      const bool free = group[index(*c)] < 0 && part_of[index(*c)] == part_of[index(row)];
      if (free) group[index(*c)] = next;
    }
    ++next;
  }
  return group;
}

/// By group: the part of its rows.
std::vector<int> parts_of_groups(const std::vector<int>& group, const std::vector<int>& part_of) {
  std::vector<int> parts(index(1 + *std::ranges::max_element(group)));
  for (std::size_t row = 0; row < group.size(); ++row) parts[index(group[row])] = part_of[row];
  return parts;
}

/// Each row takes from the groups of all that it is coupled with: one smoothing step.
Graph prolongation(const Graph& matrix, const std::vector<int>& group) {
  Graph result;
  for (int row = 0; row < matrix.rows(); ++row) {
    const auto from = static_cast<std::ptrdiff_t>(result.column.size());
    for (const int* c = matrix.begin(row); c != matrix.end(row); ++c) {
      const int next = group[index(*c)];
      if (std::find(result.column.begin() + from, result.column.end(), next) == result.column.end())
        result.column.push_back(next);
    }
    end_row(result);
  }
  return result;
}

Graph transposed(const Graph& graph, int columns) {
  Graph result;
  result.start.assign(index(columns) + 1, 0);
  for (const int c : graph.column) ++result.start[index(c) + 1];
  for (int c = 0; c < columns; ++c) result.start[index(c) + 1] += result.start[index(c)];
  result.column.resize(graph.column.size());
  std::vector<int> next(result.start.begin(), result.start.end() - 1);
  for (int row = 0; row < graph.rows(); ++row) {
    for (const int* c = graph.begin(row); c != graph.end(row); ++c)
      result.column[index(next[index(*c)]++)] = row;
  }
  return result;
}

/// Couplings of the coarse rows: the graph of Pᵀ A P.
Graph coarse_graph(const Graph& matrix, const Graph& prolongation, int count) {
  const Graph restriction = transposed(prolongation, count);
  Graph result;
  Seen rows(matrix.rows()), found(count);
  for (int coarse = 0; coarse < count; ++coarse) {
    rows.clear();
    found.clear();
    for (const int* i = restriction.begin(coarse); i != restriction.end(coarse); ++i) {
      for (const int* j = matrix.begin(*i); j != matrix.end(*i); ++j) {
        if (!rows.first(*j)) continue;
        for (const int* k = prolongation.begin(*j); k != prolongation.end(*j); ++k) {
          if (found.first(*k)) result.column.push_back(*k);
        }
      }
    }
    end_row(result);
  }
  return result;
}

/// Parts next to each other by number become one where there are too few unknowns for all.
void join_parts(std::vector<int>& part_of, int parts) {
  const int unknowns = kUnknowns * static_cast<int>(part_of.size());
  const int active =
      unknowns <= kMostOfLast ? 1 : std::clamp((unknowns + 25) / kLeastOfPart, 1, parts);
  const auto group = [&](int part) { return static_cast<long>(part) * active / parts; };
  std::vector<int> first(index(active), parts);
  for (int part = parts; part-- > 0;) first[static_cast<std::size_t>(group(part))] = part;
  for (int& part : part_of) part = first[static_cast<std::size_t>(group(part))];
}

/// Groups of the groups: what is left of the couplings is between groups.
std::vector<int> groups_of_groups(const Level& level) {
  std::vector<int> group = groups(level.matrix, level.part_of);
  Graph single;
  for (const int g : group) {
    single.column.push_back(g);
    end_row(single);
  }
  const std::vector<int> parts = parts_of_groups(group, level.part_of);
  const int count = static_cast<int>(parts.size());
  const std::vector<int> second = groups(coarse_graph(level.matrix, single, count), parts);
  for (int& g : group) g = second[index(g)];
  return group;
}

Level coarser(Level& fine, bool first, int parts) {
  const std::vector<int> group = first ? groups_of_groups(fine) : groups(fine.matrix, fine.part_of);
  fine.prolongation = prolongation(fine.matrix, group);
  Level coarse;
  coarse.part_of = parts_of_groups(group, fine.part_of);
  coarse.matrix =
      coarse_graph(fine.matrix, fine.prolongation, static_cast<int>(coarse.part_of.size()));
  join_parts(coarse.part_of, parts);
  return coarse;
}

}  // namespace

Graph wall_graph(int columns, int rows) {
  Graph graph;
  for (int course = 0; course < rows; ++course) {
    for (int i = 0; i < bricks_of_course(columns, course); ++i) {
      const int left = course % 2 == 0 ? i : i - 1;  // of those above and below
      for (int other = std::max(0, course - 1); other < std::min(rows, course + 2); ++other) {
        const int from = other == course ? i - 1 : left, to = other == course ? i + 1 : left + 1;
        for (int k = std::max(0, from); k <= to && k < bricks_of_course(columns, other); ++k)
          graph.column.push_back(first_of_course(columns, other) + k);
      }
      end_row(graph);
    }
  }
  return graph;
}

std::vector<Level> wall_levels(int columns, int rows, int parts) {
  std::vector<Level> levels(1);
  levels[0].matrix = wall_graph(columns, rows);
  const std::vector<Vector3> places = centroids(columns, rows);
  levels[0].part_of = solver::bisect(places, std::vector<double>(places.size(), 1.0), parts);
  while (kUnknowns * levels.back().matrix.rows() > kMostOfLast) {
    Level next = coarser(levels.back(), levels.size() == 1, parts);
    if (next.matrix.rows() == levels.back().matrix.rows()) break;
    levels.push_back(std::move(next));
  }
  return levels;
}

std::vector<Ghost> ghosts_of(const Graph& reads, const std::vector<int>& part_of_row,
                             const std::vector<int>& part_of_column) {
  std::vector<Ghost> ghosts;
  for (int row = 0; row < reads.rows(); ++row) {
    for (const int* c = reads.begin(row); c != reads.end(row); ++c) {
      const int owner = part_of_column[index(*c)], reader = part_of_row[index(row)];
      if (owner != reader) ghosts.push_back({owner, reader, *c});
    }
  }
  std::ranges::sort(ghosts);
  const auto rest = std::ranges::unique(ghosts);
  ghosts.erase(rest.begin(), rest.end());
  return ghosts;
}

}  // namespace quoin::bench
