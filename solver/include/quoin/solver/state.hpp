#pragma once
/// What changes while a scene runs.

#include <Eigen/Geometry>
#include <quoin/geometry/contact_point.hpp>
#include <quoin/solver/scene.hpp>

namespace quoin::solver {

/// Not aligned: the same to code that is compiled for other instructions.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

/// Place and motion of one block. A material point with reference arm X (from the reference
/// centroid) stands at centroid + rotation (I + strain) X.
struct BlockState {
  Vector3 centroid = Vector3::Zero();       ///< relative to State::origin, m
  Vector3 centroid_rest = Vector3::Zero();  ///< what `centroid` leaves by rounding: the sum is the
                                            ///< place, so that it matters nowhere how far out
  Quaternion rotation = Quaternion::Identity();  ///< reference -> world
  Vector6 strain = Vector6::Zero();              ///< total, in the turning frame
  Vector3 velocity = Vector3::Zero();            ///< m/s
  Vector3 angular_velocity = Vector3::Zero();    ///< in the turning frame, rad/s
  Vector6 strain_rate = Vector6::Zero();         ///< 1/s, turning frame
};

enum class ContactMode : std::uint8_t { Open, Stick, Slip };

/// A contact point with its mechanical history.
struct Contact {
  geometry::ContactPoint point;  ///< relative to State::origin, at the end of the step
  ContactMode mode = ContactMode::Open;
  bool impact = false;                    ///< its force stands for the impulse of an impact
  bool failed = false;                    ///< the joint's strength is at its residual values here
  bool bonded = false;                    ///< bears tension: as laid, and not parted
  double normal_force = 0.0;              ///< mean of the step, N, compression positive
  Vector3 shear_force = Vector3::Zero();  ///< on A, N, in the contact plane
  /// What the next step begins with: differs where forces mend gaps, too, and after impacts.
  double next_normal_force = 0.0;
  Vector3 next_shear_force = Vector3::Zero();
  double slip = 0.0;                   ///< accumulated sliding length, m
  double closed_gap = 0.0;             ///< gap at which it is closed, but for dilation: that a
                                       ///< bond was laid with, or an earlier law has left, m
  double spring_area = 0.0;            ///< that the joint's stiffness acts on, m2
  double spring_offset = 0.0;          ///< of the gap at which its spring is unstressed, m
  Vector3 anchor_a = Vector3::Zero();  ///< reference arms of the stuck point on A and on B, m:
  Vector3 anchor_b = Vector3::Zero();  ///< while it sticks both stand at the same place

  /// Shared by the faces here or, where these lean on springs, what the springs act on, m2.
  double area() const { return point.area > 0.0 ? point.area : spring_area; }
};

/// A tie with its history, as it is at the end of the step.
struct TieState {
  double rest_length = 0.0;  ///< m, unstressed, as it was put in
  double plastic = 0.0;      ///< m: what yielding has added to that
  double length = 0.0;       ///< m
  double force = 0.0;        ///< N, tension positive
  bool broken = false;
};

/// Where the energy is and where it went, J. Losses are what has left since the start.
struct EnergyLedger {
  double kinetic = 0.0;
  double potential = 0.0;  ///< of gravity, zero at the start
  double strain = 0.0;
  double contact = 0.0;           ///< stored in springs of contacts and in ties
  double work = 0.0;              ///< done by point, face and body loads and by prescribed motion
  double friction_loss = 0.0;     ///< in joints: friction, cohesion, broken bonds, less
                                  ///< dilation; in ties: by yield and breaking;
                                  ///< in quiet faces
  double impact_loss = 0.0;       ///< by the velocity law of closing and sticking contacts
  double algorithmic_loss = 0.0;  ///< by the time scheme: springs taken at the end of the step
  double closure = 0.0;  ///< what the terms above leave unexplained (0 but for rounding and
                         ///< the frozen directions of sliding)
  double mechanical() const { return kinetic + potential + strain + contact; }
};

struct State {
  double time = 0.0;  ///< s
  long step = 0;
  Vector3 origin = Vector3::Zero();  ///< world = origin + what the state holds, m
  std::vector<BlockState> blocks;
  std::vector<Contact> contacts;     ///< sorted by key
  std::vector<Vector3> held_forces;  ///< of Scene::fixed_points: on the block, in the last step, N
  std::vector<TieState> ties;        ///< of Scene::ties
  /// Of the points of Scene::quiet_faces: what held them on their blocks in the last static step,
  /// N.
  std::vector<Vector3> quiet_forces;
  EnergyLedger energy;
};

/// Place of a material point of a block given by its reference arm (from the centroid), m: relative
/// to State::origin, and in the world.
Vector3 local_point(const State& state, int block, const Vector3& reference_arm);
Vector3 world_point(const State& state, int block, const Vector3& reference_arm);

}  // namespace quoin::solver
