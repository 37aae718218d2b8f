#pragma once
/// VTK files of a state, as ParaView opens them, numbers appended in binary. Each file is written
/// beside its name and renamed.

#include <quoin/solver/simulation.hpp>
#include <span>
#include <string>

namespace quoin::solver {

/// Blocks as an unstructured grid of polyhedra (.vtu): id, name, kind, material, displacement,
/// velocity, stress (xx yy zz xy yz xz) and principal stresses, Pa. Absent blocks are hidden cells
/// (vtkGhostType). Displacements count from the places `from`, by block; none: from the start of
/// the run. Throws std::runtime_error naming the file when it can't be written.
void write_blocks(const std::string& path, const Simulation& simulation,
                  std::span<const BlockState> from = {});

/// Contact points (.vtp): blocks, type, gap, normal, forces, state, slip, area.
void write_contacts(const std::string& path, const Simulation& simulation);

/// Time series index (.pvd) over files written at the given times (s).
void write_series(const std::string& path, const std::vector<double>& times,
                  const std::vector<std::string>& files);

}  // namespace quoin::solver
