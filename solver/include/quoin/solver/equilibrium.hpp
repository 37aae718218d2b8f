#pragma once
/// Static equilibrium of rigid blocks as one convex cone problem: contact forces that balance the
/// loads, or the mechanism that proves that there are none.
///
/// At each contact the forces that are *admissible* (f_n compression, f_t in the contact plane):
///   |f_t| <= mu f_n + C,   f_n >= -T                  (Mohr–Coulomb with tension cut-off)
/// with T of the tensile strength, and C of cohesion, or mu T where that is more: the least cone
/// that reaches T. Inner points of such a joint make its area, moments and twist exact.
/// A *mechanism* is a velocity of every block along which each contact opens at least as dilatancy
/// wants (v_n >= mu |v_t| with f = 0 at its apex) and the loads do more work than the contacts can
/// dissipate. Theorem: it exists exactly where no admissible forces balance the loads (Farkas).
/// Coulomb friction does not dilate, so its forces are among the admissible ones: a mechanism is a
/// proof for it, too, while admissible forces are an upper bound of its limit alone [Drucker 1954;
/// Radenkovic 1961].

#include <quoin/solver/scene.hpp>
#include <vector>

namespace quoin::solver {

/// A contact point, or a held point: any force on one block.
struct EquilibriumContact {
  int a = -1, b = -1;                 ///< blocks; a of a held point: -1
  Vector3 point = Vector3::Zero();    ///< m, relative to EquilibriumProblem::origin
  Vector3 normal = Vector3::UnitX();  ///< unit, from a to b
  double gap = 0.0;                   ///< m; negative: overlap
  double friction = 0.0;              ///< mu
  double cohesion = 0.0;              ///< C, N, as above
  double tension = 0.0;               ///< T, N
  bool held = false;                  ///< by any force
  bool guided = false;                ///< held, by any force along the normal, of either sign
};

struct EquilibriumBlock {
  bool moves = false;               ///< it has unknowns
  Vector3 place = Vector3::Zero();  ///< centroid, m, relative to EquilibriumProblem::origin
  double size = 1.0;                ///< m: turns moments into forces
  Vector6 load = Vector6::Zero();   ///< force, N, and moment about the centroid, N m
  Vector6 live = Vector6::Zero();   ///< the same of the load that a factor multiplies
};

struct EquilibriumProblem {
  Vector3 origin = Vector3::Zero();  ///< m, of the world
  std::vector<EquilibriumBlock> blocks{};
  std::vector<EquilibriumContact> contacts{};
};

/// How a joint with tension spreads its normal force over its area.
enum class JointStress : std::uint8_t {
  Plastic,  ///< as f_n >= -T lets it at each point: no more can ever be borne
  /// Linear over the section, nowhere a tension of more than t or c / mu: what a brittle joint
  /// bears before it breaks, as steps judge it. Its points are the corners of the section's core.
  Elastic
};

/// The scene as it stands at time 0, its deformable blocks rigid, with peak strengths: contact
/// points with gaps of up to `reach` (m; 0: 1e-6 of the smaller block, or
/// Scene::coordinate_rounding), loads and held points. Absent blocks are left out. Throws
/// InputError as Simulation does.
EquilibriumProblem equilibrium_problem(const Scene& scene, double reach = 0.0,
                                       JointStress stress = JointStress::Plastic);

class Simulation;

/// Likewise of blocks where they stand now, with as large a set of forces as steps from there could
/// come to: contact points count if moving both blocks by `share` (>= 0) of their sizes can close
/// them; brittle joints, which steps judge as a whole, have corners alone. A mechanism proves that
/// no equilibrium is near.
EquilibriumProblem equilibrium_problem(const Simulation& simulation, double share);

/// Weight and loads of the scene at time 0, by block: force, N, and moment about its centroid, N m.
std::vector<Vector6> block_loads(const Scene& scene);

enum class EquilibriumVerdict : std::uint8_t {
  Undecided,   ///< neither was found to the tolerances below
  Admissible,  ///< `forces` balance all loads
  Mechanism    ///< no forces do; `velocities` prove it
};

/// "undecided", "admissible", "mechanism".
const char* name(EquilibriumVerdict verdict);

/// Admissible: `unbalance` is at most kBalanced, `violation` at most kBalanced.
/// Mechanism: `incompatibility` is at most kBalanced, and forces that kept the structure up would
/// add up to more than kLargestForces times the largest load.
struct Equilibrium {
  static constexpr double kBalanced = 1e-8;
  static constexpr double kLargestForces = 1e7;

  EquilibriumVerdict verdict = EquilibriumVerdict::Undecided;
  /// Of `live`: the one that was given, or the largest one that is admissible.
  double factor = 0.0;
  bool limited = true;            ///< false: more than the largest factor that was asked for
  std::vector<Vector3> forces{};  ///< by contact, on b, N, world axes
  /// Of every block: of its centroid, m/s, and angular, rad/s; the fastest moves by 1 m/s.
  std::vector<Vector6> velocities{};
  double unbalance = 0.0;        ///< largest force that is missing, by the largest load
  double violation = 0.0;        ///< farthest that a force lies outside its set, by that load
  double margin = 0.0;           ///< least distance of a force from the rim, by that load
  double incompatibility = 0.0;  ///< farthest that v_n falls short, m/s
  double power = 0.0;            ///< of the loads along `velocities`, W
  double dissipation = 0.0;      ///< most that the contacts take, W
  int factorizations = 0;        ///< of all islands
  int islands = 0;
};

/// Whether admissible forces balance load + factor × live. Islands (blocks that contacts join) are
/// solved apart; unloaded ones stand without forces. Throws nothing but std::bad_alloc.
Equilibrium find_equilibrium(const EquilibriumProblem& problem, double factor = 0.0);

/// As find_equilibrium(), which of an admissible problem costs less: it ends Undecided as soon as
/// forces seem to exist.
Equilibrium find_mechanism(const EquilibriumProblem& problem);

/// Largest factor in [0, largest] with admissible forces: a convex problem, no bisection. `forces`
/// hold it, `velocities` are the mechanism at it. Mechanism: load alone is not borne.
Equilibrium largest_load_factor(const EquilibriumProblem& problem, double largest);

/// A mechanism at that factor from two velocity fields by block (m/s, rad/s): `tight` works hardest
/// but leaves contacts short of v_n >= mu |v_t| by rounding; `strict` opens them all, as the
/// mechanism of a somewhat larger load does. Contacts of `tight` that nearly stick or slide are
/// made to do so exactly, and as little of `strict` is added as makes every contact compatible.
/// Undecided: no such sum proves it. Throws nothing but std::bad_alloc.
Equilibrium combined_mechanism(const EquilibriumProblem& problem, double factor,
                               const std::vector<Vector6>& tight,
                               const std::vector<Vector6>& strict);

/// Likewise at the least factor that such a sum proves, `factor` of the result.
Equilibrium least_falling_factor(const EquilibriumProblem& problem,
                                 const std::vector<Vector6>& tight,
                                 const std::vector<Vector6>& strict);

}  // namespace quoin::solver
