#include "step/entrance_plane.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/index.hpp"
#include "step/contact_search.hpp"
#include "step/sorted_by_key.hpp"

namespace quoin::solver {
namespace {

/// A block and where it stands.
struct PosedBlock {
  const BlockModel& model;
  Pose pose;
  Matrix3 linear = placement(model, pose).linear;
};

PosedBlock posed(const CompiledScene& compiled, std::span<const BlockState> state, int block) {
  return {compiled.models[index(block)], pose(state[index(block)])};
}

/// Outward, unit: the matrix of cofactors turns area vectors.
Vector3 face_normal(const PosedBlock& owner, int face) {
  const Vector3 own = owner.model.shape->face_normal(face);
  return (owner.linear.inverse().transpose() * own).normalized();
}

/// Distance of a part of the other block before the face's plane, negative where it is behind, m.
double separation(const PosedBlock& owner, int face, const PosedBlock& other, int part) {
  const Vector3 normal = face_normal(owner, face);
  const geometry::Shape& shape = *owner.model.shape;
  const Vector3 here = owner.linear.transpose() * normal;
  double plane = -std::numeric_limits<double>::infinity();
  for (const int v : shape.topology().face(face))
    plane = std::max(plane, here.dot(shape.vertex(v)));
  const Vector3 there = other.linear.transpose() * normal;
  const auto [first, end] = vertices_of(other.model, part);
  const double nearest =
      (there.transpose() * other.model.shape->vertices().middleCols(first, end - first)).minCoeff();
  return normal.dot(between(owner.pose, other.pose)) + (nearest - plane);
}

/// The block as it stands at the end of the step if it keeps its velocities.
BlockState moved_on(const BlockState& block, double time_step) {
  return displaced(block, time_step * velocity_vector(block));
}

struct PosedPart {
  int block, part;
  PosedBlock posed;
};

/// `limit`: how far behind a face's plane the two may be, m.
void append_planes(const PosedPart& owner, const PosedPart& other, double limit,
                   std::vector<FacePlane>& planes) {
  const auto [first, end] = faces_of(owner.posed.model, owner.part);
  for (int f = first; f < end; ++f)
    if (separation(owner.posed, f, other.posed, other.part) >= -limit)
      planes.push_back({owner.block, other.block, other.part, f});
}

/// The plane that is least violated says how far apart the two are.
template <typename PosedOf>
double largest_separation(const std::vector<FacePlane>& planes, const PosedOf& block) {
  double largest = -std::numeric_limits<double>::infinity();
  for (const FacePlane& p : planes)
    largest = std::max(largest, separation(block(p.block), p.face, block(p.other), p.other_part));
  return largest;
}

// Cosine of the angle from that of its contacts up to which a plane is none that the pair passes:
// 1e-3 rad; of a pair that touches 60 degrees, as the side of a support and its top.
constexpr double kSamePlane = 1.0 - 5e-7, kAcross = 0.5;

/// Of a pair that touches nowhere: can its contacts close in the step, and does a plane other than
/// theirs keep the two as far apart then? `planes`: all that keep them apart now. A contact can
/// close if the motion that the blocks have were twice as fast, or by gravity from rest. `alike`:
/// cosine from which on a plane is that of the contacts. `swing`: of springs, m; blocks that swing
/// on them come on by as much again.
bool passes(const SubStep& step, double limit, double swing, double alike,
            std::span<const BodyContact> contacts, const std::vector<FacePlane>& planes) {
  const int a = contacts.front().a, b = contacts.front().b;
  const BlockState next_a = moved_on(step.state[index(a)], step.length);
  const BlockState next_b = moved_on(step.state[index(b)], step.length);
  const double fall = step.compiled.scene.gravity.at(step.time).norm() * step.length * step.length;
  double closes_by = 0.0;
  bool closes = false;
  for (const BodyContact& contact : contacts) {
    const double gap = contact_geometry(contact, pose(next_a), pose(next_b)).gap;
    closes = closes || gap < contact.state.point.gap - gap + fall + limit;
    closes_by = std::min(closes_by, gap);
  }
  if (!closes) return false;
  const Vector3 normal = contacts.front().state.point.normal;
  std::vector<FacePlane> others = planes;
  std::erase_if(others, [&](const FacePlane& p) {
    const Vector3 face = face_normal(posed(step.compiled, step.state, p.block), p.face);
    return std::abs(face.dot(normal)) > alike;
  });
  if (others.empty()) return false;
  const PosedBlock end_a{step.compiled.models[index(a)], pose(next_a)};
  const PosedBlock end_b{step.compiled.models[index(b)], pose(next_b)};
  const auto end = [&](int block) -> const PosedBlock& { return block == a ? end_a : end_b; };
  return largest_separation(others, end) >= std::min(closes_by + limit, -limit - swing);
}

constexpr std::size_t kPlanes = 32;  // more than two bricks have

bool has_spring(const SubStep& step, const BodyContact& contact) {
  return step.options.method == ContactMethod::Springs || contact.state.spring_area > 0.0;
}

/// How far springs have let blocks with unknowns sink into others.
class SunkBlocks {
 public:
  SunkBlocks(const SubStep& step, std::span<const BodyContact> contacts) {
    for (const BodyContact& contact : contacts) {
      const double gap = contact.state.point.gap;
      if (!contact.was_closed || !(gap < 0.0) || !has_spring(step, contact)) continue;
      for (const int block : {contact.a, contact.b})
        if (step.slot_of_block[index(block)] >= 0) sunk_.push_back({block, -gap});
    }
    std::ranges::sort(sunk_, {}, &Sunk::block);
  }
  /// Twice the deepest of a block, m: a load set on springs at once sinks twice as deep as at rest.
  double swing(int block) const {
    double deepest = 0.0;
    for (const Sunk& of : std::ranges::equal_range(sunk_, block, {}, &Sunk::block))
      deepest = std::max(deepest, of.depth);
    return 2.0 * deepest;
  }

 private:
  struct Sunk {
    int block;
    double depth;  // m
  };
  std::vector<Sunk> sunk_;  // by block
};

/// Whether a pair may touch as a block on springs that stands at the border of its support touches
/// the side of the next.
bool touches_border(const SubStep& step, std::span<const BodyContact> pair) {
  return std::ranges::all_of(pair, [&](const BodyContact& contact) {
    return !contact.state.bonded && has_spring(step, contact);
  });
}

/// Least gap of a joint's contacts among these points, sorted by key; 0 where none is negative, m.
double least_gap(const CompiledScene& compiled, const BodyContact& contact,
                 std::span<const geometry::ContactPoint> points) {
  double gap = 0.0;
  for (const geometry::ContactPoint& point : points_of_pair(points, contact.a, contact.b))
    if (part_of(compiled.models[index(contact.a)], point.key.feature_a) == contact.part_a &&
        part_of(compiled.models[index(contact.b)], point.key.feature_b) == contact.part_b)
      gap = std::min(gap, point.gap);
  return gap;
}

}  // namespace

void set_aside_passing(const SubStep& step, double limit, std::vector<BodyContact>& contacts,
                       std::vector<PassingPair>& aside) {
  std::size_t kept = 0;
  std::vector<FacePlane> planes;  // one list for all pairs: most of them are not set aside
  const SunkBlocks sunk(step, contacts);
  for (std::size_t from = 0, to = 0; from < contacts.size(); from = to) {
    while (to < contacts.size() && same_joint(contacts[to], contacts[from])) ++to;
    const std::span<const BodyContact> pair(&contacts[from], to - from);
    const BodyContact& c = pair.front();
    const double deepest = std::max(sunk.swing(c.a), sunk.swing(c.b)), most = limit + deepest;
    const bool touches = std::ranges::any_of(pair, &BodyContact::was_closed);
    planes.clear();
    if (!touches || touches_border(step, pair)) {
      const PosedPart a{c.a, c.part_a, posed(step.compiled, step.state, c.a)};
      const PosedPart b{c.b, c.part_b, posed(step.compiled, step.state, c.b)};
      planes.reserve(kPlanes);
      append_planes(a, b, most, planes);
      append_planes(b, a, most, planes);
    }
    if (!planes.empty() &&
        passes(step, most, deepest, touches ? kAcross : kSamePlane, pair, planes)) {
      aside.push_back({planes, {pair.begin(), pair.end()}, most});
      continue;
    }
    for (std::size_t i = from; i < to; ++i, ++kept)
      if (kept != i) contacts[kept] = contacts[i];
  }
  contacts.resize(kept);
}

double passing_limit(std::span<const PassingPair> pairs, int a, int b) {
  double limit = 0.0;
  for (const PassingPair& pair : pairs) {
    const BodyContact& contact = pair.contacts.front();
    if (contact.a == a && contact.b == b) limit = std::max(limit, pair.limit);
  }
  return limit;
}

bool put_back_blocked(const CompiledScene& compiled, std::span<const BlockState> end,
                      std::span<const geometry::ContactPoint> found_end,
                      std::vector<PassingPair>& pairs, std::vector<BodyContact>& contacts) {
  const auto at_end = [&](int block) { return posed(compiled, end, block); };
  const auto blocked = [&](const PassingPair& pair) {
    const BodyContact& contact = pair.contacts.front();
    const double gap = least_gap(compiled, contact, found_end);
    const double apart = largest_separation(pair.planes, at_end);
    if (gap < -pair.limit) return apart < gap - pair.limit;
    // So far behind every plane that has kept them apart they have gone through each other.
    return apart < -kFarthest * pair_size(compiled, contact.a, contact.b);
  };
  const auto first = std::stable_partition(pairs.begin(), pairs.end(),
                                           [&](const PassingPair& pair) { return !blocked(pair); });
  const bool any = first != pairs.end();
  for (auto pair = first; pair != pairs.end(); ++pair) {
    std::erase_if(contacts,
                  [&](const BodyContact& c) { return same_joint(c, pair->contacts.front()); });
    contacts.insert(contacts.end(), pair->contacts.begin(), pair->contacts.end());
  }
  pairs.erase(first, pairs.end());
  return any;
}

}  // namespace quoin::solver
