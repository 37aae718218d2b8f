#pragma once
/// certify_corners, as a kernel. See kernels/kernels.hpp. Internal.

#include "certify/certificate_kernel.hpp"
#include "search/corner_features.hpp"
#include "search/simplex_reduction.hpp"
#include "shape/scan.hpp"

namespace quoin::geometry {
namespace {

/// Four ways that the difference q - p can go from the corner w.
struct Ways {
  FourVectors way;
  Four slope, square;  // products with w and with itself
};

template <int... kLanes>
Ways picked(const Ways& ways) {
  return {
      {picked<kLanes...>(ways.way.x), picked<kLanes...>(ways.way.y), picked<kLanes...>(ways.way.z)},
      picked<kLanes...>(ways.slope),
      picked<kLanes...>(ways.square)};
}

/// The last is none.
inline Ways ways(const FourVectors& way, const FourVectors& w) {
  return {way, dot(way, w), dot(way, way) + Four{0.0, 0.0, 0.0, 1.0}};
}

/// From a vertex to the other ends of its three edges.
struct Ends {
  FourVectors here, there;
};
inline Four at(const double* row, std::span<const int> ends, int vertex) {
  return Four{row[ends[0]], row[ends[1]], row[ends[2]], row[vertex]};
}
Ends ends_of(const Rows& rows, std::span<const int> ends, int vertex) {
  const FourVectors there{at(rows.x, ends, vertex), at(rows.y, ends, vertex),
                          at(rows.z, ends, vertex)};
  const Body* const body = rows.solid->turned();
  if (body == nullptr)
    return {{four(rows.x[vertex]), four(rows.y[vertex]), four(rows.z[vertex])}, there};
  const double* a = body->placement().linear.data();
  const FourVectors turned{there.x * a[0] + there.y * a[3] + there.z * a[6],
                           there.x * a[1] + there.y * a[4] + there.z * a[7],
                           there.x * a[2] + there.y * a[5] + there.z * a[8]};
  return {{four(turned.x[3]), four(turned.y[3]), four(turned.z[3])}, turned};
}

/// By how much the squared distance shrinks on four features; their numbers in the last bits. 0:
/// the nearest point lies beyond an end.
inline Four numbered(const Four& gain, const FourFlags& within, long long first) {
  const FourFlags number{first, first + 1, first + 2, first + 3};
  return reinterpret_cast<Four>(((reinterpret_cast<FourFlags>(gain) & ~31LL) | number) & within);
}

/// On the edges.
inline Four gain_on_edges(const Ways& e, long long first) {
  const FourFlags within = (e.slope < Four{}) & (-e.slope <= e.square);
  return numbered(e.slope * e.slope / e.square, within, first);
}

/// At their other ends, where the edges come nearer all along.
inline Four gain_at_ends(const Ways& e, long long first) {
  return numbered(-(e.slope + e.slope + e.square), -e.slope > e.square, first);
}

/// On what two ways span: a face of one solid or, of one edge each, their difference; on the first
/// alone where the second is none.
inline Four gain_on_faces(const Ways& e, const Ways& f, long long first) {
  const Four product = dot(e.way, f.way);
  const Four whole = e.square * f.square - product * product;
  const Four along_e = f.slope * product - e.slope * f.square;
  const Four along_f = e.slope * product - f.slope * e.square;
  const Four zero{};
  const FourFlags within =
      (along_e > zero) & (along_f >= zero) & (along_e <= whole) & (along_f <= whole);
  return numbered(-(along_e * e.slope + along_f * f.slope) / whole, within, first);
}

/// The corners that span a feature: ends of the edges, or the vertex itself (3).
struct Spanned {
  std::array<std::uint8_t, 3> p{3, 3, 3}, q{3, 3, 3};
};
/// Number 0: the vertices alone.
constexpr std::array<Spanned, 32> spanned() {
  std::array<Spanned, 32> all{};
  for (std::uint8_t k = 0; k < 3; ++k) {
    const auto next = static_cast<std::uint8_t>((k + 1) % 3);
    for (std::uint8_t j = 0; j < 4; ++j) all[1u + 4u * k + j] = {{3, 3, k}, {3, 3, j}};
    all[13u + k].p = {3, k, next};
    all[17u + k].q = {3, k, next};
    all[21u + k].q = {3, 3, k};
    all[25u + k].p = {k, k, k};
    all[28u + k].q = {k, k, k};
  }
  return all;
}

/// Corners that span one feature of P and one of Q; those that are fewer than three stand twice.
struct CornerFeatures {
  std::array<int, 3> p, q;
};

inline CornerFeatures around(const Solid& solid_p, const Solid& solid_q, const Vec3& direction) {
  const Rows rows_p(solid_p), rows_q(solid_q);
  const PairSupport both = Scan::support_pair(rows_p, rows_q, direction);
  const int i = both.p.vertex, j = both.q.vertex;
  const Vector3 apart = solid_q.origin() - solid_p.origin();
  const Vec3 place_p = rows_p.placed(i), place_q = rows_q.placed(j);
  const FourVectors w{four(place_q.x - place_p.x + apart.x()),
                      four(place_q.y - place_p.y + apart.y()),
                      four(place_q.z - place_p.z + apart.z())};
  const std::span<const int> ends_p = solid_p.topology().neighbours(i),
                             ends_q = solid_q.topology().neighbours(j);
  const Ends at_p = ends_of(rows_p, ends_p, i), at_q = ends_of(rows_q, ends_q, j);
  const Ways p = ways(at_p.here - at_p.there, w), q = ways(at_q.there - at_q.here, w);
  const Four most =
      larger(larger(larger(gain_on_faces(picked<0, 0, 0, 0>(p), q, 1),
                           gain_on_faces(picked<1, 1, 1, 1>(p), q, 5)),
                    larger(gain_on_faces(picked<2, 2, 2, 2>(p), q, 9),
                           gain_on_faces(p, picked<1, 2, 0, 3>(p), 13))),
             larger(larger(gain_on_faces(q, picked<1, 2, 0, 3>(q), 17), gain_on_edges(q, 21)),
                    larger(gain_at_ends(p, 25), gain_at_ends(q, 28))));
  static constexpr std::array<Spanned, 32> kSpanned = spanned();
  const Spanned& by = kSpanned[std::bit_cast<std::uint64_t>(greatest(most)[0]) & 31u];
  const std::array<int, 4> all_p{ends_p[0], ends_p[1], ends_p[2], i},
      all_q{ends_q[0], ends_q[1], ends_q[2], j};
  return {{all_p[by.p[0]], all_p[by.p[1]], all_p[by.p[2]]},
          {all_q[by.q[0]], all_q[by.q[1]], all_q[by.q[2]]}};
}

}  // namespace
}  // namespace quoin::geometry
