#include "joint_rows.hpp"

#include <algorithm>
#include <cmath>
#include <quoin/geometry/contact_point.hpp>

#include "scene_file/no_tension.hpp"

namespace quoin::commands {
namespace {

using geometry::Matrix3;
using solver::Contact;
using solver::Vector3;

JointedPair pair_of(const Contact& contact) { return {contact.point.key.a, contact.point.key.b}; }

/// Where a block's shape stands now, relative to State::origin: a deforming block stays an affine
/// image of its shape.
geometry::Placement placement_now(const solver::Simulation& simulation, int block) {
  const solver::State& state = simulation.state();
  const geometry::Placement& start =
      simulation.scene().blocks[static_cast<std::size_t>(block)].placement;
  const geometry::Shape& shape = *simulation.scene().blocks[static_cast<std::size_t>(block)].shape;
  const Vector3 origin = solver::local_point(state, block, Vector3::Zero());
  Matrix3 linear;
  for (int i = 0; i < 3; ++i)
    linear.col(i) = solver::local_point(state, block, Vector3::Unit(i)) - origin;
  const Vector3 arm = simulation.reference_arms(block).col(0);
  return {.linear = linear * start.linear,
          .translation = origin + linear * (arm - start.linear * shape.vertex(0))};
}

/// Of the two parts of a pair that are nearest to each other.
void update_pair_contact(const solver::Simulation& simulation, const JointedPair& pair,
                         geometry::PairContact& nearest) {
  const auto block = [&](int i) -> const solver::Block& {
    return simulation.scene().blocks[static_cast<std::size_t>(pair[static_cast<std::size_t>(i)])];
  };
  const geometry::Placement a = placement_now(simulation, pair[0]);
  const geometry::Placement b = placement_now(simulation, pair[1]);
  nearest = {};
  geometry::PairContact found;
  for (const geometry::Shape& part : block(0).convex_parts()) {
    for (const geometry::Shape& other : block(1).convex_parts()) {
      geometry::update_pair_contact(geometry::Body(part, a), geometry::Body(other, b), {}, found);
      if (nearest.points.empty() || found.nearest.gap < nearest.nearest.gap) nearest = found;
    }
  }
}

/// Sums over the contacts of one pair.
class Sum {
 public:
  explicit Sum(std::span<const Contact> contacts) : contacts_(contacts) {
    const auto [a, b] = pair_of(contacts[0]);
    joint_ = {
        .a = a, .b = b, .points = static_cast<int>(contacts.size()), .gap = contacts[0].point.gap};
  }

  JointSum joint() {
    Vector3 middle = Vector3::Zero(), mean = Vector3::Zero(), pressed = Vector3::Zero();
    for (const Contact& contact : contacts_) {
      const geometry::ContactPoint& point = contact.point;
      joint_.closed += contact.mode != solver::ContactMode::Open ? 1 : 0;
      joint_.gap = std::min(joint_.gap, point.gap);
      joint_.area += contact.area();
      joint_.force += force_on_b(contact);
      joint_.normal_force += contact.normal_force;
      middle += contact.area() * point.point();
      mean += point.point() / joint_.points;
      pressed += contact.normal_force * point.point();
    }
    joint_.normal = normal();
    middle = joint_.area > 0 ? Vector3(middle / joint_.area) : mean;
    for (const Contact& contact : contacts_)
      joint_.moment += (contact.point.point() - middle).cross(force_on_b(contact));
    joint_.centre = joint_.normal_force > 0 ? Vector3(pressed / joint_.normal_force) : middle;
    joint_.edge_stress = edge_stress().value_or(-1.0);
    return joint_;
  }

 private:
  static Vector3 force_on_b(const Contact& contact) {
    return contact.normal_force * contact.point.normal - contact.shear_force;
  }

  /// Of what bears, if anything does: open contacts of a joint that rocks look elsewhere.
  Vector3 normal() const {
    Vector3 bearing = Vector3::Zero(), all = Vector3::Zero();
    for (const Contact& contact : contacts_) {
      bearing += std::abs(contact.normal_force) * contact.point.normal;
      all += contact.point.normal;
    }
    return (bearing.norm() > 0 ? bearing : all).normalized();
  }

  std::optional<double> edge_stress() const {
    constexpr double kOnePlane = 0.999;  // cosine; parts of two blocks may meet in several planes
    const auto turned = [&](const Contact& contact) {
      return contact.point.normal.dot(joint_.normal) < kOnePlane;
    };
    if (!(joint_.area > 0) || std::ranges::any_of(contacts_, turned)) return {};
    const Vector3 x = joint_.normal.unitOrthogonal(), y = joint_.normal.cross(x);
    const auto flat = [&](const Vector3& point) {
      return Eigen::Vector2d(x.dot(point - joint_.centre), y.dot(point - joint_.centre));
    };
    std::vector<Eigen::Vector2d> corners;
    for (const Contact& contact : contacts_) corners.push_back(flat(contact.point.point()));
    return scene_file::no_tension_edge_stress(corners, {0, 0}, joint_.normal_force);
  }

  std::span<const Contact> contacts_;
  JointSum joint_;
};

}  // namespace

void append_joined(std::span<const Contact> contacts, std::vector<JointedPair>& pairs) {
  constexpr double kLaid = 1e-6;  // of the width of a point's area: head joints bear nothing
  const std::size_t before = pairs.size();
  for (const Contact& contact : contacts)
    if ((contact.mode != solver::ContactMode::Open ||
         contact.point.gap < kLaid * std::sqrt(contact.point.area)) &&
        (pairs.size() == before || pairs.back() != pair_of(contact)))
      pairs.push_back(pair_of(contact));
  std::ranges::inplace_merge(pairs, pairs.begin() + static_cast<std::ptrdiff_t>(before));
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
}

std::vector<Contact> parted_contacts(const solver::Simulation& simulation,
                                     std::span<const JointedPair> pairs,
                                     std::span<const Contact> contacts) {
  const std::vector<solver::Block>& blocks = simulation.scene().blocks;
  const auto absent = [&](int block) {
    return blocks[static_cast<std::size_t>(block)].kind == solver::BlockKind::Absent;
  };
  std::vector<Contact> parted;
  geometry::PairContact found;
  for (const JointedPair& pair : pairs) {
    const auto listed = std::ranges::lower_bound(contacts, pair, {}, pair_of);
    if (listed != contacts.end() && pair_of(*listed) == pair) continue;
    if (absent(pair[0]) || absent(pair[1])) continue;
    update_pair_contact(simulation, pair, found);
    for (geometry::ContactPoint& point : found.points) {
      point.key.a = pair[0];
      point.key.b = pair[1];
      parted.push_back({.point = point});
    }
  }
  return parted;
}

std::vector<JointSum> sums_by_joint(std::span<const Contact> contacts) {
  std::vector<JointSum> sums;
  for (std::size_t from = 0, to = 0; from < contacts.size(); from = to) {
    while (to < contacts.size() && pair_of(contacts[to]) == pair_of(contacts[from])) ++to;
    sums.push_back(Sum(contacts.subspan(from, to - from)).joint());
  }
  return sums;
}

}  // namespace quoin::commands
