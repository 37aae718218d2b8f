/// The program quoin-referee, as which `quoin referee` runs: the same pairs to several contact
/// libraries, each answer judged exactly.

#include "referee/referee.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>

#include "command_line.hpp"
#include "commands.hpp"
#include "in_range.hpp"
#include "output_folder.hpp"
#include "path_to_write.hpp"
#include "python_program.hpp"
#include "referee/pair_set.hpp"
#include "referee/pairs/families.hpp"
#include "scene_file/read_json.hpp"
#include "scene_file/read_shape.hpp"
#include "scene_file/scene_error.hpp"
#include "stop.hpp"

namespace quoin::commands {
namespace {

namespace fs = std::filesystem;
using scene_file::FileError;

constexpr double kLargestCoordinate = 1e100;  // m

struct Words {
  std::vector<std::string> plugins;
  std::string family, pairs, json, report, write_pairs;
  std::optional<long> count;
  std::optional<double> seconds;
  /// Without either.
  static constexpr long kUsualCount = 10000;
  std::uint64_t seed = 1;
  int steps = 1;
  double limit = 2.0;  ///< s
};

/// The plug-ins built or installed with this command.
std::vector<std::string> shipped_plugins() {
  std::error_code none;
  const fs::path command = fs::read_symlink("/proc/self/exe", none);
  for (const fs::path& folder :
       {command.parent_path().parent_path() / QUOIN_PLUGIN_DIR, fs::path(QUOIN_BUILT_PLUGINS)}) {
    std::vector<std::string> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, none))
      if (entry.path().extension() == ".so") files.push_back(entry.path().string());
    if (!files.empty()) {
      std::sort(files.begin(), files.end());
      return files;
    }
  }
  throw FileError("no plug-in is installed; --plugin FILE.so names one");
}

std::vector<int> chosen_families(const std::string& pattern) {
  std::vector<int> chosen;
  const std::vector<std::string>& names = referee::family_names();
  try {
    const std::regex wanted(pattern);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (std::regex_search(names[i], wanted)) chosen.push_back(static_cast<int>(i));
  } catch (const std::regex_error&) {
    throw std::invalid_argument("--family: is no regular expression");
  }
  if (chosen.empty()) throw std::invalid_argument("--family: no family's name matches");
  return chosen;
}

referee::Solid read_solid(const nlohmann::json& line, const char* body) {
  if (!line.contains(body)) throw geometry::InputError("\"" + std::string(body) + "\" is missing");
  const scene_file::PlacedPoints placed = scene_file::read_placed_points(line[body], body);
  if (placed.points.cols() == 0)
    throw geometry::InputError("\"" + std::string(body) + "\" has no points");
  if (placed.points.cwiseAbs().maxCoeff() > kLargestCoordinate) {
    throw geometry::InputError("\"" + std::string(body) +
                               "\" has a coordinate above 1e100 m: volumes would overflow");
  }
  return {placed.points, placed.placement};
}

std::vector<referee::SolidPair> read_pairs(const std::string& path) {
  std::ifstream in(path);
  if (!in || fs::is_directory(path)) throw FileError(path + ": can't be read");
  std::vector<referee::SolidPair> pairs;
  long number = 0;
  for (std::string text; std::getline(in, text);) {
    ++number;
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      const nlohmann::json line = scene_file::parse_json(text);
      const std::string id = line.is_object() && line.contains("id") && line["id"].is_string()
                                 ? line["id"].get<std::string>()
                                 : "line " + std::to_string(number);
      pairs.push_back({id, read_solid(line, "a"), read_solid(line, "b")});
    } catch (const std::exception& error) {
      throw std::invalid_argument(path + ", line " + std::to_string(number) + ": " + error.what());
    }
  }
  if (pairs.empty()) throw std::invalid_argument(path + ": it has no pair");
  return pairs;
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream out(path);
  out << text;
  if (!out.flush()) throw scene_file::unwritable(path.string());
}

/// Says what is wrong with a path before the run, not behind it.
void check_writable(const std::string& path) {
  const bool is_there = fs::exists(path);
  if (!std::ofstream(path, std::ios::app)) throw scene_file::unwritable(path);
  if (!is_there) fs::remove(path);
}

/// What was judged is kept where there is no Python for the page; false then.
bool write_page(OutputFolder& folder) {
  const fs::path page = folder.file("index.html");
  try {
    run_python_program("referee_page.py",
                       {(folder.path() / "report.json").string(), page.string()});
  } catch (const FileError& error) {
    complain(error.what() + std::string("; the report has no page"));
    write(page, "<!doctype html><title>Referee</title>The page was not made: see report.json.\n");
    return false;
  }
  return true;
}

bool write_report(const referee::Report& report, OutputFolder& folder) {
  write(folder.file("report.json"), text(to_json(report)));
  std::string lines;
  for (std::size_t i = 0; i < report.failures.size(); ++i) {
    const referee::Failure& failure = report.failures[i];
    const std::string name = "failure_" + std::to_string(i + 1);
    lines += failure.json + "\n";
    write(folder.file(name + ".cpp"), failure.cpp);
    write(folder.file(name + ".c"), failure.c);
  }
  write(folder.file("failures.jsonl"), lines);
  const bool has_page = write_page(folder);
  folder.commit(OutputFolder::Checkpoint::Drop);
  return has_page;
}

/// NaN passes the checks of CLI11.
void check_times(const Words& words) {
  if (std::isnan(words.limit) || std::isnan(words.seconds.value_or(0.0)))
    throw std::invalid_argument("--limit, --seconds: must be numbers");
}

referee::Options read(const Words& words) {
  check_times(words);
  referee::Options options;
  options.plugins = words.plugins.empty() ? shipped_plugins() : words.plugins;
  if (words.pairs.empty()) {
    options.families.resize(referee::family_names().size());
    for (const int family : chosen_families(words.family))
      options.families[static_cast<std::size_t>(family)] = true;
  } else {
    options.pairs = read_pairs(words.pairs);
  }
  const long unlimited = std::numeric_limits<long>::max();
  options.count = words.count.value_or(words.seconds ? unlimited : Words::kUsualCount);
  options.seed = words.seed;
  options.steps = words.steps;
  options.limit = std::chrono::milliseconds(static_cast<long>(1000 * words.limit));
  if (isatty(fileno(stderr)) != 0) {
    options.progress = [](long questions) {
      std::fprintf(stderr, "\r%ld questions judged", questions);
    };
  }
  return options;
}

/// The line of a pair; none where it is flat, or refused.
std::optional<std::string> answered(const referee::SolidPair& pair, const std::string& id) {
  try {
    return referee::pair_with_answer(pair, id);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

/// Lines of a set of pairs that others are to carry home: all families in a file of so many
/// characters.
class PairSet {
 public:
  PairSet(std::size_t families, std::size_t count)
      : families_(families), most_(5 * count / (4 * families) + 1) {}

  std::size_t count() const { return count_; }
  const std::string& text() const { return text_; }
  void add(std::size_t family, const std::string& line) {
    Family& of = families_[family];
    if (of.count < most_ && text_.size() + line.size() < kMostText && has_room(of, line)) {
      text_ += line + "\n";
      of.long_lines += line.size() > kShort ? line.size() : 0;
      ++of.count;
      ++count_;
    }
  }

 private:
  // Characters. 240 000 are left for the pairs of tests/pairs that were found; two boxes turned by
  // rounded rotations take some 1200; of longer lines a family has so many, or one.
  static constexpr std::size_t kMostText = 1'760'000, kShort = 1250, kLongLines = 9000;

  struct Family {
    std::size_t count = 0, long_lines = 0;
  };

  static bool has_room(const Family& of, const std::string& line) {
    return line.size() <= kShort || of.long_lines == 0 || of.long_lines + line.size() <= kLongLines;
  }

  std::vector<Family> families_;
  std::size_t most_;  ///< of a family: a quarter more than its share
  std::size_t count_ = 0;
  std::string text_;
};

/// Draws from the families in turn.
std::string drawn_lines(const Words& words) {
  const std::vector<int> families = chosen_families(words.family);
  const auto count = static_cast<std::size_t>(words.count.value_or(Words::kUsualCount));
  PairSet set(families.size(), count);
  for (std::uint64_t number = 0; set.count() < count && number < 20 * count; ++number) {
    referee::Random random(words.seed * 1000003 + number);
    const std::size_t turn = number % families.size();
    const referee::SolidPair pair = referee::make_pair(families[turn], random);
    const auto line = answered(
        pair, pair.family + "-" + std::to_string(words.seed) + "-" + std::to_string(number));
    if (line) set.add(turn, *line);
  }
  return set.text();
}

/// The pairs of --pairs; those that are left out are named.
std::string read_lines(const Words& words) {
  std::string lines;
  for (const referee::SolidPair& pair : read_pairs(words.pairs)) {
    const auto line = answered(pair, pair.family);
    if (line)
      lines += *line + "\n";
    else
      complain(pair.family + ": left out: a solid lies in one plane, or is refused", words.pairs);
  }
  return lines;
}

int write_pairs(const Words& words) {
  check_writable(words.write_pairs);
  write(words.write_pairs, words.pairs.empty() ? drawn_lines(words) : read_lines(words));
  return kDone;
}

/// Through any of its interfaces.
long faults_of_quoin(const referee::Report& report) {
  long faults = 0;
  for (const std::string own : {"quoin", "quoin C"}) {
    const auto found = report.tallies.find(own);
    if (found == report.tallies.end()) continue;
    for (const auto& [family, tally] : found->second) faults += tally.faulty;
  }
  return faults;
}

void print(const referee::Report& report) {
  std::printf("%s\n%ld questions in %.0f s, seed %llu\n", to_text(report).c_str(), report.questions,
              report.seconds, static_cast<unsigned long long>(report.seed));
  if (report.left_out > 0)
    std::printf("%ld left out: a solid lies in one plane\n", report.left_out);
}

int judge(const Words& words) {
  referee::Options options = read(words);
  std::optional<OutputFolder> folder;
  if (!words.json.empty()) check_writable(words.json);
  if (!words.report.empty()) folder.emplace(words.report);
  catch_signals();
  const StopRequest stop(words.seconds);
  options.stop = [&stop] { return stop().has_value(); };
  const referee::Report report = referee::run(options);
  if (options.progress) std::fprintf(stderr, "\n");
  print(report);
  if (!words.json.empty()) write(words.json, text(to_json(report)));
  const bool whole = !folder || write_report(report, *folder);
  if (stop() == scene_file::RunStatus::Interrupted) {
    complain("the run was ended early; what was judged is kept");
    return kFailed;
  }
  return faults_of_quoin(report) > 0 || !whole ? kFailed : kDone;
}

int asked(const Words& words) {
  return words.write_pairs.empty() ? judge(words) : write_pairs(words);
}

void add_referee_command(CLI::App& app, int& exit_code) {
  const auto [command, words] = add_command<Words>(
      app, exit_code, asked, "referee",
      "Ask contact libraries the same pairs and judge each answer in exact arithmetic. Exit code "
      "1: quoin itself has a fault");
  command.add_option("--plugin", words.plugins,
                     "Shared library that is a plug-in (quoin/referee.h); may be given again "
                     "(default: all that are installed)");
  command.add_option("--family", words.family,
                     "Regular expression: families of pairs to draw from (default: all)");
  command.add_option("--pairs", words.pairs,
                     "Pairs as in quoin contact --pairs instead of families");
  command
      .add_option("--count", words.count,
                  "Pairs to draw (default: 10000; with --seconds as many as there is time for)")
      ->check(CLI::Range(1L, 1000000000L));
  command.add_option("--seed", words.seed, "Seed of what is drawn")->capture_default_str();
  command
      .add_option("--steps", words.steps,
                  "Questions for each pair, which moves on by up to 1e-3 of its size and as "
                  "many radians; libraries may remember")
      ->capture_default_str()
      ->check(CLI::Range(1L, 1000000000L));
  command.add_option("--seconds", words.seconds, "End after so much time, s")
      ->check(in_range(1e-3, kMostSeconds));
  command.add_option("--limit", words.limit, "Time for one answer, s")
      ->capture_default_str()
      ->check(in_range(1e-3, 3600.0));
  add_path(command, "--json", words.json, "Write the report to this file");
  add_path(command, "--report", words.report,
           "Write a folder with index.html, report.json and each failing pair, made "
           "smaller, in failures.jsonl and as C++ and C");
  add_path(command, "--write-pairs", words.write_pairs,
           "Judge nothing: write --count pairs of --family, or those of --pairs, with "
           "their exact answers to this file, as in tests/pairs: at most 1.76 MB, few of "
           "those that are long to write");
}

}  // namespace
}  // namespace quoin::commands

int main(int argc, char** argv) {
  return quoin::commands::run_command_line(argc, argv, quoin::commands::add_referee_command);
}
