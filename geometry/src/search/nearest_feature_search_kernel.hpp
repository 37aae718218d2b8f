#pragma once
/// nearest_feature_search, as a kernel. See kernels/kernels.hpp. Internal.

#include "search/nearest_feature_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "numeric/error_bounds.hpp"
#include "search/simplex_reduction.hpp"
#include "shape/scan.hpp"

namespace quoin::geometry {
namespace {

constexpr int kMostSteps = 64;  // most pairs take under ten; what goes round comes to other tries

int name_p(double name) { return static_cast<int>(std::bit_cast<long long>(name) & 0x7fffffff); }
int name_q(double name) { return static_cast<int>(std::bit_cast<long long>(name) >> 32); }

/// Corners of their own first, then those that stand twice.
void name_corners(const SimplexReduction& rows, SearchResult& result) {
  static constexpr std::array<unsigned char, 8> kFirst{0, 0, 0, 0, 0, 2, 1, 0},
      kCount{0, 1, 1, 2, 1, 2, 2, 3}, kLanes{0, 1, 2, 0, 1, 0, 0, 0};
  std::array<double, 4> names;
  std::memcpy(names.data(), &rows.names, sizeof(names));
  for (std::size_t k = 0; k < 3; ++k) {
    const double name = names[kLanes[kFirst[rows.edges] + k]];
    result.p[k] = name_p(name);
    result.q[k] = name_q(name);
  }
  result.corners = kCount[rows.edges];
}

/// From the rows that the scans have read; `apart`: between their origins.
template <class AnyRows>
NewCorner new_corner(const AnyRows& p, const AnyRows& q, const PairSupport& both,
                     const Vector3& apart) {
  const int i = both.p.vertex, j = both.q.vertex;
  const Vec3 step = q.placed(j) - p.placed(i);
  const FourVectors offset{four(step.x), four(step.y), four(step.z)};
  const FourVectors between{four(apart.x()), four(apart.y()), four(apart.z())};
  return {offset + between, offset, corner_name(i, j)};
}

/// What a direction says of the nearest point. `newest`: one of the corners that carry it.
struct Reach {
  double along;           // of the corners along the direction
  double squared_length;  // of the direction
  double squared_distance;

  Reach(const FourVectors& newest, const Direction& d)
      : along(d.x * newest.x[0] + d.y * newest.y[0] + d.z * newest.z[0]),
        squared_length(d.x * d.x + d.y * d.y + d.z * d.z) {
    const bool normal = d.scale == 0.0;
    squared_distance =
        (normal ? along * along : squared_length) / (normal ? squared_length : d.scale * d.scale);
  }
};

template <class AnyRows>
SearchResult search_rows(const Solid& p, const Solid& q, const Vector3& direction,
                         double rounding) {
  SearchResult result;
  const AnyRows rows_p(p), rows_q(q);
  const Vector3 apart = q.origin() - p.origin();
  const auto corner_along = [&](const Vector3& d) {
    const PairSupport both = Scan::support_pair(rows_p, rows_q, d);
    return new_corner(rows_p, rows_q, both, apart);
  };
  const NewCorner first = corner_along(direction);
  SimplexReduction rows;
  rows.offset = first.offset;
  rows.names = first.name;
  Direction d{first.w.x[0], first.w.y[0], first.w.z[0]};
  Reach reach(first.w, d);
  double before = kInfinity;
  bool inside = false;
  while (result.iterations < kMostSteps) {
    ++result.iterations;
    if (!(reach.squared_distance > kNothing * kNothing * rounding * rounding)) {
      result.outcome = SearchOutcome::Overlapping;
      break;
    }
    const NewCorner corner = corner_along(Vector3(d.x, d.y, d.z));
    const FourVectors to_newest = rows.offset - corner.offset;
    const double nearer = d.x * to_newest.x[3] + d.y * to_newest.y[3] + d.z * to_newest.z[3];
    const double gain = nearer - kGainRounding * kEpsilon * reach.along;
    const bool no_gain =
        !(gain > 0.0) | (gain * gain <= rounding * rounding * reach.squared_length);
    if (no_gain | has_corner(rows, corner.name) | !(reach.squared_distance < before)) {
      result.outcome = SearchOutcome::Separated;  // as far as doubles go; the proof decides
      break;
    }
    before = reach.squared_distance;
    Carried carried = Carried::Found;
    if (rows.edges == 1)
      take_second_corner(corner, rows, d);
    else
      carried = take_corner(corner, rows, d);
    if (carried == Carried::Unclear) break;  // a flat simplex
    if (carried == Carried::Inside) {
      result.outcome = SearchOutcome::Overlapping;
      result.p[3] = name_p(corner.name[0]);
      result.q[3] = name_q(corner.name[0]);
      inside = true;
      break;
    }
    reach = Reach(corner.w, d);
  }
  name_corners(rows, result);
  if (inside) result.corners = 4;
  result.bound = std::sqrt(reach.squared_distance);
  const double length = std::sqrt(reach.squared_length);
  if (length > 0.0) result.normal = Vector3(d.x, d.y, d.z) / length;
  return result;
}

}  // namespace
}  // namespace quoin::geometry
