#pragma once
/// One scene over a grid of settings: errors against run times, whoever runs the scene.

#include <functional>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scene_file/comparison.hpp"

namespace quoin::scene_file {

/// What is varied: `key` names it in tables, `change` is the place in the scene file.
struct StudyAxis {
  std::string key{}, change{};
  bool numerical = false;  ///< how the scene is solved; else it is another scene
  std::vector<std::string> values{};
};

/// "dt=0.01,0.005" or a parameter of the scene. Throws std::invalid_argument.
StudyAxis parse_axis(const std::string& text);

/// One setting of the grid and what came of it.
struct StudyPoint {
  std::vector<std::string> values{};  ///< one an axis
  std::string failure{};              ///< what was wrong with it; empty: it ran to its end
  double time_step = 0.0;             ///< s
  double error = std::numeric_limits<double>::quiet_NaN();            ///< largest of the references
  double cpu_seconds = 0.0;                                           ///< of the thread that ran it
  double largest_overlap = std::numeric_limits<double>::quiet_NaN();  ///< m
  double energy_growth = std::numeric_limits<double>::quiet_NaN();    ///< of its scale
  double solves_per_step = 0.0;                                       ///< 0: not counted
  bool best = false;            ///< no other is both quicker and more exact
  std::vector<Vector3> ends{};  ///< displacement of each monitor at the end, m
};

/// Every combination of the axes' values.
std::vector<StudyPoint> grid(const std::vector<StudyAxis>& axes);

/// The settings of a point as changes for read_scene().
std::vector<std::string> changes_of(const std::vector<StudyAxis>& axes, const StudyPoint& point);

/// Calls `run` for each point, `jobs` at a time; an exception becomes the failure of its point.
/// `progress` is told how many are done, by one thread at a time.
void run_points(std::vector<StudyPoint>& points, int jobs,
                const std::function<void(StudyPoint&)>& run,
                const std::function<void(std::size_t done)>& progress);

/// CPU time of this thread, s.
double thread_seconds();

/// The largest error of the references; NaN when there is none.
double largest_error(const std::vector<ReferenceResult>& references);

/// Ends of the run of the smallest step that did not fail; empty when all did.
std::vector<Vector3> finest_ends(const std::vector<StudyPoint>& points);

/// Where the scene has no reference: against the run of the smallest step among those of the same
/// scene, which differ in numerical axes alone.
void compare_with_finest(const std::vector<StudyAxis>& axes, std::vector<StudyPoint>& points);

/// Likewise against a run of another program: the largest difference of a monitor's end from `ends`
/// by the largest displacement of those. The run whose ends they are has no error.
void compare_with(const std::vector<Vector3>& ends, std::vector<StudyPoint>& points);

/// Marks the Pareto front.
void mark_best(std::vector<StudyPoint>& points);

void write_csv(const std::vector<StudyAxis>& axes, const std::vector<StudyPoint>& points,
               std::FILE* out);
nlohmann::ordered_json to_json(const std::string& scene, const std::vector<StudyAxis>& axes,
                               const std::vector<StudyPoint>& points);

}  // namespace quoin::scene_file
