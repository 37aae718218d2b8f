/// A turned flush brick on its twin, with its points, at growing distances from the origin; bodies
/// that touch exactly; and the move of a body. Medians, ns.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/contact_point.hpp>
#include <random>
#include <vector>

namespace {

namespace geometry = quoin::geometry;
using geometry::Body;
using geometry::Matrix3;
using geometry::Vector3;

constexpr int kBodies = 200, kRounds = 201;

template <class Work>
double median_nanoseconds(int items, const Work& work) {
  std::vector<double> times;
  for (int round = 0; round < kRounds; ++round) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
    times.push_back(taken.count() / items);
  }
  std::nth_element(times.begin(), times.begin() + kRounds / 2, times.end());
  return times[kRounds / 2];
}

std::vector<Matrix3> turns() {
  std::mt19937_64 random(1);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<Matrix3> list;
  for (int k = 0; k < kBodies; ++k) {
    const double angle = 2 * std::numbers::pi * uniform();
    const Vector3 axis(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5);
    list.push_back(Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix());
  }
  return list;
}

double flush_brick(const geometry::Shape& brick, double far) {
  std::vector<Body> a, b;
  for (const Matrix3& turn : turns()) {
    const Vector3 at = far * Vector3(0.6, -0.64, 0.48);
    a.emplace_back(brick, geometry::Placement{turn, at});
    b.emplace_back(brick, geometry::Placement{turn, at + turn * Vector3(0.1, 0.05, 0.1 + 1e-9)});
  }
  std::vector<geometry::FeatureHint> hints(kBodies);
  std::vector<geometry::ContactPoint> contacts;
  return median_nanoseconds(kBodies, [&] {
    for (std::size_t k = 0; k < hints.size(); ++k) {
      contacts.clear();
      hints[k] =
          append_contacts_within_reach({0, 1}, a[k], b[k], {.reach = 1e-6}, hints[k], contacts)
              .hint;
    }
  });
}

double exact_touch(const Vector3& shift) {
  const geometry::Shape cube = geometry::make_box({0, 0, 0}, {1, 1, 1});
  const Body a(cube), b(cube, {.translation = shift});
  return median_nanoseconds(1, [&] { (void)geometry::nearest_features(a, b); });
}

double move() {
  const geometry::Shape brick = geometry::make_box({-0.2, -0.1, -0.05}, {0.2, 0.1, 0.05});
  const std::vector<Matrix3> list = turns();
  Body body(brick);
  return median_nanoseconds(kBodies, [&] {
    for (const Matrix3& turn : list) body.move({turn, turn.col(0)});
  });
}

}  // namespace

int main() {
  const geometry::Shape brick = geometry::make_box({-0.2, -0.1, -0.05}, {0.2, 0.1, 0.05});
  for (const double far : {0.0, 10.0, 1e3, 1e6}) {
    std::printf("flush brick, turned, warm, with points, %7g m away: %6.0f ns\n", far,
                flush_brick(brick, far));
  }
  std::printf("boxes that touch with faces, cold:    %6.0f ns\n", exact_touch({1, 0.3, 0.2}));
  std::printf("boxes that touch along edges, cold:   %6.0f ns\n", exact_touch({1, 1, 0.2}));
  std::printf("boxes that touch at vertices, cold:   %6.0f ns\n", exact_touch({1, 1, 1}));
  std::printf("move of a turned body:                %6.1f ns\n", move());
}
