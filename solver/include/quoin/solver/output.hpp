#pragma once
/// VTK files of a state, as ParaView opens them. Each file is written beside its name and renamed.

#include <quoin/solver/simulation.hpp>
#include <string>

namespace quoin::solver {

/// Blocks as an unstructured grid of polyhedra (.vtu): block id, displacement, velocity, stress.
/// Throws std::runtime_error naming the file when it can't be written.
void write_blocks(const std::string& path, const Simulation& simulation);

/// Contact points (.vtp): type, gap, normal, forces, state, area.
void write_contacts(const std::string& path, const Simulation& simulation);

/// Time series index (.pvd) over files written at the given times (s).
void write_series(const std::string& path, const std::vector<double>& times,
                  const std::vector<std::string>& files);

}  // namespace quoin::solver
