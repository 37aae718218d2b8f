#pragma once
/// Cells of the stability table: one scene with one extreme parameter, run and judged.

#include <array>
#include <functional>
#include <map>
#include <quoin/solver/simulation.hpp>
#include <string>
#include <vector>

namespace quoin::stability {

using solver::Vector3;

inline constexpr double kGravity = 9.81;  ///< m/s2
double radians(double degrees);
double decade(int exponent);  ///< that power of ten

/// What the run itself tells, gathered before any reference is looked at.
struct Evidence {
  long steps = 0;
  long solves = 0;
  long unconverged = 0;
  double unbalance = 0.0;                         ///< of the last static step
  std::array<bool, solver::kFlagKinds> raised{};  ///< StepReport::flags of any step, by kind
};

/// Names of the flags that were raised, in the order of FlagKind.
std::vector<std::string> flag_names(const Evidence& evidence);

struct Parameter {
  std::string name;
  double value = 0.0;
};

struct Result {
  double error = 0.0;  ///< against the exact answer
  Evidence evidence{};
};

struct Cell {
  std::string name;                     ///< "slide / paper"
  std::vector<Parameter> parameters{};  ///< the first one is what the row varies
  double allowed = 0.0;
  std::function<Result()> run{};
  /// Of the cell's blocks. Only the source's own methods may leave a step unconverged.
  solver::ContactMethod method = solver::ContactMethod::AugmentedLagrangian;
};

/// Flags that a cell is known to raise (expected_flags.json), by name; usually none.
/// Throws std::runtime_error when the list names a cell, a value or a flag that there is not.
class ExpectedFlags {
 public:
  explicit ExpectedFlags(const std::vector<Cell>& cells);
  const std::vector<std::string>& of(const Cell& cell) const;

 private:
  std::map<std::string, std::vector<std::string>> by_cell_;
};

/// "penalty / slide / paper": what is varied and the row.
std::string row_name(const Cell& cell);

/// Scale of the long runs.
enum class Extent : std::uint8_t { Full, Quick };

/// `scenes`: the folder of scene files.
std::vector<Cell> all_cells(Extent extent, const std::string& scenes);
void append_penalty_cells(std::vector<Cell>& cells);
void append_material_cells(std::vector<Cell>& cells);
void append_geometry_cells(std::vector<Cell>& cells);
void append_collapse_cells(const std::string& scenes, std::vector<Cell>& cells);
void append_moving_cells(std::vector<Cell>& cells);
void append_time_cells(Extent extent, std::vector<Cell>& cells);

/// A simulation with its evidence.
class Run {
 public:
  Run(solver::Scene scene, const solver::StepOptions& options);
  /// Static steps of `time_step` until the unbalance is below 1e-12 or `most` steps are done.
  void rest(double time_step, solver::Analysis analysis = solver::Analysis::Static, int most = 100);
  void steps(long count);
  solver::Simulation& simulation() { return simulation_; }
  const solver::Simulation& simulation() const { return simulation_; }
  Vector3 place(int block) const;    ///< world, m
  double force(int a, int b) const;  ///< normal force between two blocks, N
  Evidence evidence;

 private:
  void step();
  solver::Simulation simulation_;
};

/// A block on a slope, the plane being block 0 and the block 1.
struct Slide {
  double slope = 20.0, friction = 10.0;  ///< degrees
  Vector3 size = Vector3::Ones();        ///< along, across, normal, m
  double density = 2600.0, young = 0.0;  ///< young 0: rigid
  Vector3 origin = Vector3::Zero();      ///< of the scene, m
  double time_step = 0.01;               ///< s
  double rest_step = 0.01;               ///< s: it settles in steps 100 times as long
  long steps_before = 0;                 ///< dynamic, before the way is measured (blocks that stay)
  long steps = 200;
  solver::ContactMethod method = solver::ContactMethod::AugmentedLagrangian;
  double penalty = 0.0;
};
/// Settles, is let go; error of the way gone relative to it (absolute, in block sizes, where it
/// stays).
Result run_slide(const Slide& slide);

/// Blocks standing one on another on a fixed one.
struct Stack {
  std::vector<double> densities{};  ///< from the bottom
  std::vector<double> youngs{};     ///< Pa; empty: rigid
  Vector3 size = Vector3::Ones();   ///< of each, m
  Vector3 origin = Vector3::Zero();
  double time_step = 0.01;
  double rest_step = 0.01;  ///< s: it comes to rest in static steps 100 times as long
  long steps = 100;         ///< dynamic, from sudden gravity when rigid, from rest else
  solver::ContactMethod method = solver::ContactMethod::AugmentedLagrangian;
  double penalty = 0.0;
};
/// Largest error of an interface's force relative to the weight above.
Result run_stack(const Stack& stack);
/// Largest error of a block's mean axial strain after static steps, relative to the exact one.
Result run_column_strain(const Stack& stack);

}  // namespace quoin::stability
