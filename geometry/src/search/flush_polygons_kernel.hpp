#pragma once
/// flush_polygons, as a kernel. See kernels/kernels.hpp. Every number is that of clip_kernel.hpp,
/// operation by operation. Internal.

#include <bit>
#include <cstdint>

#include "numeric/branchless.hpp"
#include "numeric/floating_point.hpp"
#include "polygon/contact_polygon.hpp"
#include "search/flush_polygons.hpp"
#include "simd/lane_vector.hpp"

namespace quoin::geometry {
namespace {

/// One bit for each corner (or side) of each pair: those of corner k are bits 4 k … 4 k + 3.
struct CornerBits {
  static constexpr std::uint64_t kOneLane = 0x1111111111111111;
  static std::uint64_t of(int k, unsigned lanes) { return std::uint64_t{lanes} << 4 * k; }
  static unsigned at(std::uint64_t bits, int k) {
    return static_cast<unsigned>(bits >> 4 * k) & 15u;
  }
  /// The pairs of which all, or any, bits are set.
  static unsigned all(std::uint64_t bits) { return ~any(~bits) & 15u; }
  static unsigned any(std::uint64_t bits) {
    bits |= bits >> 32;
    bits |= bits >> 16;
    bits |= bits >> 8;
    return static_cast<unsigned>(bits | bits >> 4) & 15u;
  }
  /// The same for every corner.
  static std::uint64_t every(unsigned lanes) { return lanes * kOneLane; }
};

/// A face of each pair in its contact plane, as LaidFace of clip_kernel.hpp. Of a face with fewer
/// corners than the largest of the four the first corner is repeated: its last sides have no
/// length. Behind the last corner of all stands the first one again.
template <class Lanes>
struct LanePolygon {
  static constexpr int kMost = PolygonSide::kMost;
  FlushRow x[kMost + 1], y[kMost + 1], height[kMost + 1];
  FlushRow side_x[kMost], side_y[kMost], length[kMost];
  FlushRow slack[kMost];  ///< how near to a side is too near, times its length; -infinity: no side
  FlushRow over[kMost];   ///< height of the other face over each corner
  Lanes low, high, slope_x, slope_y, base_x, base_y, base_height;
  std::uint64_t valid = 0;  ///< corners and sides
  std::uint64_t last = 0;   ///< of them
  int most = 0;             ///< corners of the largest
  int forth;                ///< 0: side k starts at corner k, 1: it ends there

  int tail(int k) const { return k + forth; }
  int head(int k) const { return k + 1 - forth; }
  /// Each corner takes the bit of the next one.
  std::uint64_t of_next(std::uint64_t bits) const {
    return bits >> 4 | (last & CornerBits::every(static_cast<unsigned>(bits) & 15u));
  }

  LanePolygon(const PolygonSide& side, int turned) : forth(turned) {
    for (unsigned lane = 0; lane < 4; ++lane) {
      const int count = side.count[lane];
      most = count > most ? count : most;
      valid |= CornerBits::every(1u << lane) & ((std::uint64_t{1} << 4 * count) - 1);
    }
    last = valid & ~(valid >> 4);
    slope_x = Lanes::of(side.slope[0].of);
    slope_y = Lanes::of(side.slope[1].of);
  }
  static LaneVector<Lanes> vector(const FlushRow (&rows)[3]) {
    return {Lanes::of(rows[0].of), Lanes::of(rows[1].of), Lanes::of(rows[2].of)};
  }

  /// Returns how far corners lie off the face's own plane, m.
  Lanes lay(const PolygonSide& side) {
    using Vector = LaneVector<Lanes>;
    const Vector base = vector(side.base), own = vector(side.own), up = vector(side.up);
    const Vector u = vector(side.axis_u), v = vector(side.axis_v);
    const Vector shift = vector(side.shift);
    const Vector first = Vector::of(side.corners[0]);
    Lanes off_plane = Lanes::all(0.0);
    low = Lanes::all(kInfinity);
    high = Lanes::all(-kInfinity);
    for (int k = 0; k < most; ++k) {
      const Vector corner = Vector::of(side.corners[static_cast<std::size_t>(k)]);
      off_plane = off_plane.larger(own.dot(corner - first).size());
      const Vector offset = corner - base;
      const Lanes here_x = u.dot(offset) + shift.x, here_y = v.dot(offset) + shift.y;
      const Lanes here = up.dot(offset) + shift.z;
      here_x.store(x[k].of);
      here_y.store(y[k].of);
      here.store(height[k].of);
      low = low.smaller(here);
      high = high.larger(here);
      const auto is_corner = Lanes::flags(CornerBits::at(valid, k));
      const bool is_base = forth != 0 || k == 0;  // the first one, as the sides run
      if (!is_base) continue;
      base_x = k == 0 ? here_x : here_x.where(is_corner, base_x);
      base_y = k == 0 ? here_y : here_y.where(is_corner, base_y);
      base_height = k == 0 ? here : here.where(is_corner, base_height);
    }
    x[most] = x[0];
    y[most] = y[0];
    height[most] = height[0];
    low = low + Lanes::all(0.0);
    high = high + Lanes::all(0.0);
    return off_plane;
  }
  void lay_sides(const Lanes& rounding) {
    for (int k = 0; k < most; ++k) {
      const Lanes along_x = Lanes::of(x[head(k)].of) - Lanes::of(x[tail(k)].of);
      const Lanes along_y = Lanes::of(y[head(k)].of) - Lanes::of(y[tail(k)].of);
      const Lanes size = (along_x * along_x + along_y * along_y).root();
      along_x.store(side_x[k].of);
      along_y.store(side_y[k].of);
      size.store(length[k].of);
      (rounding * size)
          .where(Lanes::flags(CornerBits::at(valid, k)), Lanes::all(-kInfinity))
          .store(slack[k].of);
    }
  }
  void lay_over(const LanePolygon& other) {
    for (int k = 0; k < most; ++k) {
      const Lanes step_x = Lanes::of(x[k].of) - other.base_x;
      const Lanes step_y = Lanes::of(y[k].of) - other.base_y;
      const Lanes straight = other.base_height + (other.slope_x * step_x + other.slope_y * step_y);
      straight.larger(other.low).smaller(other.high).store(over[k].of);
    }
  }
};

template <class Lanes>
class PolygonLanes {
 public:
  PolygonLanes(const PolygonQuestion& question, PolygonAnswer& answer)
      : in_(question), out_(answer), p_(question.p, 0), q_(question.q, 1) {}

  void solve() {
    out_.count = {};
    const Lanes rounding = Lanes::of(in_.rounding.of), flat = Lanes::all(kFlatLabel) * rounding;
    const Lanes off_plane = p_.lay(in_.p).larger(q_.lay(in_.q));
    good_ = 15u & ~flat.below(off_plane).bits();
    p_.lay_sides(rounding);
    q_.lay_sides(rounding);
    compare();
    if (good_ != 0) overlay();
    out_.solved = good_;
  }

 private:
  static constexpr int kMost = PolygonSide::kMost;
  using Flags = typename Lanes::Flags;

  /// Each corner against each side.
  void compare() {
    const Lanes none = Lanes::all(0.0), far = Lanes::all(kInfinity);
    Lanes clearance = far, least = far;
    FlushRow deepest_p[kMost];
    for (int j = 0; j < q_.most; ++j) Lanes::all(-kInfinity).store(deepest_p[j].of);
    for (int i = 0; i < p_.most; ++i) {
      const Lanes x = Lanes::of(p_.x[i].of), y = Lanes::of(p_.y[i].of);
      const Lanes side_x = Lanes::of(p_.side_x[i].of), side_y = Lanes::of(p_.side_y[i].of);
      const Lanes slack_q = Lanes::of(p_.slack[i].of);
      Lanes deepest_q = Lanes::all(-kInfinity);
      std::uint64_t inside_p = 0, inside_q = 0;
      for (int j = 0, bit = 0; j < q_.most; ++j, bit += 4) {
        const Lanes deep_p = Lanes::of(q_.side_x[j].of) * (y - Lanes::of(q_.y[j + 1].of)) -
                             Lanes::of(q_.side_y[j].of) * (x - Lanes::of(q_.x[j + 1].of));
        const Lanes deep_q =
            side_x * (Lanes::of(q_.y[j].of) - y) - side_y * (Lanes::of(q_.x[j].of) - x);
        deep_p.store(deep_[i][j].of);
        inside_p |= std::uint64_t{none.below(deep_p).bits()} << bit;
        inside_q |= std::uint64_t{none.below(deep_q).bits()} << bit;
        clearance = clearance.smaller(
            (deep_p.size() - Lanes::of(q_.slack[j].of)).smaller(deep_q.size() - slack_q));
        Lanes::of(deepest_p[j].of).larger(deep_p).store(deepest_p[j].of);
        deepest_q = deepest_q.larger(deep_q);
      }
      inside_p_[i] = inside_p;
      inside_q_[i] = inside_q;
      least = least.smaller((deepest_q / Lanes::of(p_.length[i].of))
                                .where(Lanes::flags(CornerBits::at(p_.valid, i)), far));
    }
    for (int j = 0; j < q_.most; ++j) {
      least = least.smaller((Lanes::of(deepest_p[j].of) / Lanes::of(q_.length[j].of))
                                .where(Lanes::flags(CornerBits::at(q_.valid, j)), far));
    }
    inside_p_[p_.most] = inside_p_[0];
    least.store(out_.margin.of);
    good_ &= none.below(clearance).bits();
  }

  void overlay() {
    p_.lay_over(q_);
    q_.lay_over(p_);
    find_covered();
    lay_pieces();
    cross_sides();
    measure();
    share_out();
  }

  /// The corners that lie inside the other face.
  void find_covered() {
    covered_p_ = 0;
    covered_q_ = q_.valid;
    for (int i = 0; i < p_.most; ++i) {
      covered_p_ |= CornerBits::of(i, CornerBits::all(inside_p_[i] | ~q_.valid));
      covered_q_ &= inside_q_[i] | ~CornerBits::every(CornerBits::at(p_.valid, i));
    }
    covered_p_ &= p_.valid;
  }

  /// A piece of the border on each side: P's, then Q's from kMost on.
  void lay_pieces() {
    const auto lay = [&](const LanePolygon<Lanes>& face, int first) {
      for (int k = 0; k < face.most; ++k) {
        start_x_[first + k] = face.x[face.tail(k)];
        start_y_[first + k] = face.y[face.tail(k)];
        end_x_[first + k] = face.x[face.head(k)];
        end_y_[first + k] = face.y[face.head(k)];
      }
    };
    lay(p_, 0);
    lay(q_, kMost);
    starts_p_ = covered_p_;
    ends_p_ = p_.of_next(covered_p_);
    starts_q_ = q_.of_next(covered_q_);
    ends_q_ = covered_q_;
  }

  /// As FaceOverlay::cross_sides: P's piece ends and Q's starts, or the other way round.
  void cross_sides() {
    unsigned doubts = 0;
    for (int i = 0; i < p_.most; ++i) {
      const std::uint64_t next_q = q_.of_next(inside_q_[i]);
      const std::uint64_t crosses =
          (inside_p_[i] ^ inside_p_[i + 1]) & (inside_q_[i] ^ next_q) & CornerBits::every(good_);
      if (crosses == 0) continue;
      const std::uint64_t leaves = crosses & inside_p_[i], enters = crosses & ~leaves;
      doubts |= CornerBits::any((crosses & ~(next_q ^ inside_p_[i])) | (leaves & starts_q_) |
                                (enters & ends_q_));
      starts_q_ |= leaves;
      ends_q_ |= enters;
      for (std::uint64_t left = crosses; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left), lane = bit & 3;
        const std::uint64_t own = std::uint64_t{1} << (4 * i + lane);
        std::uint64_t& known = (leaves >> bit & 1) != 0 ? ends_p_ : starts_p_;
        doubts |= static_cast<unsigned>((known & own) != 0) << lane;
        known |= own;
        if ((doubts >> lane & 1) == 0) cross_side(i, bit >> 2, lane, (leaves >> bit & 1) != 0);
      }
    }
    good_ &= ~(doubts | CornerBits::any((starts_p_ ^ ends_p_) | (starts_q_ ^ ends_q_)));
    for (int lane = 0; lane < 4; ++lane) {
      const std::uint64_t one = CornerBits::kOneLane << lane;
      const int pieces = std::popcount(starts_p_ & one) + std::popcount(starts_q_ & one);
      good_ &= ~(static_cast<unsigned>(pieces < 3) << lane);
    }
  }
  void cross_side(int i, int j, int lane, bool leaves) {
    const auto at = [lane](const FlushRow& row) { return row.of[lane]; };
    const int after_i = i + 1, after_j = j + 1, row_after_i = after_i < p_.most ? after_i : 0;
    const double share = at(deep_[i][j]) / (at(deep_[i][j]) - at(deep_[row_after_i][j]));
    const double x = at(p_.x[i]) + share * at(p_.side_x[i]);
    const double y = at(p_.y[i]) + share * at(p_.side_y[i]);
    const double side_x = at(q_.side_x[j]), side_y = at(q_.side_y[j]);
    const double along = side_x * (x - at(q_.x[after_j])) + side_y * (y - at(q_.y[after_j]));
    const double squared = side_x * side_x + side_y * side_y;
    const double share_q = lesser(greater(along / squared, 0.0), 1.0);
    PolygonCorner& corner = add_corner(lane, x, y);
    corner.feature_p = {FeatureKind::Edge, i};
    corner.feature_q = {FeatureKind::Edge, j};
    corner.height_p = at(p_.height[i]) + share * (at(p_.height[after_i]) - at(p_.height[i]));
    corner.height_q =
        at(q_.height[after_j]) + share_q * (at(q_.height[j]) - at(q_.height[after_j]));
    FlushRow* const of_p_x = leaves ? end_x_ : start_x_;
    FlushRow* const of_p_y = leaves ? end_y_ : start_y_;
    FlushRow* const of_q_x = leaves ? start_x_ : end_x_;
    FlushRow* const of_q_y = leaves ? start_y_ : end_y_;
    of_p_x[i].of[lane] = of_q_x[kMost + j].of[lane] = x;
    of_p_y[i].of[lane] = of_q_y[kMost + j].of[lane] = y;
  }
  PolygonCorner& add_corner(int lane, double x, double y) {
    const auto of = static_cast<std::size_t>(lane);
    PolygonCorner& corner = out_.corners[of][static_cast<std::size_t>(out_.count[of]++)];
    corner.x = x;
    corner.y = y;
    return corner;
  }

  /// Calls `with(piece, lanes that have it)` for P's and then for Q's.
  template <class With>
  void each_piece(const With& with) const {
    for (int k = 0; k < p_.most; ++k) with(k, CornerBits::at(starts_p_, k));
    for (int k = 0; k < q_.most; ++k) with(kMost + k, CornerBits::at(starts_q_, k));
  }

  /// Area and centroid; sums in the order of FaceOverlay's lanes.
  void measure() {
    const Lanes none = Lanes::all(0.0);
    Lanes base_x = none, base_y = none;
    unsigned begun = 0;
    each_piece([&](int k, unsigned lanes) {
      const Flags first = Lanes::flags(lanes & ~begun);
      begun |= lanes;
      base_x = Lanes::of(start_x_[k].of).where(first, base_x);
      base_y = Lanes::of(start_y_[k].of).where(first, base_y);
    });
    Lanes twice[4] = {none, none, none, none}, moment_x[4] = {none, none, none, none},
          moment_y[4] = {none, none, none, none};
    each_piece([&](int k, unsigned lanes) {
      const Lanes a_x = Lanes::of(start_x_[k].of) - base_x;
      const Lanes a_y = Lanes::of(start_y_[k].of) - base_y;
      const Lanes b_x = Lanes::of(end_x_[k].of) - base_x, b_y = Lanes::of(end_y_[k].of) - base_y;
      const Lanes triangle = (a_x * b_y - a_y * b_x).where(Lanes::flags(lanes), none);
      twice[k & 3] = twice[k & 3] + triangle;
      moment_x[k & 3] = moment_x[k & 3] + triangle * (a_x + b_x);
      moment_y[k & 3] = moment_y[k & 3] + triangle * (a_y + b_y);
    });
    const auto sum = [](const Lanes(&of)[4]) { return (of[0] + of[2]) + (of[1] + of[3]); };
    const Lanes area = Lanes::all(0.5) * sum(twice);
    good_ &= none.below(area).bits();
    const Lanes sixth = Lanes::all(1.0) / (Lanes::all(6.0) * area);
    centroid_x_ = base_x + sixth * sum(moment_x);
    centroid_y_ = base_y + sixth * sum(moment_y);
    area.store(out_.area.of);
  }

  /// As FaceOverlay::share_out, and adds the corners that the other face covers.
  void share_out() {
    each_piece([&](int k, unsigned lanes) {
      const Lanes triangle =
          (Lanes::of(start_x_[k].of) - centroid_x_) * (Lanes::of(end_y_[k].of) - centroid_y_) -
          (Lanes::of(start_y_[k].of) - centroid_y_) * (Lanes::of(end_x_[k].of) - centroid_x_);
      good_ &= ~lanes | Lanes::all(0.0).below(triangle).bits();
      (Lanes::all(0.25) * triangle).store(half_[k].of);
    });
    for (int lane = 0; lane < 4; ++lane) {
      if ((good_ >> lane & 1) == 0) continue;
      const auto of = static_cast<std::size_t>(lane);
      for (int k = 0; k < out_.count[of]; ++k) {
        PolygonCorner& corner = out_.corners[of][static_cast<std::size_t>(k)];
        corner.share =
            half_[corner.feature_p.index].of[lane] + half_[kMost + corner.feature_q.index].of[lane];
      }
      const std::uint64_t one = CornerBits::kOneLane << lane;
      for (std::uint64_t left = covered_p_ & one; left != 0; left &= left - 1) {
        const int k = std::countr_zero(left) >> 2;
        PolygonCorner& corner = add_covered(p_, k, lane, half_);
        corner.feature_p = {FeatureKind::Vertex, k};
        corner.feature_q = {FeatureKind::Face, 0};
        corner.height_p = p_.height[k].of[lane];
        corner.height_q = p_.over[k].of[lane];
      }
      for (std::uint64_t left = covered_q_ & one; left != 0; left &= left - 1) {
        const int k = std::countr_zero(left) >> 2;
        PolygonCorner& corner = add_covered(q_, k, lane, half_ + kMost);
        corner.feature_p = {FeatureKind::Face, 0};
        corner.feature_q = {FeatureKind::Vertex, k};
        corner.height_p = q_.over[k].of[lane];
        corner.height_q = q_.height[k].of[lane];
      }
    }
  }
  PolygonCorner& add_covered(const LanePolygon<Lanes>& face, int k, int lane,
                             const FlushRow* half) {
    const int count = std::popcount(face.valid & (CornerBits::kOneLane << lane));
    const int before = (k > 0 ? k : count) - 1;
    PolygonCorner& corner = add_corner(lane, face.x[k].of[lane], face.y[k].of[lane]);
    corner.share = half[k].of[lane] + half[before].of[lane];
    return corner;
  }

  const PolygonQuestion& in_;
  PolygonAnswer& out_;
  LanePolygon<Lanes> p_, q_;
  unsigned good_ = 0;                                    // one bit a pair
  std::uint64_t inside_p_[kMost + 1], inside_q_[kMost];  // P's corner i in Q's sides; Q's in P's i
  std::uint64_t covered_p_, covered_q_;                  // corners inside the other face
  std::uint64_t starts_p_, ends_p_, starts_q_, ends_q_;  // which pieces have a start, an end
  Lanes centroid_x_, centroid_y_;
  FlushRow deep_[kMost][kMost];  // P's corners inside Q's sides, times length
  FlushRow start_x_[2 * kMost], start_y_[2 * kMost], end_x_[2 * kMost], end_y_[2 * kMost];
  FlushRow half_[2 * kMost];
};

}  // namespace
}  // namespace quoin::geometry
