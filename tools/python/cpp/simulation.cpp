// Scenes by the schema of scene files; steps, with states as arrays.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <Eigen/LU>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver/output.hpp>
#include <sstream>

#include "scene_file/mesh_file.hpp"
#include "scene_file/run_scene.hpp"
#include "scenes.hpp"
#include "shapes.hpp"

namespace quoin::python {
namespace {

using scene_file::RunStatus;
using scene_file::SceneFile;

struct BlockRow {
  double centroid[3], rotation[4], strain[6], velocity[3], angular_velocity[3];
};

struct ForceRow {
  std::int32_t a, b;
  std::uint8_t type, kind_a, kind_b, mode;
  bool failed, bonded, impact;
  std::int32_t feature_a, feature_b;
  double point[3], normal[3], gap, area, normal_force, shear_force[3], slip;
};

/// A function of time (s) that Python gave. Copies share it, so that none of them needs the GIL.
solver::VectorOfTime vector_of_time(py::function function, const char* name) {
  const std::shared_ptr<py::function> held(new py::function(std::move(function)),
                                           [](py::function* old) {
                                             const py::gil_scoped_acquire gil;
                                             delete old;
                                           });
  return {[held, name](double time) {
    const py::gil_scoped_acquire gil;
    const Vector3 value = vector3((*held)(time), name);
    if (!value.allFinite()) {
      throw geometry::InputError(std::string(name) + " at " + std::to_string(time) +
                                 " s: a number is not finite");
    }
    return value;
  }};
}

int block_index(const solver::Scene& scene, py::handle key) {
  const auto count = static_cast<int>(scene.blocks.size());
  if (py::isinstance<py::str>(key)) {
    const auto name = key.cast<std::string>();
    for (int i = 0; i < count; ++i)
      if (scene.blocks[static_cast<std::size_t>(i)].name == name) return i;
    throw geometry::InputError("there is no block \"" + name + "\"");
  }
  if (PyIndex_Check(key.ptr()) == 0) throw py::type_error("block: an index or a name is expected");
  const int index = key.cast<int>();
  if (index >= 0 && index < count) return index;
  throw geometry::InputError("block " + std::to_string(index) + ": there are " +
                             std::to_string(count));
}

py::function callable(py::handle value, const char* name) {
  if (PyCallable_Check(value.ptr()) != 0) return py::reinterpret_borrow<py::function>(value);
  throw py::type_error(std::string(name) + ": functions of time are expected");
}

/// forces: N, at the centroid; motions: velocities of blocks that become prescribed, m/s.
void add_functions(solver::Scene& scene, const py::dict& forces, const py::dict& motions) {
  for (const auto& [key, value] : forces) {
    const int block = block_index(scene, key);
    const Vector3 centroid =
        mass_properties(scene.blocks[static_cast<std::size_t>(block)].body()).centroid;
    scene.point_loads.push_back({.block = block,
                                 .point = centroid,
                                 .force = vector_of_time(callable(value, "forces"), "force")});
  }
  for (const auto& [key, value] : motions) {
    solver::Block& block = scene.blocks[static_cast<std::size_t>(block_index(scene, key))];
    block.kind = solver::BlockKind::Prescribed;
    block.motion = {.kind = solver::MotionKind::Velocity,
                    .value = vector_of_time(callable(value, "motions"), "motion")};
  }
}

solver::Analysis analysis(const std::string& name) {
  if (name == "dynamic") return solver::Analysis::Dynamic;
  if (name == "static") return solver::Analysis::Static;
  if (name == "settle") return solver::Analysis::Settle;
  throw geometry::InputError("analysis: \"" + name + "\", expected dynamic, static or settle");
}

const char* status_name(solver::StepStatus status) {
  constexpr const char* kNames[] = {"converged", "not-converged", "diverged", "stopped"};
  return kNames[static_cast<std::size_t>(status)];
}

class Simulation {
 public:
  Simulation(const py::object& scene, const std::vector<std::string>& changes,
             std::optional<double> time_step, const std::optional<std::string>& kind, int threads,
             const py::dict& forces, const py::dict& motions) {
    SceneFile file = scene_file_of(scene, changes);
    add_functions(file.scene, forces, motions);
    const scene_file::Stage& first = file.stages.front();
    file.options.analysis = kind ? analysis(*kind) : first.analysis;
    file.options.time_step = time_step.value_or(first.time_step);
    file.options.contact_iteration = first.contact_iteration;
    file.options.threads = threads;
    file.options.watch = [](const solver::StepReport&) {
      const py::gil_scoped_acquire gil;
      return PyErr_CheckSignals() == 0;
    };
    py::gil_scoped_release released;
    simulation_.emplace(std::move(file.scene), file.options);
    const py::gil_scoped_acquire gil;
    blocks_ = py::array_t<BlockRow>(static_cast<py::ssize_t>(state().blocks.size()));
    rows_ = blocks_.mutable_data();
    blocks_.attr("setflags")(py::arg("write") = false);
    show();
  }

  solver::StepReport advance() {
    const Use use(busy_, kName);
    return step();
  }

  solver::StepReport run(std::optional<double> until, std::optional<long> steps,
                         const py::object& callback) {
    const bool dynamic = simulation_->options().analysis == solver::Analysis::Dynamic;
    if (dynamic && !until && !steps)
      throw geometry::InputError("run: a dynamic analysis needs until or steps");
    if (until && !std::isfinite(*until)) throw geometry::InputError("until: it is not finite");
    if (steps && *steps < 0)
      throw geometry::InputError("steps: must be at least 0, is " + std::to_string(*steps));
    if (!dynamic && !steps) steps = kMostStaticSteps;  // time stands still
    solver::StepReport report;
    report.time = state().time;
    const double slack = 1e-9 * simulation_->options().time_step;
    for (long done = 0; (!steps || done < *steps) && (!until || state().time < *until - slack);
         ++done) {
      report = advance();
      if (report.status != solver::StepStatus::Converged) break;
      if (report.verdict != solver::StaticVerdict::Seeking) break;
      if (!callback.is_none() && callback().is(py::bool_(false))) break;
    }
    return report;
  }

  double time() const { return time_; }
  long step_count() const { return step_count_; }
  const solver::State& state() const { return simulation_->state(); }
  const solver::Scene& scene() const { return simulation_->scene(); }
  py::array_t<BlockRow> blocks() const { return blocks_; }
  int index(const py::object& key) const { return block_index(scene(), key); }

  py::list names() const {
    py::list result;
    for (const solver::Block& block : scene().blocks) result.append(block.name);
    return result;
  }
  ShapePointer shape(const py::object& key) const {
    const auto& block = scene().blocks[static_cast<std::size_t>(index(key))];
    return std::const_pointer_cast<geometry::Shape>(block.shape);
  }
  py::array_t<double> vertices(const py::object& key) {
    const Use use(busy_, kName);
    const geometry::Points points = simulation_->vertices(index(key));
    return py::array_t<double>(std::vector<py::ssize_t>{points.cols(), 3}, points.data());
  }
  solver::Vector6 stress(const py::object& key) {
    const Use use(busy_, kName);
    return simulation_->stress(index(key));
  }

  py::array_t<ForceRow> contacts() {
    const Use use(busy_, kName);
    py::array_t<ForceRow> result(static_cast<py::ssize_t>(state().contacts.size()));
    ForceRow* row = result.mutable_data();
    for (const solver::Contact& contact : state().contacts) set(*row++, contact);
    return result;
  }

  py::dict energy() {
    const Use use(busy_, kName);
    const solver::EnergyLedger& e = state().energy;
    py::dict result;
    result["kinetic"] = e.kinetic;
    result["potential"] = e.potential;
    result["strain"] = e.strain;
    result["contact"] = e.contact;
    result["work"] = e.work;
    result["friction_loss"] = e.friction_loss;
    result["impact_loss"] = e.impact_loss;
    result["algorithmic_loss"] = e.algorithmic_loss;
    result["closure"] = e.closure;
    return result;
  }

  void set_velocity(const py::object& key, const py::object& velocity, const py::object& turning) {
    const Use use(busy_, kName);
    const solver::BlockVelocity one{.block = index(key),
                                    .velocity = vector3(velocity, "velocity"),
                                    .angular_velocity = vector3(turning, "angular_velocity")};
    simulation_->set_velocities({&one, 1});
    show();
  }

  void set_analysis(const std::string& name) {
    const Use use(busy_, kName);
    solver::StepOptions options = simulation_->options();
    options.analysis = analysis(name);
    simulation_->set_options(options);
  }
  void set_time_step(double time_step) {
    const Use use(busy_, kName);
    solver::StepOptions options = simulation_->options();
    options.time_step = time_step;
    simulation_->set_options(options);
  }
  double time_step() const { return simulation_->options().time_step; }

  py::bytes save() {
    const Use use(busy_, kName);
    std::ostringstream out;
    simulation_->save(out);
    return out.str();
  }
  void load(const std::string& saved) {
    const Use use(busy_, kName);
    std::istringstream in(saved);
    simulation_->load(in);
    show();
  }

  void to_vtk(const std::string& blocks, const std::optional<std::string>& contacts) {
    const Use use(busy_, kName);
    py::gil_scoped_release released;
    try {
      solver::write_blocks(blocks, *simulation_);
      if (contacts) solver::write_contacts(*contacts, *simulation_);
    } catch (const std::runtime_error& error) {
      throw scene_file::FileError(error.what());
    }
  }

 private:
  static constexpr const char* kName = "Simulation";
  static constexpr long kMostStaticSteps = 1000;  ///< as in scene files

  solver::StepReport step() {
    solver::StepReport report;
    {
      py::gil_scoped_release released;
      report = simulation_->advance();
    }
    show();
    if (PyErr_Occurred() != nullptr || PyErr_CheckSignals() != 0) throw py::error_already_set();
    return report;
  }

  void show() {
    const solver::State& now = state();
    BlockRow* row = rows_;
    time_ = now.time;
    step_count_ = now.step;
    for (const solver::BlockState& block : now.blocks) {
      copy(row->centroid, now.origin + block.centroid);
      const double rotation[] = {block.rotation.w(), block.rotation.x(), block.rotation.y(),
                                 block.rotation.z()};
      std::copy_n(rotation, 4, row->rotation);
      std::copy_n(block.strain.data(), 6, row->strain);
      copy(row->velocity, block.velocity);
      copy(row->angular_velocity, block.angular_velocity);
      ++row;
    }
  }

  void set(ForceRow& row, const solver::Contact& c) const {
    const geometry::ContactPoint& p = c.point;
    row = {.a = p.key.a,
           .b = p.key.b,
           .type = static_cast<std::uint8_t>(p.type),
           .kind_a = static_cast<std::uint8_t>(p.key.feature_a.kind),
           .kind_b = static_cast<std::uint8_t>(p.key.feature_b.kind),
           .mode = static_cast<std::uint8_t>(c.mode),
           .failed = c.failed,
           .bonded = c.bonded,
           .impact = c.impact,
           .feature_a = p.key.feature_a.index,
           .feature_b = p.key.feature_b.index,
           .point = {},
           .normal = {},
           .gap = p.gap,
           .area = c.area(),
           .normal_force = c.normal_force,
           .shear_force = {},
           .slip = c.slip};
    copy(row.point, state().origin + p.point());
    copy(row.normal, p.normal);
    copy(row.shear_force, c.shear_force);
  }

  std::optional<solver::Simulation> simulation_;
  py::array_t<BlockRow> blocks_;
  BlockRow* rows_ = nullptr;
  double time_ = 0.0;  ///< with the rows: of the last whole step, while another thread steps, too
  long step_count_ = 0;
  std::atomic_flag busy_{};
};

const char* run_status_name(RunStatus status) {
  constexpr const char* kNames[] = {"completed",     "not-converged", "not-at-rest", "mechanism",
                                    "stage-refused", "not-trusted",   "interrupted", "time-limit"};
  return kNames[static_cast<std::size_t>(status)];
}

py::dict monitor_dict(const scene_file::MonitorValue& m) {
  using namespace py::literals;
  return py::dict("displacement"_a = m.displacement, "velocity"_a = m.velocity,
                  "rotation"_a = m.rotation, "angular_velocity"_a = m.angular_velocity,
                  "force"_a = m.force, "normal_force"_a = m.normal_force, "stress"_a = m.stress,
                  "strain"_a = m.strain);
}

py::dict result_dict(const SceneFile& file, const scene_file::RunResult& run) {
  py::dict result, references, monitors;
  for (std::size_t i = 0; i < run.references.size(); ++i) {
    py::dict one;
    one["error"] = run.references[i].error;
    one["ok"] = run.references[i].ok;
    references[py::str(file.references[i].name)] = one;
  }
  for (std::size_t i = 0; i < run.monitors.size(); ++i)
    monitors[py::str(file.monitors[i].name)] = monitor_dict(run.monitors[i]);
  py::list stages, flags;
  for (const scene_file::StageResult& stage : run.stages) {
    py::dict one;
    one["steps"] = stage.steps;
    one["unbalance"] = stage.unbalance;
    one["verdict"] = name(stage.verdict);
    one["done"] = stage.done;
    stages.append(one);
  }
  for (const scene_file::RunFlag& flag : run.flags)
    flags.append(py::make_tuple(name(flag.worst.kind), flag.worst.value, flag.fails));
  result["status"] = run_status_name(run.status);
  result["message"] = run.message;
  result["failures"] = failures(file, run);
  result["stages"] = stages;
  result["flags"] = flags;
  result["references"] = references;
  result["monitors"] = monitors;
  result["steps"] = run.steps;
  result["time"] = run.time;
  result["wall_seconds"] = run.wall_seconds;
  result["largest_overlap"] = run.total.largest_overlap;
  result["base_reaction"] = run.base_reaction;
  return result;
}

py::dict run_scene(const py::object& scene, const std::vector<std::string>& changes, int threads) {
  const SceneFile file = scene_file_of(scene, changes);
  scene_file::RunOptions options;
  options.threads = threads;
  options.stop = []() -> std::optional<RunStatus> {
    const py::gil_scoped_acquire gil;
    if (PyErr_Occurred() == nullptr && PyErr_CheckSignals() == 0) return std::nullopt;
    return RunStatus::Interrupted;
  };
  scene_file::RunResult result;
  {
    py::gil_scoped_release released;
    result = scene_file::run_scene(file, options);
  }
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();
  return result_dict(file, result);
}

/// (id, vertices, faces, is a support) of each block.
py::list read_meshes(const std::string& path, const std::string& format) {
  py::list result;
  for (const scene_file::MeshBlock& block :
       scene_file::read_mesh_file(path, scene_file::mesh_format(path, format))) {
    result.append(
        py::make_tuple(block.id, block.vertices.transpose().eval(), block.faces, block.is_support));
  }
  return result;
}

void bind_report(py::module_& module) {
  using solver::StepReport;
  py::class_<StepReport>(module, "StepReport", py::is_final(), "What a step took and came to.")
      .def_property_readonly(
          "status", [](const StepReport& r) { return status_name(r.status); },
          "'converged', 'not-converged', 'diverged' or 'stopped'")
      .def_property_readonly(
          "verdict", [](const StepReport& r) { return name(r.verdict); },
          "static: 'seeking', 'rest' or 'mechanism'")
      .def_property_readonly(
          "flags",
          [](const StepReport& r) {
            py::list flags;
            for (const solver::StepFlag& flag : r.flags)
              flags.append(py::make_tuple(name(flag.kind), flag.value, flag.fails));
            return flags;
          },
          "(name, value, fails) of each")
      .def_readonly("time", &StepReport::time, "at the end, s")
      .def_readonly("sub_steps", &StepReport::sub_steps)
      .def_readonly("iterations", &StepReport::iterations)
      .def_readonly("residual", &StepReport::residual, "relative force residual")
      .def_readonly("unbalance", &StepReport::unbalance)
      .def_readonly("largest_overlap", &StepReport::largest_overlap, "m")
      .def_readonly("largest_speed", &StepReport::largest_speed, "m/s")
      .def_readonly("contact_count", &StepReport::contact_count)
      .def_readonly("closed_count", &StepReport::closed_count)
      .def("__repr__", [](const StepReport& r) { return describe(r); });
}

void bind_state(py::class_<Simulation>& simulation) {
  simulation.def_property_readonly("time", &Simulation::time, "s")
      .def_property_readonly("step_count", &Simulation::step_count)
      .def_property_readonly(
          "blocks", &Simulation::blocks,
          "One row a block, a read-only view that follows the steps: centroid (m), rotation "
          "(quaternion w, x, y, z), strain (xx, yy, zz, xy, yz, zx, in the turning frame), "
          "velocity (m/s), angular_velocity (in the turning frame, rad/s)")
      .def_property_readonly(
          "contacts", &Simulation::contacts,
          "One row a contact point, with its force: normal_force (N, compression positive), "
          "shear_force (on a, N), mode (index in CONTACT_MODES), slip (m), failed, bonded")
      .def_property_readonly("energy", &Simulation::energy,
                             "by kind, J; potential, work and losses since the start")
      .def_property_readonly("block_names", &Simulation::names)
      .def_property("time_step", &Simulation::time_step, &Simulation::set_time_step, "s")
      .def("vertices", &Simulation::vertices, py::arg("block"), "(n, 3) in the world now, m")
      .def("shape", &Simulation::shape, py::arg("block"), "by index or name")
      .def("stress", &Simulation::stress, py::arg("block"),
           "(6,): xx, yy, zz, xy, yz, zx, world axes, tension positive, Pa");
}

void bind_steps(py::module_& module) {
  py::class_<Simulation> simulation(
      module, "Simulation", py::is_final(),
      "Simulation(scene): steps of a Scene. changes: 'NAME=VALUE' as of the command's --set. "
      "analysis: 'dynamic', 'static' or 'settle'; None: that of the first stage, as time_step. "
      "forces: {block: f(t) -> (3,), N, at its "
      "centroid}; motions: {block: f(t) -> (3,), velocity of a block that is moved so, m/s}; "
      "blocks by index or name, t in s. A block that is moved so may be fixed or free in the "
      "scene. What a function raises, the step raises. A function may not use the Simulation, "
      "which is in a step: what depends on its state stands in a callback of run().");
  simulation
      .def(py::init<const py::object&, const std::vector<std::string>&, std::optional<double>,
                    const std::optional<std::string>&, int, const py::dict&, const py::dict&>(),
           py::arg("scene"), py::kw_only(), py::arg("changes") = std::vector<std::string>(),
           py::arg("time_step") = py::none(), py::arg("analysis") = py::none(),
           py::arg("threads") = 1, py::arg("forces") = py::dict(), py::arg("motions") = py::dict())
      .def("advance", &Simulation::advance,
           "One time step: a StepReport. Its status says whether it was solved; the GIL is "
           "released. Ctrl-C ends a long step, with the state before it.")
      .def("run", &Simulation::run, py::arg("until") = py::none(), py::arg("steps") = py::none(),
           py::arg("callback") = py::none(),
           "Steps until the time `until` (s), for `steps` steps, to rest or mechanism (static), "
           "until callback() gives False, or until one is not solved. Returns the last report.")
      .def("set_analysis", &Simulation::set_analysis, py::arg("analysis"), "from the next step on")
      .def("set_velocity", &Simulation::set_velocity, py::arg("block"), py::arg("velocity"),
           py::arg("angular_velocity") = py::make_tuple(0.0, 0.0, 0.0),
           "Of a block, from the next step on: m/s, rad/s (world axes).")
      .def("save", &Simulation::save, "All that the steps to come depend on, as bytes.")
      .def("load", &Simulation::load, py::arg("saved"), "What save() of the same scene gave.")
      .def("to_vtk", &Simulation::to_vtk, py::arg("blocks"), py::arg("contacts") = py::none(),
           "Writes the files of these names for ParaView: blocks (.vtu), contacts (.vtp).");
  bind_state(simulation);
  module.def("run", &run_scene, py::arg("scene"), py::kw_only(),
             py::arg("changes") = std::vector<std::string>(), py::arg("threads") = 1,
             "Runs a Scene whole, stage after stage, with its monitors and references: a dict with "
             "status ('completed', 'not-converged', ...), message, failures (why it counts as "
             "failed; empty: it does not), stages, flags, references (error, ok), monitors (last "
             "values), steps, time (s), wall_seconds, largest_overlap (m), base_reaction (N). "
             "changes: 'NAME=VALUE' as of the command's --set. The GIL is released.");
  module.def("_plain_json", &scene_file::plain_json);
  module.def("_read_meshes", &read_meshes, py::arg("path"), py::arg("format"));
}

}  // namespace

SceneFile scene_file_of(const py::object& scene, const std::vector<std::string>& changes) {
  if (!py::hasattr(scene, "to_json"))
    throw geometry::InputError("scene: must be a Scene, is " +
                               py::str(py::type::of(scene).attr("__name__")).cast<std::string>());
  const auto text = scene.attr("to_json")().cast<std::string>();
  const auto folder = py::str(scene.attr("folder")).cast<std::string>();
  const py::gil_scoped_release released;
  return scene_file::parse_scene(text, folder, changes);
}

void bind_simulation(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(BlockRow, centroid, rotation, strain, velocity, angular_velocity);
  PYBIND11_NUMPY_DTYPE(ForceRow, a, b, type, kind_a, kind_b, mode, failed, bonded, impact,
                       feature_a, feature_b, point, normal, gap, area, normal_force, shear_force,
                       slip);
  bind_report(module);
  bind_steps(module);
}

}  // namespace quoin::python
