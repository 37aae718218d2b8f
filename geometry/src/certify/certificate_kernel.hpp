#pragma once
/// The ordinary answers of certificate.hpp, as kernels. See kernels/kernels.hpp. Internal.

#include "certify/canonical_order.hpp"
#include "certify/certificate.hpp"
#include "polygon/line_normal.hpp"
#include "shape/scan.hpp"

namespace quoin::geometry {
namespace {

constexpr FeatureKind kVertex = FeatureKind::Vertex, kEdge = FeatureKind::Edge,
                      kFace = FeatureKind::Face;

/// Ascending.
template <FeatureKind kKind>
std::span<const int> vertices_of(const Solid& solid, const Carrier& carrier) {
  if constexpr (kKind == kFace) return solid.topology().face_set(carrier.face);
  return {carrier.vertices.data(), kKind == kVertex ? 1u : 2u};
}

/// Where a vertex or an edge is; of a face nothing.
template <FeatureKind kKind>
Side side_of(const Solid& solid, const Carrier& carrier) {
  const auto [first, last] = carrier.vertices;
  if constexpr (kKind == kFace) return {};
  if constexpr (kKind == kVertex) return Side(place(solid, first));
  return Side(solid, first, last);
}

/// The side of A on which the normal of two edges looks is left open.
template <FeatureKind kA, FeatureKind kB>
LineNormal form_of(const Solid& a, const Solid& b, const Carrier& by_a, const Carrier& by_b,
                   const Side& at_a, const Side& at_b, double rounding) {
  if constexpr (kA == kFace) return face_line(face_normal(a, by_a.face));
  if constexpr (kB == kFace) return face_line(-face_normal(b, by_b.face));
  if constexpr (kA == kVertex && kB == kVertex) return line_normal(at_b.from - at_a.from, true);
  if constexpr (kA == kVertex) return vertex_edge<kFused>(at_a.from, at_b);
  if constexpr (kB == kVertex) return reversed(vertex_edge<kFused>(at_b.from, at_a));
  return edge_edge<kFused>(at_a, at_b, rounding);
}

/// Has a face label an area that no tolerance takes for a line? Three of its corners within
/// `tolerance` of a line would span less than twice that by the diameter.
bool clearly_wide(const Solid& solid, int face, double tolerance) {
  const std::span<const int> cycle = solid.topology().face(face);
  const Vec3 base = place(solid, cycle[0]);
  const double least = 4.0 * tolerance * solid.diameter();
  return square(cross(place(solid, cycle[1]) - base, place(solid, cycle[2]) - base)) >
         least * least;
}

/// The label of a carrier; false where it has none that is beyond doubt.
template <FeatureKind kKind>
bool name_carrier(const Solid& solid, const Carrier& carrier, double tolerance, Feature& feature) {
  if constexpr (kKind == kVertex) feature = {kVertex, carrier.vertices[0]};
  if constexpr (kKind == kFace) feature = {kFace, carrier.face};
  if constexpr (kKind == kEdge)
    feature = {kEdge, solid.topology().find_edge(carrier.vertices[0], carrier.vertices[1])};
  return feature.index >= 0 && (kKind != kFace || clearly_wide(solid, carrier.face, tolerance));
}

/// Its four lowest vertices, ascending.
template <FeatureKind kKind>
void set_hinted(const Solid& solid, const Carrier& carrier, std::array<int, 4>& hinted, int& face) {
  if constexpr (kKind != kFace) {
    hinted[0] = carrier.vertices[0];
    if constexpr (kKind == kEdge) hinted[1] = carrier.vertices[1];
    return;
  }
  const std::span<const int> set = solid.topology().face_set(carrier.face);
  std::copy_n(set.begin(), std::min<std::size_t>(set.size(), 4), hinted.begin());
  face = carrier.face;
}

/// How far a solid reaches beyond its witness; not at all where that is a vertex.
template <FeatureKind kKind>
double residual(double beyond) {
  return kKind == kVertex ? 0.0 : greater(beyond, 0.0);
}

/// The vertex of the carrier that lies highest, or one of them.
template <FeatureKind kKind>
Vec3 highest(const Solid& solid, const Carrier& carrier, const Side& side, int top) {
  if constexpr (kKind == kFace) return place(solid, top);
  return kKind == kVertex || top == carrier.vertices[0] ? side.from : side.to;
}

struct Witnesses {
  Vec3 a, b;
};

/// The witness of two crossed edges is found along one of them, in an order that hangs on the
/// coordinates alone. No branch on it, which could not be foreseen.
Witnesses crossing(const Side& e, const Side& f, const LineNormal& form, const Vec3& across,
                   bool by_b) {
  const Vec3 on_a = e.from + form.share_p * e.line;
  const Vec3 on_b = f.from + form.share_q * f.line;
  return {either(by_b, on_b - across, on_a), either(by_b, on_b, on_a + across)};
}

/// Of features that span their normal by `lever`, m: carry no others the plane that rounding may
/// turn it to?
[[gnu::noinline]] inline bool keeps_carriers(const Solid& a, const Solid& b,
                                             const std::array<int, 2>& counts, const Vec3& normal,
                                             double lever, const Lengths& length) {
  const double turned = turning(length.rounding);
  return lever * (kTurnedShare * length.widest) > turned ||
         carry_turned(a, b, counts, normal, {turned / lever, length.contact});
}

/// From a point inside A to one inside B.
inline Vec3 between(const Solid& a, const Solid& b) {
  return Vec3(b.vertex_mean()) - Vec3(a.vertex_mean());
}

template <FeatureKind kA, FeatureKind kB>
Trial attempt(const Solid& a, const Solid& b, const Carrier& by_a, const Carrier& by_b,
              const Lengths& length, const Overlap* overlap, NearestFeatures& answer) {
  constexpr bool kEdges = kA == kEdge && kB == kEdge, kByFace = kA == kFace || kB == kFace;
  constexpr bool kEdgeOnFace = kByFace && (kA == kEdge || kB == kEdge);
  const Side at_a = side_of<kA>(a, by_a), at_b = side_of<kB>(b, by_b);
  LineNormal form = form_of<kA, kB>(a, b, by_a, by_b, at_a, at_b, length.rounding);
  if (!form.found) return Trial::Refuted;
  if (!kByFace && !form.joined) return Trial::Refuted;
  if (kEdges) {
    if (!form.crossed) return Trial::Undecided;
    const Vec3 toward = overlap != nullptr ? Vec3(overlap->normal) : between(a, b);
    form.normal = std::copysign(1.0, dot(form.normal, toward)) * form.normal;
  }
  const Vec3 normal = one_zero(form.normal);
  // Do just these vertices carry the support plane, clearly? Then any way to the plane finds them.
  const double flat = kClearBelow * length.rounding;
  const double clear = kByFace ? length.widest : (1.0 + kTurnedShare) * length.widest;
  const auto alone = [=](const Solid& solid, std::span<const int> set, const Vec3& outward,
                         Support& top) {
    const Rows rows(solid);
    return Scan::carried_alone(rows, rows.local(outward), {set, flat, clear}, top);
  };
  Support top_a, top_b;
  if (!alone(a, vertices_of<kA>(a, by_a), normal, top_a) ||
      !alone(b, vertices_of<kB>(b, by_b), -normal, top_b))
    return Trial::Refuted;
  const Vec3 high = highest<kA>(a, by_a, at_a, top_a.vertex);
  const Vec3 low = highest<kB>(b, by_b, at_b, top_b.vertex);
  const double gap = dot(normal, low - high);
  double inside = kByFace || overlap != nullptr ? kFirm * length.rounding : length.rounding;
  const bool apart = gap > kApart * length.rounding;
  if (overlap != nullptr ? !(gap > overlap->least) : !apart) {
    if (overlap != nullptr || !(kByFace || kEdges)) return Trial::Undecided;
    inside = greater(kFirm * length.rounding,
                     shallow_margin(between(a, b), normal, gap, length.rounding));
  }
  Vec3 middle = low;
  if constexpr (kEdgeOnFace) {
    // The general way may prove what this does not, and takes the same middle where it is as firm.
    const Side& edge = kA == kEdge ? at_a : at_b;
    const double margin = greater(inside, kFirm * length.place);
    const bool on_face = kA == kFace ? middle_on_face(a, by_a.face, normal, edge, margin, middle)
                                     : middle_on_face(b, by_b.face, -normal, edge, margin, middle);
    if (!on_face || !(square(edge.line) > 4.0 * length.contact * length.contact))
      return Trial::Undecided;
  } else if constexpr (kA == kFace) {
    if (!over_face(a, by_a.face, normal, low, inside)) return Trial::Refuted;
  } else if constexpr (kB == kFace) {
    if (!over_face(b, by_b.face, -normal, high, inside)) return Trial::Refuted;
  } else {
    if (!(form.from_ends > inside * inside)) return Trial::Refuted;
    const double turned = turning(length.rounding);
    if (overlap == nullptr && apart && !(gap * (kTurnedShare * length.widest) > turned) &&
        !keeps_carriers(a, b, {kA == kVertex ? 1 : 2, kB == kVertex ? 1 : 2}, normal,
                        kEdges ? greater(gap, form.reach_across()) : gap, length))
      return Trial::Refuted;
  }
  if (!name_carrier<kA>(a, by_a, length.contact, answer.feature_a) ||
      !name_carrier<kB>(b, by_b, length.contact, answer.feature_b))
    return Trial::Undecided;
  const Vec3 across = gap * normal;
  const Witnesses on = kEdges        ? crossing(at_a, at_b, form, across, in_reverse_order(a, b))
                       : kEdgeOnFace ? Witnesses{kA == kEdge ? middle : middle - across,
                                                 kB == kEdge ? middle : middle + across}
                                     : Witnesses{kA == kVertex ? high : low - across,
                                                 kB == kVertex ? low : high + across};
  const bool open = kEdges ? parallel(form.skew, form.longer, length.contact) : !kByFace;
  answer.status = status_of(gap, length.contact);
  answer.gap = gap + 0.0;  // one zero
  answer.normal = normal;
  answer.point_a = on.a;
  answer.point_b = on.b;
  answer.residual_a = residual<kA>(dot(normal, high - on.a));
  answer.residual_b = residual<kB>(dot(normal, on.b - low));
  answer.indeterminate = open;
  answer.rule = open ? PlaneRule::ShortestLine : PlaneRule::Unique;
  set_hinted<kA>(a, by_a, answer.hint.vertices_a, answer.hint.face_a);
  set_hinted<kB>(b, by_b, answer.hint.vertices_b, answer.hint.face_b);
  answer.hint.normal = normal;
  return Trial::Proved;
}

inline Trial try_kinds(const Solid& a, const Solid& b, const Carrier& by_a, const Carrier& by_b,
                       const Lengths& length, const Overlap* overlap, NearestFeatures& answer) {
  switch (3 * static_cast<int>(by_a.kind) + static_cast<int>(by_b.kind)) {
    case 0:
      return attempt<kVertex, kVertex>(a, b, by_a, by_b, length, overlap, answer);
    case 1:
      return attempt<kVertex, kEdge>(a, b, by_a, by_b, length, overlap, answer);
    case 2:
      return attempt<kVertex, kFace>(a, b, by_a, by_b, length, overlap, answer);
    case 3:
      return attempt<kEdge, kVertex>(a, b, by_a, by_b, length, overlap, answer);
    case 4:
      return attempt<kEdge, kEdge>(a, b, by_a, by_b, length, overlap, answer);
    case 5:
      return attempt<kEdge, kFace>(a, b, by_a, by_b, length, overlap, answer);
    case 6:
      return attempt<kFace, kVertex>(a, b, by_a, by_b, length, overlap, answer);
    case 7:
      return attempt<kFace, kEdge>(a, b, by_a, by_b, length, overlap, answer);
    default:
      return Trial::Undecided;
  }
}

}  // namespace
}  // namespace quoin::geometry
