/// quoin info FILE

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/nearest_features.hpp>

#include "commands.hpp"
#include "scene_file/mesh_file.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using scene_file::MeshBlock;

struct InfoArguments {
  std::string file;
  std::string format;
  std::string units = "m";
  std::string supports = "flagged";
  double convexity_tolerance = -1.0;
  bool json = false;
};

/// One block of the file, and what becomes of it.
struct BlockInfo {
  const MeshBlock* mesh = nullptr;
  std::optional<geometry::Shape> shape{};  ///< none: not convex
  std::string fault{};                     ///< why not
  int support = -1;                        ///< the nearest; -1: there is none
  double gap = 0.0;                        ///< to it, m; negative: overlap
};

double box_distance(const geometry::Box& a, const geometry::Box& b) {
  return (a.min - b.max).cwiseMax(b.min - a.max).cwiseMax(0.0).norm();
}

/// Boxes tell which supports can be nearest, the exact gap which is.
void find_nearest_support(const std::vector<int>& supports, std::vector<BlockInfo>& blocks,
                          BlockInfo& block) {
  std::vector<std::pair<double, int>> near;
  for (const int s : supports) {
    near.emplace_back(
        box_distance(block.shape->box(), blocks[static_cast<std::size_t>(s)].shape->box()), s);
  }
  std::sort(near.begin(), near.end());
  for (const auto& [distance, s] : near) {
    if (block.support >= 0 && distance > std::max(0.0, block.gap)) return;
    const double gap =
        geometry::nearest_features(*block.shape, *blocks[static_cast<std::size_t>(s)].shape).gap;
    if (block.support < 0 || gap < block.gap) {
      block.support = s;
      block.gap = gap;
    }
  }
}

/// `taken`: as of convex_block().
std::vector<BlockInfo> look_at(const std::vector<MeshBlock>& meshes, double tolerance,
                               double& taken) {
  std::vector<BlockInfo> blocks(meshes.size());
  std::vector<int> supports;
  for (std::size_t b = 0; b < meshes.size(); ++b) {
    blocks[b].mesh = &meshes[b];
    try {
      blocks[b].shape = scene_file::convex_block(meshes[b], tolerance, &taken);
      if (meshes[b].is_support) supports.push_back(static_cast<int>(b));
    } catch (const geometry::InputError& error) {
      blocks[b].fault = error.what();
    }
  }
  for (BlockInfo& block : blocks)
    if (block.shape && !block.mesh->is_support) find_nearest_support(supports, blocks, block);
  return blocks;
}

json block_json(const BlockInfo& block, const std::vector<BlockInfo>& blocks) {
  json line = {{"id", block.mesh->id},
               {"name", block.mesh->name},
               {"support", block.mesh->is_support},
               {"convex", block.shape.has_value()},
               {"fault", block.fault},
               {"mesh_faces", block.mesh->faces.size()},
               {"faces", nullptr},
               {"vertices", nullptr},
               {"volume", nullptr},
               {"centroid", nullptr},
               {"nearest_support", nullptr}};
  if (block.shape) {
    const geometry::MassProperties mass = geometry::mass_properties(*block.shape);
    line["faces"] = block.shape->topology().face_count();
    line["vertices"] = block.shape->vertices().cols();
    line["volume"] = mass.volume;
    line["centroid"] = {mass.centroid.x(), mass.centroid.y(), mass.centroid.z()};
  }
  if (block.support >= 0) {
    line["nearest_support"] = {{"id", blocks[static_cast<std::size_t>(block.support)].mesh->id},
                               {"gap", block.gap}};
  }
  return line;
}

void print_block(const BlockInfo& block, const std::vector<BlockInfo>& blocks) {
  std::printf("%-16s %-16s ", block.mesh->id.c_str(), block.mesh->name.c_str());
  if (!block.shape) {
    std::printf("%12s %6zu  %s\n", "", block.mesh->faces.size(), block.fault.c_str());
    return;
  }
  const double volume = geometry::mass_properties(*block.shape).volume;
  std::printf("%12.6g %6d  convex", volume, block.shape->topology().face_count());
  if (block.mesh->is_support) {
    std::printf(", support");
  } else if (block.support >= 0) {
    std::printf(", %.3g m from support %s", block.gap,
                blocks[static_cast<std::size_t>(block.support)].mesh->id.c_str());
  }
  std::printf("\n");
}

void print_all(const std::vector<BlockInfo>& blocks) {
  std::printf("%-16s %-16s %12s %6s\n", "id", "name", "volume, m3", "faces");
  int convex = 0, supports = 0;
  double volume = 0.0;
  for (const BlockInfo& block : blocks) {
    print_block(block, blocks);
    convex += block.shape.has_value();
    supports += block.mesh->is_support;
    volume += block.shape ? geometry::mass_properties(*block.shape).volume : 0.0;
  }
  std::printf("%zu blocks, %d convex, %d supports, %.6g m3\n", blocks.size(), convex, supports,
              volume);
}

/// Of "mm" or "0.001", m; 0: neither.
double length_of(const std::string& units) {
  double length = scene_file::unit_length(units);
  const bool known = length > 0.0 || CLI::detail::lexical_cast(units, length);
  return known && length > 0.0 && std::isfinite(length) ? length : 0.0;
}

CLI::Validator units() {
  return CLI::Validator(
      [](const std::string& text) {
        return length_of(text) > 0.0
                   ? std::string()
                   : "must be m, dm, cm, mm, in, ft or a length in m, is " + text.substr(0, 40);
      },
      "UNIT");
}

int info(const InfoArguments& arguments) {
  std::vector<MeshBlock> meshes = scene_file::read_mesh_file(
      arguments.file, scene_file::mesh_format(arguments.file, arguments.format));
  for (MeshBlock& mesh : meshes) {
    mesh.vertices *= length_of(arguments.units);
    mesh.rounding *= length_of(arguments.units);
  }
  if (arguments.supports == "lowest_course") scene_file::mark_lowest_course(meshes);
  double taken = 0.0;
  const std::vector<BlockInfo> blocks = look_at(meshes, arguments.convexity_tolerance, taken);
  if (arguments.json) {
    json list = json::array();
    for (const BlockInfo& block : blocks) list.push_back(block_json(block, blocks));
    std::printf("%s\n", json{{"file", arguments.file}, {"blocks", list}}
                            .dump(2, ' ', false, json::error_handler_t::replace)
                            .c_str());
  } else {
    print_all(blocks);
    if (taken > 0.0) std::printf("taken for convex: up to %.3g m below the hull\n", taken);
  }
  const bool all_convex = std::all_of(
      blocks.begin(), blocks.end(), [](const BlockInfo& block) { return block.shape.has_value(); });
  return all_convex ? kDone : kBadInput;
}

}  // namespace

void add_info_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<InfoArguments>();
  CLI::App* command = app.add_subcommand(
      "info", "List the blocks of a mesh file: volume, faces, convex or why not, nearest support");
  command->add_option("file", arguments->file, "as quoin import takes it")->required();
  command->add_option("--format", arguments->format, "default: by the ending of the file")
      ->check(CLI::IsMember(
          {"compas", "obj", "stl", "ply", "off", "dxf", "3dec", "lmgc90", "chrono", "rigid_ipc"}));
  command->add_option("--units", arguments->units, "of the file")
      ->check(units())
      ->capture_default_str();
  command->add_option("--supports", arguments->supports, "as the file says, or the lowest course")
      ->check(CLI::IsMember({"flagged", "lowest_course"}))
      ->capture_default_str();
  command->add_option("--convexity-tolerance", arguments->convexity_tolerance,
                      "m, how deep a surface may lie below its convex hull "
                      "(default: 1e-6 of the diameter, 1e-4 in files of up to 8 digits)");
  command->add_flag("--json", arguments->json, "the same as JSON, with centroids");
  command->callback([arguments, &exit_code] {
    try {
      exit_code = info(*arguments);
    } catch (const scene_file::MeshError& error) {
      std::fprintf(stderr, "%s: %s\n", arguments->file.c_str(), error.what());
      exit_code = kBadInput;
    }
  });
}

}  // namespace quoin::commands
