#include "scene_file/no_tension.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

namespace quoin::scene_file {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Counter-clockwise, without corners on a side [Andrew 1979].
std::vector<Vector2d> convex_polygon(std::vector<Vector2d> points) {
  std::ranges::sort(points, [](const Vector2d& a, const Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Vector2d> hull;
  const auto chain = [&](auto from, auto to) {
    const std::size_t start = hull.size();
    for (; from != to; ++from) {
      while (hull.size() >= start + 2 &&
             cross(hull.back() - hull[hull.size() - 2], *from - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(*from);
    }
    hull.pop_back();
  };
  if (points.size() < 3) return {};
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
  return hull;
}

/// The corners as (1, x, y); of a polygon the part where `plane` is positive.
std::vector<Vector3d> bearing_part(const std::vector<Vector3d>& polygon, const Vector3d& plane) {
  std::vector<Vector3d> part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d &from = polygon[i], &to = polygon[(i + 1) % polygon.size()];
    const double at_from = plane.dot(from), at_to = plane.dot(to);
    if (at_from >= 0) part.push_back(from);
    if ((at_from > 0 && at_to < 0) || (at_from < 0 && at_to > 0))
      part.emplace_back(from + at_from / (at_from - at_to) * (to - from));
  }
  return part;
}

/// Integral of p p' over a polygon of corners p = (1, x, y).
Matrix3d moments(const std::vector<Vector3d>& polygon) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Vector3d &a = polygon[0], &b = polygon[i - 1], &c = polygon[i];
    const double area = 0.5 * cross((b - a).tail<2>(), (c - a).tail<2>());
    const Vector3d all = a + b + c;
    sum += area / 12 *
           (a * a.transpose() + b * b.transpose() + c * c.transpose() + all * all.transpose());
  }
  return sum;
}

/// Newton's method on the convex function int max(0, c p)^2 / 2 - c p0, whose gradient is zero
/// where the pressure c p has a unit resultant at p0: each step solves for the part that bears.
std::optional<Vector3d> unit_pressure(const std::vector<Vector3d>& polygon, const Vector3d& p0) {
  constexpr int kMost = 100;
  const auto value = [&](const Vector3d& c) {
    return 0.5 * c.dot(moments(bearing_part(polygon, c)) * c) - c.dot(p0);
  };
  Vector3d c = moments(polygon).ldlt().solve(p0);
  for (int i = 0; i < kMost; ++i) {
    const std::vector<Vector3d> part = bearing_part(polygon, c);
    const Vector3d next = moments(part).ldlt().solve(p0);
    if (!next.allFinite()) return {};
    if ((next - c).norm() <= 1e-12 * next.norm()) return next;
    double step = 1.0;
    while (step > 1e-6 && !(value(c + step * (next - c)) < value(c))) step *= 0.5;
    if (step <= 1e-6)  // the value is the least within rounding, or there is none
      return (next - c).norm() <= 1e-6 * next.norm() ? std::optional(next) : std::nullopt;
    c += step * (next - c);
  }
  return {};
}

}  // namespace

std::optional<double> no_tension_edge_stress(std::span<const Vector2d> corners,
                                             const Vector2d& centre, double force) {
  const std::vector<Vector2d> hull = convex_polygon({corners.begin(), corners.end()});
  if (hull.size() < 3 || !(force > 0)) return {};
  Vector2d low = hull[0], high = hull[0];
  for (const Vector2d& corner : hull) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const double size = (high - low).norm();
  std::vector<Vector3d> polygon;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d along = hull[(i + 1) % hull.size()] - hull[i];
    if (!(cross(along, centre - hull[i]) > 1e-6 * size * along.norm())) return {};
    polygon.emplace_back(1.0, (hull[i] - centre).x() / size, (hull[i] - centre).y() / size);
  }
  const std::optional<Vector3d> pressure = unit_pressure(polygon, Vector3d::UnitX());
  if (!pressure) return {};
  double largest = 0.0;
  for (const Vector3d& corner : polygon) largest = std::max(largest, pressure->dot(corner));
  return largest * force / (size * size);
}

}  // namespace quoin::scene_file
