#include "numeric/plane.hpp"

#include <cmath>

#include "numeric/double_double.hpp"
#include "numeric/error_bounds.hpp"

namespace quoin::geometry {
namespace {

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

ContactPlane::ContactPlane(const Vector3& origin_in, const Vector3& normal_in)
    : origin(origin_in), normal(normal_in) {
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(normal[i]) < std::abs(normal[k])) k = i;
  axis_u = normal.cross(Vector3::Unit(k)).normalized();
  axis_v = normal.cross(axis_u);
}

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

}  // namespace quoin::geometry
