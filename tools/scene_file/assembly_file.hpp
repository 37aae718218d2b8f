#pragma once
/// Block meshes from files of other programs.

#include <quoin/geometry/polyhedron.hpp>
#include <string>
#include <vector>

namespace quoin::scene_file {

struct MeshBlock {
  std::string id;                       ///< node or element key of the file, name of the object
  geometry::Points vertices;            ///< 3 × n, file units
  std::vector<std::vector<int>> faces;  ///< columns of `vertices`
  bool is_support = false;
};

/// COMPAS assembly or model: meshes under data/graph/data/node/*/block/data, blocks/* or
/// data/elements/*/data/geometry/data. Throws FileError, and SceneError with a pointer into the
/// file.
std::vector<MeshBlock> read_compas(const std::string& path);

/// Wavefront OBJ: one block for each `o` or `g`; no support flags. Throws FileError.
std::vector<MeshBlock> read_obj(const std::string& path);

/// The convex hull of the mesh. Throws geometry::InputError when the surface of the mesh lies
/// deeper than `tolerance` (m) below that hull, or does not enclose it. `tolerance` < 0: 1e-6 of
/// the diameter.
geometry::Polyhedron convex_block(const MeshBlock& mesh, double tolerance);

}  // namespace quoin::scene_file
