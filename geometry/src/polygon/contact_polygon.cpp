#include "polygon/contact_polygon.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "numeric/double_double.hpp"
#include "numeric/error_bounds.hpp"
#include "polygon/clip.hpp"
#include "polygon/cross2.hpp"

namespace quoin::geometry {
namespace {

/// Height of a polygon over a place that it covers: a mean of its corners' heights, hence between
/// them, however badly the slope of a sliver is known.
double height_over(const PolygonRows& polygon, double x, double y) {
  const double height = polygon.height[0] + (polygon.slope_x * (x - polygon.x[0]) +
                                             polygon.slope_y * (y - polygon.y[0]));
  return std::clamp(height, polygon.low, polygon.high);
}

/// The corners of one polygon against the sides of the other, one bit each.
struct Corners {
  const PolygonRows& rows;
  const SideMasks& masks;

  /// The lines through sides of the other that side i crosses.
  std::uint64_t crossed(int i) const {
    const int next = rows.next(i);
    return (masks.inside[i] & masks.outside[next]) | (masks.outside[i] & masks.inside[next]);
  }
};

/// Where side i of P crosses side j of Q, as a share of the way along P's.
double crossing_share(const PolygonRows& p, int i, const PolygonRows& q, int j) {
  const auto inside = [&](int corner) {
    return q.side_x[j] * (p.y[corner] - q.y[j]) - q.side_y[j] * (p.x[corner] - q.x[j]);
  };
  const double a = inside(i), b = inside(p.next(i));
  return a / (a - b);
}

/// Is a place that is in doubt on a polygon, or beside it within rounding? At the tip of a needle
/// it may lie within rounding of the lines of two sides and far beyond both of them; and the line
/// of a short side is not known far away from it. So distances are those from the sides themselves,
/// and inside is where a ray along x meets an odd number of sides.
bool is_beside(const PolygonRows& polygon, const Vector2& place, double rounding) {
  const double limit = kBesideBorder * rounding;
  bool inside = false;
  for (int j = 0; j < polygon.count; ++j) {
    const Vector2 side(polygon.side_x[j], polygon.side_y[j]);
    const Vector2 step(place.x() - polygon.x[j], place.y() - polygon.y[j]);
    const double squared = side.squaredNorm();
    const double along = squared > 0.0 ? std::clamp(side.dot(step) / squared, 0.0, 1.0) : 0.0;
    if ((step - along * side).squaredNorm() <= limit * limit) return true;
    const bool rises = polygon.y[polygon.next(j)] > place.y();
    if (rises != (polygon.y[j] > place.y())) inside ^= (cross2(side, step) > 0.0) == rises;
  }
  return inside;
}

/// Does a place lie beyond the line of one of these sides by more than the line may be off there?
bool is_outside(const PolygonRows& polygon, std::uint64_t sides, const Vector2& place,
                double rounding) {
  for (; sides != 0; sides &= sides - 1) {
    const int j = std::countr_zero(sides);
    const Vector2 side(polygon.side_x[j], polygon.side_y[j]);
    const Vector2 step(place.x() - polygon.x[j], place.y() - polygon.y[j]);
    if (cross2(side, step) < -rounding * (std::abs(step.x()) + std::abs(step.y()))) return true;
  }
  return false;
}

/// Two polygons over each other, and where their shared corners go.
struct Clip {
  const Corners p, q;
  const double rounding;
  SharedCorners& corners;

  /// Does a polygon cover corner i of the other one?
  bool covers(const PolygonRows& polygon, const Corners& other, int i) const {
    const std::uint64_t all = (std::uint64_t{1} << polygon.count) - 1;
    if ((other.masks.inside[i] & all) == all) return true;
    const Vector2 place(other.rows.x[i], other.rows.y[i]);
    return !is_outside(polygon, other.masks.outside[i], place, rounding) &&
           is_beside(polygon, place, rounding);
  }
  void add_corner_of_p(int i) const {
    const PolygonRows& rows = p.rows;
    SharedCorner& corner = corners.add();
    corner.place = {rows.x[i], rows.y[i]};
    corner.height_p = rows.height[i];
    corner.height_q = height_over(q.rows, rows.x[i], rows.y[i]);
    corner.feature_p = {FeatureKind::Vertex, rows.vertex[i]};
    corner.feature_q = {FeatureKind::Face, q.rows.face};
    corner.share = 0.0;
  }
  void add_corner_of_q(int j) const {
    const PolygonRows& rows = q.rows;
    SharedCorner& corner = corners.add();
    corner.place = {rows.x[j], rows.y[j]};
    corner.height_p = height_over(p.rows, rows.x[j], rows.y[j]);
    corner.height_q = rows.height[j];
    corner.feature_p = {FeatureKind::Face, p.rows.face};
    corner.feature_q = {FeatureKind::Vertex, rows.vertex[j]};
    corner.share = 0.0;
  }
  /// Nearly parallel sides cross in an ill-conditioned place: Q's height is taken there, not where
  /// its own crossing would be.
  void add_crossing(int i, int j, double share) const {
    const PolygonRows &a = p.rows, &b = q.rows;
    const double x = a.x[i] + share * a.side_x[i], y = a.y[i] + share * a.side_y[i];
    const double along = b.side_x[j] * (x - b.x[j]) + b.side_y[j] * (y - b.y[j]);
    const double squared = b.side_x[j] * b.side_x[j] + b.side_y[j] * b.side_y[j];
    const double share_q = std::clamp(along / squared, 0.0, 1.0);
    SharedCorner& corner = corners.add();
    corner.place = {x, y};
    corner.height_p = a.height[i] + share * (a.height[a.next(i)] - a.height[i]);
    corner.height_q = b.height[j] + share_q * (b.height[b.next(j)] - b.height[j]);
    corner.feature_p = {FeatureKind::Edge, a.edge[i]};
    corner.feature_q = {FeatureKind::Edge, b.edge[j]};
    corner.share = 0.0;
  }

  /// The sides of Q that side i of P crosses, in their inner parts.
  std::uint64_t crossings(int i) const {
    std::uint64_t found = 0;
    for (std::uint64_t lines = p.crossed(i); lines != 0; lines &= lines - 1) {
      const int j = std::countr_zero(lines);
      found |= (q.crossed(j) >> i & 1) << j;
    }
    return found;
  }

  /// P's corners, Q's corners, crossings.
  void append() const {
    for (int i = 0; i < p.rows.count; ++i) {
      if (covers(q.rows, p, i)) add_corner_of_p(i);
    }
    for (int j = 0; j < q.rows.count; ++j) {
      if (covers(p.rows, q, j)) add_corner_of_q(j);
    }
    for (int i = 0; i < p.rows.count; ++i) {
      for (std::uint64_t found = crossings(i); found != 0; found &= found - 1) {
        const int j = std::countr_zero(found);
        add_crossing(i, j, crossing_share(p.rows, i, q.rows, j));
      }
    }
  }
};

}  // namespace

/// Q's faces look the other way and run backwards.
bool lay_face(const Solid& polyhedron, int face, const ContactPlane& plane, double outward,
              PolygonRows& rows) {
  const std::span<const int> cycle = polyhedron.topology().face(face);
  const std::span<const int> edges = polyhedron.topology().face_edges(face);
  if (cycle.size() > PolygonRows::kMost) return false;
  rows.count = static_cast<int>(cycle.size());
  rows.face = face;
  const int last = rows.count - 1;
  for (int k = 0; k <= last; ++k) {
    const int corner = outward > 0.0 ? k : last - k;
    const int side = outward > 0.0 ? k : (k < last ? last - 1 - k : last);
    rows.vertex[k] = cycle[static_cast<std::size_t>(corner)];
    rows.edge[k] = edges[static_cast<std::size_t>(side)];
  }
  lay_corners(polyhedron, plane, rows);
  const Vector3 normal = polyhedron.face_normal(face);
  const double across = normal.dot(plane.normal);
  constexpr double kUpright = 1e-3;  // a face seen from its edge has no slope
  const bool upright = std::abs(across) < kUpright;
  rows.slope_x = upright ? 0.0 : -normal.dot(plane.axis_u) / across;
  rows.slope_y = upright ? 0.0 : -normal.dot(plane.axis_v) / across;
  return true;
}

namespace {

/// Area, centroid and shares of a polygon whose order is known.
void measure(const SmallVector<int, 32>& order, SharedCorners& corners, SharedPolygon& polygon) {
  const auto corner = [&](std::size_t k) -> SharedCorner& {
    return corners[static_cast<std::size_t>(order[k])];
  };
  const auto place = [&](std::size_t k) -> const Vector2& { return corner(k).place; };
  const std::size_t n = order.size();
  for (SharedCorner& c : corners) c.share = 0.0;
  polygon.area = 0.0;
  polygon.centroid.setZero();
  if (n == 0) return;
  const Vector2 base = place(0);
  Vector2 moment = Vector2::Zero();
  for (std::size_t k = 2; k < n; ++k) {
    const Vector2 a = place(k - 1) - base, b = place(k) - base;
    const double twice = std::max(0.0, cross2(a, b));  // negative by rounding alone
    polygon.area += 0.5 * twice;
    moment += twice / 6.0 * (a + b);
  }
  if (!(polygon.area > 0.0)) {
    for (std::size_t k = 0; k < n; ++k) polygon.centroid += place(k) / static_cast<double>(n);
    polygon.area = 0.0;
    return;
  }
  polygon.centroid = base + moment / polygon.area;
  // Half of each triangle (centroid, corner, next corner) to either corner: since the centroid of
  // the polygon is the area-weighted mean of the triangles' centroids, the shares have its first
  // moment.
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t next = k + 1 < n ? k + 1 : 0;
    const double half = 0.25 * cross2(place(k) - polygon.centroid, place(next) - polygon.centroid);
    corner(k).share += half;
    corner(next).share += half;
  }
}

/// Does a place lie to the left of the way from `a` to `b`? Exact but for the last of 106 bits: of
/// places that are one but for rounding each lies to either side of what the others span, and a
/// chain of turns that rounding has told wrongly goes to and fro.
bool is_left(const Vector2& a, const Vector2& b, const Vector2& place) {
  const Vector2 u = b - a, v = place - a;
  const double first = u.x() * v.y(), second = u.y() * v.x(), rough = first - second;
  if (place == b || (first == 0.0 && second == 0.0)) return false;  // no turn at all
  const double size = (std::abs(u.x()) + std::abs(u.y())) * (std::abs(v.x()) + std::abs(v.y()));
  if (std::abs(rough) > kTurnRounding * kEpsilon * size) return rough > 0.0;
  const DoubleDouble product = two_difference(b.x(), a.x()) * two_difference(place.y(), a.y());
  return (product - two_difference(b.y(), a.y()) * two_difference(place.x(), a.x())).high > 0.0;
}

}  // namespace

void hull_order(std::span<const Vector2> places, SmallVector<int, 32>& order) {
  const auto at = [&](int i) -> const Vector2& { return places[static_cast<std::size_t>(i)]; };
  const auto before = [&](int i, int j) {
    const Vector2 &a = at(i), &b = at(j);
    return a.x() != b.x() ? a.x() < b.x() : (a.y() != b.y() ? a.y() < b.y() : i < j);
  };
  order.clear();
  if (places.size() <= 2) {
    for (std::size_t i = 0; i < places.size(); ++i) order.push_back(static_cast<int>(i));
    if (places.size() == 2 && before(1, 0)) std::swap(order[0], order[1]);
    return;
  }
  SmallVector<int, 32> sorted;
  sorted.resize(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) sorted[i] = static_cast<int>(i);
  std::sort(sorted.begin(), sorted.end(), before);
  const auto add = [&](int i, std::size_t floor) {
    std::size_t size = order.size();
    while (size >= floor + 2 && !is_left(at(order[size - 2]), at(order[size - 1]), at(i))) --size;
    order.resize(size);
    order.push_back(i);
  };
  for (const int i : sorted) add(i, 0);
  order.resize(order.size() - 1);
  const std::size_t floor = order.size();
  for (std::size_t k = places.size(); k-- > 0;) add(sorted[k], floor);
  order.resize(order.size() - 1);
  if (order.empty()) order.push_back(sorted[0]);
}

void find_order(const SharedCorners& corners, SmallVector<int, 32>& order) {
  SmallVector<Vector2, 32> places;
  for (const SharedCorner& corner : corners) places.push_back(corner.place);
  hull_order(places, order);
}

void find_polygon(SharedCorners& corners, SharedPolygon& polygon) {
  SmallVector<int, 32> order;
  find_order(corners, order);
  measure(order, corners, polygon);
}

void find_polygon(ContactPolygon& part) {
  if (!part.measured) find_polygon(part.corners, part.polygon);
}

double append_shared_of_polygons(const PolygonRows& p, const PolygonRows& q, double rounding,
                                 SharedCorners& corners) {
  SideMasks of_p, of_q;
  find_side_masks(p, q, rounding, of_p, of_q);
  const Clip clip{{p, of_p}, {q, of_q}, rounding, corners};
  clip.append();
  return std::min(of_p.margin, of_q.margin);
}

bool lay_faces(const Solid& p, const Solid& q, double gap, ContactPolygon& part) {
  const double rounding = border_rounding(p, q, gap);
  part.measured = overlay_faces(p, q, rounding, part);
  if (part.measured) return true;
  part.corners.clear();
  PolygonRows rows_p, rows_q;
  if (!lay_face(p, part.face_p, part.plane, 1.0, rows_p) ||
      !lay_face(q, part.face_q, part.plane, -1.0, rows_q)) {
    return false;
  }
  part.margin = append_shared_of_polygons(rows_p, rows_q, rounding, part.corners);
  return true;
}

double border_rounding(const Solid& p, const Solid& q, double gap) {
  const double size = p.diameter() + q.diameter() + std::abs(gap);
  const double coordinate = std::max(p.largest_coordinate(), q.largest_coordinate());
  return std::numeric_limits<double>::epsilon() *
         std::max(kBorderSize * size, kBorderCoordinate * coordinate);
}

}  // namespace quoin::geometry
