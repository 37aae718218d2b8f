#include "scene_file/study_grid.hpp"

#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "scene_file/printable.hpp"

namespace quoin::scene_file {
namespace {

// Settings of the solution, as changes of a scene file.
constexpr std::array<std::string_view, 12> kNumerical = {
    "/time_step",         "/smallest_time_step", "/method",         "/scheme",
    "/penalty",           "/shear_ratio",        "/tolerance",      "/reach",
    "/contact_iteration", "/linear_solver",      "/max_iterations", "/max_displacement_ratio"};

bool counts(const StudyPoint& point) { return point.failure.empty() && std::isfinite(point.error); }

/// Quicker or more exact, and the other not worse.
bool beats(const StudyPoint& a, const StudyPoint& b) {
  return a.error <= b.error && a.cpu_seconds <= b.cpu_seconds &&
         (a.error < b.error || a.cpu_seconds < b.cpu_seconds);
}

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

StudyAxis parse_axis(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw std::invalid_argument("--vary " + text + ": expected KEY=VALUE,VALUE,…");
  StudyAxis axis;
  axis.key = text.substr(0, equals);
  const bool known = axis.key == "method" || axis.key == "penalty" || axis.key == "tolerance" ||
                     axis.key == "scheme";
  axis.change = axis.key == "dt" ? "/time_step" : known ? "/" + axis.key : axis.key;
  axis.numerical = std::ranges::find(kNumerical, axis.change) != kNumerical.end();
  for (std::size_t from = equals + 1; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    if (comma == from) throw std::invalid_argument("--vary " + text + ": a value is empty");
    axis.values.push_back(text.substr(from, comma - from));
    from = comma + 1;
  }
  return axis;
}

std::vector<StudyPoint> grid(const std::vector<StudyAxis>& axes) {
  std::vector<StudyPoint> points(1);
  for (const StudyAxis& axis : axes) {
    std::vector<StudyPoint> next;
    for (const StudyPoint& point : points) {
      for (const std::string& value : axis.values) {
        next.push_back(point);
        next.back().values.push_back(value);
      }
    }
    points.swap(next);
  }
  return points;
}

std::vector<std::string> changes_of(const std::vector<StudyAxis>& axes, const StudyPoint& point) {
  std::vector<std::string> changes;
  for (std::size_t k = 0; k < axes.size(); ++k)
    if (!axes[k].change.empty()) changes.push_back(axes[k].change + "=" + point.values[k]);
  return changes;
}

void run_points(std::vector<StudyPoint>& points, int jobs,
                const std::function<void(StudyPoint&)>& run,
                const std::function<void(std::size_t)>& progress) {
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  std::mutex telling;
  const auto work = [&] {
    for (std::size_t i = next++; i < points.size(); i = next++) {
      try {
        run(points[i]);
      } catch (const std::exception& error) {
        points[i].failure = error.what();
      }
      const std::lock_guard lock(telling);
      progress(++done);
    }
  };
  std::vector<std::jthread> workers;
  try {
    for (int w = 1; w < jobs; ++w) workers.emplace_back(work);
  } catch (const std::system_error&) {
    // The machine gives no more threads: those that are there do all of it.
  }
  work();
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double largest_error(const std::vector<ReferenceResult>& references) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const ReferenceResult& r : references) {
    if (r.compared == 0) throw std::runtime_error("no step ended at the time of a reference");
    if (!(r.error <= largest)) largest = r.error;  // the first one, and NaN stays to be seen
    if (std::isnan(r.error)) break;
  }
  return largest;
}

void compare_with_finest(const std::vector<StudyAxis>& axes, std::vector<StudyPoint>& points) {
  std::map<std::vector<std::string>, std::vector<StudyPoint*>> scenes;
  for (StudyPoint& point : points) {
    std::vector<std::string> scene;
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (!axes[i].numerical) scene.push_back(point.values[i]);
    scenes[scene].push_back(&point);
  }
  for (const auto& [scene, members] : scenes) {
    std::vector<StudyPoint> own;
    for (const StudyPoint* point : members) own.push_back(*point);
    compare_with(finest_ends(own), own);
    for (std::size_t i = 0; i < own.size(); ++i) *members[i] = std::move(own[i]);
  }
}

std::vector<Vector3> finest_ends(const std::vector<StudyPoint>& points) {
  const StudyPoint* finest = nullptr;
  for (const StudyPoint& point : points) {
    if (!point.failure.empty()) continue;
    if (finest == nullptr || point.time_step < finest->time_step) finest = &point;
  }
  return finest == nullptr ? std::vector<Vector3>() : finest->ends;
}

void compare_with(const std::vector<Vector3>& ends, std::vector<StudyPoint>& points) {
  double scale = 0.0;
  for (const Vector3& end : ends) scale = std::max(scale, end.norm());
  for (StudyPoint& point : points) {
    if (!point.failure.empty() || point.ends.size() != ends.size() || point.ends == ends) continue;
    double worst = 0.0;
    for (std::size_t m = 0; m < ends.size(); ++m)
      worst = std::max(worst, (point.ends[m] - ends[m]).norm());
    point.error = scale > 0.0 ? worst / scale : worst;
  }
}

void mark_best(std::vector<StudyPoint>& points) {
  for (StudyPoint& point : points) {
    point.best =
        counts(point) && std::none_of(points.begin(), points.end(), [&](const auto& other) {
          return counts(other) && beats(other, point);
        });
  }
}

void write_csv(const std::vector<StudyAxis>& axes, const std::vector<StudyPoint>& points,
               std::FILE* out) {
  for (const StudyAxis& axis : axes) std::fprintf(out, "%s,", csv_field(axis.key).c_str());
  std::fprintf(out,
               "error,cpu_seconds,largest_overlap,energy_growth,solves_per_step,pareto,failure\n");
  for (const StudyPoint& p : points) {
    for (const std::string& value : p.values) std::fprintf(out, "%s,", csv_field(value).c_str());
    std::fprintf(out, "%.6g,%.4g,%.4g,%.4g,%.4g,%d,%s\n", p.error, p.cpu_seconds, p.largest_overlap,
                 p.energy_growth, p.solves_per_step, p.best ? 1 : 0,
                 csv_field(printable(p.failure, 600)).c_str());
  }
}

nlohmann::ordered_json to_json(const std::string& scene, const std::vector<StudyAxis>& axes,
                               const std::vector<StudyPoint>& points) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const StudyPoint& p : points) {
    nlohmann::ordered_json object;
    for (std::size_t k = 0; k < axes.size(); ++k) object["settings"][axes[k].key] = p.values[k];
    object["time_step"] = p.time_step;
    object["error"] = number(p.error);
    object["cpu_seconds"] = p.cpu_seconds;
    object["largest_overlap"] = number(p.largest_overlap);
    object["energy_growth"] = number(p.energy_growth);
    object["solves_per_step"] = p.solves_per_step;
    object["pareto"] = p.best;
    object["failure"] = p.failure;
    object["ends"] = nlohmann::ordered_json::array();
    for (const Vector3& end : p.ends)
      object["ends"].push_back({number(end.x()), number(end.y()), number(end.z())});
    list.push_back(object);
  }
  return {{"scene", scene}, {"points", list}};
}

}  // namespace quoin::scene_file
