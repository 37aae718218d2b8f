#include "contact/outer_surface.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/floating_point.hpp"
#include "polygon/contact_plane.hpp"
#include "polygon/contact_polygon.hpp"

namespace quoin::geometry {
namespace {

/// Rise over run of the steepest triangle that is believed: on steeper ones a place a few roundings
/// (1e-15 D) aside lies farther below than tol (1e-9 D). Heights are means of those of vertices, so
/// what is not known of a steep one's is along it, and never above it.
constexpr double kSteep = 1e6;

}  // namespace

OuterSurface::OuterSurface(const Solid& solid, const ContactPlane& plane, double outward,
                           double depth, double rounding)
    : outward_(outward), rounding_(kBesideBorder * rounding) {
  const LocalPlane local(solid, plane);
  const std::size_t count = static_cast<std::size_t>(solid.vertex_count());
  places_.resize(count);
  heights_.resize(count);
  SmallVector<char, 32> used;
  used.resize(count);
  double top = -kInfinity;
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3 x = solid.shape().vertex(static_cast<int>(v));
    places_[v] = local.place(x);
    heights_[v] = outward * local.height(x);
    top = std::max(top, heights_[v]);
    used[v] = 0;
  }
  for (Triangle t : solid.topology().triangles()) {
    const auto height = [&](std::size_t k) { return heights_[static_cast<std::size_t>(t[k])]; };
    if (std::max({height(0), height(1), height(2)}) < top - depth) continue;
    if (outward < 0.0) std::swap(t[1], t[2]);
    if (!faces(t)) continue;
    triangles_.push_back(t);
    for (const int v : t) used[static_cast<std::size_t>(v)] = 1;
  }
  for (std::size_t v = 0; v < count; ++v)
    if (used[v] != 0) corners_.push_back(static_cast<int>(v));
}

double OuterSurface::height(const Vector2& place, double otherwise) const {
  Triangle best{};
  double height = -kInfinity;
  for (const Triangle& t : triangles_) {
    const Cover here = cover(t, place);
    if (!here.found || here.height <= height) continue;
    height = here.height;
    best = t;
  }
  if (height == -kInfinity) return otherwise;
  while (raise(best, place, height)) {
  }
  return outward_ * height;
}

bool OuterSurface::faces(const Triangle& t) const {
  const auto height = [&](std::size_t k) { return heights_[static_cast<std::size_t>(t[k])]; };
  const Vector2 u = at(t[1]) - at(t[0]), v = at(t[2]) - at(t[0]);
  const double area = cross2(u, v), rise_u = height(1) - height(0), rise_v = height(2) - height(0);
  return area > 0.0 && (rise_u * v - rise_v * u).squaredNorm() <= kSteep * kSteep * area * area;
}

/// The areas opposite to the corners are the shares of their heights, as seen from the place: those
/// of a needle would drown in the rounding of its length otherwise. Shares are kept between 0 and
/// 1, and the place that they then stand for must be this one within rounding.
OuterSurface::Cover OuterSurface::cover(const Triangle& t, const Vector2& place) const {
  const std::array<Vector2, 3> step{at(t[0]) - place, at(t[1]) - place, at(t[2]) - place};
  double sum = 0.0, height = 0.0;
  Vector2 covered = Vector2::Zero();
  bool inside = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const double area = cross2(step[(k + 1) % 3], step[(k + 2) % 3]);
    const double opposite = std::max(0.0, area);
    inside = inside && area > 0.0;
    sum += opposite;
    height += opposite * heights_[static_cast<std::size_t>(t[k])];
    covered += opposite * step[k];
  }
  const double limit = rounding_ * sum;
  if (sum > 0.0 && covered.squaredNorm() <= limit * limit) return {true, height / sum};
  if (inside) return {true, needle_height(t, step)};
  return cover_side(t, step);
}

/// Over a place inside a needle, where rounding moves along it what shares by areas stand for: the
/// share of the corner beyond the longest side by distances from that side, but no more than leaves
/// the place between the ends; and along the side by lengths. Between the heights of the corners
/// however little the first is known.
double OuterSurface::needle_height(const Triangle& t, const std::array<Vector2, 3>& step) const {
  std::size_t from = 0;
  const auto side_at = [&](std::size_t k) -> Vector2 { return step[(k + 1) % 3] - step[k]; };
  for (std::size_t k = 1; k < 3; ++k)
    if (side_at(k).squaredNorm() > side_at(from).squaredNorm()) from = k;
  const std::size_t to = (from + 1) % 3, beyond = (from + 2) % 3;
  const auto height = [&](std::size_t k) { return heights_[static_cast<std::size_t>(t[k])]; };
  const Vector2 side = side_at(from), corner = step[beyond] - step[from];
  const double whole = cross2(side, corner), squared = side.squaredNorm();
  const double here = std::clamp(-side.dot(step[from]) / squared, 0.0, 1.0);
  const double there = side.dot(corner) / squared;  // between the ends: the side is the longest
  double most = 1.0;
  if (here < there) most = here / there;
  if (here > there) most = (1.0 - here) / (1.0 - there);
  const double share =
      whole > 0.0 ? std::clamp(cross2(step[from], step[to]) / whole, 0.0, most) : 0.0;
  const double rest = 1.0 - share, along = std::clamp(here - share * there, 0.0, rest);
  return share * height(beyond) + (rest - along) * height(from) + along * height(to);
}

/// On a side the height is that of its ends.
OuterSurface::Cover OuterSurface::cover_side(const Triangle& t,
                                             const std::array<Vector2, 3>& step) const {
  Cover best;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const Vector2 side = step[next] - step[k];
    const double squared = side.squaredNorm();
    if (!(squared > 0.0)) continue;
    const double share = std::clamp(-side.dot(step[k]) / squared, 0.0, 1.0);
    if ((step[k] + share * side).squaredNorm() > rounding_ * rounding_) continue;
    const double from = heights_[static_cast<std::size_t>(t[k])];
    const double to = heights_[static_cast<std::size_t>(t[next])];
    const double height = from + share * (to - from);
    if (!best.found || height > best.height) best = {true, height};
  }
  return best;
}

bool OuterSurface::raise(Triangle& triangle, const Vector2& place, double& height) const {
  const Triangle before = triangle;
  const double from = height;
  for (const int v : corners_) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Triangle next{v, before[k], before[(k + 1) % 3]};
      if (!faces(next)) continue;
      const Cover here = cover(next, place);
      if (!here.found || here.height <= height) continue;
      height = here.height;
      triangle = next;
    }
  }
  return height > from;
}

}  // namespace quoin::geometry
