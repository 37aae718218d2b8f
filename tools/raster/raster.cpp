#include "raster.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace quoin::raster {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNowhere = -std::numeric_limits<double>::infinity();
constexpr int kShadowSide = 2048;  // samples of the light's own picture, along each side
constexpr double kAmbient = 0.56, kFromAbove = 0.08, kDiffuse = 0.42;
const Eigen::Vector3f kLine{0.19f, 0.17f, 0.15f};

/// x = scale (axes p - offset), so that samples have their middle at whole numbers plus a half, and
/// y grows downwards; the third component is the depth in samples.
struct Grid {
  int width = 0, height = 0;
  Matrix3d axes;
  Vector3d offset;
  double scale = 1.0;

  Vector3d operator()(const Vector3d& p) const { return scale * (axes * p - offset); }
  Vector3d back(const Vector3d& x) const { return axes.transpose() * (x / scale + offset); }
};

struct Buffer {
  std::vector<float> depth;
  std::vector<std::int32_t> polygon;

  explicit Buffer(const Grid& grid)
      : depth(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
              static_cast<float>(kNowhere)),
        polygon(depth.size(), kNone) {}
};

struct Side {
  double a, b, c;  // a x + b y + c: distance of a sample from it, positive inside
};

/// A polygon in the samples of a grid.
struct Flat {
  std::vector<Vector3d> corners;
  std::vector<Side> sides;
  Vector3d normal = Vector3d::Zero();  // of the world
  double across = 0.0, down = 0.0;     // change of the depth by sample
  bool seen = false;

  void set(const Polygons& all, std::size_t polygon, const Grid& grid) {
    corners.clear();
    sides.clear();
    for (int k = all.first[polygon]; k < all.first[polygon + 1]; ++k) {
      corners.push_back(
          grid(Eigen::Map<const Vector3d>(&all.corners[3 * static_cast<std::size_t>(k)])));
    }
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 1; i + 1 < corners.size(); ++i)
      sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
    const double size = sum.norm();
    // The grid's y points down: there a polygon that looks to the eye is wound clockwise.
    seen = -sum.z() > 1e-9 * size && size > 0;
    if (!seen) return;
    normal = grid.axes.transpose() * Vector3d(-sum.x(), -sum.y(), -sum.z()) / size;
    across = -sum.x() / sum.z();
    down = -sum.y() / sum.z();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector3d &p = corners[i], &q = corners[(i + 1) % corners.size()];
      const double dx = q.x() - p.x(), dy = q.y() - p.y(), length = std::hypot(dx, dy);
      if (length > 0)
        sides.push_back({dy / length, -dx / length, (dx * p.y() - dy * p.x()) / length});
    }
  }
  double depth(double x, double y) const {
    return corners[0].z() + across * (x - corners[0].x()) + down * (y - corners[0].y());
  }
  double from_side(double x, double y) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Side& side : sides) least = std::min(least, side.a * x + side.b * y + side.c);
    return least;
  }
};

/// The samples of row y from `from` up to, without, `to` that lie in the polygon.
struct Run {
  int from, to;
};

Run run_of(const Flat& flat, int y, int width) {
  double low = 0.5, high = width - 0.5;
  for (const Side& side : flat.sides) {
    const double rest = side.b * (y + 0.5) + side.c;
    if (side.a > 0) low = std::max(low, -rest / side.a);
    if (side.a < 0) high = std::min(high, -rest / side.a);
    if (side.a == 0 && rest < 0) return {0, 0};
  }
  if (!(low <= high)) return {0, 0};
  return {static_cast<int>(std::ceil(low - 0.5)), static_cast<int>(std::floor(high - 0.5)) + 1};
}

void fill(const Flat& flat, std::int32_t number, const Grid& grid, Buffer& buffer) {
  double low = grid.height, high = 0;
  for (const Vector3d& corner : flat.corners) {
    low = std::min(low, corner.y());
    high = std::max(high, corner.y());
  }
  const int last = static_cast<int>(std::min<double>(grid.height - 1, std::floor(high)));
  for (int y = static_cast<int>(std::max(0.0, std::floor(low))); y <= last; ++y) {
    const Run run = run_of(flat, y, grid.width);
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width);
    for (int x = run.from; x < run.to; ++x) {
      const std::size_t at = row + static_cast<std::size_t>(x);
      const auto depth = static_cast<float>(flat.depth(x + 0.5, y + 0.5));
      if (depth > buffer.depth[at]) {
        buffer.depth[at] = depth;
        buffer.polygon[at] = number;
      }
    }
  }
}

Buffer filled(const Polygons& all, const Grid& grid) {
  Buffer buffer(grid);
  Flat flat;
  for (std::size_t p = 0; p + 1 < all.first.size(); ++p) {
    flat.set(all, p, grid);
    if (flat.seen) fill(flat, static_cast<std::int32_t>(p), grid, buffer);
  }
  return buffer;
}

/// What the light sees of the corners that the picture shows.
Grid light_grid(const Polygons& all, const Grid& shown, const Vector3d& direction) {
  const Vector3d to_light = direction.normalized();
  const Vector3d right = to_light.unitOrthogonal();
  Grid grid{kShadowSide, kShadowSide, {}, {}, 1.0};
  grid.axes << right.transpose(), -to_light.cross(right).transpose(), to_light.transpose();
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t k = 0; k + 2 < all.corners.size(); k += 3) {
    const Eigen::Map<const Vector3d> corner(&all.corners[k]);
    const Vector3d at = shown(corner), p = grid.axes * corner;
    if (at.x() < 0 || at.y() < 0 || at.x() > shown.width || at.y() > shown.height) continue;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (!(low.x() <= high.x())) low = high = Vector3d::Zero();
  const double side = std::max({high.x() - low.x(), high.y() - low.y(), 1e-300});
  grid.scale = kShadowSide / (1.01 * side);
  grid.offset = 0.5 * (low + high) - Vector3d(0.505 * side, 0.505 * side, 0);
  return grid;
}

/// Whether light comes to a place; `jitter` in samples of the light's picture makes soft borders.
bool is_lit(const Vector3d& place, const Grid& grid, const Buffer& buffer, const Vector2d& jitter) {
  const Vector3d at = grid(place);
  const double x = at.x() + jitter.x(), y = at.y() + jitter.y();
  if (!(x >= 0 && y >= 0 && x < grid.width && y < grid.height)) return true;
  const std::size_t index = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) +
                            static_cast<std::size_t>(x);
  constexpr double kSlack = 3.0;  // samples
  return buffer.depth[index] <= at.z() + kSlack;
}

/// The colour of each sample, added up by pixel.
class Painter {
 public:
  Painter(const Polygons& all, const View& view, const Grid& grid, const Buffer& buffer)
      : all_(all),
        view_(view),
        grid_(grid),
        buffer_(buffer),
        to_light_(view.light.normalized()),
        light_(light_grid(all, grid, view.light)),
        shadow_(filled(all, light_)) {}

  Eigen::Vector3f sample(int x, int y) {
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width) +
                           static_cast<std::size_t>(x);
    const std::int32_t polygon = buffer_.polygon[at];
    if (polygon == kNone) return Eigen::Vector3f::Ones();
    if (polygon != current_) {
      current_ = polygon;
      flat_.set(all_, static_cast<std::size_t>(polygon), grid_);
      double reach = 0.0;  // a line takes no more than a part of a small face
      for (const Vector3d& corner : flat_.corners)
        reach = std::max(reach, (corner - flat_.corners[0]).head<2>().norm());
      line_ = std::min(view_.line * view_.samples, 0.06 * reach);
    }
    if (flat_.from_side(x + 0.5, y + 0.5) < line_) return kLine;
    double shade = kAmbient + kFromAbove * flat_.normal.z();
    const double towards = flat_.normal.dot(to_light_);
    constexpr double kLifted = 4.0;  // samples of the light's picture: a face does not shade itself
    const Vector3d place = grid_.back({x + 0.5, y + 0.5, static_cast<double>(buffer_.depth[at])}) +
                           kLifted / light_.scale * flat_.normal;
    const int n = view_.samples;
    const Vector2d jitter = 3.0 * Vector2d((x % n) - 0.5 * (n - 1), (y % n) - 0.5 * (n - 1)) / n;
    if (towards > 0 && is_lit(place, light_, shadow_, jitter)) shade += kDiffuse * towards;
    const Eigen::Map<const Eigen::Vector3f> colour(
        &all_.colours[3 * static_cast<std::size_t>(polygon)]);
    return (static_cast<float>(shade) * colour).cwiseMin(1.0f);
  }

 private:
  const Polygons& all_;
  const View& view_;
  const Grid& grid_;
  const Buffer& buffer_;
  Vector3d to_light_;
  Grid light_;
  Buffer shadow_;
  std::int32_t current_ = kNone;
  Flat flat_;
  double line_ = 0.0;
};

void check(const Polygons& polygons, const View& view) {
  const std::size_t corners = polygons.corners.size() / 3, count = polygons.first.size() - 1;
  const bool fits = !polygons.first.empty() && polygons.first[0] == 0 &&
                    std::ranges::is_sorted(polygons.first) &&
                    static_cast<std::size_t>(polygons.first.back()) == corners &&
                    polygons.colours.size() == 3 * count;
  constexpr long kMostSamples = 400'000'000;
  const long samples = long{view.width} * view.height * view.samples * view.samples;
  if (!fits || std::min({view.width, view.height, view.samples}) < 1 || samples > kMostSamples ||
      !(view.scale > 0)) {
    throw std::invalid_argument(
        "raster: sizes of corners, polygons, colours and picture don't fit");
  }
}

}  // namespace

Image draw(const Polygons& polygons, const View& view) {
  check(polygons, view);
  const int n = view.samples;
  Grid grid{view.width * n, view.height * n, view.axes, {}, view.scale * n};
  grid.axes.row(1) *= -1.0;
  grid.offset = Vector3d(view.centre.x(), -view.centre.y(), 0) -
                Vector3d(view.width, view.height, 0) / (2 * view.scale);
  const Buffer buffer = filled(polygons, grid);
  Painter painter(polygons, view, grid, buffer);
  Image image;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int k = 0; k < n * n; ++k) sum += painter.sample(x * n + k % n, y * n + k / n);
      for (const float part : sum) {
        image.rgb.push_back(
            static_cast<std::uint8_t>(std::lround(255.0f * part / static_cast<float>(n * n))));
      }
      const std::size_t middle =
          static_cast<std::size_t>(y * n + n / 2) * static_cast<std::size_t>(grid.width) +
          static_cast<std::size_t>(x * n + n / 2);
      image.depth.push_back(buffer.depth[middle] / static_cast<float>(grid.scale));
      image.polygons.push_back(buffer.polygon[middle]);
    }
  }
  return image;
}

}  // namespace quoin::raster
