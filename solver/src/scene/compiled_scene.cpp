#include "scene/compiled_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>

#include "base/index.hpp"
#include "base/messages.hpp"
#include "contact/contact_history.hpp"

namespace quoin::solver {
namespace {

void check_loaded_block(const Scene& scene, int block, const std::string& what) {
  const Block& loaded = scene.blocks[checked_block(block, scene.blocks.size(), what + ": ")];
  if (loaded.kind >= BlockKind::Fixed) {
    throw InputError(what + ": " + label(loaded, block) +
                     " is fixed, prescribed or absent and takes no load");
  }
}

void check_joint(const Joint& joint, const std::string& what) {
  const auto require = [&](bool good, const std::string& name, double value, const char* limit) {
    if (!good) throw InputError(what + ": " + name + " " + text_of(value) + " " + limit);
    if (!std::isfinite(value)) throw InputError(what + ": " + name + " is not finite");
  };
  const double right_angle = 0.5 * std::numbers::pi;
  require(joint.friction_angle >= 0.0 && joint.friction_angle < right_angle, "friction angle",
          joint.friction_angle, "rad must lie in [0, pi/2)");
  const double residual = joint.residual_friction_angle;
  require(residual == -1.0 || (residual >= 0.0 && residual < right_angle),
          "residual friction angle", residual,
          "rad must lie in [0, pi/2), or be -1 for the friction angle");
  require(residual < 0.0 || joint.dilation_angle <= residual, "dilation angle",
          joint.dilation_angle, "rad must not exceed the residual friction angle");
  require(joint.dilation_angle >= 0.0 && joint.dilation_angle < right_angle, "dilation angle",
          joint.dilation_angle, "rad must lie in [0, pi/2)");
  require(joint.dilation_angle <= joint.friction_angle, "dilation angle", joint.dilation_angle,
          "rad must not exceed the friction angle: the joint would make energy");
  require(joint.dilation_slip >= 0.0, "dilation slip", joint.dilation_slip,
          "m must not be negative");
  require(joint.softening_slip >= 0.0, "softening slip", joint.softening_slip,
          "m must not be negative");
  require(joint.normal_stiffness >= 0.0, "normal stiffness", joint.normal_stiffness,
          "Pa/m must not be negative");
  require((joint.shear_stiffness > 0.0) == (joint.normal_stiffness > 0.0), "shear stiffness",
          joint.shear_stiffness, "Pa/m must be greater than 0 where normal stiffness is, else 0");
  require(joint.restitution >= 0.0 && joint.restitution <= 1.0, "restitution", joint.restitution,
          "must lie in [0, 1]");
  require(joint.cohesion >= 0.0, "cohesion", joint.cohesion, "Pa must not be negative");
  require(joint.tension >= 0.0, "tension", joint.tension, "Pa must not be negative");
  require(joint.residual_cohesion >= 0.0, "residual cohesion", joint.residual_cohesion,
          "Pa must not be negative");
  require(joint.residual_tension >= 0.0, "residual tension", joint.residual_tension,
          "Pa must not be negative");
}

/// Two joints of one pair of groups: which of them holds?
void check_pairs(const std::vector<PairJoint>& joints) {
  std::map<std::pair<int, int>, std::size_t> first;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto groups = std::minmax(joints[i].group_a, joints[i].group_b);
    const auto [place, is_new] = first.try_emplace(groups, i);
    if (is_new) continue;
    throw InputError("pair joints " + std::to_string(place->second) + " and " + std::to_string(i) +
                     ": both are of the joint groups " + std::to_string(groups.first) + " and " +
                     std::to_string(groups.second));
  }
}

void check_block_joints(const Scene& scene) {
  const std::vector<BlockJoint>& joints = scene.block_joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto& [a, b, joint] = joints[i];
    const std::string what = "block joint " + std::to_string(i);
    check_joint(joint, what);
    if (a < 0 || b <= a || std::cmp_greater_equal(b, scene.blocks.size())) {
      throw InputError(what + ": " + std::to_string(a) + " and " + std::to_string(b) +
                       " are not two blocks, the lower first");
    }
    if (i > 0 && std::pair(joints[i - 1].a, joints[i - 1].b) >= std::pair(a, b))
      throw InputError(what + ": pairs of blocks must ascend");
  }
}

template <class Vector>
void check_finite(const Vector& value, const std::string& what) {
  if (!value.allFinite()) throw InputError(what + " is not finite");
}

void check_square(const Vector3& value, const std::string& what) {
  if (!std::isfinite(value.squaredNorm())) throw InputError(what + " is not finite, or its square");
}

Vector3 arm_of(const CompiledScene& compiled, int block, const Vector3& world_point) {
  const BlockState& start = compiled.models[index(block)].start;
  return (world_point - compiled.origin - start.centroid) - start.centroid_rest;
}

/// Of a held point. One at the centroid but for the rounding of both is there: what is left of its
/// arm says nothing of how the block yields to it by its strain.
Vector3 held_arm(const CompiledScene& compiled, int block, const Vector3& world_point) {
  constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();
  const Vector3 arm = arm_of(compiled, block, world_point);
  const double size = compiled.models[index(block)].size + world_point.norm();
  return arm.norm() <= kRounding * size ? Vector3(Vector3::Zero()) : arm;
}

struct FaceMean {
  double area = 0.0;
  Vector3 centroid = Vector3::Zero();
};

/// By reference arms.
FaceMean face_mean(const BlockModel& model, int face) {
  const auto cycle = model.shape->topology().face(face);
  const auto arm = [&](int v) { return Vector3(model.turn * model.shape->vertex(v)); };
  const Vector3 first = arm(cycle[0]);
  FaceMean mean;
  for (std::size_t i = 2; i < cycle.size(); ++i) {
    const Vector3 p = arm(cycle[i - 1]) - first, q = arm(cycle[i]) - first;
    const double area = 0.5 * p.cross(q).norm();
    mean.area += area;
    mean.centroid += area * (p + q) / 3.0;
  }
  mean.centroid = first + mean.centroid / mean.area;
  return mean;
}

bool is_always_zero(const VectorOfTime& value) {
  return value.is_constant() && value.at(0.0).isZero(0.0);
}

void check_constant(const VectorOfTime& value, const std::string& what) {
  if (value.is_constant()) check_finite(value.at(0.0), what);
}

void add_load(CompiledScene& compiled, int block, const Vector3& arm, const VectorOfTime& force,
              double factor) {
  if (!is_always_zero(force)) compiled.loads.push_back({block, arm, force, factor});
}

/// Calls `add` with three points of each of the divisions² equal parts of a triangle, whose mean is
/// exact for polynomials of second degree.
template <class Add>
void for_each_point(const Vector3& corner, const Vector3& u, const Vector3& v, int divisions,
                    const Add& add) {
  const double n = divisions;
  const auto part = [&](double i, double j, double sign) {
    for (const auto& [p, q] : {std::pair(1.0, 1.0), std::pair(4.0, 1.0), std::pair(1.0, 4.0)})
      add(Vector3(corner + (i + sign * p / 6.0) / n * u + (j + sign * q / 6.0) / n * v));
  };
  for (int i = 0; i < divisions; ++i) {
    for (int j = 0; i + j < divisions; ++j) {
      part(i, j, 1.0);
      if (i + j + 1 < divisions) part(i + 1.0, j + 1.0, -1.0);
    }
  }
}

void add_pressure(CompiledScene& compiled, const PressureLoad& load) {
  for (std::size_t i = 2; i < load.corners.size(); ++i) {
    const Vector3 &first = load.corners[0], u = load.corners[i - 1] - first,
                  v = load.corners[i] - first;
    const Vector3 area = u.cross(v) / (6.0 * load.divisions * load.divisions);
    for_each_point(first, u, v, load.divisions, [&](const Vector3& point) {
      compiled.loads.push_back({.block = load.block,
                                .arm = arm_of(compiled, load.block, point),
                                .factor = load.factor,
                                .pressure = load.field,
                                .area = area,
                                .origin = compiled.origin});
    });
  }
}

/// How messages name a load whose block takes one: by its place in its list.
template <class Load>
std::string checked_load(const Scene& scene, const char* kind, const std::vector<Load>& loads,
                         const Load& load) {
  const std::string what = kind + std::string(" ") + std::to_string(&load - loads.data());
  check_loaded_block(scene, load.block, what);
  return what;
}

void check_face(const BlockModel& model, int block, int face, const std::string& what) {
  if (face >= 0 && face < model.shape->topology().face_count()) return;
  throw InputError(what + ": block " + std::to_string(block) + " has no face " +
                   std::to_string(face));
}

void compile_loads(CompiledScene& compiled) {
  const Scene& scene = compiled.scene;
  for (const PointLoad& load : scene.point_loads) {
    const std::string what = checked_load(scene, "point load", scene.point_loads, load);
    check_finite(load.point, what + ": point");
    check_constant(load.force, what + ": force");
    add_load(compiled, load.block, arm_of(compiled, load.block, load.point), load.force, 1.0);
  }
  for (const FaceLoad& load : scene.face_loads) {
    const std::string what = checked_load(scene, "face load", scene.face_loads, load);
    const BlockModel& model = compiled.models[index(load.block)];
    check_face(model, load.block, load.face, what);
    check_constant(load.traction, what + ": traction");
    const FaceMean mean = face_mean(model, load.face);
    add_load(compiled, load.block, mean.centroid, load.traction, mean.area);
  }
  for (const BodyLoad& load : scene.body_loads) {
    const std::string what = checked_load(scene, "body load", scene.body_loads, load);
    check_constant(load.force, what + ": force");
    add_load(compiled, load.block, Vector3::Zero(), load.force,
             compiled.models[index(load.block)].volume);
  }
  for (const PressureLoad& load : scene.pressure_loads) {
    const std::string what = checked_load(scene, "pressure load", scene.pressure_loads, load);
    if (!load.field || !load.field->value || load.corners.size() < 3 || load.divisions < 1)
      throw InputError(what + " needs a field, three corners, and at least one division");
    for (const Vector3& corner : load.corners) check_finite(corner, what + ": corner");
    if (load.across >= std::ssize(scene.blocks))
      throw InputError(what + ": there is no block across");
    if (load.across < 0 || scene.blocks[index(load.across)].kind != BlockKind::Absent)
      add_pressure(compiled, load);
  }
  for (const FixedPoint& point : scene.fixed_points) {
    const std::string what = checked_load(scene, "fixed point", scene.fixed_points, point);
    check_finite(point.point, what + ": point");
    check_constant(point.displacement, what + ": displacement");
    const Vector3 arm = held_arm(compiled, point.block, point.point);
    compiled.held.push_back({.block = point.block, .arm = arm, .displacement = point.displacement});
  }
}

std::string tie_label(const CompiledScene& compiled, std::size_t tie) {
  const std::string& name = compiled.scene.ties[tie].name;
  return "tie " + (name.empty() ? std::to_string(tie) : "\"" + name + "\"");
}

/// A place in the world, or a material point of a block.
Vector3 tie_arm(const CompiledScene& compiled, int block, const Vector3& point,
                const std::string& what) {
  check_finite(point, what + ": point");
  if (block < 0) return point - compiled.origin;
  const std::size_t b = checked_block(block, compiled.models.size(), what + ": ");
  if (is_absent(compiled, block))
    throw InputError(what + ": " + label(compiled.scene.blocks[b], block) + " is absent");
  return arm_of(compiled, block, point);
}

void check_tie(const CompiledScene& compiled, const Tie& tie, const std::string& what) {
  const auto require = [&](bool good, const char* name, double value, const char* limit) {
    if (!good) throw InputError(what + ": " + name + " " + text_of(value) + " " + limit);
  };
  const auto moves = [&](int block) { return block >= 0 && !compiled.idle[index(block)]; };
  if (!moves(tie.a) && !moves(tie.b)) throw InputError(what + ": none of its blocks can move");
  if (tie.a == tie.b) {
    throw InputError(what + ": both ends are in " +
                     label(compiled.scene.blocks[index(tie.a)], tie.a));
  }
  require(tie.stiffness > 0.0 && std::isfinite(tie.stiffness), "stiffness", tie.stiffness,
          "N/m must be finite and greater than 0");
  require(tie.yield_force > 0.0, "yield force", tie.yield_force, "N must be greater than 0");
  require(tie.break_force > 0.0, "break force", tie.break_force, "N must be greater than 0");
  require(tie.break_strain > 0.0, "break strain", tie.break_strain, "must be greater than 0");
  require(tie.rest_length >= 0.0 && std::isfinite(tie.rest_length), "rest length", tie.rest_length,
          "m must be finite and not negative");
  const double most = std::min(tie.yield_force, tie.break_force);
  require(std::abs(tie.pretension) <= most && std::isfinite(tie.pretension), "pretension",
          tie.pretension, "N must not exceed yield and break force");
  require(!tie.tension_only || tie.pretension >= 0.0, "pretension", tie.pretension,
          "N must not be negative where the tie bears tension only");
}

void compile_quiet_faces(CompiledScene& compiled) {
  for (const QuietFace& quiet : compiled.scene.quiet_faces) {
    const std::string what =
        checked_load(compiled.scene, "quiet face", compiled.scene.quiet_faces, quiet);
    const BlockModel& model = compiled.models[index(quiet.block)];
    check_face(model, quiet.block, quiet.face, what);
    check_constant(quiet.velocity, what + ": velocity");
    for (const double impedance : {quiet.normal_impedance, quiet.shear_impedance}) {
      if (impedance >= 0.0 && std::isfinite(impedance)) continue;
      throw InputError(what + ": impedance " + text_of(impedance) +
                       " Pa s/m must be finite and not negative");
    }
    const auto cycle = model.shape->topology().face(quiet.face);
    const auto arm = [&](int v) { return Vector3(model.turn * model.shape->vertex(v)); };
    for (std::size_t i = 2; i < cycle.size(); ++i) {
      const Vector3 first = arm(cycle[0]), u = arm(cycle[i - 1]) - first, v = arm(cycle[i]) - first;
      const Vector3 normal = u.cross(v);
      const double area = normal.norm() / 6.0;
      for_each_point(first, u, v, 1, [&](const Vector3& point) {
        compiled.quiet.push_back({quiet.block, point, normal.normalized(),
                                  area * quiet.normal_impedance, area * quiet.shear_impedance,
                                  quiet.velocity});
      });
    }
  }
}

void compile_ties(CompiledScene& compiled) {
  for (const Tie& tie : compiled.scene.ties) {
    const std::string what = tie_label(compiled, compiled.ties.size());
    const TieModel model{tie, tie_arm(compiled, tie.a, tie.point_a, what),
                         tie_arm(compiled, tie.b, tie.point_b, what)};
    check_tie(compiled, tie, what);
    compiled.ties.push_back(model);
  }
}

/// Near the scene, in steps of a power of two of its own size: taking it off rounds nothing, and a
/// scene near zero stays where it is.
Vector3 scene_origin(const Scene& scene) {
  Vector3 low = scene.blocks.front().body().centre(), high = low;
  for (const Block& block : scene.blocks) {
    const geometry::Body body = block.body();
    const double radius = 0.5 * body.stretch() * block.shape->diameter();
    low = low.cwiseMin((body.centre().array() - radius).matrix());
    high = high.cwiseMax((body.centre().array() + radius).matrix());
  }
  const double step = std::exp2(std::ceil(std::log2(2.0 * (high - low).norm())));
  return step * (0.5 / step * (low + high)).array().round().matrix();
}

void check_parts(const Block& block, int index) {
  if (!block.parts) return;
  int vertices = 0, faces = 0;
  for (const geometry::Shape& part : *block.parts) {
    vertices += part.vertex_count();
    faces += part.topology().face_count();
  }
  if (vertices == block.shape->vertex_count() && faces == block.shape->topology().face_count())
    return;
  throw InputError(label(block, index) + ": its parts have " + std::to_string(vertices) +
                   " vertices and " + std::to_string(faces) + " faces, its shape " +
                   std::to_string(block.shape->vertex_count()) + " and " +
                   std::to_string(block.shape->topology().face_count()));
}

void check_shape(const Scene& scene, int block) {
  const Block& b = scene.blocks[index(block)];
  if (b.shape == nullptr) throw InputError(label(b, block) + " has no shape");
  check_parts(b, block);
  const double determinant = b.placement.linear.determinant();
  if (const Vector3& at = b.placement.translation;
      !(at.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < geometry::kLargestCoordinate)) {
    std::ostringstream message;
    message << label(b, block) << ": translation (" << at.transpose()
            << ") m of its placement must be less than " << geometry::kLargestCoordinate << " m";
    throw InputError(message.str());
  }
  if (!(determinant > 0.0 && std::isfinite(determinant))) {
    throw InputError(label(b, block) + ": its placement has determinant " + text_of(determinant) +
                     ", must be finite and greater than 0");
  }
}

void check_coordinate_rounding(const Scene& scene, double smallest_size) {
  const double limit = 1e-3 * smallest_size;
  if (scene.coordinate_rounding >= 0.0 && scene.coordinate_rounding <= limit) return;
  std::ostringstream message;
  message << "coordinate rounding " << scene.coordinate_rounding << " m must be between 0 and "
          << limit << " m, 1e-3 of the smallest block";
  throw InputError(message.str());
}

/// One reference shape for all blocks that share a shape.
class ReferenceShapes {
 public:
  const ReferenceShape& of(const Block& block) {
    const auto [place, is_new] = known_.try_emplace({block.shape.get(), block.parts.get()});
    if (is_new) place->second = reference_shape(*block.shape, block.parts.get());
    return place->second;
  }

 private:
  std::map<std::pair<const geometry::Shape*, const std::vector<geometry::Shape>*>, ReferenceShape>
      known_;
};

}  // namespace

CompiledScene compile(Scene scene) {
  if (scene.blocks.empty()) throw InputError("the scene has no blocks");
  check_joint(scene.joint, "joint");
  for (std::size_t i = 0; i < scene.pair_joints.size(); ++i)
    check_joint(scene.pair_joints[i].joint, "pair joint " + std::to_string(i));
  check_pairs(scene.pair_joints);
  check_block_joints(scene);
  check_finite(scene.gravity.at(0.0), "gravity at time 0");
  CompiledScene compiled;
  compiled.scene = std::move(scene);
  for (std::size_t b = 0; b < compiled.scene.blocks.size(); ++b)
    check_shape(compiled.scene, static_cast<int>(b));
  compiled.origin = scene_origin(compiled.scene);
  std::vector<int> unknowns;
  std::vector<double> sizes;
  ReferenceShapes shapes;
  compiled.models.reserve(compiled.scene.blocks.size());  // large records: doubling would show
  for (std::size_t b = 0; b < compiled.scene.blocks.size(); ++b) {
    const Block& block = compiled.scene.blocks[b];
    const std::string what = label(block, static_cast<int>(b));
    check_square(block.velocity, what + ": velocity");
    check_square(block.angular_velocity, what + ": angular velocity");
    check_finite(block.initial_stress, what + ": initial stress");
    check_constant(block.motion.value, what + ": motion");
    compiled.models.push_back(
        make_block_model(block, shapes.of(block), compiled.origin, static_cast<int>(b)));
    unknowns.push_back(compiled.models.back().unknowns);
    sizes.push_back(compiled.models.back().size);
    if (unknowns.back() == 0)
      compiled.idle_blocks.push_back(static_cast<int>(compiled.idle.size()));
    compiled.idle.push_back(unknowns.back() == 0);
    compiled.has_parts = compiled.has_parts || block.parts;
    check_constant(block.motion.rotation, what + ": rotation");
    check_finite(block.motion.centre, what + ": centre of rotation");
    const bool stands = block.motion.kind != MotionKind::Acceleration &&
                        is_always_zero(block.motion.value) && is_always_zero(block.motion.rotation);
    if (block.kind == BlockKind::Prescribed && !stands)
      compiled.prescribed.push_back(static_cast<int>(b));
  }
  compiled.slots = make_slots(unknowns, sizes);
  compiled.smallest_size = *std::min_element(sizes.begin(), sizes.end());
  check_coordinate_rounding(compiled.scene, compiled.smallest_size);
  if (compiled.slots.count() > 0) {
    compiled.smallest_size =
        *std::min_element(compiled.slots.length.begin(), compiled.slots.length.end());
  }
  const auto has_group = [&](int group) {
    return std::ranges::any_of(compiled.scene.blocks, [group](const Block& block) {
      return block.material.joint_group == group;
    });
  };
  const auto dilates = [&](const PairJoint& pair) {
    return pair.joint.dilation_angle > 0.0 && has_group(pair.group_a) && has_group(pair.group_b);
  };
  compiled.dilates = compiled.scene.joint.dilation_angle > 0.0 ||
                     std::ranges::any_of(compiled.scene.pair_joints, dilates) ||
                     std::ranges::any_of(compiled.scene.block_joints, [](const BlockJoint& pair) {
                       return pair.joint.dilation_angle > 0.0;
                     });
  compile_loads(compiled);
  compile_ties(compiled);
  compile_quiet_faces(compiled);
  return compiled;
}

namespace {

/// Of a function of time, by one-sided differences of second order: before `time` for a step that
/// goes back, s, else after it. For one of 0.01 s they are rounded by 4e-10 / s, and wrong by as
/// much of a swing of 5 Hz.
template <typename Function>
Vector3 rate_beside(const Function& value, double time, double step) {
  const double eps = std::copysign(std::max(1e-4 * std::abs(step), 1e-7), step);
  const Vector3 near = value(time + eps), far = value(time + 2.0 * eps);
  return (4.0 * near - 3.0 * value(time) - far) / (2.0 * eps);
}

}  // namespace

Vector3 velocity_inside(const VectorOfTime& velocity, double end, double other) {
  constexpr double kInside = 1e-6;  // of the interval: there a smooth one changes by as little
  const Vector3 at = velocity.at(end), inside = velocity.at(end + kInside * (other - end));
  const double change =
      std::max((velocity.at(other) - at).norm(), (velocity.at(0.5 * (end + other)) - at).norm());
  return (inside - at).norm() > 0.5 * change ? inside : at;
}

Vector3 velocity_from(const Motion& motion, const Vector3& reached, double time) {
  constexpr double kStep = 0.01;  // s
  switch (motion.kind) {
    case MotionKind::Displacement:
      return rate_beside([&](double t) { return motion.value.at(t); }, time, kStep);
    case MotionKind::Velocity:
      return motion.value.at(time);
    case MotionKind::Acceleration:
      break;
  }
  return reached;
}

void check_motion_velocity(const Scene& scene, int block, const Vector3& velocity, double time) {
  if (std::isfinite(velocity.squaredNorm())) return;
  std::ostringstream message;
  message << label(scene.blocks[index(block)], block) << ": velocity of its motion at " << time
          << " s is not finite, or its square";
  throw InputError(message.str());
}

Quaternion turn_at(const Motion& motion, double time) {
  const Vector3 rotation = motion.rotation.at(time);
  const double angle = rotation.norm();
  if (!(angle > 0.0)) return Quaternion::Identity();
  return Quaternion(Eigen::AngleAxisd(angle, rotation / angle));
}

namespace {

/// Angular velocity as the step ends, or where all begins, `from` = `to`, after that.
void set_turn(const Motion& motion, double from, double to, PrescribedMotion& next) {
  if (motion.rotation.is_constant()) return;
  next.turn = turn_at(motion, to);
  const auto turned = [&](double time) -> Vector3 {
    const Quaternion by = turn_at(motion, time) * next.turn.conjugate();
    return 2.0 / by.w() * by.vec();
  };
  next.angular_velocity = rate_beside(turned, to, from - to);
}

}  // namespace

void lay_ties(const CompiledScene& compiled, State& state) {
  state.ties.clear();
  if (compiled.ties.empty()) return;
  std::vector<Pose> poses;
  for (const BlockState& block : state.blocks) poses.push_back(pose(block));
  for (const TieModel& tie : compiled.ties) {
    const TieState laid = state.ties.emplace_back(laid_tie(tie, poses));
    if (laid.length > 0.0 && laid.rest_length > 0.0) continue;
    throw InputError(tie_label(compiled, state.ties.size() - 1) + ": length " +
                     text_of(laid.length) + " m, unstressed " + text_of(laid.rest_length) +
                     " m, must be greater than 0");
  }
}

State initial_state(const CompiledScene& compiled) {
  State state;
  state.origin = compiled.origin;
  state.held_forces.assign(compiled.held.size(), Vector3::Zero());
  state.quiet_forces.assign(compiled.quiet.size(), Vector3::Zero());
  state.blocks.reserve(compiled.models.size());
  for (std::size_t b = 0; b < compiled.models.size(); ++b) {
    const Block& block = compiled.scene.blocks[b];
    BlockState place = compiled.models[b].start;
    if (compiled.models[b].unknowns > 0) {
      place.velocity = block.velocity;
      place.angular_velocity = block.angular_velocity;
    }
    state.blocks.push_back(place);
  }
  for (const int b : compiled.prescribed) {
    const Motion& motion = compiled.scene.blocks[index(b)].motion;
    Vector3& velocity = state.blocks[index(b)].velocity;
    velocity = velocity_from(motion, velocity, 0.0);
    check_motion_velocity(compiled.scene, b, velocity, 0.0);
    PrescribedMotion begun{.velocity = velocity};
    set_turn(motion, 0.0, 0.0, begun);
    begun.turn = Quaternion::Identity();
    move_along(compiled.models[index(b)], motion, begun, begun, compiled.origin,
               state.blocks[index(b)]);
  }
  lay_ties(compiled, state);
  return state;
}

namespace {

double sum_of(double (*energy)(const BlockModel&, const BlockState&), const CompiledScene& compiled,
              const State& state) {
  double sum = 0.0;
  for (const int block : compiled.slots.block_of_slot) {
    const std::size_t b = index(block);
    sum += energy(compiled.models[b], state.blocks[b]);
  }
  return sum;
}

}  // namespace

double kinetic_energy(const CompiledScene& compiled, const State& state) {
  return sum_of(kinetic_energy, compiled, state);
}

double strain_energy(const CompiledScene& compiled, const State& state) {
  return sum_of(strain_energy, compiled, state);
}

namespace {

PrescribedMotion given_motion(const VectorOfTime& displacement, double from, double to) {
  const auto at = [&](double time) { return displacement.at(time); };
  return {at(to), rate_beside(at, to, from - to)};
}

/// By a three-point Gauss rule: exact where velocity or acceleration is linear from `from` to `to`.
PrescribedMotion integrate(const Motion& motion, const PrescribedMotion& known, double from,
                           double to) {
  PrescribedMotion next = known;
  const double h = to - from;
  const double node = std::sqrt(0.6);
  const double s[3] = {0.5 * (1.0 - node), 0.5, 0.5 * (1.0 + node)};
  const double w[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  Vector3 integral = Vector3::Zero(), first_moment = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vector3 value = motion.value.at(from + s[i] * h);
    integral += w[i] * h * value;
    first_moment += w[i] * h * h * (1.0 - s[i]) * value;
  }
  if (motion.kind == MotionKind::Velocity) {
    next.displacement += integral;
  } else {
    next.displacement += known.velocity * h + first_moment;
    next.velocity += integral;
  }
  return next;
}

/// Where a velocity changes by more than half of its change within ever shorter pieces, s; none:
/// `to`.
double jump_within(const VectorOfTime& velocity, double from, double to) {
  constexpr int kPieces = 4;          // of a smooth one no quarter has nearly all of the change
  constexpr double kNearlyAll = 0.9;  // of the change
  constexpr int kHalvings = 32;       // to 2^-34 of the interval
  std::array<Vector3, kPieces + 1> values;
  double change = 0.0;
  for (int k = 0; k <= kPieces; ++k) {
    values[index(k)] = velocity.at(from + (to - from) * k / kPieces);
    if (k > 0) change += (values[index(k)] - values[index(k - 1)]).norm();
  }
  for (std::size_t k = 0; k < kPieces; ++k) {
    const double most = kNearlyAll * change;
    if (!(change > 0.0) || (values[k + 1] - values[k]).norm() < most) continue;
    double low = from + (to - from) * static_cast<double>(k) / kPieces;
    double high = low + (to - from) / kPieces;
    Vector3 first = values[k], last = values[k + 1];
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle = 0.5 * (low + high);
      const Vector3 value = velocity.at(middle);
      const bool lower = (value - first).norm() >= (last - value).norm();
      (lower ? high : low) = middle;
      (lower ? last : first) = value;
    }
    return (last - first).norm() >= 0.5 * most ? high : to;
  }
  return to;
}

}  // namespace

double next_jump(const Motion& motion, double from, double to) {
  if (motion.kind != MotionKind::Velocity || motion.value.is_constant()) return to;
  const std::span<const double> knots = motion.value.knots();
  if (knots.empty()) return jump_within(motion.value, from, to);
  for (auto knot = std::ranges::upper_bound(knots, from); knot != knots.end() && *knot < to; ++knot)
    if (std::next(knot) != knots.end() && *std::next(knot) == *knot) return *knot;
  return to;
}

namespace {

/// But for its turn.
PrescribedMotion advance_translation(const Motion& motion, const PrescribedMotion& known,
                                     double from, double to) {
  if (motion.kind == MotionKind::Displacement) return given_motion(motion.value, from, to);
  PrescribedMotion next = known;
  double reached = from;
  const auto advance_to = [&](double time) {
    next = integrate(motion, next, reached, time);
    reached = time;
  };
  const std::span<const double> knots = motion.value.knots();
  for (auto knot = std::ranges::upper_bound(knots, from); knot != knots.end() && *knot < to; ++knot)
    advance_to(*knot);
  if (const double jump = next_jump(motion, reached, to); jump < to) advance_to(jump);
  advance_to(to);
  if (motion.kind == MotionKind::Velocity) next.velocity = velocity_inside(motion.value, to, from);
  return next;
}

}  // namespace

PrescribedMotion advance_motion(const Motion& motion, const PrescribedMotion& known, double from,
                                double to) {
  if (from == to) return known;
  PrescribedMotion next = advance_translation(motion, known, from, to);
  next.turn = known.turn;
  set_turn(motion, from, to, next);
  return next;
}

void move_along(const BlockModel& model, const Motion& motion, const PrescribedMotion& from,
                const PrescribedMotion& to, const Vector3& origin, BlockState& block) {
  move_centroid(to.displacement - from.displacement, block);
  block.velocity = to.velocity;
  if (motion.rotation.is_constant()) return;
  const Vector3 arm = (model.start.centroid - (motion.centre - origin)) + model.start.centroid_rest;
  const Vector3 before = block.rotation * arm;
  if (to.turn.coeffs() != from.turn.coeffs())
    block.rotation = (to.turn * from.turn.conjugate() * block.rotation).normalized();
  const Vector3 after = block.rotation * arm;
  move_centroid(after - before, block);
  block.velocity += to.angular_velocity.cross(after);
  block.angular_velocity = block.rotation.conjugate() * to.angular_velocity;
}

}  // namespace quoin::solver
