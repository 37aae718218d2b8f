#include "polygon/overlay.hpp"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "numeric/floating_point.hpp"
#include "polygon/contact_plane.hpp"

namespace quoin::geometry {
namespace {

/// Up to so many sides, those that a corner lies left of are bits of a number.
constexpr std::size_t kTableSides = 64;
/// Of eps times the size of what is laid: by less a table of turns is off.
constexpr double kTableRounding = 8.0;
/// Up to so many corners, the farthest is sought among all.
constexpr std::size_t kFewCorners = 8;

/// From corner k of a laid feature to the next; an edge has two sides, to and fro, a vertex one
/// without length.
struct LaidSide {
  Vector2 from, line;
  double length = 0.0;  // m; once measured
};
using Sides = SmallVector<LaidSide, 32>;

/// What the sides of a polygon say of a place.
struct Standing {
  bool within = false;   // an odd number of sides lies below it
  bool beside = false;   // it lies on a side, or beside one within rounding
  bool outside = false;  // it lies beyond the line of a side by more than that may be off there
};
using Standings = SmallVector<Standing, 32>;

double squared_distance(const LaidSide& side, const Vector2& step) {
  const double squared = side.line.squaredNorm();
  const double along = squared > 0.0 ? std::clamp(side.line.dot(step) / squared, 0.0, 1.0) : 0.0;
  return (step - along * side.line).squaredNorm();
}

/// A laid feature against another one.
struct Laid {
  const ProjectedFeature& feature;
  double beside;                              // so near to a side counts as on it, m
  double low = kInfinity, high = -kInfinity;  // least and greatest height
  double extent;                              // no coordinate of a corner is larger, m
  Sides sides;

  Laid(const ProjectedFeature& laid, double rounding)
      : feature(laid), beside(is_polygon() ? kBesideBorder * rounding : rounding) {
    const std::size_t n = feature.corners.size();
    sides.resize(n);
    Vector2 most = Vector2::Zero();
    const ProjectedCorner* corner = feature.corners.begin();
    for (LaidSide& side : sides) {
      side.from = corner->place;
      most = most.cwiseMax(side.from.cwiseAbs());
      low = corner->height < low ? corner->height : low;
      high = corner->height > high ? corner->height : high;
      ++corner;
      side.line = (corner == feature.corners.end() ? place(0) : corner->place) - side.from;
    }
    extent = most.maxCoeff();
  }
  void measure() {
    for (LaidSide& side : sides) side.length = side.line.norm();
  }
  std::size_t size() const { return sides.size(); }
  bool is_polygon() const { return feature.corners.size() > 2; }
  std::size_t next(std::size_t k) const { return k + 1 < feature.corners.size() ? k + 1 : 0; }
  const Vector2& place(std::size_t k) const { return feature.corners[k].place; }
  bool covers(const Standing& corner) const {
    return corner.beside ? !corner.outside : is_polygon() && corner.within && !corner.outside;
  }
  /// Of an edge at the foot of a place that it covers; else a mean of the corners' heights, hence
  /// between them, however badly the slope of a sliver is known.
  double height_over(const Vector2& at) const {
    if (feature.corners.size() != 2) return std::clamp(feature.surface_height(at), low, high);
    return height_along(0, at);
  }
  double height_along(std::size_t k, const Vector2& at) const {
    const double squared = sides[k].line.squaredNorm();
    const double along = sides[k].line.dot(at - sides[k].from) / squared;
    const double share = squared > 0.0 ? std::clamp(along, 0.0, 1.0) : 0.0;
    return feature.corners[k].height +
           share * (feature.corners[next(k)].height - feature.corners[k].height);
  }
};

/// Twice the area that a place spans with a side, positive to the left.
double turn(const LaidSide& side, const Vector2& place) {
  return cross2(side.line, place - side.from);
}

/// What a length is divided by instead of 0, m.
constexpr double kShortestSide = std::numeric_limits<double>::min();

using Two = double __attribute__((vector_size(16)));

/// A bit for each number above its limit.
unsigned above(const Two& numbers, const Two& limits) {
#ifdef __SSE2__
  return static_cast<unsigned>(_mm_movemask_pd(_mm_cmpgt_pd(numbers, limits)));
#else
  const auto flags = numbers > limits;  // -1 or 0 each
  return static_cast<unsigned>((flags[0] & 1) | (flags[1] & 2));
#endif
}

/// The corners of a polygon against all sides of another one, of at most 64.
struct Table {
  SmallVector<std::uint64_t, 32> left;  // of corner k: a bit for each side that it lies left of
  std::uint64_t all = 0;                // the bits of a corner inside
  bool clear = true;          // each corner lies off the line of each side by more than the slack
  double margin = kInfinity;  // m, least over the sides of how far the farthest corner lies inside

  Table(const Laid& corners, const Laid& on, double slack) : all(~0ull >> (64 - on.size())) {
    left.resize(corners.size());
    std::fill(left.begin(), left.end(), 0);
    // No side, and no step from it, is longer than three times the extents.
    const double off = slack * 3.0 * (on.extent + corners.extent);
    for (std::size_t first = 0; first < on.size(); first += 2) stand(corners, on, off, first);
  }

 private:
  /// Against two sides; the last one stands for one that is none.
  void stand(const Laid& corners, const Laid& on, double slack, std::size_t first) {
    const LaidSide &s = on.sides[first], &t = on.sides[std::min(first + 1, on.size() - 1)];
    const Two line_x{s.line.x(), t.line.x()}, line_y{s.line.y(), t.line.y()};
    const Two base{cross2(s.line, s.from), cross2(t.line, t.from)};
    const Two off{slack, slack};
    Two farthest{-kInfinity, -kInfinity};
    unsigned off_lines = 3;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vector2& at = corners.place(k);
      const Two turned = line_x * Two{at.y(), at.y()} - line_y * Two{at.x(), at.x()} - base;
      farthest = turned > farthest ? turned : farthest;
      const unsigned inside = above(turned, off);
      off_lines &= inside | above(-off, turned);
      left[k] |= static_cast<std::uint64_t>(inside) << first;
    }
    clear = clear && off_lines == 3u;
    margin = std::min(margin, std::min(farthest[0] / std::max(s.line.norm(), kShortestSide),
                                       farthest[1] / std::max(t.line.norm(), kShortestSide)));
  }
};

struct Crossing {
  std::size_t i, j;
  double share;  // of the way along P's side
};

/// Two laid features over each other.
class Overlay {
 public:
  Overlay(const ProjectedFeature& p, const ProjectedFeature& q, double rounding)
      : p_(p, rounding), q_(q, rounding), rounding_(rounding) {}

  /// Returns how far they reach over each other (overlap_margin) where that is known, else NaN.
  double append(SharedCorners& corners) {
    if (polygons_ && std::max(p_.size(), q_.size()) <= kTableSides) {
      const double least = kTableRounding * kEpsilon * (p_.extent + q_.extent);
      const double slack = std::max(kBesideBorder * rounding_, least);
      const Table of_p(p_, q_, slack), of_q(q_, p_, slack);
      (of_p.clear && of_q.clear) ? walk(of_p, of_q, corners) : compare(corners);
      return std::min(of_p.margin, of_q.margin);
    }
    compare(corners);
    return std::numeric_limits<double>::quiet_NaN();
  }

 private:
  /// Where rounding decides nothing: round P's border, and round Q's where P's is outside. In the
  /// order of the border if both are convex.
  void walk(const Table& of_p, const Table& of_q, SharedCorners& corners) const {
    std::uint64_t shown = 0;  // of Q's corners
    const auto add_from = [&](std::size_t j) {
      for (; (of_q.left[j] & of_q.all) == of_q.all && (shown >> j & 1) == 0; j = q_.next(j)) {
        shown |= std::uint64_t{1} << j;
        add_corner_of_q(j, corners);
      }
    };
    for (std::size_t i = 0; i < p_.size(); ++i) {
      const std::size_t after = p_.next(i);
      const std::uint64_t from = of_p.left[i] & of_p.all, to = of_p.left[after] & of_p.all;
      if (from == of_p.all) add_corner_of_p(i, corners);
      const auto add_crossings = [&](std::uint64_t passed, bool leaves) {
        for (; passed != 0; passed &= passed - 1) {
          const auto j = static_cast<std::size_t>(std::countr_zero(passed));
          if (((of_q.left[j] ^ of_q.left[q_.next(j)]) >> i & 1) == 0) continue;
          const double here = turn(q_.sides[j], p_.place(i)),
                       there = turn(q_.sides[j], p_.place(after));
          add_crossing({i, j, here / (here - there)}, corners);
          if (leaves) add_from(q_.next(j));
        }
      };
      add_crossings(~from & to, false);
      add_crossings(from & ~to, true);
    }
    for (std::size_t j = 0; j < q_.size(); ++j) add_from(j);
  }

  /// Side by side.
  void compare(SharedCorners& corners) {
    p_.measure();
    q_.measure();
    stand_p_.resize(p_.size());
    stand_q_.resize(q_.size());
    std::fill(stand_p_.begin(), stand_p_.end(), Standing{});
    std::fill(stand_q_.begin(), stand_q_.end(), Standing{});
    sweep();
    for (std::size_t i = 0; i < p_.size(); ++i)
      if (q_.covers(stand_p_[i])) add_corner_of_p(i, corners);
    for (std::size_t j = 0; j < q_.size(); ++j)
      if (p_.covers(stand_q_[j])) add_corner_of_q(j, corners);
    for (const Crossing& crossing : crossings_) add_crossing(crossing, corners);
  }

  /// The extent of a side along u: only sides whose extents meet are compared. Others neither
  /// cross, nor come near each other's ends, nor lie below them.
  struct Extent {
    double low, high;
  };
  using Extents = SmallVector<Extent, 32>;
  void find_extents(const Laid& laid, Extents& extents) const {
    for (const LaidSide& side : laid.sides) {
      const auto [low, high] = std::minmax({side.from.x(), side.from.x() + side.line.x()});
      extents.push_back({low - 2.0 * kBesideBorder * rounding_, high});
    }
  }
  /// Along u: a side that begins is compared with those of the other that have not ended.
  void sweep() {
    Extents of_p, of_q;
    find_extents(p_, of_p);
    find_extents(q_, of_q);
    SmallVector<std::size_t, 64> order_p, order_q, open_p, open_q;
    sort_by_begin(of_p, order_p);
    sort_by_begin(of_q, order_q);
    for (std::size_t i = 0, j = 0; i < order_p.size() || j < order_q.size();) {
      const bool takes_p = j == order_q.size() ||
                           (i < order_p.size() && of_p[order_p[i]].low <= of_q[order_q[j]].low);
      if (takes_p) {
        const std::size_t side = order_p[i++];
        drop_ended(of_q, of_p[side].low, open_q);
        for (const std::size_t other : open_q) compare(side, other);
        open_p.push_back(side);
      } else {
        const std::size_t side = order_q[j++];
        drop_ended(of_p, of_q[side].low, open_p);
        for (const std::size_t other : open_p) compare(other, side);
        open_q.push_back(side);
      }
    }
    std::sort(crossings_.begin(), crossings_.end(), [](const Crossing& x, const Crossing& y) {
      return std::pair(x.i, x.j) < std::pair(y.i, y.j);
    });
  }
  static void sort_by_begin(const Extents& sides, SmallVector<std::size_t, 64>& order) {
    for (std::size_t k = 0; k < sides.size(); ++k) order.push_back(k);
    std::sort(order.begin(), order.end(), [&](std::size_t k, std::size_t l) {
      return std::pair(sides[k].low, k) < std::pair(sides[l].low, l);
    });
  }
  static void drop_ended(const Extents& sides, double low, SmallVector<std::size_t, 64>& open) {
    std::size_t kept = 0;
    for (const std::size_t k : open)
      if (sides[k].high >= low) open[kept++] = k;
    open.resize(kept);
  }

  void compare(std::size_t i, std::size_t j) {
    const LaidSide &s = p_.sides[i], &t = q_.sides[j];
    const Vector2 &p_end = p_.place(p_.next(i)), &q_end = q_.place(q_.next(j));
    const double p_from = turn(t, s.from), q_from = turn(s, t.from);
    place(t, q_end, s.from, p_from, q_.beside, stand_p_[i]);
    place(s, p_end, t.from, q_from, p_.beside, stand_q_[j]);
    const bool sides = i < crossing_sides(p_) && j < crossing_sides(q_);
    if (!sides) return;
    const double p_to = turn(t, p_end);
    if (!parts(p_from, p_to, rounding_ * t.length)) return;
    if (!parts(q_from, turn(s, q_end), rounding_ * s.length)) return;
    crossings_.push_back({i, j, p_from / (p_from - p_to)});
  }
  /// The sides that may cross others: of an edge the one, of a vertex none.
  static std::size_t crossing_sides(const Laid& laid) {
    return laid.is_polygon() ? laid.size() : laid.size() - 1;
  }
  /// Do both ends of a side lie on different sides of a line, by more than `slack`?
  static bool parts(double from, double to, double slack) {
    return std::min(from, to) < -slack && std::max(from, to) > slack;
  }
  /// Distances are those from the sides themselves: at the tip of a needle a place may lie within
  /// rounding of the lines of two sides and far beyond both, and the line of a short side is not
  /// known far away from it.
  void place(const LaidSide& side, const Vector2& to, const Vector2& at, double turned,
             double beside, Standing& standing) const {
    if (standing.outside) return;
    if (!(turned > beside * side.length)) {
      const Vector2 step = at - side.from;
      const double off = std::max(side.length, std::abs(step.x()) + std::abs(step.y()));
      if (polygons_ && turned < -rounding_ * off) {
        standing.outside = true;
        return;
      }
      standing.beside = standing.beside || squared_distance(side, step) <= beside * beside;
    }
    const bool rises = to.x() > at.x();
    if (rises != (side.from.x() > at.x())) standing.within ^= (turned > 0.0) == rises;
  }

  void add_corner_of_p(std::size_t i, SharedCorners& corners) const {
    const ProjectedCorner& corner = p_.feature.corners[i];
    corners.add() = {corner.place,
                     corner.height,
                     q_.height_over(corner.place),
                     {FeatureKind::Vertex, corner.vertex},
                     {FeatureKind::Face, q_.feature.face}};
  }
  void add_corner_of_q(std::size_t j, SharedCorners& corners) const {
    const ProjectedCorner& corner = q_.feature.corners[j];
    corners.add() = {corner.place,
                     p_.height_over(corner.place),
                     corner.height,
                     {FeatureKind::Face, p_.feature.face},
                     {FeatureKind::Vertex, corner.vertex}};
  }
  /// Nearly parallel sides cross in an ill-conditioned place: Q's height is taken there, not where
  /// its own crossing would be.
  void add_crossing(const Crossing& at, SharedCorners& corners) const {
    const ProjectedCorner &from = p_.feature.corners[at.i], &to = p_.feature.corners[p_.next(at.i)];
    const LaidSide &s = p_.sides[at.i], &t = q_.sides[at.j];
    const Vector2 place = from.place + at.share * s.line;
    corners.add() = {place,
                     from.height + at.share * (to.height - from.height),
                     q_.height_along(at.j, place),
                     {FeatureKind::Edge, from.edge},
                     {FeatureKind::Edge, q_.feature.corners[at.j].edge},
                     std::abs(cross2(s.line, t.line)) /
                         std::sqrt(std::max(s.line.squaredNorm(), t.line.squaredNorm()))};
  }

  Laid p_, q_;
  double rounding_;
  bool polygons_ = p_.is_polygon() && q_.is_polygon();
  Standings stand_p_, stand_q_;  // of the corners, against the other
  SmallVector<Crossing, 32> crossings_;
};

/// Signed distance of a place from the line through side k of a polygon, inside positive.
double inside(const ProjectedFeature& patch, std::size_t k, const Vector2& place) {
  const Vector2& from = patch.corners[k].place;
  const Vector2 side = patch.corners[k + 1 < patch.corners.size() ? k + 1 : 0].place - from;
  const double length = side.norm();
  return length > 0.0 ? cross2(side, place - from) / length : 0.0;
}

/// How far the other patch reaches past either end of an edge, inwards: two edges of one line can
/// be apart along it alone.
double reach_along(const ProjectedFeature& edge, const ProjectedFeature& other) {
  const Vector2 &first = edge.corners[0].place, &last = edge.corners[1].place;
  const Vector2 direction = (last - first).normalized();
  double past_first = -kInfinity, past_last = -kInfinity;
  for (const ProjectedCorner& c : other.corners) {
    past_first = std::max(past_first, (c.place - first).dot(direction));
    past_last = std::max(past_last, (last - c.place).dot(direction));
  }
  return std::min(past_first, past_last);
}

/// The corner of a patch farthest inside a side, from a corner that is so for the side before: the
/// next ones, as long as they lie no less far inside. Stopped early by a corner that rounding has
/// put too far out it tells too little, by that rounding.
class FarthestInside {
 public:
  FarthestInside(const ProjectedFeature& patch, const ProjectedFeature& other)
      : patch_(patch), other_(other) {}
  double operator()(std::size_t k) {
    const Vector2& from = patch_.corners[k].place;
    const Vector2 side = patch_.corners[k + 1 < patch_.corners.size() ? k + 1 : 0].place - from;
    const double length = side.norm();
    const auto inside = [&](std::size_t i) { return cross2(side, other_.corners[i].place - from); };
    const std::size_t count = other_.corners.size();
    double farthest = inside(at_);
    const bool all = k == 0 || count <= kFewCorners || !(length > 0.0);
    std::size_t i = at_;
    for (std::size_t step = 1; step < count; ++step) {
      i = i + 1 < count ? i + 1 : 0;
      const double here = inside(i);
      if (here >= farthest) {
        farthest = here;
        at_ = i;
      } else if (!all) {
        break;
      }
    }
    return length > 0.0 ? farthest / length : 0.0;
  }

 private:
  const ProjectedFeature &patch_, &other_;
  std::size_t at_ = 0;
};

/// Least over the sides of a patch (an edge has two) of how far the other reaches inside it.
double reach_inside(const ProjectedFeature& patch, const ProjectedFeature& other) {
  double least = kInfinity;
  if (patch.corners.size() < 2) return least;
  FarthestInside farthest(patch, other);
  for (std::size_t k = 0; k < patch.corners.size(); ++k) least = std::min(least, farthest(k));
  return patch.corners.size() == 2 ? std::min(least, reach_along(patch, other)) : least;
}

/// How far outside a patch a place lies: of a polygon, its lines.
double outside(const ProjectedFeature& patch, const Vector2& place) {
  const Vector2& first = patch.corners[0].place;
  if (patch.corners.size() <= 2) {
    const Vector2 line = patch.corners[patch.corners.size() - 1].place - first;
    return std::sqrt(squared_distance({first, line}, place - first));
  }
  double worst = 0.0;
  for (std::size_t k = 0; k < patch.corners.size(); ++k)
    worst = std::max(worst, -inside(patch, k, place));
  return worst;
}

}  // namespace

void append_shared_corners(const ProjectedFeature& p, const ProjectedFeature& q, double rounding,
                           SharedCorners& corners) {
  Overlay(p, q, rounding).append(corners);
}

double lay_over(const ProjectedFeature& p, const ProjectedFeature& q, double rounding,
                SharedCorners& corners) {
  const double margin = Overlay(p, q, rounding).append(corners);
  return std::isnan(margin) ? overlap_margin(p, q) : margin;
}

double overlap_margin(const ProjectedFeature& p, const ProjectedFeature& q) {
  if (p.corners.size() == 1 && q.corners.size() == 1)
    return -(p.corners[0].place - q.corners[0].place).norm();
  return std::min(reach_inside(p, q), reach_inside(q, p));
}

Vector2 nearest_place(const ProjectedFeature& p, const ProjectedFeature& q) {
  Vector2 best = p.corners[0].place;
  double least = kInfinity;
  const auto compare = [&](const ProjectedFeature& corners, const ProjectedFeature& patch) {
    for (const ProjectedCorner& c : corners.corners) {
      const double distance = outside(patch, c.place);
      if (distance >= least) continue;
      least = distance;
      best = c.place;
    }
  };
  compare(p, q);
  compare(q, p);
  return best;
}

}  // namespace quoin::geometry
