#pragma once
/// All kernels. Included once by the file of each instruction set. Internal.

#include "certify/certificate_kernel.hpp"
#include "kernels/kernels.hpp"
#include "search/box_sat_kernel.hpp"
#include "search/corner_features_kernel.hpp"
#include "search/epa_kernel.hpp"
#include "search/nearest_feature_search_kernel.hpp"
#include "shape/scan.hpp"

// Numbers that stay apart in registers: packing two of them costs more than it saves.
#if defined(__GNUC__) && !defined(__clang__)
#define QUOIN_UNPACKED [[gnu::optimize("no-tree-slp-vectorize")]]
#else
#define QUOIN_UNPACKED
#endif

// All that a kernel calls is built into it, unless calls stay within the file
// (geometry/CMakeLists.txt).
#if defined(QUOIN_KERNELS_IN_PIECES)
#define QUOIN_WHOLE
#else
#define QUOIN_WHOLE [[gnu::flatten]]
#endif

namespace quoin::geometry {
namespace {

struct Build {
  QUOIN_WHOLE static Support support(const Solid& solid, const Vector3& direction) {
    const Rows rows(solid);
    return Scan::support(rows, rows.local(direction));
  }
  QUOIN_WHOLE static void find_vertices_beyond(const Solid& solid, const Vector3& direction,
                                               double value, VertexSet& vertices) {
    vertices.clear();
    const Rows rows(solid);
    Scan::beyond(rows, rows.local(direction), value, vertices);
  }
  QUOIN_WHOLE static Support find_top(const Solid& solid, const Vector3& direction,
                                      const std::array<double, 2>& depths, VertexSet& deep,
                                      VertexSet& shallow) {
    deep.clear();
    shallow.clear();
    const Rows rows(solid);
    return Scan::top(rows, rows.local(direction), depths, deep, shallow);
  }
  QUOIN_WHOLE static bool carried_alone(const Solid& solid, const Vector3& direction,
                                        const Carriers& carriers, Support& top) {
    const Rows rows(solid);
    return Scan::carried_alone(rows, rows.local(direction), carriers, top);
  }

  [[gnu::noinline]] QUOIN_WHOLE QUOIN_UNPACKED static Trial certify(
      const Solid& a, const Solid& b, const Carrier& by_a, const Carrier& by_b,
      const Lengths& length, const Overlap* overlap, NearestFeatures& answer) {
    return try_kinds(a, b, by_a, by_b, length, overlap, answer);
  }
  QUOIN_WHOLE static Trial certify_hint(const Solid& a, const Solid& b, const FeatureHint& hint,
                                        const Lengths& length, NearestFeatures& answer) {
    Carrier by_a, by_b;
    if (!hinted_carrier(a.shape(), hint.vertices_a, hint.face_a, by_a) ||
        !hinted_carrier(b.shape(), hint.vertices_b, hint.face_b, by_b))
      return Trial::Undecided;
    return certify(a, b, by_a, by_b, length, nullptr, answer);
  }

  [[gnu::noinline]] QUOIN_WHOLE QUOIN_UNPACKED static CornerFeatures nearest_corners(
      const Solid& a, const Solid& b) {
    return around(a, b, between(a, b));
  }
  QUOIN_WHOLE static Trial certify_corners(const Solid& a, const Solid& b, const Lengths& length,
                                           NearestFeatures& answer) {
    const CornerFeatures corners = nearest_corners(a, b);
    Carrier by_a, by_b;
    if (!corner_carrier(a, corners.p, by_a) || !corner_carrier(b, corners.q, by_b))
      return Trial::Refuted;
    return certify(a, b, by_a, by_b, length, nullptr, answer);
  }

  template <class AnyRows>
  [[gnu::noinline]] QUOIN_WHOLE static SearchResult search(const Solid& p, const Solid& q,
                                                           const Vector3& direction,
                                                           double rounding) {
    return search_rows<AnyRows>(p, q, direction, rounding);
  }
  static SearchResult nearest_feature_search(const Solid& p, const Solid& q,
                                             const Vector3& direction, double rounding) {
    const bool turned = p.turned() != nullptr || q.turned() != nullptr;
    return turned ? search<Rows>(p, q, direction, rounding)
                  : search<StraightRows>(p, q, direction, rounding);
  }

  QUOIN_WHOLE static SearchResult box_sat(const Solid& p, const Solid& q, double rounding) {
    return least_overlap(p, q, rounding);
  }

  [[gnu::noinline]] QUOIN_WHOLE static SearchResult expand_polytope(const Solid& p, const Solid& q,
                                                                    const SearchResult& start,
                                                                    double rounding) {
    return Polytope(p, q, rounding).grow(start);
  }

  static constexpr Kernels kernels(const char* name) {
    return {.name = name,
            .support = support,
            .find_vertices_beyond = find_vertices_beyond,
            .find_top = find_top,
            .carried_alone = carried_alone,
            .certify = certify,
            .certify_hint = certify_hint,
            .certify_corners = certify_corners,
            .nearest_feature_search = nearest_feature_search,
            .box_sat = box_sat,
            .expand_polytope = expand_polytope};
  }
};

}  // namespace
}  // namespace quoin::geometry
