/// quoin validate [CASE…]: the cases with exact answers, as a table or JSON.

#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "validation/cases.hpp"

namespace quoin::commands {
namespace {

using validation::Case;
using validation::Row;

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

int validate(const std::vector<std::string>& names, bool json) {
  std::vector<const Case*> chosen;
  for (const std::string& name : names) {
    chosen.push_back(find_case(name));
    if (chosen.back() != nullptr) continue;
    std::fprintf(stderr, "quoin validate: there is no case %s (quoin validate --list names them)\n",
                 name.c_str());
    return kBadInput;
  }
  if (names.empty()) {
    for (const Case& which : validation::cases()) chosen.push_back(&which);
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::size_t rows = 0, failed = 0;
  if (!json) print_head();
  for (const Case* which : chosen) {
    for (const Row& row : validation::run(*which)) {
      ++rows;
      failed += row.ok ? 0U : 1U;
      json ? list.push_back(to_json(row)) : print(row);
    }
  }
  if (json) {
    std::printf("%s\n", list.dump(1).c_str());
  } else {
    std::printf("%zu rows, %zu not ok\n", rows, failed);
  }
  return failed == 0 ? kDone : kFailed;
}

}  // namespace

void add_validate_command(CLI::App& app, int& exit_code) {
  struct Options {
    std::vector<std::string> names;
    bool json = false;
    bool list = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "validate", "Runs the cases with exact answers; exit code 1 when a row is not ok");
  command->add_option("case", options->names, "Cases to run, such as V05 (default: all)");
  command->add_flag("--json", options->json, "A list of objects instead of a table");
  command->add_flag("--list", options->list, "Names and titles of the cases");
  command->callback([options, &exit_code] {
    if (!options->list) {
      exit_code = validate(options->names, options->json);
      return;
    }
    for (const Case& which : validation::cases()) {
      std::printf("%-4s %s\n", which.name.data(), which.title.data());
    }
  });
}

}  // namespace quoin::commands
