#pragma once
/// Convex cells by cutting, as blocks of rock are cut by joints and Voronoi cells by bisectors: in
/// plain doubles, with all the near coincidences that this leaves.

#include <quoin/geometry/types.hpp>
#include <vector>

#include "referee/pairs/random.hpp"

namespace quoin::referee {

struct Cell {
  std::vector<geometry::Vector3> vertices;
  std::vector<std::vector<int>> faces;  ///< counter-clockwise from outside

  geometry::Points points() const;
};

Cell box_cell(const geometry::Vector3& min, const geometry::Vector3& max);

/// The part where n·x <= d; a vertex within `snap` (m) of the plane is on it. Empty when nothing or
/// nothing of any thickness is left. The other part (-n, -d) gets the same doubles on the cut.
Cell cut(Cell cell, const geometry::Vector3& n, double d, double snap);

/// A cell of a cubic lattice of seeds, each moved by up to `jitter` along each axis (lattice length
/// 1 m), and the cell of one of its neighbours: across a face, an edge or a corner.
std::array<Cell, 2> voronoi_cells(double jitter, double snap, Random& random);

/// Cells of two of 24 random seeds in a box, as near to each other as two of them are.
std::array<Cell, 2> random_voronoi_cells(double snap, Random& random);

}  // namespace quoin::referee
