/// quoin import FILE, quoin split FILE

#include <map>
#include <quoin/geometry/mass_properties.hpp>

#include "commands.hpp"
#include "made_scene.hpp"
#include "path_to_write.hpp"
#include "scene_file/mesh_file.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

using Ordered = nlohmann::ordered_json;
using geometry::Shape;
using scene_file::MeshBlock;

struct ImportArguments {
  std::string file, format, units = "m", out;
  double density = 2400, friction_deg = 35;
};

/// A convex mesh as it is, another one in convex parts. `taken`: as of convex_block().
std::vector<Shape> solids(std::span<const MeshBlock> meshes, double& taken) {
  std::vector<Shape> parts;
  for (const MeshBlock& mesh : meshes) {
    try {
      parts.push_back(scene_file::convex_block(mesh, -1, &taken));
      continue;
    } catch (const geometry::InputError&) {  // not convex, or not closed
    }
    try {
      std::ranges::move(scene_file::convex_parts(mesh), std::back_inserter(parts));
    } catch (const geometry::InputError& error) {
      throw scene_file::SceneError("block \"" + mesh.id + "\"", error.what());
    }
  }
  return parts;
}

Ordered hull_of(const Shape& shape) {
  Ordered points = Ordered::array();
  for (int v = 0; v < shape.vertex_count(); ++v) {
    const Eigen::Vector3d place = shape.vertex(v);
    points.push_back({place.x(), place.y(), place.z()});
  }
  return {{"type", "hull"}, {"points", std::move(points)}};
}

scene_file::MeshFormat format_of(const ImportArguments& arguments) {
  try {
    return scene_file::mesh_format(arguments.file, arguments.format);
  } catch (const scene_file::MeshError& error) {
    throw std::invalid_argument(arguments.file + ": " + error.what());
  }
}

std::vector<MeshBlock> read_meshes(const ImportArguments& arguments,
                                   scene_file::MeshFormat format) {
  const double unit = scene_file::unit_length(arguments.units);
  if (!(unit > 0)) throw std::invalid_argument("--units: must be one of m, dm, cm, mm, in, ft");
  std::vector<MeshBlock> meshes;
  try {
    meshes = scene_file::read_mesh_file(arguments.file, format);
  } catch (const scene_file::MeshError& error) {
    throw std::invalid_argument(arguments.file + ": " + error.what());
  }
  for (MeshBlock& mesh : meshes) {
    mesh.vertices *= unit;
    mesh.rounding *= unit;
  }
  return meshes;
}

/// What is said of the blocks that were written.
struct Imported {
  std::size_t blocks = 0, compounds = 0, parts = 0, fixed = 0;
  double volume = 0;  ///< m3
  double taken = 0;   ///< of convex_block(), m
};

Ordered block_of(std::span<const MeshBlock> meshes, const ImportArguments& arguments,
                 std::map<double, std::string>& materials, Imported& told) {
  const MeshBlock& mesh = meshes.front();
  const std::vector<Shape> parts = solids(meshes, told.taken);
  const double density = mesh.density > 0 ? mesh.density : arguments.density;
  std::string& material = materials[density];
  if (material.empty()) material = "stone" + std::to_string(materials.size() - 1);
  const std::string& id = meshes.size() > 1 ? mesh.body : mesh.id;
  Ordered block = {{"name", mesh.name.empty() || mesh.name == id ? id : mesh.name + ":" + id},
                   {"kind", mesh.is_support ? "fixed" : "rigid"},
                   {"material", material}};
  if (parts.size() == 1) {
    block["shape"] = hull_of(parts.front());
  } else {
    for (const Shape& part : parts) block["parts"].push_back(hull_of(part));
    ++told.compounds;
    told.parts += parts.size();
  }
  ++told.blocks;
  told.fixed += mesh.is_support ? 1 : 0;
  for (const Shape& part : parts) told.volume += geometry::mass_properties(part).volume;
  return block;
}

int import_file(const ImportArguments& arguments) {
  using scene_file::MeshFormat;
  Imported told;
  std::map<double, std::string> materials;
  Ordered blocks = Ordered::array();
  const MeshFormat format = format_of(arguments);
  const std::vector<MeshBlock> meshes = read_meshes(arguments, format);
  for (std::size_t m = 0; m < meshes.size();) {
    const std::span<const MeshBlock> of_block = scene_file::meshes_of_block(meshes, m);
    blocks.push_back(block_of(of_block, arguments, materials, told));
    m += of_block.size();
  }
  Ordered head = {{"title", "Blocks of " + arguments.file}};
  if (format == MeshFormat::Chrono || format == MeshFormat::RigidIpc)
    head["gravity"] = {0, -9.81, 0};  // both have y up
  for (const auto& [density, name] : materials) head["materials"][name] = {{"density", density}};
  head["joint"] = {{"friction_angle_deg", arguments.friction_deg}};
  head["stages"] = Ordered::array({Ordered{{"analysis", "static"}}});
  save_text(arguments.out, scene_text(head, blocks));
  std::fprintf(stderr, "%zu blocks (%zu fixed; %zu of %zu convex parts), %.9g m3\n", told.blocks,
               told.fixed, told.compounds, told.parts, told.volume);
  if (told.taken > 0)
    std::fprintf(stderr, "taken for convex: up to %.3g m below the hull\n", told.taken);
  return kDone;
}

}  // namespace

void add_import_command(CLI::App& app, int& exit_code) {
  const auto [command, words] = add_command<ImportArguments>(
      app, exit_code, import_file, "import",
      "Write a scene from a file of another program (DXF 3DFACE, 3DEC, LMGC90 BODIES.DAT, Chrono "
      "brick file, rigid-ipc, COMPAS, OBJ, STL, PLY, OFF); solids that are not convex are split "
      "exactly at the planes of their inner faces into parts of one block");
  command.alias("split");
  command.add_option("file", words.file, "the file")->required();
  command.add_option("--format", words.format,
                     "compas, obj, stl, ply, off, dxf, 3dec, lmgc90, chrono, rigid_ipc; default: "
                     "by its ending");
  command.add_option("--units", words.units, "of its lengths: m, dm, cm, mm, in, ft");
  command.add_option("--density", words.density, "kg/m3, where the file states none")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command.add_option("--friction", words.friction_deg, "friction angle, degrees")
      ->check(CLI::Range(0.0, 89.0))
      ->capture_default_str();
  add_path(command, "--out", words.out, "FILE.json (default: standard output)");
}

}  // namespace quoin::commands
