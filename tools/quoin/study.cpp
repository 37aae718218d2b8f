/// `quoin study`: one scene over a grid of settings, error against run time.

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "commands.hpp"
#include "in_range.hpp"
#include "output_folder.hpp"
#include "path_to_write.hpp"
#include "scene_file/read_json.hpp"
#include "scene_file/run_scene.hpp"
#include "scene_file/study_grid.hpp"
#include "stop.hpp"

namespace quoin::commands {
namespace {

using scene_file::StudyAxis;
using scene_file::StudyPoint;

struct StudyArguments {
  std::string scene, out;
  std::vector<std::string> vary, changes;
  std::optional<double> max_seconds{};
  bool json = false;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
};

void run_point(const StudyArguments& arguments, const std::vector<StudyAxis>& axes,
               const StopRequest& stop, StudyPoint& point) {
  if (stop()) throw std::runtime_error("not run: the study was ended early");
  std::vector<std::string> changes = arguments.changes;
  for (const std::string& change : changes_of(axes, point)) changes.push_back(change);
  const scene_file::SceneFile file = scene_file::read_scene(arguments.scene, changes);
  point.time_step = file.options.time_step;
  const double start = scene_file::thread_seconds();
  scene_file::RunOptions options;
  options.stop = stop;
  const scene_file::RunResult result = scene_file::run_scene(file, options);
  point.cpu_seconds = scene_file::thread_seconds() - start;
  if (result.status != scene_file::RunStatus::Completed) point.failure = result.message;
  point.largest_overlap = result.total.largest_overlap;
  if (result.energy_scale > 0.0) point.energy_growth = result.energy_growth / result.energy_scale;
  point.solves_per_step = static_cast<double>(result.total.linear_solves) /
                          static_cast<double>(std::max(result.steps, 1L));
  for (const scene_file::MonitorValue& m : result.monitors) point.ends.push_back(m.displacement);
  if (point.failure.empty()) point.error = scene_file::largest_error(result.references);
}

/// A line that counts, on a terminal only.
std::function<void(std::size_t)> progress_line(std::size_t total) {
  if (isatty(STDERR_FILENO) == 0) return [](std::size_t) {};
  return [total](std::size_t done) {
    std::fprintf(stderr, "\r%zu of %zu%s", done, total, done == total ? "\n" : "");
  };
}

std::string scene_name(const StudyArguments& arguments) {
  return std::filesystem::path(arguments.scene).filename().string();
}

void write_files(OutputFolder& folder, const StudyArguments& arguments,
                 const std::vector<StudyAxis>& axes, const std::vector<StudyPoint>& points) {
  const std::filesystem::path table = folder.file("study.csv"), tree = folder.file("study.json");
  std::FILE* csv = std::fopen(table.c_str(), "w");
  if (csv == nullptr) throw scene_file::unwritable(table.string());
  write_csv(axes, points, csv);
  if (std::fclose(csv) != 0) throw scene_file::unwritable(table.string());
  std::ofstream report(tree);
  report << text(to_json(scene_name(arguments), axes, points)) << "\n";
  report.close();
  if (!report) throw scene_file::unwritable(tree.string());
  folder.commit(OutputFolder::Checkpoint::Drop);
}

int run(const StudyArguments& arguments) {
  std::vector<StudyAxis> axes;
  for (const std::string& text : arguments.vary) {
    StudyAxis axis = scene_file::parse_axis(text);
    const auto same = [&](const StudyAxis& other) { return other.change == axis.change; };
    if (std::any_of(axes.begin(), axes.end(), same))
      throw std::invalid_argument("--vary " + axis.key + ": is varied twice");
    axes.push_back(std::move(axis));
  }
  std::vector<StudyPoint> points = grid(axes);
  scene_file::read_json(arguments.scene);  // what can't be read at all is no row of a table
  std::optional<OutputFolder> folder;      // before anything runs: a study may take long
  if (!arguments.out.empty()) folder.emplace(arguments.out);
  catch_signals();
  const StopRequest stop(arguments.max_seconds);
  run_points(
      points, arguments.jobs, [&](StudyPoint& point) { run_point(arguments, axes, stop, point); },
      progress_line(points.size()));
  const bool referenced = std::any_of(points.begin(), points.end(), [](const StudyPoint& point) {
    return std::isfinite(point.error);
  });
  if (!referenced) compare_with_finest(axes, points);
  mark_best(points);
  if (arguments.json)
    std::printf("%s\n", text(to_json(scene_name(arguments), axes, points)).c_str());
  else
    write_csv(axes, points, stdout);
  if (folder) write_files(*folder, arguments, axes, points);
  const bool one_ran = std::any_of(points.begin(), points.end(),
                                   [](const StudyPoint& point) { return point.failure.empty(); });
  if (stop()) complain("the study was ended early; the rows that were run are kept");
  return one_ran && !stop() ? kDone : kFailed;
}

}  // namespace

void add_study_command(CLI::App& app, int& exit_code) {
  const auto [command, words] = add_command<StudyArguments>(
      app, exit_code, run, "study",
      "A scene over a grid of settings: error against run time (picture: plot_study.py)");
  command.add_option("scene", words.scene, "scene file, JSON")->required();
  command
      .add_option("--vary", words.vary,
                  "dt, method, penalty, tolerance, scheme, a parameter of the scene or a place in "
                  "it; may be repeated")
      ->type_name("KEY=A,B,…")
      ->required();
  command.add_option("--set", words.changes, "change the scene first, as for run")
      ->type_name("NAME=VALUE");
  command.add_flag("--json", words.json, "print study.json on standard output, not CSV");
  add_path(command, "--out", words.out,
           "folder for study.csv and study.json; takes the place of earlier results, of "
           "nothing else (default: no files)");
  command
      .add_option(
          "--max-seconds", words.max_seconds,
          "end after this wall time, s, and keep the rows that were run (default: no limit)")
      ->check(in_range(0, kMostSeconds));
  command.add_option("--jobs", words.jobs, "runs at the same time (default: one a core)")
      ->check(CLI::Range(1, 1024));
}

}  // namespace quoin::commands
