/// quoin validate [CASE…]: the cases with exact answers, or how they converge, as a table or JSON.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "scene_file/cases.hpp"
#include "shared_file.hpp"

namespace quoin::commands {
namespace {

using Row = scene_file::CaseRow;
using Series = scene_file::CaseSeries;
using Cases = std::vector<scene_file::CaseFile>;

void print_head() {
  std::printf("%-4s %-68s %20s %20s %10s %10s %-3s %8s\n", "case", "quantity", "exact", "result",
              "error", "allowed", "ok", "s");
}

void print(const Row& row) {
  std::printf("%-4s %-68s %20.13g %20.13g %10.2e %10.1e %-3s %8.2f\n", row.case_name.c_str(),
              row.quantity.c_str(), row.exact, row.result, row.error, row.allowed,
              row.ok ? "yes" : "NO", row.seconds);
  std::fflush(stdout);
}

nlohmann::ordered_json to_json(const Row& row) {
  return {{"case", row.case_name}, {"quantity", row.quantity}, {"exact", row.exact},
          {"result", row.result},  {"error", row.error},       {"allowed", row.allowed},
          {"ok", row.ok},          {"seconds", row.seconds}};
}

/// NaN is null: JSON has no other word for it.
nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

void print(const Series& series) {
  const bool penalty = series.refined == "penalty";
  std::printf("%s  %s against %s\n", series.case_name.c_str(), series.quantity.c_str(),
              penalty ? "penalty [N/m]" : "dt [s]");
  for (std::size_t i = 0; i < series.errors.size(); ++i) {
    std::printf("  %12g  %10.2e", series.values[i], series.errors[i]);
    if (series.errors[i] <= series.floor) {
      std::printf("     floor");
    } else if (i > 0) {
      std::printf("  %8.2f", std::log(series.errors[i - 1] / series.errors[i]) /
                                 std::abs(std::log(series.values[i - 1] / series.values[i])));
    }
    std::printf("\n");
  }
  if (!series.failure.empty()) std::printf("  broke off: %s\n", series.failure.c_str());
  std::printf("  order %.2f (expected %g), floor %g reached at %g: %s, %.1f s\n\n", series.order(),
              series.expected_order, series.floor, series.stops_at(), series.ok() ? "ok" : "NOT OK",
              series.seconds);
  std::fflush(stdout);
}

nlohmann::ordered_json to_json(const Series& series) {
  return {{"case", series.case_name},
          {"quantity", series.quantity},
          {"refined", series.refined},
          {"values", series.values},
          {"errors", series.errors},
          {"order", number(series.order())},
          {"expected_order", series.expected_order},
          {"floor", series.floor},
          {"stops_at", number(series.stops_at())},
          {"failure", series.failure},
          {"ok", series.ok()},
          {"seconds", series.seconds}};
}

struct Options {
  std::vector<std::string> names;
  std::string folder;
  bool json = false, list = false, convergence = false;
};

/// The cases by name, all when none is named. Throws std::invalid_argument for an unknown one.
Cases choose(const Options& options) {
  Cases cases = scene_file::read_cases(options.folder.empty() ? shared_file("scenes/validation")
                                                              : options.folder);
  for (const std::string& name : options.names) {
    const auto is_meant = [&](const auto& which) { return which.name() == name; };
    if (std::ranges::none_of(cases, is_meant)) {
      throw std::invalid_argument("there is no case " + name +
                                  " (quoin validate --list names them)");
    }
    const auto has_series = [&](const auto& which) {
      return is_meant(which) && which.has_series();
    };
    if (options.convergence && std::ranges::none_of(cases, has_series))
      throw std::invalid_argument(name + " has no series against time step or penalty");
  }
  std::erase_if(cases, [&](const auto& which) {
    return !options.names.empty() && std::ranges::count(options.names, which.name()) == 0;
  });
  return cases;
}

int list(const Options& options) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const auto& which : choose(options)) {
    if (!options.json) std::printf("%-4s %s\n", which.name().c_str(), which.title().c_str());
    all.push_back({{"case", which.name()}, {"title", which.title()}});
  }
  if (options.json) std::printf("%s\n", all.dump(1).c_str());
  return kDone;
}

/// Flags that a run raised and its file does not name, or the other way round: a row of their own.
std::vector<Row> rows_of(const scene_file::CaseFile& which, const scene_file::CaseRun& run) {
  scene_file::CaseOutcome outcome = which.run(run);
  if (outcome.flags != run.flags) {
    std::string flags;
    for (const std::string& flag : outcome.flags) flags += " " + flag;
    const double none = std::numeric_limits<double>::quiet_NaN();
    outcome.rows.push_back({.case_name = which.name(),
                            .quantity = run.name + ": flags other than the file's:" + flags,
                            .result = none,
                            .error = none});
  }
  return outcome.rows;
}

/// Runs the cases and shows their rows or series; kFailed when one is not ok.
int validate(const Options& options) {
  const Cases cases = choose(options);
  if (!options.json && !options.convergence) print_head();
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::size_t count = 0, failed = 0;
  const auto show = [&](const auto& result, bool ok) {
    ++count;
    failed += ok ? 0U : 1U;
    options.json ? list.push_back(to_json(result)) : print(result);
  };
  const auto run_all = [&](const scene_file::CaseFile& which) {
    if (options.convergence) {
      for (const Series& series : which.series()) show(series, series.ok());
      return;
    }
    for (const auto& run : which.runs())
      for (const Row& row : rows_of(which, run)) show(row, row.ok);
  };
  for (const auto& which : cases) scene_file::in_file(which.path(), [&] { run_all(which); });
  if (options.json)
    std::printf("%s\n", list.dump(1).c_str());
  else
    std::printf("%zu rows, %zu not ok\n", count, failed);
  return failed == 0 ? kDone : kFailed;
}

int asked(const Options& words) { return words.list ? list(words) : validate(words); }

}  // namespace

void add_validate_command(CLI::App& app, int& exit_code) {
  const auto [command, words] =
      add_command<Options>(app, exit_code, asked, "validate",
                           "Runs the cases with exact answers; exit code 1 when a row is not ok");
  command.add_option("case", words.names, "Cases to run, such as V05 (default: all)");
  command.add_option("--folder", words.folder, "Case files, JSON (default: those of quoin)");
  command.add_flag("--json", words.json, "A list of objects instead of a table");
  command.add_flag("--convergence", words.convergence,
                   "Errors against time step and penalty instead, for the cases that have such "
                   "series (picture: bench/tables.py)");
  command.add_flag("--list", words.list, "Names and titles of the cases, which are not run");
}

}  // namespace quoin::commands
