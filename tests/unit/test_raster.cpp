#include <cmath>
#include <limits>
#include <numeric>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/queries.hpp>

#include "raster/raster.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

namespace {

namespace geometry = quoin::geometry;
namespace raster = quoin::raster;
using geometry::Vector3;
using quoin::tests::Random;

/// Bodies as polygons; the body of each polygon.
struct Drawn {
  std::vector<double> corners{};
  std::vector<std::int32_t> first{0};
  std::vector<float> colours{};
  std::vector<int> body{};

  void add(const geometry::Body& shown, int number) {
    const geometry::Topology& topology = shown.shape().topology();
    for (int f = 0; f < topology.face_count(); ++f) {
      for (const int v : topology.face(f)) {
        const Vector3 place = shown.vertex(v);
        corners.insert(corners.end(), place.begin(), place.end());
      }
      first.push_back(static_cast<std::int32_t>(corners.size() / 3));
      colours.insert(colours.end(), 3, 0.5f);
      body.push_back(number);
    }
  }
};

raster::View view_of(Random& random) {
  raster::View view{.width = 161, .height = 120};
  view.axes = random.rotation();
  view.scale = 40.0;
  return view;
}

}  // namespace

TEST_CASE("raster: 1000 pixels show the body that a ray meets first") {
  Random random(5);
  const geometry::Shape box = geometry::make_box({-0.5, -0.3, -0.2}, {0.5, 0.3, 0.2});
  std::vector<geometry::Body> bodies;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {  // a wall of boxes face to face, and some that cross it
      bodies.emplace_back(
          box, geometry::Placement{geometry::Matrix3::Identity(), {1.0 * x, 0, 0.4 * y}});
      bodies.emplace_back(box, geometry::Placement{random.rotation(), {0.7 * x, 0.8 * y, 0.5}});
    }
  }
  Drawn drawn;
  for (std::size_t b = 0; b < bodies.size(); ++b) drawn.add(bodies[b], static_cast<int>(b));
  int compared = 0, hits = 0;
  for (int trial = 0; trial < 5; ++trial) {
    const raster::View view = view_of(random);
    const raster::Image image = raster::draw({drawn.corners, drawn.first, drawn.colours}, view);
    for (int k = 0; k < 200; ++k) {
      const int x = static_cast<int>(random.uniform(0, view.width));
      const int y = static_cast<int>(random.uniform(0, view.height));
      const Vector3 flat((x + 0.5 - 0.5 * view.width) / view.scale,
                         -(y + 0.5 - 0.5 * view.height) / view.scale, 10.0);
      const geometry::Ray ray{view.axes.transpose() * flat, -view.axes.row(2).transpose(), 20.0};
      double nearest = std::numeric_limits<double>::infinity();
      for (const geometry::Body& body : bodies)
        if (const auto hit = geometry::first_hit(body, ray)) nearest = std::min(nearest, hit->s);
      const auto at = static_cast<std::size_t>(y * view.width + x);
      ++compared;
      if (image.polygons[at] == raster::kNone) {
        CHECK(std::isinf(nearest));
        continue;
      }
      ++hits;
      CHECK(std::abs(image.depth[at] - (10.0 - nearest)) < 1e-5);
      const auto seen =
          static_cast<std::size_t>(drawn.body[static_cast<std::size_t>(image.polygons[at])]);
      const auto own = geometry::first_hit(bodies[seen], ray);
      CHECK((own && own->s - nearest < 1e-5));
    }
  }
  CHECK(compared == 1000);
  CHECK(hits > 300);
}

TEST_CASE("raster: a face in full light is as bright as its colour allows, the empty part white") {
  Drawn drawn;
  const geometry::Shape box = geometry::make_box({-1, -1, -1}, {1, 1, 1});
  drawn.add(geometry::Body(box), 0);
  raster::View view{.width = 40, .height = 40};
  view.scale = 10.0;
  view.light = {0, 0, 1};
  const raster::Image image = raster::draw({drawn.corners, drawn.first, drawn.colours}, view);
  const std::size_t middle = 20 * 40 + 20;
  CHECK(image.rgb[3 * middle] == std::lround(255 * 0.5 * 1.06));
  CHECK(image.rgb[0] == 255);
  CHECK(image.polygons[0] == raster::kNone);
  CHECK_THROWS_AS(raster::draw({drawn.corners, drawn.first, {}}, view), std::invalid_argument);
}

TEST_CASE("raster: a box throws its shadow, edges are dark, light that comes aslant is weaker") {
  Drawn drawn;
  drawn.add(geometry::Body(geometry::make_box({-4, -4, -1}, {4, 4, 0})), 0);
  drawn.add(geometry::Body(geometry::make_box({-1, -1, 0}, {1, 1, 1})), 1);
  raster::View view{.width = 100, .height = 100};
  view.scale = 10.0;
  view.light = {-1, 0, 1};
  const raster::Image image = raster::draw({drawn.corners, drawn.first, drawn.colours}, view);
  const auto brightness = [&](double x, double y) {
    const int column = 50 + static_cast<int>(std::floor(10 * x)),
              row = 49 - static_cast<int>(std::floor(10 * y));
    return static_cast<double>(image.rgb[3 * static_cast<std::size_t>(100 * row + column)]);
  };
  const double dark = 255 * 0.5 * 0.64, lit = 255 * 0.5 * (0.64 + 0.42 * std::sqrt(0.5));
  CHECK(std::abs(brightness(1.55, 0.05) - dark) < 1.0);
  for (const auto& [x, y] : {std::pair{2.55, 0.05}, {1.55, 2.05}, {-1.55, 0.05}, {0.55, 0.05}})
    CHECK(std::abs(brightness(x, y) - lit) < 1.0);
  CHECK(brightness(0.95, 0.05) < 0.8 * lit);
}
