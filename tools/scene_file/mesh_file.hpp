#pragma once
/// Block meshes from files of other programs.

#include <quoin/geometry/shape.hpp>
#include <span>
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
  std::string body{};  ///< solids that follow each other with the same one are parts of one block;
                       ///< empty: a block by itself
  double density = 0.0;   ///< kg/m3; 0: not stated
  double rounding = 0.0;  ///< of a coordinate as the file writes it, file units; 0: not known
  bool single = false;    ///< decimals of at most 8 digits: what wrote it computes in floats
};

/// What a mesh file says that can't be worked with: line or element, value, limit.
class MeshError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// compas: assemblies and models of COMPAS 1.x and 2.x, a mesh or a list of them (JSON).
/// obj, stl (ASCII and binary), ply (ASCII and binary of either endianness), off: surfaces; each
/// object of the file, or the whole of it, is divided into its closed surfaces, one block each.
/// dxf: 3DFACE entities, each layer an object. 3dec: blocks created one by one. lmgc90: POLYR of
/// BODIES.DAT, turned by the DOF.INI beside it. chrono: brick files of Chrono's masonry simulator.
/// rigid_ipc: fixtures, their meshes beside them or in folders `meshes` above.
enum class MeshFormat : std::uint8_t {
  Compas,
  Obj,
  Stl,
  Ply,
  Off,
  Dxf,
  ThreeDec,
  Lmgc90,
  Chrono,
  RigidIpc
};

/// By name ("compas", "obj", …), or by the ending of `path` where `name` is empty (.json: compas,
/// .dat: lmgc90 if it begins with BODIES, else 3dec, .3ddat and .3dec: 3dec). Throws
/// MeshError.
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
/// of 1e-6 of the diameter, 1e-4 where the digits are those of floats, and 4 times the rounding of
/// a coordinate. `taken`: where given, becomes the larger of itself and a depth beyond 1e-6 of the
/// diameter, m.
geometry::Shape convex_block(const MeshBlock& mesh, double tolerance, double* taken = nullptr);

/// What one block is made of: the meshes that follow `first` with the same `body`, or it alone.
std::span<const MeshBlock> meshes_of_block(std::span<const MeshBlock> meshes, std::size_t first);

/// Convex solids that together are what a closed mesh encloses, convex or not: its hull, parted by
/// the planes of those faces that run through it, less what lies outside. Cells on either side of a
/// plane have the same doubles on it; volumes sum to the mesh's within 1e-12 (of a file of few
/// digits, within the rounding of its places). Throws geometry::InputError for a mesh that is not
/// closed, or of which that is not true.
std::vector<geometry::Shape> convex_parts(const MeshBlock& mesh);

}  // namespace quoin::scene_file
