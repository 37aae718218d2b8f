#include "run_files.hpp"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver/output.hpp>

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

void put(std::ostream& out, double value) {
  char digits[32];
  out.write(digits, std::to_chars(digits, digits + sizeof digits, value).ptr - digits);
}

void put(std::ostream& out, const Vector3& value) {
  for (const double component : value) {
    put(out << ',', component);
  }
}

json vector(const Eigen::VectorXd& value) {
  return std::vector<double>(value.begin(), value.end());
}

std::string numbered(const char* stem, std::size_t number, const char* extension) {
  const std::string digits = std::to_string(number);
  return stem + std::string(6 - std::min<std::size_t>(6, digits.size()), '0') + digits + extension;
}

const char* name(Analysis analysis) {
  return analysis == Analysis::Dynamic  ? "dynamic"
         : analysis == Analysis::Static ? "static"
                                        : "settle";
}

const char* name(scene_file::RunStatus status) {
  using scene_file::RunStatus;
  return status == RunStatus::Completed      ? "completed"
         : status == RunStatus::NotConverged ? "not_converged"
         : status == RunStatus::NotAtRest    ? "not_at_rest"
                                             : "interrupted";
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

json blocks_json(const solver::Scene& scene, double time) {
  int count[4] = {0, 0, 0, 0};
  Vector3 weight = Vector3::Zero();
  for (const solver::Block& block : scene.blocks) {
    ++count[static_cast<int>(block.kind)];
    if (block.kind == BlockKind::Deformable || block.kind == BlockKind::Rigid) {
      weight += block.material.density * geometry::mass_properties(block.shape).volume *
                scene.gravity.at(time);
    }
  }
  return {{"deformable", count[0]},
          {"rigid", count[1]},
          {"fixed", count[2]},
          {"prescribed", count[3]},
          {"weight", vector(weight)}};
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

json monitors_json(const SceneFile& file, const RunResult& result) {
  json all = json::object();
  for (std::size_t m = 0; m < file.monitors.size(); ++m) {
    const MonitorValue& value = result.monitors[m];
    all[file.monitors[m].name] =
        file.monitors[m].other
            ? json{{"force", vector(value.force)}, {"normal_force", value.normal_force}}
            : json{{"displacement", vector(value.displacement)},
                   {"velocity", vector(value.velocity)},
                   {"rotation", vector(value.rotation)},
                   {"angular_velocity", vector(value.angular_velocity)}};
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

json stages_json(const RunResult& result) {
  json list = json::array();
  for (const scene_file::StageResult& stage : result.stages) {
    list.push_back({{"analysis", name(stage.analysis)},
                    {"steps", stage.steps},
                    {"unbalance", stage.unbalance},
                    {"done", stage.done}});
  }
  return list;
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
      const std::string& name = file.scene.blocks[static_cast<std::size_t>(block)].name;
      blocks.push_back(name.empty() ? json(block) : json(name));
    }
    list.push_back({{"flag", solver::name(flag.worst.kind)},
                    {"value", flag.worst.value},
                    {"limit", flag.worst.limit},
                    {"blocks", blocks},
                    {"first_time", flag.first_time},
                    {"steps", flag.steps}});
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

RunFiles::RunFiles(const std::filesystem::path& folder, const SceneFile& file)
    : folder_(folder), file_(file), history_(folder / "history.csv") {
  write_history_head();
}

void RunFiles::write_history_head() {
  history_ << "step,stage,time";
  for (const Monitor& monitor : file_.monitors) {
    const std::vector<const char*> columns =
        monitor.other
            ? std::vector<const char*>{"fx", "fy", "fz", "normal_force"}
            : std::vector<const char*>{"ux", "uy", "uz", "vx", "vy", "vz", "rx", "ry", "rz"};
    for (const char* column : columns) {
      history_ << ',' << monitor.name << '.' << column;
    }
  }
  history_ << ",kinetic,potential,strain,contact,work,friction_loss,impact_loss,algorithmic_loss,"
              "contacts,closed,largest_overlap,unbalance,sub_steps,iterations,linear_solves\n";
}

void RunFiles::write_history_line(const StepView& view) {
  history_ << steps_ << ',' << view.stage << ',';
  put(history_, view.dynamic_time);
  for (std::size_t m = 0; m < view.monitors.size(); ++m) {
    const MonitorValue& value = view.monitors[m];
    if (file_.monitors[m].other) {
      put(history_, value.force);
      put(history_ << ',', value.normal_force);
    } else {
      put(history_, value.displacement);
      put(history_, value.velocity);
      put(history_, value.rotation);
    }
  }
  const EnergyLedger& energy = view.simulation.state().energy;
  for (const double joule :
       {energy.kinetic, energy.potential, energy.strain, energy.contact, energy.work,
        energy.friction_loss, energy.impact_loss, energy.algorithmic_loss}) {
    put(history_ << ',', joule);
  }
  history_ << ',' << view.report.contact_count << ',' << view.report.closed_count;
  put(history_ << ',', view.report.largest_overlap);
  put(history_ << ',', view.report.unbalance);
  history_ << ',' << view.report.sub_steps << ',' << view.report.iterations << ','
           << view.report.linear_solves << '\n';
}

void RunFiles::start(const StepView& view) {
  write_history_line(view);
  write_vtk(view);
}

bool RunFiles::is_due(const StepView& view) const {
  const scene_file::Stage& stage = file_.stages[view.stage];
  if (stage.analysis != Analysis::Dynamic) {
    return false;
  }
  const double slack = 1e-6 * stage.time_step;
  const double before = view.dynamic_time - view.simulation.options().time_step;
  return std::floor((view.dynamic_time + slack) / file_.output_interval) >
             std::floor((before + slack) / file_.output_interval) ||
         view.dynamic_time >= stage.end_time - slack;
}

void RunFiles::step(const StepView& view) {
  ++steps_;
  if (steps_ % file_.history_every == 0) {
    write_history_line(view);
  }
  if (is_due(view)) {
    write_vtk(view);
  }
}

void RunFiles::write_vtk(const StepView& view) {
  const std::size_t number = times_.size();
  times_.push_back(view.simulation.state().time);
  block_files_.push_back(numbered("blocks_", number, ".vtu"));
  contact_files_.push_back(numbered("contacts_", number, ".vtp"));
  solver::write_blocks((folder_ / block_files_.back()).string(), view.simulation);
  solver::write_contacts((folder_ / contact_files_.back()).string(), view.simulation);
  solver::write_series((folder_ / "blocks.pvd").string(), times_, block_files_);
  solver::write_series((folder_ / "contacts.pvd").string(), times_, contact_files_);
}

void RunFiles::finish() {
  history_.close();
  if (!history_) {
    throw scene_file::FileError((folder_ / "history.csv").string() + ": can't be written");
  }
}

json summary(const SceneFile& file, const std::string& path, const RunResult& result, int threads) {
  const solver::StepReport& total = result.total;
  const double steps = static_cast<double>(std::max(1L, result.steps));
  return {{"quoin", QUOIN_VERSION},
          {"scene", path},
          {"title", file.title},
          {"status", name(result.status)},
          {"message", result.message},
          {"options", options_json(file.options, threads)},
          {"blocks", blocks_json(file.scene, result.time)},
          {"stages", stages_json(result)},
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
          {"references", references_json(file, result)},
          {"monitors", monitors_json(file, result)},
          {"largest_overlap", total.largest_overlap},
          {"pairs", {{"candidates", total.candidate_pairs}, {"searched", total.searched_pairs}}},
          {"contacts", {{"watched", total.contact_count}, {"closed", total.closed_count}}},
          {"base_reaction", vector(result.base_reaction)},
          {"unbalance", total.unbalance},
          {"energy", energy_json(result)},
          {"open_close_iterations", total.iterations},
          {"linear_solves", total.linear_solves},
          {"linear_solves_per_step", static_cast<double>(total.linear_solves) / steps},
          {"factorizations", total.factorizations},
          {"largest_residual", total.residual},
          {"system", system_json(total)},
          {"left_out", result.left_out}};
}

}  // namespace quoin::commands
