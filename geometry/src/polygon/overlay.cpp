#include "polygon/overlay.hpp"

#include <cmath>

#include "numeric/floating_point.hpp"
#include "polygon/cross2.hpp"

namespace quoin::geometry {
namespace {

/// Up to so many pairs of sides, all are compared: their table needs no heap.
constexpr std::size_t kFewPairs = 128;
/// Up to so many corners, the farthest is sought among all.
constexpr std::size_t kFewCorners = 8;

/// From corner k of a laid feature to the next; an edge has two sides, to and fro, a vertex one
/// without length.
struct LaidSide {
  Vector2 from, line;
  double length;     // m
  double low, high;  // its extent along u, m
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
  const double squared = side.length * side.length;
  const double along = squared > 0.0 ? std::clamp(side.line.dot(step) / squared, 0.0, 1.0) : 0.0;
  return (step - along * side.line).squaredNorm();
}

/// A laid feature against another one.
struct Laid {
  const ProjectedFeature& feature;
  double beside;                              // so near to a side counts as on it, m
  double low = kInfinity, high = -kInfinity;  // least and greatest height
  double extent = 0.0;                        // no coordinate of a corner is larger, m
  Sides sides;
  Standings standings;  // of its corners, against the other

  Laid(const ProjectedFeature& laid, double rounding)
      : feature(laid), beside(is_polygon() ? kBesideBorder * rounding : rounding) {
    const std::size_t n = feature.corners.size();
    sides.resize(n);
    standings.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      const ProjectedCorner& corner = feature.corners[k];
      extent = std::max(extent, corner.place.cwiseAbs().maxCoeff());
      low = std::min(low, corner.height);
      high = std::max(high, corner.height);
      standings[k] = {};
      LaidSide& side = sides[k];
      side.from = corner.place;
      side.line = feature.corners[next(k)].place - corner.place;
      side.length = side.line.norm();
      const double end = feature.corners[next(k)].place.x();
      side.low = std::min(corner.place.x(), end) - kBesideBorder * rounding;
      side.high = std::max(corner.place.x(), end);
    }
  }
  bool is_polygon() const { return feature.corners.size() > 2; }
  std::size_t next(std::size_t k) const { return k + 1 < feature.corners.size() ? k + 1 : 0; }
  const Vector2& place(std::size_t k) const { return feature.corners[k].place; }
  /// The sides that may cross others: of an edge the one, of a vertex none.
  std::size_t crossing_sides() const { return is_polygon() ? sides.size() : sides.size() - 1; }
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

struct Crossing {
  std::size_t i, j;
  double share;  // of the way along P's side
};

/// Two laid features over each other. Only sides whose extents along u meet are compared: others
/// neither cross, nor come near each other's ends, nor lie below them.
class Overlay {
 public:
  Overlay(const ProjectedFeature& p, const ProjectedFeature& q, double rounding)
      : p_(p, rounding), q_(q, rounding), rounding_(rounding) {
    polygons_ = p_.is_polygon() && q_.is_polygon();
    if (p_.sides.size() * q_.sides.size() <= kFewPairs) {
      compare_all();
    } else {
      sweep();
    }
  }

  void append(SharedCorners& corners) const {
    for (std::size_t i = 0; i < p_.sides.size(); ++i) {
      if (q_.covers(p_.standings[i])) add_corner_of_p(i, corners);
    }
    for (std::size_t j = 0; j < q_.sides.size(); ++j) {
      if (p_.covers(q_.standings[j])) add_corner_of_q(j, corners);
    }
    for (const Crossing& crossing : crossings_) add_crossing(crossing, corners);
  }

 private:
  /// All corners of one against all sides of the other, which clear ones need alone.
  void compare_all() {
    SmallVector<double, kFewPairs> turns_p, turns_q;  // of corner k against side l: k * sides + l
    stand(q_, p_, turns_p);
    stand(p_, q_, turns_q);
    const std::size_t n = p_.sides.size(), m = q_.sides.size();
    for (std::size_t i = 0; i < p_.crossing_sides(); ++i) {
      for (std::size_t j = 0; j < q_.crossing_sides(); ++j) {
        add_if_crossed(i, j, turns_p[i * m + j], turns_p[p_.next(i) * m + j], turns_q[j * n + i],
                       turns_q[q_.next(j) * n + i]);
      }
    }
  }
  void stand(const Laid& on, Laid& corners, SmallVector<double, kFewPairs>& turns) const {
    const std::size_t count = on.sides.size();
    const double span = 2.0 * (on.extent + corners.extent);  // no step is longer
    turns.resize(corners.sides.size() * count);
    for (std::size_t k = 0; k < corners.sides.size(); ++k) {
      const Vector2& at = corners.place(k);
      double inside = kInfinity, outside = kInfinity;
      for (std::size_t l = 0; l < count; ++l) {
        const LaidSide& side = on.sides[l];
        const double turned = turns[k * count + l] = turn(side, at);
        inside = std::min(inside, turned - on.beside * side.length);
        outside = std::min(outside, turned + rounding_ * std::max(side.length, span));
      }
      Standing& standing = corners.standings[k];
      standing.within = inside > 0.0;
      standing.outside = polygons_ && outside < 0.0;
      if (standing.within || standing.outside) continue;
      for (std::size_t l = 0; l < count; ++l) {
        place(on.sides[l], on.place(on.next(l)), at, turns[k * count + l], on.beside, standing);
      }
    }
  }

  /// Along u: a side that begins is compared with those of the other that have not ended.
  void sweep() {
    SmallVector<std::size_t, 64> order_p, order_q, open_p, open_q;
    sort_by_begin(p_.sides, order_p);
    sort_by_begin(q_.sides, order_q);
    for (std::size_t i = 0, j = 0; i < order_p.size() || j < order_q.size();) {
      const bool of_p = j == order_q.size() || (i < order_p.size() && p_.sides[order_p[i]].low <=
                                                                          q_.sides[order_q[j]].low);
      if (of_p) {
        const std::size_t side = order_p[i++];
        drop_ended(q_.sides, p_.sides[side].low, open_q);
        for (const std::size_t other : open_q) compare(side, other);
        open_p.push_back(side);
      } else {
        const std::size_t side = order_q[j++];
        drop_ended(p_.sides, q_.sides[side].low, open_p);
        for (const std::size_t other : open_p) compare(other, side);
        open_q.push_back(side);
      }
    }
    std::sort(crossings_.begin(), crossings_.end(), [](const Crossing& x, const Crossing& y) {
      return std::pair(x.i, x.j) < std::pair(y.i, y.j);
    });
  }
  static void sort_by_begin(const Sides& sides, SmallVector<std::size_t, 64>& order) {
    for (std::size_t k = 0; k < sides.size(); ++k) order.push_back(k);
    std::sort(order.begin(), order.end(), [&](std::size_t k, std::size_t l) {
      return std::pair(sides[k].low, k) < std::pair(sides[l].low, l);
    });
  }
  static void drop_ended(const Sides& sides, double low, SmallVector<std::size_t, 64>& open) {
    std::size_t kept = 0;
    for (const std::size_t k : open) {
      if (sides[k].high >= low) open[kept++] = k;
    }
    open.resize(kept);
  }

  void compare(std::size_t i, std::size_t j) {
    const LaidSide &s = p_.sides[i], &t = q_.sides[j];
    const Vector2 &p_end = p_.place(p_.next(i)), &q_end = q_.place(q_.next(j));
    const double p_from = turn(t, s.from), q_from = turn(s, t.from);
    place(t, q_end, s.from, p_from, q_.beside, p_.standings[i]);
    place(s, p_end, t.from, q_from, p_.beside, q_.standings[j]);
    add_if_crossed(i, j, p_from, turn(t, p_end), q_from, turn(s, q_end));
  }
  /// `p_from`: turn of the first end of P's side against Q's, and so on.
  void add_if_crossed(std::size_t i, std::size_t j, double p_from, double p_to, double q_from,
                      double q_to) {
    if (!parts(p_from, p_to, rounding_ * q_.sides[j].length)) return;
    if (!parts(q_from, q_to, rounding_ * p_.sides[i].length)) return;
    crossings_.push_back({i, j, p_from / (p_from - p_to)});
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
    corners.push_back({corner.place,
                       corner.height,
                       q_.height_over(corner.place),
                       {FeatureKind::Vertex, corner.vertex},
                       {FeatureKind::Face, q_.feature.face}});
  }
  void add_corner_of_q(std::size_t j, SharedCorners& corners) const {
    const ProjectedCorner& corner = q_.feature.corners[j];
    corners.push_back({corner.place,
                       p_.height_over(corner.place),
                       corner.height,
                       {FeatureKind::Face, p_.feature.face},
                       {FeatureKind::Vertex, corner.vertex}});
  }
  /// Nearly parallel sides cross in an ill-conditioned place: Q's height is taken there, not where
  /// its own crossing would be.
  void add_crossing(const Crossing& at, SharedCorners& corners) const {
    const ProjectedCorner &from = p_.feature.corners[at.i], &to = p_.feature.corners[p_.next(at.i)];
    const Vector2 place = from.place + at.share * (to.place - from.place);
    corners.push_back({place,
                       from.height + at.share * (to.height - from.height),
                       q_.height_along(at.j, place),
                       {FeatureKind::Edge, from.edge},
                       {FeatureKind::Edge, q_.feature.corners[at.j].edge}});
  }

  Laid p_, q_;
  double rounding_;
  bool polygons_ = false;
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
    return std::sqrt(squared_distance({first, line, line.norm(), 0.0, 0.0}, place - first));
  }
  double worst = 0.0;
  for (std::size_t k = 0; k < patch.corners.size(); ++k) {
    worst = std::max(worst, -inside(patch, k, place));
  }
  return worst;
}

}  // namespace

void append_shared_corners(const ProjectedFeature& p, const ProjectedFeature& q, double rounding,
                           SharedCorners& corners) {
  Overlay(p, q, rounding).append(corners);
}

double overlap_margin(const ProjectedFeature& p, const ProjectedFeature& q) {
  if (p.corners.size() == 1 && q.corners.size() == 1) {
    return -(p.corners[0].place - q.corners[0].place).norm();
  }
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
