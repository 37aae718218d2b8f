#include "polygon/contact_polygon.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/error_bounds.hpp"
#include "polygon/contact_plane.hpp"
#include "polygon/overlay.hpp"

namespace quoin::geometry {
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

/// Does a way turn left, beyond what rounding can do?
bool turns_clearly_left(const Vector2& a, const Vector2& b, const Vector2& c) {
  const Vector2 u = b - a, v = c - a;
  const double size = (std::abs(u.x()) + std::abs(u.y())) * (std::abs(v.x()) + std::abs(v.y()));
  return cross2(u, v) > kTurnRounding * kEpsilon * size;
}

/// Do the corners go once round a convex polygon, beyond doubt? From the one that hull_order()
/// begins with.
bool find_given_order(const SharedCorners& corners, SmallVector<int, 32>& order) {
  const std::size_t n = corners.size();
  if (n < 3) return false;
  const auto after = [n](std::size_t k) { return k + 1 < n ? k + 1 : 0; };
  const auto before = [](const Vector2& u, const Vector2& v) {
    return u.x() != v.x() ? u.x() < v.x() : u.y() < v.y();
  };
  std::size_t first = n;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t l = after(k);
    const Vector2 &a = corners[k].place, &b = corners[l].place, &c = corners[after(l)].place;
    if (!turns_clearly_left(a, b, c)) return false;
    if (!before(b, a) || !before(b, c)) continue;
    if (first < n) return false;
    first = l;
  }
  if (first == n) return false;
  order.resize(n);
  for (std::size_t k = 0; k < n; ++k, first = after(first)) order[k] = static_cast<int>(first);
  return true;
}

}  // namespace

void find_order(const SharedCorners& corners, SmallVector<int, 32>& order) {
  if (find_given_order(corners, order)) return;
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
  if (part.measured) return;
  SmallVector<int, 32> order;
  find_order(part.corners, order);
  measure(order, part.corners, part.polygon);
  part.measured = true;
  part.convex = !order.empty() && order.size() == part.corners.size();
}

void lay_faces(const Solid& p, const Solid& q, double gap, ContactPolygon& part) {
  ProjectedFeature patch_p, patch_q;
  lay_feature(p, {FeatureKind::Face, part.face_p}, part.plane, 1.0, patch_p);
  lay_feature(q, {FeatureKind::Face, part.face_q}, part.plane, -1.0, patch_q);
  part.corners.clear();
  part.measured = false;
  part.margin = lay_over(patch_p, patch_q, border_rounding(p, q, gap), part.corners);
}

double border_rounding(const Solid& p, const Solid& q, double gap) {
  const double size = p.diameter() + q.diameter() + std::abs(gap);
  const double coordinate = std::max(p.largest_coordinate(), q.largest_coordinate());
  return kEpsilon * std::max(kBorderSize * size, kBorderCoordinate * coordinate);
}

}  // namespace quoin::geometry
