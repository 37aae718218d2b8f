/// `quoin stability`: the table of extreme cells.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>

#include "commands.hpp"
#include "stability/cell.hpp"

namespace quoin::commands {
namespace {

using stability::Cell;

struct Arguments {
  bool json = false, quick = false;
  std::string filter = ".*";
};

struct Judged {
  std::string verdict = "right";
  std::vector<std::string> flags{};
  stability::Result result{};
  double seconds = 0.0;
};

Judged judge(const Cell& cell) {
  Judged judged;
  const auto start = std::chrono::steady_clock::now();
  judged.result = cell.run();
  judged.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  judged.flags = stability::flags(judged.result.evidence, cell.allowed);
  if (!judged.flags.empty()) {
    judged.verdict = "flagged";
  } else if (!(judged.result.error <= cell.allowed)) {
    judged.verdict = "wrong";
  }
  return judged;
}

double solves_per_step(const stability::Evidence& evidence) {
  return static_cast<double>(evidence.solves) /
         static_cast<double>(std::max(evidence.steps, 1L));
}

nlohmann::ordered_json to_json(const Cell& cell, const Judged& judged) {
  nlohmann::ordered_json parameters;
  for (const stability::Parameter& p : cell.parameters) parameters[p.name] = p.value;
  if (!judged.flags.empty()) parameters["flags"] = judged.flags;
  nlohmann::ordered_json object;
  object["cell"] = cell.parameters.front().name + " / " + cell.name;
  object["parameters"] = parameters;
  object["verdict"] = judged.verdict;
  object["error"] = std::isfinite(judged.result.error) ? nlohmann::ordered_json(judged.result.error) : nlohmann::ordered_json();
  object["allowed"] = cell.allowed;
  object["solves_per_step"] = solves_per_step(judged.result.evidence);
  object["unconverged_steps"] = judged.result.evidence.unconverged;
  object["seconds"] = judged.seconds;
  return object;
}

void print(const Cell& cell, const Judged& judged) {
  const stability::Evidence& evidence = judged.result.evidence;
  std::string flags;
  for (const std::string& flag : judged.flags) flags += " [" + flag + "]";
  std::printf("%-7s %-16s %9.3g  %-34s error %9.2e allowed %.0e  solves %6.2f  cuts %4ld  unconverged %ld%s\n",
              judged.verdict.c_str(), cell.parameters.front().name.c_str(),
              cell.parameters.front().value, cell.name.c_str(), judged.result.error, cell.allowed,
              solves_per_step(evidence), evidence.cuts, evidence.unconverged, flags.c_str());
  std::fflush(stdout);
}

int run(const Arguments& arguments) {
  const std::regex wanted(arguments.filter);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  int right = 0, flagged = 0, right_flagged = 0, wrong = 0;
  for (const Cell& cell :
       stability::all_cells(arguments.quick ? stability::Extent::Quick : stability::Extent::Full)) {
    if (!std::regex_search(cell.parameters.front().name + " / " + cell.name, wanted)) continue;
    const Judged judged = judge(cell);
    right += judged.verdict == "right";
    wrong += judged.verdict == "wrong";
    flagged += judged.verdict == "flagged";
    right_flagged += judged.verdict == "flagged" && judged.result.error <= cell.allowed;
    if (arguments.json) {
      list.push_back(to_json(cell, judged));
    } else {
      print(cell, judged);
    }
  }
  if (arguments.json) {
    std::printf("%s\n", list.dump(1).c_str());
  } else {
    std::printf("%d right, %d flagged (%d of them right all the same), %d WRONG\n", right, flagged,
                right_flagged, wrong);
  }
  return wrong == 0 ? kDone : kFailed;
}

}  // namespace

void add_stability_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "stability", "Extreme parameters against exact answers: right, flagged or wrong");
  command->add_flag("--json", arguments->json, "a list of objects on standard output");
  command->add_flag("--quick", arguments->quick, "long runs end after 1e4 steps instead of 1e6");
  command->add_option("--filter", arguments->filter, "only cells that match this expression");
  command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace quoin::commands
