#pragma once
/// Block meshes from files of other programs.

#include <quoin/geometry/shape.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace quoin::scene_file {

struct MeshBlock {
  std::string id{};                       ///< node or element key, name of the object; unique
  std::string name{};                     ///< the name that the file gives beside the id, or empty
  geometry::Points vertices{};            ///< 3 × n, file units; places all different
  std::vector<std::vector<int>> faces{};  ///< columns of `vertices`, either orientation
  bool is_support = false;
  double rounding = 0.0;  ///< of a coordinate as the file writes it, file units; 0: not known
};

/// What a mesh file says that can't be worked with: line or element, value, limit.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// compas: assemblies and models of COMPAS 1.x and 2.x, a mesh or a list of them (JSON).
/// obj, stl (ASCII and binary), ply (ASCII and binary of either endianness), off: surfaces; each
/// object of the file, or the whole of it, is divided into its closed surfaces, one block each.
enum class MeshFormat : std::uint8_t { Compas, Obj, Stl, Ply, Off };

/// By name ("compas", "obj", …), or by the ending of `path` where `name` is empty (.json: compas).
/// Throws MeshError.
MeshFormat mesh_format(const std::string& path, const std::string& name);

/// Every block of the file; ids in the order of the file, numbers ascending. Throws FileError when
/// it can't be read, MeshError for what it says.
std::vector<MeshBlock> read_mesh_file(const std::string& path, MeshFormat format);

/// Length in m of a unit by name: m, dm, cm, mm, in, ft; 0 for any other.
double unit_length(const std::string& name);

/// Flags the blocks whose underside is lowest, within 1e-3 of the height of all.
void mark_lowest_course(std::vector<MeshBlock>& meshes);

/// The convex hull of the mesh. Throws geometry::InputError when the surface of the mesh lies
/// deeper than `tolerance` (m) below that hull, or does not enclose it. `tolerance` < 0: the larger
/// of 1e-6 of the diameter and 4 times the rounding of a coordinate.
geometry::Shape convex_block(const MeshBlock& mesh, double tolerance);

}  // namespace quoin::scene_file
