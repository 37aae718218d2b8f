#pragma once
/// Cells of the stability table: one scene with one extreme parameter, run and judged.

#include <functional>
#include <quoin/solver/simulation.hpp>
#include <string>
#include <vector>

namespace quoin::stability {

using solver::Vector3;

inline constexpr double kGravity = 9.81;  ///< m/s2
double radians(double degrees);

/// What the run itself tells, gathered before any reference is looked at.
struct Evidence {
  long steps = 0;
  long solves = 0;
  long unconverged = 0;
  long cuts = 0;                  ///< steps cut for contact, displacement or convergence
  double largest_overlap = 0.0;   ///< m
  double largest_strain = 0.0;
  double condition = 0.0;         ///< largest estimate
  double stiffest_omega_dt = 0.0;
  double energy_growth = 0.0;     ///< mechanical less work, over its least so far, share of its range
  double unbalance = 0.0;         ///< of the last static step; 0 where there was none
  double block_size = 1.0;        ///< of the smallest moving block, m
  double coordinate = 0.0;        ///< largest of the scene as given, m
  double force_rounding = 0.0;    ///< share of the weight; 0 where no force decides
  double resolved = 0.0;          ///< length that the result is measured against, m; 0: a force or speed
};

/// Names of the criteria that say "do not trust this result to `allowed`"; empty: trusted.
std::vector<std::string> flags(const Evidence& evidence, double allowed);

struct Parameter {
  std::string name;
  double value = 0.0;
};

struct Result {
  double error = 0.0;  ///< against the exact answer
  Evidence evidence{};
};

struct Cell {
  std::string name;                      ///< "penalty / slide / augmented_lagrangian"
  std::vector<Parameter> parameters{};   ///< the first one is what the row varies
  double allowed = 0.0;
  std::function<Result()> run{};
};

/// Scale of the long runs.
enum class Extent : std::uint8_t { Full, Quick };

std::vector<Cell> all_cells(Extent extent);
void append_penalty_cells(std::vector<Cell>& cells);
void append_material_cells(std::vector<Cell>& cells);
void append_geometry_cells(std::vector<Cell>& cells);
void append_collapse_cells(std::vector<Cell>& cells);
void append_time_cells(Extent extent, std::vector<Cell>& cells);

/// A simulation with its evidence.
class Run {
 public:
  Run(solver::Scene scene, const solver::StepOptions& options);
  /// Static steps of `time_step` until the unbalance is below 1e-12 or `most` steps are done.
  void rest(double time_step, solver::Analysis analysis = solver::Analysis::Static, int most = 100);
  void steps(long count);
  solver::Simulation& simulation() { return simulation_; }
  Vector3 place(int block) const;                ///< world, m
  double force(int a, int b) const;              ///< normal force between two blocks, N
  Evidence evidence;
  bool watches_energy = false;  ///< for scenes with motion: at rest it would see rounding alone

 private:
  void step();
  void watch_energy();
  double least_energy_ = 0.0, most_energy_ = 0.0, growth_ = 0.0;  // J
  bool watched_ = false;
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
/// Settles, is let go; error of the way gone relative to it (absolute, in block sizes, where it stays).
Result run_slide(const Slide& slide);

/// Blocks standing one on another on a fixed one.
struct Stack {
  std::vector<double> densities{};       ///< from the bottom
  std::vector<double> youngs{};          ///< Pa; empty: rigid
  Vector3 size = Vector3::Ones();        ///< of each, m
  Vector3 origin = Vector3::Zero();
  double time_step = 0.01;
  double rest_step = 0.01;               ///< s: it comes to rest in static steps 100 times as long
  long steps = 100;                      ///< dynamic, from sudden gravity when rigid, from rest else
  solver::ContactMethod method = solver::ContactMethod::AugmentedLagrangian;
  double penalty = 0.0;
};
/// Largest error of an interface's force relative to the weight above.
Result run_stack(const Stack& stack);
/// Largest error of a block's mean axial strain after static steps, relative to the exact one.
Result run_column_strain(const Stack& stack);

}  // namespace quoin::stability
