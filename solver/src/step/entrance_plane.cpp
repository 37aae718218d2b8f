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
struct Posed {
  const BlockModel& model;
  Pose pose;
  Matrix3 linear = placement(model, pose).linear;
};

Posed posed(const CompiledScene& compiled, std::span<const BlockState> state, int block) {
  return {compiled.models[index(block)], pose(state[index(block)])};
}

/// Outward, unit: the matrix of cofactors turns area vectors.
Vector3 face_normal(const Posed& owner, int face) {
  const Vector3 own = owner.model.shape->face_normal(face);
  return (owner.linear.inverse().transpose() * own).normalized();
}

/// Distance of the other block before the face's plane, negative where it is behind, m.
double separation(const Posed& owner, int face, const Posed& other) {
  const Vector3 normal = face_normal(owner, face);
  const geometry::Shape& shape = *owner.model.shape;
  const Vector3 here = owner.linear.transpose() * normal;
  double plane = -std::numeric_limits<double>::infinity();
  for (const int v : shape.topology().face(face)) {
    plane = std::max(plane, here.dot(shape.vertex(v)));
  }
  const Vector3 there = other.linear.transpose() * normal;
  const double nearest = (there.transpose() * other.model.shape->vertices()).minCoeff();
  return normal.dot(between(owner.pose, other.pose)) + (nearest - plane);
}

/// The block as it stands at the end of the step if it keeps its velocities.
BlockState moved_on(const BlockState& block, double time_step) {
  return displaced(block, time_step * velocity_vector(block));
}

void append_planes(const Posed& owner, const Posed& other, const std::array<int, 2>& names,
                   double limit, std::vector<FacePlane>& planes) {
  for (int f = 0; f < owner.model.shape->topology().face_count(); ++f) {
    if (separation(owner, f, other) >= -limit) planes.push_back({names[0], names[1], f});
  }
}

/// The plane that is least violated says how far apart the two are.
template <typename PosedOf>
double largest_separation(const std::vector<FacePlane>& planes, const PosedOf& block) {
  double largest = -std::numeric_limits<double>::infinity();
  for (const FacePlane& p : planes) {
    largest = std::max(largest, separation(block(p.block), p.face, block(p.other)));
  }
  return largest;
}

/// Cosine of the angle, 1e-3 rad, within which two planes are one.
constexpr double kSamePlane = 1.0 - 5e-7;

/// Of a pair that touches nowhere: can its contacts close in the step, and does a plane other than
/// theirs keep the two as far apart then? `planes`: all that keep them apart now. A contact can
/// close if the motion that the blocks have were twice as fast, or by gravity from rest.
bool passes(const SubStep& step, double limit, std::span<const BodyContact> contacts,
            const std::vector<FacePlane>& planes) {
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
    return std::abs(face.dot(normal)) > kSamePlane;
  });
  if (others.empty()) return false;
  const Posed end_a{step.compiled.models[index(a)], pose(next_a)};
  const Posed end_b{step.compiled.models[index(b)], pose(next_b)};
  const auto end = [&](int block) -> const Posed& { return block == a ? end_a : end_b; };
  return largest_separation(others, end) >= std::min(closes_by + limit, -limit);
}

constexpr std::size_t kPlanes = 32;  // more than two bricks have

bool of_pair(const BodyContact& contact, const PassingPair& pair) {
  return contact.a == pair.a && contact.b == pair.b;
}

}  // namespace

void set_aside_passing(const SubStep& step, double limit, std::vector<BodyContact>& contacts,
                       std::vector<PassingPair>& aside) {
  std::size_t kept = 0;
  std::vector<FacePlane> planes;  // one list for all pairs: most of them are not set aside
  for (std::size_t from = 0, to = 0; from < contacts.size(); from = to) {
    const auto same = [&](std::size_t i) {
      return contacts[i].a == contacts[from].a && contacts[i].b == contacts[from].b;
    };
    while (to < contacts.size() && same(to)) ++to;
    const std::span<const BodyContact> pair(&contacts[from], to - from);
    const int a = contacts[from].a, b = contacts[from].b;
    planes.clear();
    if (std::ranges::none_of(pair, &BodyContact::was_closed)) {
      const Posed posed_a = posed(step.compiled, step.state, a);
      const Posed posed_b = posed(step.compiled, step.state, b);
      planes.reserve(kPlanes);
      append_planes(posed_a, posed_b, {a, b}, limit, planes);
      append_planes(posed_b, posed_a, {b, a}, limit, planes);
    }
    if (planes.size() > 1 && passes(step, limit, pair, planes)) {
      aside.push_back({a, b, planes, {pair.begin(), pair.end()}});
      continue;
    }
    for (std::size_t i = from; i < to; ++i, ++kept) {
      if (kept != i) contacts[kept] = contacts[i];
    }
  }
  contacts.resize(kept);
}

bool put_back_blocked(const CompiledScene& compiled, std::span<const BlockState> end,
                      std::span<const geometry::ContactPoint> found_end, double limit,
                      std::vector<PassingPair>& pairs, std::vector<BodyContact>& contacts) {
  const auto at_end = [&](int block) { return posed(compiled, end, block); };
  const auto blocked = [&](const PassingPair& pair) {
    double gap = 0.0;
    for (const geometry::ContactPoint& point : points_of_pair(found_end, pair.a, pair.b)) {
      gap = std::min(gap, point.gap);
    }
    const double apart = largest_separation(pair.planes, at_end);
    if (gap < -limit) return apart < gap - limit;
    // So far behind every plane that has kept them apart they have gone through each other.
    return apart < -kFarthest * pair_size(compiled, pair.a, pair.b);
  };
  const auto first = std::stable_partition(pairs.begin(), pairs.end(),
                                           [&](const PassingPair& pair) { return !blocked(pair); });
  const bool any = first != pairs.end();
  for (auto pair = first; pair != pairs.end(); ++pair) {
    std::erase_if(contacts, [&](const BodyContact& c) { return of_pair(c, *pair); });
    contacts.insert(contacts.end(), pair->contacts.begin(), pair->contacts.end());
  }
  pairs.erase(first, pairs.end());
  return any;
}

}  // namespace quoin::solver
