/// `quoin study`: one scene over a grid of settings, error against run time.

#include <time.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <unistd.h>

#include "commands.hpp"
#include "scene_file/run_scene.hpp"

namespace quoin::commands {
namespace {

struct StudyArguments {
  std::string scene, out;
  std::vector<std::string> vary, changes;
  int jobs = 1;
};

/// One setting of the grid and what came of it.
struct Point {
  std::vector<std::string> values{};  ///< one a key
  std::string failure{};              ///< what was wrong with it; empty: it ran to its end
  double time_step = 0.0;             ///< s
  double error = std::nan("");
  double cpu_seconds = 0.0;
  double largest_overlap = 0.0;       ///< m
  double solves_per_step = 0.0;
  bool best = false;                  ///< no other is both quicker and more exact
  std::vector<Eigen::Vector3d> ends{};  ///< displacement of each monitor at the end, m
  bool referenced = false;
};

struct Axis {
  std::string key, change;
  std::vector<std::string> values{};
};

Axis parse_axis(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw std::invalid_argument("--vary " + text + ": expected KEY=VALUE,VALUE,…");
  }
  Axis axis;
  axis.key = text.substr(0, equals);
  const bool known = axis.key == "method" || axis.key == "penalty" || axis.key == "tolerance" ||
                     axis.key == "scheme";
  axis.change = axis.key == "dt" ? "/time_step" : known ? "/" + axis.key : axis.key;
  std::size_t from = equals + 1;
  while (from <= text.size()) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    axis.values.push_back(text.substr(from, comma - from));
    from = comma + 1;
  }
  return axis;
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void run_point(const StudyArguments& arguments, const std::vector<Axis>& axes, Point& point) {
  std::vector<std::string> changes = arguments.changes;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    changes.push_back(axes[k].change + "=" + point.values[k]);
  }
  try {
    const scene_file::SceneFile file = scene_file::read_scene(arguments.scene, changes);
    point.time_step = file.options.time_step;
    const double start = thread_seconds();
    const scene_file::RunResult result = scene_file::run_scene(file, {});
    point.cpu_seconds = thread_seconds() - start;
    if (result.status != scene_file::RunStatus::Completed) point.failure = result.message;
    point.largest_overlap = result.total.largest_overlap;
    point.solves_per_step =
        static_cast<double>(result.total.linear_solves) / static_cast<double>(std::max(result.steps, 1L));
    for (const scene_file::MonitorValue& m : result.monitors) point.ends.push_back(m.displacement);
    point.referenced = !result.references.empty();
    double error = 0.0;
    for (const scene_file::ReferenceResult& r : result.references) error = std::max(error, r.error);
    if (point.referenced) point.error = error;
  } catch (const std::exception& error) {
    point.failure = error.what();
  }
}

std::vector<Point> grid(const std::vector<Axis>& axes) {
  std::vector<Point> points(1);
  for (const Axis& axis : axes) {
    std::vector<Point> next;
    for (const Point& point : points) {
      for (const std::string& value : axis.values) {
        next.push_back(point);
        next.back().values.push_back(value);
      }
    }
    points.swap(next);
  }
  return points;
}

void run_all(const StudyArguments& arguments, const std::vector<Axis>& axes,
             std::vector<Point>& points) {
  std::atomic<std::size_t> next{0}, done{0};
  std::mutex terminal;
  const bool progress = isatty(STDERR_FILENO) != 0;
  std::vector<std::jthread> workers;
  for (int w = 0; w < arguments.jobs; ++w) {
    workers.emplace_back([&] {
      for (std::size_t i = next++; i < points.size(); i = next++) {
        run_point(arguments, axes, points[i]);
        const std::size_t count = ++done;
        if (!progress) continue;
        const std::lock_guard lock(terminal);
        std::fprintf(stderr, "\r%zu of %zu", count, points.size());
      }
    });
  }
  workers.clear();
  if (progress) std::fputc('\n', stderr);
}

/// Where the scene has no reference: against the run of the smallest step, which has no error itself.
void compare_with_finest(std::vector<Point>& points) {
  const Point* finest = nullptr;
  for (const Point& point : points) {
    if (point.referenced) return;
    if (!point.failure.empty()) continue;
    if (finest == nullptr || point.time_step < finest->time_step) finest = &point;
  }
  if (finest == nullptr) return;
  double scale = 0.0;
  for (const Eigen::Vector3d& end : finest->ends) scale = std::max(scale, end.norm());
  for (Point& point : points) {
    if (!point.failure.empty() || &point == finest) continue;
    double worst = 0.0;
    for (std::size_t m = 0; m < point.ends.size(); ++m) {
      worst = std::max(worst, (point.ends[m] - finest->ends[m]).norm());
    }
    point.error = scale > 0.0 ? worst / scale : worst;
  }
}

void mark_best(std::vector<Point>& points) {
  const auto counts = [](const Point& p) { return p.failure.empty() && std::isfinite(p.error); };
  for (Point& point : points) {
    point.best = counts(point);
    for (const Point& other : points) {
      if (!counts(other)) continue;
      const bool better = other.error <= point.error && other.cpu_seconds <= point.cpu_seconds &&
                          (other.error < point.error || other.cpu_seconds < point.cpu_seconds);
      point.best = point.best && !better;
    }
  }
}

void write_csv(const std::vector<Axis>& axes, const std::vector<Point>& points, std::FILE* out) {
  for (const Axis& axis : axes) std::fprintf(out, "%s,", axis.key.c_str());
  std::fprintf(out, "error,cpu_seconds,largest_overlap,solves_per_step,pareto,failure\n");
  for (const Point& p : points) {
    for (const std::string& value : p.values) std::fprintf(out, "%s,", value.c_str());
    std::fprintf(out, "%.6g,%.4g,%.4g,%.4g,%d,\"%s\"\n", p.error, p.cpu_seconds, p.largest_overlap,
                 p.solves_per_step, p.best ? 1 : 0, p.failure.c_str());
  }
}

nlohmann::ordered_json to_json(const StudyArguments& arguments, const std::vector<Axis>& axes,
                               const std::vector<Point>& points) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Point& p : points) {
    nlohmann::ordered_json object;
    for (std::size_t k = 0; k < axes.size(); ++k) object["settings"][axes[k].key] = p.values[k];
    object["error"] = std::isfinite(p.error) ? nlohmann::ordered_json(p.error) : nullptr;
    object["cpu_seconds"] = p.cpu_seconds;
    object["largest_overlap"] = p.largest_overlap;
    object["solves_per_step"] = p.solves_per_step;
    object["pareto"] = p.best;
    object["failure"] = p.failure;
    list.push_back(object);
  }
  return {{"scene", std::filesystem::path(arguments.scene).filename().string()}, {"points", list}};
}

int run(const StudyArguments& arguments) {
  std::vector<Axis> axes;
  for (const std::string& text : arguments.vary) axes.push_back(parse_axis(text));
  std::vector<Point> points = grid(axes);
  run_all(arguments, axes, points);
  compare_with_finest(points);
  mark_best(points);
  write_csv(axes, points, stdout);
  if (!arguments.out.empty()) {
    const std::filesystem::path folder(arguments.out);
    std::filesystem::create_directories(folder);
    std::FILE* csv = std::fopen((folder / "study.csv").c_str(), "w");
    if (csv == nullptr) throw std::runtime_error("can't write " + (folder / "study.csv").string());
    write_csv(axes, points, csv);
    std::fclose(csv);
    std::ofstream json(folder / "study.json");
    json << to_json(arguments, axes, points).dump(1) << "\n";
    if (!json) throw std::runtime_error("can't write " + (folder / "study.json").string());
  }
  for (const Point& point : points) {
    if (point.failure.empty()) return kDone;
  }
  return kFailed;
}

}  // namespace

void add_study_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* command = app.add_subcommand(
      "study", "A scene over a grid of settings: error against run time (picture: plot_study.py)");
  command->add_option("scene", arguments->scene, "scene file, JSON")->required();
  command
      ->add_option("--vary", arguments->vary,
                   "dt, method, penalty, tolerance, scheme, a parameter of the scene or a place in "
                   "it; may be repeated")
      ->type_name("KEY=A,B,…")
      ->required();
  command->add_option("--set", arguments->changes, "change the scene first, as for run")
      ->type_name("NAME=VALUE");
  command->add_option("--out", arguments->out, "folder for study.csv and study.json");
  command->add_option("--jobs", arguments->jobs, "runs at the same time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->callback([arguments, &exit_code] {
    try {
      exit_code = run(*arguments);
    } catch (const std::invalid_argument& error) {
      std::fprintf(stderr, "quoin study: %s\n", error.what());
      exit_code = kBadInput;
    }
  });
}

}  // namespace quoin::commands
