#pragma once
/// What the cases share: scenes on a slope in any frame and unit system, and how they are run.

#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver/simulation.hpp>

namespace quoin::validation {

namespace geometry = quoin::geometry;
namespace solver = quoin::solver;
using geometry::Matrix3;
using geometry::Vector3;

inline constexpr double kGravity = 9.81;  ///< m/s2

double radians(double degrees);
Matrix3 turn(double angle, const Vector3& axis);  ///< rad

/// Where and in which unit of length a scene is built. A number of m is `scale` of the unit; mass
/// and time keep theirs, so densities take scale^-3, pressures scale^-1, forces and accelerations
/// scale.
struct Frame {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 origin = Vector3::Zero();  ///< m
  double scale = 1.0;

  Vector3 point(const Vector3& p) const { return scale * (origin + rotation * p); }
  Vector3 vector(const Vector3& v) const { return scale * (rotation * v); }
  geometry::Shape place(const geometry::Shape& shape) const;
  solver::Material material(const solver::Material& m) const;
  /// A displacement or velocity of the frame back in its own axes, m.
  Vector3 back(const Vector3& v) const { return rotation.transpose() * v / scale; }
};

/// A block on a fixed plane that dips by `angle` towards the frame's x; slope axes are x
/// down-slope, y across, z normal. The block stands with its lower centre at the origin of the
/// slope.
struct SlopeScene {
  double angle = 0.0;              ///< rad
  double friction = 0.0;           ///< rad
  Vector3 size = Vector3::Ones();  ///< along, across, normal, m
  solver::Material material{};
  double gravity = kGravity;
  Vector3 velocity = Vector3::Zero();  ///< slope axes, m/s
  double plane_length = 60.0;          ///< down-slope of the block, m
  bool rigid = false;
  bool plane_last = false;  ///< blocks listed in reverse
  Frame frame{};

  int block() const { return plane_last ? 0 : 1; }
  Matrix3 slope_axes() const;  ///< columns: down-slope, across, normal, in the frame
  solver::Scene scene() const;
  /// Of the block's centroid since the start, slope axes, m.
  Vector3 displacement(const solver::Simulation& simulation) const;
  Vector3 block_velocity(const solver::Simulation& simulation) const;    ///< m/s
  Vector3 angular_velocity(const solver::Simulation& simulation) const;  ///< rad/s, slope axes
};

/// Brings the contact forces to rest with closed contacts held in their plane, then turns to
/// `analysis`. Initial velocities of the scene's blocks are taken up again.
void settle(solver::Simulation& simulation, solver::Analysis analysis = solver::Analysis::Dynamic);

/// Static steps with friction alive (then the analysis as it was): a held state that the joints
/// cannot bear slips to one they can. Blocks that are bound to move creep, and their strain comes
/// to rest under the forces of the motion. Ends with a mechanism.
solver::StaticVerdict relax(solver::Simulation& simulation, int most_steps);

/// One step. Throws std::runtime_error with its description when it does not converge.
solver::StepReport step(solver::Simulation& simulation);

/// `duration` / time_step steps; the largest overlap in them, m.
double run_for(solver::Simulation& simulation, double duration);

/// Momenta about the world origin of all blocks together, and mechanical kinetic energy.
struct Momentum {
  Vector3 linear = Vector3::Zero();   ///< kg m/s
  Vector3 angular = Vector3::Zero();  ///< kg m2/s
};
Momentum momentum(const solver::Simulation& simulation);

/// Sum of the contact forces on block `on`, N.
Vector3 contact_force(const solver::State& state, int on);

/// 3 × 3 matrix of a strain vector (shear as gamma).
Matrix3 strain_matrix(const solver::Vector6& strain);

std::string text(double value);  ///< short, as %g
std::string name(
    const solver::StepOptions& options);  ///< "augmented Lagrangian", "springs 5e+07", …

}  // namespace quoin::validation
