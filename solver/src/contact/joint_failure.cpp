#include "contact/joint_failure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/rounding.hpp"
#include "contact/contact_jacobian.hpp"
#include "contact/joint_area.hpp"
#include "contact/joint_law.hpp"

namespace quoin::solver {
namespace {

using Eigen::Vector2d;

constexpr double kUnborne = std::numeric_limits<double>::infinity();

/// The contacts of one pair.
struct SolvedJoint {
  std::span<BodyContact> contacts;
  std::span<const LinearContact> linear;
};

/// Place of a contact in the plane of its joint, m.
Vector2d in_plane(const BodyContact& contact, const Vector3& normal) {
  Vector3 t1, t2;
  tangent_frame(contact, normal, t1, t2);
  const Vector3 place = contact.state.point.point();
  return {t1.dot(place), t2.dot(place)};
}

/// What is bonded of a joint, by contact.
struct BondedCorners {
  std::vector<std::size_t> index;
  std::vector<double> pull;    ///< N, tension positive
  std::vector<double> stress;  ///< Pa; empty: they span no area
};

BondedCorners bonded_corners(const SolvedJoint& joint) {
  const Vector3& normal = joint.contacts.front().state.point.normal;
  BondedCorners bonded;
  std::vector<Vector2d> places;
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    if (!joint.contacts[i].state.bonded) continue;
    bonded.index.push_back(i);
    places.push_back(in_plane(joint.contacts[i], normal));
    bonded.pull.push_back(-joint.linear[i].force[0]);
  }
  if (joint.contacts.front().joint->normal_stiffness > 0.0) {
    for (std::size_t k = 0; k < bonded.index.size(); ++k)
      bonded.stress.push_back(bonded.pull[k] / joint.contacts[bonded.index[k]].state.spring_area);
    return bonded;
  }
  const std::optional<JointSection> section = joint_section(places);
  if (section) bonded.stress = section_stress(*section, places, bonded.pull);
  return bonded;
}

/// A crack from a corner runs through the triangles that end there (joint_area.hpp): their inner
/// points part with it. Of the corners those next to an inner point by angle are its triangle's.
void part_triangles(const SolvedJoint& joint, std::span<const char> parted) {
  const Vector3& normal = joint.contacts.front().state.point.normal;
  std::vector<Vector2d> places;
  Vector2d centre = Vector2d::Zero();
  double area = 0.0;
  for (const BodyContact& contact : joint.contacts) {
    places.push_back(in_plane(contact, normal));
    area += contact.state.point.area;
    centre += contact.state.point.area * places.back();
  }
  centre /= area;
  const auto angle = [&](std::size_t of, std::size_t from) {  // 0 .. 2 pi
    const Vector2d x = places[from] - centre, y = places[of] - centre;
    const double turn = std::atan2(x.x() * y.y() - x.y() * y.x(), x.dot(y));
    return turn < 0.0 ? turn + 2.0 * std::numbers::pi : turn;
  };
  for (std::size_t i = 0; i < places.size(); ++i) {
    BodyContact& inner = joint.contacts[i];
    if (!inner.state.bonded || !is_inner(inner.state.point.key)) continue;
    std::size_t next = i, last = i;
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (is_inner(joint.contacts[k].state.point.key)) continue;
      if (next == i || angle(k, i) < angle(next, i)) next = k;
      if (last == i || angle(k, i) > angle(last, i)) last = k;
    }
    if (parted[next] != 0 || parted[last] != 0) weaken(*inner.joint, inner.state);
  }
}

bool part_where_overloaded(const SolvedJoint& joint) {
  const BondedCorners bonded = bonded_corners(joint);
  std::vector<char> parted(joint.contacts.size(), 0);
  bool any = false;
  for (std::size_t k = 0; k < bonded.index.size(); ++k) {
    BodyContact& contact = joint.contacts[bonded.index[k]];
    const double tension = strength(*contact.joint, contact.state).tension;
    const bool spans = !bonded.stress.empty();
    if (spans && !(bonded.stress[k] > (1.0 + kRelativeRounding) * tension)) continue;
    weaken(*contact.joint, contact.state);
    parted[bonded.index[k]] = 1;
    any = true;
  }
  if (any) part_triangles(joint, parted);
  return any;
}

bool fail_where_opened(const SolvedJoint& joint, double limit) {
  bool any = false;
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    BodyContact& contact = joint.contacts[i];
    const LinearContact& c = joint.linear[i];
    const bool opened = (c.mode == ContactMode::Open || unpressed(c)) && c.relative[0] > limit;
    if (!opened || contact.state.bonded) continue;
    any = any || c.clings || !contact.state.failed;
    contact.parted = true;
    if (!contact.state.failed) weaken(*contact.joint, contact.state);
  }
  return any;
}

/// Shear on the contacts that are bonded in shear, and what they bear. Vectors in the joint's
/// plane.
struct ShearState {
  Vector2d force = Vector2d::Zero(), centre = Vector2d::Zero();
  double limit = 0.0;         ///< N
  double moment = 0.0;        ///< N m, about the centre of strength
  double moment_limit = 0.0;  ///< N m
};

/// Of a contact, N.
struct ShearStrength {
  double friction = 0.0, cohesion = 0.0;
};

ShearStrength shear_strength(const BodyContact& contact, const LinearContact& c) {
  const JointStrength now = strength(*contact.joint, contact.state);
  const double friction = now.friction * c.force[0];
  const double cohesion = now.cohesion * contact.state.point.area + std::min(friction, 0.0);
  return {std::max(friction, 0.0), std::max(cohesion, 0.0)};
}

/// Cohesion acts on the whole area, less what pulls take off it; friction where the contacts are.
ShearState shear_state(const SolvedJoint& joint) {
  const Vector3& normal = joint.contacts.front().state.point.normal;
  ShearState state;
  std::vector<Vector2d> places, forces;
  std::vector<ShearStrength> bears;
  double cohesion = 0.0;
  for (std::size_t i = 0; i < joint.contacts.size(); ++i) {
    const BodyContact& contact = joint.contacts[i];
    if (!bonded_in_shear(*contact.joint, contact.state)) continue;
    places.push_back(in_plane(contact, normal));
    forces.push_back(joint.linear[i].force.tail<2>());
    bears.push_back(shear_strength(contact, joint.linear[i]));
    const double both = bears.back().friction + bears.back().cohesion;
    state.force += forces.back();
    state.limit += both;
    state.centre += both * places.back();
    cohesion += bears.back().cohesion;
  }
  if (state.limit > 0.0) state.centre /= state.limit;
  const bool spans = joint_section(places).has_value();
  if (spans) state.moment_limit = cohesion * mean_distance(places, state.centre);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Vector2d arm = places[k] - state.centre;
    state.moment += arm.x() * forces[k].y() - arm.y() * forces[k].x();
    state.moment_limit += (bears[k].friction + (spans ? 0.0 : bears[k].cohesion)) * arm.norm();
  }
  return state;
}

double share(double load, double bears) { return load > 0.0 ? load / bears : 0.0; }

/// Of the strength in tension that the worst corner bears; of `negligible` (N) nothing.
double tension_load(const SolvedJoint& joint, double negligible) {
  const BondedCorners bonded = bonded_corners(joint);
  double largest = 0.0;
  for (std::size_t k = 0; k < bonded.index.size(); ++k) {
    if (!(bonded.pull[k] > negligible)) continue;
    const BodyContact& contact = joint.contacts[bonded.index[k]];
    const double tension = strength(*contact.joint, contact.state).tension;
    const double load = bonded.stress.empty() ? kUnborne : share(bonded.stress[k], tension);
    largest = std::max(largest, load);
  }
  return largest;
}

/// Likewise in shear: the radius of the ellipsoid that its forces are on.
double shear_load(const SolvedJoint& joint, double negligible) {
  const ShearState shear = shear_state(joint);
  const double force = shear.force.norm(), moment = std::abs(shear.moment);
  const double arm = share(shear.moment_limit, shear.limit);
  if (!(force > negligible) && !(moment > negligible * arm)) return 0.0;
  const bool point = shear.moment_limit == 0.0;
  return std::hypot(share(force, shear.limit), point ? 0.0 : moment / shear.moment_limit);
}

double load_of(const SolvedJoint& joint, double negligible) {
  return std::max(tension_load(joint, negligible), shear_load(joint, negligible));
}

bool fail_where_sliding(const SolvedJoint& joint) {
  const ShearState shear = shear_state(joint);
  const double beyond = shear.force.squaredNorm() * shear.moment_limit * shear.moment_limit +
                        shear.moment * shear.moment * shear.limit * shear.limit;
  const double allowed = shear.limit * shear.moment_limit * (1.0 + kRelativeRounding);
  const bool point = shear.moment_limit == 0.0;  // bears no moment, and gets none
  const bool holds = point ? shear.force.norm() <= (1.0 + kRelativeRounding) * shear.limit
                           : beyond <= allowed * allowed;
  if (holds) return false;
  bool any = false;
  for (BodyContact& contact : joint.contacts) {
    if (!bonded_in_shear(*contact.joint, contact.state)) continue;
    weaken(*contact.joint, contact.state);
    any = true;
  }
  return any;
}

/// Those that can fail.
template <typename Visit>
void each_weak_joint(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                     const Visit& visit) {
  each_joint(contacts, [&](std::span<BodyContact> joint) {
    // A stage may take the strength of joints that are bonded.
    const bool bonded =
        std::ranges::any_of(joint, [](const BodyContact& c) { return c.state.bonded; });
    if (!bonded && !can_fail(*joint.front().joint)) return;
    const auto first = static_cast<std::size_t>(joint.data() - contacts.data());
    visit(SolvedJoint{joint, linear.subspan(first, joint.size())});
  });
}

}  // namespace

bool fail_overloaded(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                     double opened) {
  bool any = false;
  each_weak_joint(contacts, linear, [&](const SolvedJoint& joint) {
    any = part_where_overloaded(joint) || any;
    any = fail_where_opened(joint, opened) || any;
    any = fail_where_sliding(joint) || any;
  });
  return any;
}

bool may_fail(std::span<const BodyContact> contacts) {
  return std::ranges::any_of(contacts, [](const BodyContact& contact) {
    if (contact.state.bonded) return true;
    if (contact.parted || !can_fail(*contact.joint)) return false;
    return clings(*contact.joint, contact.state);  // all that are bonded in shear do
  });
}

std::vector<double> joint_loads(std::span<BodyContact> contacts,
                                std::span<const LinearContact> linear, double largest_force) {
  std::vector<double> loads(contacts.size(), 0.0);
  each_weak_joint(contacts, linear, [&](const SolvedJoint& joint) {
    const auto first = loads.begin() + (joint.contacts.data() - contacts.data());
    std::fill_n(first, joint.contacts.size(), load_of(joint, kRelativeRounding * largest_force));
  });
  return loads;
}

bool fail_chosen(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                 std::span<const char> chosen) {
  bool any = false;
  each_weak_joint(contacts, linear, [&](const SolvedJoint& joint) {
    if (!chosen[static_cast<std::size_t>(joint.contacts.data() - contacts.data())]) return;
    any = part_where_overloaded(joint) || any;
    any = fail_where_sliding(joint) || any;
  });
  return any;
}

bool fail_opened(std::span<BodyContact> contacts, std::span<const LinearContact> linear,
                 double opened) {
  bool any = false;
  each_weak_joint(contacts, linear,
                  [&](const SolvedJoint& joint) { any = fail_where_opened(joint, opened) || any; });
  return any;
}

}  // namespace quoin::solver
