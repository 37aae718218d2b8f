/// `quoin stability`: the table of extreme cells.

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>

#include "commands.hpp"
#include "path_to_write.hpp"
#include "scene_file/scene_error.hpp"
#include "stability/cell.hpp"

namespace quoin::commands {
namespace {

using stability::Cell;

struct Arguments {
  bool json = false, quick = false;
  std::string filter = ".*";
  std::string out;  ///< file that grows with every cell and is taken up again; none: empty
};

constexpr double kMostFlagged = 0.1;  // of all cells: a table of flags judges nothing

struct Judged {
  std::string verdict;
  std::vector<std::string> flags{};
  stability::Result result{};
  double seconds = 0.0;
};

/// Only the source's own methods may leave a step unsolved, where the list says so.
bool must_converge(const Cell& cell) {
  return cell.method != solver::ContactMethod::Paper &&
         cell.method != solver::ContactMethod::Penalty;
}

std::string verdict_of(const Cell& cell, const Judged& judged,
                       const std::vector<std::string>& expected) {
  if (judged.result.evidence.unconverged > 0 && must_converge(cell)) return "unconverged";
  if (judged.flags != expected) return "unexpected";
  if (!judged.flags.empty()) return "flagged";
  return judged.result.error <= cell.allowed ? "right" : "wrong";
}

Judged judge(const Cell& cell, const std::vector<std::string>& expected) {
  Judged judged;
  const auto start = std::chrono::steady_clock::now();
  judged.result = cell.run();
  judged.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  judged.flags = stability::flag_names(judged.result.evidence);
  judged.verdict = verdict_of(cell, judged, expected);
  return judged;
}

double solves_per_step(const stability::Evidence& evidence) {
  return static_cast<double>(evidence.solves) / static_cast<double>(std::max(evidence.steps, 1L));
}

nlohmann::ordered_json parameters_of(const Cell& cell) {
  nlohmann::ordered_json parameters;
  for (const stability::Parameter& p : cell.parameters) parameters[p.name] = p.value;
  return parameters;
}

nlohmann::ordered_json to_json(const Cell& cell, const Judged& judged,
                               const std::vector<std::string>& expected) {
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
  };
  nlohmann::ordered_json object;
  object["cell"] = stability::row_name(cell);
  object["parameters"] = parameters_of(cell);
  object["verdict"] = judged.verdict;
  object["flags"] = judged.flags;
  object["expected_flags"] = expected;
  object["error"] = number(judged.result.error);
  object["allowed"] = cell.allowed;
  object["solves_per_step"] = solves_per_step(judged.result.evidence);
  object["unconverged_steps"] = judged.result.evidence.unconverged;
  object["seconds"] = judged.seconds;
  return object;
}

void print(const nlohmann::ordered_json& row) {
  const nlohmann::ordered_json& parameters = row["parameters"];
  std::string flags;
  for (const std::string flag : row["flags"]) flags += " [" + flag + "]";
  if (row["flags"] != row["expected_flags"]) flags += " expected " + row["expected_flags"].dump();
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::printf("%-11s %-46s %9.3g  error %9.2e allowed %.0e  solves %6.2f  unconverged %ld%s\n",
              row["verdict"].get<std::string>().c_str(), row["cell"].get<std::string>().c_str(),
              parameters.front().get<double>(),
              row["error"].is_null() ? none : row["error"].get<double>(),
              row["allowed"].get<double>(), row["solves_per_step"].get<double>(),
              row["unconverged_steps"].get<long>(), flags.c_str());
  std::fflush(stdout);
}

/// Rows of an earlier run that was broken off, by cell and parameters.
using Rows = std::map<std::string, nlohmann::ordered_json>;

std::string key(const std::string& cell, const nlohmann::ordered_json& parameters) {
  return cell + parameters.dump();
}

Rows read_rows(const std::string& path) {
  Rows rows;
  if (!std::filesystem::exists(path)) return rows;
  std::ifstream in(path);
  if (!in || std::filesystem::is_directory(path)) {
    throw scene_file::FileError(path + ": can't be read");
  }
  try {
    for (const auto& row : nlohmann::ordered_json::parse(in)) {
      rows[key(row.at("cell"), row.at("parameters"))] = row;
    }
  } catch (const nlohmann::json::exception&) {
    throw std::runtime_error(path + ": holds no cells that quoin stability wrote");
  }
  return rows;
}

/// `list` and what is left of earlier rows. The file is whole at any time: written beside its name,
/// then moved.
void write_rows(const std::string& path, nlohmann::ordered_json list, const Rows& left) {
  const std::string part = path + ".part";
  for (const auto& [name, row] : left) list.push_back(row);
  {
    std::ofstream out(part);
    out << list.dump(1) << "\n";
    if (!out.flush()) throw scene_file::unwritable(part);
  }
  std::filesystem::rename(part, path);
}

std::vector<Cell> chosen_cells(const Arguments& arguments) {
  std::regex wanted;
  try {
    wanted = arguments.filter;
  } catch (const std::regex_error& error) {
    throw std::invalid_argument("--filter " + arguments.filter + ": " + error.what());
  }
  std::vector<Cell> cells = stability::all_cells(
      arguments.quick ? stability::Extent::Quick : stability::Extent::Full, shared_file("scenes"));
  std::erase_if(cells, [&](const Cell& cell) {
    return !std::regex_search(stability::row_name(cell), wanted);
  });
  if (cells.empty()) throw std::invalid_argument("--filter " + arguments.filter + ": no such cell");
  return cells;
}

/// What is said at the end; true when every cell is right, or flagged as expected and not too many
/// are.
bool sum_up(const nlohmann::ordered_json& list, bool whole) {
  std::map<std::string, int> count;
  int right_flagged = 0;
  for (const auto& row : list) {
    const std::string verdict = row["verdict"];
    ++count[verdict];
    right_flagged += verdict == "flagged" && !row["error"].is_null() &&
                     row["error"].get<double>() <= row["allowed"].get<double>();
  }
  const int bad = static_cast<int>(list.size()) - count["right"] - count["flagged"];
  const bool too_many = whole && count["flagged"] > kMostFlagged * static_cast<double>(list.size());
  std::fprintf(stderr,
               "%d right, %d flagged as expected (%d of them right all the same)%s; %d WRONG, "
               "%d UNEXPECTED, %d UNCONVERGED\n",
               count["right"], count["flagged"], right_flagged,
               too_many ? ": TOO MANY, a tenth of the cells at most" : "", count["wrong"],
               count["unexpected"], count["unconverged"]);
  return bad == 0 && !too_many;
}

int run(const Arguments& arguments) {
  const std::vector<Cell> cells = chosen_cells(arguments);
  const stability::ExpectedFlags expected(
      stability::all_cells(stability::Extent::Full, shared_file("scenes")));
  Rows left = arguments.out.empty() ? Rows() : read_rows(arguments.out);
  const bool progress = isatty(STDERR_FILENO) != 0;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    const auto known = left.extract(key(stability::row_name(cell), parameters_of(cell)));
    if (progress) {
      std::fprintf(stderr, "\r\033[K%zu of %zu: %s", i + 1, cells.size(),
                   stability::row_name(cell).c_str());
    }
    list.push_back(known ? known.mapped()
                         : to_json(cell, judge(cell, expected.of(cell)), expected.of(cell)));
    if (!arguments.out.empty()) write_rows(arguments.out, list, left);
    if (!arguments.json) print(list.back());
  }
  if (progress) std::fprintf(stderr, "\r\033[K");
  if (arguments.json) std::printf("%s\n", list.dump(1).c_str());
  return sum_up(list, arguments.filter == Arguments().filter) ? kDone : kFailed;
}

}  // namespace

void add_stability_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "stability",
      "Extreme parameters against exact answers: right, flagged as expected, or a failure");
  command->add_flag("--json", arguments->json, "a list of objects on standard output");
  command->add_flag("--quick", arguments->quick, "long runs end after 1e4 steps instead of 1e6");
  command
      ->add_option("--out", arguments->out,
                   "file of the same objects that grows with every cell; a run that was broken "
                   "off goes on from it")
      ->check(path_to_write());
  command->add_option("--filter", arguments->filter, "only cells that match this expression");
  command->callback([arguments, &exit_code] {
    exit_code = run_guarded([&] { return run(*arguments); }, "quoin stability");
  });
}

}  // namespace quoin::commands
