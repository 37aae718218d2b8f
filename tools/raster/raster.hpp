#pragma once
/// Pictures of flat polygons: the nearest one at every sample, by a depth buffer.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace quoin::raster {

/// Convex flat polygons, wound counter-clockwise as seen from outside; those that look away from
/// the eye are not drawn.
struct Polygons {
  std::span<const double> corners;      ///< x y z of each corner, m
  std::span<const std::int32_t> first;  ///< first corner of each polygon, and the number of corners
  std::span<const float> colours;       ///< red green blue of each polygon, 0 … 1
};

/// A parallel projection.
struct View {
  int width = 0, height = 0;  ///< pixels, > 0
  int samples = 3;            ///< along each side of a pixel, > 0
  Eigen::Matrix3d axes =
      Eigen::Matrix3d::Identity();  ///< rows: unit vectors to the right, up, to the eye
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< of the picture, along right and up, m
  double scale = 1.0;                                ///< pixels a metre, > 0
  Eigen::Vector3d light{-0.45, -0.55, 0.707};        ///< towards the light
  double line = 0.6;                                 ///< half width of an edge, pixels; 0: none
};

constexpr int kNone = -1;

struct Image {
  std::vector<std::uint8_t> rgb;       ///< rows from the top, three bytes a pixel; white: nothing
  std::vector<float> depth;            ///< towards the eye at the middle of each pixel, m
  std::vector<std::int32_t> polygons;  ///< seen there; kNone: nothing
};

/// Throws std::invalid_argument where sizes do not fit.
Image draw(const Polygons& polygons, const View& view);

}  // namespace quoin::raster
