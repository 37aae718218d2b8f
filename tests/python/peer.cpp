// What measure.py holds the Python module against: the same calls in C++. Prints CPU seconds.
#include <cstdio>
#include <ctime>
#include <fstream>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <quoin/solver.hpp>

#include "scene_file/scene_file.hpp"

namespace {

template <class Call>
double least_seconds(int repeats, const Call& call) {
  double least = 1e300;
  for (int i = 0; i < repeats; ++i) {
    const std::clock_t start = std::clock();
    call();
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

std::vector<double> numbers(const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  std::vector<double> result(bytes.size() / sizeof(double));
  std::copy_n(bytes.data(), result.size() * sizeof(double), reinterpret_cast<char*>(result.data()));
  return result;
}

/// points, placements (rows of 3×4) and pairs, all as doubles.
double pairs(char** files, int repeats) {
  namespace geometry = quoin::geometry;
  const std::vector<double> points = numbers(files[0]), places = numbers(files[1]),
                            list = numbers(files[2]);
  const auto count = static_cast<Eigen::Index>(points.size() / 3);
  const geometry::Shape shape =
      geometry::make_hull(Eigen::Map<const geometry::Points>(points.data(), 3, count)).polyhedron;
  std::vector<geometry::Body> bodies;
  for (std::size_t i = 0; i + 12 <= places.size(); i += 12) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> rows(places.data() + i);
    bodies.emplace_back(shape, geometry::Placement{rows.leftCols<3>(), rows.col(3)});
  }
  std::vector<geometry::BlockPair> pairs;
  for (std::size_t i = 0; i < list.size(); i += 2)
    pairs.push_back({static_cast<int>(list[i]), static_cast<int>(list[i + 1])});
  geometry::PairBatch batch({.reach = 0.05});
  std::vector<geometry::ContactPoint> contacts;
  return least_seconds(repeats, [&] { batch.find(bodies, pairs, contacts); });
}

/// So many steps from the start, the least of five runs.
double steps(const char* scene, int count) {
  const quoin::scene_file::SceneFile file = quoin::scene_file::read_scene(scene);
  quoin::solver::StepOptions options = file.options;
  options.time_step = file.stages.front().time_step;
  double least = 1e300;
  for (int run = 0; run < 5; ++run) {
    quoin::solver::Simulation simulation(file.scene, options);
    least = std::min(least, least_seconds(1, [&] {
                       for (int i = 0; i < count; ++i) (void)simulation.advance();
                     }));
  }
  return least;
}

}  // namespace

int main(int count, char** words) {
  std::printf("%.17g\n", count == 5 ? pairs(words + 1, std::atoi(words[4]))
                                    : steps(words[1], std::atoi(words[2])));
}
