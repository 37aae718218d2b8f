#include "scene_file/run_scene.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace quoin::scene_file {
namespace {

using solver::Analysis;
using solver::BlockState;
using solver::Contact;
using solver::Simulation;
using solver::State;
using solver::StepReport;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Vector3 rotation_vector(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turned(rotation);
  return turned.angle() * turned.axis();
}

/// Force of a contact on its block B; on A it is the opposite. N.
Vector3 force_on_b(const Contact& contact) {
  return contact.normal_force * contact.point.normal - contact.shear_force;
}

/// Where the monitors' points stood when displacements began to count.
struct Start {
  std::vector<Vector3> places;
  std::vector<Eigen::Quaterniond> rotations;
};

class Watch {
 public:
  Watch(const SceneFile& file, const Simulation& simulation) : file_(file) {
    for (const Monitor& monitor : file.monitors) {
      arms_.push_back(monitor.point ? simulation.reference_arm(monitor.block, *monitor.point)
                                    : Vector3(Vector3::Zero()));
    }
    begin(simulation.state());
  }

  /// Displacements and rotations count from here.
  void begin(const State& state) {
    start_ = {};
    for (std::size_t m = 0; m < file_.monitors.size(); ++m) {
      start_.places.push_back(solver::world_point(state, file_.monitors[m].block, arms_[m]));
      start_.rotations.push_back(block(state, m).rotation);
    }
  }

  std::vector<MonitorValue> values(const State& state) const {
    std::vector<MonitorValue> result;
    for (std::size_t m = 0; m < file_.monitors.size(); ++m) {
      result.push_back(file_.monitors[m].other ? contact_value(state, file_.monitors[m])
                                               : point_value(state, m));
    }
    return result;
  }

 private:
  const BlockState& block(const State& state, std::size_t monitor) const {
    return state.blocks[static_cast<std::size_t>(file_.monitors[monitor].block)];
  }

  MonitorValue point_value(const State& state, std::size_t m) const {
    const BlockState& now = block(state, m);
    MonitorValue value;
    const Vector3 place = solver::world_point(state, file_.monitors[m].block, arms_[m]);
    value.displacement = place - start_.places[m];
    value.angular_velocity = now.rotation * now.angular_velocity;
    value.velocity =
        now.velocity + value.angular_velocity.cross(place - state.origin - now.centroid);
    value.rotation = rotation_vector(now.rotation * start_.rotations[m].conjugate());
    return value;
  }

  static MonitorValue contact_value(const State& state, const Monitor& monitor) {
    MonitorValue value;
    for (const Contact& contact : state.contacts) {
      const bool on_b =
          contact.point.key.a == *monitor.other && contact.point.key.b == monitor.block;
      const bool on_a =
          contact.point.key.b == *monitor.other && contact.point.key.a == monitor.block;
      if (on_a || on_b) {
        value.force += on_b ? force_on_b(contact) : Vector3(-force_on_b(contact));
        value.normal_force += contact.normal_force;
      }
    }
    return value;
  }

  const SceneFile& file_;
  std::vector<Vector3> arms_;
  Start start_;
};

void add(const StepReport& step, StepReport& total) {
  total.sub_steps += step.sub_steps;
  total.cuts_by_displacement += step.cuts_by_displacement;
  total.cuts_by_convergence += step.cuts_by_convergence;
  total.cuts_by_contact += step.cuts_by_contact;
  total.iterations += step.iterations;
  total.linear_solves += step.linear_solves;
  total.factorizations += step.factorizations;
  total.seconds.detect += step.seconds.detect;
  total.seconds.assemble += step.seconds.assemble;
  total.seconds.solve += step.seconds.solve;
  total.seconds.update += step.seconds.update;
  total.residual = std::max(total.residual, step.residual);
  total.largest_overlap = std::max(total.largest_overlap, step.largest_overlap);
  total.largest_speed = std::max(total.largest_speed, step.largest_speed);
  total.largest_strain = std::max(total.largest_strain, step.largest_strain);
  total.stiffest_omega_dt = std::max(total.stiffest_omega_dt, step.stiffest_omega_dt);
  total.numerical_damping = std::max(total.numerical_damping, step.numerical_damping);
  total.condition = std::max(total.condition, step.condition);
  total.candidate_pairs += step.candidate_pairs;
  total.searched_pairs += step.searched_pairs;
  total.contact_count = step.contact_count;
  total.closed_count = step.closed_count;
  total.unbalance = step.unbalance;
}

class Runner {
 public:
  Runner(const SceneFile& file, const RunOptions& options)
      : file_(file),
        options_(options),
        simulation_(file.scene, step_options(file.stages.at(0))),
        watch_(file, simulation_) {
    for (const Reference& reference : file.references) {
      comparisons_.emplace_back(reference);
    }
  }

  RunResult run() {
    const auto start = std::chrono::steady_clock::now();
    result_.energy_start = simulation_.state().energy;
    result_.monitors = watch_.values(simulation_.state());
    if (options_.before_first) {
      options_.before_first({simulation_, StepReport{}, result_.monitors, 0.0, 0, 0.0});
    }
    for (std::size_t stage = 0; stage < file_.stages.size() && going_; ++stage) {
      run_stage(stage);
    }
    finish();
    result_.wall_seconds = seconds_since(start);
    return std::move(result_);
  }

 private:
  solver::StepOptions step_options(const Stage& stage) const {
    solver::StepOptions options = file_.options;
    options.analysis = stage.analysis;
    options.time_step = stage.time_step;
    options.threads = options_.threads;
    return options;
  }

  void run_stage(std::size_t index) {
    const Stage& stage = file_.stages[index];
    stage_ = index;
    result_.stages.push_back({.analysis = stage.analysis});
    simulation_.set_options(step_options(stage));
    note_left_out();
    if (stage.analysis == Analysis::Dynamic) {
      run_dynamic(stage);
    } else {
      run_static(stage);
    }
    result_.stages.back().done = going_;
  }

  /// What a run does not need is what none of its stages needs.
  void note_left_out() {
    std::vector<std::string> now = simulation_.left_out();
    if (result_.stages.size() == 1) {
      result_.left_out = std::move(now);
      return;
    }
    std::erase_if(result_.left_out, [&](const std::string& line) {
      return std::find(now.begin(), now.end(), line) == now.end();
    });
  }

  void run_static(const Stage& stage) {
    const long most = stage.steps.value_or(stage.max_steps);
    for (long n = 0; n < most && going_; ++n) {
      const StepReport report = step(0.0);
      if (!stage.steps && going_ && report.unbalance <= stage.unbalance) {
        return;
      }
    }
    if (going_ && !stage.steps) {
      fail(RunStatus::NotAtRest, "stage " + std::to_string(stage_) + " did not come to rest in " +
                                     std::to_string(most) + " steps: unbalance " +
                                     std::to_string(simulation_report_.unbalance));
    }
  }

  void run_dynamic(const Stage& stage) {
    if (!dynamic_start_) {
      dynamic_start_ = simulation_.state().time;
      if (stage_ > 0) {
        set_initial_velocities();
      }
      watch_.begin(simulation_.state());
      result_.energy_start = simulation_.state().energy;
      least_energy_ = result_.energy_start.mechanical() - result_.energy_start.work;
    }
    while (going_) {
      const double left = *dynamic_start_ + stage.end_time - simulation_.state().time;
      if (left <= 1e-6 * stage.time_step) {
        return;
      }
      // The last step ends where the stage does; a rounding error is no reason for another step.
      const double time_step = left < (1 - 1e-6) * stage.time_step ? left : stage.time_step;
      if (time_step != simulation_.options().time_step) {
        solver::StepOptions options = step_options(stage);
        options.time_step = time_step;
        simulation_.set_options(options);
      }
      step(1 - left / stage.end_time);
    }
  }

  /// Velocities of the scene, after stages that brought it to rest.
  void set_initial_velocities() {
    for (std::size_t b = 0; b < file_.scene.blocks.size(); ++b) {
      const solver::Block& block = file_.scene.blocks[b];
      if (!block.velocity.isZero(0.0) || !block.angular_velocity.isZero(0.0)) {
        simulation_.set_velocity(static_cast<int>(b), block.velocity, block.angular_velocity);
      }
    }
  }

  void note_flags(const StepReport& report) {
    for (const solver::StepFlag& flag : report.flags) {
      auto known = std::find_if(result_.flags.begin(), result_.flags.end(),
                                [&](const RunFlag& f) { return f.worst.kind == flag.kind; });
      if (known == result_.flags.end()) {
        known = result_.flags.insert(known, {.worst = flag, .first_time = report.time});
      }
      ++known->steps;
      if (flag.value > known->worst.value) {
        known->worst = flag;
      }
    }
  }

  StepReport step(double progress) {
    const StepReport report = simulation_.advance();
    simulation_report_ = report;
    add(report, result_.total);
    note_flags(report);
    ++result_.steps;
    ++result_.stages.back().steps;
    result_.stages.back().unbalance = report.unbalance;
    if (report.status != solver::StepStatus::Converged) {
      not_converged(report);
    }
    const State& state = simulation_.state();
    result_.monitors = watch_.values(state);
    const double time = dynamic_start_ ? state.time - *dynamic_start_ : 0.0;
    if (dynamic_start_) {
      compare(time);
      measure_energy(state.energy);
    }
    if (options_.after_step &&
        !options_.after_step({simulation_, report, result_.monitors, time, stage_, progress})) {
      fail(RunStatus::Interrupted, "interrupted");
      going_ = false;
    }
    return report;
  }

  void not_converged(const StepReport& report) {
    ++result_.unconverged_steps;
    fail(RunStatus::NotConverged, describe(report));
    if (going_) {
      simulation_.take_best_try();
    }
  }

  /// Notes the first failure, and stops unless failures are accepted.
  void fail(RunStatus status, const std::string& message) {
    if (result_.status == RunStatus::Completed) {
      result_.status = status;
      result_.message = message;
    }
    going_ = going_ && options_.on_failure == RunOptions::OnFailure::Accept;
  }

  void compare(double time) {
    for (std::size_t r = 0; r < comparisons_.size(); ++r) {
      comparisons_[r].compare(
          time, result_.monitors[static_cast<std::size_t>(file_.references[r].monitor)]);
    }
  }

  void measure_energy(const solver::EnergyLedger& energy) {
    const double own = energy.mechanical() - energy.work;
    least_energy_ = std::min(least_energy_, own);
    result_.energy_growth = std::max(result_.energy_growth, own - least_energy_);
    largest_kinetic_ = std::max(largest_kinetic_, energy.kinetic);
    least_potential_ = std::min(least_potential_, energy.potential);
    largest_potential_ = std::max(largest_potential_, energy.potential);
    result_.energy_scale = largest_kinetic_ + largest_potential_ - least_potential_;
  }

  void finish() {
    if (!dynamic_start_) {
      compare(0.0);
    }
    for (const Comparison& comparison : comparisons_) {
      result_.references.push_back(comparison.result());
    }
    const State& state = simulation_.state();
    result_.energy = state.energy;
    result_.time = state.time;
    result_.dynamic_time = dynamic_start_ ? state.time - *dynamic_start_ : 0.0;
    for (const Contact& contact : state.contacts) {
      const bool a = is_held(contact.point.key.a);
      const bool b = is_held(contact.point.key.b);
      if (a != b) {
        result_.base_reaction += b ? force_on_b(contact) : Vector3(-force_on_b(contact));
      }
    }
  }

  bool is_held(int block) const {
    const solver::BlockKind kind = file_.scene.blocks[static_cast<std::size_t>(block)].kind;
    return kind == solver::BlockKind::Fixed || kind == solver::BlockKind::Prescribed;
  }

  const SceneFile& file_;
  const RunOptions& options_;
  Simulation simulation_;
  Watch watch_;
  std::vector<Comparison> comparisons_;
  RunResult result_;
  StepReport simulation_report_;
  std::optional<double> dynamic_start_;
  std::size_t stage_ = 0;
  bool going_ = true;
  double least_energy_ = 0.0, largest_kinetic_ = 0.0;
  double least_potential_ = 0.0, largest_potential_ = 0.0;
};

}  // namespace

RunResult run_scene(const SceneFile& file, const RunOptions& options) {
  return Runner(file, options).run();
}

}  // namespace quoin::scene_file
