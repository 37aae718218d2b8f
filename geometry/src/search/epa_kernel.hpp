#pragma once
/// The polytope of expand_polytope, as a kernel. See kernels/kernels.hpp. Internal.

#include "search/nearest_feature_search.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "numeric/double_double.hpp"
#include "numeric/error_bounds.hpp"
#include "shape/scan.hpp"

namespace quoin::geometry {
namespace {

/// A polytope inside the set of differences, around the origin. While all its facets turn to the
/// origin their inner sides, each ray from the origin meets one of them; so the least distance of a
/// facet is a depth that the solids have at least. See geometry/README.md, "Least overlap".
/// Facets are triangles, counter-clockwise seen from outside, their planes rows of numbers.
class Polytope {
 public:
  Polytope(const Solid& p, const Solid& q, double rounding) : p_(p), q_(q), rounding_(rounding) {}

  SearchResult grow(const SearchResult& start) {
    SearchResult result = start;
    result.outcome = SearchOutcome::Unclear;
    result.iterations = 0;
    if (!begin(start)) return result;
    for (Index k = 0; k < 4; ++k) put(k, kSides[0][k], kSides[1][k], kSides[2][k]);
    store(four(kNone), least_);
    if (add_facets(4)) expand(result);
    return result;
  }

 private:
  using Index = std::size_t;     // of a corner or a facet
  using Number = std::uint16_t;  // the same, stored
  using Bits = std::uint64_t;
  static constexpr int kMostSteps = 88;
  static constexpr Index kMostCorners = kMostSteps + 8, kRow = 128;
  static constexpr Index kMostFacets = 1024;  // a power of two

  struct Corner {
    Vector3 w;
    int p = 0, q = 0;
  };
  /// Planes of four facets.
  struct alignas(64) Planes {
    double x[4], y[4], z[4];  // normals, unit
    double distance[4];       // from the origin, m; infinite: no facet, or one that is no more
    double sure[4];           // the same less its rounding
    double key[4];            // the same with the facet's number as its last bits; `kNone`
  };

  /// Four triangles: their apexes and from there to the two other corners, each with how far that
  /// corner is from the origin; the product of the two, outward.
  struct Triangles {
    Four apex[4], from[4], to[4];
    FourVectors normal;
    Triangles(const double (*corners)[4], const Number* a, const Number* b, const Number* c) {
      turn(corners, c, apex);
      turn(corners, a, from);
      turn(corners, b, to);
      for (int k = 0; k < 3; ++k) {
        from[k] = from[k] - apex[k];
        to[k] = to[k] - apex[k];
      }
      normal = cross(FourVectors{from[0], from[1], from[2]}, FourVectors{to[0], to[1], to[2]});
    }
  };
  /// The sides of a tetrahedron.
  static constexpr Number kSides[3][4] = {{0, 1, 2, 0}, {1, 0, 1, 2}, {2, 3, 3, 3}};

  static Number number(Index i) { return static_cast<Number>(i); }
  Planes& planes(Index f) { return planes_[f / 4]; }
  bool slim(Index f) const { return (slim_[f / 4] >> f % 4 & 1) != 0; }
  Vector3 place(Index c) const { return {corner_[c][0], corner_[c][1], corner_[c][2]}; }
  Vector3 normal(Index f) { return {planes(f).x[f % 4], planes(f).y[f % 4], planes(f).z[f % 4]}; }
  double gain(Index f, const Corner& corner) { return normal(f).dot(corner.w - place(apex_[f])); }
  /// The facet whose side runs from one corner to another.
  Number& facet_at(Index from, Index to) { return facet_at_[kRow * from + to]; }

  Corner corner_of(int i, int j) const { return {q_.vertex(j) - p_.vertex(i), i, j}; }

  Corner find_corner(const Vector3& direction) const {
    const PairSupport both = Scan::support_pair(Rows(p_), Rows(q_), direction);
    return corner_of(both.p.vertex, both.q.vertex);
  }

  Index add_corner(const Corner& corner) {
    const Index c = corner_count_++;
    store(Four{corner.w.x(), corner.w.y(), corner.w.z(), corner.w.norm()}, corner_[c]);
    vertex_p_[c] = corner.p;
    vertex_q_[c] = corner.q;
    return c;
  }

  /// Four corners around the origin, from the search and, where it ended with fewer, from supports
  /// across them. Outside is where 0, 1, 2 turn left.
  bool begin(const SearchResult& start) {
    for (Index k = 0; k < static_cast<Index>(start.corners); ++k)
      add_corner(corner_of(start.p[k], start.q[k]));
    while (corner_count_ < 4)
      if (!add_across()) return false;
    const Vector3 a = place(1) - place(0), b = place(2) - place(0), c = place(3) - place(0);
    if (a.cross(b).dot(c) > 0.0) swap_corners(0, 1);
    return true;
  }

  /// Steps until the nearest facet is one of the set of differences, or rounding has torn the
  /// surface.
  void expand(SearchResult& result) {
    while (result.iterations < kMostSteps) {
      ++result.iterations;
      const Index nearest = nearest_facet();
      if (nearest == kMostFacets) return;
      const Corner corner = find_corner(-normal(nearest));
      if (!(gain(nearest, corner) > rounding_)) return finish(nearest, result);
      if (!open(nearest, corner.w, add_corner(corner)) || !add_facets(sides_)) return;
    }
  }

  void swap_corners(Index c, Index d) {
    std::swap(corner_[c], corner_[d]);
    std::swap(vertex_p_[c], vertex_p_[d]);
    std::swap(vertex_q_[c], vertex_q_[d]);
  }

  bool add_across() {
    Vector3 direction;
    if (corner_count_ == 3) {
      direction = (place(1) - place(0)).cross(place(2) - place(0));
    } else {
      const Vector3 line = corner_count_ == 2 ? Vector3(place(1) - place(0))
                                              : Vector3(q_.vertex_mean() - p_.vertex_mean());
      int axis = 0;
      line.cwiseAbs().minCoeff(&axis);
      direction = line.cross(Vector3::Unit(axis));
    }
    Corner best{Vector3::Zero(), 0, 0};
    double farthest = 0.0;
    for (const double side : {1.0, -1.0}) {
      const Corner corner = find_corner(side * direction);
      const double reach = std::abs(direction.dot(corner.w - place(0)));
      if (reach > farthest) {
        farthest = reach;
        best = corner;
      }
    }
    if (!(farthest > rounding_ * direction.norm())) return false;
    add_corner(best);
    return true;
  }

  /// The corners of a facet.
  void put(Index f, Index from, Index to, Index apex) {
    from_[f] = number(from);
    to_[f] = number(to);
    apex_[f] = number(apex);
  }

  /// New facets whose corners have been put. False: one turns its outer side to the origin.
  bool add_facets(Index count) {
    const Index first = facet_count_, end = first + count;
    const Index c = apex_[first];
    for (Index f = end; f < end + 3; ++f) put(f, c, c, c);
    bool around = true;
    for (Index f = first; f < end; f += 4) around &= lay_four(f);
    for (Index f = first; f < end; ++f) {
      const Index from = from_[f], to = to_[f], apex = apex_[f];
      facet_at(from, to) = facet_at(to, apex) = facet_at(apex, from) = number(f);
    }
    facet_count_ = first + (count + 3) / 4 * 4;
    return around;
  }

  /// The planes of a block. False: one turns its outer side to the origin.
  bool lay_four(Index f) {
    const Triangles t(corner_, from_ + f, to_ + f, apex_ + f);
    const FourVectors a{t.apex[0], t.apex[1], t.apex[2]}, u{t.from[0], t.from[1], t.from[2]},
        v{t.to[0], t.to[1], t.to[2]};
    const Four reach = larger(larger(t.from[3], t.to[3]), t.apex[3]);
    const Four squared = dot(t.normal, t.normal), whole = dot(u, u) * dot(v, v);
    const Four inverse = four(1.0) / root(squared);
    const Four distance = dot(t.normal, a) * inverse;
    // By how much the products that made the normal have cancelled: at most 1 + a quarter of this.
    const Four cancelled = whole * (inverse * inverse);
    const Four sure = distance - four(kEpsilon) * reach *
                                     (four(kFacetRounding) + four(kFacetCancelled) * cancelled);
    const FourFlags there = four(kNoArea * kNoArea) * whole < squared;
    const unsigned slim = bits(squared < four(kSlim * kSlim) * whole);
    Planes& planes_of = planes(f);
    const FourVectors unit = t.normal * inverse;
    store(unit.x, planes_of.x);
    store(unit.y, planes_of.y);
    store(unit.z, planes_of.z);
    store(either(there, distance, four(kInfinity)), planes_of.distance);
    store(sure, planes_of.sure);
    const Four key = either(there, numbered(sure, f, kMostFacets), four(kNone));
    store(key, planes_of.key);
    store(smaller(key, load(least_)), least_);
    slim_[f / 4] = static_cast<std::uint8_t>(slim);
    return (bits(there) & ~slim & bits(distance < four(-rounding_))) == 0;
  }

  /// The plane of a slim facet from exact differences.
  void lay_exactly(Index f) {
    slim_[f / 4] = static_cast<std::uint8_t>(slim_[f / 4] & ~(1 << f % 4));
    const std::array<Index, 3> corners{from_[f], to_[f], apex_[f]};
    std::array<WideVector, 3> w;
    double reach = 0.0;
    for (Index k = 0; k < 3; ++k) {
      const Index c = corners[k];
      w[k] = exact_corner(p_, q_, vertex_p_[c], vertex_q_[c]);
      reach = std::max(reach, corner_[c][3]);
    }
    const Vector3 across = cross(w[1] - w[0], w[2] - w[0]).rounded();
    const double area = across.norm();
    Planes& four = planes(f);
    const Index k = f % 4;
    four.distance[k] = kInfinity;
    four.key[k] = kNone;
    if (!(area > 0.0)) return;
    const Vector3 unit = across / area;
    four.x[k] = unit.x();
    four.y[k] = unit.y();
    four.z[k] = unit.z();
    four.distance[k] = unit.dot(place(apex_[f]));
    four.sure[k] = four.distance[k] - kFacetRounding * kEpsilon * reach;
    four.key[k] = numbered(load(four.sure), f - k, kMostFacets)[k];
  }

  /// The facet nearest to the origin, or `kMostFacets` where one turns its outer side to it.
  Index nearest_facet() {
    Index nearest = least_facet();
    while (nearest < kMostFacets && slim(nearest)) {  // only now is it worth its exact normal
      lay_exactly(nearest);
      find_least();
      if (planes(nearest).distance[nearest % 4] < -rounding_) return kMostFacets;
      nearest = least_facet();
    }
    return nearest;
  }

  Index least_facet() const {
    const double key = least(load(least_));
    return key < kNone ? std::bit_cast<Bits>(key) % kMostFacets : kMostFacets;
  }

  void find_least() {
    Four least = four(kNone);
    for (Index f = 0; f < facet_count_; f += 4) least = smaller(least, load(planes(f).key));
    store(least, least_);
  }

  /// The normals of four facets along a vector.
  static Four along(const Planes& of, const Vector3& v) {
    return dot(FourVectors{load(of.x), load(of.y), load(of.z)},
               FourVectors{four(v.x()), four(v.y()), four(v.z())});
  }

  /// Which of four facets see a corner; these are no more.
  static unsigned take_seeing(const Vector3& w, Planes& of, Four& least) {
    const Four distance = load(of.distance);
    const FourFlags seeing = distance < along(of, w);
    store(either(seeing, four(kInfinity), distance), of.distance);
    const Four key = either(seeing, four(kNone), load(of.key));
    store(key, of.key);
    least = smaller(least, key);
    return bits(seeing);
  }

  /// Takes away the facets that see a new corner, the first one in any case. The sides around the
  /// hole become the first sides of new facets. False: there are too many.
  bool open(Index first, const Vector3& w, Index apex) {
    planes(first).distance[first % 4] = -kInfinity;
    Bits seeing[kMostFacets / 64];
    Four least = four(kNone);
    Index count = 0;
    for (Index f = 0; f < facet_count_; f += 64) {
      Bits bits = 0;
      const Index end = std::min<Index>(facet_count_ - f, 64);
      for (Index k = 0; k < end; k += 4) bits |= Bits{take_seeing(w, planes(f + k), least)} << k;
      seeing[f / 64] = bits;
      count += static_cast<Index>(std::popcount(bits));
    }
    store(least, least_);
    if (facet_count_ + 3 * count + 4 > kMostFacets) return false;
    Index end = facet_count_;
    Bits starts = 0;
    for (Index f = 0; f < facet_count_; f += 64) {
      for (Bits left = seeing[f / 64]; left != 0; left &= left - 1) {
        const Index taken = f + static_cast<Index>(std::countr_zero(left));
        const Index a = from_[taken], b = to_[taken], c = apex_[taken];
        for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
          const Index across = facet_at(to, from);
          const Bits beyond = ~seeing[across / 64] >> across % 64 & 1;
          put(end, from, to, apex);
          starts |= beyond << from % 64;
          end += beyond;
        }
      }
    }
    sides_ = end - facet_count_;
    return sides_ >= 3 && static_cast<Index>(std::popcount(starts)) == sides_;
  }

  void finish(Index nearest, SearchResult& result) {
    const double distance = planes(nearest).distance[nearest % 4];
    const double limit = distance + std::max(kAsNear * rounding_, kRounded * distance);
    int near = 0;
    for (Index f = 0; f < facet_count_; f += 4)
      near += std::popcount(bits(load(planes(f).key) < four(limit)));
    double sure = planes(nearest).sure[nearest % 4];
    if (near > 1 && (!direction_is_known(nearest) || !only_direction(nearest, sure))) return;
    result.outcome = SearchOutcome::Overlapping;
    result.normal = -normal(nearest);
    result.bound = -sure;
    result.corners = 3;
    for (Index k = 0; k < 3; ++k) {
      const Index c = (k == 0 ? from_ : k == 1 ? to_ : apex_)[nearest];
      result.p[k] = vertex_p_[c];
      result.q[k] = vertex_q_[c];
    }
  }

  /// Not that of a triangle so slim that rounding turns it.
  bool direction_is_known(Index f) const {
    const Vector3 apex = place(apex_[f]), u = place(from_[f]) - apex, v = place(to_[f]) - apex;
    const double longest = std::max(u.squaredNorm(), v.squaredNorm());
    const double least = kSlimHeight / (kRounding * kSearchShare) * rounding_;
    return u.cross(v).squaredNorm() > least * least * longest;
  }

  /// Does no other direction come as near? `sure`: the least of all facets.
  bool only_direction(Index nearest, double& sure) {
    const Vector3 n = normal(nearest);
    const double limit = planes(nearest).distance[nearest % 4] + kAsNear * rounding_;
    Four least_four = four(sure);
    unsigned others = 0;
    for (Index f = 0; f < facet_count_; f += 4) {
      const Planes& of = planes(f);
      const FourFlags there = load(of.key) < four(kNone);
      const FourFlags aside = along(of, n) < four(kSurelyOneDirection);
      least_four = smaller(either(there, load(of.sure), least_four), least_four);
      others |= ~bits(four(limit) < load(of.distance)) & bits(aside);
    }
    sure = least(least_four);
    return others == 0;
  }

  static constexpr double kSlim = 0.25;  // sine; the normal is that of doubles that have cancelled
  static constexpr double kNoArea = 1e-14;   // sine
  static constexpr double kNone = 1e300;     // m
  static constexpr double kRounded = 1e-12;  // more than the number of a facet changes in its key

  const Solid& p_;
  const Solid& q_;
  double rounding_;
  alignas(32) double least_[4];  // of the keys, in four heaps
  Index corner_count_ = 0, facet_count_ = 0, sides_ = 0;
  alignas(32) double corner_[kMostCorners][4];  // its place and how far that is from the origin, m
  int vertex_p_[kMostCorners], vertex_q_[kMostCorners];
  Planes planes_[kMostFacets / 4];
  std::uint8_t slim_[kMostFacets / 4];  // one bit a facet
  Number from_[kMostFacets], to_[kMostFacets], apex_[kMostFacets];
  Number facet_at_[kMostCorners * kRow];
};

}  // namespace
}  // namespace quoin::geometry
