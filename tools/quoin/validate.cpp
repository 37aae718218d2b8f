/// quoin validate [CASE…]: the cases with exact answers, or how they converge, as a table or JSON.

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "validation/cases.hpp"

namespace quoin::commands {
namespace {

using validation::Case;
using validation::Refined;
using validation::Row;
using validation::Series;

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

const Case* find_case(const std::string& name) {
  for (const Case& which : validation::cases()) {
    if (which.name == name) return &which;
  }
  return nullptr;
}

/// NaN is null: JSON has no other word for it.
nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

void print(const Series& series) {
  const bool penalty = series.refined == Refined::Penalty;
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
          {"refined", series.refined == Refined::Penalty ? "penalty" : "time_step"},
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

/// The cases by name, all when none is named. An unknown one is told, and the answer is empty.
std::vector<const Case*> choose(const std::vector<std::string>& names) {
  std::vector<const Case*> chosen;
  for (const std::string& name : names) {
    chosen.push_back(find_case(name));
    if (chosen.back() != nullptr) continue;
    std::fprintf(stderr, "quoin validate: there is no case %s (quoin validate --list names them)\n",
                 name.c_str());
    return {};
  }
  if (names.empty()) {
    for (const Case& which : validation::cases()) chosen.push_back(&which);
  }
  return chosen;
}

/// Runs `results` of each case and shows them; kFailed when one is not ok.
template <class Results, class Ok>
int show(const std::vector<const Case*>& chosen, bool json, Results results, Ok ok) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::size_t count = 0, failed = 0;
  for (const Case* which : chosen) {
    for (const auto& result : results(*which)) {
      ++count;
      failed += ok(result) ? 0U : 1U;
      json ? list.push_back(to_json(result)) : print(result);
    }
  }
  if (json) {
    std::printf("%s\n", list.dump(1).c_str());
  } else {
    std::printf("%zu rows, %zu not ok\n", count, failed);
  }
  return failed == 0 ? kDone : kFailed;
}

int list(const std::vector<std::string>& names, bool json) {
  const std::vector<const Case*> chosen = choose(names);
  if (chosen.empty()) return kBadInput;
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const Case* which : chosen) {
    if (!json) std::printf("%-4s %s\n", which->name.data(), which->title.data());
    all.push_back({{"case", which->name}, {"title", which->title}});
  }
  if (json) std::printf("%s\n", all.dump(1).c_str());
  return kDone;
}

int validate(const std::vector<std::string>& names, bool json) {
  const std::vector<const Case*> chosen = choose(names);
  if (chosen.empty()) return kBadInput;
  if (!json) print_head();
  return show(chosen, json, validation::run, [](const Row& row) { return row.ok; });
}

int converge(const std::vector<std::string>& names, bool json) {
  const std::vector<const Case*> chosen = choose(names);
  if (chosen.empty()) return kBadInput;
  for (const Case* which : chosen) {
    if (names.empty() || which->converge != nullptr) continue;
    std::fprintf(stderr, "quoin validate: %s has no series against time step or penalty\n",
                 which->name.data());
    return kBadInput;
  }
  return show(chosen, json, validation::converge, [](const Series& series) { return series.ok(); });
}

}  // namespace

void add_validate_command(CLI::App& app, int& exit_code) {
  struct Options {
    std::vector<std::string> names;
    bool json = false;
    bool list = false;
    bool convergence = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "validate", "Runs the cases with exact answers; exit code 1 when a row is not ok");
  command->add_option("case", options->names, "Cases to run, such as V05 (default: all)");
  command->add_flag("--json", options->json, "A list of objects instead of a table");
  command->add_flag("--convergence", options->convergence,
                    "Errors against time step and penalty instead, for the cases that have such "
                    "series (picture: plot_convergence.py)");
  command->add_flag("--list", options->list, "Names and titles of the cases, which are not run");
  command->callback([options, &exit_code] {
    exit_code = options->list          ? list(options->names, options->json)
                : options->convergence ? converge(options->names, options->json)
                                       : validate(options->names, options->json);
  });
}

}  // namespace quoin::commands
