#pragma once
/// Runs a scene: options, advance(), what a step reports.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iosfwd>
#include <memory>
#include <quoin/solver/state.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace quoin::solver {

enum class ContactMethod : std::uint8_t {
  AugmentedLagrangian,  ///< exact contact; needs no penalty
  Springs,              ///< springs of stiffness `penalty`, solved as the exact contact is
  Paper,                ///< Algorithm 1 of the source as it stands, for comparison
  Penalty  ///< the source's penalty method: the same open-close iteration, no multipliers
};

/// As in scene files: "augmented_lagrangian", "springs", "paper", "penalty".
const char* name(ContactMethod method);

/// How the forces of exact contacts are found.
enum class ContactIteration : std::uint8_t {
  OpenClose,  ///< Newton's method on the augmented Lagrangian: exact to rounding where blocks rest
  ProximalNewton,  ///< on friction cones, for crowds that slide, rock and pile up; where hard
                   ///< contacts are not found they yield a little
  Automatic  ///< OpenClose; ProximalNewton for islands that it does not solve soon, until they come
             ///< to rest: sooner where few joints hold many blocks
};

/// As in scene files: "open_close", "proximal_newton", "automatic".
const char* name(ContactIteration iteration);

/// How linear systems of the contact iteration are solved.
enum class LinearSolverKind : std::uint8_t {
  Automatic,  ///< of several processes Multigrid where the factors would be large, else Elimination
  Elimination,  ///< multifrontal, exact to rounding
  Multigrid     ///< of several processes, by PETSc; Elimination where it does not converge, and of
                ///< one process
};

/// As in scene files: "automatic", "elimination", "multigrid".
const char* name(LinearSolverKind kind);

/// What linear systems took.
struct LinearSolverCounts {
  long eliminations = 0;  ///< matrices
  long distributed = 0;   ///< matrices of StepOptions::distributed_solver, of all kinds
  long set_ups = 0;       ///< hierarchies of Multigrid
  long iterations = 0;    ///< of Multigrid
  long fallbacks = 0;     ///< matrices whose iterations did not converge: eliminated

  void add(const LinearSolverCounts& more) {
    eliminations += more.eliminations;
    distributed += more.distributed;
    set_ups += more.set_ups;
    iterations += more.iterations;
    fallbacks += more.fallbacks;
  }
};

enum class TimeScheme : std::uint8_t {
  ConstantAcceleration,  ///< Shi's: forces at the end of the step; damps springs
  EnergyMomentum         ///< forces at the middle of the step: no algorithmic damping
};

enum class Analysis : std::uint8_t {
  Dynamic,
  Static,  ///< steps towards equilibrium, each from rest, with a pseudo-step of their own; take no
           ///< time: State::time stays
  Settle   ///< static, and closed contacts cannot slide: brings contact forces to rest before
           ///< release
};

/// What a static step knows of the equilibrium that it looks for.
enum class StaticVerdict : std::uint8_t {
  Seeking,   ///< not yet; also of every dynamic step
  Rest,      ///< unbalance is at most StepOptions::rest_unbalance, and falls no further
  Mechanism  ///< a block has moved by more than a tenth of itself: no equilibrium near the start
};

/// "seeking", "rest", "mechanism".
const char* name(StaticVerdict verdict);

struct ContactProblem;
class DistributedSolver;
struct StepReport;

struct StepOptions {
  double time_step = 1e-3;  ///< s, of a dynamic step; a static one has its own
  Analysis analysis = Analysis::Dynamic;
  ContactMethod method = ContactMethod::AugmentedLagrangian;
  TimeScheme scheme = TimeScheme::ConstantAcceleration;
  /// N/m. Springs: a contact point; a joint of more than four points has that of four, shared out
  /// by area. Paper, Penalty: a contact point, as the source has it. Not used by
  /// AugmentedLagrangian. 0: chosen by the solver.
  double penalty = 0.0;
  double shear_ratio = 1.0;  ///< shear stiffness / normal stiffness; used like `penalty`
  double reach = 0.0;        ///< contacts are watched up to this gap at least, m; 0: chosen
  double tolerance = 1e-10;  ///< relative, of forces and of gaps to block size
  /// Of AugmentedLagrangian. Steps with springs, cohesion, bonds or held points are always
  /// OpenClose's.
  ContactIteration contact_iteration = ContactIteration::Automatic;
  /// Iterations of one attempt at a sub-step, open–close or proximal Newton, all its rounds
  /// together, and again with each joint that fails in it; Paper, Penalty: linear solves. A step
  /// that can't be solved is tried eleven times, each half as long.
  int max_iterations = 1000;
  /// Of the default's contact iteration. ProximalNewton, Paper and Penalty eliminate.
  LinearSolverKind linear_solver = LinearSolverKind::Automatic;
  /// Of several processes that take the same steps (quoin/solver/ranks.hpp): solves what
  /// `linear_solver` names; Automatic: what would be Multigrid's, by multigrid. None: this process
  /// is alone. The same for all steps of a simulation.
  std::shared_ptr<DistributedSolver> distributed_solver{};
  double max_displacement_ratio = 0.0;  ///< largest displacement / block size; 0: no limit
  double smallest_time_step = 0.0;      ///< s; 0: time_step / 1024
  double rest_unbalance = 1e-6;         ///< static: StepReport::unbalance at rest
  int threads = 1;                      ///< any number gives the same bits
  /// Asked some twenty times a second in a step that lasts, with what it has come to so far, on the
  /// thread of advance(); false ends the step as Stopped. Must not throw.
  std::function<bool(const StepReport&)> watch{};
  /// Given the contact problem of the first linearisation of each attempt at a sub-step of each
  /// island before it is solved, where contacts have Coulomb's law alone. Must not throw.
  std::function<void(const ContactProblem&)> contact_problem{};
};

enum class StepStatus : std::uint8_t {
  Converged,
  NotConverged,
  Diverged,
  Stopped  ///< by StepOptions::watch: the state is that before the step
};

/// Run time by phase, s.
struct PhaseSeconds {
  double detect = 0.0;    ///< contact search
  double assemble = 0.0;  ///< history handed on, terms of blocks, contacts linearised
  double solve = 0.0;     ///< open–close iteration: contact forces, matrices, linear systems
  double update = 0.0;    ///< the new state, energy

  void add(const PhaseSeconds& more) {
    detect += more.detect;
    assemble += more.assemble;
    solve += more.solve;
    update += more.update;
  }
};

/// What a result should not be trusted for without a look. Limits: README, "Flags".
enum class FlagKind : std::uint8_t {
  Unconverged,   ///< the step was not solved; value: relative force residual
  Strain,        ///< larger than small-strain theory is good for
  Overlap,       ///< of two blocks by the smaller one's size
  Rounding,      ///< of a gap, against the tolerance of gaps
  EnergyGrowth,  ///< in one step, by the scale of the run's energy
  LostContact,   ///< overlap of a failed step that no attempt held; a closed contact whose blocks
                 ///< are no longer found near each other
  Turn,          ///< of a block in a sub-step, rad: its square, by twelve, is lost of it
  Impacts        ///< one that follows from another in the same sub-step, and is solved with it;
                 ///< value: the gap in between by the size of the smaller block
};

inline constexpr std::size_t kFlagKinds = 8;

struct StepFlag {
  FlagKind kind = FlagKind::Unconverged;
  double value = 0.0, limit = 0.0;  ///< relative
  int block = -1, other = -1;       ///< where it is worst; -1: no block, the whole scene
  bool fails = false;  ///< the step's result is not to be trusted; else to within `value`
};

/// At most one of each kind.
class StepFlags {
 public:
  void push_back(const StepFlag& flag) { flags_[count_++] = flag; }
  const StepFlag* begin() const { return flags_.data(); }
  const StepFlag* end() const { return flags_.data() + count_; }
  const StepFlag& operator[](std::size_t i) const { return flags_[i]; }
  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }

 private:
  std::array<StepFlag, kFlagKinds> flags_{};
  std::size_t count_ = 0;
};

std::string_view name(FlagKind kind);  ///< "unconverged", "strain", …

/// A contact of a step that was not solved whose forces had not come to rest.
struct FightingContact {
  int block = -1, other = -1;
  Vector3 place = Vector3::Zero();  ///< world, m
  double change = 0.0;              ///< of its force in the next iteration, N
};

/// The worst contact of each pair of blocks, the worst pair first.
struct FightingContacts {
  std::array<FightingContact, 3> contacts{};
  std::size_t count = 0;
  const FightingContact* begin() const { return contacts.data(); }
  const FightingContact* end() const { return contacts.data() + count; }
};

struct StepReport {
  StepStatus status = StepStatus::Converged;
  double time = 0.0;  ///< at the end, s
  /// Groups of blocks that contacts join are solved each by itself: counts are those of the island
  /// that took most, cuts those of all.
  int islands = 0;
  int islands_at_rest = 0;  ///< of these: stand as in the last step, and took nothing
  int sub_steps = 0;
  int cuts_by_displacement = 0;
  int cuts_by_convergence = 0;
  int cuts_by_contact = 0;  ///< a fast block would have passed through another
  int iterations = 0;       ///< open–close
  int linear_solves = 0;
  long block_solves = 0;  ///< of all islands: linear solves times blocks
  int factorizations = 0;
  LinearSolverCounts linear{};
  int proximal_newton_attempts = 0;  ///< at a sub-step: those that it solved
  double residual = 0.0;         ///< relative force residual of the last iteration; inf: diverged
  double largest_overlap = 0.0;  ///< m
  /// Largest of the blocks' forces that make the step's motion from rest / weight, or 0.01 of the
  /// largest weight, load or contact force, if that is more; without gravity / that force.
  double unbalance = 0.0;
  StaticVerdict verdict = StaticVerdict::Seeking;
  double travel = 0.0;    ///< static: farthest way of a block since the analysis began, less what
                          ///< strains and springs explain, by the block's size
  int travel_block = -1;  ///< that block; -1: none
  double largest_speed = 0.0;      ///< m/s, of a vertex
  double stiffest_omega_dt = 0.0;  ///< of the stiffest spring (Springs, Penalty); 0 without
  double numerical_damping = 0.0;  ///< damping ratio that goes with it
  double condition = 0.0;          ///< estimate for the system solved last; 0: nothing solved
  double largest_strain = 0.0;
  int candidate_pairs = 0;  ///< block pairs near enough to touch, all searches of the step
  int searched_pairs = 0;   ///< of these: not left as they were by both blocks
  int contact_count = 0;
  int closed_count = 0;
  StepFlags flags{};
  FightingContacts fighting{};  ///< when not solved (methods of the default's iteration)
  PhaseSeconds seconds{};
};

/// The larger one; what is no number is worse than any.
inline double worse_residual(double a, double b) { return b > a || std::isnan(b) ? b : a; }

/// One line for a person: status, what was tried, residual.
std::string describe(const StepReport& report);

/// Of a block that can move.
struct BlockVelocity {
  int block = 0;
  Vector3 velocity = Vector3::Zero();          ///< of the centroid, m/s
  Vector3 angular_velocity = Vector3::Zero();  ///< world axes, rad/s
};

class Simulation {
 public:
  /// Checks the scene and compiles it. Throws InputError.
  Simulation(Scene scene, const StepOptions& options);
  /// Goes on from what save() wrote, with the scene and the options() of that time. Throws
  /// InputError as load() does.
  Simulation(Scene scene, const StepOptions& options, std::istream& saved);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// One time_step (in counted sub-steps where it must). When the status is not Converged the state
  /// is that of the last accepted sub-step (before the step, when Stopped); best_try() holds the
  /// best attempt. Throws what a function of time throws; until a step is accepted nothing changes.
  [[nodiscard]] StepReport advance();

  const Scene& scene() const;
  const State& state() const;
  const StepOptions& options() const;
  int threads() const;  ///< at work: no more than blocks that move, or than the system starts
  bool threads_refused() const;                  ///< the system starts no more
  void set_options(const StepOptions& options);  ///< from the next step on
  /// From the next step on these blocks move so; a settled scene starts to move. The energy that
  /// this brings or takes counts as work. Throws InputError for a block without unknowns and for
  /// what is not finite, and changes nothing.
  void set_velocities(std::span<const BlockVelocity> velocities);
  /// From the next step on the scene is this one: the same blocks with the same shapes in the same
  /// placements, in other kinds, with other materials, joints, motions, loads, held points,
  /// gravity. Places, strains, contacts and their history stay, and velocities of what can move. A
  /// block that was absent stands where the scene has it, with its velocities there, and is laid in
  /// the next step; one that becomes fixed stays where it is. Blocks without unknowns have no
  /// contacts. One that is set free has the joints with others that the two had when one of them
  /// could move last, or were laid with, as long as neither has moved since; else they have met. A
  /// motion counts from where its block stands, with the velocity it has; a point that was not held
  /// before is held where it is. The energy that this brings or takes counts as work. Throws
  /// InputError, and changes nothing, for other blocks, for what the constructor refuses, and for a
  /// block that appears, or is set free, within another.
  void change(Scene scene);
  const State& best_try() const;  ///< after a step that did not converge
  void take_best_try();           ///< accept it and go on

  Vector6 stress(int block) const;  ///< Pa, world axes, tension positive
  Vector3 reference_arm(int block, const Vector3& world_point) const;  ///< of a material point now
  geometry::Points reference_arms(int block) const;  ///< of the shape's vertices, 3 × n, m
  geometry::Points vertices(int block) const;        ///< in the world now, 3 × n, m
  /// Of a material point since the start, m. No digits are lost to where the scene stands.
  Vector3 displacement(int block, const Vector3& reference_arm) const;
  /// Writes all that the steps to come depend on. A Simulation of the same scene, with the same
  /// options(), that reads it goes on to the bit as this one does. Only the same build reads it.
  void save(std::ostream& out) const;
  /// Goes on from what save() wrote. Throws InputError when that is of blocks of other shapes,
  /// placements, kinds or materials, damaged or cut short: then nothing has changed.
  void load(std::istream& in);

  /// What this scene does not need with these options and is not done, and why.
  std::vector<std::string> left_out() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace quoin::solver
