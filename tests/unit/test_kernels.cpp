/// The kernels of all instruction sets that this machine can run give the bits of the plain ones.

#include "geometry/src/kernels/kernels.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <quoin/geometry/build.hpp>
#include <vector>

#include "support/bits.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin;
using geometry::Kernels;
using geometry::Shape;
using geometry::Solid;
using geometry::Vector3;

namespace {

/// What a kernel has answered.
struct Bits : quoin::tests::Bits {
  using quoin::tests::Bits::add;
  void add(const geometry::Support& top) {
    add(top.vertex);
    add(top.value);
  }
  template <class T, std::size_t kCount>
  void add(const std::array<T, kCount>& values) {
    for (const T& value : values) add(value);
  }
  void add(const geometry::SearchResult& found) {
    add(static_cast<int>(found.outcome));
    add(found.normal);
    add(found.bound);
    add(found.corners);
    add(found.iterations);
    add(found.p);
    add(found.q);
  }
  void add(const geometry::NearestFeatures& answer) {
    add(static_cast<int>(answer.status));
    add(static_cast<int>(answer.rule));
    add(answer.gap);
    add(answer.normal);
    add(answer.point_a);
    add(answer.point_b);
    add(answer.residual_a);
    add(answer.residual_b);
    add(answer.feature_a);
    add(answer.feature_b);
    add(answer.hint.vertices_a);
    add(answer.hint.vertices_b);
    add(answer.hint.face_a);
    add(answer.hint.face_b);
  }
  void add(const geometry::PolygonRows& rows) {
    for (int k = 0; k < rows.count; ++k) {
      for (const double value : {rows.x[k], rows.y[k], rows.height[k], rows.side_x[k],
                                 rows.side_y[k], rows.length[k], rows.low, rows.high}) {
        add(value);
      }
    }
  }
  void add(const geometry::SideMasks& masks, int count) {
    all.insert(all.end(), masks.inside, masks.inside + count);
    all.insert(all.end(), masks.outside, masks.outside + count);
    add(masks.margin);
  }
  void add(const geometry::ContactPolygon& part) {
    add(part.margin);
    add(part.polygon.area);
    add(part.lowest);
    add(part.highest);
    add(part.nearest_squared);
    for (const double x : {part.polygon.centroid.x(), part.polygon.centroid.y()}) add(x);
    for (const geometry::SharedCorner& corner : part.corners) {
      for (const double value :
           {corner.place.x(), corner.place.y(), corner.height_p, corner.height_q, corner.share}) {
        add(value);
      }
      add(corner.feature_p);
      add(corner.feature_q);
    }
  }
};

/// How many answers there were; all kernels have to agree.
int check_all(const std::function<int(const Kernels&, Bits&)>& ask) {
  Bits expected;
  const int count = ask(geometry::kPlainKernels, expected);
  for (const Kernels* kernels : geometry::runnable_kernels()) {
    INFO(kernels->name);
    Bits found;
    CHECK(ask(*kernels, found) == count);
    CHECK(found.all.size() == expected.all.size());
    const auto [here, there] =
        std::mismatch(found.all.begin(), found.all.end(), expected.all.begin(), expected.all.end());
    INFO("the first difference is number " << here - found.all.begin());
    CHECK(here == found.all.end());
  }
  return count;
}

Shape hull(tests::Random& random, int count) {
  geometry::Points points(3, count);
  for (int k = 0; k < count; ++k) points.col(k) = random.direction();
  return geometry::make_hull(points).polyhedron;
}

Shape brick(tests::Random& random) {
  const Vector3 half(random.uniform(0.2, 0.9), random.uniform(0.2, 0.9), random.uniform(0.2, 0.9));
  return geometry::make_box(-half, half);
}

/// Bodies about so far from each other, turned or not.
struct Bodies {
  geometry::Body a, b;
  geometry::PlacedPair pair;
  geometry::Lengths length;
  Bodies(tests::Random& random, const Shape& p, const Shape& q, double distance)
      : a(p, placement(random, random.point(-1, 1))),
        b(q, placement(random, a.placement().translation + distance * random.direction())),
        pair(a, b),
        length(geometry::lengths(pair.a, pair.b, 0.0)) {}

 private:
  static geometry::Placement placement(tests::Random& random, const Vector3& translation) {
    if (random.chance(0.3)) return {.translation = translation};
    return {.linear = random.rotation(), .translation = translation};
  }
};

constexpr int kCounts[] = {4, 6, 8, 9, 14, 16, 17, 24, 25, 32, 33, 40, 57, 64, 65, 72, 90, 130};

}  // namespace

TEST_CASE("kernels: scans") {
  tests::Random random(15);
  for (const int count : kCounts) {
    const Shape shape = count == 8 ? brick(random) : hull(random, count);
    const Bodies bodies(random, shape, shape, 1.0);
    for (int k = 0; k < 40; ++k) {
      // along an axis many vertices of a brick are equal
      const Vector3 d = k < 3 ? Vector3(Vector3::Unit(k)) : random.direction();
      const double depth = random.uniform(0.0, 0.6);
      check_all([&](const Kernels& kernels, Bits& bits) {
        const Solid& solid = bodies.pair.a;
        const geometry::Support top = kernels.support(solid, d);
        bits.add(top);
        geometry::VertexSet beyond;
        kernels.find_vertices_beyond(solid, d, top.value - depth, beyond);
        for (const int v : beyond) bits.add(v);
        bits.add(kernels.count_beyond(solid, d, top.value - depth));
        geometry::Support again;
        for (const double clear : {depth, 1.2 * depth}) {
          bits.add(int{kernels.carried_alone(solid, d, {beyond, depth, clear}, again)});
          bits.add(again);
        }
        return beyond.count();
      });
    }
  }
}

TEST_CASE("kernels: searches, and what certifies them") {
  tests::Random random(16);
  int proved = 0, overlapping = 0;
  for (int k = 0; k < 600; ++k) {
    const int count = kCounts[random.integer(0, std::ssize(kCounts) - 1)];
    const Shape p = k % 3 == 0 ? brick(random) : hull(random, count);
    const Shape q = k % 3 == 0 ? brick(random) : hull(random, random.integer(4, 40));
    const Bodies bodies(random, p, q, random.uniform(0.3, 3.0));
    const Solid &a = bodies.pair.a, &b = bodies.pair.b;
    const double rounding = bodies.length.rounding;
    proved += check_all([&](const Kernels& kernels, Bits& bits) {
      const geometry::SearchResult found =
          kernels.nearest_feature_search(a, b, b.vertex_mean() - a.vertex_mean(), rounding);
      bits.add(found);
      if (found.outcome != geometry::SearchOutcome::Separated) return 0;
      geometry::Carrier by_a, by_b;
      if (!geometry::corner_carrier(a, found.p, by_a)) return 0;
      if (!geometry::corner_carrier(b, found.q, by_b)) return 0;
      geometry::NearestFeatures cold, warm;
      const geometry::Trial trial = kernels.certify(a, b, by_a, by_b, bodies.length, nullptr, cold);
      bits.add(static_cast<int>(trial));
      if (trial != geometry::Trial::Proved) return 0;
      bits.add(cold);
      CHECK(kernels.certify_hint(a, b, cold.hint, bodies.length, warm) == trial);
      bits.add(warm);
      return 1;
    });
    overlapping += check_all([&](const Kernels& kernels, Bits& bits) {
      const geometry::SearchResult start =
          kernels.nearest_feature_search(a, b, b.vertex_mean() - a.vertex_mean(), rounding);
      if (start.outcome != geometry::SearchOutcome::Overlapping) return 0;
      bits.add(kernels.expand_polytope(a, b, start, rounding));
      return 1;
    });
    if (k % 3 != 0) continue;
    check_all([&](const Kernels& kernels, Bits& bits) {
      bits.add(kernels.box_sat(a, b, rounding));
      return 0;
    });
  }
  CHECK(proved > 100);
  CHECK(overlapping > 100);
}

namespace {

/// A prism of height 1 on the plane z = `low`; corners on a circle.
Shape prism(tests::Random& random, int corners, double low) {
  geometry::Points polygon(3, corners);
  const double first = random.uniform(0.0, 6.0), x = random.uniform(-0.7, 0.7);
  for (int k = 0; k < corners; ++k) {
    const double angle = first + 6.283185307179586 * (k + random.uniform(-0.3, 0.3)) / corners;
    polygon.col(k) = Vector3(x + std::cos(angle), std::sin(angle), low);
  }
  return geometry::make_prism(polygon, {0, 0, 1});
}

int face_towards(const Shape& solid, double sign) {
  int best = 0;
  for (int f = 1; f < solid.topology().face_count(); ++f) {
    if (sign * solid.face_normal(f).z() > sign * solid.face_normal(best).z()) best = f;
  }
  return best;
}

/// The vertices of a face as the corners of a polygon.
void name_corners(const Shape& solid, int face, geometry::PolygonRows& rows) {
  rows.count = 0;
  for (const int v : solid.topology().face(face)) rows.vertex[rows.count++] = v;
}

}  // namespace

TEST_CASE("kernels: faces on each other") {
  tests::Random random(17);
  int overlaid = 0;
  for (int k = 0; k < 300; ++k) {
    const int most = k < 200 ? 13 : 60;
    const Shape p = prism(random, k < 50 ? 4 : random.integer(3, most), -1.0),
                q = prism(random, k < 50 ? 4 : random.integer(3, most), 0.0);
    const int face_p = face_towards(p, 1.0), face_q = face_towards(q, -1.0);
    const geometry::ContactPlane plane(p.vertex(p.topology().face(face_p)[0]), {0, 0, 1});
    overlaid += check_all([&](const Kernels& kernels, Bits& bits) {
      geometry::PolygonRows rows_p, rows_q;
      name_corners(p, face_p, rows_p);
      name_corners(q, face_q, rows_q);
      kernels.lay_corners(p, plane, rows_p);
      kernels.lay_corners(q, plane, rows_q);
      bits.add(rows_p);
      bits.add(rows_q);
      geometry::SideMasks of_p, of_q;
      kernels.find_side_masks(rows_p, rows_q, 0.01, of_p, of_q);
      bits.add(of_p, rows_p.count);
      bits.add(of_q, rows_q.count);
      geometry::ContactPolygon part;
      part.face_p = face_p;
      part.face_q = face_q;
      part.plane = plane;
      if (!kernels.overlay_faces(p, q, 1e-12, part)) return 0;
      bits.add(part);
      return 1;
    });
  }
  CHECK(overlaid > 100);
}
