#include "scene_file/mesh_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Half a unit of the last digit that the largest coordinate has. Fewer digits than files of
/// programs have are exact numbers, more are doubles.
double rounding_of(const Surface& surface) {
  constexpr int kFewest = 5, kMost = 12;
  double largest = 0.0;
  for (const std::array<double, 3>& place : surface.places)
    for (const double x : place) largest = std::max(largest, std::abs(x));
  if (surface.digits < kFewest || surface.digits > kMost || !(largest > 0.0)) return 0.0;
  return 0.5 * std::pow(10.0, std::floor(std::log10(largest)) + 1 - surface.digits);
}

/// The text of DOF.INI beside a file, empty if there is none.
std::string text_of_dof(const std::string& path) {
  const std::filesystem::path dof = std::filesystem::path(path).parent_path() / "DOF.INI";
  std::error_code none;
  return std::filesystem::exists(dof, none) ? read_text(dof.string()) : std::string();
}

std::vector<MeshBlock> blocks_of_text(std::string_view text, MeshFormat format,
                                      const std::string& path) {
  if (format == MeshFormat::Compas) return read_compas(text);
  if (format == MeshFormat::ThreeDec) return read_3dec(text);
  if (format == MeshFormat::Lmgc90) return read_lmgc90(text, text_of_dof(path));
  if (format == MeshFormat::Chrono) return read_chrono(text);
  if (format == MeshFormat::RigidIpc) return read_rigid_ipc(text, path);
  const Surface surface = format == MeshFormat::Obj   ? read_obj(text)
                          : format == MeshFormat::Stl ? read_stl(text)
                          : format == MeshFormat::Ply ? read_ply(text)
                          : format == MeshFormat::Dxf ? read_dxf(text)
                                                      : read_off(text);
  if (surface.face_ends.empty()) throw MeshError("holds no faces");
  std::vector<MeshBlock> blocks = blocks_of(surface);
  constexpr int kFloat = 8;  // digits; 9 tell a float from the next one
  for (MeshBlock& block : blocks) {
    block.rounding = rounding_of(surface);
    block.single = block.rounding > 0.0 && surface.digits <= kFloat;
  }
  return blocks;
}

}  // namespace

MeshFormat mesh_format(const std::string& path, const std::string& name) {
  std::string ending = name;
  if (name.empty()) {
    ending = std::filesystem::path(path).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    ending = ending == ".json" ? "compas" : ending.substr(std::min<std::size_t>(1, ending.size()));
    if (ending == "3ddat") ending = "3dec";
    if (ending == "dat") {
      ending =
          std::filesystem::path(path).stem().string().starts_with("BODIES") ? "lmgc90" : "3dec";
    }
  }
  static constexpr std::pair<const char*, MeshFormat> kFormats[] = {
      {"compas", MeshFormat::Compas}, {"obj", MeshFormat::Obj},
      {"stl", MeshFormat::Stl},       {"ply", MeshFormat::Ply},
      {"off", MeshFormat::Off},       {"dxf", MeshFormat::Dxf},
      {"3dec", MeshFormat::ThreeDec}, {"lmgc90", MeshFormat::Lmgc90},
      {"chrono", MeshFormat::Chrono}, {"rigid_ipc", MeshFormat::RigidIpc}};
  for (const auto& [known, format] : kFormats)
    if (ending == known) return format;
  throw MeshError(
      "its ending tells no format: state one of compas, obj, stl, ply, off, dxf, "
      "3dec, lmgc90, chrono, rigid_ipc");
}

std::vector<MeshBlock> read_mesh_file(const std::string& path, MeshFormat format) {
  const std::string text = read_text(path);
  const std::size_t mark = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  std::vector<MeshBlock> blocks = blocks_of_text(std::string_view(text).substr(mark), format, path);
  for (const MeshBlock& block : blocks) {
    if (block.faces.empty()) {
      throw MeshError("block " + in_quotes(block.id) +
                      ": none of its faces has 3 corners at different places");
    }
  }
  return blocks;
}

std::span<const MeshBlock> meshes_of_block(std::span<const MeshBlock> meshes, std::size_t first) {
  const std::string& body = meshes[first].body;
  std::size_t end = first + 1;
  while (!body.empty() && end < meshes.size() && meshes[end].body == body) ++end;
  return meshes.subspan(first, end - first);
}

double unit_length(const std::string& name) {
  static constexpr std::pair<const char*, double> kUnits[] = {
      {"m", 1.0}, {"dm", 0.1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  for (const auto& [unit, length] : kUnits)
    if (name == unit) return length;
  return 0.0;
}

void mark_lowest_course(std::vector<MeshBlock>& meshes) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const MeshBlock& mesh : meshes) {
    lowest = std::min(lowest, mesh.vertices.row(2).minCoeff());
    highest = std::max(highest, mesh.vertices.row(2).maxCoeff());
  }
  for (MeshBlock& mesh : meshes)
    mesh.is_support = mesh.vertices.row(2).minCoeff() <= lowest + 1e-3 * (highest - lowest);
}

}  // namespace quoin::scene_file
