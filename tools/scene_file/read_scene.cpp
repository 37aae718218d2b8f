#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/queries.hpp>
#include <set>
#include <sstream>

#include "scene_file/cut.hpp"
#include "scene_file/grouted_tie.hpp"
#include "scene_file/mesh_file.hpp"
#include "scene_file/moved_hulls.hpp"
#include "scene_file/overrides.hpp"
#include "scene_file/printable.hpp"
#include "scene_file/read_json.hpp"
#include "scene_file/read_record.hpp"
#include "scene_file/read_shape.hpp"
#include "scene_file/scene_file.hpp"
#include "scene_file/schema_check.hpp"
#include "scene_file/shared_topology.hpp"
#include "scene_file/staged_work.hpp"
#include "scene_file/start_joints.hpp"
#include "scene_file/water.hpp"

namespace quoin::scene_file {
namespace {

using nlohmann::json;
using solver::BlockKind;
using solver::VectorOfTime;

std::string at(const std::string& pointer, std::size_t index) {
  return pointer + "/" + std::to_string(index);
}

double radians(const json& object, const char* key, double otherwise) {
  return object.contains(key) ? object[key].get<double>() * std::numbers::pi / 180 : otherwise;
}

Formula read_formula(const json& text, const std::string& pointer, const Parameters& parameters,
                     Formula::Clock clock = Formula::Clock::Run) {
  try {
    return {text.is_string() ? text.get<std::string>() : text.dump(), parameters, clock};
  } catch (const std::invalid_argument& error) {
    throw SceneError(pointer, error.what());
  }
}

/// A time that stands twice is a jump.
void check_ascending(const json& table, const std::string& pointer) {
  const auto time = [&](std::size_t row) { return table[row][0].get<double>(); };
  for (std::size_t i = 1; i < table.size(); ++i) {
    if (time(i) >= time(i - 1) && (i < 2 || time(i) > time(i - 2))) continue;
    throw SceneError(at(pointer, i) + "/0", "times must ascend, each at most twice; " +
                                                table[i][0].dump() + " comes after " +
                                                table[i - 1][0].dump());
  }
}

/// Reads one checked document. Its parts find blocks and materials by name.
class Reader {
 public:
  Reader(const json& document, std::string folder, Parameters parameters)
      : document_(document), folder_(std::move(folder)), parameters_(std::move(parameters)) {}

  SceneFile read() {
    file_.title = document_.value("title", "");
    file_.scene.gravity = VectorOfTime(Vector3(0, 0, -9.81));
    if (document_.contains("gravity"))
      file_.scene.gravity = vector_of_time(document_["gravity"], "/gravity");
    const std::string overlap = document_.value("initial_overlap", "refuse");
    file_.scene.initial_overlap = overlap == "keep"   ? solver::InitialOverlap::Keep
                                  : overlap == "zero" ? solver::InitialOverlap::Zero
                                                      : solver::InitialOverlap::Refuse;
    file_.scene.coordinate_rounding = document_.value("coordinate_rounding", 0.0);
    read_materials();
    read_blocks();
    each("join", &Reader::read_join);
    set_properties();
    tell_overlapping_parts();
    check_supports();
    read_joints();
    each("loads", &Reader::read_load);
    each("fixed_points", &Reader::read_fixed_point);
    each("ties", &Reader::read_tie);
    each("quiet_faces", &Reader::read_quiet_face);
    read_options();
    read_stages();
    tell_sampling();
    each("monitors", &Reader::read_monitor);
    each("references", &Reader::read_reference);
    file_.sources.insert(file_.sources.end(), records_.begin(), records_.end());
    return std::move(file_);
  }

 private:
  /// Motions are exact integrals of their records; other functions are taken once a step.
  void tell_sampling() {
    double step = 0.0;
    for (const Stage& stage : file_.stages)
      if (stage.analysis == solver::Analysis::Dynamic) step = std::max(step, stage.time_step);
    for (const auto& [pointer, interval] : sampled_) {
      if (!(interval < 0.999 * step)) continue;
      std::ostringstream line;
      line << pointer << ": a value each " << interval << " s, taken once a time step of " << step
           << " s, at its middle";
      file_.notes.push_back(line.str());
    }
  }

  using ReadOne = void (Reader::*)(const json&, const std::string&);
  void each(const char* key, ReadOne read_one) { each_of(document_, "", key, read_one); }
  void each_of(const json& document, const std::string& pointer, const char* key,
               ReadOne read_one) {
    for (std::size_t i = 0; document.contains(key) && i < document[key].size(); ++i)
      (this->*read_one)(document[key][i], at(pointer + "/" + key, i));
  }

  VectorOfTime vector_of_time(const json& value, const std::string& pointer) const {
    if (value.is_array()) return {read_vector(value)};
    if (value.contains("csv")) {
      records_.push_back(
          (std::filesystem::path(folder_) / value["csv"].get<std::string>()).string());
      if (value.contains("baseline") && !pointer.ends_with("/acceleration"))
        throw SceneError(pointer + "/baseline", "only an acceleration can be corrected");
      Record record = read_record(value, records_.back(), pointer);
      const double length = record.times.back() - record.times.front();
      if (pointer.find("/motion/") == std::string::npos)
        sampled_.emplace_back(pointer, length / static_cast<double>(record.times.size() - 1));
      return solver::interpolate(std::move(record.times), std::move(record.values));
    }
    if (value.contains("table")) {
      check_ascending(value["table"], pointer + "/table");
      std::vector<double> times;
      std::vector<Vector3> values;
      for (const json& row : value["table"]) {
        times.push_back(row[0]);
        values.emplace_back(row[1], row[2], row[3]);
      }
      return solver::interpolate(std::move(times), std::move(values));
    }
    std::vector<Formula> formulas;
    for (std::size_t i = 0; i < 3; ++i) {
      formulas.push_back(read_formula(value["formula"][i], at(pointer + "/formula", i), parameters_,
                                      Formula::Clock::RunAndStage));
    }
    return {[formulas, clock = file_.stage_clock](double time) {
      const double stage_time = time - clock->start;
      return Vector3(formulas[0].at(time, stage_time), formulas[1].at(time, stage_time),
                     formulas[2].at(time, stage_time));
    }};
  }

  void read_materials() {
    if (!document_.contains("materials")) return;
    for (const auto& [name, value] : document_["materials"].items()) {
      materials_[name] = {.density = value["density"],
                          .young = value.value("young", 0.0),
                          .poisson = value.value("poisson", 0.0),
                          .joint_group = new_joint_group(name),
                          .name = name};
      doubt(value, "density", 100.0, "/materials/" + name, "kg/m3: stone has 2000 to 3000");
    }
  }

  /// Tells of a value below what is likely: units are SI alone.
  void doubt(const json& value, const char* key, double least, const std::string& pointer,
             const std::string& units) {
    if (!value.contains(key) || value[key] >= least) return;
    file_.notes.push_back(pointer + "/" + key + ": " + value[key].dump() + " " + units);
  }

  /// Joint group 0 is of blocks without a material.
  int new_joint_group(const std::string& name) {
    return joint_groups_.try_emplace(name, static_cast<int>(joint_groups_.size()) + 1)
        .first->second;
  }

  const solver::Material& material(const std::string& name, const std::string& pointer) const {
    const auto found = materials_.find(name);
    if (found == materials_.end()) throw SceneError(pointer, "there is no material " + shown(name));
    return found->second;
  }

  void read_blocks() {
    const json& blocks = document_["blocks"];
    if (blocks.is_object()) {
      read_block_file(blocks, "/blocks", 0);
      return;
    }
    file_.scene.blocks.reserve(blocks.size());
    entries_.reserve(blocks.size());
    for (std::size_t i = 0; i < blocks.size(); ++i)
      if (blocks[i].contains("file"))
        read_block_file(blocks[i], at("/blocks", i), i);
      else
        read_block(blocks[i], i);
  }

  /// Where a block is stated, and what its file says of it.
  struct Entry {
    const json* value = nullptr;
    std::size_t index = 0;  ///< in /blocks, where that is a list
    std::string file_name{};
    bool is_support = false;
  };

  /// What the scene states of one block: the last override that has a key, else the block's own
  /// entry.
  class Stated {
   public:
    Stated(const json& own, std::string pointer) { layers_.emplace_back(&own, std::move(pointer)); }
    void override(const json& value, std::string pointer) {
      layers_.emplace_back(&value, std::move(pointer));
    }
    const json* find(const char* key, std::string& pointer) const {
      for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer) {
        if (const auto found = layer->first->find(key); found != layer->first->end()) {
          pointer = layer->second + "/" + key;
          return &*found;
        }
      }
      pointer = layers_.front().second;
      return nullptr;
    }
    bool is_overridden(const char* key) const {
      return std::any_of(layers_.begin() + 1, layers_.end(),
                         [&](const auto& layer) { return layer.first->contains(key); });
    }

   private:
    std::vector<std::pair<const json*, std::string>> layers_;
  };

  std::string pointer_of(const Entry& entry) const {
    return document_["blocks"].is_object() ? "/blocks" : at("/blocks", entry.index);
  }

  /// A face of a convex part whose plane is named.
  struct NamedFace {
    int part = 0;
    Vector3 normal = Vector3::UnitX();  ///< outward, in the frame of the block's shape
    std::string plane{};                ///< empty: none
  };

  /// Block::shape and Block::parts.
  struct Solid {
    std::shared_ptr<const geometry::Shape> shape{};
    std::shared_ptr<const std::vector<geometry::Shape>> parts{};
  };

  /// A block's own shape and where that stands.
  struct PlacedShape {
    Solid solid;
    geometry::Placement placement;
  };

  void add(PlacedShape placed, std::string name, Entry entry) {
    if (name.empty()) name = "block" + std::to_string(file_.scene.blocks.size());
    const int index = static_cast<int>(file_.scene.blocks.size());
    if (!index_of_.try_emplace(name, index).second) {
      throw SceneError(pointer_of(entry) + (entry.value->contains("name") ? "/name" : ""),
                       "there are two blocks named " + shown(name));
    }
    file_.scene.blocks.push_back({.shape = std::move(placed.solid.shape),
                                  .parts = std::move(placed.solid.parts),
                                  .placement = placed.placement,
                                  .material = {},
                                  .motion = {},
                                  .name = std::move(name)});
    entries_.push_back(std::move(entry));
  }

  static geometry::Placement pose_of(const json& value, const std::string& pointer) {
    return value.contains("pose") ? read_pose(value["pose"], pointer + "/pose")
                                  : geometry::Placement{};
  }

  void read_block(const json& value, std::size_t index) {
    const std::string pointer = at("/blocks", index);
    try {
      // Blocks whose shape is stated in the same words share it.
      const char* const key = value.contains("parts") ? "parts" : "shape";
      Solid& known = shapes_[value[key].dump()];
      if (known.shape == nullptr) known = stated_solid(value[key], pointer + "/" + key);
      add({known, pose_of(value, pointer)}, value.value("name", ""),
          {.value = &value, .index = index});
      const std::string& name = file_.scene.blocks.back().name;
      if (key == std::string("shape")) return name_faces(name, value[key], pointer + "/shape");
      for (std::size_t i = 0; i < value[key].size(); ++i)
        name_faces(name, value[key][i], at(pointer + "/parts", i), static_cast<int>(i));
    } catch (const geometry::InputError& error) {
      throw SceneError(pointer + "/shape", error.what());
    }
  }

  /// `value`: a shape, or a list of parts.
  Solid stated_solid(const json& value, const std::string& pointer) {
    if (!value.is_array())
      return {std::make_shared<const geometry::Shape>(topologies_.share(read_shape(value)))};
    std::vector<geometry::Shape> parts;
    for (std::size_t i = 0; i < value.size(); ++i) {
      try {
        parts.push_back(topologies_.share(read_shape(value[i])));
      } catch (const geometry::InputError& error) {
        throw SceneError(at(pointer, i), error.what());
      }
    }
    const solver::Block block = solver::compound(std::move(parts));
    return {block.shape, block.parts};
  }

  void read_join(const json& value, const std::string& pointer) {
    const std::vector<int> members = blocks_named(value["blocks"], pointer + "/blocks");
    const auto first = static_cast<std::size_t>(members.front());
    std::vector<solver::Block>& blocks = file_.scene.blocks;
    solver::Block& whole = blocks[first];
    const geometry::Placement frame{.translation = whole.placement.translation};
    std::vector<geometry::Shape> parts;
    std::vector<NamedFace> faces;
    for (const int member : members) {
      const auto m = static_cast<std::size_t>(member);
      if (stated_beside_shape(m) != stated_beside_shape(first)) {
        throw SceneError(pointer + "/blocks", shown(blocks[m].name) + " differs from " +
                                                  shown(whole.name) +
                                                  " in more than name, shape and pose");
      }
      const auto& [linear, translation] = blocks[m].placement;
      for (const NamedFace& face : faces_[blocks[m].name]) {
        faces.push_back({face.part + static_cast<int>(parts.size()),
                         linear.inverse().transpose() * face.normal, face.plane});
      }
      for (const geometry::Shape& part : blocks[m].convex_parts()) {
        const geometry::Points places =
            (linear * part.vertices()).colwise() + (translation - frame.translation);
        parts.emplace_back(part.shared_topology(), places);
      }
    }
    solver::Block joined = solver::compound(std::move(parts));
    joined.placement = frame;
    joined.name = value.value("name", whole.name);
    for (const int member : members) faces_.erase(blocks[static_cast<std::size_t>(member)].name);
    if (!faces.empty()) faces_[joined.name] = std::move(faces);
    whole = std::move(joined);
    for (auto member = members.rbegin(); member + 1 != members.rend(); ++member) {
      blocks.erase(blocks.begin() + *member);
      entries_.erase(entries_.begin() + *member);
    }
    index_of_.clear();
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (index_of_.try_emplace(blocks[b].name, static_cast<int>(b)).second) continue;
      throw SceneError(pointer + "/name", "there are two blocks named " + shown(blocks[b].name));
    }
  }

  /// The first compound of which parts overlap by more than blocks may: their mass counts twice.
  void tell_overlapping_parts() {
    constexpr double kMost = 1e-3;  // of the smaller part
    std::set<const void*> seen;
    for (const solver::Block& block : file_.scene.blocks) {
      if (block.parts == nullptr || !seen.insert(block.parts.get()).second) continue;
      const std::vector<geometry::Shape>& parts = *block.parts;
      for (std::size_t b = 1; b < parts.size(); ++b) {
        for (std::size_t a = 0; a < b; ++a) {
          const geometry::Box &box_a = parts[a].box(), &box_b = parts[b].box();
          if (((box_a.min.cwiseMax(box_b.min)).array() > box_a.max.cwiseMin(box_b.max).array())
                  .any())
            continue;
          const double size =
              std::min((box_a.max - box_a.min).norm(), (box_b.max - box_b.min).norm());
          const auto found =
              geometry::nearest_features_within({parts[a], {}}, {parts[b], {}}, -kMost * size);
          if (!found) continue;
          std::ostringstream line;
          line << "block " << shown(block.name) << ": its parts " << a << " and " << b
               << " overlap by " << -found->gap
               << " m, more than 1e-3 of the smaller one: mass counts twice there";
          file_.notes.push_back(line.str());
          return;
        }
      }
    }
  }

  /// What the entry of a block says beside its name, shape and pose, and whether its file flags it.
  std::pair<json, bool> stated_beside_shape(std::size_t block) const {
    json rest = *entries_[block].value;
    for (const char* key : {"name", "shape", "parts", "pose"}) rest.erase(key);
    return {rest, entries_[block].is_support};
  }

  std::vector<BlockLabel> labels() const {
    std::vector<BlockLabel> result;
    for (std::size_t b = 0; b < entries_.size(); ++b) {
      const solver::Block& block = file_.scene.blocks[b];
      result.push_back({block.name, entries_[b].file_name, &block});
    }
    return result;
  }

  /// Ascending.
  std::vector<int> blocks_named(const json& names, const std::string& pointer) const {
    const std::vector<char> meant = match_blocks(names, pointer, labels());
    std::vector<int> result;
    for (std::size_t b = 0; b < meant.size(); ++b)
      if (meant[b]) result.push_back(static_cast<int>(b));
    return result;
  }

  /// Kind, material and motion of every block, when all are known.
  void set_properties() {
    std::vector<std::vector<int>> overrides;
    if (document_.contains("overrides"))
      overrides = match_overrides(document_["overrides"], "/overrides", labels(), parameters_);
    for (std::size_t b = 0; b < entries_.size(); ++b) {
      Stated stated(*entries_[b].value, pointer_of(entries_[b]));
      for (std::size_t i = 0; !overrides.empty() && i < overrides[b].size(); ++i) {
        const auto number = static_cast<std::size_t>(overrides[b][i]);
        stated.override(document_["overrides"][number], at("/overrides", number));
      }
      set_kind(stated, entries_[b].is_support, file_.scene.blocks[b]);
      set_material(stated, file_.scene.blocks[b]);
      set_motion(stated, file_.scene.blocks[b]);
    }
  }

  static void set_kind(const Stated& stated, bool is_support, solver::Block& block) {
    std::string pointer;
    const json* value = stated.find("kind", pointer);
    const std::string kind = is_support && !stated.is_overridden("kind") ? "fixed"
                             : value != nullptr                          ? value->get<std::string>()
                                                                         : "deformable";
    block.kind = kind == "rigid"        ? BlockKind::Rigid
                 : kind == "fixed"      ? BlockKind::Fixed
                 : kind == "prescribed" ? BlockKind::Prescribed
                                        : BlockKind::Deformable;
  }

  /// What a stage's override says of a block, after all that was said of it before.
  void override_in_stage(const json& value, const std::string& pointer, int index, Stage& stage) {
    solver::Block& block = file_.scene.blocks[static_cast<std::size_t>(index)];
    const Stated stated(value, pointer);
    const auto says = [&](const char* key) { return value.contains(key); };
    if (says("kind")) set_kind(stated, false, block);
    if (says("material")) change_material(value["material"], pointer + "/material", block);
    if (says("joint_group")) block.material.joint_group = new_joint_group(value["joint_group"]);
    constexpr std::array kMotion = {"kind", "motion", "velocity", "angular_velocity",
                                    "initial_stress"};
    if (std::ranges::any_of(kMotion, says)) set_motion(stated, block);
    if (says("velocity") || says("angular_velocity")) set_in_motion(value, pointer, index, stage);
    if (!moves_freely(block)) return;
    const bool deformable = block.kind == BlockKind::Deformable;
    if (!(block.material.density > 0) || (deformable && !(block.material.young > 0))) {
      throw SceneError(pointer, "block " + shown(block.name) + " has no material" +
                                    (deformable ? " with young" : "") +
                                    ", which it needs to move freely");
    }
  }

  /// A block that has a joint group of its own keeps it.
  void change_material(const json& name, const std::string& pointer, solver::Block& block) const {
    const int group = block.material.joint_group;
    const auto before = materials_.find(block.material.name);
    const bool own = group != (before == materials_.end() ? 0 : before->second.joint_group);
    block.material = material(name, pointer);
    if (own) block.material.joint_group = group;
  }

  static void set_in_motion(const json& value, const std::string& pointer, int block,
                            Stage& stage) {
    if (stage.analysis != solver::Analysis::Dynamic) {
      throw SceneError(pointer + (value.contains("velocity") ? "/velocity" : "/angular_velocity"),
                       "in a static stage nothing has a velocity");
    }
    std::vector<StageVelocity>& known = stage.velocities;
    if (known.empty() || known.back().block != block) known.push_back({.block = block});
    if (value.contains("velocity")) known.back().velocity = read_vector(value["velocity"]);
    if (value.contains("angular_velocity"))
      known.back().angular_velocity = read_vector(value["angular_velocity"]);
  }

  static bool moves_freely(const solver::Block& block) {
    return block.kind == BlockKind::Deformable || block.kind == BlockKind::Rigid;
  }

  void set_material(const Stated& stated, solver::Block& block) {
    std::string pointer;
    if (const json* name = stated.find("material", pointer)) {
      block.material = material(*name, pointer);
      if (block.kind == BlockKind::Deformable && !(block.material.young > 0)) {
        throw SceneError(
            pointer, "material " + name->dump() + " has no young, which a deformable block needs");
      }
    } else if (moves_freely(block)) {
      throw SceneError(pointer, "missing key \"material\"");
    }
    if (const json* group = stated.find("joint_group", pointer))
      block.material.joint_group = new_joint_group(*group);
  }

  void set_motion(const Stated& stated, solver::Block& block) const {
    std::string pointer;
    for (const char* key : {"velocity", "angular_velocity", "initial_stress"})
      if (stated.find(key, pointer) != nullptr && !moves_freely(block))
        throw SceneError(pointer, "a fixed or prescribed block can't have it");
    if (const json* velocity = stated.find("velocity", pointer))
      block.velocity = read_vector(*velocity);
    if (const json* velocity = stated.find("angular_velocity", pointer))
      block.angular_velocity = read_vector(*velocity);
    const json* stress = stated.find("initial_stress", pointer);
    for (std::size_t i = 0; stress != nullptr && i < 6; ++i)
      block.initial_stress[static_cast<Eigen::Index>(i)] = (*stress)[i];
    const json* motion = stated.find("motion", pointer);
    if ((motion != nullptr) != (block.kind == BlockKind::Prescribed)) {
      throw SceneError(pointer, motion != nullptr
                                    ? "only a prescribed block has a \"motion\""
                                    : "missing key \"motion\", which a prescribed block needs");
    }
    if (motion != nullptr) {
      const std::string key = motion->contains("velocity")       ? "velocity"
                              : motion->contains("acceleration") ? "acceleration"
                                                                 : "displacement";
      block.motion.kind = key == "displacement" ? solver::MotionKind::Displacement
                          : key == "velocity"   ? solver::MotionKind::Velocity
                                                : solver::MotionKind::Acceleration;
      block.motion.value = Vector3(Vector3::Zero());
      if (motion->contains(key))
        block.motion.value = vector_of_time((*motion)[key], pointer + "/" + key);
      block.motion.rotation = Vector3(Vector3::Zero());
      if (motion->contains("rotation")) {
        block.motion.rotation = vector_of_time((*motion)["rotation"], pointer + "/rotation");
        if (!motion->contains("centre")) throw SceneError(pointer, "missing key \"centre\"");
        block.motion.centre = read_vector((*motion)["centre"]);
      }
      const std::span<const double> times = block.motion.value.knots();
      if (key == "displacement" && std::ranges::adjacent_find(times) != times.end())
        throw SceneError(pointer + "/" + key, "a displacement can't jump");
    }
  }

  static double unit_of(const json& value) {
    if (!value.contains("units")) return 1.0;
    return value["units"].is_number() ? value["units"].get<double>() : unit_length(value["units"]);
  }

  std::vector<MeshBlock> read_meshes(const json& value, const std::string& pointer) const {
    const std::string path =
        (std::filesystem::path(folder_) / value["file"].get<std::string>()).string();
    try {
      return read_mesh_file(path, mesh_format(path, value.value("format", "")));
    } catch (const MeshError& error) {
      throw SceneError(pointer + "/file", path + ": " + error.what());
    }
  }

  void read_block_file(const json& value, const std::string& pointer, std::size_t index) {
    file_.sources.push_back(
        (std::filesystem::path(folder_) / value["file"].get<std::string>()).string());
    std::vector<MeshBlock> meshes = read_meshes(value, pointer);
    for (MeshBlock& mesh : meshes) {
      mesh.vertices *= unit_of(value);
      mesh.rounding *= unit_of(value);
    }
    mark_supports(value, pointer, meshes);
    const bool held = std::any_of(meshes.begin(), meshes.end(),
                                  [](const MeshBlock& mesh) { return mesh.is_support; });
    if (!held && !(value.contains("supports") && value["supports"].is_array()))
      files_without_support_.push_back(pointer);
    if (entries_.empty()) {
      file_.scene.blocks.reserve(meshes.size());
      entries_.reserve(meshes.size());
    }
    MovedHulls hulls;
    taken_ = 0.0;
    for (std::size_t m = 0; m < meshes.size();) {
      const std::span<const MeshBlock> of_block = meshes_of_block(meshes, m);
      const MeshBlock& mesh = of_block.front();
      try {
        add({solid_of(value, of_block, hulls), pose_of(value, pointer)},
            of_block.size() > 1 ? mesh.body : mesh.id,
            {.value = &value,
             .index = index,
             .file_name = mesh.name,
             .is_support = mesh.is_support});
      } catch (const geometry::InputError& error) {
        throw SceneError(
            pointer, "block \"" + mesh.id + "\" of " + value["file"].dump() + ": " + error.what());
      }
      m += of_block.size();
    }
    if (!(taken_ > 0.0)) return;
    std::ostringstream line;
    line << value["file"].get<std::string>() << ": blocks whose surface lies up to " << taken_
         << " m below their convex hull are taken for convex (convexity_tolerance)";
    file_.notes.push_back(line.str());
  }

  /// `value`: of the block file.
  Solid solid_of(const json& value, std::span<const MeshBlock> meshes, MovedHulls& hulls) {
    const double tolerance = value.value("convexity_tolerance", -1.0);
    const bool split = value.value("split", false);
    if (meshes.size() == 1 && !split) {
      return {std::make_shared<const geometry::Shape>(hulls.shape_of(meshes[0], [&] {
        return topologies_.share(convex_block(meshes[0], tolerance, &taken_));
      }))};
    }
    std::vector<geometry::Shape> parts;
    for (const MeshBlock& mesh : meshes)
      if (split)
        std::ranges::move(convex_parts(mesh), std::back_inserter(parts));
      else
        parts.push_back(convex_block(mesh, tolerance, &taken_));
    if (parts.size() == 1) return {std::make_shared<const geometry::Shape>(parts.front())};
    const solver::Block block = solver::compound(std::move(parts));
    return {block.shape, block.parts};
  }

  /// A file that flags no support would fall without a word. Who wants that says "supports": [].
  void check_supports() const {
    const auto& blocks = file_.scene.blocks;
    const bool held =
        document_.contains("fixed_points") ||
        std::any_of(blocks.begin(), blocks.end(), [](const solver::Block& block) {
          return block.kind == BlockKind::Fixed || block.kind == BlockKind::Prescribed;
        });
    if (held || files_without_support_.empty()) return;
    throw SceneError(files_without_support_[0],
                     "the file flags no block as a support and nothing else is fixed; say "
                     "\"supports\": \"lowest_course\", a list of ids, or [] for none");
  }

  static void mark_supports(const json& value, const std::string& pointer,
                            std::vector<MeshBlock>& meshes) {
    const json flagged = "flagged";
    const json& supports = value.contains("supports") ? value["supports"] : flagged;
    if (supports == "lowest_course") mark_lowest_course(meshes);
    if (!supports.is_array()) return;
    for (MeshBlock& mesh : meshes) mesh.is_support = false;
    for (std::size_t i = 0; i < supports.size(); ++i) {
      const std::string id =
          supports[i].is_string() ? supports[i].get<std::string>() : supports[i].dump();
      const auto found = std::find_if(meshes.begin(), meshes.end(),
                                      [&](const MeshBlock& mesh) { return mesh.id == id; });
      if (found == meshes.end())
        throw SceneError(at(pointer + "/supports", i), "the file has no block \"" + id + "\"");
      found->is_support = true;
    }
  }

  /// What one key of a joint allows another one.
  static void check_joint(const json& value, const std::string& pointer) {
    const double friction = value["friction_angle_deg"],
                 dilation = value.value("dilation_angle_deg", 0.0);
    for (const char* key : {"friction_angle_deg", "residual_friction_angle_deg"}) {
      if (dilation <= value.value(key, friction)) continue;
      throw SceneError(pointer + "/dilation_angle_deg",
                       value["dilation_angle_deg"].dump() + " must not exceed " + key + ", " +
                           value[key].dump() + ": the joint would make energy");
    }
    for (const auto& [key, other] : {std::pair("normal_stiffness", "shear_stiffness"),
                                     std::pair("shear_stiffness", "normal_stiffness")}) {
      if (!value.contains(key) || value.contains(other)) continue;
      throw SceneError(pointer,
                       std::string("missing key \"") + other + "\", as there is \"" + key + "\"");
    }
  }

  static solver::Joint joint(const json& value, const std::string& pointer) {
    check_joint(value, pointer);
    return {.friction_angle = radians(value, "friction_angle_deg", 0.0),
            .cohesion = value.value("cohesion", 0.0),
            .tension = value.value("tension", 0.0),
            .restitution = value.value("restitution", 0.0),
            .dilation_angle = radians(value, "dilation_angle_deg", 0.0),
            .dilation_slip = value.value("dilation_slip", 0.0),
            .residual_friction_angle = radians(value, "residual_friction_angle_deg", -1.0),
            .residual_cohesion = value.value("residual_cohesion", 0.0),
            .residual_tension = value.value("residual_tension", 0.0),
            .softening_slip = value.value("softening_slip", 0.0),
            .normal_stiffness = value.value("normal_stiffness", 0.0),
            .shear_stiffness = value.value("shear_stiffness", 0.0)};
  }

  void read_joints() {
    if (document_.contains("joint"))
      file_.scene.joint = joint(document_["joint"], "/joint");
    else if (file_.scene.blocks.size() > 1)
      throw SceneError("", "missing key \"joint\": the properties where blocks touch");
    each("joints", &Reader::read_pair_joint);
  }

  void read_pair_joint(const json& value, const std::string& pointer) {
    if (value.contains("blocks") || value.contains("planes") || value.contains("where"))
      return read_block_joints(value, pointer);
    if (!value.contains("between"))
      throw SceneError(pointer, "needs \"between\", \"blocks\", \"planes\" or \"where\"");
    const auto [a, b] = groups_between(value, pointer);
    const auto is_same = [&](const solver::PairJoint& known) {
      return std::minmax(known.group_a, known.group_b) == std::minmax(a, b);
    };
    if (std::ranges::any_of(file_.scene.pair_joints, is_same)) {
      const json& names = value["between"];
      throw SceneError(pointer + "/between", "there is a joint between " + shown(names[0]) +
                                                 " and " + shown(names[1]) + " already");
    }
    file_.scene.pair_joints.push_back({a, b, joint(value, pointer)});
  }

  std::pair<int, int> groups_between(const json& value, const std::string& pointer) const {
    return {joint_group(value["between"][0], pointer + "/between/0"),
            joint_group(value["between"][1], pointer + "/between/1")};
  }

  /// Of blocks that touch at the start, by pair, plane or place. Later entries win.
  void read_block_joints(const json& value, const std::string& pointer) {
    const solver::Joint law = joint(value, pointer);
    const auto meant = meant_joints(value, "blocks", pointer);
    std::optional<std::pair<int, int>> groups;
    if (value.contains("between")) groups = groups_between(value, pointer);
    const auto group = [&](int block) {
      return file_.scene.blocks[static_cast<std::size_t>(block)].material.joint_group;
    };
    std::map<std::pair<int, int>, solver::Joint> known;
    for (solver::BlockJoint& pair : file_.scene.block_joints) known[{pair.a, pair.b}] = pair.joint;
    bool any = false;
    for (const StartJoint& touching : laid_joints()) {
      const auto [a, b] = std::pair(touching.a, touching.b);
      if (a == b || !meant(touching)) continue;
      if (groups && std::minmax(group(a), group(b)) != std::minmax(groups->first, groups->second))
        continue;
      known[{a, b}] = law;
      any = true;
    }
    if (!any) throw SceneError(pointer, "no faces that touch at the start are meant");
    file_.scene.block_joints.clear();
    for (const auto& [pair, stated] : known)
      file_.scene.block_joints.push_back({pair.first, pair.second, stated});
  }

  const std::vector<StartJoint>& laid_joints() {
    if (!laid_joints_) laid_joints_ = start_joints(file_.scene);
    return *laid_joints_;
  }

  /// Which joints of the start an entry means: those between the two sets of blocks of `key`, on
  /// `planes`, and whose middle meets `where`, as far as it states them.
  std::function<bool(const StartJoint&)> meant_joints(const json& value, const char* key,
                                                      const std::string& pointer) const {
    std::vector<char> one(file_.scene.blocks.size(), 1), other = one;
    if (value.contains(key) && value[key].is_array() && value[key].size() == 2) {
      one = match_blocks(value[key][0], pointer + "/" + key + "/0", labels());
      other = match_blocks(value[key][1], pointer + "/" + key + "/1", labels());
    }
    std::set<std::string> planes;
    if (value.contains("planes")) planes = planes_named(value["planes"], pointer + "/planes");
    std::optional<Formula> where;
    if (value.contains("where")) {
      where = read_formula(value["where"], pointer + "/where", parameters_,
                           Formula::Clock::RunAndPlace);
    }
    return [=, this](const StartJoint& joint) {
      const auto a = static_cast<std::size_t>(joint.a), b = static_cast<std::size_t>(joint.b);
      if (!(one[a] && other[b]) && !(one[b] && other[a])) return false;
      if (!planes.empty() && !planes.contains(plane_of(a, joint.part_a, joint.normal)) &&
          !planes.contains(plane_of(b, joint.part_b, -joint.normal)))
        return false;
      Vector3 middle = Vector3::Zero();
      for (const Vector3& corner : joint.corners) middle += corner;
      middle /= static_cast<double>(joint.corners.size());
      return !where || where->at(middle, 0.0) != 0.0;
    };
  }

  std::set<std::string> planes_named(const json& names, const std::string& pointer) const {
    std::set<std::string> known, meant;
    for (const auto& [block, faces] : faces_)
      for (const NamedFace& face : faces) known.insert(face.plane);
    for (const json& name : names.is_array() ? names : json::array({names})) {
      meant.insert(name);
      if (known.contains(name)) continue;
      throw SceneError(pointer, "no face is of the plane " + shown(name));
    }
    return meant;
  }

  /// Name of the plane of a part's face with this outward normal, in the world; empty: none.
  std::string plane_of(std::size_t block, int part, const Vector3& normal) const {
    const auto faces = faces_.find(file_.scene.blocks[block].name);
    if (faces == faces_.end()) return {};
    const geometry::Matrix3& linear = file_.scene.blocks[block].placement.linear;
    const NamedFace* best = nullptr;
    double greatest = 0.0;
    for (const NamedFace& face : faces->second) {
      const Vector3 outward = linear.inverse().transpose() * face.normal;
      const double along = outward.normalized().dot(normal);
      if (face.part != part || along <= greatest) continue;
      best = &face;
      greatest = along;
    }
    return best == nullptr ? std::string() : best->plane;
  }

  /// Keeps the planes that `shape` names for its faces.
  void name_faces(const std::string& block, const json& shape, const std::string& pointer,
                  int part = 0) {
    if (!shape.contains("planes")) return;
    const json &vertices = shape["vertices"], &planes = shape["planes"];
    if (planes.size() != shape["faces"].size())
      throw SceneError(pointer + "/planes", "must name one plane a face, \"\" for none");
    for (std::size_t f = 0; f < planes.size(); ++f) {
      Vector3 area = Vector3::Zero();
      const json& cycle = shape["faces"][f];
      const auto line = [&](std::size_t to) -> Vector3 {
        return read_vector(vertices[cycle[to].get<std::size_t>()]) -
               read_vector(vertices[cycle[0].get<std::size_t>()]);
      };
      for (std::size_t i = 1; i + 1 < cycle.size(); ++i) area += line(i).cross(line(i + 1));
      faces_[block].push_back({part, area.normalized(), planes[f]});
    }
  }

  int joint_group(const std::string& name, const std::string& pointer) const {
    const auto found = joint_groups_.find(name);
    if (found == joint_groups_.end())
      throw SceneError(pointer, "there is no material or joint group \"" + name + "\"");
    return found->second;
  }

  int block_named(const json& name, const std::string& pointer) const {
    const auto found = index_of_.find(name.get<std::string>());
    if (found == index_of_.end()) throw SceneError(pointer, "there is no block " + shown(name));
    return found->second;
  }

  int loaded_block(const json& value, const std::string& pointer) const {
    const int block = block_named(value["block"], pointer + "/block");
    const BlockKind kind = file_.scene.blocks[static_cast<std::size_t>(block)].kind;
    if (kind == BlockKind::Fixed || kind == BlockKind::Prescribed) {
      throw SceneError(pointer + "/block",
                       value["block"].dump() + " is fixed or prescribed and can't bear it");
    }
    require_present(block, pointer + "/block");
    return block;
  }

  /// Of what a stage gives; what was given before waits for a block that is absent.
  void require_present(int block, const std::string& pointer) const {
    if (!at_start_ || !absent_[static_cast<std::size_t>(block)]) return;
    throw SceneError(pointer,
                     json(file_.scene.blocks[static_cast<std::size_t>(block)].name).dump() +
                         " is not there in this stage");
  }

  int face_towards(int block, const Vector3& direction, const std::string& pointer) const {
    if (!(direction.norm() > 0)) throw SceneError(pointer, "must not be zero");
    const geometry::Body body = file_.scene.blocks[static_cast<std::size_t>(block)].body();
    const geometry::Topology& topology = body.shape().topology();
    const auto line = [&](int from, int to) -> Vector3 {
      return body.placement().linear * (body.shape().vertex(to) - body.shape().vertex(from));
    };
    constexpr double kAlike = 1e-9;  // of cosines: far above their rounding
    int best = 0;
    double greatest = -2.0, second = -2.0;
    for (int f = 0; f < topology.face_count(); ++f) {
      const std::span<const int> cycle = topology.face(f);
      Vector3 area = Vector3::Zero();
      for (std::size_t i = 1; i + 1 < cycle.size(); ++i)
        area += line(cycle[0], cycle[i]).cross(line(cycle[0], cycle[i + 1]));
      const double along = area.normalized().dot(direction.normalized());
      second = std::max(second, std::min(along, greatest));
      if (along > greatest) {
        greatest = along;
        best = f;
      }
    }
    if (greatest - second < kAlike)
      throw SceneError(pointer, "two faces of the block look this way alike");
    return best;
  }

  void read_load(const json& value, const std::string& pointer) {
    const int block = loaded_block(value, pointer);
    const std::string type = value["type"];
    if (type == "point") {
      file_.scene.point_loads.push_back(
          {.block = block,
           .point = read_vector(value["point"]),
           .force = vector_of_time(value["force"], pointer + "/force")});
    } else if (type == "face") {
      const int face = face_towards(block, read_vector(value["towards"]), pointer + "/towards");
      file_.scene.face_loads.push_back(
          {.block = block,
           .face = face,
           .traction = vector_of_time(value["traction"], pointer + "/traction")});
    } else {
      file_.scene.body_loads.push_back(
          {.block = block, .force = vector_of_time(value["force"], pointer + "/force")});
    }
  }

  void read_fixed_point(const json& value, const std::string& pointer) {
    solver::FixedPoint fixed{.block = loaded_block(value, pointer),
                             .point = read_vector(value["point"]),
                             .displacement = {},
                             .name = value.value("name", value["block"].get<std::string>())};
    if (value.contains("displacement"))
      fixed.displacement = vector_of_time(value["displacement"], pointer + "/displacement");
    file_.scene.fixed_points.push_back(std::move(fixed));
  }

  /// What a tie states twice, or by halves.
  void check_tie(const json& value, const std::string& name, const std::string& pointer) const {
    const bool of_bar = value.contains("young") && value.contains("area");
    if (value.contains("stiffness") == of_bar || value.contains("young") != value.contains("area"))
      throw SceneError(pointer, "needs either \"stiffness\", or \"young\" and \"area\"");
    for (const char* other : {"stiffness", "rest_length"}) {
      if (!value.contains("points") || !value.contains(other)) continue;
      throw SceneError(pointer + "/" + other,
                       "a tie that is grouted at \"points\" takes \"young\" and \"area\", and "
                       "\"pretension\": its parts have different lengths");
    }
    if (value.contains("pretension") && value.contains("rest_length"))
      throw SceneError(pointer + "/rest_length", "can't be given together with \"pretension\"");
    const auto same = [&](const solver::Tie& tie) {
      return tie.name == name || tie.name.starts_with(name + "/");
    };
    if (std::ranges::any_of(file_.scene.ties, same))
      throw SceneError(pointer + "/name", "another tie is named " + json(name).dump());
  }

  void read_tie(const json& value, const std::string& pointer) {
    solver::Tie tie{.pretension = value.value("pretension", 0.0),
                    .rest_length = value.value("rest_length", 0.0),
                    .tension_only = value.value("tension_only", true),
                    .yield_force = value.value("yield_force", solver::Tie{}.yield_force),
                    .break_force = value.value("break_force", solver::Tie{}.break_force),
                    .break_strain = value.value("break_strain", solver::Tie{}.break_strain),
                    .name = value.value("name", "tie" + pointer.substr(pointer.rfind('/') + 1))};
    check_tie(value, tie.name, pointer);
    if (tie.break_strain > 1.0 && value.contains("break_strain")) {
      file_.notes.push_back(pointer + "/break_strain: " + value["break_strain"].dump() +
                            " by rest length: 0.05 is 5 %");
    }
    const auto read_end = [&](const char* key, int& block, Vector3& point) {
      const json& end = value[key];
      if (end.contains("block")) {
        block = block_named(end["block"], pointer + "/" + key + "/block");
        require_present(block, pointer + "/" + key + "/block");
      }
      point = read_vector(end["point"]);
    };
    read_end("from", tie.a, tie.point_a);
    read_end("to", tie.b, tie.point_b);
    const double length = (tie.point_b - tie.point_a).norm();
    const bool of_bar = value.contains("young");
    tie.stiffness = of_bar ? value["young"].get<double>() * value["area"].get<double>() / length
                           : value["stiffness"].get<double>();
    std::vector<solver::Tie>& ties = file_.scene.ties;
    if (!value.contains("points")) return ties.push_back(tie);
    try {
      std::ranges::move(grouted_tie(file_.scene, tie, value["points"]), std::back_inserter(ties));
    } catch (const geometry::InputError& error) {
      throw SceneError(pointer + "/points", error.what());
    }
  }

  /// Impedances of the block's own material, where none are stated.
  void read_quiet_face(const json& value, const std::string& pointer) {
    const int block = loaded_block(value, pointer);
    const solver::Material& rock = file_.scene.blocks[static_cast<std::size_t>(block)].material;
    const double shear = rock.young / (2.0 * (1.0 + rock.poisson));
    const double pressed = 2.0 * shear * (1.0 - rock.poisson) / (1.0 - 2.0 * rock.poisson);
    if (!(rock.young > 0.0) &&
        !(value.contains("normal_impedance") && value.contains("shear_impedance"))) {
      throw SceneError(pointer,
                       "the block's material has no young: \"normal_impedance\" and "
                       "\"shear_impedance\" are needed");
    }
    solver::QuietFace face{
        .block = block,
        .face = face_towards(block, read_vector(value["towards"]), pointer + "/towards"),
        .normal_impedance = value.value("normal_impedance", std::sqrt(rock.density * pressed)),
        .shear_impedance = value.value("shear_impedance", std::sqrt(rock.density * shear))};
    if (value.contains("velocity"))
      face.velocity = vector_of_time(value["velocity"], pointer + "/velocity");
    file_.scene.quiet_faces.push_back(std::move(face));
  }

  void read_water(const json& value, const std::string& pointer) {
    Water water{.field = water_pressure(value, pointer),
                .divisions = value.value("divisions", Water{}.divisions)};
    const std::string on = value.value("on", "all");
    water.surface = on == "joints" ? WetSurface::Joints
                    : on == "free" ? WetSurface::Free
                                   : WetSurface::All;
    if (value.contains("towards")) water.towards = read_vector(value["towards"]);
    for (const char* key : {"between", "planes"})
      if (value.contains(key) && water.surface != WetSurface::Joints)
        throw SceneError(pointer + "/" + key, "only water in \"joints\" is between blocks");
    std::vector<char> wet(file_.scene.blocks.size(), 1);
    if (value.contains("blocks"))
      wet = match_blocks(value["blocks"], pointer + "/blocks", labels());
    water.wets = [wet = std::move(wet)](int b) { return wet[static_cast<std::size_t>(b)] != 0; };
    water.wets_joint = meant_joints(value, "between", pointer);
    doubt(value, "unit_weight", 1000.0, pointer, "N/m3: water has 9810");
    const std::size_t before = file_.scene.pressure_loads.size();
    append_water(water, laid_joints(), absent_, file_.scene);
    tell_suction(std::span(file_.scene.pressure_loads).subspan(before), pointer);
    if (file_.scene.pressure_loads.size() == before && std::ranges::count(absent_, 1) == 0)
      throw SceneError(pointer, "wets no face of a block that can move");
  }

  /// A formula that goes on above the water table is negative there, and pulls.
  void tell_suction(std::span<const solver::PressureLoad> loads, const std::string& pointer) {
    double least = 0.0, largest = 0.0;
    for (const solver::PressureLoad& load : loads) {
      for (const solver::Vector3& corner : load.corners) {
        const double pressure = load.field->value(corner, 0.0);
        least = std::min(least, pressure);
        largest = std::max(largest, std::abs(pressure));
      }
    }
    if (!(least < -1e-6 * largest)) return;
    std::ostringstream line;
    line << pointer << "/pressure: down to " << least
         << " Pa at the start, which pulls; max(0, …)?";
    file_.notes.push_back(line.str());
  }

  std::shared_ptr<const solver::PressureField> water_pressure(const json& value,
                                                              const std::string& pointer) const {
    if (value.contains("pressure") == value.contains("level"))
      throw SceneError(pointer, "needs either \"pressure\" or \"level\"");
    const bool of_level = value.contains("level");
    const char* key = of_level ? "level" : "pressure";
    const double weight = value.value("unit_weight", 9810.0);
    auto formula = std::make_shared<const Formula>(
        read_formula(value[key], pointer + "/" + key, parameters_, Formula::Clock::RunAndPlace));
    const bool steady = !formula->names_time();
    return std::make_shared<const solver::PressureField>(
        solver::PressureField{[=](const Vector3& place, double time) {
                                const double given = formula->at(place, time);
                                return of_level ? weight * std::max(0.0, given - place.z()) : given;
                              },
                              steady});
  }

  static solver::ContactIteration contact_iteration(const json& value,
                                                    solver::ContactIteration otherwise) {
    using solver::ContactIteration;
    const std::string stated = value.value("contact_iteration", name(otherwise));
    for (const auto known : {ContactIteration::OpenClose, ContactIteration::ProximalNewton})
      if (stated == name(known)) return known;
    return ContactIteration::Automatic;
  }

  void read_options() {
    solver::StepOptions& options = file_.options;
    const std::string method = document_.value("method", "augmented_lagrangian");
    for (const auto known : {solver::ContactMethod::Springs, solver::ContactMethod::Paper,
                             solver::ContactMethod::Penalty})
      if (method == name(known)) options.method = known;
    options.contact_iteration = contact_iteration(document_, options.contact_iteration);
    const std::string linear = document_.value("linear_solver", "automatic");
    for (const auto known :
         {solver::LinearSolverKind::Elimination, solver::LinearSolverKind::Multigrid})
      if (linear == name(known)) options.linear_solver = known;
    options.scheme = document_.value("scheme", "") == "energy_momentum"
                         ? solver::TimeScheme::EnergyMomentum
                         : solver::TimeScheme::ConstantAcceleration;
    const auto take = [&](const char* key, auto& option) { option = document_.value(key, option); };
    take("time_step", options.time_step);
    take("smallest_time_step", options.smallest_time_step);
    take("penalty", options.penalty);
    take("shear_ratio", options.shear_ratio);
    take("reach", options.reach);
    take("tolerance", options.tolerance);
    take("max_iterations", options.max_iterations);
    take("max_displacement_ratio", options.max_displacement_ratio);
    file_.paraview = document_.value("paraview", true);
    file_.history_every = document_.value("history_every", 1);
    if (document_.contains("end_time")) require_time_step(options.time_step, "/smallest_time_step");
  }

  /// No step is shorter than the smallest.
  void require_time_step(double time_step, const std::string& pointer) const {
    const double smallest = file_.options.smallest_time_step;
    if (smallest <= time_step) return;
    throw SceneError(pointer, "smallest time step must be at most the time step, " +
                                  shown(time_step) + " s, is " + shown(smallest) + " s");
  }

  void read_stages() {
    if (document_.contains("stages") == document_.contains("end_time")) {
      throw SceneError("", document_.contains("stages")
                               ? "\"stages\" and \"end_time\" can't both be given"
                               : "missing key \"end_time\" or \"stages\"");
    }
    if (document_.contains("end_time")) {
      require_few_steps(document_["end_time"], file_.options.time_step, "/end_time");
      file_.stages.push_back({.end_time = document_["end_time"],
                              .time_step = file_.options.time_step,
                              .contact_iteration = file_.options.contact_iteration});
    }
    find_absent();
    each("water", &Reader::read_water);
    double reached = document_.value("end_time", 0.0);
    const json& stages = stages_of(document_);
    for (std::size_t i = 0; i < stages.size(); ++i) {
      Stage stage = read_stage(stages[i], at("/stages", i), reached);
      change_scene(stages[i], at("/stages", i), stage);
      file_.stages.push_back(std::move(stage));
    }
    if (at_start_) file_.scene = *std::move(at_start_);
    file_.output_interval = document_.value("output_interval", reached / 100);
  }

  /// `reached`: where a dynamic stage begins at the latest, s; becomes where it ends.
  Stage read_stage(const json& value, const std::string& pointer, double& reached) const {
    Stage stage;
    const std::string analysis = value["analysis"];
    stage.analysis = analysis == "static"   ? solver::Analysis::Static
                     : analysis == "settle" ? solver::Analysis::Settle
                                            : solver::Analysis::Dynamic;
    stage.name = value.value("name", "");
    stage.time_step = value.value("time_step", file_.options.time_step);
    stage.contact_iteration = contact_iteration(value, file_.options.contact_iteration);
    stage.max_steps = value.value("max_steps", stage.max_steps);
    stage.unbalance = value.value("unbalance", stage.unbalance);
    stage.until_rest = value.contains("until");
    stage.until_moved = value.value("until_moved", 0.0);
    stage.reset_displacements = value.value("reset_displacements", false);
    if (value.contains("steps")) stage.steps = value["steps"].get<long>();
    const std::string on_mechanism = value.value("on_mechanism", "fail");
    stage.on_mechanism = on_mechanism == "continue" ? OnMechanism::Continue
                         : on_mechanism == "remove" ? OnMechanism::Remove
                                                    : OnMechanism::Fail;
    stage.relax = value.value("relax", 0);
    if (stage.relax > 0 && !value.contains("remove"))
      throw SceneError(pointer + "/relax", "needs \"remove\": whose forces are given back");
    if (value.contains("ramp")) {
      stage.ramp_by = value["ramp"]["by"];
      stage.ramp_to = value["ramp"]["to"];
    }
    for (const char* key : {"relax", "ramp"}) {
      if (!value.contains(key) ||
          (!stage.steps && !(value.contains("relax") && value.contains("ramp"))))
        continue;
      throw SceneError(pointer, "\"" + std::string(key) +
                                    "\" comes to rest in each part, and takes no " +
                                    (stage.steps ? "\"steps\"" : "\"ramp\""));
    }
    if (value.contains("ramp")) {
      const solver::Scene& now = file_.scene;
      const bool none = now.point_loads.empty() && now.face_loads.empty() && now.body_loads.empty();
      if (value.contains("loads") ? value["loads"].empty() : none)
        throw SceneError(pointer + "/ramp", "there are no loads that it could multiply");
    }
    require_time_step(stage.time_step,
                      value.contains("time_step") ? pointer + "/time_step" : "/smallest_time_step");
    if (stage.analysis == solver::Analysis::Dynamic) {
      read_end(value, pointer, stage, reached);
      return stage;
    }
    if (stage.steps && stage.until_rest)
      throw SceneError(pointer, "\"steps\" and \"until\" can't both be given");
    stage.until_rest = !stage.steps;
    return stage;
  }

  static void require_few_steps(double seconds, double time_step, const std::string& pointer) {
    constexpr double kMostSteps = 1e9;  // the quickest step takes 0.3 us: five minutes and more
    if (seconds / time_step <= kMostSteps) return;
    throw SceneError(pointer, json(seconds).dump() + " s are more than 1e9 steps of " +
                                  json(time_step).dump() + " s");
  }

  static void read_end(const json& value, const std::string& pointer, Stage& stage,
                       double& reached) {
    stage.end_time = value.value("end_time", 0.0);
    stage.duration = value.value("duration", 0.0);
    const int given =
        value.contains("end_time") + value.contains("duration") + value.contains("steps");
    if (given != 1) {
      throw SceneError(pointer, std::string(given == 0 ? "missing key" : "can take only one of") +
                                    " \"end_time\", \"duration\" or \"steps\"");
    }
    if (stage.end_time > 0 && !(stage.end_time > reached)) {
      throw SceneError(pointer + "/end_time",
                       "must be after " + json(reached).dump() + " s, where the stage begins");
    }
    const double start = reached;
    reached = stage.end_time > 0 ? stage.end_time
              : stage.steps      ? reached + static_cast<double>(*stage.steps) * stage.time_step
                                 : reached + stage.duration;
    require_few_steps(reached - start, stage.time_step, pointer);
  }

  static const json& stages_of(const json& document) {
    static const json none = json::array();
    return document.contains("stages") ? document["stages"] : none;
  }

  /// Blocks that a stage adds before any removes them are absent at the start.
  void find_absent() {
    absent_.assign(file_.scene.blocks.size(), 0);
    std::vector<char> known(file_.scene.blocks.size(), 0);
    const json& stages = stages_of(document_);
    for (std::size_t i = 0; i < stages.size(); ++i) {
      for (const char* key : {"remove", "add"}) {
        if (!stages[i].contains(key)) continue;
        for (const int b : blocks_named(stages[i][key], at("/stages", i) + "/" + key)) {
          const auto block = static_cast<std::size_t>(b);
          if (!known[block]) absent_[block] = key == std::string("add");
          known[block] = 1;
        }
      }
    }
  }

  /// The scene with those that are absent out of it.
  solver::Scene present(solver::Scene scene) const {
    for (std::size_t b = 0; b < scene.blocks.size(); ++b)
      if (absent_[b]) scene.blocks[b].kind = BlockKind::Absent;
    drop_unborne(scene);
    return scene;
  }

  /// What a stage says of the scene holds from then on. Its lists take the place of earlier ones.
  void change_scene(const json& value, const std::string& pointer, Stage& stage) {
    const auto given = [&](const char* key) { return value.contains(key); };
    constexpr std::array kKeys = {"gravity",      "joint",     "joints",     "loads",
                                  "fixed_points", "ties",      "water",      "remove",
                                  "add",          "overrides", "quiet_faces"};
    if (std::ranges::none_of(kKeys, given)) return;
    if (!at_start_) at_start_ = present(file_.scene);
    const auto replace = [&](const char* key, ReadOne read_one, auto&... lists) {
      if (given(key)) (lists.clear(), ...);
      each_of(value, pointer, key, read_one);
    };
    solver::Scene& scene = file_.scene;
    if (given("gravity")) scene.gravity = vector_of_time(value["gravity"], pointer + "/gravity");
    if (given("overrides")) override_blocks(value["overrides"], pointer + "/overrides", stage);
    if (given("joint")) scene.joint = joint(value["joint"], pointer + "/joint");
    replace("joints", &Reader::read_pair_joint, scene.pair_joints, scene.block_joints);
    if (given("remove")) move_blocks(value["remove"], pointer + "/remove", 1);
    if (given("add")) move_blocks(value["add"], pointer + "/add", 0);
    replace("loads", &Reader::read_load, scene.point_loads, scene.face_loads, scene.body_loads);
    replace("fixed_points", &Reader::read_fixed_point, scene.fixed_points);
    replace("ties", &Reader::read_tie, scene.ties);
    replace("quiet_faces", &Reader::read_quiet_face, scene.quiet_faces);
    replace("water", &Reader::read_water, scene.pressure_loads);
    stage.scene = std::make_shared<const solver::Scene>(present(scene));
  }

  /// Away or in. One of those that are meant at least must not be so already.
  void move_blocks(const json& names, const std::string& pointer, char absent) {
    bool any = false;
    for (const int b : blocks_named(names, pointer)) {
      any = any || absent_[static_cast<std::size_t>(b)] != absent;
      absent_[static_cast<std::size_t>(b)] = absent;
    }
    if (!any) {
      throw SceneError(pointer, absent != 0 ? "none of these blocks is there"
                                            : "all of these blocks are there already");
    }
  }

  void override_blocks(const json& overrides, const std::string& pointer, Stage& stage) {
    const auto numbers = match_overrides(overrides, pointer, labels(), parameters_);
    for (std::size_t b = 0; b < numbers.size(); ++b) {
      for (const int number : numbers[b]) {
        const auto i = static_cast<std::size_t>(number);
        override_in_stage(overrides[i], at(pointer, i), static_cast<int>(b), stage);
      }
    }
  }

  void read_monitor(const json& value, const std::string& pointer) {
    Monitor monitor{.name = value["name"]};
    if (value.contains("contact")) {
      monitor.kind = Monitor::Kind::Contact;
      monitor.others = blocks_named(value["contact"][0], pointer + "/contact/0");
      monitor.blocks = blocks_named(value["contact"][1], pointer + "/contact/1");
      if (value.contains("about")) monitor.about = read_vector(value["about"]);
    } else if (value.contains("blocks")) {
      monitor.kind = Monitor::Kind::Group;
      monitor.blocks = blocks_named(value["blocks"], pointer + "/blocks");
    } else if (value.contains("fixed_points")) {
      monitor.kind = Monitor::Kind::FixedPoints;
      monitor.fixed_points = fixed_points_named(value["fixed_points"], pointer + "/fixed_points");
    } else {
      monitor.blocks = {block_named(value["block"], pointer + "/block")};
      if (value.contains("point")) monitor.point = read_vector(value["point"]);
      if (value.contains("relative_to"))
        monitor.relative_to = block_named(value["relative_to"], pointer + "/relative_to");
    }
    const bool taken = std::any_of(file_.monitors.begin(), file_.monitors.end(),
                                   [&](const Monitor& m) { return m.name == monitor.name; });
    if (taken)
      throw SceneError(pointer + "/name", "there are two monitors named " + shown(value["name"]));
    file_.monitors.push_back(std::move(monitor));
  }

  /// Names of the fixed points of all stages that are meant, ascending.
  std::vector<std::string> fixed_points_named(const json& names, const std::string& pointer) const {
    std::vector<BlockLabel> known;  // by its own name or its block's
    const auto add_all = [&](const solver::Scene& scene) {
      for (const solver::FixedPoint& point : scene.fixed_points) {
        const std::string& block = scene.blocks[static_cast<std::size_t>(point.block)].name;
        known.push_back({.name = point.name, .file_name = block});
      }
    };
    add_all(file_.scene);
    for (const Stage& stage : file_.stages)
      if (stage.scene) add_all(*stage.scene);
    const std::vector<char> meant = match_blocks(names, pointer, known, "fixed point");
    std::set<std::string> result;
    for (std::size_t i = 0; i < known.size(); ++i)
      if (meant[i]) result.emplace(known[i].name);
    return {result.begin(), result.end()};
  }

  static Quantity quantity(const std::string& name) {
    static constexpr std::array kNames = {
        // in the order of Quantity
        "displacement",       "velocity", "rotation",         "angular_velocity", "force", "moment",
        "centre_of_pressure", "momentum", "angular_momentum", "stress",           "strain"};
    return static_cast<Quantity>(std::ranges::find(kNames, name) - kNames.begin());
  }

  static bool shows(Monitor::Kind kind, Quantity quantity) {
    switch (kind) {
      case Monitor::Kind::Contact:
        return quantity >= Quantity::Force && quantity <= Quantity::CentreOfPressure;
      case Monitor::Kind::FixedPoints:
        return quantity == Quantity::Force;
      case Monitor::Kind::Group:
        return quantity >= Quantity::Momentum;
      case Monitor::Kind::Point:
        break;
    }
    return quantity < Quantity::Force;
  }

  void read_reference(const json& value, const std::string& pointer) {
    Reference reference{.name = value.value("name", value["quantity"].get<std::string>()),
                        .quantity = quantity(value["quantity"])};
    const auto found = std::find_if(file_.monitors.begin(), file_.monitors.end(),
                                    [&](const Monitor& m) { return m.name == value["monitor"]; });
    if (found == file_.monitors.end())
      throw SceneError(pointer + "/monitor", "there is no monitor " + shown(value["monitor"]));
    reference.monitor = static_cast<int>(found - file_.monitors.begin());
    if (!shows(found->kind, reference.quantity)) {
      throw SceneError(pointer + "/quantity", "monitor " + value["monitor"].dump() + " has no " +
                                                  value["quantity"].get<std::string>());
    }
    read_component(value, pointer, reference);
    read_exact(value["exact"], pointer + "/exact", reference);
    reference.from = value.value("from", 0.0);
    reference.until = value.value("until", std::numeric_limits<double>::infinity());
    reference.allowed = value.value("allowed", 0.0);
    file_.references.push_back(std::move(reference));
  }

  static void read_component(const json& value, const std::string& pointer, Reference& reference) {
    using Component = Reference::Component;
    if (value.contains("component") && value.contains("along"))
      throw SceneError(pointer, "\"component\" and \"along\" can't both be given");
    const std::string component = value.value("component", "");
    const bool tensor =
        reference.quantity == Quantity::Stress || reference.quantity == Quantity::Strain;
    if (tensor != (component.size() == 2)) {
      throw SceneError(pointer, std::string(tensor ? "needs" : "can't have") +
                                    " a \"component\" of xx, yy, zz, xy, yz, zx");
    }
    if (tensor) {
      reference.component = Component::Along;
      const std::array<const char*, 6> names = {"xx", "yy", "zz", "xy", "yz", "zx"};
      reference.tensor_component = std::ranges::find(names, component) - names.begin();
      return;
    }
    if (component == "magnitude") {
      reference.component = Component::Magnitude;
    } else if (!component.empty()) {
      reference.component = Component::Along;
      reference.direction = Vector3::Unit(component[0] - 'x');
    } else if (value.contains("along")) {
      reference.component = Component::Along;
      const Vector3 along = read_vector(value["along"]);
      if (!(along.norm() > 0)) throw SceneError(pointer + "/along", "must not be zero");
      reference.direction = along.normalized();
    }
  }

  void read_exact(const json& exact, const std::string& pointer, Reference& reference) const {
    const std::size_t wanted = reference.component == Reference::Component::Vector ? 3 : 1;
    std::size_t given = exact.is_array() ? exact.size() : 1;
    if (exact.is_object()) {
      check_ascending(exact["table"], pointer + "/table");
      reference.table = exact["table"];
      for (const std::vector<double>& row : reference.table) {
        given = row.size() - 1;
        if (given != wanted) break;
      }
    } else if (exact.is_array()) {
      for (std::size_t i = 0; i < exact.size(); ++i)
        reference.formulas.push_back(read_formula(exact[i], at(pointer, i), parameters_));
    } else {
      reference.formulas.push_back(read_formula(exact, pointer, parameters_));
    }
    if (given != wanted) {
      throw SceneError(pointer, "must give " + std::to_string(wanted) +
                                    (wanted == 1 ? " value" : " values") + ", gives " +
                                    std::to_string(given));
    }
  }

  const json& document_;
  std::string folder_;
  Parameters parameters_;
  SceneFile file_;
  std::map<std::string, solver::Material> materials_;
  std::map<std::string, int> joint_groups_;
  std::map<std::string, int> index_of_;
  std::map<std::string, Solid> shapes_;                  // by what is stated
  std::vector<Entry> entries_;                           ///< of each block
  std::map<std::string, std::vector<NamedFace>> faces_;  ///< of blocks whose shapes name planes
  std::optional<std::vector<StartJoint>> laid_joints_;
  std::vector<std::string> files_without_support_;
  mutable std::vector<std::string> records_;                     ///< files of functions of time
  mutable std::vector<std::pair<std::string, double>> sampled_;  ///< records, mean interval, s
  SharedTopologies topologies_;
  double taken_ = 0.0;  ///< of the file at hand: the deepest surface that is taken for convex, m
  std::optional<solver::Scene> at_start_;  ///< kept as soon as a stage changes the scene
  std::vector<char> absent_;               ///< by block: in the stage that is being read
};

}  // namespace

Eigen::VectorXd Reference::exact(double time) const {
  if (!formulas.empty()) {
    Eigen::VectorXd value(static_cast<Eigen::Index>(formulas.size()));
    for (std::size_t i = 0; i < formulas.size(); ++i)
      value[static_cast<Eigen::Index>(i)] = formulas[i].at(time);
    return value;
  }
  const auto after = std::find_if(table.begin(), table.end(),
                                  [&](const std::vector<double>& row) { return row[0] >= time; });
  const auto row = [](const std::vector<double>& values) {
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(values.data() + 1, std::ssize(values) - 1));
  };
  if (after == table.begin() || after == table.end())
    return row(after == table.begin() ? table.front() : table.back());
  const auto before = after - 1;
  const double share = (time - (*before)[0]) / ((*after)[0] - (*before)[0]);
  return (1 - share) * row(*before) + share * row(*after);
}

const solver::Scene& SceneFile::scene_in(std::size_t stage) const {
  for (std::size_t i = stage + 1; i-- > 0;)
    if (stages[i].scene) return *stages[i].scene;
  return scene;
}

namespace {

SceneFile read_document(json document, const std::string& folder,
                        const std::vector<std::string>& changes) {
  const Parameters parameters = expand(document, changes);
  check_schema(json::parse(scene_schema()), document);
  const std::vector<std::string> notes = expand_cut(document);
  if (!document.contains("blocks")) throw SceneError("", "missing key \"blocks\"");
  SceneFile file = Reader(document, folder, parameters).read();
  file.notes.insert(file.notes.begin(), notes.begin(), notes.end());
  return file;
}

}  // namespace

SceneFile parse_scene(const std::string& text, const std::string& folder,
                      const std::vector<std::string>& changes) {
  return read_document(parse_json(text), folder, changes);
}

SceneFile read_scene(const std::string& path, const std::vector<std::string>& changes) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  SceneFile file = read_document(read_json(path), folder, changes);
  file.sources.insert(file.sources.begin(), path);
  return file;
}

}  // namespace quoin::scene_file
