/// What it costs to make a shape from points: `bench_make_hull [solid [times]]`, medians in ns.
/// Instructions are the difference of two runs under callgrind, of some times and of none.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <quoin/geometry/build.hpp>
#include <string>
#include <vector>

#include "referee/pairs/cut_cell.hpp"

namespace {

using quoin::geometry::make_hull;
using quoin::geometry::Points;
using quoin::referee::Random;

struct Solid {
  std::string name;
  Points points;
};

Points on_a_sphere(int count, Random& random) {
  Points points(3, count);
  for (int i = 0; i < count; ++i) points.col(i) = random.direction();
  return points;
}

std::vector<Solid> solids() {
  Random random(7);
  const Points box = quoin::geometry::make_box({0, 0, 0}, {1, 0.5, 0.3}).vertices();
  return {{"box", box},
          {"turned box", random.rotation() * box},
          {"Voronoi cell", quoin::referee::random_voronoi_cells(0.0, random)[0].points()},
          {"hull of 64", on_a_sphere(64, random)},
          {"hull of 1000", on_a_sphere(1000, random)}};
}

void time(const Solid& solid, int times) {
  std::vector<double> nanoseconds;
  int edges = 0;
  for (int round = 0; round < times; ++round) {
    const auto start = std::chrono::steady_clock::now();
    edges = make_hull(solid.points).polyhedron.topology().edge_count();
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
    nanoseconds.push_back(taken.count());
  }
  if (times == 0) return;
  std::nth_element(nanoseconds.begin(), nanoseconds.begin() + times / 2, nanoseconds.end());
  std::printf("%-14s %5ld points %5d edges %12.0f ns\n", solid.name.c_str(),
              static_cast<long>(solid.points.cols()), edges, nanoseconds[nanoseconds.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  const int times = argc > 2 ? std::atoi(argv[2]) : 201;
  for (const Solid& solid : solids())
    if (name.empty() || name == solid.name) time(solid, times);
}
