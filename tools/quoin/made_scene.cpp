#include "made_scene.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using Vector3 = Eigen::Vector3d;

constexpr double kGravity = 9.81;  // m/s2, of scenes that do not say

/// A length in m, to a picometre: what is shared by two blocks is the same number in both.
double rounded(double x) {
  const double value = std::round(x * 1e12) / 1e12;
  return value == 0.0 ? 0.0 : value;
}

/// Lengths that are each allowed can ask for more than any memory holds.
void check_count(double blocks) {
  if (blocks <= kMostBlocks) return;
  char line[80];
  std::snprintf(line, sizeof line, "would have %.7g blocks, at most %d are made", blocks,
                kMostBlocks);
  throw std::invalid_argument(line);
}

json points(const std::vector<Vector3>& list) {
  json all = json::array();
  for (const Vector3& point : list) all.push_back(vector(point));
  return all;
}

}  // namespace

json vector(const Vector3& v) { return {rounded(v.x()), rounded(v.y()), rounded(v.z())}; }

json box(const Vector3& min, const Vector3& max) {
  return {{"type", "box"}, {"min", vector(min)}, {"max", vector(max)}};
}

json prism(const std::vector<Vector3>& polygon, const Vector3& sweep) {
  return {{"type", "prism"}, {"polygon", points(polygon)}, {"sweep", vector(sweep)}};
}

json hull(const std::vector<Vector3>& list) { return {{"type", "hull"}, {"points", points(list)}}; }

std::string numbered(const std::string& stem, int number) { return stem + std::to_string(number); }

std::string numbered(const std::string& stem, int first, int second) {
  return stem + std::to_string(first) + "_" + std::to_string(second);
}

Made::Made(const Stone& stone, std::string title, double blocks)
    : stone_(stone), title_(std::move(title)), parameters_{{"phi", stone.friction_deg}} {
  check_count(blocks);
}

json& Made::add(const std::string& name, json shape) {
  blocks_.push_back({{"name", name},
                     {"kind", stone_.young > 0 ? "deformable" : "rigid"},
                     {"material", "stone"},
                     {"shape", std::move(shape)}});
  return blocks_.back();
}

json& Made::add_box(const std::string& name, const Vector3& corner, const Vector3& size) {
  json& block = add(name, box(Vector3::Zero(), size));
  block["pose"] = {{"translation", vector(corner)}};
  return block;
}

void Made::add_turned(const std::string& name, json shape, const Eigen::Quaterniond& turn,
                      const Vector3& about) {
  add(name, std::move(shape))["pose"] = {
      {"rotation",
       {{"quaternion",
         {rounded(turn.w()), rounded(turn.x()), rounded(turn.y()), rounded(turn.z())}}}},
      {"about", vector(about)}};
}

json& Made::add_fixed(const std::string& name, json shape) {
  blocks_.push_back({{"name", name}, {"kind", "fixed"}, {"shape", std::move(shape)}});
  return blocks_.back();
}

void Made::add_smooth_material(const std::string& name, double density) {
  materials_[name] = {{"density", density}};
  joints_.push_back({{"between", {name, name}}, {"friction_angle_deg", 0}});
}

void Made::watch(const std::string& block) {
  monitors_.push_back({{"name", block}, {"block", block}});
}

void Made::set(const std::string& parameter, double value) { parameters_[parameter] = value; }

double Made::end_time(double otherwise) const {
  return stone_.end_time > 0 ? stone_.end_time : otherwise;
}

void Made::save_standing(double time_step) const {
  json stages = json::array({json{{"analysis", "static"}}});
  if (stone_.end_time > 0)
    stages.push_back({{"analysis", "dynamic"}, {"end_time", stone_.end_time}});
  save(time_step, stages);
}

void Made::save_moving(double time_step, double otherwise) const {
  save(time_step, json::array({json{{"analysis", "dynamic"}, {"end_time", end_time(otherwise)}}}));
}

void Made::save_changing(double time_step, double otherwise, const json& change) const {
  json moving = {{"analysis", "dynamic"}, {"duration", end_time(otherwise)}};
  moving.update(change);
  save(time_step, json::array({json{{"analysis", "static"}}, moving}));
}

void Made::save(double time_step, const json& stages) const {
  json material = {{"density", stone_.density}};
  if (stone_.young > 0) material["young"] = stone_.young;
  json materials = {{"stone", material}};
  materials.update(materials_);
  json head = {{"title", title_},
               {"parameters", parameters_},
               {"materials", materials},
               {"joint", {{"friction_angle_deg", "=phi"}}}};
  if (!joints_.empty()) head["joints"] = joints_;
  for (const json& block : blocks_) {
    if (!(stone_.push > 0) || block["kind"] == "fixed") continue;
    const double density = materials[block["material"].get<std::string>()]["density"];
    head["loads"].push_back({{"type", "body"},
                             {"name", "push"},
                             {"block", block["name"]},
                             {"force", vector({stone_.push * density * kGravity, 0, 0})}});
  }
  head.update(json{{"time_step", time_step}, {"stages", stages}, {"monitors", monitors_}});
  save_text(stone_.out, scene_text(head, blocks_));
}

std::string scene_text(const json& head, const json& blocks) {
  std::string text = "{\n";
  for (const auto& [key, value] : head.items())
    text += "  " + json(key).dump() + ": " + value.dump() + ",\n";
  text += "  \"blocks\": [\n";
  for (std::size_t b = 0; b < blocks.size(); ++b)
    text += "    " + blocks[b].dump() + (b + 1 < blocks.size() ? ",\n" : "\n");
  return text + "  ]\n}\n";
}

void save_text(const std::string& path, const std::string& text) {
  if (path.empty()) {
    std::fputs(text.c_str(), stdout);
    return;
  }
  if (std::filesystem::is_regular_file(path))  // it may be a made scene that was changed
    throw scene_file::FileError(path + ": is there already; take another name or remove it");
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw scene_file::unwritable(path);
}

}  // namespace quoin::commands
