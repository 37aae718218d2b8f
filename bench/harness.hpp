#pragma once
/// Interleaved timing on top of Google Benchmark, and the result file.
///
/// The peers of one workload are registered together and run with random interleaving, many short
/// repetitions each; medians and their ratios are taken inside that one group.

#include <benchmark/benchmark.h>

#include <functional>
#include <string>
#include <vector>

namespace quoin::bench {

/// What is known about one contestant in one group before it is timed, and what timing adds.
struct Entry {
  std::string workload;  ///< "W1/box"
  std::string peer;      ///< "quoin"
  bool setting =
      false;  ///< a variant by tolerance or iterations, for the error picture: fewer repetitions
  double queries = 1.0;      ///< that one timed pass answers
  int pairs = 0, wrong = 0;  ///< asked; answered wrong, not timed
  double error_median = 0.0,
         error_max = 0.0;  ///< of the gap, as a share of the smaller solid's size
  std::string note{};
  /// One timed pass; returns seconds.
  std::function<double()> pass{};

  std::vector<double> nanoseconds{};  ///< per query, one a repetition
};

struct HarnessOptions {
  int repetitions = 41;
  double least_time = 0.002;  ///< of each repetition, s: short, so that the median
                              ///< is one in which nobody else had the core
};

/// Time this thread had a core, s: what others do on a shared machine is left out.
double thread_seconds();

double median(std::vector<double> values);
double quantile(std::vector<double> values, double share);

/// For `valgrind --tool=callgrind --instr-atstart=no`: from here on caches and branches are
/// followed. Nothing where the program was built without valgrind's header.
void start_callgrind();
/// Runs `pass` once. What callgrind collects: --toggle-collect='quoin::bench::counted*'.
void counted(const std::function<void()>& pass);
/// Says how many queries were counted, for bench/count_bench.py.
void print_counted(const std::string& workload, const std::string& peer, std::size_t queries);

/// Times the entries of one group against each other.
void run_group(std::vector<Entry>& entries, const HarnessOptions& options);

/// Command line shared by the programs: --out FILE, --filter REGEX, --quick, --settings,
/// --repetitions N, --count PEER.
struct Arguments {
  std::string out, filter;
  std::string count;  ///< a peer whose queries are counted by callgrind instead of being timed
  bool quick = false, settings = false;
  HarnessOptions harness;
};

/// One workload of a program and how its peers are timed.
struct Contest {
  std::string name{};
  std::string reference{};  ///< the peer whose time is 1 in what is printed
  /// What was timed; with --count what was counted, not timed.
  std::function<std::vector<Entry>(const Arguments&)> run{};
  bool large = false;      ///< left out by --quick
  bool countable = false;  ///< knows --count
};

/// Contests that know --count, by the names of their workloads.
std::vector<Contest> contests_of(const std::vector<std::string>& names,
                                 const std::function<std::string(const std::string&)>& reference,
                                 std::vector<Entry> (*run)(const std::string&, const Arguments&));

/// The main of a program: runs the contests that the command line wants, prints them and writes the
/// result file. Returns the exit code: 2 where --count has nothing to count.
int run_contests(int argc, char** argv, const std::vector<Contest>& contests);

}  // namespace quoin::bench
