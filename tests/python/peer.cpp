// What measure.py holds the Python module against: the same calls in C++. Prints the least seconds
// of a call.
#include <chrono>
#include <cstdio>
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
    const auto start = std::chrono::steady_clock::now();
    call();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    least = std::min(least, taken.count());
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
  for (std::size_t i = 0; i < list.size(); i += 2) {
    pairs.push_back({static_cast<int>(list[i]), static_cast<int>(list[i + 1])});
  }
  geometry::PairBatch batch({.reach = 0.05});
  std::vector<geometry::ContactPoint> contacts;
  return least_seconds(repeats, [&] { batch.find(bodies, pairs, contacts); });
}

double steps(const char* scene, int repeats) {
  const quoin::scene_file::SceneFile file = quoin::scene_file::read_scene(scene);
  quoin::solver::StepOptions options = file.options;
  options.time_step = file.stages.front().time_step;
  quoin::solver::Simulation simulation(file.scene, options);
  return least_seconds(repeats, [&] { (void)simulation.advance(); });
}

}  // namespace

int main(int count, char** words) {
  std::printf("%.17g\n", count == 5 ? pairs(words + 1, std::atoi(words[4]))
                                    : steps(words[1], std::atoi(words[2])));
}
