#include "statics/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/index.hpp"
#include "base/joined_groups.hpp"
#include "contact/contact_history.hpp"
#include "contact/joint_area.hpp"
#include "contact/joint_law.hpp"
#include "statics/cone_program.hpp"

namespace quoin::solver {
namespace {

using Eigen::VectorXd;

constexpr double kTouching = 1e-6;    // of the smaller block
constexpr int kMostIterations = 150;  // a wall of 10 050 bricks takes 60
constexpr double kLeastPart = 1e-13;  // of a strict mechanism that is added to a tight one
constexpr double kNears[] = {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3};  // of compatible_motion()
constexpr double kOneNormal =
    0.7;  // cosine between normals that count as one: a hinge's, opened by 45 degrees
constexpr double kFewOfLargest = 0.05;  // a factor this far below the largest one is solved again

Matrix3 contact_frame(const Vector3& normal) {
  Matrix3 frame;
  frame.col(0) = normal;
  frame.col(1) = normal.unitOrthogonal();
  frame.col(2) = normal.cross(frame.col(1));
  return frame;
}

Vector6 load_at(const Vector3& arm, const Vector3& force) {
  Vector6 load;
  load << force, arm.cross(force);
  return load;
}

/// Blocks that contacts join, and their contacts.
struct Group {
  std::vector<int> blocks, contacts;
};

std::vector<Group> groups_of(const EquilibriumProblem& problem, std::vector<int>& slot_of_block) {
  const std::size_t count = problem.blocks.size();
  JoinedGroups joined;
  joined.part(count);
  const auto moves = [&](int b) { return b >= 0 && problem.blocks[index(b)].moves; };
  for (const EquilibriumContact& c : problem.contacts)
    if (moves(c.a) && moves(c.b)) joined.join(c.a, c.b);
  std::vector<Group> groups;
  std::vector<int> group_of(count, -1);
  slot_of_block.assign(count, -1);
  for (int b = 0; b < static_cast<int>(count); ++b) {
    if (!moves(b)) continue;
    int& group = group_of[index(joined.least(b))];
    if (group < 0) {
      group = static_cast<int>(groups.size());
      groups.emplace_back();
    }
    slot_of_block[index(b)] = static_cast<int>(groups[index(group)].blocks.size());
    groups[index(group)].blocks.push_back(b);
  }
  for (int i = 0; i < static_cast<int>(problem.contacts.size()); ++i) {
    const EquilibriumContact& c = problem.contacts[index(i)];
    const int one = moves(c.a) ? c.a : c.b;
    if (moves(one)) groups[index(group_of[index(joined.least(one))])].contacts.push_back(i);
  }
  return groups;
}

/// Velocity fields that are combined.
struct MechanismPair {
  const std::vector<Vector6>&tight, &strict;
};

/// What contacts make of a motion.
struct Along {
  double dissipation = 0.0;
  double short_of = 0.0, short_sum = 0.0;  ///< of v_n >= mu |v_t|
};

/// One group in numbers of size 1: forces by `force`, moments and turns by the blocks' sizes.
class GroupProblem {
 public:
  GroupProblem(const EquilibriumProblem& problem, const Group& group, const std::vector<int>& slots)
      : problem_(problem), group_(group), slots_(slots) {}

  /// At `factor`; `range` > 0: how much more is borne, up to that.
  void solve(double factor, double range, Equilibrium& result);
  /// Ends where forces seem to exist.
  void look_for_mechanism(Equilibrium& result);
  double factor() const { return factor_; }
  /// Of combined_mechanism(), and of least_falling_factor().
  void combine(double factor, const MechanismPair& pair, Equilibrium& result);
  void combine_least(const MechanismPair& pair, Equilibrium& result);

 private:
  VectorXd scaled_velocities(const std::vector<Vector6>& velocities) const;
  VectorXd scaled_loads(double factor) const;
  ConeContact cone_contact(const EquilibriumContact& contact) const;
  void fill(double factor, double range);
  void judge_forces(const VectorXd& forces, Equilibrium& result) const;
  Along along(const VectorXd& y) const;
  std::vector<VectorXd> sums(const MechanismPair& pair) const;
  void judge_velocities(const VectorXd& velocities, Equilibrium& result) const;

  const EquilibriumProblem& problem_;
  const Group& group_;
  const std::vector<int>& slots_;
  ConeProgram program_;
  double force_ = 1.0;  ///< N
  double factor_ = 0.0;
};

/// By slot, not yet by force_: moments by the blocks' sizes.
VectorXd GroupProblem::scaled_loads(double factor) const {
  VectorXd loads(6 * static_cast<Eigen::Index>(group_.blocks.size()));
  for (std::size_t s = 0; s < group_.blocks.size(); ++s) {
    const EquilibriumBlock& block = problem_.blocks[index(group_.blocks[s])];
    Vector6 load = factor == kInfinite ? block.live : Vector6(block.load + factor * block.live);
    load.tail<3>() /= block.size;
    loads.segment<6>(6 * static_cast<Eigen::Index>(s)) = load;
  }
  return loads;
}

ConeContact GroupProblem::cone_contact(const EquilibriumContact& contact) const {
  ConeContact cone;
  const Matrix3 frame = contact_frame(contact.normal);
  double size = kInfinite;
  const auto map = [&](int b, double sign, int& slot) {
    Matrix6x3 result = Matrix6x3::Zero();
    slot = b >= 0 ? slots_[index(b)] : -1;
    if (slot < 0) return result;
    const EquilibriumBlock& block = problem_.blocks[index(b)];
    const Vector3 arm = (contact.point - block.place) / block.size;
    size = std::min(size, block.size);
    result << sign * frame, sign * cross_matrix(arm) * frame;
    const bool shears = contact.held || contact.friction > 0.0 || contact.cohesion > 0.0;
    if (!shears || contact.guided) result.rightCols<2>().setZero();
    return result;
  };
  cone.map_a = map(contact.a, -1.0, cone.a);
  cone.map_b = map(contact.b, 1.0, cone.b);
  cone.friction = contact.friction;
  cone.cohesion = contact.cohesion / force_;
  cone.tension = contact.tension / force_;
  cone.cost = std::max(contact.gap, 0.0) / size;
  cone.held = contact.held || contact.guided;
  return cone;
}

void GroupProblem::fill(double factor, double range) {
  program_.slots = static_cast<int>(group_.blocks.size());
  program_.load = scaled_loads(factor);
  program_.live.resize(0);
  if (range > 0.0) program_.live = range * scaled_loads(kInfinite);
  force_ = std::max(largest_entry(program_.load), largest_entry(program_.live));
  program_.contacts.clear();
  if (!(force_ > 0.0)) return;
  program_.load /= force_;
  program_.live /= force_;
  for (const int i : group_.contacts)
    program_.contacts.push_back(cone_contact(problem_.contacts[index(i)]));
}

/// `forces`: in contact frames, by force_.
void GroupProblem::judge_forces(const VectorXd& forces, Equilibrium& result) const {
  VectorXd left = program_.load;
  if (program_.live.size() > 0) left += factor_ * program_.live;
  for (std::size_t i = 0; i < group_.contacts.size(); ++i) {
    const ConeContact& c = program_.contacts[i];
    const Vector3 f = forces.segment<3>(3 * static_cast<Eigen::Index>(i));
    c.add_load(f, left);
    const EquilibriumContact& contact = problem_.contacts[index(group_.contacts[i])];
    result.forces[index(group_.contacts[i])] = force_ * (contact_frame(contact.normal) * f);
    if (c.held) continue;
    const double inside =
        std::min(c.has_cut_off() ? f[0] + c.tension : kInfinite,
                 c.has_cone() ? c.friction * f[0] + c.cohesion - f.tail<2>().norm() : kInfinite);
    result.margin = std::min(result.margin, inside);
    result.violation = std::max(result.violation, -inside);
  }
  result.unbalance = std::max(result.unbalance, largest_entry(left));
}

/// A contact dissipates at most C |v_t| + T (v_n - mu |v_t|), where the cut-off decides, else
/// C v_n / mu.
Along GroupProblem::along(const VectorXd& y) const {
  Along result;
  for (const ConeContact& c : program_.contacts) {
    const Vector3 v = c.motion(y);
    const double slip = c.has_cone() ? v.tail<2>().norm() : 0.0;
    const double apart = v[0] - c.friction * slip;
    const double lacking = c.held ? v.norm() : std::max(0.0, -apart);
    result.short_of = std::max(result.short_of, lacking);
    result.short_sum += lacking;
    if (c.held) continue;
    result.dissipation += c.has_cut_off() ? c.cohesion * slip + c.tension * std::max(0.0, apart)
                                          : c.cohesion * std::max(0.0, v[0]) / c.friction;
  }
  return result;
}

/// Velocities by the blocks' sizes.
void GroupProblem::judge_velocities(const VectorXd& given, Equilibrium& result) const {
  const double fastest = largest_entry(given);
  if (!(fastest > 0.0)) return;
  const VectorXd y = given / fastest;
  const Along contacts = along(y);
  const double power =
      program_.load.dot(y) + (program_.live.size() > 0 ? factor_ * program_.live.dot(y) : 0.0);
  result.incompatibility = std::max(result.incompatibility, contacts.short_of);
  result.power += force_ * power;
  result.dissipation += force_ * contacts.dissipation;
  for (std::size_t s = 0; s < group_.blocks.size(); ++s) {
    Vector6& velocity = result.velocities[index(group_.blocks[s])];
    velocity = y.segment<6>(6 * static_cast<Eigen::Index>(s));
    velocity.tail<3>() /= problem_.blocks[index(group_.blocks[s])].size;
  }
  const double excess = power - contacts.dissipation;
  const bool proves = contacts.short_of <= Equilibrium::kBalanced &&
                      excess > Equilibrium::kBalanced &&
                      excess > Equilibrium::kLargestForces * contacts.short_sum;
  if (proves) result.verdict = EquilibriumVerdict::Mechanism;
}

void GroupProblem::look_for_mechanism(Equilibrium& result) {
  program_.mechanism_only = true;
  solve(0.0, 0.0, result);
}

void GroupProblem::solve(double factor, double range, Equilibrium& result) {
  fill(factor, range);
  factor_ = range > 0.0 ? 1.0 : 0.0;
  result.verdict = EquilibriumVerdict::Admissible;
  if (force_ > 0.0 && !(range > 0.0 && program_.live.isZero(0.0))) {
    const ConeSolution solution = quoin::solver::solve(program_, kMostIterations);
    result.factorizations += solution.factorizations;
    factor_ = std::clamp(solution.factor, 0.0, 1.0);
    judge_forces(solution.forces, result);
    const bool balanced =
        result.unbalance <= Equilibrium::kBalanced && result.violation <= Equilibrium::kBalanced;
    if (!balanced) result.verdict = EquilibriumVerdict::Undecided;
    const double found = std::exchange(factor_, balanced ? factor_ : 0.0);
    if (range > 0.0 || !balanced) judge_velocities(solution.velocities, result);
    factor_ = found;
    if (range > 0.0 && balanced) result.verdict = EquilibriumVerdict::Admissible;
  }
  factor_ = factor + range * factor_;
}

/// Of size 1, moments' conjugates by the blocks' sizes.
VectorXd GroupProblem::scaled_velocities(const std::vector<Vector6>& velocities) const {
  VectorXd result(6 * static_cast<Eigen::Index>(group_.blocks.size()));
  for (std::size_t s = 0; s < group_.blocks.size(); ++s) {
    Vector6 velocity = velocities[index(group_.blocks[s])];
    velocity.tail<3>() *= problem_.blocks[index(group_.blocks[s])].size;
    result.segment<6>(6 * static_cast<Eigen::Index>(s)) = velocity;
  }
  const double fastest = largest_entry(result);
  return fastest > 0.0 ? VectorXd(result / fastest) : result;
}

/// The tight one as it is and made compatible, each with so little of the strict one that no
/// contact closes, the largest of size 1.
std::vector<VectorXd> GroupProblem::sums(const MechanismPair& pair) const {
  const VectorXd one = scaled_velocities(pair.tight), other = scaled_velocities(pair.strict);
  std::vector<VectorXd> tights{one}, result;
  for (const double near : kNears) tights.push_back(compatible_motion(program_, one, near));
  for (const VectorXd& tight : tights) {
    for (double part = kLeastPart; part <= 1.0; part *= 4.0) {
      VectorXd sum = tight + part * other;
      sum /= std::max(largest_entry(sum), 1e-300);
      if (along(sum).short_sum * Equilibrium::kLargestForces > Equilibrium::kBalanced) continue;
      result.push_back(std::move(sum));
      break;
    }
  }
  return result;
}

void GroupProblem::combine(double factor, const MechanismPair& pair, Equilibrium& result) {
  fill(factor, 0.0);
  factor_ = factor;
  if (!(force_ > 0.0)) return;
  const auto excess = [&](const VectorXd& y) {
    return program_.load.dot(y) - along(y).dissipation;
  };
  const std::vector<VectorXd> all = sums(pair);
  const auto best = std::ranges::max_element(all, {}, excess);
  if (best != all.end()) judge_velocities(*best, result);
}

/// The factor where a sum does just what contacts take, and a hair more.
void GroupProblem::combine_least(const MechanismPair& pair, Equilibrium& result) {
  fill(0.0, 1.0);
  if (!(force_ > 0.0)) return;
  const double dead_size = largest_entry(program_.load);
  const double live_size = largest_entry(program_.live);
  const auto least = [&](const VectorXd& y) {
    const double live = program_.live.dot(y);
    if (!(live > 0.0)) return kInfinite;
    const double factor = (along(y).dissipation - program_.load.dot(y)) / live;
    return factor +
           2.0 * Equilibrium::kBalanced * (dead_size + std::abs(factor) * live_size) / live;
  };
  const std::vector<VectorXd> all = sums(pair);
  const auto best = std::ranges::min_element(all, {}, least);
  if (best == all.end() || !(least(*best) < kInfinite)) return;
  factor_ = result.factor = least(*best);
  fill(factor_, 0.0);
  judge_velocities(*best, result);
}

Equilibrium empty_result(const EquilibriumProblem& problem) {
  Equilibrium result;
  result.forces.assign(problem.contacts.size(), Vector3::Zero());
  result.velocities.assign(problem.blocks.size(), Vector6::Zero());
  result.margin = kInfinite;
  return result;
}

/// A mechanism of any island is one of the whole, and one that is undecided leaves the whole so.
EquilibriumVerdict together(EquilibriumVerdict one, EquilibriumVerdict other) {
  if (one == EquilibriumVerdict::Mechanism || other == EquilibriumVerdict::Mechanism)
    return EquilibriumVerdict::Mechanism;
  return one == other ? one : EquilibriumVerdict::Undecided;
}

}  // namespace

std::vector<Vector6> block_loads(const CompiledScene& compiled, const State& state) {
  std::vector<Vector6> loads(compiled.models.size(), Vector6::Zero());
  std::vector<double> sizes(loads.size(), 0.0);  // sums of the parts' sizes, N
  for (const int b : compiled.slots.block_of_slot) {
    loads[index(b)].head<3>() =
        compiled.models[index(b)].mass * compiled.scene.gravity.at(state.time);
    sizes[index(b)] = loads[index(b)].norm();
  }
  for (const PointForce& load : compiled.loads) {
    const Pose now = pose(state.blocks[index(load.block)]);
    const Vector3 force = load.at(now, state.time);
    loads[index(load.block)] += load_at(now.shape * load.arm, force);
    sizes[index(load.block)] += force.norm();
  }
  for (std::size_t b = 0; b < loads.size(); ++b) {  // what is in balance has rounding left
    const double arm = compiled.models[b].size;
    const double rest = loads[b].head<3>().norm() + loads[b].tail<3>().norm() / arm;
    if (rest <= Equilibrium::kBalanced * sizes[b]) loads[b].setZero();
  }
  return loads;
}

namespace {

/// What a problem is made of.
struct ProblemScene {
  const CompiledScene& compiled;
  const State& state;
  std::vector<Pose> poses{};
  double reach = 0.0;  ///< m
  StrengthPoints points = StrengthPoints::ShareArea;

  /// Gap up to which two blocks touch, m.
  double touching(const BodyContact& contact) const {
    const double size =
        std::min(compiled.models[index(contact.a)].size, compiled.models[index(contact.b)].size);
    return std::max({reach, kTouching * size, compiled.scene.coordinate_rounding});
  }
  bool has_inner_points(const Joint& joint) const {
    if (!(std::max(joint.cohesion, joint.tension) > 0.0)) return false;
    return points != StrengthPoints::OfSteps || acts_by_area(joint);
  }
  bool has_core(const Joint& joint) const {
    return points == StrengthPoints::OfCore && joint.tension > 0.0;
  }
  JointBlocks blocks_of(const BodyContact& contact) const {
    return {compiled.models[index(contact.a)], compiled.models[index(contact.b)],
            poses[index(contact.a)], poses[index(contact.b)]};
  }
};

/// One of the two convex bodies at a contact, seen from it.
struct BodyAtContact {
  const BlockModel& model;
  int part = 0;
  Matrix3 turn;   ///< from the shape's frame to the world
  Vector3 place;  ///< of the contact, in the shape's frame

  /// Farthest that it reaches beyond the contact along `way`, m.
  double beyond(const Vector3& way) const {
    const FeatureRange vertices = vertices_of(model, part);
    double most = -kInfinite;
    for (int v = vertices.first; v < vertices.end; ++v)
      most = std::max(most, way.dot(turn * (model.shape->vertex(v) - place)));
    return most;
  }
};

/// Where blocks meet along an edge or at a corner alone, normals far apart may part them: a small
/// motion along any one is free, so no force counts.
bool has_own_normal(const ProblemScene& scene, const BodyContact& contact) {
  const auto body = [&](int block, int part, const Vector3& arm) {
    const BlockModel& model = scene.compiled.models[index(block)];
    return BodyAtContact{model, part, scene.poses[index(block)].rotation * model.turn,
                         model.turn.transpose() * arm};
  };
  const BodyAtContact a = body(contact.a, contact.part_a, contact.arm_a);
  const BodyAtContact b = body(contact.b, contact.part_b, contact.arm_b);
  const double near = scene.touching(contact);
  std::vector<Vector3> parting{contact.state.point.normal};
  for (const auto& [own, sign] : {std::pair(&a, 1.0), {&b, -1.0}}) {
    const FeatureRange faces = faces_of(own->model, own->part);
    for (int f = faces.first; f < faces.end; ++f) {
      const Vector3 way = sign * (own->turn * own->model.shape->face_normal(f));
      if (a.beyond(way) <= near && b.beyond(-way) <= near) parting.push_back(way);
    }
  }
  return std::ranges::all_of(parting, [&](const Vector3& one) {
    return std::ranges::all_of(parting,
                               [&](const Vector3& other) { return one.dot(other) > kOneNormal; });
  });
}

/// The points of a joint with strength share its area.
std::vector<BodyContact> with_inner_points(const ProblemScene& scene,
                                           std::span<const BodyContact> corners) {
  const BodyContact& first = corners.front();
  std::vector<BodyContact> points(corners.begin(), corners.end());
  double area = 0.0;
  for (const BodyContact& corner : corners) area += corner.state.point.area;
  if (!(area > 0.0) || !scene.has_inner_points(*first.joint)) return points;
  const std::vector<BlockModel>& models = scene.compiled.models;
  const JointBlocks blocks = scene.blocks_of(first);
  const JointPolygon polygon = joint_polygon(blocks, first);
  if (!(polygon.area > 0.0)) return points;
  for (const auto& inner : inner_points(blocks, polygon, corners, scene.touching(first)))
    points.push_back(make_body_contact({scene.compiled.scene, models, scene.poses}, inner));
  const auto shares = area_shares(blocks, polygon, cohesion_rule(polygon), points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].state.point.area = shares[i];
  return points;
}

EquilibriumContact equilibrium_contact(const ProblemScene& scene, const BodyContact& contact) {
  const geometry::ContactPoint& point = contact.state.point;
  const JointStrength bears = strength(*contact.joint, Contact{});
  const double cohesion = std::max(bears.cohesion, bears.friction * bears.tension);
  const Vector3 middle = 0.5 * (local_point(scene.state, contact.a, contact.arm_a) +
                                local_point(scene.state, contact.b, contact.arm_b));
  return {.a = contact.a,
          .b = contact.b,
          .point = middle,
          .normal = point.normal,
          .gap = point.gap,
          .friction = bears.friction,
          .cohesion = cohesion * point.area,
          .tension = bears.tension * point.area};
}

/// Its normal force acts at the corners of the core. Shear strength is that of steps: friction and
/// cohesion where the cone reaches the tension, none without cohesion.
std::vector<EquilibriumContact> core_contacts(const ProblemScene& scene,
                                              std::span<const BodyContact> corners) {
  const BodyContact& first = corners.front();
  const JointPolygon polygon = joint_polygon(scene.blocks_of(first), first);
  const JointStrength bears = strength(*first.joint, Contact{});
  EquilibriumContact contact = equilibrium_contact(scene, first);
  const Vector3 middle = contact.point;
  const Eigen::Vector2d from = polygon.plane(middle - scene.state.blocks[index(first.a)].centroid);
  const double most = bears.friction > 0.0 ? bears.cohesion / bears.friction : kInfinite;
  const double tension = bears.cohesion > 0.0 ? std::min(bears.tension, most) : bears.tension;
  if (!(bears.cohesion > 0.0)) contact.friction = 0.0;
  std::vector<EquilibriumContact> result;
  for (const Eigen::Vector2d& at : core(polygon)) {
    const double area = polygon.triangles[result.size()];
    contact.point = middle + (at - from).x() * polygon.plane.u + (at - from).y() * polygon.plane.v;
    contact.cohesion = bears.cohesion * area;
    contact.tension = tension * area;
    result.push_back(contact);
  }
  return result;
}

}  // namespace

EquilibriumProblem equilibrium_problem(const CompiledScene& compiled, const State& state,
                                       std::span<const geometry::ContactPoint> found, double reach,
                                       StrengthPoints points) {
  if (!compiled.ties.empty() || !compiled.scene.quiet_faces.empty())
    throw InputError("a problem of equilibrium can't have ties or quiet faces");
  EquilibriumProblem problem{.origin = state.origin};
  ProblemScene scene{compiled, state, {}, reach, points};
  const std::vector<Vector6> loads = block_loads(compiled, state);
  for (std::size_t b = 0; b < compiled.models.size(); ++b) {
    problem.blocks.push_back(
        {compiled.idle[b] == 0, state.blocks[b].centroid, compiled.models[b].size, loads[b]});
    scene.poses.push_back(pose(state.blocks[b]));
  }
  std::vector<BodyContact> contacts;
  for (const geometry::ContactPoint& point : found) {
    contacts.push_back(make_body_contact({compiled.scene, compiled.models, scene.poses}, point));
    if (point.gap > scene.touching(contacts.back())) contacts.pop_back();
  }
  if (compiled.has_parts) std::ranges::sort(contacts, {}, joint_order);
  each_joint(contacts, [&](std::span<const BodyContact> joint) {
    double area = 0.0;
    for (const BodyContact& contact : joint) area += contact.state.point.area;
    const BodyContact& first = joint.front();
    const double size =
        std::min(compiled.models[index(first.a)].size, compiled.models[index(first.b)].size);
    const bool meets = scene.points == StrengthPoints::OfSteps ||
                       area > scene.touching(first) * size;  // wider than what touches
    if (meets && scene.has_core(*first.joint)) {
      const std::vector<EquilibriumContact> added = core_contacts(scene, joint);
      problem.contacts.insert(problem.contacts.end(), added.begin(), added.end());
      if (!added.empty()) return;
    }
    for (const BodyContact& contact : with_inner_points(scene, joint)) {
      if (!meets && !has_own_normal(scene, contact)) continue;
      problem.contacts.push_back(equilibrium_contact(scene, contact));
    }
  });
  for (const HeldPoint& held : compiled.held) {
    const Vector3 at = local_point(state, held.block, held.arm);
    problem.contacts.push_back({.b = held.block, .point = at, .held = true});
  }
  return problem;
}

const char* name(EquilibriumVerdict verdict) {
  static constexpr const char* kNames[] = {"undecided", "admissible", "mechanism"};
  return kNames[static_cast<std::size_t>(verdict)];
}

Equilibrium find_equilibrium(const EquilibriumProblem& problem, double factor) {
  Equilibrium result = empty_result(problem);
  std::vector<int> slots;
  EquilibriumVerdict verdict = EquilibriumVerdict::Admissible;
  for (const Group& group : groups_of(problem, slots)) {
    GroupProblem(problem, group, slots).solve(factor, 0.0, result);
    verdict = together(verdict, result.verdict);
    ++result.islands;
  }
  result.verdict = verdict;
  result.factor = factor;
  return result;
}

Equilibrium find_mechanism(const EquilibriumProblem& problem) {
  Equilibrium result = empty_result(problem);
  std::vector<int> slots;
  for (const Group& group : groups_of(problem, slots)) {
    GroupProblem(problem, group, slots).look_for_mechanism(result);
    ++result.islands;
    if (result.verdict == EquilibriumVerdict::Mechanism) return result;
  }
  result.verdict = EquilibriumVerdict::Undecided;
  return result;
}

namespace {

/// Of the first group, or of that with the least factor, that one of the combinations proves.
template <class Combine>
Equilibrium best_mechanism(const EquilibriumProblem& problem, const Combine& combine) {
  Equilibrium best = empty_result(problem);
  std::vector<int> slots;
  for (const Group& group : groups_of(problem, slots)) {
    GroupProblem part(problem, group, slots);
    Equilibrium own = empty_result(problem);
    combine(part, own);
    const int islands = best.islands + 1;
    if (own.verdict == EquilibriumVerdict::Mechanism &&
        (best.verdict != own.verdict || own.factor < best.factor))
      best = std::move(own);
    best.islands = islands;
  }
  return best;
}

}  // namespace

Equilibrium combined_mechanism(const EquilibriumProblem& problem, double factor,
                               const std::vector<Vector6>& tight,
                               const std::vector<Vector6>& strict) {
  Equilibrium result = best_mechanism(problem, [&](GroupProblem& part, Equilibrium& own) {
    part.combine(factor, {tight, strict}, own);
  });
  result.factor = factor;
  return result;
}

Equilibrium least_falling_factor(const EquilibriumProblem& problem,
                                 const std::vector<Vector6>& tight,
                                 const std::vector<Vector6>& strict) {
  return best_mechanism(problem, [&](GroupProblem& part, Equilibrium& own) {
    part.combine_least({tight, strict}, own);
  });
}

Equilibrium largest_load_factor(const EquilibriumProblem& problem, double largest) {
  Equilibrium result = empty_result(problem);
  std::vector<int> slots;
  EquilibriumVerdict verdict = EquilibriumVerdict::Admissible;
  result.factor = largest;
  result.limited = false;
  for (const Group& group : groups_of(problem, slots)) {
    GroupProblem island(problem, group, slots);
    double range = largest;
    Equilibrium own = empty_result(problem);
    for (int round = 0; round < 4; ++round) {
      own = empty_result(problem);
      island.solve(0.0, range, own);
      result.factorizations += own.factorizations;
      if (own.verdict != EquilibriumVerdict::Admissible || island.factor() > kFewOfLargest * range)
        break;
      range = std::max(4.0 * island.factor(), 1e-3 * range);
    }
    verdict = together(verdict, own.verdict);
    ++result.islands;
    const bool limits = island.factor() < largest * (1.0 - 1e-7);
    if (own.verdict != EquilibriumVerdict::Admissible ||
        (limits && island.factor() < result.factor)) {
      own.factorizations = result.factorizations;
      own.islands = result.islands;
      own.factor = std::min(result.factor, island.factor());
      own.limited = result.limited || limits;
      result = own;
    }
    if (verdict == EquilibriumVerdict::Mechanism) break;
  }
  result.verdict = verdict;
  return result;
}

}  // namespace quoin::solver
