#pragma once
/// overlay_faces, as a kernel. See kernels/kernels.hpp. Internal.

#include "polygon/clip.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "numeric/branchless.hpp"

namespace quoin::geometry {
namespace {

/// A face in the contact plane: of just four corners, or of `kMost` at the most, where the places
/// behind the last one repeat the first. Side k lies between corners k and k + 1; it runs that way
/// on P, and back on Q, whose faces are seen from behind: the inside is to the left.
template <class Lanes, int kMost>
struct LaidFace {
  int count_;
  Feature label;
  const int *vertices, *edges;
  bool turned;
  alignas(32) double x[kMost], y[kMost], height[kMost];
  alignas(32) double tail_x[kMost], tail_y[kMost], head_x[kMost], head_y[kMost];  // of the sides
  alignas(32) double side_x[kMost], side_y[kMost], length[kMost];
  alignas(32) double over[kMost];  // height of the other face over each corner
  double low, high, slope_x, slope_y;

  LaidFace(const Solid& solid, int face, const ContactPlane& plane, bool seen_from_behind)
      : count_(static_cast<int>(solid.topology().face(face).size())),
        label{FeatureKind::Face, face},
        vertices(solid.topology().face_in_fours(face)),
        edges(solid.topology().face_edges(face).data()),
        turned(seen_from_behind) {
    lay_corners(solid.shape().vertices().data(), LocalPlane(solid, plane));
    lay_sides();
    find_slope(solid.face_normal(face), plane);
  }
  int count() const { return kMost == 4 ? 4 : count_; }
  int next(int k) const { return k + 1 < count() ? k + 1 : 0; }
  int before(int k) const { return (k > 0 ? k : count()) - 1; }
  unsigned all() const { return (1u << count()) - 1; }
  /// One bit a corner: each takes the bit of the next one.
  unsigned of_next(unsigned corners) const {
    return corners >> 1 | (corners & 1u) << (count() - 1);
  }

  void lay_corners(const double* places, const LocalPlane& plane) {
    const auto along = [](const Vec3& axis, double shift, const Lanes& u, const Lanes& v,
                          const Lanes& w) {
      return Lanes::all(axis.x) * u + Lanes::all(axis.y) * v + Lanes::all(axis.z) * w +
             Lanes::all(shift);
    };
    Lanes least = Lanes::all(std::numeric_limits<double>::infinity()),
          greatest = Lanes::all(-std::numeric_limits<double>::infinity());
    for (int k = 0; k < kMost; k += 4) {
      if (k >= count()) {
        Lanes::all(x[0]).store(x + k);
        Lanes::all(y[0]).store(y + k);
        Lanes::all(height[0]).store(height + k);
        continue;
      }
      const double* corner[4];
      for (int i = 0; i < 4; ++i) corner[i] = places + 3 * vertices[k + i];
      Lanes u, v, w;
      Lanes::turned(corner, u, v, w);
      u = u - Lanes::all(plane.base.x);
      v = v - Lanes::all(plane.base.y);
      w = w - Lanes::all(plane.base.z);
      const Lanes up = along(plane.normal, plane.shift_height, u, v, w);
      along(plane.axis_u, plane.shift_u, u, v, w).store(x + k);
      along(plane.axis_v, plane.shift_v, u, v, w).store(y + k);
      up.store(height + k);
      least = least.smaller(up);
      greatest = greatest.larger(up);
    }
    low = least.least() + 0.0;  // one zero only: -0 would tell the variants apart
    high = greatest.greatest() + 0.0;
  }
  void lay_sides() {
    for (int k = 0; k < kMost; k += 4) {
      const int after = k + 4 < kMost ? k + 4 : 0;
      const Lanes here_x = Lanes::of(x + k), next_x = here_x.shifted(Lanes::of(x + after));
      const Lanes here_y = Lanes::of(y + k), next_y = here_y.shifted(Lanes::of(y + after));
      const Lanes from_x = turned ? next_x : here_x, to_x = turned ? here_x : next_x;
      const Lanes from_y = turned ? next_y : here_y, to_y = turned ? here_y : next_y;
      const Lanes along_x = to_x - from_x, along_y = to_y - from_y;
      from_x.store(tail_x + k);
      from_y.store(tail_y + k);
      to_x.store(head_x + k);
      to_y.store(head_y + k);
      along_x.store(side_x + k);
      along_y.store(side_y + k);
      (along_x * along_x + along_y * along_y).root().store(length + k);
    }
  }
  void find_slope(const Vector3& normal, const ContactPlane& plane) {
    constexpr double kUpright = 1e-3;  // a face seen from its edge has no slope
    const double across = normal.dot(plane.normal);
    const bool upright = std::abs(across) < kUpright;
    slope_x = upright ? 0.0 : -normal.dot(plane.axis_u) / across;
    slope_y = upright ? 0.0 : -normal.dot(plane.axis_v) / across;
  }
  /// A mean of the corners' heights, hence between them, however badly the slope of a sliver is
  /// known.
  void lay_over(const LaidFace& other) {
    const int base = other.turned ? other.count() - 1 : 0;  // its first corner, as the sides run
    for (int k = 0; k < kMost; k += 4) {
      const Lanes step_x = Lanes::of(x + k) - Lanes::all(other.x[base]);
      const Lanes step_y = Lanes::of(y + k) - Lanes::all(other.y[base]);
      const Lanes straight = Lanes::all(other.height[base]) + (Lanes::all(other.slope_x) * step_x +
                                                               Lanes::all(other.slope_y) * step_y);
      straight.larger(Lanes::all(other.low)).smaller(Lanes::all(other.high)).store(over + k);
    }
  }
};

/// Two faces over each other. The border of what they share consists of pieces, one a side at the
/// most, of P's sides and then of Q's; each runs counter-clockwise from a start to an end, a corner
/// that the other face covers or where two sides cross. None of it asks for their order.
template <class Lanes, int kMost>
class FaceOverlay {
 public:
  FaceOverlay(const Solid& p, const Solid& q, ContactPolygon& part)
      : p_(p, part.face_p, part.plane, false), q_(q, part.face_q, part.plane, true), part_(part) {
    part.corners.resize(2 * kMost);
    end_ = part.corners.begin();
  }

  bool lay(double rounding) {
    if (!compare(rounding)) return false;
    p_.lay_over(q_);
    q_.lay_over(p_);
    lay_sides();
    return cross_sides() && measure() && share_out();
  }

 private:
  enum End { kStart, kEnd };

  /// Each corner against each side, one bit each. False where one lies too near a line.
  bool compare(double rounding) {
    const Lanes far = Lanes::all(std::numeric_limits<double>::infinity());
    Lanes slack[kMost / 4], deepest[kMost / 4], clearance[kMost / 4];
    for (int k = 0; k < kMost / 4; ++k) {
      slack[k] = Lanes::all(rounding) * Lanes::of(q_.length + 4 * k);
      deepest[k] = Lanes::all(-std::numeric_limits<double>::infinity());
      clearance[k] = far;
    }
    alignas(32) double deepest_of_q[kMost];
    std::fill_n(deepest_of_q, kMost, std::numeric_limits<double>::infinity());
    covered_p_ = 0;
    covered_q_ = q_.all();
    for (int i = 0; i < p_.count(); ++i) {
      const Lanes x = Lanes::all(p_.x[i]), y = Lanes::all(p_.y[i]);
      const Lanes side_x = Lanes::all(p_.side_x[i]), side_y = Lanes::all(p_.side_y[i]);
      const Lanes slack_q = Lanes::all(rounding * p_.length[i]);
      Lanes deepest_q = Lanes::all(-std::numeric_limits<double>::infinity());
      unsigned inside_p = 0, inside_q = 0;
      for (int k = 0; k < kMost / 4; ++k) {
        const int j = 4 * k;
        const Lanes deep_p = Lanes::of(q_.side_x + j) * (y - Lanes::of(q_.tail_y + j)) -
                             Lanes::of(q_.side_y + j) * (x - Lanes::of(q_.tail_x + j));
        const Lanes deep_q =
            side_x * (Lanes::of(q_.y + j) - y) - side_y * (Lanes::of(q_.x + j) - x);
        deep_p.store(deep_[i] + j);
        inside_p |= Lanes::all(0.0).below(deep_p).bits() << j;
        inside_q |= Lanes::all(0.0).below(deep_q).bits() << j;
        clearance[k] =
            clearance[k].smaller((deep_p.size() - slack[k]).smaller(deep_q.size() - slack_q));
        deepest[k] = deepest[k].larger(deep_p);
        deepest_q = deepest_q.larger(deep_q);
      }
      inside_p_[i] = inside_p & q_.all();
      inside_q_[i] = inside_q & q_.all();
      covered_p_ |= static_cast<unsigned>(inside_p_[i] == q_.all()) << i;
      covered_q_ &= inside_q;
      deepest_of_q[i] = deepest_q.greatest();
    }
    Lanes least = far;
    unsigned doubtful = 0;
    for (int k = 0; k < kMost / 4; ++k) {
      const unsigned valid_p = p_.all() >> 4 * k, valid_q = q_.all() >> 4 * k;
      const Lanes reach_p = deepest[k] / Lanes::of(q_.length + 4 * k);
      const Lanes reach_q = Lanes::of(deepest_of_q + 4 * k) / Lanes::of(p_.length + 4 * k);
      least = least.smaller(only(valid_q, reach_p)).smaller(only(valid_p, reach_q));
      doubtful |= ~Lanes::all(0.0).below(clearance[k]).bits() & valid_q & 15u;
    }
    part_.margin = least.least();
    return doubtful == 0;
  }
  /// Infinite where a bit is not set: not at all, where all four are.
  static Lanes only(unsigned valid, const Lanes& lanes) {
    return kMost == 4 ? lanes
                      : lanes.where(Lanes::flags(valid),
                                    Lanes::all(std::numeric_limits<double>::infinity()));
  }

  /// The pieces where no side is crossed.
  void lay_sides() {
    for (int k = 0; k < kMost; k += 4) {
      Lanes::of(p_.tail_x + k).store(x_[kStart] + k);
      Lanes::of(p_.tail_y + k).store(y_[kStart] + k);
      Lanes::of(p_.head_x + k).store(x_[kEnd] + k);
      Lanes::of(p_.head_y + k).store(y_[kEnd] + k);
      Lanes::of(q_.tail_x + k).store(x_[kStart] + kMost + k);
      Lanes::of(q_.tail_y + k).store(y_[kStart] + kMost + k);
      Lanes::of(q_.head_x + k).store(x_[kEnd] + kMost + k);
      Lanes::of(q_.head_y + k).store(y_[kEnd] + kMost + k);
    }
    known_[kStart] = covered_p_ | q_.of_next(covered_q_) << kMost;
    known_[kEnd] = p_.of_next(covered_p_) | covered_q_ << kMost;
  }

  /// Where sides cross, one piece of P's side ends and one of Q's starts, or the other way round.
  /// False where signs contradict each other, as rounding may make them.
  bool cross_sides() {
    unsigned doubts = 0;
    for (int i = 0; i < p_.count() && doubts == 0; ++i) {
      const unsigned lines_q = inside_p_[i] ^ inside_p_[p_.next(i)];
      const unsigned line_p = inside_q_[i] ^ q_.of_next(inside_q_[i]);
      for (unsigned sides = lines_q & line_p; sides != 0; sides &= sides - 1) {
        const int j = std::countr_zero(sides);
        const unsigned end = inside_p_[i] >> j & 1, start = end ^ 1;  // of P's piece; of Q's start
        doubts |= inside_q_[i] >> q_.next(j) & end;
        doubts |= ~(inside_q_[i] >> q_.next(j)) & start;
        doubts |= (known_[end] >> i | known_[start] >> (kMost + j)) & 1;
        if (doubts != 0) break;
        const auto [x, y] = add_crossing(i, j);
        known_[end] |= 1u << i;
        known_[start] |= 1u << (kMost + j);
        x_[end][i] = x_[start][kMost + j] = x;
        y_[end][i] = y_[start][kMost + j] = y;
      }
    }
    return doubts == 0 && known_[kStart] == known_[kEnd] && std::popcount(known_[kStart]) >= 3;
  }
  struct Place {
    double x, y;
  };
  /// Nearly parallel sides cross in an ill-conditioned place: Q's height is taken there, not where
  /// its own crossing would be.
  Place add_crossing(int i, int j) {
    const int after_i = p_.next(i), after_j = q_.next(j);
    const double share = deep_[i][j] / (deep_[i][j] - deep_[after_i][j]);
    const double x = p_.x[i] + share * p_.side_x[i], y = p_.y[i] + share * p_.side_y[i];
    const double along = q_.side_x[j] * (x - q_.tail_x[j]) + q_.side_y[j] * (y - q_.tail_y[j]);
    const double squared = q_.side_x[j] * q_.side_x[j] + q_.side_y[j] * q_.side_y[j];
    const double share_q = lesser(greater(along / squared, 0.0), 1.0);
    SharedCorner& corner = *end_++;
    corner.place = {x, y};
    corner.height_p = p_.height[i] + share * (p_.height[after_i] - p_.height[i]);
    corner.height_q = q_.height[after_j] + share_q * (q_.height[j] - q_.height[after_j]);
    corner.feature_p = {FeatureKind::Edge, i};  // the side; named when the shares are known
    corner.feature_q = {FeatureKind::Edge, j};
    return {x, y};
  }

  /// Area and centroid from the triangles of one point and each piece.
  bool measure() {
    const unsigned pieces = known_[kStart];
    const int first = std::countr_zero(pieces);
    const double base_x = x_[kStart][first], base_y = y_[kStart][first];
    const Lanes none = Lanes::all(0.0);
    Lanes twice = none, moment_x = none, moment_y = none;
    for (int k = 0; k < 2 * kMost; k += 4) {
      const Lanes a_x = Lanes::of(x_[kStart] + k) - Lanes::all(base_x);
      const Lanes a_y = Lanes::of(y_[kStart] + k) - Lanes::all(base_y);
      const Lanes b_x = Lanes::of(x_[kEnd] + k) - Lanes::all(base_x);
      const Lanes b_y = Lanes::of(y_[kEnd] + k) - Lanes::all(base_y);
      const Lanes triangle = (a_x * b_y - a_y * b_x).where(Lanes::flags(pieces >> k), none);
      twice = twice + triangle;
      moment_x = moment_x + triangle * (a_x + b_x);
      moment_y = moment_y + triangle * (a_y + b_y);
    }
    const double area = 0.5 * twice.sum();
    if (!(area > 0.0)) return false;
    const double sixth = 1.0 / (6.0 * area);
    part_.polygon.area = area;
    part_.polygon.centroid = {base_x + sixth * moment_x.sum(), base_y + sixth * moment_y.sum()};
    return true;
  }

  /// Half of each triangle (centroid, piece) to either end: since the centroid of the polygon is
  /// the area-weighted mean of the triangles' centroids, the shares have its first moment. False:
  /// the pieces do not wind around the centroid.
  bool share_out() {
    const Lanes x = Lanes::all(part_.polygon.centroid.x()),
                y = Lanes::all(part_.polygon.centroid.y());
    const unsigned pieces = known_[kStart];
    alignas(32) double half[2 * kMost];
    unsigned turning = 0;
    for (int k = 0; k < 2 * kMost; k += 4) {
      const Lanes triangle = (Lanes::of(x_[kStart] + k) - x) * (Lanes::of(y_[kEnd] + k) - y) -
                             (Lanes::of(y_[kStart] + k) - y) * (Lanes::of(x_[kEnd] + k) - x);
      turning |= Lanes::all(0.0).below(triangle).bits() << k;
      (Lanes::all(0.25) * triangle).store(half + k);
    }
    if ((turning & pieces) != pieces) return false;
    for (SharedCorner* crossing = part_.corners.begin(); crossing != end_; ++crossing) {
      SharedCorner& c = *crossing;
      const int i = c.feature_p.index, j = c.feature_q.index;
      c.share = half[i] + half[kMost + j];
      c.feature_p.index = p_.edges[i];
      c.feature_q.index = q_.edges[j];
    }
    add_corners_of_p(half);
    add_corners_of_q(half + kMost);
    part_.corners.resize(static_cast<std::size_t>(end_ - part_.corners.begin()));
    find_spread();
    return true;
  }

  /// How near two corners come to each other, and the range of gaps.
  void find_spread() {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, nearest = lowest;
    const SharedCorner* const begin = part_.corners.begin();
    for (const SharedCorner* c = begin; c != end_; ++c) {
      lowest = lesser(lowest, c->height_q - c->height_p);
      highest = greater(highest, c->height_q - c->height_p);
      for (const SharedCorner* other = begin; other != c; ++other) {
        const double x = c->place.x() - other->place.x(), y = c->place.y() - other->place.y();
        nearest = lesser(nearest, x * x + y * y);
      }
    }
    part_.lowest = lowest;
    part_.highest = highest;
    part_.nearest_squared = nearest;
  }
  void add_corners_of_p(const double* half) {
    for (unsigned covered = covered_p_; covered != 0; covered &= covered - 1) {
      const int i = std::countr_zero(covered);
      SharedCorner& corner = *end_++;
      corner.place = {p_.x[i], p_.y[i]};
      corner.height_p = p_.height[i];
      corner.height_q = p_.over[i];
      corner.feature_p = {FeatureKind::Vertex, p_.vertices[i]};
      corner.feature_q = q_.label;
      corner.share = half[i] + half[p_.before(i)];
    }
  }
  void add_corners_of_q(const double* half) {
    for (unsigned covered = covered_q_; covered != 0; covered &= covered - 1) {
      const int j = std::countr_zero(covered);
      SharedCorner& corner = *end_++;
      corner.place = {q_.x[j], q_.y[j]};
      corner.height_p = q_.over[j];
      corner.height_q = q_.height[j];
      corner.feature_p = p_.label;
      corner.feature_q = {FeatureKind::Vertex, q_.vertices[j]};
      corner.share = half[j] + half[q_.before(j)];
    }
  }

  LaidFace<Lanes, kMost> p_, q_;
  ContactPolygon& part_;
  SharedCorner* end_;                                     // behind the corners that are known
  unsigned covered_p_, covered_q_;                        // corners that lie inside the other face
  unsigned inside_p_[kMost];                              // sides of Q around corner i of P
  unsigned inside_q_[kMost];                              // corners of Q inside side i of P
  unsigned known_[2];                                     // which pieces have a start, an end
  alignas(32) double x_[2][2 * kMost], y_[2][2 * kMost];  // starts and ends
  alignas(32) double deep_[kMost][kMost];  // P's corners inside Q's sides, times length
};

template <class Lanes>
bool overlay_of_few(const Solid& p, const Solid& q, double rounding, ContactPolygon& part) {
  const std::size_t count_p = p.topology().face(part.face_p).size();
  const std::size_t count_q = q.topology().face(part.face_q).size();
  const std::size_t most = std::max(count_p, count_q);
  if (count_p == 4 && count_q == 4) return FaceOverlay<Lanes, 4>(p, q, part).lay(rounding);
  if (most <= 8) return FaceOverlay<Lanes, 8>(p, q, part).lay(rounding);
  return most <= 12 && FaceOverlay<Lanes, 12>(p, q, part).lay(rounding);
}

}  // namespace
}  // namespace quoin::geometry
