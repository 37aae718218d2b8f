#include <algorithm>
#include <cmath>
#include <cstdio>
#include <quoin/geometry/broad_phase.hpp>
#include <quoin/solver/simulation.hpp>
#include <sstream>

#include "base/index.hpp"
#include "base/messages.hpp"
#include "linear/linear_solver.hpp"
#include "simulation/checkpoint.hpp"
#include "simulation/scene_change.hpp"
#include "source_method/paper_step.hpp"
#include "step/contact_search.hpp"
#include "step/step_control.hpp"

namespace quoin::solver {
namespace {

// What a scene does not need: each line names what is not done and why; only what the code really
// leaves out stands here.

template <typename Has>
bool any_joint(const Scene& scene, const Has& has) {
  const auto of_pair = [&](const auto& pair) { return has(pair.joint); };
  return has(scene.joint) || std::ranges::any_of(scene.pair_joints, of_pair) ||
         std::ranges::any_of(scene.block_joints, of_pair);
}

std::string of_blocks(std::ptrdiff_t count) {
  return " of " + std::to_string(count) + (count == 1 ? " block" : " blocks");
}

void say_blocks(const CompiledScene& compiled, std::vector<std::string>& out) {
  const std::vector<BlockModel>& models = compiled.models;
  const auto count = [&](int unknowns) {
    return std::ranges::count(models, unknowns, &BlockModel::unknowns);
  };
  const auto absent = std::ranges::count(models, BlockKind::Absent, &BlockModel::kind);
  const auto held = count(0) - absent, rigid = count(6);
  if (held > 0)
    out.push_back("unknowns and mass terms" + of_blocks(held) + ": fixed or prescribed");
  if (absent > 0) out.push_back("all" + of_blocks(absent) + ": absent");
  if (held > 1) out.push_back("contact search between blocks that are fixed or prescribed");
  if (rigid > 0) out.push_back("strain and elasticity" + of_blocks(rigid) + ": rigid");
  std::ptrdiff_t stressed = 0;
  for (const Block& block : compiled.scene.blocks)
    stressed += block.kind == BlockKind::Rigid && !block.initial_stress.isZero(0.0) ? 1 : 0;
  if (stressed > 0) out.push_back("initial stress" + of_blocks(stressed) + ": rigid");
  if (geometry::tries_all_pairs(models.size())) {
    out.push_back("tree of the broad phase: " + std::to_string(models.size()) +
                  (models.size() == 2 ? " blocks are one pair" : " blocks, all pairs are tried"));
  }
}

void say_forces(const CompiledScene& compiled, const StepOptions& options,
                std::vector<std::string>& out) {
  const Scene& scene = compiled.scene;
  const bool rough =
      any_joint(scene, [](const Joint& j) { return j.friction_angle > 0.0 || j.cohesion > 0.0; });
  if (!rough && options.analysis != Analysis::Settle)
    out.push_back("shear forces and friction limits: no joint has friction or cohesion");
  if (options.method == ContactMethod::Springs || options.method == ContactMethod::Penalty)
    out.push_back("multipliers and velocity law: contacts are springs");
  if (options.method == ContactMethod::Paper) out.push_back("velocity law: the source has none");
  if (is_paper_method(options.method) && any_joint(scene, [](const Joint& j) {
        return j.restitution > 0.0 || j.dilation_angle > 0.0;
      }))
    out.push_back("restitution and dilation: the source has none");
  if (is_paper_method(options.method) && any_joint(scene, [](const Joint& j) {
        return j.normal_stiffness > 0.0 || j.residual_friction_angle >= 0.0 ||
               j.softening_slip > 0.0 || j.residual_cohesion > 0.0 || j.residual_tension > 0.0;
      }))
    out.push_back("stiffness of joints, softening and residual values: the source has none");
  const bool springs = any_joint(scene, [](const Joint& j) { return j.normal_stiffness > 0.0; });
  const bool bounces = any_joint(scene, [&](const Joint& j) {
    return j.restitution > 0.0 &&
           (j.normal_stiffness > 0.0 || options.method == ContactMethod::Springs);
  });
  if (bounces && !is_paper_method(options.method))
    out.push_back("restitution of joints that are springs: these rebound as they store energy");
  if (options.method == ContactMethod::AugmentedLagrangian && !springs)
    out.push_back("contact springs: contacts are exact, penalty and shear_ratio are not used");
  if (compiled.loads.empty()) out.push_back("load terms: no point, face, body or pressure load");
  if (is_paper_method(options.method) && !(compiled.ties.empty() && compiled.quiet.empty()))
    out.push_back("ties and quiet faces: the source has none");
  if (compiled.held.empty()) out.push_back("held points: none in the scene");
  if (compiled.prescribed.empty()) out.push_back("prescribed motion: no block has one");
}

}  // namespace

Vector3 local_point(const State& state, int block, const Vector3& reference_arm) {
  const Pose now = pose(state.blocks[index(block)]);
  return now.centroid + (now.centroid_rest + now.shape * reference_arm);
}

Vector3 world_point(const State& state, int block, const Vector3& reference_arm) {
  return state.origin + local_point(state, block, reference_arm);
}

const char* name(ContactMethod method) {
  static constexpr const char* kNames[] = {"augmented_lagrangian", "springs", "paper", "penalty"};
  return kNames[static_cast<std::size_t>(method)];
}

const char* name(ContactIteration iteration) {
  static constexpr const char* kNames[] = {"open_close", "proximal_newton", "automatic"};
  return kNames[static_cast<std::size_t>(iteration)];
}

const char* name(LinearSolverKind kind) {
  static constexpr const char* kNames[] = {"automatic", "elimination", "multigrid"};
  return kNames[static_cast<std::size_t>(kind)];
}

const char* name(StaticVerdict verdict) {
  static constexpr const char* kNames[] = {"seeking", "rest", "mechanism"};
  return kNames[static_cast<std::size_t>(verdict)];
}

std::string describe(const StepReport& report) {
  static constexpr const char* kNames[] = {"converged", "did not converge", "diverged",
                                           "was stopped"};
  char text[256];
  std::snprintf(
      text, sizeof text,
      "step to %.9g s %s: %d sub-step(s), %d cut(s) for convergence, %d for displacement, "
      "%d open-close iterations, %d solves, residual %.3g",
      report.time, kNames[static_cast<int>(report.status)], report.sub_steps,
      report.cuts_by_convergence, report.cuts_by_displacement, report.iterations,
      report.linear_solves, report.residual);
  return text;
}

struct Simulation::Parts {
  Parts(Scene scene, const StepOptions& step_options)
      : compiled(compile(std::move(scene))),
        options(step_options),
        state(initial_state(compiled)),
        work(compiled, step_options) {
    work.other_method = std::make_unique<PaperMethod>(compiled.slots, &work.watch);
  }

  void read(std::istream& saved);

  CompiledScene compiled;
  StepOptions options;
  State state;
  State best;
  Workspace work;
};

namespace {

/// What the source's methods lack.
void check_paper_method(const StepOptions& options) {
  if (!is_paper_method(options.method)) return;
  const std::string method = std::string("method ") + name(options.method);
  if (options.scheme != TimeScheme::ConstantAcceleration)
    throw InputError(method + " knows the scheme constant_acceleration alone");
}

void check(const StepOptions& options) {
  const auto require = [](bool good, const char* what, double value) {
    if (good) return;
    std::ostringstream line;
    line << what << " (is " << value << ")";
    throw InputError(line.str());
  };
  require(options.time_step > 0.0 && std::isfinite(options.time_step),
          "time step must be greater than 0 s", options.time_step);
  require(options.penalty >= 0.0 && std::isfinite(options.penalty),
          "penalty must not be negative, N/m", options.penalty);
  require(options.shear_ratio > 0.0 && std::isfinite(options.shear_ratio),
          "shear ratio must be finite and greater than 0", options.shear_ratio);
  require(options.reach >= 0.0 && std::isfinite(options.reach),
          "reach must be finite and not negative, m", options.reach);
  require(options.tolerance > 0.0 && options.tolerance < 1e-2, "tolerance must lie in (0, 0.01)",
          options.tolerance);
  require(options.max_iterations > 0, "max iterations must be at least 1", options.max_iterations);
  require(options.max_displacement_ratio >= 0.0, "displacement ratio must not be negative",
          options.max_displacement_ratio);
  require(options.smallest_time_step >= 0.0 && options.smallest_time_step <= options.time_step,
          "smallest time step must lie in [0, time step], s", options.smallest_time_step);
  require(options.rest_unbalance > 0.0, "unbalance at rest must be greater than 0",
          options.rest_unbalance);
  require(options.threads >= 1, "threads must be at least 1", options.threads);
  check_paper_method(options);
}

void check(const BlockVelocity& given, const std::vector<BlockModel>& models) {
  const std::string what = "velocity of block " + std::to_string(given.block);
  if (given.block < 0 || given.block >= static_cast<int>(models.size()) ||
      models[index(given.block)].unknowns == 0)
    throw InputError(what + ": there is no such block with unknowns");
  const auto require = [&](const Vector3& value, const char* unit) {
    if (std::isfinite(value.squaredNorm())) return;
    std::ostringstream line;
    line << what << ": (" << value.transpose() << ") " << unit << " is not finite, or its square";
    throw InputError(line.str());
  };
  require(given.velocity, "m/s");
  require(given.angular_velocity, "rad/s");
}

std::string numbered(const Scene& scene, int block) {
  const std::string& name = scene.blocks[index(block)].name;
  return std::to_string(block) + (name.empty() ? "" : " (" + name + ")");
}

/// Overlap above 1e-3 of the smaller block of what is being laid, and of blocks that had no
/// unknowns `before` and were not looked at, is refused unless the scene keeps it.
void check_overlap(const CompiledScene& compiled, const Workspace& work,
                   std::span<const char> idle_before) {
  if (compiled.scene.initial_overlap != InitialOverlap::Refuse) return;
  const auto size = [&](const geometry::ContactPoint& point) {
    return std::min(compiled.models[index(point.key.a)].size,
                    compiled.models[index(point.key.b)].size);
  };
  const auto overlaps = [&](const geometry::ContactPoint& point) {
    const auto [a, b] = std::pair(point.key.a, point.key.b);
    const bool is_new =
        are_laid(work.laid, a, b) || (idle_before[index(a)] != 0 && idle_before[index(b)] != 0);
    return is_new && !(-point.gap <= 1e-3 * size(point));
  };
  const auto first = std::ranges::find_if(work.found, overlaps);
  if (first == work.found.end()) return;
  const geometry::ContactPoint& point = *first;
  std::ostringstream line;
  line << "blocks " << numbered(compiled.scene, point.key.a) << " and "
       << numbered(compiled.scene, point.key.b) << " overlap by " << -point.gap
       << " m where they stand; the limit is 1e-3 of the smaller block, " << 1e-3 * size(point)
       << " m (initial overlap can be kept, or taken as touching)";
  throw InputError(line.str());
}

}  // namespace

Simulation::Simulation(Scene scene, const StepOptions& options) {
  check(options);
  parts_ = std::make_unique<Parts>(std::move(scene), options);
  detect(parts_->compiled, options, parts_->state, parts_->work);
  check_overlap(parts_->compiled, parts_->work, parts_->compiled.idle);
  InitialDepths& depths = parts_->work.initial_depths;
  depths.remember(parts_->compiled, parts_->work.found, parts_->work.laid);
  depths.take_off(parts_->compiled, parts_->state.blocks, parts_->work.found);
  EnergyLedger& energy = parts_->state.energy;
  energy.kinetic = kinetic_energy(parts_->compiled, parts_->state);
  energy.strain = strain_energy(parts_->compiled, parts_->state);
  energy.contact = initial_spring_energy(parts_->compiled, options, parts_->state, parts_->work);
}

Simulation::Simulation(Scene scene, const StepOptions& options, std::istream& saved) {
  check(options);
  parts_ = std::make_unique<Parts>(std::move(scene), options);
  parts_->read(saved);
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

StepReport Simulation::advance() {
  return solver::advance(parts_->compiled, parts_->options, parts_->state, parts_->best,
                         parts_->work);
}

const Scene& Simulation::scene() const { return parts_->compiled.scene; }
const State& Simulation::state() const { return parts_->state; }
const StepOptions& Simulation::options() const { return parts_->options; }

int Simulation::threads() const { return parts_->work.threads.workers(); }

bool Simulation::threads_refused() const { return threads() < parts_->work.threads_wanted; }

void Simulation::set_options(const StepOptions& options) {
  check(options);
  if (options.distributed_solver != parts_->options.distributed_solver)
    throw InputError("the processes of a simulation can't change");
  parts_->options = options;
  parts_->work.search = {};
  detect(parts_->compiled, options, parts_->state, parts_->work);
}

void Simulation::set_velocities(std::span<const BlockVelocity> velocities) {
  const std::vector<BlockModel>& models = parts_->compiled.models;
  for (const BlockVelocity& given : velocities) check(given, models);
  EnergyLedger& energy = parts_->state.energy;
  const double before = energy.kinetic;
  std::vector<char> set_on(models.size());
  for (const BlockVelocity& given : velocities) {
    const std::size_t b = index(given.block);
    BlockState& now = parts_->state.blocks[b];
    energy.kinetic -= kinetic_energy(models[b], now);
    now.velocity = given.velocity;
    now.angular_velocity = now.rotation.conjugate() * given.angular_velocity;
    energy.kinetic += kinetic_energy(models[b], now);
    set_on[b] = 1;
  }
  energy.work += energy.kinetic - before;
  part_hit_contacts(set_on, parts_->options.method, parts_->state);
  detect(parts_->compiled, parts_->options, parts_->state, parts_->work);
}

void Simulation::change(Scene scene) {
  check_same_blocks(parts_->compiled.scene, scene);
  auto next = std::make_unique<Parts>(std::move(scene), parts_->options);
  CompiledScene& compiled = next->compiled;
  State& state = next->state;
  Workspace& work = next->work;
  take_over(parts_->compiled, parts_->state, parts_->work, compiled, state, work);
  part_hit_contacts(set_on(parts_->state, state), next->options.method, state);
  detect(compiled, next->options, state, work);
  check_overlap(compiled, work, parts_->compiled.idle);
  if (work.initial_depths.remember(compiled, work.found, work.laid))
    detect(compiled, next->options, state, work);
  EnergyLedger& energy = state.energy;
  const double before = energy.mechanical();
  energy.kinetic = kinetic_energy(compiled, state);
  energy.strain = strain_energy(compiled, state);
  energy.contact +=
      initial_spring_energy(compiled, next->options, state, work) -
      initial_spring_energy(parts_->compiled, parts_->options, parts_->state, parts_->work);
  energy.work += energy.mechanical() - before;
  parts_ = std::move(next);
}

const State& Simulation::best_try() const { return parts_->best; }

void Simulation::take_best_try() {
  if (parts_->best.blocks.empty()) return;
  parts_->state = parts_->best;
  parts_->work.motion = parts_->work.best_motion;
  parts_->best = State{};
  detect(parts_->compiled, parts_->options, parts_->state, parts_->work);
}

Vector6 Simulation::stress(int block) const {
  const std::size_t b = checked_block(block, parts_->state.blocks.size());
  const BlockState& now = parts_->state.blocks[b];
  const Vector6 local = solver::stress(parts_->compiled.models[b], now.strain);
  Matrix3 tensor;
  tensor << local[0], local[3], local[5], local[3], local[1], local[4], local[5], local[4],
      local[2];
  const Matrix3 rotation = now.rotation.toRotationMatrix();
  const Matrix3 world = rotation * tensor * rotation.transpose();
  Vector6 result;
  result << world(0, 0), world(1, 1), world(2, 2), world(0, 1), world(1, 2), world(0, 2);
  return result;
}

Vector3 Simulation::reference_arm(int block, const Vector3& world_point) const {
  const Pose now = pose(parts_->state.blocks[checked_block(block, parts_->state.blocks.size())]);
  return solver::reference_arm(
      now, (world_point - parts_->state.origin - now.centroid) - now.centroid_rest);
}

geometry::Points Simulation::reference_arms(int block) const {
  return solver::reference_arms(
      parts_->compiled.models[checked_block(block, parts_->compiled.models.size())]);
}

geometry::Points Simulation::vertices(int block) const {
  geometry::Points places = reference_arms(block);
  for (Eigen::Index v = 0; v < places.cols(); ++v)
    places.col(v) = world_point(parts_->state, block, places.col(v)).eval();
  return places;
}

Vector3 Simulation::displacement(int block, const Vector3& reference_arm) const {
  const std::size_t b = checked_block(block, parts_->state.blocks.size());
  return solver::displacement(parts_->compiled.models[b], pose(parts_->state.blocks[b]),
                              reference_arm);
}

void Simulation::save(std::ostream& out) const {
  write_checkpoint(out, parts_->compiled, parts_->state, parts_->work);
}

void Simulation::Parts::read(std::istream& saved) {
  read_checkpoint(saved, compiled, state, work);
  place_bodies(compiled, state, work);
}

void Simulation::load(std::istream& in) {
  auto next = std::make_unique<Parts>(parts_->compiled.scene, parts_->options);
  next->read(in);
  parts_ = std::move(next);
}

std::vector<std::string> Simulation::left_out() const {
  std::vector<std::string> out;
  say_blocks(parts_->compiled, out);
  say_forces(parts_->compiled, parts_->options, out);
  if (parts_->options.analysis != Analysis::Dynamic)
    out.push_back("velocities, kinetic energy, restitution: the analysis is static");
  if (parts_->options.threads == 1) out.push_back("worker threads: one thread is asked for");
  return out;
}

}  // namespace quoin::solver
