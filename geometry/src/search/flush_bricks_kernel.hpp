#pragma once
/// flush_bricks, as a kernel. See kernels/kernels.hpp. Every step is that of one pair alone: of
/// face_face.cpp, contact_plane.hpp, clip_kernel.hpp and contact_points.cpp, operation by
/// operation. What these leave to another way is not solved. Internal.

#include "certify/certificate.hpp"
#include "search/face_face.hpp"
#include "search/flush_bricks.hpp"
#include "shape/lane_frame.hpp"

namespace quoin::geometry {
namespace {

/// A face of four corners in the contact plane, as LaidFace of clip_kernel.hpp: side k runs from
/// `tail(k)` to `head(k)`.
template <class Lanes>
struct LaneFace {
  using Vector = LaneVector<Lanes>;
  Lanes x[4], y[4], height[4], side_x[4], side_y[4], length[4], over[4];
  Lanes low, high, slope_x, slope_y;
  int forth;  ///< 0: side k starts at corner k, 1: it ends there

  int tail(int k) const { return (k + forth) & 3; }
  int head(int k) const { return (k + 1 - forth) & 3; }

  /// `axes`, `shifts`: u, v and the normal in the shape's frame.
  void lay(const Vector (&offsets)[4], const Vector (&axes)[3], const Lanes (&shifts)[3]) {
    for (int k = 0; k < 4; ++k) {
      x[k] = axes[0].dot(offsets[k]) + shifts[0];
      y[k] = axes[1].dot(offsets[k]) + shifts[1];
      height[k] = axes[2].dot(offsets[k]) + shifts[2];
    }
    low = height[0].smaller(height[1]).smaller(height[2].smaller(height[3])) + Lanes::all(0.0);
    high = height[0].larger(height[1]).larger(height[2].larger(height[3])) + Lanes::all(0.0);
    for (int k = 0; k < 4; ++k) {
      side_x[k] = x[head(k)] - x[tail(k)];
      side_y[k] = y[head(k)] - y[tail(k)];
      length[k] = (side_x[k] * side_x[k] + side_y[k] * side_y[k]).root();
    }
  }
  void find_slope(const Vector& own, const Vector& normal, const Vector& u, const Vector& v) {
    const Lanes across = own.dot(normal);
    slope_x = negated(own.dot(u)) / across;
    slope_y = negated(own.dot(v)) / across;
  }
  void lay_over(const LaneFace& other) {
    const int base = other.forth == 0 ? 0 : 3;
    for (int k = 0; k < 4; ++k) {
      const Lanes step_x = x[k] - other.x[base], step_y = y[k] - other.y[base];
      const Lanes straight = other.height[base] + (other.slope_x * step_x + other.slope_y * step_y);
      over[k] = straight.larger(other.low).smaller(other.high);
    }
  }
};

template <class Lanes>
class FlushLanes {
 public:
  FlushLanes(const FlushQuestion& question, FlushAnswer& answer)
      : in_(question), out_(answer), frame_p_(frame(question.p)), frame_q_(frame(question.q)) {
    reversed_ = Lanes::flags(bits(question.reversed));
    good_ = every();
  }

  void solve() {
    out_.solved = out_.listed = 0;
    out_.corner_count = 0;
    find_lengths();
    place_solids();
    find_plane();
    if (good_.bits() == 0) return;
    lay_faces();
    if (!compare()) return;
    cross_sides();
    measure();
    share_out();
    prove();
    take_points();
    out_.solved = good_.bits();
  }

 private:
  using Vector = LaneVector<Lanes>;
  using Flags = typename Lanes::Flags;

  static unsigned bits(const std::array<bool, FlushRow::kPairs>& set) {
    unsigned bits = 0;
    for (unsigned k = 0; k < 4; ++k) bits |= static_cast<unsigned>(set[k]) << k;
    return bits;
  }
  static LaneFrame<Lanes> frame(const FlushSide& side) {
    return {bits(side.turned), side.linear, side.cofactors};
  }
  static Lanes all(double x) { return Lanes::all(x); }
  static Flags every() { return Lanes::flags(15); }
  static Flags unless(const Flags& flags) { return every().without(flags); }
  static Flags reaches(const Lanes& x, const Lanes& least) {  // x >= least, false for NaN
    return unless(x.below(least)) & ordered(x) & ordered(least);
  }
  static Flags ordered(const Lanes& x) { return (x - x).below(all(1.0)); }
  void need(const Flags& flags) { good_ = good_ & flags; }

  /// As lengths() and border_rounding().
  void find_lengths() {
    diameter_p_ = Lanes::of(in_.p.diameter.of);
    diameter_q_ = Lanes::of(in_.q.diameter.of);
    smaller_ = diameter_q_.smaller(diameter_p_);
    larger_ = diameter_p_.larger(diameter_q_);
    coordinate_ = Lanes::of(in_.p.coordinate.of).larger(Lanes::of(in_.q.coordinate.of));
    contact_ = in_.tolerance > 0.0 ? all(in_.tolerance)
                                   : (all(kDefaultTolerance) * smaller_)
                                         .larger(all(kLeastTolerance * kEpsilon) * coordinate_);
    rounding_ = all(kRounding * kEpsilon) * larger_;
    const Lanes place = rounding_.larger(all(kPlaceRounding * kEpsilon) * coordinate_);
    const Lanes widest = contact_.larger(place).larger(all(kClearAbove) * rounding_);
    clear_ = all(kFarBelow) * smaller_;
    need(widest.below(clear_));
    need(unless((all(kUneven) * smaller_).below(larger_)));
  }

  /// As PlacedPair.
  void place_solids() {
    const Vector b = lanes_apart<Lanes>(in_.centres_a, in_.centres_b);
    b.store(out_.between);
    const Vector low = b * all(-0.5), high = b * all(0.5);
    origin_p_ = high.where(reversed_, low);
    origin_q_ = low.where(reversed_, high);
  }

  /// Whether just the corners of a face carry the plane, all others far below, and which does.
  void find_carrier(const FlushSide& side, const Vector& base, const Vector& local, Vector& top) {
    Lanes value[4], most;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector offset = Vector::of(side.set[k]) - base;
      value[k] = offset.dot(local);
      const Flags more = k == 0 ? every() : most.below(value[k]);
      top = k == 0 ? offset : offset.where(more, top);
      most = k == 0 ? value[0] : value[k].where(more, most);
    }
    const Lanes flat = most - all(kClearBelow) * rounding_, clear = most - clear_;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector offset = Vector::of(side.others[k]) - base;
      need(unless(value[k].below(flat)));
      need(offset.dot(local).below(clear));
    }
  }

  /// The faces look at each other, carry the plane of the larger one, and no other face does.
  void find_plane() {
    const Vector own_p = Vector::of(in_.p.normal[0]), own_q = Vector::of(in_.q.normal[0]);
    normal_p_ = frame_p_.normal(own_p);
    normal_q_ = frame_q_.normal(own_q);
    need(unless(all(kTouchingOpposite).below(normal_p_.dot(normal_q_))));
    const Flags by_q = diameter_p_.below(diameter_q_);
    normal_ = (-normal_q_).where(by_q, normal_p_);
    base_p_ = Vector::of(in_.p.origin[0]);
    base_q_ = Vector::of(in_.q.origin[0]);
    Vector top_p, top_q;
    find_carrier(in_.p, base_p_, frame_p_.turned_back(normal_), top_p);
    find_carrier(in_.q, base_q_, frame_q_.turned_back(-normal_), top_q);
    high_ = frame_p_.turn(top_p) + origin_p_;
    const Vector low = frame_q_.turn(top_q) + origin_q_;
    gap_ = normal_.dot(low - high_);
    need_steep_neighbours(in_.p, own_p);
    need_steep_neighbours(in_.q, own_q);
    find_axes();
  }
  /// The plane leans by less than 2e-3 rad from either face, so no neighbour that stands more than
  /// 36 degrees off its face is within 30 degrees of the plane.
  void need_steep_neighbours(const FlushSide& side, const Vector& own) {
    constexpr double kSteep = 0.8;
    for (std::size_t k = 0; k < 4; ++k) {
      need(Vector::of(side.neighbours[k]).dot(own).below(all(kSteep)));
    }
  }
  /// As ContactPlane.
  void find_axes() {
    const Lanes x = normal_.x.size(), y = normal_.y.size(), z = normal_.z.size();
    const Flags by_y = y.below(x);
    const Lanes least = y.where(by_y, x);
    const Flags by_z = z.below(least);
    const Lanes one = all(1.0), none = all(0.0);
    const Lanes e_z = one.where(by_z, none), e_y = one.where(by_y.without(by_z), none);
    const Lanes e_x = none.where(by_y | by_z, one);
    const Vector u = normal_.cross(Vector{e_x, e_y, e_z});
    axis_u_ = u / u.dot(u).root();
    axis_v_ = normal_.cross(axis_u_);
  }

  /// As LocalPlane and LaidFace; labels have to be flat.
  void lay_face(const FlushSide& side, const LaneFrame<Lanes>& frame, const Vector& base,
                const Vector& origin, LaneFace<Lanes>& face) {
    Vector offsets[4], first;
    Lanes off_plane = all(0.0);
    const Vector own = Vector::of(side.normal[0]);
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector corner = Vector::of(side.corners[k]);
      if (k == 0) first = corner;
      off_plane = off_plane.larger(own.dot(corner - first).size());
      offsets[k] = corner - base;
    }
    need(unless((all(kFlatLabel) * border_).below(off_plane)));
    const Vector from = origin - high_;
    const Vector axes[3] = {frame.turned_back(axis_u_), frame.turned_back(axis_v_),
                            frame.turned_back(normal_)};
    const Lanes shifts[3] = {axis_u_.dot(from), axis_v_.dot(from), normal_.dot(from)};
    face.lay(offsets, axes, shifts);
  }
  void lay_faces() {
    const Lanes size = diameter_p_ + diameter_q_ + gap_.size();
    border_ =
        all(kEpsilon) * (all(kBorderSize) * size).larger(all(kBorderCoordinate) * coordinate_);
    p_.forth = 0;
    q_.forth = 1;
    lay_face(in_.p, frame_p_, base_p_, origin_p_, p_);
    lay_face(in_.q, frame_q_, base_q_, origin_q_, q_);
    p_.find_slope(normal_p_, normal_, axis_u_, axis_v_);
    q_.find_slope(normal_q_, normal_, axis_u_, axis_v_);
  }

  /// Each corner against each side, as FaceOverlay::compare. False: nothing is left to solve.
  bool compare() {
    const Lanes none = all(0.0);
    Lanes clearance = all(kInfinity), least = all(kInfinity);
    Lanes deepest_p[4], deepest_q[4];
    for (int i = 0; i < 4; ++i) {
      const Lanes slack_q = border_ * p_.length[i];
      for (int j = 0; j < 4; ++j) {
        const int tail = q_.tail(j);
        const Lanes deep_p =
            q_.side_x[j] * (p_.y[i] - q_.y[tail]) - q_.side_y[j] * (p_.x[i] - q_.x[tail]);
        const Lanes deep_q =
            p_.side_x[i] * (q_.y[j] - p_.y[i]) - p_.side_y[i] * (q_.x[j] - p_.x[i]);
        deep_[i][j] = deep_p;
        inside_p_[i][j] = none.below(deep_p);
        inside_q_[i][j] = none.below(deep_q);
        clearance = clearance.smaller(
            (deep_p.size() - border_ * q_.length[j]).smaller(deep_q.size() - slack_q));
        deepest_p[j] = i == 0 ? deep_p : deepest_p[j].larger(deep_p);
        deepest_q[i] = j == 0 ? deep_q : deepest_q[i].larger(deep_q);
      }
    }
    need(none.below(clearance));
    if (good_.bits() == 0) return false;
    for (int k = 0; k < 4; ++k) {
      least = least.smaller(deepest_p[k] / q_.length[k]).smaller(deepest_q[k] / p_.length[k]);
      covered_p_[k] = (inside_p_[k][0] & inside_p_[k][1]) & (inside_p_[k][2] & inside_p_[k][3]);
      covered_q_[k] = (inside_q_[0][k] & inside_q_[1][k]) & (inside_q_[2][k] & inside_q_[3][k]);
    }
    margin_ = least;
    return true;
  }

  /// A piece of the border on each side: P's, then Q's.
  struct Piece {
    Lanes start_x, start_y, end_x, end_y;
    Flags starts, ends;
  };

  /// A whole side. Written number by number, as it is read: copies in wide registers would wait.
  static void lay_piece(const LaneFace<Lanes>& face, int k, const Flags (&covered)[4],
                        Piece& piece) {
    const int tail = face.tail(k), head = face.head(k);
    piece.start_x = face.x[tail];
    piece.start_y = face.y[tail];
    piece.end_x = face.x[head];
    piece.end_y = face.y[head];
    piece.starts = covered[tail];
    piece.ends = covered[head];
  }

  /// As FaceOverlay::lay_sides and cross_sides.
  void cross_sides() {
    p_.lay_over(q_);
    q_.lay_over(p_);
    for (int k = 0; k < 4; ++k) {
      lay_piece(p_, k, covered_p_, pieces_[k]);
      lay_piece(q_, k, covered_q_, pieces_[4 + k]);
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const int after_j = (j + 1) & 3;
        const Flags crosses = (inside_p_[i][j] ^ inside_p_[(i + 1) & 3][j]) &
                              (inside_q_[i][j] ^ inside_q_[i][after_j]) & good_;
        if (crosses.bits() != 0) cross_side(i, j, crosses);
      }
    }
    Lanes count = all(0.0);
    for (const Piece& side : pieces_) {
      need(unless(side.starts ^ side.ends));
      count = count + all(1.0).where(side.starts, all(0.0));
    }
    need(all(2.5).below(count));
  }
  /// Whether such a crossing is no contact point is for contact_points.cpp to say. Twice as wide as
  /// there: sides are rounded in the plane.
  void need_no_parallels(int i, int j, const Flags& crosses) {
    const Lanes wide = p_.side_x[i] * q_.side_y[j] - p_.side_y[i] * q_.side_x[j];
    const Lanes limit = all(2.0) * contact_ * p_.length[i].larger(q_.length[j]);
    need(unless(crosses.without(limit.below(wide.size()))));
  }
  /// P's piece ends there and Q's starts, or the other way round.
  void cross_side(int i, int j, const Flags& crosses) {
    need_no_parallels(i, j, crosses);
    Piece &of_p = pieces_[i], &of_q = pieces_[4 + j];
    const int after_i = (i + 1) & 3, after_j = (j + 1) & 3;
    const Flags ends = inside_p_[i][j], leaves = crosses & ends, enters = crosses.without(ends);
    const Flags twice = (leaves & (of_p.ends | of_q.starts)) | (enters & (of_p.starts | of_q.ends));
    const Flags contradicted = crosses.without(inside_q_[i][after_j] ^ ends);
    need(unless(twice | contradicted));
    const Lanes share = deep_[i][j] / (deep_[i][j] - deep_[after_i][j]);
    const Lanes x = p_.x[i] + share * p_.side_x[i], y = p_.y[i] + share * p_.side_y[i];
    const int tail = q_.tail(j);
    const Lanes along = q_.side_x[j] * (x - q_.x[tail]) + q_.side_y[j] * (y - q_.y[tail]);
    const Lanes squared = q_.side_x[j] * q_.side_x[j] + q_.side_y[j] * q_.side_y[j];
    const Lanes share_q = negated(negated((along / squared).larger(all(0.0))).larger(all(-1.0)));
    FlushCorner& corner = out_.corners[static_cast<std::size_t>(out_.corner_count++)];
    corner.feature_p = {FeatureKind::Edge, i};
    corner.feature_q = {FeatureKind::Edge, j};
    corner.pairs = crosses.bits();
    x.store(corner.x.of);
    y.store(corner.y.of);
    (p_.height[i] + share * (p_.height[after_i] - p_.height[i])).store(corner.height_p.of);
    (q_.height[after_j] + share_q * (q_.height[j] - q_.height[after_j])).store(corner.height_q.of);
    of_p.ends = of_p.ends | leaves;
    of_q.starts = of_q.starts | leaves;
    of_p.starts = of_p.starts | enters;
    of_q.ends = of_q.ends | enters;
    of_p.end_x = x.where(leaves, of_p.end_x);
    of_p.end_y = y.where(leaves, of_p.end_y);
    of_q.start_x = x.where(leaves, of_q.start_x);
    of_q.start_y = y.where(leaves, of_q.start_y);
    of_p.start_x = x.where(enters, of_p.start_x);
    of_p.start_y = y.where(enters, of_p.start_y);
    of_q.end_x = x.where(enters, of_q.end_x);
    of_q.end_y = y.where(enters, of_q.end_y);
  }

  /// The sum of eight pieces in the order of FaceOverlay's lanes.
  static Lanes sum_of(const Lanes (&terms)[8]) {
    Lanes sum[4];
    for (int k = 0; k < 4; ++k) sum[k] = all(0.0) + terms[k] + terms[4 + k];
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
  }

  /// Area and centroid.
  void measure() {
    Lanes base_x = pieces_[7].start_x, base_y = pieces_[7].start_y;
    for (int k = 6; k >= 0; --k) {
      base_x = pieces_[k].start_x.where(pieces_[k].starts, base_x);
      base_y = pieces_[k].start_y.where(pieces_[k].starts, base_y);
    }
    Lanes twice[8], moment_x[8], moment_y[8];
    for (int k = 0; k < 8; ++k) {
      const Piece& piece = pieces_[k];
      const Lanes a_x = piece.start_x - base_x, a_y = piece.start_y - base_y;
      const Lanes b_x = piece.end_x - base_x, b_y = piece.end_y - base_y;
      twice[k] = (a_x * b_y - a_y * b_x).where(piece.starts, all(0.0));
      moment_x[k] = twice[k] * (a_x + b_x);
      moment_y[k] = twice[k] * (a_y + b_y);
    }
    area_ = all(0.5) * sum_of(twice);
    need(all(0.0).below(area_));
    const Lanes sixth = all(1.0) / (all(6.0) * area_);
    centroid_x_ = base_x + sixth * sum_of(moment_x);
    centroid_y_ = base_y + sixth * sum_of(moment_y);
  }

  /// The shares of the corners, and the corners of the faces.
  void share_out() {
    Lanes half[8];
    for (int k = 0; k < 8; ++k) {
      const Piece& piece = pieces_[k];
      const Lanes triangle = (piece.start_x - centroid_x_) * (piece.end_y - centroid_y_) -
                             (piece.start_y - centroid_y_) * (piece.end_x - centroid_x_);
      need(unless(piece.starts.without(all(0.0).below(triangle))));
      half[k] = all(0.25) * triangle;
    }
    const auto corners = out_.corners.begin();
    for (auto corner = corners; corner != corners + out_.corner_count; ++corner) {
      (half[corner->feature_p.index] + half[4 + corner->feature_q.index]).store(corner->share.of);
    }
    for (int k = 0; k < 4; ++k) {
      const int before = (k + 3) & 3;
      if (FlushCorner* corner = add_corner(covered_p_[k], p_, k)) {
        corner->feature_p = {FeatureKind::Vertex, k};
        corner->feature_q = {FeatureKind::Face, 0};
        p_.height[k].store(corner->height_p.of);
        p_.over[k].store(corner->height_q.of);
        (half[k] + half[before]).store(corner->share.of);
      }
      if (FlushCorner* corner = add_corner(covered_q_[k], q_, k)) {
        corner->feature_p = {FeatureKind::Face, 0};
        corner->feature_q = {FeatureKind::Vertex, k};
        q_.over[k].store(corner->height_p.of);
        q_.height[k].store(corner->height_q.of);
        (half[4 + k] + half[4 + before]).store(corner->share.of);
      }
    }
  }
  FlushCorner* add_corner(const Flags& covered, const LaneFace<Lanes>& face, int k) {
    const unsigned pairs = (covered & good_).bits();
    if (pairs == 0) return nullptr;
    FlushCorner& corner = out_.corners[static_cast<std::size_t>(out_.corner_count++)];
    corner.pairs = pairs;
    face.x[k].store(corner.x.of);
    face.y[k].store(corner.y.of);
    return &corner;
  }

  /// Wide, and the best plane of all: as WholeFaces.
  void prove() {
    need((all(8.0) * contact_ * larger_).below(area_));
    const Flags apart = (all(kApart) * rounding_).below(gap_);
    const Flags over = apart & reaches(margin_, rounding_);
    need(good_.without(apart).bits() == 0 ? over : over | shallow().without(apart));
  }
  /// As proves_shallow.
  Flags shallow() const {
    const Lanes depth = negated(gap_) * all(1.0 + kAloneShare) + all(kAlone) * rounding_;
    const Vector mean_p = frame_p_.turn(Vector::of(in_.p.mean[0]) - base_p_) + origin_p_;
    const Vector mean_q = frame_q_.turn(Vector::of(in_.q.mean[0]) - base_q_) + origin_q_;
    const Vector inner = mean_q - mean_p;
    const Lanes down = inner.dot(normal_), below = down - depth;
    const Vector beside = inner - normal_ * down;
    const Lanes aside = beside.dot(beside);
    const Lanes needed = depth * (aside.root() + (aside + below * (down + depth)).root()) / below;
    return all(0.0).below(below) & reaches(margin_, needed);
  }

  /// Are the corners the contact points as they are: of pairs within reach.
  void take_points() {
    const Lanes none = all(0.0), reach = Lanes::of(in_.reach.of);
    const Flags touching = unless(contact_.below(gap_.size()));
    const Flags listed = unless(reach.below(gap_).without(touching));
    const Lanes above = (reach - gap_).larger(none);
    const Lanes band = contact_.larger(above);
    Lanes lowest = all(kInfinity), highest = all(-kInfinity);
    for (int k = 0; k < out_.corner_count; ++k) {
      const FlushCorner& corner = out_.corners[static_cast<std::size_t>(k)];
      const Flags here = Lanes::flags(corner.pairs);
      const Lanes gap = Lanes::of(corner.height_q.of) - Lanes::of(corner.height_p.of);
      lowest = lowest.smaller(gap).where(here, lowest);
      highest = highest.larger(gap).where(here, highest);
    }
    const Flags settled = unless(clear_.below(band))
                              .without((gap_ + band).below(highest))
                              .without((gap_ + border_).below(lowest));
    need(settled | unless(listed));
    out_.listed = listed.bits();
    gap_.store(out_.gap.of);
    contact_.store(out_.tolerance.of);
    high_.store(out_.origin);
    normal_.store(out_.normal);
    axis_u_.store(out_.axis_u);
    axis_v_.store(out_.axis_v);
  }

  const FlushQuestion& in_;
  FlushAnswer& out_;
  const LaneFrame<Lanes> frame_p_, frame_q_;
  Flags reversed_, good_;
  Lanes diameter_p_, diameter_q_, smaller_, larger_, coordinate_;  // m
  Lanes contact_, rounding_, clear_, border_;                      // m
  Vector base_p_, base_q_, origin_p_, origin_q_, normal_p_, normal_q_, normal_, high_;
  Vector axis_u_, axis_v_;
  Lanes gap_, margin_, area_, centroid_x_, centroid_y_;
  LaneFace<Lanes> p_, q_;
  Lanes deep_[4][4];                       // P's corners inside Q's sides, times length
  Flags inside_p_[4][4], inside_q_[4][4];  // P's corner i in Q's side j; Q's j in P's i
  Flags covered_p_[4], covered_q_[4];
  Piece pieces_[8];
};

}  // namespace
}  // namespace quoin::geometry
