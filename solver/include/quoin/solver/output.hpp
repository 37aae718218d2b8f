#pragma once
/// VTK files of a state, as ParaView opens them, numbers appended in binary. Each file is written
/// beside its name and renamed.

#include <quoin/solver/simulation.hpp>
#include <span>
#include <string>

namespace quoin::solver {

/// What one of several processes writes of a state: the blocks of one part, and the contacts whose
/// first block that can move is one of them.
struct Piece {
  std::span<const int> part_of_block{};  ///< by block; empty: all of them are written
  int part = 0;
};

/// Blocks as an unstructured grid of polyhedra (.vtu): id, name, kind, material, displacement,
/// velocity, stress (xx yy zz xy yz xz) and principal stresses, Pa. Absent blocks are hidden cells
/// (vtkGhostType). Displacements count from the places `from`, by block; none: from the start of
/// the run. Throws std::runtime_error naming the file when it can't be written, and InputError
/// where a list by block is not as long as there are blocks.
void write_blocks(const std::string& path, const Simulation& simulation,
                  std::span<const BlockState> from = {}, const Piece& piece = {});

/// Whether the joint of a contact has a strength to lose, and bears its residual values there.
bool has_failed(const Scene& scene, const Contact& contact);

/// Contact points (.vtp): blocks, type, gap, normal, forces, state, slip, area.
void write_contacts(const std::string& path, const Simulation& simulation, const Piece& piece = {});

/// Ties as lines (.vtp): force (N, tension positive), elongation against the rest length (m),
/// plastic part of it, broken. Throws std::runtime_error as above.
void write_ties(const std::string& path, const Simulation& simulation);

/// Index (.pvtu of blocks, .pvtp of contacts) over pieces in the same folder, at least one, or an
/// InputError is thrown. The
/// first is read for the names of its arrays; the others may come later.
void write_index(const std::string& path, const std::vector<std::string>& pieces);

/// Time series index (.pvd) over files written at the given times (s). Throws InputError when there
/// are not as many times as files.
void write_series(const std::string& path, const std::vector<double>& times,
                  const std::vector<std::string>& files);

}  // namespace quoin::solver
