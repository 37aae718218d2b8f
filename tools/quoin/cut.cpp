/// quoin cut SCENE

#include <filesystem>
#include <quoin/geometry/mass_properties.hpp>

#include "commands.hpp"
#include "made_scene.hpp"
#include "path_to_write.hpp"
#include "scene_file/cut.hpp"
#include "scene_file/read_json.hpp"
#include "scene_file/scene_file.hpp"
#include "scene_file/schema_check.hpp"

namespace quoin::commands {
namespace {

using Ordered = nlohmann::ordered_json;
using scene_file::CutBody;
using scene_file::CutCell;

struct CutArguments {
  std::string scene, out;
  std::vector<std::string> changes{};
  bool as_json = false;
};

/// All blocks as objects of an OBJ file; `usemtl` names the joint that a face lies in.
std::string obj_text(const CutBody& body) {
  std::string text = "# m\n";
  char line[128];
  long before = 1;  // OBJ counts from 1
  for (std::size_t c = 0; c < body.cells.size(); ++c) {
    const CutCell& cell = body.cells[c];
    text +=
        "o " + (cell.region.empty() ? "" : cell.region + ":") + "block" + std::to_string(c) + "\n";
    for (int v = 0; v < cell.shape.vertex_count(); ++v) {
      const Eigen::Vector3d place = cell.shape.vertex(v);
      std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", place.x(), place.y(), place.z());
      text += line;
    }
    for (std::size_t f = 0; f < cell.face_joints.size(); ++f) {
      const int joint = cell.face_joints[f];
      text += "usemtl " + (joint < 0 ? "surface" : body.joints[static_cast<std::size_t>(joint)]);
      text += "\nf";
      for (const int v : cell.shape.topology().face(static_cast<int>(f)))
        text += " " + std::to_string(before + v);
      text += "\n";
    }
    before += cell.shape.vertex_count();
  }
  return text;
}

/// Number and volumes (m3) of the blocks; `closure`: what their sum is off the body's, relative.
Ordered told_of(const CutBody& body) {
  double sum = 0.0, least = body.volume, excavated = 0.0;
  std::size_t inside = 0;
  for (const CutCell& cell : body.cells) {
    const double volume = mass_properties(cell.shape).volume;
    sum += volume;
    least = std::min(least, volume);
    if (cell.region.empty()) continue;
    ++inside;
    excavated += volume;
  }
  return {{"blocks", body.cells.size()}, {"in_excavations", inside},
          {"volume", body.volume},       {"excavated_volume", excavated},
          {"smallest_volume", least},    {"closure", sum / body.volume - 1}};
}

int cut(const CutArguments& arguments) {
  nlohmann::json scene = scene_file::read_json(arguments.scene);
  scene_file::expand(scene, arguments.changes);
  scene_file::check_schema(nlohmann::json::parse(scene_file::scene_schema()), scene);
  if (!scene.contains("cut")) throw scene_file::SceneError("", "missing key \"cut\"");
  const CutBody body = scene_file::cut_body(scene["cut"], "/cut");
  for (const std::string& line : body.notes) complain(line);
  if (std::filesystem::path(arguments.out).extension() == ".obj") {
    save_text(arguments.out, obj_text(body));
  } else if (!arguments.as_json || !arguments.out.empty()) {
    scene_file::expand_cut(scene, body);
    const Ordered blocks = scene["blocks"];
    scene.erase("blocks");
    save_text(arguments.out, scene_text(scene, blocks));
  }
  const Ordered told = told_of(body);
  if (arguments.as_json) {
    std::printf("%s\n", text(told).c_str());
  } else {
    std::fprintf(
        stderr,
        "%zu blocks (%zu in excavations), smallest %.3g m3; volumes sum to %.9g m3, off by %.1e\n",
        body.cells.size(), told["in_excavations"].get<std::size_t>(),
        told["smallest_volume"].get<double>(), body.volume, told["closure"].get<double>());
  }
  return kDone;
}

}  // namespace

void add_cut_command(CLI::App& app, int& exit_code) {
  const auto [command, words] = add_command<CutArguments>(
      app, exit_code, cut, "cut",
      "Cut the body of a scene's \"cut\" by joint sets, planes, discs and excavations");
  command.add_option("scene", words.scene, "scene file with \"cut\"")->required();
  add_path(command, "--out", words.out,
           "FILE.json: the scene with its blocks, one a line (default: standard output); "
           "FILE.obj: the blocks, in m");
  command.add_option("--set", words.changes, "as of quoin run")->type_name("NAME=VALUE");
  command.add_flag("--json", words.as_json, "counts and volumes (m3) as JSON");
}

}  // namespace quoin::commands
