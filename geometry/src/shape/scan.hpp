#pragma once
/// The scans behind support.hpp, to be built into the kernels. See kernels/kernels.hpp. Internal.

#include <algorithm>
#include <bit>
#include <type_traits>

#include "numeric/vec3.hpp"
#include "shape/support.hpp"
#include "simd/four.hpp"

namespace quoin::geometry {
namespace {

/// Is a fused product one instruction?
#ifdef __FMA__
constexpr bool kFused = true;
#else
constexpr bool kFused = false;
#endif

/// Rows of a shape's offsets. The scans take directions in the shape's frame: `local` turns them.
struct Rows {
  const double *x, *y, *z;
  int padded;
  int count;
  const Solid* solid;
  explicit Rows(const Solid&& of) = delete;
  explicit Rows(const Solid& of)
      : x(of.shape().offsets()),
        y(x + of.padded_count()),
        z(y + of.padded_count()),
        padded(of.padded_count()),
        count(of.vertex_count()),
        solid(&of) {}
  Vec3 local(const Vec3& direction) const { return solid->turned_back(direction); }
  Vec3 offset(int v) const { return {x[v], y[v], z[v]}; }
  Vec3 placed(int v) const { return solid->turn(offset(v)); }  ///< the same turned as the body is
  double along(int v, const Vec3& d) const { return dot(offset(v), d); }
};

/// Rows of a body that is not turned, for loops where asking each time would cost.
struct StraightRows : Rows {
  using Rows::Rows;
  static Vec3 local(const Vec3& direction) { return direction; }
  Vec3 placed(int v) const { return offset(v); }
};

/// The products of up to 32 vertices with a direction, four side by side.
template <int kFours>
struct Products {
  Four value[kFours];

  Products(const Rows& rows, const FourVectors& d, int first) {
    for (int k = 0; k < kFours; ++k) {
      const int v = first + 4 * k;
      value[k] = dot(FourVectors{load(rows.x + v), load(rows.y + v), load(rows.z + v)}, d);
    }
  }
  /// The greatest, and the lowest index that has it.
  Support top(int first) const {
    Four most = value[0];
    for (int k = 1; k < kFours; ++k) most = larger(most, value[k]);
    most = greatest(most);
    return {first + (std::countr_zero(reaching(most)) & 31), most[0] + 0.0};  // one zero
  }
  /// A bit for each vertex that reaches the limit, in all places.
  std::uint32_t reaching(const Four& limit) const {
    std::uint32_t reached = 0;
    for (int k = 0; k < kFours; ++k) reached |= std::uint32_t{bits(value[k] >= limit)} << 4 * k;
    return reached;
  }
};

/// work(products) of the last up to 32 vertices from `first` on.
template <class Work>
auto scan_last(const Rows& rows, const FourVectors& d, int first, const Work& work) {
  const int left = rows.padded - first;
  if (left == 8) return work(Products<2>(rows, d, first));
  if (left == 16) return work(Products<4>(rows, d, first));
  if (left == 24) return work(Products<6>(rows, d, first));
  return work(Products<8>(rows, d, first));
}

inline FourVectors four(const Vec3& d) { return {four(d.x), four(d.y), four(d.z)}; }

/// Calls work(bits, first) for the vertices that reach a limit, up to 32 at a time.
template <class Work>
void find_reaching(const Rows& rows, const Vec3& direction, double limit, const Work& work) {
  const FourVectors d = four(direction);
  const Four least = four(limit);
  int v = 0;
  for (; rows.padded - v > 32; v += 32) work(Products<8>(rows, d, v).reaching(least), v);
  const auto reached =
      scan_last(rows, d, v, [&](const auto& products) { return products.reaching(least); });
  work(reached & (~std::uint32_t{0} >> (32 - (rows.count - v))), v);
}

/// Directions are those of the shape's frame, of a pair those of the world.
struct Scan {
  static Support support(const Rows& rows, const FourVectors& d) {
    const auto top_from = [&](int first) {
      return scan_last(rows, d, first, [=](const auto& products) { return products.top(first); });
    };
    if (rows.padded <= 32) return top_from(0);
    Support best{0, -kInfinity};
    int v = 0;
    for (; rows.padded - v > 32; v += 32) take(Products<8>(rows, d, v).top(v), best);
    take(top_from(v), best);
    return best;
  }
  static Support support(const Rows& rows, const Vec3& d) { return support(rows, four(d)); }
  template <class AnyRows>
  static PairSupport support_pair(const AnyRows& p, const AnyRows& q, const Vec3& d) {
    return {support(p, p.local(d)), support(q, q.local(-d))};
  }
  static PairSupport support_pair(const StraightRows& p, const StraightRows& q, const Vec3& d) {
    const FourVectors all = four(d);
    return {support(p, all), support(q, {-all.x, -all.y, -all.z})};
  }
  static void beyond(const Rows& rows, const Vec3& d, double value, VertexSet& vertices) {
    find_reaching(rows, d, value,
                  [&](std::uint32_t reached, int first) { add(reached, first, vertices); });
  }
  static Support top(const Rows& rows, const Vec3& d, const std::array<double, 2>& depths,
                     VertexSet& deep, VertexSet& shallow) {
    if (rows.padded > 32) {
      const Support top = support(rows, d);
      beyond(rows, d, top.value - depths[0], deep);
      beyond(rows, d, top.value - depths[1], shallow);
      return top;
    }
    return scan_last(rows, four(d), 0, [&](const auto& products) {
      const Support top = products.top(0);
      const std::uint32_t all = ~std::uint32_t{0} >> (32 - rows.count);
      add(products.reaching(four(top.value - depths[0])) & all, 0, deep);
      add(products.reaching(four(top.value - depths[1])) & all, 0, shallow);
      return top;
    });
  }
  static bool carried_alone(const Rows& rows, const Vec3& d, const Carriers& carriers,
                            Support& top) {
    int highest = carriers.set[0];
    double most = rows.along(highest, d), least = most;
    for (const int v : carriers.set.subspan(1)) {
      const double value = rows.along(v, d);
      highest = value > most ? v : highest;
      most = greater(value, most);
      least = lesser(value, least);
    }
    top = {highest, most + 0.0};  // one zero
    int count = 0;
    find_reaching(rows, d, most - carriers.clear,
                  [&](std::uint32_t reached, int) { count += std::popcount(reached); });
    return most - least <= carriers.flat && count == std::ssize(carriers.set);
  }

 private:
  static void add(std::uint32_t reached, int first, VertexSet& vertices) {
    for (; reached != 0; reached &= reached - 1)
      vertices.push_back(first + std::countr_zero(reached));
  }
  static void take(const Support& next, Support& best) {
    if (next.value > best.value) best = next;
  }
};

}  // namespace
}  // namespace quoin::geometry
