#include "referee/pairs/families.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <numeric>
#include <quoin/geometry/build.hpp>
#include <sstream>
#include <stdexcept>

namespace quoin::referee {
namespace {

using geometry::make_box;
using geometry::make_hull;
using geometry::Matrix3;
using geometry::Points;
using geometry::Shape;
using geometry::Vector3;

using std::numbers::pi;

// ---- shapes, each about the origin and about `size` large -----------------------------------

Shape box_shape(Random& random, double size) {
  const Vector3 half =
      0.5 * size * Vector3(random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1));
  return make_box(-half, half);
}

Points polygon(Random& random, int corners, double size) {
  Points points(3, corners);
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * pi * (i + random.uniform(0.1, 0.9)) / corners;
    points.col(i) = 0.5 * size * Vector3(std::cos(angle), std::sin(angle), 0);
  }
  return points;
}

Shape prism_shape(Random& random, double size) {
  const int corners = random.integer(3, 9);
  const Points base = polygon(random, corners, size);
  const double height = size * random.uniform(0.1, 1);
  const double lean = size * random.uniform(-0.3, 0.3);
  Points points(3, 2 * corners);
  points.leftCols(corners) = base.colwise() - Vector3(0, 0, 0.5 * height);
  points.rightCols(corners) = base.colwise() + Vector3(lean, 0, 0.5 * height);
  return make_hull(points).polyhedron;
}

Shape wedge_shape(Random& random, double size) {
  const double length = size * random.uniform(0.3, 1), half = 0.5 * size * random.uniform(0.2, 1);
  const double height = size * random.uniform(0.05, 1), cut = random.uniform(0, 0.8);
  Points points(3, 6);
  points << -half, half, -half, half, 0, 0,                                             //
      -length / 2, -length / 2, length / 2, length / 2, -cut * length / 2, length / 2,  //
      0, 0, 0, 0, -height, -height;
  return make_hull(points).polyhedron;
}

Shape tetrahedron_shape(Random& random, double size) {
  for (;;) {
    Points points(3, 4);
    for (int i = 0; i < 4; ++i) points.col(i) = 0.5 * size * random.point(-1, 1);
    const Vector3 e1 = points.col(1) - points.col(0), e2 = points.col(2) - points.col(0);
    const Vector3 e3 = points.col(3) - points.col(0);
    if (std::abs(e1.cross(e2).dot(e3)) > 1e-3 * size * size * size)
      return make_hull(points).polyhedron;
  }
}

Shape hull_shape(Random& random, double size, int count, bool cospherical) {
  const Vector3 axes(random.uniform(0.3, 1), random.uniform(0.3, 1), random.uniform(0.3, 1));
  Points points(3, count);
  for (int i = 0; i < count; ++i) {
    const double radius = cospherical ? 1.0 + 1e-10 * random.uniform() : random.uniform(0.6, 1);
    points.col(i) = 0.5 * size * radius * random.direction();
    if (!cospherical) points.col(i) = points.col(i).cwiseProduct(axes).eval();
  }
  return make_hull(points).polyhedron;
}

Shape sliver_shape(Random& random, double size) {
  const double thin = random.log_uniform(1e-5, 1e-3);
  switch (random.integer(0, 3)) {
    case 0:
      return make_box(-0.5 * size * Vector3(1, 1, thin), 0.5 * size * Vector3(1, 1, thin));
    case 1:
      return make_box(-0.5 * size * Vector3(1, thin, thin), 0.5 * size * Vector3(1, thin, thin));
    case 2: {
      Points points = polygon(random, 3, size);
      points.conservativeResize(3, 4);
      points.col(3) = Vector3(0, 0, thin * size);
      return make_hull(points).polyhedron;
    }
    default: {
      Points points = hull_shape(random, size, 12, false).vertices();
      points.row(2) *= thin;
      return make_hull(points).polyhedron;
    }
  }
}

Shape any_shape(Random& random, double size) {
  switch (random.integer(0, 5)) {
    case 0:
      return box_shape(random, size);
    case 1:
      return prism_shape(random, size);
    case 2:
      return wedge_shape(random, size);
    case 3:
      return tetrahedron_shape(random, size);
    default:
      return hull_shape(random, size, random.integer(4, 24), false);
  }
}

// ---- placing --------------------------------------------------------------------------------

Shape turned(const Shape& solid, Random& random) {
  return transformed(solid, 1.0, random.rotation(), Vector3::Zero());
}

/// Of either sign, often zero or tiny, at most `size`.
double random_gap(Random& random, double size) {
  if (random.chance(0.05)) return 0.0;
  const double gap = random.log_uniform(1e-12, 0.5) * size;
  return random.chance(0.5) ? gap : -gap;
}

/// B shifted so that along a random direction it is `gap` away from A.
SolidPair placed(const std::string& family, const Shape& a, const Shape& b, double gap,
                 Random& random) {
  const Vector3 n = random.direction();
  const double top = (n.transpose() * a.vertices()).maxCoeff();
  const double bottom = (n.transpose() * b.vertices()).minCoeff();
  const Vector3 aside = random.direction() * 0.2 * std::min(diameter(a), diameter(b));
  const Vector3 shift = (top - bottom + gap) * n + (aside - aside.dot(n) * n);
  return {family, a, transformed(b, 1.0, Matrix3::Identity(), shift)};
}

SolidPair nearby(const std::string& family, const Shape& a, const Shape& b, Random& random) {
  const double size = std::min(diameter(a), diameter(b));
  return placed(family, turned(a, random), turned(b, random), random_gap(random, size), random);
}

// ---- families -------------------------------------------------------------------------------

SolidPair boxes(Random& r) { return nearby("boxes", box_shape(r, 1), box_shape(r, 1), r); }
SolidPair prisms(Random& r) { return nearby("prisms", prism_shape(r, 1), prism_shape(r, 1), r); }
SolidPair wedges(Random& r) { return nearby("wedges", wedge_shape(r, 1), wedge_shape(r, 1), r); }
SolidPair tetrahedra(Random& r) {
  return nearby("tetrahedra", tetrahedron_shape(r, 1), tetrahedron_shape(r, 1), r);
}
SolidPair mixed(Random& r) {
  return nearby("mixed", any_shape(r, r.log_uniform(0.1, 10)), any_shape(r, 1), r);
}
SolidPair hulls(Random& r) {
  return nearby("hulls", hull_shape(r, 1, r.integer(4, 64), false),
                hull_shape(r, 1, r.integer(4, 64), false), r);
}
SolidPair large_hulls(Random& r) {
  return nearby("large_hulls", hull_shape(r, 1, 200, r.chance(0.5)),
                hull_shape(r, 1, r.integer(100, 200), r.chance(0.5)), r);
}

/// Two bricks of a wall: in running bond, stacked or offset anyhow, exact or ground away a little,
/// as laid or with the whole wall turned.
SolidPair masonry(Random& r) {
  const Vector3 size(0.25, 0.125, r.chance(0.5) ? 0.0625 : 0.065);
  const double joint = r.chance(0.4) ? 0.0 : random_gap(r, 1e-3);
  Vector3 shift(0.5 * size.x(), 0, size.z() + joint);
  switch (r.integer(0, 3)) {
    case 0:
      shift.x() = 0;
      break;
    case 1:
      shift.x() = r.uniform(-1, 1) * size.x();
      shift.y() = r.uniform(-1, 1) * size.y();
      break;
    case 2:
      shift = Vector3(size.x() + joint, r.chance(0.5) ? 0.0 : 0.5 * size.y(), 0);
      break;
    default:
      break;
  }
  const Vector3 corner = r.chance(0.5) ? Vector3::Zero() : r.point(0, 10);
  const Shape a = make_box(corner, corner + size);
  const Shape b = make_box(corner + shift, corner + shift + size);
  if (r.chance(0.5)) return {"masonry", a, b};
  const Matrix3 turn = r.rotation();
  return {"masonry", transformed(a, 1, turn, Vector3::Zero()),
          transformed(b, 1, turn, Vector3::Zero())};
}

SolidPair slivers(Random& r) {
  return nearby("slivers", sliver_shape(r, 1), r.chance(0.5) ? sliver_shape(r, 1) : any_shape(r, 1),
                r);
}

SolidPair tiny_and_huge(Random& r) {
  const Shape huge = turned(any_shape(r, r.log_uniform(1, 1e3)), r);
  const Shape tiny = turned(any_shape(r, r.log_uniform(1e-6, 1e-3)), r);
  if (r.chance(0.1))  // the tiny one stays near the origin: elsewhere it would be rounded away
    return placed("tiny_and_huge", tiny, huge, r.log_uniform(1, 1e9), r);
  const double gap = random_gap(r, diameter(tiny));
  return r.chance(0.5) ? placed("tiny_and_huge", huge, tiny, gap, r)
                       : placed("tiny_and_huge", tiny, huge, gap, r);
}

/// Stacked with facing faces, then tilted by next to nothing.
SolidPair nearly_parallel(Random& r) {
  const Shape a = r.chance(0.5) ? box_shape(r, 1) : prism_shape(r, 1);
  Shape b = r.chance(0.5) ? box_shape(r, 1) : prism_shape(r, 1);
  const Vector3 axis = r.direction();
  b = transformed(b, 1,
                  rotation_about(axis, r.log_uniform(1e-12, 1e-3)) *
                      rotation_about(Vector3::UnitZ(), r.chance(0.5) ? r.uniform(0, 7) : 0.0),
                  Vector3::Zero());
  const double lift = a.box().max.z() - b.box().min.z() + random_gap(r, 1e-2);
  b = transformed(b, 1, Matrix3::Identity(), {r.uniform(-0.3, 0.3), r.uniform(-0.3, 0.3), lift});
  if (r.chance(0.5)) return {"nearly_parallel", a, b};
  const Matrix3 turn = r.rotation();
  return {"nearly_parallel", transformed(a, 1, turn, Vector3::Zero()),
          transformed(b, 1, turn, Vector3::Zero())};
}

/// Coordinates on a coarse grid: all kinds of exact touch and exact parallelism.
SolidPair on_the_grid(Random& r) {
  const auto solid = [&] {
    for (;;) {
      Points points(3, r.integer(4, 10));
      for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = 0.25 * r.integer(-3, 3);
      try {
        return make_hull(points).polyhedron;
      } catch (const geometry::InputError&) {
      }
    }
  };
  const Shape a = solid(), b = solid();
  const Vector3 shift(0.25 * r.integer(-6, 6), 0.25 * r.integer(-6, 6), 0.25 * r.integer(-6, 6));
  return {"on_the_grid", a, transformed(b, 1, Matrix3::Identity(), shift)};
}

SolidPair identical(Random& r) {
  const Shape a = turned(any_shape(r, 1), r);
  return {"identical", a, a};
}

SolidPair concentric(Random& r) {
  const Shape a = any_shape(r, 1), b = any_shape(r, r.uniform(0.1, 1));
  return {"concentric", a, r.chance(0.5) ? b : turned(b, r)};
}

SolidPair contained(Random& r) {
  const Shape a = turned(any_shape(r, 1), r);
  const Shape b = turned(any_shape(r, r.log_uniform(1e-6, 0.1)), r);
  return {"contained", a, transformed(b, 1, Matrix3::Identity(), 0.05 * r.direction())};
}

SolidPair far_away(Random& r) {
  SolidPair pair = make_pair(r.integer(0, 5), r);
  const Vector3 shift = r.log_uniform(1e3, 1e8) * r.direction();
  return {"far_away", transformed(pair.a, Matrix3::Identity(), shift),
          transformed(pair.b, Matrix3::Identity(), shift)};
}

const Family kOrdinaryFamilies[] = {{"boxes", boxes, 100},
                                    {"prisms", prisms, 60},
                                    {"wedges", wedges, 60},
                                    {"tetrahedra", tetrahedra, 60},
                                    {"mixed", mixed, 100},
                                    {"hulls", hulls, 20},
                                    {"masonry", masonry, 120},
                                    {"slivers", slivers, 80},
                                    {"tiny_and_huge", tiny_and_huge, 80},
                                    {"nearly_parallel", nearly_parallel, 80},
                                    {"on_the_grid", on_the_grid, 100},
                                    {"identical", identical, 20},
                                    {"concentric", concentric, 30},
                                    {"contained", contained, 30},
                                    {"far_away", far_away, 60},
                                    {"large_hulls", large_hulls, 1}};

}  // namespace

std::span<const Family> families() {
  static const std::vector<Family> list = [] {
    std::vector<Family> all(std::begin(kOrdinaryFamilies), std::end(kOrdinaryFamilies));
    all.insert(all.end(), hard_families().begin(), hard_families().end());
    return all;
  }();
  return list;
}

const std::vector<std::string>& family_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Family& family : families()) list.emplace_back(family.name);
    return list;
  }();
  return names;
}

SolidPair make_pair(int family, Random& random) {
  const Family& drawn = families()[static_cast<std::size_t>(family)];
  SolidPair pair = drawn.make(random);
  pair.family = drawn.name;
  return pair;
}

SolidPair make_pair(Random& random, const std::vector<bool>& wanted) {
  const auto weight = [&](std::size_t i) {
    return wanted.empty() || wanted[i] ? families()[i].weight : 0;
  };
  int total = 0;
  for (std::size_t i = 0; i < families().size(); ++i) total += weight(i);
  int ticket = random.integer(0, total - 1);
  std::size_t family = 0;
  while (ticket >= weight(family)) ticket -= weight(family++);
  return make_pair(static_cast<int>(family), random);
}

}  // namespace quoin::referee
