/// `quoin stability`: the table of extreme cells.

#include <unistd.h>

#include <algorithm>
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
#include "scene_file/cases.hpp"
#include "scene_file/scene_error.hpp"
#include "shared_file.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;

/// A run of a case file, with its one row.
struct Cell {
  const scene_file::CaseFile* file;
  scene_file::CaseRun run;

  /// "penalty / slide / paper": what is varied and the run.
  std::string name() const { return run.parameters.at(0).first + " / " + run.name; }
};

struct Arguments {
  bool json = false, quick = false;
  std::string filter = ".*";
  std::string out;  ///< file that grows with every cell and is taken up again; none: empty
};

constexpr double kMostFlagged = 0.1;  // of all cells: a table of flags judges nothing

std::string verdict_of(const Cell& cell, const scene_file::CaseOutcome& outcome) {
  if (outcome.unconverged > 0 && !outcome.may_fail) return "unconverged";
  if (outcome.flags != cell.run.flags) return "unexpected";
  if (!outcome.flags.empty()) return "flagged";
  const bool right = std::ranges::all_of(outcome.rows, [](const auto& row) { return row.ok; });
  return right ? "right" : "wrong";
}

json parameters_of(const Cell& cell) {
  json parameters;
  for (const auto& [name, value] : cell.run.parameters) parameters[name] = value;
  return parameters;
}

json judged(const Cell& cell) {
  const scene_file::CaseOutcome outcome = cell.file->run(cell.run);
  const scene_file::CaseRow& row = outcome.rows.at(0);
  const auto steps = static_cast<double>(std::max(outcome.steps, 1L));
  return {{"cell", cell.name()},
          {"parameters", parameters_of(cell)},
          {"verdict", verdict_of(cell, outcome)},
          {"flags", outcome.flags},
          {"expected_flags", cell.run.flags},
          {"error", std::isfinite(row.error) ? json(row.error) : json()},
          {"allowed", row.allowed},
          {"solves_per_step", static_cast<double>(outcome.solves) / steps},
          {"unconverged_steps", outcome.unconverged},
          {"seconds", outcome.seconds}};
}

void print_cell(const json& row) {
  const json& parameters = row["parameters"];
  std::string flags;
  for (const std::string flag : row["flags"]) flags += " [" + flag + "]";
  if (row["flags"] != row["expected_flags"]) flags += " expected " + row["expected_flags"].dump();
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::printf("%-11s %-46s %9.3g  error %9.2e allowed %.0e  solves %6.2f  unconverged %ld%s\n",
              words(row["verdict"]), words(row["cell"]), parameters.front().get<double>(),
              row["error"].is_null() ? none : row["error"].get<double>(),
              row["allowed"].get<double>(), row["solves_per_step"].get<double>(),
              row["unconverged_steps"].get<long>(), flags.c_str());
  std::fflush(stdout);
}

/// Rows of an earlier run that was broken off, by cell and parameters.
using Rows = std::map<std::string, json>;

std::string key(const std::string& cell, const json& parameters) {
  return cell + parameters.dump();
}

Rows read_rows(const std::string& path) {
  Rows rows;
  if (!std::filesystem::exists(path)) return rows;
  std::ifstream in(path);
  if (!in || std::filesystem::is_directory(path))
    throw scene_file::FileError(path + ": can't be read");
  try {
    for (const auto& row : json::parse(in)) rows[key(row.at("cell"), row.at("parameters"))] = row;
  } catch (const json::exception&) {
    throw std::runtime_error(path + ": holds no cells that quoin stability wrote");
  }
  return rows;
}

/// `list` and what is left of earlier rows. The file is whole at any time: written beside its name,
/// then moved.
void write_rows(const std::string& path, json list, const Rows& left) {
  const std::string part = path + ".part";
  for (const auto& [name, row] : left) list.push_back(row);
  {
    std::ofstream out(part);
    out << list.dump(1) << "\n";
    if (!out.flush()) throw scene_file::unwritable(part);
  }
  std::filesystem::rename(part, path);
}

std::vector<Cell> chosen_cells(const Arguments& arguments,
                               const std::vector<scene_file::CaseFile>& files) {
  std::regex wanted;
  try {
    wanted = arguments.filter;
  } catch (const std::regex_error& error) {
    throw std::invalid_argument("--filter " + arguments.filter + ": " + error.what());
  }
  std::vector<Cell> cells;
  for (const scene_file::CaseFile& file : files) {
    for (scene_file::CaseRun& run : file.runs(arguments.quick)) {
      cells.push_back({&file, std::move(run)});
      if (!std::regex_search(cells.back().name(), wanted)) cells.pop_back();
    }
  }
  if (cells.empty()) throw std::invalid_argument("--filter " + arguments.filter + ": no such cell");
  return cells;
}

/// What is said at the end; true when every cell is right, or flagged as expected and not too many
/// are.
bool sum_up(const json& list, bool whole) {
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
  const std::vector<scene_file::CaseFile> files =
      scene_file::read_cases(shared_file("scenes/stability"));
  const std::vector<Cell> cells = chosen_cells(arguments, files);
  Rows left = arguments.out.empty() ? Rows() : read_rows(arguments.out);
  const bool progress = isatty(STDERR_FILENO) != 0;
  json list = json::array();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    const auto known = left.extract(key(cell.name(), parameters_of(cell)));
    if (progress)
      std::fprintf(stderr, "\r\033[K%zu of %zu: %s", i + 1, cells.size(), cell.name().c_str());
    list.push_back(known ? known.mapped() : judged(cell));
    if (!arguments.out.empty()) write_rows(arguments.out, list, left);
    if (!arguments.json) print_cell(list.back());
  }
  if (progress) std::fprintf(stderr, "\r\033[K");
  if (arguments.json) std::printf("%s\n", list.dump(1).c_str());
  return sum_up(list, arguments.filter == Arguments().filter) ? kDone : kFailed;
}

}  // namespace

void add_stability_command(CLI::App& app, int& exit_code) {
  const auto [command, words] = add_command<Arguments>(
      app, exit_code, run, "stability",
      "Extreme parameters against exact answers: right, flagged as expected, or a failure");
  command.add_flag("--json", words.json, "a list of objects on standard output");
  command.add_flag("--quick", words.quick, "long runs end after 1e4 steps instead of 1e6");
  add_path(command, "--out", words.out,
           "file of the same objects that grows with every cell; a run that was broken "
           "off goes on from it");
  command.add_option("--filter", words.filter, "only cells that match this expression");
}

}  // namespace quoin::commands
