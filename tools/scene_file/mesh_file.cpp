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
  for (const std::array<double, 3>& place : surface.places) {
    for (const double x : place) largest = std::max(largest, std::abs(x));
  }
  if (surface.digits < kFewest || surface.digits > kMost || !(largest > 0.0)) return 0.0;
  return 0.5 * std::pow(10.0, std::floor(std::log10(largest)) + 1 - surface.digits);
}

std::vector<MeshBlock> blocks_of_text(std::string_view text, MeshFormat format) {
  if (format == MeshFormat::Compas) {
    return read_compas(text);
  }
  const Surface surface = format == MeshFormat::Obj   ? read_obj(text)
                          : format == MeshFormat::Stl ? read_stl(text)
                          : format == MeshFormat::Ply ? read_ply(text)
                                                      : read_off(text);
  if (surface.face_ends.empty()) {
    throw MeshError("holds no faces");
  }
  std::vector<MeshBlock> blocks = blocks_of(surface);
  for (MeshBlock& block : blocks) block.rounding = rounding_of(surface);
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
  }
  static constexpr std::pair<const char*, MeshFormat> kFormats[] = {{"compas", MeshFormat::Compas},
                                                                    {"obj", MeshFormat::Obj},
                                                                    {"stl", MeshFormat::Stl},
                                                                    {"ply", MeshFormat::Ply},
                                                                    {"off", MeshFormat::Off}};
  for (const auto& [known, format] : kFormats) {
    if (ending == known) {
      return format;
    }
  }
  throw MeshError("its ending tells no format: state one of compas, obj, stl, ply, off");
}

std::vector<MeshBlock> read_mesh_file(const std::string& path, MeshFormat format) {
  const std::string text = read_text(path);
  const std::size_t mark = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  std::vector<MeshBlock> blocks = blocks_of_text(std::string_view(text).substr(mark), format);
  for (const MeshBlock& block : blocks) {
    if (block.faces.empty()) {
      throw MeshError("block " + in_quotes(block.id) +
                      ": none of its faces has 3 corners at different places");
    }
  }
  return blocks;
}

double unit_length(const std::string& name) {
  static constexpr std::pair<const char*, double> kUnits[] = {
      {"m", 1.0}, {"dm", 0.1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  for (const auto& [unit, length] : kUnits) {
    if (name == unit) {
      return length;
    }
  }
  return 0.0;
}

void mark_lowest_course(std::vector<MeshBlock>& meshes) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const MeshBlock& mesh : meshes) {
    lowest = std::min(lowest, mesh.vertices.row(2).minCoeff());
    highest = std::max(highest, mesh.vertices.row(2).maxCoeff());
  }
  for (MeshBlock& mesh : meshes) {
    mesh.is_support = mesh.vertices.row(2).minCoeff() <= lowest + 1e-3 * (highest - lowest);
  }
}

}  // namespace quoin::scene_file
