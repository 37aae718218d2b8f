/// contact_problems FOLDER: runs each contact iteration on the problems of a folder, as
/// `quoin run --dump-steps` writes them. Prints one table of solves and CPU time by scene and
/// tolerance, and a performance profile: the share of the problems that an iteration solves within
/// a factor of the best one's time.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <quoin/solver/contact_problem.hpp>
#include <string>
#include <vector>

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

using Results = std::vector<Result>;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Result run(const solver::ContactProblem& problem, ContactIteration iteration, double tolerance) {
  const double start = cpu_seconds();
  const solver::ContactSolution solution = solver::solve(problem, iteration, tolerance);
  const double seconds = cpu_seconds() - start;
  return {solution.converged, solution.factorizations, seconds,
          solver::contact_error(problem, solution.forces)};
}

template <typename Value>
Value median(std::vector<Value> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// Folder and numbered file: the scene is the folder's name.
std::map<std::string, std::vector<solver::ContactProblem>> read_all(const char* folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".txt") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  std::map<std::string, std::vector<solver::ContactProblem>> scenes;
  for (const auto& file : files) {
    std::ifstream in(file);
    scenes[file.parent_path().filename().string()].push_back(solver::read_contact_problem(in));
  }
  return scenes;
}

void print_row(const std::string& scene, ContactIteration iteration, double tolerance,
               const Results& results) {
  std::vector<int> solves;
  std::vector<double> seconds, force, gap;
  for (const Result& result : results) {
    if (!result.converged) continue;
    solves.push_back(result.factorizations);
    seconds.push_back(result.seconds);
    force.push_back(result.error.force);
    gap.push_back(result.error.gap);
  }
  const std::size_t failed = results.size() - solves.size();
  const auto most = [](const auto& values) {
    return values.empty() ? 0 : *std::ranges::max_element(values);
  };
  std::printf("| %s | %zu | %s | %.0e | %d / %d | %zu | %.2g | %.1e | %.1e |\n", scene.c_str(),
              results.size(), name(iteration), tolerance, median(solves), most(solves), failed,
              1e3 * median(seconds), median(force), most(gap));
}

void print_profile(const std::vector<Results>& by_iteration) {
  std::printf("\nShare of problems solved to 1e-08 within a factor of the best CPU time:\n\n");
  std::printf(
      "| iteration | 1 | 1.5 | 2 | 4 | 8 | 16 | at all |\n|---|---|---|---|---|---|---|---|\n");
  const std::size_t count = by_iteration.front().size();
  for (std::size_t k = 0; k < by_iteration.size(); ++k) {
    std::printf("| %s |", name(kIterations[k]));
    for (const double factor : {1.0, 1.5, 2.0, 4.0, 8.0, 16.0, HUGE_VAL}) {
      std::size_t within = 0;
      for (std::size_t p = 0; p < count; ++p) {
        double best = HUGE_VAL;
        for (const Results& results : by_iteration) {
          if (results[p].converged) best = std::min(best, results[p].seconds);
        }
        const Result& mine = by_iteration[k][p];
        within += mine.converged && mine.seconds <= factor * best ? 1U : 0U;
      }
      std::printf(" %.2f |", static_cast<double>(within) / static_cast<double>(count));
    }
    std::printf("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "contact_problems FOLDER\n");
    return 2;
  }
  const auto scenes = read_all(argv[1]);
  std::vector<Results> profile(std::size(kIterations));
  std::printf(
      "| scene | problems | iteration | tolerance | solves: median / largest | failed | CPU ms | "
      "force error | largest gap error m |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [scene, problems] : scenes) {
    for (std::size_t k = 0; k < std::size(kIterations); ++k) {
      for (const double tolerance : kTolerances) {
        Results results;
        for (const auto& problem : problems) {
          results.push_back(run(problem, kIterations[k], tolerance));
        }
        print_row(scene, kIterations[k], tolerance, results);
        if (tolerance == 1e-8) profile[k].insert(profile[k].end(), results.begin(), results.end());
      }
    }
  }
  if (!profile.front().empty()) print_profile(profile);
  return EXIT_SUCCESS;
}
