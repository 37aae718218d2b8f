#include "ordinary.hpp"

#include <algorithm>

#include "line_forms.hpp"
#include "pair_order.hpp"
#include "patch.hpp"
#include "support_lanes.hpp"

namespace quoin::geometry {
namespace {

constexpr FeatureKind kVertex = FeatureKind::Vertex, kEdge = FeatureKind::Edge,
                      kFace = FeatureKind::Face;

/// Ascending.
template <FeatureKind kKind>
std::span<const int> vertices_of(const Polyhedron& solid, const Carrier& carrier) {
  if constexpr (kKind == kFace) return solid.topology().face_set(carrier.face);
  return {carrier.vertices.data(), kKind == kVertex ? 1u : 2u};
}

/// The side of P on which the normal of two edges looks is left open.
template <bool kFused, FeatureKind kP, FeatureKind kQ>
ClosedForm form_of(const Polyhedron& p, const Polyhedron& q, const Carrier& by_p,
                   const Carrier& by_q, double rounding) {
  if constexpr (kP == kFace) return {.found = true, .normal = p.face_normal(by_p.face)};
  if constexpr (kQ == kFace) return {.found = true, .normal = -q.face_normal(by_q.face)};
  const Vector3 first_p = p.vertex(by_p.vertices[0]), first_q = q.vertex(by_q.vertices[0]);
  if constexpr (kP == kVertex && kQ == kVertex) return line_form(first_q - first_p, true);
  if constexpr (kP == kVertex) return vertex_edge<kFused>(first_p, q, by_q.vertices, 1.0);
  if constexpr (kQ == kVertex) return vertex_edge<kFused>(first_q, p, by_p.vertices, -1.0);
  return edge_edge<kFused>(p, by_p.vertices, q, by_q.vertices, rounding);
}

/// By hand: the library's maximum becomes a branch, which could not be foreseen.
double greater(double x, double y) {
#ifdef QUOIN_WIDE_LANES
  return _mm_cvtsd_f64(_mm_max_pd(_mm_set1_pd(x), _mm_set1_pd(y)));
#else
  return x > y ? x : y;
#endif
}

/// Do just these vertices carry the support plane, clearly? Then any way to the plane finds them.
template <class Scan>
bool carry_alone(const Polyhedron& solid, std::span<const int> vertices, const Vector3& outward,
                 const Lengths& length, Support& top) {
  top = {vertices[0], along(offset(solid, vertices[0]), outward)};
  double least = top.value;
  for (const int v : vertices.subspan(1)) {
    const double value = along(offset(solid, v), outward);
    top.vertex = value > top.value ? v : top.vertex;
    top.value = greater(value, top.value);
    least = -greater(-least, -value);
  }
  return top.value - least <= kClearBelow * length.rounding &&
         Scan::count_beyond(Rows(solid), outward, top.value - length.widest) ==
             static_cast<int>(vertices.size());
}

/// Has a face label an area that no tolerance takes for a line? Three of its corners within
/// `tolerance` of a line would span less than twice that by the diameter.
bool clearly_wide(const Polyhedron& solid, int face, double tolerance) {
  const std::span<const int> cycle = solid.topology().face(face);
  const Vector3 base = solid.vertex(cycle[0]);
  const Vector3 normal = (solid.vertex(cycle[1]) - base).cross(solid.vertex(cycle[2]) - base);
  const double least = 4.0 * tolerance * solid.diameter();
  return normal.squaredNorm() > least * least;
}

/// The label of a carrier; false where it has none that is beyond doubt.
template <FeatureKind kKind>
bool name_carrier(const Polyhedron& solid, const Carrier& carrier, double tolerance,
                  Feature& feature) {
  if constexpr (kKind == kVertex) feature = {kVertex, carrier.vertices[0]};
  if constexpr (kKind == kFace) feature = {kFace, carrier.face};
  if constexpr (kKind == kEdge) {
    feature = {kEdge, solid.topology().find_edge(carrier.vertices[0], carrier.vertices[1])};
  }
  return feature.index >= 0 && (kKind != kFace || clearly_wide(solid, carrier.face, tolerance));
}

/// Its four lowest vertices, ascending.
template <FeatureKind kKind>
void set_hinted(const Polyhedron& solid, const Carrier& carrier, std::array<int, 4>& hinted,
                int& face) {
  if constexpr (kKind != kFace) {
    hinted[0] = carrier.vertices[0];
    if constexpr (kKind == kEdge) hinted[1] = carrier.vertices[1];
    return;
  }
  const std::span<const int> set = solid.topology().face_set(carrier.face);
  std::copy_n(set.begin(), std::min<std::size_t>(set.size(), 4), hinted.begin());
  face = carrier.face;
}

/// Where the answer of one solid goes.
struct Outlet {
  Vector3& point;
  Feature& feature;
  double& residual;
  std::array<int, 4>& hinted;
  int& face;
  double sign;  // of the normal, seen from here
};
Outlet outlet_a(NearestFeatures& answer) {
  return {answer.point_a,         answer.feature_a,   answer.residual_a,
          answer.hint.vertices_a, answer.hint.face_a, 1.0};
}
Outlet outlet_b(NearestFeatures& answer) {
  return {answer.point_b,         answer.feature_b,   answer.residual_b,
          answer.hint.vertices_b, answer.hint.face_b, -1.0};
}

/// How far a solid reaches beyond its witness; not at all where that is a vertex.
template <FeatureKind kKind>
double residual(double beyond) {
  return kKind == kVertex ? 0.0 : greater(beyond, 0.0);
}

/// Fills all of the answer that does not hang on who is A: `to_p`, `to_q` say where the rest goes.
template <class Scan, FeatureKind kP, FeatureKind kQ>
Trial attempt(const Polyhedron& p, const Polyhedron& q, const Carrier& by_p, const Carrier& by_q,
              const Lengths& length, const Outlet& to_p, const Outlet& to_q, const Overlap* overlap,
              NearestFeatures& answer) {
  ClosedForm form = form_of<Scan::kFused, kP, kQ>(p, q, by_p, by_q, length.rounding);
  if constexpr (kP == kEdge && kQ == kEdge) {
    const Vector3 toward = overlap != nullptr
                               ? Vector3(to_p.sign * overlap->normal)
                               : Vector3(q.vertex(by_q.vertices[0]) - p.vertex(by_p.vertices[0]));
    form.normal *= std::copysign(1.0, form.normal.dot(toward));
  }
  if (!form.found) return Trial::Undecided;
  const Vector3 normal = form.normal;
  Support top_p, top_q;
  if (!carry_alone<Scan>(p, vertices_of<kP>(p, by_p), normal, length, top_p) ||
      !carry_alone<Scan>(q, vertices_of<kQ>(q, by_q), -normal, length, top_q)) {
    return Trial::Refuted;
  }
  const Vector3 high = p.vertex(top_p.vertex), low = q.vertex(top_q.vertex);
  const double gap = normal.dot(low - high);
  if (!(gap > (overlap != nullptr ? overlap->least : 8 * length.rounding))) return Trial::Undecided;
  if constexpr (kP == kFace) {
    if (!over_face(p, by_p.face, normal, low, length.rounding)) return Trial::Refuted;
  } else if constexpr (kQ == kFace) {
    if (!over_face(q, by_q.face, -normal, high, length.rounding)) return Trial::Refuted;
  } else if (!form.joined) {
    return Trial::Refuted;
  }
  if (kP == kEdge && kQ == kEdge && !form.crossed) return Trial::Undecided;
  if (!name_carrier<kP>(p, by_p, length.contact, to_p.feature) ||
      !name_carrier<kQ>(q, by_q, length.contact, to_q.feature)) {
    return Trial::Undecided;
  }
  const Vector3 across = gap * normal;
  if constexpr (kP == kVertex) {
    to_p.point = high;
    to_q.point = kQ == kVertex ? low : Vector3(high + across);
  } else if constexpr (kQ == kVertex) {
    to_q.point = low;
    to_p.point = low - across;
  } else {
    const Vector3 base = p.vertex(by_p.vertices[0]);
    to_p.point = base + form.share * (p.vertex(by_p.vertices[1]) - base);
    to_q.point = to_p.point + across;
  }
  answer.gap = gap;
  answer.normal = to_p.sign * normal;
  to_p.residual = residual<kP>(normal.dot(high - to_p.point));
  to_q.residual = residual<kQ>(normal.dot(to_q.point - low));
  answer.status = status_of(gap, length);
  if constexpr (kP != kFace && kQ != kFace) {
    if (kP != kEdge || kQ != kEdge ||
        parallel(p.vertex(by_p.vertices[1]) - p.vertex(by_p.vertices[0]),
                 q.vertex(by_q.vertices[1]) - q.vertex(by_q.vertices[0]), length.contact)) {
      answer.indeterminate = true;
      answer.rule = PlaneRule::ShortestLine;
    }
  }
  set_hinted<kP>(p, by_p, to_p.hinted, to_p.face);
  set_hinted<kQ>(q, by_q, to_q.hinted, to_q.face);
  answer.hint.normal = answer.normal;
  return Trial::Proved;
}

/// The witness of two crossed edges is found along one of them: in an order that hangs on the
/// coordinates alone. No branch on it, which could not be foreseen.
template <class Scan>
Trial attempt_edges(const Polyhedron& a, const Polyhedron& b, const Carrier& by_a,
                    const Carrier& by_b, const Lengths& length, const Overlap* overlap,
                    NearestFeatures& answer) {
  const std::array solids{&a, &b};
  const std::array carriers{&by_a, &by_b};
  const std::array outlets{outlet_a(answer), outlet_b(answer)};
  const std::size_t p = worked_in_reverse(a, b) ? 1 : 0, q = 1 - p;
  return attempt<Scan, kEdge, kEdge>(*solids[p], *solids[q], *carriers[p], *carriers[q], length,
                                     outlets[p], outlets[q], overlap, answer);
}

template <class Scan>
Trial try_kinds(const Polyhedron& a, const Polyhedron& b, const Carrier& by_a, const Carrier& by_b,
                const Lengths& length, const Overlap* overlap, NearestFeatures& answer) {
  const Outlet to_a = outlet_a(answer), to_b = outlet_b(answer);
  switch (3 * static_cast<int>(by_a.kind) + static_cast<int>(by_b.kind)) {
    case 0:
      return attempt<Scan, kVertex, kVertex>(a, b, by_a, by_b, length, to_a, to_b, overlap, answer);
    case 1:
      return attempt<Scan, kVertex, kEdge>(a, b, by_a, by_b, length, to_a, to_b, overlap, answer);
    case 2:
      return attempt<Scan, kVertex, kFace>(a, b, by_a, by_b, length, to_a, to_b, overlap, answer);
    case 3:
      return attempt<Scan, kEdge, kVertex>(a, b, by_a, by_b, length, to_a, to_b, overlap, answer);
    case 4:
      return attempt_edges<Scan>(a, b, by_a, by_b, length, overlap, answer);
    case 6:
      return attempt<Scan, kFace, kVertex>(a, b, by_a, by_b, length, to_a, to_b, overlap, answer);
    default:
      return Trial::Undecided;
  }
}

#ifdef QUOIN_WIDE_LANES
QUOIN_AVX512 [[gnu::flatten]] Trial try_512(const Polyhedron& a, const Polyhedron& b,
                                            const Carrier& by_a, const Carrier& by_b,
                                            const Lengths& length, const Overlap* overlap,
                                            NearestFeatures& answer) {
  return try_kinds<Scan512>(a, b, by_a, by_b, length, overlap, answer);
}
QUOIN_AVX2 [[gnu::flatten]] Trial try_256(const Polyhedron& a, const Polyhedron& b,
                                          const Carrier& by_a, const Carrier& by_b,
                                          const Lengths& length, const Overlap* overlap,
                                          NearestFeatures& answer) {
  return try_kinds<Scan256>(a, b, by_a, by_b, length, overlap, answer);
}
#endif

}  // namespace

Trial try_ordinary(const Polyhedron& a, const Polyhedron& b, const Carrier& by_a,
                   const Carrier& by_b, const Lengths& length, const Overlap* overlap,
                   NearestFeatures& answer) {
#ifdef QUOIN_WIDE_LANES
  if (has_avx512() && !few_vertices(a, b))
    return try_512(a, b, by_a, by_b, length, overlap, answer);
  if (has_avx2()) return try_256(a, b, by_a, by_b, length, overlap, answer);
#endif
  return try_kinds<PlainScan>(a, b, by_a, by_b, length, overlap, answer);
}

bool corner_carrier(const Polyhedron& polyhedron, const std::array<int, 4>& corners,
                    Carrier& carrier) {
  const int u = corners[0], v = corners[1], w = corners[2];
  const int low = std::min(std::min(u, v), w), high = std::max(std::max(u, v), w);
  const int middle = u + v + w - low - high;
  carrier = {low == high ? kVertex : kEdge, {low, high}, -1};
  if (low == middle || middle == high) return true;
  carrier = {kFace, {}, common_face(polyhedron.topology(), std::span(corners).first(3))};
  return carrier.face >= 0;
}

}  // namespace quoin::geometry
