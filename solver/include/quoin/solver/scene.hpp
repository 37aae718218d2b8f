#pragma once
/// What the user states: blocks, materials, joints, supports, loads. SI units, radians, world
/// frame.

#include <functional>
#include <limits>
#include <memory>
#include <quoin/geometry/body.hpp>
#include <span>
#include <string>
#include <vector>

namespace quoin::solver {

using geometry::InputError;
using geometry::Matrix3;
using geometry::Vector3;
using Vector6 = Eigen::Matrix<double, 6, 1>;  ///< (xx, yy, zz, xy, yz, zx); shear strains are gamma

/// A vector that is constant or a function of time (s).
class VectorOfTime {
 public:
  VectorOfTime(const Vector3& constant = Vector3::Zero()) : constant_(constant) {}
  VectorOfTime(std::function<Vector3(double)> varying) {
    if (varying) varying_ = std::make_shared<std::function<Vector3(double)>>(std::move(varying));
  }
  /// Smooth between `knots` alone; these ascend, s.
  VectorOfTime(std::function<Vector3(double)> varying,
               std::shared_ptr<const std::vector<double>> knots)
      : VectorOfTime(std::move(varying)) {
    knots_ = std::move(knots);
  }
  Vector3 at(double time) const { return varying_ ? (*varying_)(time) : constant_; }
  bool is_constant() const { return !varying_; }
  /// The same constant, or copies of one function.
  bool is(const VectorOfTime& other) const {
    return varying_ == other.varying_ && constant_ == other.constant_;
  }
  /// None of a constant, and of a function that states none.
  std::span<const double> knots() const {
    return knots_ ? std::span<const double>(*knots_) : std::span<const double>();
  }

 private:
  Vector3 constant_ = Vector3::Zero();
  std::shared_ptr<const std::function<Vector3(double)>> varying_;
  std::shared_ptr<const std::vector<double>> knots_;
};

/// Piecewise linear table, held constant outside its range. times ascending (s); one that stands
/// twice is a jump, from the first value before it to the second from it on.
VectorOfTime interpolate(std::vector<double> times, std::vector<Vector3> values);

struct Material {
  double density = 0.0;  ///< kg/m3, > 0 unless the block is fixed
  double young = 0.0;    ///< Pa, > 0 for a deformable block
  double poisson = 0.0;  ///< -1 < poisson < 0.5
  int joint_group = 0;   ///< which joints of Scene::pair_joints apply
  std::string name{};    ///< for output; may be empty
};

/// A joint of two blocks: stiffness, Mohr–Coulomb strength on its area, dilation. Peak values hold
/// where blocks are laid touching; where they have slid or parted, and where they meet later,
/// residual values do.
struct Joint {
  double friction_angle = 0.0;  ///< rad, 0 <= angle < pi/2
  double cohesion = 0.0;        ///< Pa on the contact area
  double tension = 0.0;         ///< Pa on the contact area
  double restitution = 0.0;     ///< ratio of normal velocities after and before an impact, 0..1
  double dilation_angle = 0.0;  ///< rad, at most friction_angle: opening per slip is its tangent
  double dilation_slip = 0.0;   ///< m of slip after which it opens no more; 0: never
  double residual_friction_angle = -1.0;  ///< rad after failure; -1: friction_angle
  double residual_cohesion = 0.0;         ///< Pa after failure
  double residual_tension = 0.0;          ///< Pa after failure, until the joint opens
  double softening_slip = 0.0;            ///< m of slip from peak to residual values; 0: brittle
  double normal_stiffness = 0.0;          ///< Pa/m on the contact area; 0: rigid
  double shear_stiffness = 0.0;  ///< Pa/m on the contact area; > 0 where normal_stiffness is
};

/// Of two blocks whose materials have these joint groups, in either order. One for each pair.
struct PairJoint {
  int group_a = 0;
  int group_b = 0;
  Joint joint;
};

/// Of these two blocks, a < b, in place of the joint of their groups.
struct BlockJoint {
  int a = 0;
  int b = 0;
  Joint joint;
};

enum class BlockKind : std::uint8_t {
  Deformable,  ///< 12 unknowns: motion and constant strain
  Rigid,       ///< 6 unknowns
  Fixed,       ///< no unknowns
  Prescribed,  ///< no unknowns, moved by `motion`
  Absent       ///< not there, yet or any more: touches nothing, weighs nothing
};

/// Which derivative of the translation of a prescribed block is given.
enum class MotionKind : std::uint8_t { Displacement, Velocity, Acceleration };

struct Motion {
  MotionKind kind = MotionKind::Velocity;
  /// m, m/s or m/s2, starting from rest at its place at time 0: of a displacement counts by how
  /// much it changes. Tables of velocities and accelerations are integrated exactly, other
  /// functions by a Gauss rule over each step.
  VectorOfTime value{};
  /// Rotation vector (axis times angle), rad, by how much it changes: the block turns about the
  /// material point that stands at `centre` (m) at the start, which `value` moves.
  VectorOfTime rotation{};
  Vector3 centre = Vector3::Zero();
};

struct Block {
  std::shared_ptr<const geometry::Shape> shape;  ///< blocks alike share one
  /// Of a block that is not convex, such as an L-stone, its convex parts, in the frame of `shape`,
  /// which is then geometry::join() of them; they touch others, and never each other. Null: `shape`
  /// is convex.
  std::shared_ptr<const std::vector<geometry::Shape>> parts{};
  geometry::Placement placement{};  ///< of the shape in the world at the start
  Material material;
  BlockKind kind = BlockKind::Deformable;
  Vector3 velocity = Vector3::Zero();          ///< of the centroid at the start, m/s
  Vector3 angular_velocity = Vector3::Zero();  ///< at the start, rad/s
  Vector6 initial_stress = Vector6::Zero();    ///< Pa, tension positive, world axes
  Motion motion{};                             ///< of a prescribed block
  std::string name{};                          ///< for messages and output; may be empty

  geometry::Body body() const { return {*shape, placement}; }  ///< at the start; of all parts
  std::span<const geometry::Shape> convex_parts() const {      ///< in the frame of `shape`
    return parts ? std::span(*parts) : std::span(shape.get(), 1);
  }
};

/// Force on a material point, given by its place at the start. N.
struct PointLoad {
  int block = 0;
  Vector3 point = Vector3::Zero();
  VectorOfTime force;
};

/// Uniform dead traction on a face of the block's topology, by its area at the start. Pa.
struct FaceLoad {
  int block = 0;
  int face = 0;
  VectorOfTime traction;
};

/// Force per volume. N/m3.
struct BodyLoad {
  int block = 0;
  VectorOfTime force;
};

/// Pressure by place (world, m) and time (s), Pa.
struct PressureField {
  std::function<double(const Vector3& place, double time)> value;
  bool steady = false;  ///< the same at all times
};

/// Pressure of water on a convex plane polygon of a block's surface. It acts against the polygon's
/// normal as the block turns, at the places where its velocities bring it in half of a dynamic
/// (sub-)step, or where it stands when a pseudo-step begins; the area stays that of the start.
/// Integrated by triangles, exact where the pressure is linear.
struct PressureLoad {
  int block = 0;
  std::vector<Vector3> corners{};  ///< at the start, m, counter-clockwise seen from outside
  std::shared_ptr<const PressureField> field{};
  double factor = 1.0;  ///< of the pressure; -1 takes off what another load has too much
  int divisions = 4;    ///< of each triangle's edges, >= 1
  int across = -1;      ///< of a joint: the other block; the load is none while that is absent
};

/// Viscous boundary on a face of the block's topology [Lysmer & Kuhlemeyer 1969]. In dynamic steps
/// dashpots to a ground that moves with twice `velocity` bear the face, beside the force that held
/// it in the last static step; static steps hold it where it stands. Impedances: density times the
/// speed of pressure and of shear waves behind the boundary.
struct QuietFace {
  int block = 0;
  int face = 0;
  double normal_impedance = 0.0;  ///< Pa s/m, >= 0
  double shear_impedance = 0.0;   ///< Pa s/m, >= 0
  VectorOfTime velocity{};        ///< of the incoming wave, m/s: half of what a free surface shows
};

/// A material point held at its place at the start (moved by `displacement`, m).
struct FixedPoint {
  int block = 0;
  Vector3 point = Vector3::Zero();
  VectorOfTime displacement;
  std::string name{};  ///< for output; may be empty
};

/// A bolt, cable, tie rod or tension bar: a straight link of two material points, given by their
/// places at the start. Its force follows the line between them, N, tension positive: stiffness
/// times elongation, perfectly plastic beyond the yield force. It is put in where its blocks stand
/// when a scene first has it. At least one of its blocks can move.
struct Tie {
  int a = -1, b = -1;  ///< two different blocks; -1: a place in the world
  Vector3 point_a = Vector3::Zero(), point_b = Vector3::Zero();  ///< at the start, apart, m
  double stiffness = 0.0;    ///< N/m, > 0: E A / length of a bar
  double pretension = 0.0;   ///< N, as it is put in; compression only where it bears any
  double rest_length = 0.0;  ///< m, unstressed: in place of pretension; 0: by pretension
  bool tension_only = true;  ///< slack where it is shorter than its rest length
  double yield_force = std::numeric_limits<double>::infinity();  ///< N, > 0, in both directions
  double break_force = std::numeric_limits<double>::infinity();  ///< N, > 0, likewise
  double break_strain =
      std::numeric_limits<double>::infinity();  ///< > 0, elongation by rest length
  std::string name{};                           ///< for output; may be empty
};

/// What becomes of blocks that overlap at the start.
enum class InitialOverlap : std::uint8_t {
  Refuse,  ///< more than 1e-3 of the smaller block is an InputError
  Keep,    ///< they push each other apart
  Zero     ///< as they stand they touch: the depth at the start is subtracted from then on
};

struct Scene {
  std::vector<Block> blocks{};
  Joint joint{};  ///< where none of the following applies
  std::vector<PairJoint> pair_joints{};
  std::vector<BlockJoint> block_joints{};      ///< each pair once, ascending
  VectorOfTime gravity{Vector3(0, 0, -9.81)};  ///< m/s2
  std::vector<PointLoad> point_loads{};
  std::vector<FaceLoad> face_loads{};
  std::vector<BodyLoad> body_loads{};
  std::vector<FixedPoint> fixed_points{};
  std::vector<Tie> ties{};
  std::vector<PressureLoad> pressure_loads{};
  std::vector<QuietFace> quiet_faces{};
  InitialOverlap initial_overlap = InitialOverlap::Refuse;
  /// m: shapes and placements are given no better, as from a file with six digits. Where two blocks
  /// are laid with gaps of either sign within it, and not exactly, gaps that small are zero from
  /// then on. 0: eps of the coordinates. At most 1e-3 of the smallest block.
  double coordinate_rounding = 0.0;

  /// A shape that stands in the world; a deformable block; its index.
  int add_block(geometry::Shape shape, const Material& material);
  int add_rigid(geometry::Shape shape, const Material& material);
  int add_fixed(geometry::Shape shape, const Material& material = {});
};

/// Shape and parts of a block of several convex parts that move as one. Throws InputError for none.
Block compound(std::vector<geometry::Shape> parts);

}  // namespace quoin::solver
