// The narrow phase alone: needs Eigen and nothing else.
#include <cstdio>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/nearest_features.hpp>
namespace geometry = quoin::geometry;

int main() {
  const geometry::Shape a = geometry::make_box({0, 0, 0}, {1, 1, 1});
  const geometry::Shape b = geometry::make_box({0, 0, 1.25}, {1, 1, 2});
  const geometry::NearestFeatures nearest = geometry::nearest_features(a, b);
  std::printf("gap %g m along (%g, %g, %g)\n", nearest.gap, nearest.normal.x(), nearest.normal.y(),
              nearest.normal.z());
  return nearest.gap == 0.25 ? 0 : 1;
}
