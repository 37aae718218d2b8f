#include "contact/contact_patch.hpp"

#include <algorithm>
#include <cmath>

#include "polygon/contact_plane.hpp"

namespace quoin::geometry {
namespace {

/// The place on a side that is nearest to a place.
Vector2 foot_on_side(const Vector2& from, const Vector2& to, const Vector2& place) {
  const Vector2 side = to - from;
  const double squared = side.squaredNorm();
  const double share = squared > 0.0 ? std::clamp(side.dot(place - from) / squared, 0.0, 1.0) : 0.0;
  return from + share * side;
}

double distance_to_side(const Vector2& from, const Vector2& to, const Vector2& place) {
  return (place - foot_on_side(from, to, place)).norm();
}

std::size_t nearest_corner(const ProjectedFeature& patch, const Vector2& place) {
  const auto squared = [&](const ProjectedCorner& c) { return (c.place - place).squaredNorm(); };
  const auto nearest = std::min_element(
      patch.corners.begin(), patch.corners.end(),
      [&](const ProjectedCorner& c, const ProjectedCorner& d) { return squared(c) < squared(d); });
  return static_cast<std::size_t>(nearest - patch.corners.begin());
}

/// The edges that may name a place on the border of a support polygon, the best first: its own,
/// those around the nearest corners, those of its face.
void find_names(const Solid& solid, const ProjectedFeature& patch, const Feature& own,
                const Vector2& place, SmallVector<int, 32>& names) {
  const Topology& topology = solid.topology();
  const auto add = [&](std::span<const int> edges) {
    for (const int e : edges)
      if (!names.contains(e)) names.push_back(e);
  };
  if (own.kind == FeatureKind::Edge && own.index >= 0) names.push_back(own.index);
  const std::size_t k = nearest_corner(patch, place);
  add(topology.vertex_edges(patch.corners[k].vertex));
  add(topology.vertex_edges(patch.corners[(k + 1) % patch.corners.size()].vertex));
  add(topology.face_edges(patch.face));
}

/// The contact plane as one of the solids sees it.
struct SeenPlane {
  const ContactPlane& plane;
  double outward;  ///< +1 for P, -1 for Q
};

/// Sine of the angle between a face and the contact plane; of one that looks away without limit.
double lean(const Solid& solid, int face, const SeenPlane& seen) {
  const Vector3 normal = solid.face_normal(face);
  if (!(seen.outward * normal.dot(seen.plane.normal) > 0.0)) return kInfinity;
  return normal.cross(seen.plane.normal).norm();
}

/// Faces that a place may lie on instead of the one that names it. What is found of a face is kept
/// for the next place on it.
class LeastLeaning {
 public:
  LeastLeaning(const Solid& solid, const SeenPlane& seen, double tolerance)
      : solid_(solid), seen_(seen), tolerance_(tolerance) {}

  /// From face to face as long as the next one leans less: around a vertex there may be several.
  int of(int face, const Vector2& place) {
    for (int last = -1; last != face;) {
      last = face;
      face = less_leaning_beside(face, place);
    }
    return face;
  }

 private:
  struct Beside {
    int face;
    double lean;
    Vector2 from, to;  // of the edge between
  };

  /// Of the faces across edges within the tolerance of a place on `face` the one that leans least,
  /// if it leans less than that one itself.
  int less_leaning_beside(int face, const Vector2& place) {
    if (face != known_) find_beside(face);
    double least = kInfinity;
    int best = face;
    for (const Beside& beside : beside_) {
      if (!(beside.lean < least)) continue;
      if (distance_to_side(beside.from, beside.to, place) > tolerance_) continue;
      least = beside.lean;
      best = beside.face;
    }
    return best;
  }
  void find_beside(int face) {
    constexpr double kAlike = 1e-9;  // normals are right to a few eps
    known_ = face;
    beside_.clear();
    const double own = lean(solid_, face, seen_) - kAlike;
    if (!(own > 0.0)) return;
    const Topology& topology = solid_.topology();
    const std::span<const int> edges = topology.face_edges(face);
    const std::span<const int> across = topology.face_neighbours(face);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const double beside = lean(solid_, across[i], seen_);
      if (!(beside < own)) continue;
      const auto [from, to] = topology.edge(edges[i]);
      beside_.push_back({across[i], beside, seen_.plane.place(solid_.vertex(from)),
                         seen_.plane.place(solid_.vertex(to))});
    }
  }

  const Solid& solid_;
  SeenPlane seen_;
  double tolerance_;
  int known_ = -1;
  SmallVector<Beside, 8> beside_;
};

/// Where a ray from a place along `way` leaves the convex hull of the points: on the side between
/// two of them, by a share of the way from the one to the other, and how far away, in units of
/// `way`.
struct Exit {
  int from = -1, to = -1;
  double share = 0.0, distance = kInfinity;
};

/// The side whose ends lie on either side of the ray, the end on its left. Told by the ends and not
/// by the lines through the sides: those of sides that are collinear but for rounding are left at
/// the same distance.
Exit exit_of(const Vector2& start, const Vector2& way, const SharedCorners& points,
             const SmallVector<int, 32>& order) {
  Exit exit;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const int from = order[k], to = order[k + 1 < order.size() ? k + 1 : 0];
    const Vector2& first = points[static_cast<std::size_t>(from)].place;
    const Vector2& last = points[static_cast<std::size_t>(to)].place;
    const double right = -cross2(way, first - start), left = cross2(way, last - start);
    if (!(right >= 0.0 && left > 0.0)) continue;
    const double share = right / (right + left);
    const Vector2 step = first + share * (last - first) - start;
    exit = {from, to, share, way.dot(step) / way.squaredNorm()};
  }
  return exit;
}

/// Where the polygon's centroid lies outside the hull of the points, as of slivers: all of the area
/// goes to the ends of the side next to it. False: it lies inside.
bool share_by_side(const SharedPolygon& polygon, const SmallVector<int, 32>& order,
                   SharedCorners& points) {
  const Vector2& place = polygon.centroid;
  bool inside = order.size() > 2;
  double nearest = kInfinity;
  std::size_t first = 0, last = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto from = static_cast<std::size_t>(order[k]);
    const auto to = static_cast<std::size_t>(order[k + 1 < order.size() ? k + 1 : 0]);
    const double distance = distance_to_side(points[from].place, points[to].place, place);
    inside =
        inside && cross2(points[to].place - points[from].place, place - points[from].place) > 0.0;
    if (!(distance < nearest)) continue;
    nearest = distance;
    first = from;
    last = to;
  }
  if (inside) return false;
  if (first == last) return true;
  const Vector2 side = points[last].place - points[first].place;
  const double share =
      std::clamp(side.dot(place - points[first].place) / side.squaredNorm(), 0.0, 1.0);
  for (SharedCorner& c : points) c.share = 0.0;
  points[first].share = (1.0 - share) * polygon.area;
  points[last].share = share * polygon.area;
  return true;
}

}  // namespace

bool is_free(const Feature& feature_p, const Feature& feature_q, const SharedCorners& points) {
  return std::none_of(points.begin(), points.end(), [&](const SharedCorner& point) {
    return point.feature_p == feature_p && point.feature_q == feature_q;
  });
}

void Surfaces::lift(SharedCorners& corners) const {
  for (SharedCorner& c : corners) {
    if (c.feature_p.kind != FeatureKind::Vertex) c.height_p = p.height(c.place, c.height_p);
    if (c.feature_q.kind != FeatureKind::Vertex) c.height_q = q.height(c.place, c.height_q);
  }
}

bool Surfaces::lift(SharedCorner& c) const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (c.feature_p.kind != FeatureKind::Vertex) c.height_p = p.height(c.place, kNone);
  if (c.feature_q.kind != FeatureKind::Vertex) c.height_q = q.height(c.place, kNone);
  return !std::isnan(c.height_p) && !std::isnan(c.height_q);
}

bool find_shared_stretch(const ProjectedFeature& edge, const ProjectedFeature& other,
                         double rounding, std::array<Vector2, 2>& ends) {
  const Vector2& base = edge.corners[0].place;
  const Vector2 line = edge.corners[1].place - base;
  const double squared = line.squaredNorm();
  const auto share = [&](const ProjectedCorner& c) { return line.dot(c.place - base) / squared; };
  const auto [first, last] = std::minmax({share(other.corners[0]), share(other.corners[1])});
  const double low = std::clamp(first, 0.0, 1.0), high = std::clamp(last, 0.0, 1.0);
  const double beyond = std::max(first - 1.0, -last);
  const auto midway = [&](double at) {
    const Vector2 place = base + at * line;
    return Vector2(0.5 *
                   (place + foot_on_side(other.corners[0].place, other.corners[1].place, place)));
  };
  ends = {midway(low), midway(high)};
  return !(beyond > 0.0) || beyond * beyond * squared <= rounding * rounding;
}

double height_along(const ProjectedFeature& edge, const Vector2& place) {
  const ProjectedCorner &from = edge.corners[0], &to = edge.corners[1];
  const Vector2 line = to.place - from.place;
  const double share = std::clamp(line.dot(place - from.place) / line.squaredNorm(), 0.0, 1.0);
  return from.height + share * (to.height - from.height);
}

void name_least_leaning(const Solid& solid, const ContactPlane& plane, double outward,
                        double tolerance, SharedCorners& corners) {
  LeastLeaning least(solid, {plane, outward}, tolerance);
  for (SharedCorner& c : corners) {
    Feature& feature = outward > 0.0 ? c.feature_p : c.feature_q;
    if (feature.kind == FeatureKind::Face) feature.index = least.of(feature.index, c.place);
  }
}

bool name_cut(const Solid& p, const Solid& q, const ProjectedFeature& patch_p,
              const ProjectedFeature& patch_q, const SharedCorners& points, SharedCorner& corner) {
  SmallVector<int, 32> names_p, names_q;
  find_names(p, patch_p, corner.feature_p, corner.place, names_p);
  find_names(q, patch_q, corner.feature_q, corner.place, names_q);
  for (const int e : names_p) {
    for (const int f : names_q) {
      const Feature feature_p{FeatureKind::Edge, e}, feature_q{FeatureKind::Edge, f};
      if (!is_free(feature_p, feature_q, points)) continue;
      corner.feature_p = feature_p;
      corner.feature_q = feature_q;
      return true;
    }
  }
  return false;
}

bool near_segment(const Vector2& from, const Vector2& to, const Vector2& place, double tolerance) {
  return distance_to_side(from, to, place) <= tolerance;
}

bool near_hull(const SharedCorners& points, const Vector2& place, double tolerance) {
  SmallVector<int, 32> order;
  find_order(points, order);
  bool inside = order.size() > 2;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const int after = order[k + 1 < order.size() ? k + 1 : 0];
    const Vector2& from = points[static_cast<std::size_t>(order[k])].place;
    const Vector2& to = points[static_cast<std::size_t>(after)].place;
    if (distance_to_side(from, to, place) <= tolerance) return true;
    inside = inside && cross2(to - from, place - from) > 0.0;
  }
  return inside;
}

bool well_inside(const SharedCorners& points, const SmallVector<int, 32>& order,
                 const Vector2& place, double tolerance) {
  bool inside = order.size() > 2;
  for (std::size_t k = 0; k < order.size() && inside; ++k) {
    const int after = order[k + 1 < order.size() ? k + 1 : 0];
    const Vector2& from = points[static_cast<std::size_t>(order[k])].place;
    const Vector2 side = points[static_cast<std::size_t>(after)].place - from;
    inside = cross2(side, place - from) > tolerance * side.norm();
  }
  return inside;
}

SharedCorner nearest_in_hull(const SharedCorners& corners, const Vector2& place) {
  const auto nearer = [&](const SharedCorner& c, const SharedCorner& d) {
    return (c.place - place).squaredNorm() < (d.place - place).squaredNorm();
  };
  constexpr Feature kNone{FeatureKind::Edge, -1};
  SharedCorner best = *std::min_element(corners.begin(), corners.end(), nearer);
  SmallVector<int, 32> order;
  find_order(corners, order);
  bool inside = order.size() > 2;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const int after = order[k + 1 < order.size() ? k + 1 : 0];
    const Vector2& from = corners[static_cast<std::size_t>(order[k])].place;
    const Vector2& to = corners[static_cast<std::size_t>(after)].place;
    const SharedCorner foot{foot_on_side(from, to, place), 0.0, 0.0, kNone, kNone};
    if (nearer(foot, best)) best = foot;
    inside = inside && cross2(to - from, place - from) > 0.0;
  }
  return inside ? SharedCorner{place, 0.0, 0.0, kNone, kNone} : best;
}

void balance_shares(const SharedPolygon& polygon, SharedCorners& points) {
  if (points.size() < 2 || !(polygon.area > 0.0)) return;
  Vector2 moment = Vector2::Zero();
  for (const SharedCorner& c : points) moment += c.share * (c.place - polygon.centroid);
  const Vector2 centroid = polygon.centroid + moment / polygon.area;
  const Vector2 way = polygon.centroid - centroid;
  if (way == Vector2::Zero()) return;
  SmallVector<int, 32> order;
  find_order(points, order);
  if (share_by_side(polygon, order, points)) return;
  const Exit exit = exit_of(centroid, way, points, order);
  if (exit.from < 0) return;
  const double moved = exit.distance > 1.0 ? 1.0 / exit.distance : 1.0;
  for (SharedCorner& c : points) c.share *= 1.0 - moved;
  points[static_cast<std::size_t>(exit.from)].share += moved * (1.0 - exit.share) * polygon.area;
  points[static_cast<std::size_t>(exit.to)].share += moved * exit.share * polygon.area;
}

}  // namespace quoin::geometry
