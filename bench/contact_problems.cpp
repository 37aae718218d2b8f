/// contact_problems FOLDER: runs each contact iteration to several tolerances on the problems of a
/// folder, as `quoin run --dump-steps` writes them. CSV on standard output, a line a run; the
/// errors are those of the forces when the blocks bear them exactly (solver::contact_error).

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "scene_file/contact_problem_file.hpp"

namespace {

namespace solver = quoin::solver;
using solver::ContactIteration;

constexpr ContactIteration kIterations[] = {ContactIteration::OpenClose,
                                            ContactIteration::ProximalNewton};
constexpr double kTolerances[] = {1e-4, 1e-6, 1e-8, 1e-10};

/// One problem by one iteration to one tolerance.
struct Result {
  bool converged = false;
  int factorizations = 0;
  double seconds = 0.0;  ///< of CPU
  solver::ContactError error{};
};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Result run(const solver::ContactProblem& problem, ContactIteration iteration, double tolerance) {
  const double start = cpu_seconds();
  const solver::ContactSolution solution = solver::solve(problem, iteration, tolerance);
  const double seconds = cpu_seconds() - start;
  return {solution.converged, solution.factorizations, seconds,
          solver::contact_error(problem, solution.forces)};
}

/// Folder and numbered file: the scene is the folder's name.
std::map<std::string, std::vector<solver::ContactProblem>> read_all(const char* folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".txt") files.push_back(entry.path());
  std::ranges::sort(files);
  std::map<std::string, std::vector<solver::ContactProblem>> scenes;
  for (const auto& file : files) {
    std::ifstream in(file);
    scenes[file.parent_path().filename().string()].push_back(
        quoin::scene_file::read_contact_problem(in));
  }
  return scenes;
}

void print(const std::string& scene, std::size_t number, ContactIteration iteration,
           double tolerance, const Result& result) {
  std::printf("%s,%zu,%s,%.0e,%d,%d,%.4g,%.3e,%.3e\n", scene.c_str(), number, name(iteration),
              tolerance, static_cast<int>(result.converged), result.factorizations,
              1e3 * result.seconds, result.error.force, result.error.gap);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "contact_problems FOLDER\n");
    return 2;
  }
  std::puts(
      "scene,problem,iteration,tolerance,converged,factorizations,cpu_ms,force_error,gap_error_m");
  for (const auto& [scene, problems] : read_all(argv[1])) {
    for (std::size_t p = 0; p < problems.size(); ++p) {
      for (const ContactIteration iteration : kIterations)
        for (const double tolerance : kTolerances)
          print(scene, p, iteration, tolerance, run(problems[p], iteration, tolerance));
    }
  }
}
