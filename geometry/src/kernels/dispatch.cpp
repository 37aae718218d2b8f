/// Each kernel under its own name: that of the widest instructions that the machine has.

#include <algorithm>
#include <array>

#include "kernels/kernels.hpp"
#include "search/corner_features.hpp"
#include "search/nearest_feature_search.hpp"

namespace quoin::geometry {
namespace {

// Plain until this file's initialiser has run: those of other files may ask before.
constinit const Kernels* widest = &kPlainKernels;
[[maybe_unused]] const bool chosen = (widest = runnable_kernels().back(), true);

}  // namespace

std::span<const Kernels* const> runnable_kernels() {
#ifdef QUOIN_WIDE_KERNELS
  static constexpr std::array kAll{&kPlainKernels, &kAvx2Kernels};
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                    __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  return std::span(kAll).first(avx2 ? 2 : 1);
#else
  static constexpr std::array kAll{&kPlainKernels};
  return kAll;
#endif
}

Support support(const Solid& solid, const Vector3& direction) {
  return widest->support(solid, direction);
}

void find_vertices_beyond(const Solid& solid, const Vector3& direction, double value,
                          VertexSet& vertices) {
  widest->find_vertices_beyond(solid, direction, value, vertices);
}

Support find_top(const Solid& solid, const Vector3& direction, const std::array<double, 2>& depths,
                 VertexSet& deep, VertexSet& shallow) {
  return widest->find_top(solid, direction, depths, deep, shallow);
}

bool carried_alone(const Solid& solid, const Vector3& direction, const Carriers& carriers,
                   Support& top) {
  return widest->carried_alone(solid, direction, carriers, top);
}

Trial certify(const Solid& a, const Solid& b, const Carrier& by_a, const Carrier& by_b,
              const Lengths& length, const Overlap* overlap, NearestFeatures& answer) {
  return widest->certify(a, b, by_a, by_b, length, overlap, answer);
}

Trial certify_hint(const Solid& a, const Solid& b, const FeatureHint& hint, const Lengths& length,
                   NearestFeatures& answer) {
  return widest->certify_hint(a, b, hint, length, answer);
}

Trial certify_corners(const Solid& a, const Solid& b, const Lengths& length,
                      NearestFeatures& answer) {
  return widest->certify_corners(a, b, length, answer);
}

SearchResult nearest_feature_search(const Solid& p, const Solid& q, const Vector3& direction,
                                    double rounding) {
  return widest->nearest_feature_search(p, q, direction, rounding);
}

SearchResult box_sat(const Solid& p, const Solid& q, double rounding) {
  return widest->box_sat(p, q, rounding);
}

SearchResult expand_polytope(const Solid& p, const Solid& q, const SearchResult& start,
                             double rounding) {
  return widest->expand_polytope(p, q, start, rounding);
}

PairSupport support_pair(const Solid& p, const Solid& q, const Vector3& direction) {
  return {support(p, direction), support(q, -direction)};
}

bool only_these_beyond(const Solid& polyhedron, const Vector3& direction, double value,
                       std::span<const int> set) {
  VertexSet beyond;
  find_vertices_beyond(polyhedron, direction, value, beyond);
  return std::equal(set.begin(), set.end(), beyond.begin(), beyond.end());
}

}  // namespace quoin::geometry
