#include "run_files.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver/output.hpp>

#include "scene_file/archive.hpp"
#include "scene_file/mechanism_proof.hpp"
#include "scene_file/peak_memory.hpp"
#include "scene_file/printable.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using scene_file::Monitor;
using scene_file::MonitorValue;
using scene_file::ReferenceResult;
using scene_file::RunResult;
using scene_file::SceneFile;
using scene_file::StepView;
using solver::Analysis;
using solver::BlockKind;
using solver::EnergyLedger;
using solver::Vector3;

json vector(const Eigen::VectorXd& value) {
  return std::vector<double>(value.begin(), value.end());
}

std::string numbered(const char* stem, std::size_t number, const char* extension) {
  const std::string digits = std::to_string(number);
  const std::string zeros(6 - std::min<std::size_t>(6, digits.size()), '0');
  return stem + ("_" + zeros) + digits + "." + extension;
}

/// Files of which each frame has one, in ParaView's forms.
constexpr std::pair<const char*, const char*> kFrames[] = {
    {"blocks", "vtu"}, {"contacts", "vtp"}, {"ties", "vtp"}};

const char* name(Analysis analysis) {
  return analysis == Analysis::Dynamic  ? "dynamic"
         : analysis == Analysis::Static ? "static"
                                        : "settle";
}

json name(scene_file::StageEnd end) {
  static constexpr const char* kNames[] = {"rest", "moved", "steps", "time"};
  return end == scene_file::StageEnd::None ? json() : json(kNames[static_cast<int>(end) - 1]);
}

json options_json(const solver::StepOptions& options, int threads) {
  const bool exact = options.method == solver::ContactMethod::AugmentedLagrangian;
  const bool energy_momentum = options.scheme == solver::TimeScheme::EnergyMomentum;
  return {{"method", name(options.method)},
          {"penalty", exact                 ? json("not used")
                      : options.penalty > 0 ? json(options.penalty)
                                            : json("chosen by the solver")},
          {"scheme", energy_momentum ? "energy_momentum" : "constant_acceleration"},
          {"time_step", options.time_step},
          {"tolerance", options.tolerance},
          {"threads", threads}};
}

/// Of the last stage, without what a mechanism has had removed.
json blocks_json(const SceneFile& file, const RunResult& result) {
  solver::Scene scene = file.scene_in(result.stages.size() - 1);
  for (const scene_file::LooseBlock& loose : result.loose)
    if (loose.removed) scene.blocks[static_cast<std::size_t>(loose.block)].kind = BlockKind::Absent;
  int count[5] = {0, 0, 0, 0, 0};
  Vector3 weight = Vector3::Zero();
  for (const solver::Block& block : scene.blocks) {
    ++count[static_cast<int>(block.kind)];
    if (block.kind == BlockKind::Deformable || block.kind == BlockKind::Rigid) {
      weight += block.material.density * geometry::mass_properties(block.body()).volume *
                scene.gravity.at(result.time);
    }
  }
  return {{"deformable", count[0]}, {"rigid", count[1]},  {"fixed", count[2]},
          {"prescribed", count[3]}, {"absent", count[4]}, {"weight", vector(weight)}};
}

json references_json(const SceneFile& file, const RunResult& result) {
  json list = json::array();
  for (std::size_t r = 0; r < file.references.size(); ++r) {
    const ReferenceResult& compared = result.references[r];
    const double allowed = file.references[r].allowed;
    list.push_back(
        {{"name", file.references[r].name},
         {"monitor", file.monitors[static_cast<std::size_t>(file.references[r].monitor)].name},
         {"value", vector(compared.value)},
         {"exact", vector(compared.exact)},
         {"error", compared.error},
         {"error_end", compared.error_end},
         {"allowed", allowed > 0 ? json(allowed) : json()},
         {"ok", compared.ok},
         {"steps_compared", compared.compared}});
  }
  return list;
}

/// A part of what a monitor shows.
struct Shown {
  const char* name;    ///< in summary.json
  const char* column;  ///< in history.csv, before the axes
  std::span<const double> value;
};

std::vector<Shown> shown(Monitor::Kind kind, const MonitorValue& value) {
  const auto all = [](const auto& of) {
    return std::span(of.data(), std::size_t{of.SizeAtCompileTime});
  };
  switch (kind) {
    case Monitor::Kind::Contact:
      return {{"force", "f", all(value.force)},
              {"normal_force", "normal_force", {&value.normal_force, 1}},
              {"moment", "m", all(value.moment)},
              {"centre_of_pressure", "c", all(value.centre_of_pressure)}};
    case Monitor::Kind::Group:
      return {{"momentum", "p", all(value.momentum)},
              {"angular_momentum", "l", all(value.angular_momentum)},
              {"stress", "stress_", all(value.stress)},
              {"strain", "strain_", all(value.strain)}};
    case Monitor::Kind::FixedPoints:
      return {{"force", "f", all(value.force)}};
    case Monitor::Kind::Point:
      break;
  }
  return {{"displacement", "u", all(value.displacement)},
          {"velocity", "v", all(value.velocity)},
          {"rotation", "r", all(value.rotation)},
          {"angular_velocity", "w", all(value.angular_velocity)}};
}

json monitors_json(const SceneFile& file, const RunResult& result) {
  json all = json::object();
  for (std::size_t m = 0; m < file.monitors.size(); ++m) {
    json& parts = all[file.monitors[m].name];
    for (const Shown& part : shown(file.monitors[m].kind, result.monitors[m]))
      parts[part.name] = part.value.size() == 1 ? json(part.value[0]) : json(part.value);
  }
  return all;
}

json energy_json(const RunResult& result) {
  const EnergyLedger& start = result.energy_start;
  const EnergyLedger& end = result.energy;
  return {{"kinetic", end.kinetic},
          {"potential", end.potential},
          {"strain", end.strain},
          {"contact", end.contact},
          {"work", end.work},
          {"friction_loss", end.friction_loss},
          {"impact_loss", end.impact_loss},
          {"algorithmic_loss", end.algorithmic_loss},
          {"mechanical_start", start.mechanical()},
          {"mechanical_end", end.mechanical()},
          {"closure", end.closure - start.closure},
          {"scale", result.energy_scale},
          {"growth", result.energy_growth}};
}

/// Its number where it has no name.
json block_name(const SceneFile& file, int block) {
  const std::string& name = file.scene.blocks[static_cast<std::size_t>(block)].name;
  return name.empty() ? json(block) : json(name);
}

json stages_json(const SceneFile& file, const RunResult& result) {
  json list = json::array();
  for (std::size_t i = 0; i < result.stages.size(); ++i) {
    const scene_file::StageResult& stage = result.stages[i];
    json entry = {{"name", file.stages[i].name}, {"analysis", name(stage.analysis)},
                  {"steps", stage.steps},        {"unbalance", stage.unbalance},
                  {"ended_by", name(stage.end)}, {"done", stage.done}};
    if (stage.analysis != Analysis::Dynamic) {
      entry["verdict"] = stage.admissible ? "admissible" : name(stage.verdict);
      entry["travel"] = stage.travel;
      entry["travel_block"] =
          stage.travel_block >= 0 ? block_name(file, stage.travel_block) : json();
    }
    if (file.stages[i].ramp_to > 0) entry["load_factor"] = stage.load_factor;
    for (const scene_file::LooseBlock& loose : result.loose) {
      if (loose.stage != static_cast<int>(i)) continue;
      entry[loose.removed ? "removed" : "loose"].push_back(block_name(file, loose.block));
    }
    list.push_back(std::move(entry));
  }
  return list;
}

/// What proves that the last static stage has no equilibrium; null: nothing does.
json proof_json(const RunResult& result) {
  if (!result.proof) return nullptr;
  const solver::Equilibrium& found = result.proof->found;
  return {{"power", found.power},
          {"dissipation", found.dissipation},
          {"incompatibility", found.incompatibility},
          {"factorizations", found.factorizations}};
}

json linear_json(const solver::LinearSolverCounts& counts) {
  return {{"eliminations", counts.eliminations},
          {"distributed", counts.distributed},
          {"multigrid_set_ups", counts.set_ups},
          {"multigrid_iterations", counts.iterations},
          {"fallbacks", counts.fallbacks}};
}

json system_json(const solver::StepReport& total) {
  const double digits =
      total.condition > 0 ? std::max(0.0, 15.95 - std::log10(total.condition)) : 15.95;
  return {{"condition", total.condition},
          {"digits_left", digits},
          {"stiffest_omega_dt", total.stiffest_omega_dt},
          {"numerical_damping", total.numerical_damping},
          {"largest_strain", total.largest_strain},
          {"largest_speed", total.largest_speed}};
}

json flags_json(const SceneFile& file, const RunResult& result) {
  json list = json::array();
  for (const scene_file::RunFlag& flag : result.flags) {
    json blocks = json::array();
    for (const int block : {flag.worst.block, flag.worst.other}) {
      if (block < 0) continue;
      blocks.push_back(block_name(file, block));
    }
    list.push_back({{"flag", solver::name(flag.worst.kind)},
                    {"value", flag.worst.value},
                    {"limit", flag.worst.limit},
                    {"blocks", blocks},
                    {"first_time", flag.first_time},
                    {"steps", flag.steps},
                    {"fails", flag.fails}});
  }
  return list;
}

json phases_json(const RunResult& result) {
  const solver::PhaseSeconds& seconds = result.total.seconds;
  const double stepping = seconds.detect + seconds.assemble + seconds.solve + seconds.update;
  return {{"detect", seconds.detect},
          {"assemble", seconds.assemble},
          {"solve", seconds.solve},
          {"update", seconds.update},
          {"rest", result.wall_seconds - stepping}};
}

}  // namespace

namespace {

constexpr const char* kHistory = "history.csv";
constexpr const char* kBlocks = "blocks.csv";
constexpr const char* kContacts = "contacts.csv";
constexpr const char* kJoints = "joints.csv";

const char* axes(const Shown& part, std::size_t i) {
  static constexpr const char* kVector[] = {"x", "y", "z"};
  static constexpr const char* kTensor[] = {"xx", "yy", "zz", "xy", "yz", "zx"};
  return part.value.size() == 1 ? "" : part.value.size() == 3 ? kVector[i] : kTensor[i];
}

std::string history_head(const SceneFile& file) {
  std::string head = "step,stage,time";
  const MonitorValue none;
  for (const Monitor& monitor : file.monitors) {
    for (const Shown& part : shown(monitor.kind, none)) {
      for (std::size_t i = 0; i < part.value.size(); ++i)
        head += ',' + scene_file::csv_field(monitor.name + "." + part.column + axes(part, i));
    }
  }
  return head +
         ",kinetic,potential,strain,contact,work,friction_loss,impact_loss,algorithmic_loss,"
         "contacts,closed,largest_overlap,unbalance,sub_steps,iterations,linear_solves";
}

constexpr const char* kBlocksHead =
    "stage,time,block,name,kind,material,volume,mass,x,y,z,ux,uy,uz,rx,ry,rz,vx,vy,vz,wx,wy,wz,"
    "stress_xx,stress_yy,stress_zz,stress_xy,stress_yz,stress_zx,stress_1,stress_2,stress_3";

constexpr const char* kContactsHead =
    "stage,time,a,b,name_a,name_b,type,state,failed,x,y,z,nx,ny,nz,gap,area,slip,normal_force,"
    "shear_force,normal_stress,shear_stress,fx,fy,fz";

constexpr const char* kTies = "ties.csv";
constexpr const char* kTiesHead = "step,stage,time,name,length,force,plastic,state";

bool has_ties(const SceneFile& file) {
  return !file.scene.ties.empty() || std::ranges::any_of(file.stages, [](const auto& stage) {
    return stage.scene && !stage.scene->ties.empty();
  });
}

constexpr const char* kJointsHead =
    "stage,time,a,b,name_a,name_b,state,points,closed,gap,area,x,y,z,nx,ny,nz,normal_force,"
    "shear_force,normal_stress,edge_stress,fx,fy,fz,mx,my,mz";

const char* name(BlockKind kind) {
  static constexpr const char* kNames[] = {"deformable", "rigid", "fixed", "prescribed", "absent"};
  return kNames[static_cast<int>(kind)];
}

const char* name(solver::ContactMode mode) {
  static constexpr const char* kNames[] = {"open", "stick", "slip"};
  return kNames[static_cast<int>(mode)];
}

Vector3 principal(const solver::Vector6& s) {
  geometry::Matrix3 tensor;
  tensor << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  const Eigen::SelfAdjointEigenSolver<geometry::Matrix3> solver(tensor, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().reverse();  // the largest first
}

Vector3 rotation_vector(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turned(rotation);
  return turned.angle() * turned.axis();
}

/// At the end.
json ties_json(const SceneFile& file, const RunResult& result) {
  json all = json::array();
  const auto& ties = file.scene_in(result.stages.size() - 1).ties;
  for (std::size_t t = 0; t < ties.size() && t < result.ties.size(); ++t) {
    const solver::TieState& tie = result.ties[t];
    all.push_back({{"name", ties[t].name},
                   {"length", tie.length},
                   {"force", tie.force},
                   {"plastic", tie.plastic},
                   {"broken", tie.broken}});
  }
  return all;
}

}  // namespace

RunFiles::RunFiles(OutputFolder& folder, const SceneFile& file, FileShare share)
    : folder_(folder), file_(file), share_(std::move(share)) {
  if (share_.rank > 0) return;
  history_.emplace(folder_.file(kHistory), history_head(file_));
  blocks_.emplace(folder_.file(kBlocks), kBlocksHead);
  contacts_.emplace(folder_.file(kContacts), kContactsHead);
  joints_.emplace(folder_.file(kJoints), kJointsHead);
  if (has_ties(file_)) ties_.emplace(folder_.file(kTies), kTiesHead);
}

RunFiles::RunFiles(OutputFolder& folder, const SceneFile& file, std::istream& resume)
    : folder_(folder), file_(file) {
  std::uintmax_t history = 0, blocks = 0, contacts = 0, joints = 0, ties = 0;
  scene_file::ArchiveReader archive(resume);
  archive(steps_, frame_step_, times_, joined_, history, blocks, contacts, joints, ties);
  history_.emplace(folder_.file(kHistory), history);
  blocks_.emplace(folder_.file(kBlocks), blocks);
  contacts_.emplace(folder_.file(kContacts), contacts);
  joints_.emplace(folder_.file(kJoints), joints);
  if (has_ties(file_)) ties_.emplace(folder_.file(kTies), ties);
  remove_later_frames();
}

/// Those that a killed run wrote after its last checkpoint.
void RunFiles::remove_later_frames() {
  std::error_code ignored;
  for (std::size_t number = times_.size();; ++number) {
    std::uintmax_t removed = 0;
    for (const auto& [stem, extension] : kFrames)
      removed +=
          std::filesystem::remove(folder_.path() / numbered(stem, number, extension), ignored);
    if (removed == 0) return;
  }
}

void RunFiles::save(std::ostream& out) {
  scene_file::ArchiveWriter archive(out);
  archive(steps_, frame_step_, times_, joined_, history_->length(), blocks_->length(),
          contacts_->length(), joints_->length(), ties_ ? ties_->length() : std::uintmax_t{0});
}

void RunFiles::write_history_line(const StepView& view) {
  if (!history_) return;
  history_->number(steps_).number(static_cast<long>(view.stage)).number(view.dynamic_time);
  for (std::size_t m = 0; m < view.monitors.size(); ++m) {
    for (const Shown& part : shown(file_.monitors[m].kind, view.monitors[m]))
      for (const double value : part.value) history_->number(value);
  }
  const EnergyLedger& energy = view.simulation.state().energy;
  for (const double joule :
       {energy.kinetic, energy.potential, energy.strain, energy.contact, energy.work,
        energy.friction_loss, energy.impact_loss, energy.algorithmic_loss})
    history_->number(joule);
  for (const int count : {view.report.contact_count, view.report.closed_count})
    history_->number(static_cast<long>(count));
  history_->number(view.report.largest_overlap).number(view.report.unbalance);
  for (const int count : {view.report.sub_steps, view.report.iterations, view.report.linear_solves})
    history_->number(static_cast<long>(count));
  history_->end_line();
  write_ties(view);
}

void RunFiles::write_ties(const StepView& view) {
  if (!ties_) return;
  const std::vector<solver::Tie>& ties = view.simulation.scene().ties;
  for (std::size_t t = 0; t < ties.size(); ++t) {
    const solver::TieState& now = view.simulation.state().ties[t];
    const double size = std::abs(now.force);
    ties_->number(steps_).number(static_cast<long>(view.stage)).number(view.dynamic_time);
    ties_->text(ties[t].name).number(now.length).number(now.force).number(now.plastic);
    ties_->text(now.broken                    ? "broken"
                : size >= ties[t].yield_force ? "yields"
                : size > 0.0                  ? "elastic"
                                              : "slack");
    ties_->end_line();
  }
}

void RunFiles::start(const StepView& view) {
  write_history_line(view);
  write_vtk(view);
}

bool RunFiles::is_due(const StepView& view) const {
  const scene_file::Stage& stage = file_.stages[view.stage];
  if (stage.analysis != Analysis::Dynamic) return false;
  const double slack = 1e-6 * stage.time_step;
  const double before = view.dynamic_time - view.simulation.options().time_step;
  return std::floor((view.dynamic_time + slack) / file_.output_interval) >
         std::floor((before + slack) / file_.output_interval);
}

void RunFiles::step(const StepView& view) {
  if (++steps_ == 1) append_joined(view.simulation.state().contacts, joined_);
  if (steps_ % file_.history_every == 0) write_history_line(view);
  if (is_due(view)) write_vtk(view);
}

void RunFiles::end_stage(const StepView& view) {
  if (frame_step_ != steps_) write_vtk(view);
  write_blocks(view);
  write_contacts(view);
}

namespace {

/// From one centroid to another, m.
Vector3 between(const solver::BlockState& from, const solver::BlockState& to) {
  return (to.centroid - from.centroid) + (to.centroid_rest - from.centroid_rest);
}

}  // namespace

void RunFiles::write_blocks(const StepView& view) {
  if (!blocks_) return;
  const solver::State& state = view.simulation.state();
  const std::vector<solver::Block>& blocks = view.simulation.scene().blocks;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const geometry::MassProperties start = geometry::mass_properties(blocks[b].body());
    const solver::BlockState& now = state.blocks[b];
    const Vector3 place = state.origin + now.centroid;
    const bool reset = !view.counted_from.empty();
    const Vector3 moved = reset
                              ? between(view.counted_from[b], now)
                              : view.simulation.displacement(static_cast<int>(b), Vector3::Zero());
    Eigen::Quaterniond turned(now.rotation);
    if (reset) turned = turned * view.counted_from[b].rotation.conjugate();
    const solver::Vector6 stress = view.simulation.stress(static_cast<int>(b));
    blocks_->number(static_cast<long>(view.stage)).number(view.dynamic_time);
    blocks_->number(static_cast<long>(b)).text(blocks[b].name).text(name(blocks[b].kind));
    blocks_->text(blocks[b].material.name).number(start.volume);
    blocks_->number(start.volume * blocks[b].material.density).numbers(place);
    blocks_->numbers(moved).numbers(rotation_vector(turned));
    blocks_->numbers(now.velocity).numbers(now.rotation * now.angular_velocity);
    blocks_->numbers(stress).numbers(principal(stress)).end_line();
  }
  blocks_->flush();
}

namespace {

/// Stage, time, and two blocks by number and name.
void start_line(CsvFile& file, const StepView& view, std::initializer_list<int> pair) {
  file.number(static_cast<long>(view.stage)).number(view.dynamic_time);
  for (const int block : pair) file.number(static_cast<long>(block));
  for (const int block : pair)
    file.text(view.simulation.scene().blocks[static_cast<std::size_t>(block)].name);
}

}  // namespace

void RunFiles::write_contacts(const StepView& view) {
  const solver::State& state = view.simulation.state();
  if (!contacts_) return;
  std::vector<solver::Contact> all = state.contacts;
  append_joined(all, joined_);
  std::ranges::move(parted_contacts(view.simulation, joined_, all), std::back_inserter(all));
  std::ranges::stable_sort(all, {}, [](const solver::Contact& contact) {
    return JointedPair{contact.point.key.a, contact.point.key.b};
  });
  write_joints(view, all);
  for (const solver::Contact& contact : all) {
    const geometry::ContactPoint& point = contact.point;
    const double shear = contact.shear_force.norm();
    start_line(*contacts_, view, {point.key.a, point.key.b});
    contacts_->text(geometry::name(point.type)).text(name(contact.mode));
    contacts_->number(long{solver::has_failed(view.simulation.scene(), contact)});
    contacts_->numbers(state.origin + point.point());
    contacts_->numbers(point.normal).number(point.gap).number(contact.area()).number(contact.slip);
    contacts_->number(contact.normal_force).number(shear);
    for (const double force : {contact.normal_force, shear})
      contact.area() > 0 ? contacts_->number(force / contact.area()) : contacts_->text("");
    contacts_->numbers(contact.normal_force * point.normal - contact.shear_force).end_line();
  }
  contacts_->flush();
}

void RunFiles::write_joints(const StepView& view, std::span<const solver::Contact> contacts) {
  const Vector3& origin = view.simulation.state().origin;
  for (const JointSum& joint : sums_by_joint(contacts)) {
    start_line(*joints_, view, {joint.a, joint.b});
    joints_->text(joint.closed > 0 ? "closed" : "open").number(static_cast<long>(joint.points));
    joints_->number(static_cast<long>(joint.closed)).number(joint.gap).number(joint.area);
    joints_->numbers(origin + joint.centre).numbers(joint.normal).number(joint.normal_force);
    const Vector3 shear = joint.force - joint.force.dot(joint.normal) * joint.normal;
    joints_->number(shear.norm());
    joint.area > 0 ? joints_->number(joint.normal_force / joint.area) : joints_->text("");
    joint.edge_stress >= 0 ? joints_->number(joint.edge_stress) : joints_->text("");
    joints_->numbers(joint.force).numbers(joint.moment).end_line();
  }
  joints_->flush();
}

/// ParaView shows one frame a time, and static stages take none: each further frame of a time
/// stands a thousandth of the output interval later (a second, where nothing is dynamic).
double RunFiles::frame_time(double time) const {
  if (times_.empty() || times_.back() < time) return time;
  return times_.back() + (file_.output_interval > 0 ? 1e-3 * file_.output_interval : 1.0);
}

namespace {

/// "blocks_000012.vtu" -> "blocks_000012_3.vtu".
std::string piece_name(const std::string& file, int rank) {
  const std::size_t dot = file.rfind('.');
  return file.substr(0, dot) + "_" + std::to_string(rank) + file.substr(dot);
}

}  // namespace

void RunFiles::write_vtk(const StepView& view) {
  if (!file_.paraview) return;
  frame_step_ = steps_;
  times_.push_back(frame_time(view.simulation.state().time));
  share_.count > 1 ? write_pieces(view) : write_frame(view);
  if (share_.rank > 0) return;
  for (const auto& [stem, extension] : kFrames) {
    if (stem == std::string_view("ties") && !ties_) continue;
    std::vector<std::string> names;
    const std::string ending = (share_.count > 1 ? "p" : "") + std::string(extension);
    for (std::size_t number = 0; number < times_.size(); ++number)
      names.push_back(numbered(stem, number, ending.c_str()));
    solver::write_series(folder_.file(stem + std::string(".pvd")).string(), times_, names);
  }
}

void RunFiles::write_frame(const StepView& view) {
  const std::size_t number = times_.size() - 1;
  solver::write_blocks(folder_.file(numbered("blocks", number, "vtu")).string(), view.simulation,
                       view.counted_from);
  solver::write_contacts(folder_.file(numbered("contacts", number, "vtp")).string(),
                         view.simulation);
  if (ties_)
    solver::write_ties(folder_.file(numbered("ties", number, "vtp")).string(), view.simulation);
}

void RunFiles::write_pieces(const StepView& view) {
  const std::size_t number = times_.size() - 1;
  const auto pieces_of = [&](const char* stem, const char* extension) {
    std::vector<std::string> names;
    for (int rank = 0; rank < share_.count; ++rank) {
      names.push_back(piece_name(numbered(stem, number, extension), rank));
      // All are the folder's of the first rank, also those that other processes write.
      if (share_.rank == 0) folder_.file(names.back());
    }
    return names;
  };
  const std::vector<std::string> blocks = pieces_of("blocks", "vtu");
  const std::vector<std::string> contacts = pieces_of("contacts", "vtp");
  const auto mine = static_cast<std::size_t>(share_.rank);
  const solver::Piece piece{share_.rank_of_block, share_.rank};
  solver::write_blocks(folder_.file(blocks[mine]).string(), view.simulation, view.counted_from,
                       piece);
  solver::write_contacts(folder_.file(contacts[mine]).string(), view.simulation, piece);
  if (share_.rank > 0) return;
  solver::write_index(folder_.file(numbered("blocks", number, "pvtu")).string(), blocks);
  solver::write_index(folder_.file(numbered("contacts", number, "pvtp")).string(), contacts);
}

void RunFiles::finish() {
  for (std::optional<CsvFile>* file : {&history_, &blocks_, &contacts_, &joints_, &ties_})
    if (*file) (*file)->flush();
}

json summary(const SceneFile& file, const std::string& path, const RunResult& result) {
  const std::vector<std::string> failed = failures(file, result);
  const solver::StepReport& total = result.total;
  const double steps = static_cast<double>(std::max(1L, result.steps));
  return {{"quoin", QUOIN_VERSION},
          {"scene", path},
          {"title", file.title},
          {"status", name(result.status)},
          {"message", result.message.empty() && !failed.empty() ? failed.front() : result.message},
          {"verdict", failed.empty() ? "ok" : "failed"},
          {"failures", failed},
          {"options", options_json(file.options, result.threads)},
          {"blocks", blocks_json(file, result)},
          {"stages", stages_json(file, result)},
          {"proof", proof_json(result)},
          {"steps", result.steps},
          {"sub_steps", total.sub_steps},
          {"unconverged_steps", result.unconverged_steps},
          {"flags", flags_json(file, result)},
          {"cuts",
           {{"by_displacement", total.cuts_by_displacement},
            {"by_convergence", total.cuts_by_convergence},
            {"by_contact", total.cuts_by_contact}}},
          {"time", result.time},
          {"dynamic_time", result.dynamic_time},
          {"wall_seconds", result.wall_seconds},
          {"seconds", phases_json(result)},
          {"peak_memory_mb", scene_file::peak_memory_mb()},
          {"references", references_json(file, result)},
          {"monitors", monitors_json(file, result)},
          {"largest_overlap", total.largest_overlap},
          {"pairs", {{"candidates", total.candidate_pairs}, {"searched", total.searched_pairs}}},
          {"contacts", {{"watched", total.contact_count}, {"closed", total.closed_count}}},
          {"base_reaction", vector(result.base_reaction)},
          {"ties", ties_json(file, result)},
          {"unbalance", total.unbalance},
          {"energy", energy_json(result)},
          {"open_close_iterations", total.iterations},
          {"linear_solves", total.linear_solves},
          {"linear_solves_per_step", static_cast<double>(total.linear_solves) / steps},
          {"factorizations", total.factorizations},
          {"linear_solver", linear_json(total.linear)},
          {"proximal_newton_attempts", total.proximal_newton_attempts},
          {"largest_residual", total.residual},
          {"system", system_json(total)},
          {"left_out", result.left_out}};
}

}  // namespace quoin::commands
