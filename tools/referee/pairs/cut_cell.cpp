#include "referee/pairs/cut_cell.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace quoin::referee {
namespace {

using geometry::Points;
using geometry::Vector3;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Makes the vertices of a part: old ones that stay and new ones where an edge crosses the plane.
class Cutter {
 public:
  Cutter(const Cell& cell, const Vector3& n, double d, double snap) : cell_(cell) {
    for (const Vector3& x : cell.vertices) {
      const double side = n.dot(x) - d;
      sides_.push_back(std::abs(side) <= snap ? 0.0 : side);
    }
  }
  bool keeps_all() const {
    return std::all_of(sides_.begin(), sides_.end(), [](double side) { return side <= 0; });
  }
  bool keeps_some() const {
    return std::any_of(sides_.begin(), sides_.end(), [](double side) { return side < 0; });
  }
  std::vector<int> part_of(const std::vector<int>& face) {
    std::vector<int> loop;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const int p = face[i], q = face[(i + 1) % face.size()];
      if (sides_[at(p)] <= 0) loop.push_back(stays(p));
      if ((sides_[at(p)] < 0 && sides_[at(q)] > 0) || (sides_[at(p)] > 0 && sides_[at(q)] < 0))
        loop.push_back(crossing(std::min(p, q), std::max(p, q)));
    }
    return loop;
  }
  Cell part;
  std::vector<int> on_plane;

 private:
  int add(const std::pair<int, int>& key, const Vector3& x, bool on) {
    const auto [entry, fresh] = numbers_.try_emplace(key, static_cast<int>(part.vertices.size()));
    if (fresh) {
      part.vertices.push_back(x);
      if (on) on_plane.push_back(entry->second);
    }
    return entry->second;
  }
  int stays(int p) { return add({p, p}, cell_.vertices[at(p)], sides_[at(p)] == 0); }
  int crossing(int p, int q) {
    const double t = sides_[at(p)] / (sides_[at(p)] - sides_[at(q)]);
    const Vector3 &x = cell_.vertices[at(p)], &y = cell_.vertices[at(q)];
    return add({p, q}, x + t * (y - x), true);
  }

  const Cell& cell_;
  std::vector<double> sides_;
  std::map<std::pair<int, int>, int> numbers_;
};

/// The vertices on the plane in the order of their angle about n.
std::vector<int> cap_of(const Cell& part, const std::vector<int>& loop, const Vector3& n) {
  Vector3 middle = Vector3::Zero();
  for (int v : loop) middle += part.vertices[at(v)] / static_cast<double>(loop.size());
  const Vector3 u = n.unitOrthogonal(), w = n.cross(u);
  std::vector<std::pair<double, int>> angles;
  for (const int v : loop) {
    const Vector3 step = part.vertices[at(v)] - middle;
    angles.emplace_back(std::atan2(w.dot(step), u.dot(step)), v);
  }
  std::sort(angles.begin(), angles.end(),
            [](const auto& p, const auto& q) { return p.first < q.first; });
  std::vector<int> sorted;
  for (const auto& [angle, v] : angles) sorted.push_back(v);
  return sorted;
}

Cell voronoi_cell(const std::vector<Vector3>& seeds, int seed, const Cell& around, double snap) {
  Cell cell = around;
  const Vector3& s = seeds[at(seed)];
  for (const Vector3& other : seeds) {
    if (other != s) {
      const Vector3 n = (other - s).normalized();
      cell = cut(std::move(cell), n, n.dot(0.5 * (other + s)), snap);
    }
  }
  return cell;
}

}  // namespace

Points Cell::points() const {
  Points list(3, static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t v = 0; v < vertices.size(); ++v)
    list.col(static_cast<Eigen::Index>(v)) = vertices[v];
  return list;
}

Cell box_cell(const Vector3& min, const Vector3& max) {
  Cell cell;
  for (int v = 0; v < 8; ++v) {
    cell.vertices.emplace_back((v & 1) != 0 ? max.x() : min.x(), (v & 2) != 0 ? max.y() : min.y(),
                               (v & 4) != 0 ? max.z() : min.z());
  }
  cell.faces = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  return cell;
}

Cell cut(Cell cell, const Vector3& n, double d, double snap) {
  Cutter cutter(cell, n, d, snap);
  if (cutter.keeps_all()) return cell;
  if (!cutter.keeps_some()) return {};
  for (const std::vector<int>& face : cell.faces) {
    std::vector<int> loop = cutter.part_of(face);
    if (loop.size() >= 3) cutter.part.faces.push_back(std::move(loop));
  }
  if (cutter.on_plane.size() >= 3)
    cutter.part.faces.push_back(cap_of(cutter.part, cutter.on_plane, n));
  return cutter.part;
}

std::array<Cell, 2> voronoi_cells(double jitter, double snap, Random& random) {
  std::vector<Vector3> seeds;
  for (int k = 0; k < 64; ++k)
    seeds.push_back(Vector3(k % 4, k / 4 % 4, k / 16) + jitter * random.point(-1, 1));
  const int steps[] = {1, 4, 16, 5, 20, 21};
  const int seed = 1 + 4 + 16;
  const Cell around = box_cell(Vector3::Constant(-1), Vector3::Constant(4));
  return {voronoi_cell(seeds, seed, around, snap),
          voronoi_cell(seeds, seed + steps[random.integer(0, 5)], around, snap)};
}

std::array<Cell, 2> random_voronoi_cells(double snap, Random& random) {
  std::vector<Vector3> seeds;
  for (int k = 0; k < 24; ++k) seeds.push_back(random.point(0, 1));
  int nearest = 1;
  for (int k = 2; k < 24; ++k) {
    const auto apart = [&](int m) { return (seeds[at(m)] - seeds[0]).norm(); };
    nearest = apart(k) < apart(nearest) ? k : nearest;
  }
  const Cell around = box_cell(Vector3::Zero(), Vector3::Ones());
  return {voronoi_cell(seeds, 0, around, snap), voronoi_cell(seeds, nearest, around, snap)};
}

}  // namespace quoin::referee
