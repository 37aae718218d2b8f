#pragma once
/// A scene checked once and turned into what a step needs, and nothing else.

#include "block/block_system.hpp"
#include "block/block_terms.hpp"
#include "contact/tie.hpp"

namespace quoin::solver {

/// factor × force at the material point of a block; or the pressure there on its face.
struct PointForce {
  int block = 0;
  Vector3 arm = Vector3::Zero();  ///< reference arm, m
  VectorOfTime force{};
  double factor = 1.0;
  std::shared_ptr<const PressureField> pressure{};
  Vector3 area = Vector3::Zero();    ///< outward normal times area, reference axes, m2
  Vector3 origin = Vector3::Zero();  ///< State::origin

  bool is_constant() const { return pressure ? pressure->steady : force.is_constant(); }
  /// N. `pose`: of its block.
  Vector3 at(const Pose& pose, double time) const {
    if (!pressure) return factor * force.at(time);
    const Vector3 place = origin + (pose.centroid + pose.shape * arm);
    return -(factor * pressure->value(place, time)) * (pose.rotation * area);
  }
};

struct HeldPoint {
  int block = 0;
  Vector3 arm = Vector3::Zero();   ///< reference arm, m
  Vector3 from = Vector3::Zero();  ///< its displacement when it began to be held, m
  double since = 0.0;              ///< when its displacement began to be prescribed so, s
  VectorOfTime displacement;
};

/// Dashpots at a point of a QuietFace.
struct QuietPoint {
  int block = 0;
  Vector3 arm = Vector3::Zero();     ///< reference arm, m
  Vector3 normal = Vector3::Zero();  ///< unit, reference axes
  double normal_viscosity = 0.0;     ///< N s/m
  double shear_viscosity = 0.0;      ///< N s/m
  VectorOfTime velocity;
};

struct CompiledScene {
  Scene scene;
  Vector3 origin = Vector3::Zero();
  std::vector<BlockModel> models;
  Slots slots;
  std::vector<char> idle;         ///< per block: no unknowns
  std::vector<int> idle_blocks;   ///< those, ascending
  std::vector<int> prescribed;    ///< blocks moved by a motion
  std::vector<PointForce> loads;  ///< point, face and body loads
  std::vector<HeldPoint> held;
  std::vector<TieModel> ties;
  std::vector<QuietPoint> quiet;
  bool dilates = false;        ///< any joint
  bool has_parts = false;      ///< any block: Block::parts
  double smallest_size = 0.0;  ///< of the blocks with unknowns (of all, if there are none), m
};

/// Throws InputError naming block, joint or load, value and limit.
CompiledScene compile(Scene scene);

inline bool is_absent(const CompiledScene& compiled, int block) {
  return compiled.models[static_cast<std::size_t>(block)].kind == BlockKind::Absent;
}

/// Of a held point since it began to be held, m.
inline Vector3 displacement(const CompiledScene& compiled, const HeldPoint& held,
                            const Pose& pose) {
  return displacement(compiled.models[static_cast<std::size_t>(held.block)], pose, held.arm) -
         held.from;
}

/// Ties as they are put in where the state's blocks stand. Throws InputError where one has no
/// length.
void lay_ties(const CompiledScene& compiled, State& state);

/// State at time 0.
State initial_state(const CompiledScene& compiled);

/// Of all blocks with unknowns, J.
double kinetic_energy(const CompiledScene& compiled, const State& state);
double strain_energy(const CompiledScene& compiled, const State& state);

/// Where a prescribed block is and how fast.
struct PrescribedMotion {
  Vector3 displacement = Vector3::Zero();      ///< since time 0, m
  Vector3 velocity = Vector3::Zero();          ///< m/s
  Quaternion turn = Quaternion::Identity();    ///< Motion::rotation
  Vector3 angular_velocity = Vector3::Zero();  ///< rad/s, world
};

/// Motion::rotation at a time.
Quaternion turn_at(const Motion& motion, double time);

/// Moves a block as it goes from one point of its motion to another.
void move_along(const BlockModel& model, const Motion& motion, const PrescribedMotion& from,
                const PrescribedMotion& to, const Vector3& origin, BlockState& block);

/// Velocity from `time` on, m/s; of an acceleration the one that is `reached`.
Vector3 velocity_from(const Motion& motion, const Vector3& reached, double time);
/// Throws InputError where a motion sets its block off at a velocity that is not finite.
void check_motion_velocity(const Scene& scene, int block, const Vector3& velocity, double time);

/// A velocity at one end of an interval of time, m/s: where it jumps there, the one inside.
Vector3 velocity_inside(const VectorOfTime& velocity, double end, double other);

/// The first time between `from` and `to` at which a motion's velocity jumps, s; none: `to`.
double next_jump(const Motion& motion, double from, double to);

/// The motion at time `to`, from that `known` at `from`: velocity and acceleration are integrated
/// by a Gauss rule from knot to knot, which is exact for a table. A velocity that jumps at `to` is
/// that before the jump.
PrescribedMotion advance_motion(const Motion& motion, const PrescribedMotion& known, double from,
                                double to);

}  // namespace quoin::solver
