#include "scene_file/run_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/queries.hpp>
#include <quoin/geometry/time_of_impact.hpp>
#include <sstream>

#include "scene_file/archive.hpp"
#include "scene_file/group_value.hpp"
#include "scene_file/mechanism_proof.hpp"
#include "scene_file/not_finite.hpp"
#include "scene_file/staged_work.hpp"

namespace quoin::scene_file {
namespace {

using solver::Analysis;
using solver::BlockState;
using solver::Contact;
using solver::Simulation;
using solver::State;
using solver::StepReport;

// Of the energy that moves in a run: what it may gain, and what its ledger may leave open. Speeds
// are then off by half of that.
constexpr double kMostGrowth = 1e-4;

// How deep a motion may drive a block into another without unknowns, of the thinner one; and how
// near they are when they meet within a step, of the smaller one.
constexpr double kDrivenOverlap = 1e-3, kMeets = 1e-6;

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
  std::vector<Vector3> places{};
  std::vector<Eigen::Quaterniond> rotations{};
  /// Of what a monitor is relative to: reference arm of the material at its place, and rotation.
  std::vector<Vector3> ground_arms{};
  std::vector<Eigen::Quaterniond> ground_rotations{};
};

/// Reference arm of a block's material at a place, both relative to State::origin, m.
Vector3 arm_at(const State& state, int block, const Vector3& place) {
  const Vector3 centroid = solver::local_point(state, block, Vector3::Zero());
  geometry::Matrix3 turned;
  for (int i = 0; i < 3; ++i)
    turned.col(i) = solver::local_point(state, block, Vector3::Unit(i)) - centroid;
  return turned.inverse() * (place - centroid);
}

/// Where blocks without unknowns stand, by block.
using DrivenPlaces = std::map<std::size_t, geometry::Placement>;

class Watch {
 public:
  Watch(const SceneFile& file, const Simulation& simulation) : file_(file) {
    for (const Monitor& monitor : file.monitors) {
      arms_.push_back(monitor.point ? simulation.reference_arm(monitor.blocks[0], *monitor.point)
                                    : Vector3(Vector3::Zero()));
      sides_.push_back(monitor.kind == Monitor::Kind::Contact
                           ? sides(monitor, file.scene.blocks.size())
                           : std::vector<Side>());
    }
    begin(simulation.state());
  }

  /// Displacements and rotations count from here.
  void begin(const State& state) {
    start_ = {};
    for (std::size_t m = 0; m < file_.monitors.size(); ++m) {
      const bool moves = file_.monitors[m].kind == Monitor::Kind::Point;
      start_.places.push_back(
          moves ? solver::local_point(state, file_.monitors[m].blocks[0], arms_[m])
                : Vector3(Vector3::Zero()));
      start_.rotations.push_back(Eigen::Quaterniond::Identity());
      if (moves) start_.rotations.back() = block(state, m).rotation;
      const int ground = file_.monitors[m].relative_to;
      start_.ground_arms.emplace_back(ground < 0 ? Vector3(Vector3::Zero())
                                                 : arm_at(state, ground, start_.places[m]));
      start_.ground_rotations.push_back(Eigen::Quaterniond::Identity());
      if (ground >= 0) start_.ground_rotations.back() = of(state, ground).rotation;
    }
  }

  template <class Archive>
  void transfer(Archive& archive) {
    archive(start_.places, start_.rotations, start_.ground_arms, start_.ground_rotations);
  }

  std::vector<MonitorValue> values(const Simulation& simulation) const {
    std::vector<MonitorValue> result;
    for (std::size_t m = 0; m < file_.monitors.size(); ++m) {
      const Monitor& monitor = file_.monitors[m];
      switch (monitor.kind) {
        case Monitor::Kind::Contact:
          result.push_back(contact_value(simulation, sides_[m], monitor.about));
          break;
        case Monitor::Kind::Group:
          result.push_back(group_value(simulation, monitor.blocks));
          break;
        case Monitor::Kind::FixedPoints:
          result.push_back(held_value(simulation, monitor.fixed_points));
          break;
        case Monitor::Kind::Point:
          result.push_back(point_value(simulation.state(), m));
          break;
      }
    }
    return result;
  }

 private:
  /// What a block is to a contact monitor.
  struct Side {
    bool pushes = false, is_pushed = false;
  };
  static std::vector<Side> sides(const Monitor& monitor, std::size_t block_count) {
    std::vector<Side> result(block_count);
    for (const int b : monitor.others) result[static_cast<std::size_t>(b)].pushes = true;
    for (const int b : monitor.blocks) result[static_cast<std::size_t>(b)].is_pushed = true;
    return result;
  }

  const BlockState& block(const State& state, std::size_t monitor) const {
    return of(state, file_.monitors[monitor].blocks[0]);
  }
  static const BlockState& of(const State& state, int block) {
    return state.blocks[static_cast<std::size_t>(block)];
  }

  MonitorValue point_value(const State& state, std::size_t m) const {
    const BlockState& now = block(state, m);
    MonitorValue value;
    const Vector3 place = solver::local_point(state, file_.monitors[m].blocks[0], arms_[m]);
    value.displacement = place - start_.places[m];
    value.angular_velocity = now.rotation * now.angular_velocity;
    value.velocity = now.velocity + value.angular_velocity.cross(place - now.centroid);
    Eigen::Quaterniond turned = now.rotation * start_.rotations[m].conjugate();
    if (const int ground = file_.monitors[m].relative_to; ground >= 0) {
      const BlockState& carrier = of(state, ground);
      const Vector3 carried = solver::local_point(state, ground, start_.ground_arms[m]);
      const Vector3 spin = carrier.rotation * carrier.angular_velocity;
      value.displacement = place - carried;
      value.velocity -= carrier.velocity + spin.cross(carried - carrier.centroid);
      value.angular_velocity -= spin;
      turned = (carrier.rotation * start_.ground_rotations[m].conjugate()).conjugate() * turned;
    }
    value.rotation = rotation_vector(turned);
    return value;
  }

  /// Of all pairs of one that pushes and one that is pushed: inner forces of what is both cancel.
  static MonitorValue contact_value(const Simulation& simulation, const std::vector<Side>& sides,
                                    const Vector3& about) {
    MonitorValue value;
    const auto pushes = [&](int from, int to) {
      return sides[static_cast<std::size_t>(from)].pushes &&
             sides[static_cast<std::size_t>(to)].is_pushed;
    };
    const auto on_b = [&](const Contact& c) { return pushes(c.point.key.a, c.point.key.b); };
    const auto on_a = [&](const Contact& c) { return pushes(c.point.key.b, c.point.key.a); };
    for (const Contact& contact : simulation.state().contacts) {
      if (!on_a(contact) && !on_b(contact)) continue;
      const Vector3 place = simulation.state().origin + contact.point.point();
      const double times = (on_b(contact) ? 1 : 0) - (on_a(contact) ? 1 : 0);
      value.force += times * force_on_b(contact);
      value.moment += times * (place - about).cross(force_on_b(contact));
      value.normal_force += contact.normal_force;
      value.centre_of_pressure += contact.normal_force * place;
    }
    value.centre_of_pressure /= value.normal_force;
    return value;
  }

  static MonitorValue held_value(const Simulation& simulation,
                                 const std::vector<std::string>& names) {
    MonitorValue value;
    const std::vector<solver::FixedPoint>& points = simulation.scene().fixed_points;
    for (std::size_t h = 0; h < points.size(); ++h) {
      if (!std::ranges::binary_search(names, points[h].name)) continue;
      value.force += simulation.state().held_forces[h];
    }
    return value;
  }

  const SceneFile& file_;
  std::vector<Vector3> arms_;
  std::vector<std::vector<Side>> sides_;  ///< of contact monitors: by block
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
  total.linear.add(step.linear);
  total.proximal_newton_attempts += step.proximal_newton_attempts;
  total.seconds.add(step.seconds);
  total.residual = solver::worse_residual(total.residual, step.residual);
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

std::string block_name(const SceneFile& file, int block) {
  const std::string& name = file.scene.blocks[static_cast<std::size_t>(block)].name;
  return name.empty() ? std::to_string(block) : '"' + name + '"';
}

/// What closing gaps may make of the energy of a scene at rest, J: overlaps that steps leave are
/// lifted out again. `overlap`: the largest of the run, m.
double energy_noise(const solver::Scene& scene, double overlap) {
  constexpr double kLeast = 1e-8, kMost = 1e-6;  // of a block: what steps leave of gaps
  double noise = 0.0;
  for (const solver::Block& block : scene.blocks) {
    if (block.kind >= solver::BlockKind::Fixed) continue;
    const double size = block.body().stretch() * block.shape->diameter();
    const double mass = block.material.density * geometry::mass_properties(block.body()).volume;
    noise += mass * std::clamp(overlap, kLeast * size, kMost * size);
  }
  return noise * std::max(1.0, scene.gravity.at(0.0).norm());
}

/// The limit that a run exceeds which gains or leaves open `value` where `scale` has been moved, J.
std::optional<double> limit_exceeded(const SceneFile& file, const RunResult& result, double value,
                                     double scale) {
  if (value <= kMostGrowth * scale) return {};
  const double limit = kMostGrowth * scale + energy_noise(file.scene, result.total.largest_overlap);
  return value <= limit ? std::nullopt : std::optional(limit);
}

/// A line for what the ledger of a run leaves open, and for growth that no step flags: steps gain
/// less than they flag, and many of them more.
void append_ledger(const SceneFile& file, const RunResult& result,
                   std::vector<std::string>& lines) {
  const solver::EnergyLedger &start = result.energy_start, &end = result.energy;
  const auto change = [&](double solver::EnergyLedger::*term) {
    return std::abs(end.*term - start.*term);
  };
  const double moved =
      result.energy_scale + change(&solver::EnergyLedger::potential) + start.strain + end.strain +
      start.contact + end.contact + change(&solver::EnergyLedger::work) +
      change(&solver::EnergyLedger::friction_loss) + change(&solver::EnergyLedger::impact_loss) +
      change(&solver::EnergyLedger::algorithmic_loss);
  const auto append = [&](const char* what, double value) {
    const std::optional<double> limit = limit_exceeded(file, result, value, moved);
    if (!limit) return;
    std::ostringstream line;
    line << "not to be trusted: " << what << ' ' << value << " J, limit " << *limit << " J";
    lines.push_back(line.str());
  };
  append("the energy ledger leaves open", change(&solver::EnergyLedger::closure));
  const bool flagged = std::ranges::any_of(result.flags, [](const RunFlag& flag) {
    return flag.worst.kind == solver::FlagKind::EnergyGrowth;
  });
  const bool kept = file.scene.initial_overlap == solver::InitialOverlap::Keep;
  if (!flagged && !kept) append("energy has grown by", result.energy_growth);
}

/// A line for each flag that fails the run, but for steps that did not converge.
std::vector<std::string> failing_flags(const SceneFile& file, const RunResult& result) {
  std::vector<std::string> lines;
  for (const RunFlag& flag : result.flags) {
    if (!flag.fails || flag.worst.kind == solver::FlagKind::Unconverged) continue;
    const bool growth = flag.worst.kind == solver::FlagKind::EnergyGrowth;
    std::ostringstream line;
    line << "not to be trusted: " << name(flag.worst.kind) << ' '
         << (growth ? result.energy_growth / result.energy_scale : flag.worst.value)
         << (growth ? " in the run, limit " : ", limit ")
         << (growth ? kMostGrowth : flag.worst.limit) << ", from " << flag.first_time << " s in "
         << flag.steps << " of " << result.steps << " steps";
    if (flag.worst.block >= 0) line << ", block " << block_name(file, flag.worst.block);
    if (flag.worst.other >= 0) line << " and " << block_name(file, flag.worst.other);
    lines.push_back(line.str());
  }
  append_ledger(file, result, lines);
  return lines;
}

class Runner {
 public:
  Runner(const SceneFile& file, const RunOptions& options)
      : file_(file),
        options_(options),
        simulation_(file.scene, step_options(file.stages.at(0))),
        watch_(file, simulation_) {
    for (const Reference& reference : file.references) comparisons_.emplace_back(reference);
  }

  RunResult run() {
    started_ = std::chrono::steady_clock::now();
    if (options_.resume != nullptr) {
      load(*options_.resume);
    } else {
      file_.stage_clock->start = 0.0;
      result_.energy_start = simulation_.state().energy;
    }
    result_.monitors = watch_.values(simulation_);
    if (options_.resume == nullptr && options_.before_first) options_.before_first(view());
    for (std::size_t stage = stage_; stage < file_.stages.size() && going_; ++stage)
      run_stage(stage);
    finish();
    return std::move(result_);
  }

 private:
  solver::StepOptions step_options(const Stage& stage) {
    solver::StepOptions options = file_.options;
    options.analysis = stage.analysis;
    options.time_step = stage.time_step;
    options.contact_iteration = stage.contact_iteration;
    options.rest_unbalance = stage.unbalance;
    options.threads = options_.threads;
    options.distributed_solver = options_.distributed_solver;
    options.contact_problem = options_.contact_problem;
    options.watch = [this](const StepReport& so_far) {
      if (options_.in_step) {
        StepView now = view();
        options_.in_step({simulation_, so_far, now.monitors, now.counted_from, now.dynamic_time,
                          now.stage, now.progress, now.status});
      }
      return !must_stop();
    };
    return options;
  }

  StepView view() const {
    return {simulation_,      simulation_report_,
            result_.monitors, counted_from_,
            dynamic_time(),   stage_,
            progress_,        stopped_.value_or(result_.status)};
  }

  double dynamic_time() const {
    return dynamic_start_ ? simulation_.state().time - *dynamic_start_ : 0.0;
  }

  bool must_stop() {
    if (!stopped_ && options_.stop) stopped_ = options_.stop();
    going_ = going_ && !stopped_;
    return !going_;
  }

  /// All but what the file says and the simulation holds.
  template <class Archive>
  void transfer(Archive& archive) {
    archive(result_.status, result_.message, result_.stages, result_.energy_start,
            result_.energy_growth, result_.steps, result_.unconverged_steps, result_.total,
            result_.wall_seconds, result_.left_out, stage_, progress_, simulation_report_,
            dynamic_start_, time_step_, least_energy_, largest_kinetic_, least_potential_,
            largest_potential_, result_.energy_scale, result_.flags, stage_start_, moved_from_,
            counted_from_, file_.stage_clock->start, result_.loose);
    work_.transfer(archive);
    watch_.transfer(archive);
    for (Comparison& comparison : comparisons_) comparison.transfer(archive);
  }

  void save(std::ostream& out) {
    const double before = result_.wall_seconds;
    result_.wall_seconds += seconds_since(started_);
    time_step_ = simulation_.options().time_step;
    ArchiveWriter archive(out);
    transfer(archive);
    simulation_.save(out);
    result_.wall_seconds = before;
  }

  void load(std::istream& in) {
    ArchiveReader archive(in);
    transfer(archive);
    solver::StepOptions options = step_options(file_.stages.at(stage_));
    options.time_step = time_step_;
    simulation_ = Simulation(work_.worked(file_.scene_in(stage_)), options, in);
  }

  void run_stage(std::size_t index) {
    const Stage& stage = file_.stages[index];
    if (index >= result_.stages.size()) {
      begin_stage(index);
      must_stop();  // a stage that is gone on with takes a step at least
    }
    if (going_) stage.analysis == Analysis::Dynamic ? run_dynamic(stage) : run_static(stage);
    result_.stages.back().done = going_;
    if (options_.after_stage) options_.after_stage(view(), save_);
  }

  void begin_stage(std::size_t index) {
    stage_ = index;
    progress_ = 0.0;
    const Stage& stage = file_.stages[index];
    result_.stages.push_back({.analysis = stage.analysis});
    file_.stage_clock->start = simulation_.state().time;
    if (stage.relax > 0) work_.take_tractions(simulation_, *stage.scene);
    work_.begin_stage(stage);
    const bool changed = stage.scene || stage.ramp_to > 0.0;
    if (changed && !change_scene(work_.worked(file_.scene_in(index)))) return;
    work_.begin_round(simulation_.state(), 0);
    simulation_.set_options(step_options(stage));
    note_left_out();
    if (stage.analysis == Analysis::Dynamic && !dynamic_start_) begin_dynamic();
    set_velocities(stage);
    stage_start_ = dynamic_time();
    const State& state = simulation_.state();
    moved_from_.clear();
    for (const BlockState& block : state.blocks)
      if (stage.until_moved > 0) moved_from_.push_back(block.centroid);
    if (stage.reset_displacements) {
      counted_from_ = state.blocks;
      watch_.begin(state);
    }
  }

  bool change_scene(const solver::Scene& scene) {
    try {
      simulation_.change(scene);
      return true;
    } catch (const geometry::InputError& error) {
      fail(RunStatus::StageRefused, stage_name() + " can't begin: " + error.what());
      going_ = false;  // there is no state to go on from
      return false;
    }
  }

  std::string stage_name() const {
    const std::string& name = file_.stages[stage_].name;
    return "stage " + std::to_string(stage_) + (name.empty() ? "" : " (" + name + ")");
  }

  void begin_dynamic() {
    dynamic_start_ = simulation_.state().time;
    if (stage_ > 0) set_initial_velocities();
    watch_.begin(simulation_.state());
    result_.energy_start = simulation_.state().energy;
    least_energy_ = result_.energy_start.mechanical() - result_.energy_start.work;
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

  /// True where the stage ends by a proof that nothing near its start is an equilibrium.
  bool falls_by_proof(const Stage& stage) {
    StageResult& done = result_.stages.back();
    const bool in_rounds = stage.on_mechanism != OnMechanism::Fail || stage.relax > 0 ||
                           stage.ramp_to > 0.0;  // what the first one shows is not the end
    if (done.steps > 0 || in_rounds || !may_be_proved(simulation_, stage)) return false;
    result_.proof = find_mechanism(simulation_);
    if (!result_.proof) return false;
    done.verdict = solver::StaticVerdict::Mechanism;
    done.unbalance = std::numeric_limits<double>::quiet_NaN();
    done.travel_block = result_.proof->fastest();
    std::ostringstream line;
    line << stage_name()
         << ": mechanism: no forces within friction and strength balance the loads: "
         << "block " << block_name(file_, done.travel_block) << " moves first; the loads do "
         << result_.proof->found.power << " W, contacts take " << result_.proof->found.dissipation
         << " W";
    fail(RunStatus::Mechanism, line.str());
    return true;
  }

  void run_static(const Stage& stage) {
    if (falls_by_proof(stage)) return;
    const StageResult& done = result_.stages.back();
    while (going_) {
      const bool ended = has_ended(stage);
      const bool loose = done.verdict == solver::StaticVerdict::Mechanism;
      if (loose && done.end != StageEnd::Moved) {
        if (stage.ramp_to > 0.0) return;
        if (stage.on_mechanism != OnMechanism::Fail) {
          if (!take_loose(stage)) return;
          continue;
        }
        if (!(stage.until_moved > 0.0)) return fail(RunStatus::Mechanism, mechanism(done));
      }
      if (ended && !next_round(stage)) return;
      if (!stage.steps && steps_of_round() >= stage.max_steps) return not_at_rest();
      step();
    }
  }

  long steps_of_round() const { return result_.stages.back().steps - work_.steps_before(); }

  /// After rest, the next part of a ramp or of what is given back: false, the stage is over.
  bool next_round(const Stage& stage) {
    StageResult& done = result_.stages.back();
    if (done.end != StageEnd::Rest || (stage.relax == 0 && !(stage.ramp_to > 0.0))) return false;
    if (stage.ramp_to > 0.0) done.load_factor = work_.share();
    if (!work_.next_share(stage)) return false;
    begin_round();
    return true;
  }

  void begin_round() {
    StageResult& done = result_.stages.back();
    work_.begin_round(simulation_.state(), done.steps);
    done.verdict = solver::StaticVerdict::Seeking;
    done.end = StageEnd::None;
    simulation_.set_options(step_options(file_.stages[stage_]));
  }

  /// Notes what has come loose: false, the stage ends with it.
  bool take_loose(const Stage& stage) {
    const std::vector<int> blocks = work_.loose(simulation_, result_.stages.back().travel_block);
    const bool removes = stage.on_mechanism == OnMechanism::Remove;
    for (const int block : blocks)
      result_.loose.push_back({static_cast<int>(stage_), block, removes});
    if (!removes || blocks.empty()) return false;
    work_.remove(blocks);
    if (!change_scene(work_.worked(file_.scene_in(stage_)))) return false;
    begin_round();
    return true;
  }

  /// A static stage is at rest by its verdict; also where its steps are over and the unbalance
  /// still falls, below its limit.
  bool is_at_rest(const Stage& stage, const StageResult& done) const {
    const bool balanced = done.steps > 0 && done.unbalance <= stage.unbalance;
    if (stage.analysis == Analysis::Dynamic) return balanced;
    return done.verdict == solver::StaticVerdict::Rest ||
           (balanced && steps_of_round() >= stage.max_steps);
  }

  /// Rest, distance and steps; notes which.
  bool has_ended(const Stage& stage) {
    StageResult& done = result_.stages.back();
    const bool moved =
        stage.until_moved > 0 && farthest_moved(simulation_.state()) >= stage.until_moved;
    done.end = stage.until_rest && is_at_rest(stage, done) ? StageEnd::Rest
               : moved                                     ? StageEnd::Moved
               : stage.steps && done.steps >= *stage.steps ? StageEnd::Steps
                                                           : StageEnd::None;
    const bool seeking = stage.analysis == Analysis::Static &&
                         done.verdict == solver::StaticVerdict::Seeking &&
                         !(done.unbalance <= stage.unbalance);
    if (done.end == StageEnd::Steps && (stage.until_rest || seeking)) not_at_rest();
    return done.end != StageEnd::None;
  }

  /// Of any block that can move, since the start of the stage, m.
  double farthest_moved(const State& state) const {
    double farthest = 0.0;
    for (std::size_t b = 0; b < state.blocks.size(); ++b) {
      if (simulation_.scene().blocks[b].kind >= solver::BlockKind::Fixed) continue;
      farthest = std::max(farthest, (state.blocks[b].centroid - moved_from_[b]).norm());
    }
    return farthest;
  }

  void not_at_rest() {
    std::ostringstream line;
    line << stage_name() << " did not come to rest in " << result_.stages.back().steps
         << " steps: unbalance " << simulation_report_.unbalance << admissible();
    fail(RunStatus::NotAtRest, line.str());
  }

  /// Of a static stage that has found no rest: whether there could be one where it ended.
  const char* admissible() {
    StageResult& done = result_.stages.back();
    done.admissible =
        may_be_proved(simulation_, file_.stages[stage_]) && is_admissible(simulation_);
    return done.admissible
               ? "; admissible: forces within friction balance all loads, which does not "
                 "say that loading leads there"
               : "";
  }

  /// "; contacts that fight: …", nothing where there are none.
  std::string fighting(const StepReport& report) const {
    std::ostringstream line;
    const char* before = "; contacts that fight: ";
    for (const solver::FightingContact& contact : report.fighting) {
      line << before << block_name(file_, contact.block) << " and "
           << block_name(file_, contact.other) << " at (" << contact.place.x() << ", "
           << contact.place.y() << ", " << contact.place.z() << ") m";
      before = ", ";
    }
    return line.str();
  }

  /// Of a scene whose first step fails, pressed by no support that moves: whether its blocks are
  /// laid as rounded coordinates leave them, which rigid ones that fill a space cannot stand.
  std::string rounded(const StepReport& report) const {
    constexpr double kZero = 1e-10;  // of the smallest block: what steps call zero, and more
    double smallest = std::numeric_limits<double>::infinity();
    for (const solver::Block& block : file_.scene.blocks)
      smallest = std::min(smallest, block.body().stretch() * block.shape->diameter());
    const double overlap = report.largest_overlap;
    const auto is_prescribed = [&](int block) {
      return simulation_.scene().blocks[static_cast<std::size_t>(block)].kind ==
             solver::BlockKind::Prescribed;
    };
    const bool pressed =
        std::ranges::any_of(report.fighting, [&](const solver::FightingContact& c) {
          return is_prescribed(c.block) || is_prescribed(c.other);
        });
    if (result_.steps > 1 || pressed ||
        overlap <= std::max(kZero * smallest, file_.scene.coordinate_rounding))
      return "";
    std::ostringstream line;
    line << "; blocks overlap by up to " << overlap
         << " m: where the digits of a file leave that, \"coordinate_rounding\" takes it for none";
    return line.str();
  }

  std::string mechanism(const StageResult& stage) const {
    std::ostringstream line;
    line << stage_name() << ": mechanism: block " << block_name(file_, stage.travel_block)
         << " has moved by " << stage.travel << " of its size and does not come to rest; unbalance "
         << stage.unbalance;
    return line.str();
  }

  void run_dynamic(const Stage& stage) {
    const double unlimited = std::numeric_limits<double>::infinity();
    const double end = stage.end_time > 0   ? stage.end_time
                       : stage.duration > 0 ? stage_start_ + stage.duration
                                            : unlimited;
    while (going_ && !has_ended(stage)) {
      const double left = *dynamic_start_ + end - simulation_.state().time;
      // A stage that is shorter than that has a step all the same.
      const bool stepped = result_.stages.back().steps > 0;
      const double now = simulation_.state().time;
      if (left <=
          (stepped ? 1e-6 * stage.time_step : 4 * std::numeric_limits<double>::epsilon() * now)) {
        result_.stages.back().end = StageEnd::Time;
        if (stage.until_rest) not_at_rest();
        return;
      }
      // The last step ends where the stage does; a rounding error is no reason for another step.
      const double time_step = left < (1 - 1e-6) * stage.time_step ? left : stage.time_step;
      if (time_step != simulation_.options().time_step) {
        solver::StepOptions options = step_options(stage);
        options.time_step = time_step;
        simulation_.set_options(options);
      }
      progress_ = stage.steps ? static_cast<double>(result_.stages.back().steps) /
                                    static_cast<double>(*stage.steps)
                              : 1 - left / (end - stage_start_);
      step();
    }
  }

  /// Velocities of the scene, after stages that brought it to rest.
  void set_initial_velocities() {
    const std::vector<solver::Block>& blocks = simulation_.scene().blocks;
    std::vector<solver::BlockVelocity> given;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const solver::Block& block = blocks[b];
      if (block.kind >= solver::BlockKind::Fixed) continue;
      if (!block.velocity.isZero(0.0) || !block.angular_velocity.isZero(0.0))
        given.push_back({static_cast<int>(b), block.velocity, block.angular_velocity});
    }
    if (!given.empty()) simulation_.set_velocities(given);
  }

  /// Those that a stage states.
  void set_velocities(const Stage& stage) {
    std::vector<solver::BlockVelocity> given;
    for (const StageVelocity& stated : stage.velocities) {
      const auto b = static_cast<std::size_t>(stated.block);
      const BlockState& now = simulation_.state().blocks[b];
      if (simulation_.scene().blocks[b].kind >= solver::BlockKind::Fixed) continue;
      given.push_back(
          {stated.block, stated.velocity.value_or(now.velocity),
           stated.angular_velocity.value_or(Vector3(now.rotation * now.angular_velocity))});
    }
    if (!given.empty()) simulation_.set_velocities(given);
  }

  void note_flags(const StepReport& report, const DrivenPlaces& before) {
    for (const solver::StepFlag& flag : report.flags) note_flag(flag, report.time);
    if (const solver::StepFlag flag = driven_overlap(before); flag.value > flag.limit)
      note_flag(flag, report.time);
  }

  void note_flag(const solver::StepFlag& flag, double time) {
    auto known = std::find_if(result_.flags.begin(), result_.flags.end(),
                              [&](const RunFlag& f) { return f.worst.kind == flag.kind; });
    if (known == result_.flags.end())
      known = result_.flags.insert(known, {.worst = flag, .first_time = time});
    ++known->steps;
    known->fails = known->fails || flag.fails;
    // One that fails the run before any that does not.
    if (std::pair(flag.fails, flag.value) > std::pair(known->worst.fails, known->worst.value))
      known->worst = flag;
  }

  /// None where no block is driven.
  DrivenPlaces driven_places() const {
    const std::vector<solver::Block>& blocks = simulation_.scene().blocks;
    const auto is_driven = [](const solver::Block& block) {
      return block.kind == solver::BlockKind::Prescribed;
    };
    DrivenPlaces places;
    if (std::ranges::none_of(blocks, is_driven)) return places;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (!is_held(static_cast<int>(b))) continue;
      const BlockState& now = simulation_.state().blocks[b];
      const geometry::Placement& first = file_.scene.blocks[b].placement;
      const Vector3 arm = first.translation - start_[b].centroid;
      places[b] = {.linear = now.rotation.toRotationMatrix() * first.linear,
                   .translation = now.centroid + now.rotation * arm};
    }
    return places;
  }

  /// Least extent along a face's normal, m.
  static double thickness(const geometry::Shape& shape) {
    double least = shape.diameter();
    for (int f = 0; f < shape.topology().face_count(); ++f) {
      const Eigen::RowVectorXd along = shape.face_normal(f).transpose() * shape.vertices();
      least = std::min(least, along.maxCoeff() - along.minCoeff());
    }
    return least;
  }

  /// Of two blocks at these places, m.
  static double depth(const solver::Block& x, const geometry::Placement& at_x,
                      const solver::Block& y, const geometry::Placement& at_y) {
    double deepest = 0.0;
    for (const geometry::Shape& part : x.convex_parts()) {
      for (const geometry::Shape& other : y.convex_parts()) {
        const auto nearest = geometry::nearest_features_within({part, at_x}, {other, at_y}, 0.0);
        if (nearest) deepest = std::max(deepest, -nearest->gap);
      }
    }
    return deepest;
  }

  /// Whether two blocks that stand apart before and after a step come as `near` (m) within it.
  static bool met(const solver::Block& x, const geometry::Placement& x0,
                  const geometry::Placement& x1, const solver::Block& y,
                  const geometry::Placement& y0, const geometry::Placement& y1, double near) {
    const geometry::Motion way_x = motion_between(x0, x1, x0.translation);
    const geometry::Motion way_y = motion_between(y0, y1, y0.translation);
    bool meet = false;
    for (const geometry::Shape& part : x.convex_parts()) {
      for (const geometry::Shape& other : y.convex_parts()) {
        if (geometry::nearest_features_within({part, x0}, {other, y0}, near) ||
            geometry::nearest_features_within({part, x1}, {other, y1}, near))
          return false;
        const geometry::Impact impact =
            time_of_impact({part, x0}, way_x, {other, y0}, way_y, {.length = near});
        meet = meet || impact.status == geometry::ImpactStatus::Impact;
      }
    }
    return meet;
  }

  /// The deepest overlap into which a motion has driven a block with another one without unknowns:
  /// they have no contacts. Right through it is as deep as the smaller one. Value 0: there is none.
  solver::StepFlag driven_overlap(const DrivenPlaces& before) const {
    solver::StepFlag worst{
        .kind = solver::FlagKind::Overlap, .limit = kDrivenOverlap, .fails = true};
    const std::vector<solver::Block>& blocks = simulation_.scene().blocks;
    const DrivenPlaces now = driven_places();
    for (const auto& [p, at_p] : now) {
      if (blocks[p].kind != solver::BlockKind::Prescribed) continue;
      for (const auto& [q, at_q] : now) {
        const solver::Block &x = blocks[p], &y = blocks[q];
        if (q == p || (q < p && y.kind == x.kind)) continue;
        const double size = std::min(x.shape->diameter(), y.shape->diameter());
        const double deep = depth(x, at_p, y, at_q);
        double share = 0.0;
        if (deep > 0.0)
          share = (deep - depth(x, x.placement, y, y.placement)) /
                  std::min(thickness(*x.shape), thickness(*y.shape));
        else if (met(x, before.at(p), at_p, y, before.at(q), at_q, kMeets * size))
          share = 1.0;
        if (!(share > worst.value)) continue;
        worst.value = share;
        worst.block = static_cast<int>(std::min(p, q));
        worst.other = static_cast<int>(std::max(p, q));
      }
    }
    return worst;
  }

  void step() {
    const DrivenPlaces before = driven_places();
    const StepReport report = simulation_.advance();
    if (report.status == solver::StepStatus::Stopped) return;  // as if it had not begun
    simulation_report_ = report;
    stepped_ = true;
    add(report, result_.total);
    note_flags(report, before);
    ++result_.steps;
    ++result_.stages.back().steps;
    note_stage(report, result_.stages.back());
    if (report.status != solver::StepStatus::Converged) not_converged(report);
    const State& state = simulation_.state();
    result_.monitors = watch_.values(simulation_);
    if (dynamic_start_) {
      compare(dynamic_time());
      measure_energy(state.energy);
    }
    if (options_.after_step) options_.after_step(view(), save_);
    must_stop();
  }

  static void note_stage(const StepReport& report, StageResult& stage) {
    stage.unbalance = report.unbalance;
    stage.verdict = report.verdict;
    stage.travel = report.travel;
    stage.travel_block = report.travel_block;
  }

  void not_converged(const StepReport& report) {
    ++result_.unconverged_steps;
    fail(RunStatus::NotConverged,
         describe(report) + not_finite(simulation_.scene(), report.time, simulation_.options()) +
             fighting(report) + rounded(report) +
             (options_.on_failure == RunOptions::OnFailure::Stop ? admissible() : ""));
    going_ = going_ && report.status != solver::StepStatus::Diverged;  // no try to go on from
    if (going_) simulation_.take_best_try();
  }

  /// Notes the first failure, and stops unless failures are accepted.
  void fail(RunStatus status, const std::string& message) {
    if (result_.status == RunStatus::Completed) {
      result_.status = status;
      result_.message = message;
    }
    going_ = going_ && options_.on_failure == RunOptions::OnFailure::Accept;
  }

  /// Growth is judged by the whole run: of a step's scale it says little while nothing has moved
  /// yet. Overlaps that are kept give energy.
  void judge_growth() {
    if (file_.scene.initial_overlap == solver::InitialOverlap::Keep) return;
    const auto grows = [&] {
      return limit_exceeded(file_, result_, result_.energy_growth, result_.energy_scale)
          .has_value();
    };
    for (RunFlag& flag : result_.flags)
      if (flag.worst.kind == solver::FlagKind::EnergyGrowth) flag.fails = grows();
  }

  /// A run that came to its end, with flags that fail it, has not been completed well.
  void judge_flags() {
    judge_growth();
    if (result_.status != RunStatus::Completed) return;
    const std::vector<std::string> lines = failing_flags(file_, result_);
    if (lines.empty()) return;
    result_.status = RunStatus::NotTrusted;
    result_.message = lines.front();
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
    if (!dynamic_start_) compare(0.0);
    if (stopped_) {
      result_.status = *stopped_;
      const char* limit =
          stepped_ ? "the time limit is over" : "the time limit is over, no step has ended";
      result_.message = *stopped_ == RunStatus::Interrupted ? "interrupted" : limit;
    }
    result_.energy = simulation_.state().energy;
    judge_flags();
    for (const Comparison& comparison : comparisons_)
      result_.references.push_back(comparison.result());
    const State& state = simulation_.state();
    result_.threads = simulation_.threads();
    result_.time = state.time;
    result_.dynamic_time = dynamic_time();
    result_.ties = state.ties;
    result_.wall_seconds += seconds_since(started_);
    for (const Contact& contact : state.contacts) {
      if (is_held(contact.point.key.a) == is_held(contact.point.key.b)) continue;
      const bool b = is_held(contact.point.key.b);
      result_.base_reaction += b ? force_on_b(contact) : Vector3(-force_on_b(contact));
    }
  }

  bool is_held(int block) const {
    const solver::BlockKind kind = simulation_.scene().blocks[static_cast<std::size_t>(block)].kind;
    return kind == solver::BlockKind::Fixed || kind == solver::BlockKind::Prescribed;
  }

  const SceneFile& file_;
  const RunOptions& options_;
  Simulation simulation_;
  const std::vector<BlockState> start_ = simulation_.state().blocks;
  Watch watch_;
  std::vector<Comparison> comparisons_;
  RunResult result_;
  StagedWork work_;
  StepReport simulation_report_;
  std::optional<double> dynamic_start_;
  std::optional<RunStatus> stopped_;
  std::size_t stage_ = 0;
  bool going_ = true;
  double progress_ = 0.0;
  double stage_start_ = 0.0;              ///< of the present stage: dynamic_time(), s
  bool stepped_ = false;                  ///< since the run began, or went on
  std::vector<Vector3> moved_from_;       ///< centroids then, where the stage asks for them
  std::vector<BlockState> counted_from_;  ///< StepView
  double time_step_ = 0.0;                ///< of the last step, s: only in a checkpoint
  const SaveRun save_ = [this](std::ostream& out) { save(out); };
  std::chrono::steady_clock::time_point started_{};
  double least_energy_ = 0.0, largest_kinetic_ = 0.0;
  double least_potential_ = 0.0, largest_potential_ = 0.0;
};

}  // namespace

std::vector<std::string> failures(const SceneFile& file, const RunResult& result) {
  std::vector<std::string> lines;
  const bool ended =
      result.status == RunStatus::Completed || result.status == RunStatus::NotTrusted;
  if (!ended) lines.push_back(result.message);
  if (result.unconverged_steps > 0) {
    lines.push_back(std::to_string(result.unconverged_steps) + " of " +
                    std::to_string(result.steps) + " steps did not converge");
  }
  for (std::string& line : failing_flags(file, result)) lines.push_back(std::move(line));
  for (std::size_t r = 0; r < result.references.size(); ++r) {
    const ReferenceResult& compared = result.references[r];
    if (compared.ok) continue;
    std::ostringstream line;
    line << "reference \"" << file.references[r].name << "\": ";
    if (compared.compared == 0)
      line << "no step ended within its time";
    else if (std::isnan(compared.error))
      line << "its error is not a number";
    else if (file.references[r].allowed > 0)
      line << "error " << compared.error << ", allowed " << file.references[r].allowed;
    else
      line << "error " << compared.error;
    lines.push_back(line.str());
  }
  return lines;
}

RunResult run_scene(const SceneFile& file, const RunOptions& options) {
  return Runner(file, options).run();
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

const char* name(RunStatus status) {
  constexpr const char* kNames[] = {"completed",     "not_converged", "not_at_rest", "mechanism",
                                    "stage_refused", "not_trusted",   "interrupted", "time_limit"};
  return kNames[static_cast<std::size_t>(status)];
}

}  // namespace quoin::scene_file
