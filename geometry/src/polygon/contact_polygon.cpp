#include "polygon/contact_polygon.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/double_double.hpp"
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
