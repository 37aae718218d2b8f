#include "contact/joint_section.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "contact/joint_area.hpp"

namespace quoin::solver {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// Of the area of the corners' bounding circle: less is a line.
constexpr double kLeastSection = 1e-9;

/// Of their convex hull, counter-clockwise: arms from `middle`.
std::vector<Vector2d> around(std::span<const Vector2d> places, const Vector2d& middle) {
  std::vector<Vector2d> arms, hull;
  for (const Vector2d& place : places) arms.push_back(place - middle);
  std::ranges::sort(arms, {}, [](const Vector2d& p) { return std::pair(p.x(), p.y()); });
  for (const bool back : {false, true}) {  // below, then above
    const std::size_t first = hull.size() + 1;
    for (const Vector2d& arm : arms) {
      while (hull.size() > first &&
             !(cross(hull.back() - hull[hull.size() - 2], arm - hull.back()) > 0.0))
        hull.pop_back();
      hull.push_back(arm);
    }
    hull.pop_back();  // the other one begins with it
    if (!back) std::ranges::reverse(arms);
  }
  return hull;
}

}  // namespace

std::optional<JointSection> joint_section(std::span<const Vector2d> places) {
  if (places.size() < 3) return std::nullopt;
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& place : places) middle += place / static_cast<double>(places.size());
  const std::vector<Vector2d> arms = around(places, middle);
  JointSection section;
  Vector2d first = Vector2d::Zero();
  Matrix2d second = Matrix2d::Zero();
  double radius = 0.0;
  for (std::size_t i = 0; i < arms.size(); ++i) {
    // The triangle of the middle and one side.
    const Vector2d &p = arms[i], &q = arms[(i + 1) % arms.size()];
    const double area = 0.5 * cross(p, q);
    const Vector2d sum = p + q;
    section.area += area;
    first += area / 3.0 * sum;
    second += area / 12.0 * (p * p.transpose() + q * q.transpose() + sum * sum.transpose());
    radius = std::max(radius, p.norm());
  }
  if (!(section.area > kLeastSection * radius * radius)) return std::nullopt;
  const Vector2d centroid = first / section.area;
  section.centroid = middle + centroid;
  section.second_moment = second - section.area * centroid * centroid.transpose();
  return section;
}

double mean_distance(std::span<const Vector2d> places, const Vector2d& from) {
  double distance = 0.0, area = 0.0;
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& place : places) middle += place / static_cast<double>(places.size());
  const std::vector<Vector2d> arms = around(places, middle);
  for (std::size_t i = 0; i < arms.size(); ++i) {  // the triangle of the place and one side
    const Vector2d p = middle + arms[i] - from, q = middle + arms[(i + 1) % arms.size()] - from;
    const Vector2d side = (q - p).normalized();
    const double height = cross(p, side);  // of it, on its side
    area += 0.5 * cross(p, q);
    if (height == 0.0) continue;
    const auto integral = [&](double s) {  // of the distance along the side
      return 0.5 * (s * std::hypot(height, s) + height * height * std::asinh(s / std::abs(height)));
    };
    distance += height / 3.0 * (integral(q.dot(side)) - integral(p.dot(side)));
  }
  return distance / area;
}

std::vector<double> section_stress(const JointSection& section, std::span<const Vector2d> places,
                                   std::span<const double> pull) {
  double force = 0.0;
  Vector2d moment = Vector2d::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    force += pull[i];
    moment += pull[i] * (places[i] - section.centroid);
  }
  const Vector2d gradient = section.second_moment.inverse() * moment;
  std::vector<double> stress;
  for (const Vector2d& place : places)
    stress.push_back(force / section.area + gradient.dot(place - section.centroid));
  return stress;
}

}  // namespace quoin::solver
