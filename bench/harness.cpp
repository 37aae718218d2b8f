#include "harness.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <regex>
#include <stdexcept>
#include <thread>

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#else
#define CALLGRIND_START_INSTRUMENTATION
#endif

namespace quoin::bench {
namespace {

class Collector final : public benchmark::BenchmarkReporter {
 public:
  explicit Collector(std::vector<Entry>& entries) : entries_(entries) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
      Entry& entry = entries_[static_cast<std::size_t>(std::stoi(run.run_name.function_name))];
      const double seconds = run.real_accumulated_time / static_cast<double>(run.iterations);
      entry.nanoseconds.push_back(1e9 * seconds / entry.queries);
    }
  }

 private:
  std::vector<Entry>& entries_;
};

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string number(double value) {
  if (!std::isfinite(value)) return "null";
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  std::string line, name, family, model;
  while (std::getline(file, line)) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::string value = colon + 2 <= line.size() ? line.substr(colon + 2) : "";
    if (line.starts_with("model name") && name.empty()) name = value;
    if (line.starts_with("cpu family") && family.empty()) family = value;
    if (line.starts_with("model\t") && model.empty()) model = value;
  }
  return name + " (family " + family + ", model " + model + ")";
}

}  // namespace

namespace {

/// Cycles a nanosecond: a chain of additions, each waiting for the one before, runs one a cycle.
double clock_rate() {
  constexpr long kAdditions = 20'000'000;
  double best = 0.0;
  for (int turn = 0; turn < 5; ++turn) {
    const double start = thread_seconds();
    long sum = turn;
    for (long k = 0; k < kAdditions; ++k) {
      sum += 3;
      asm volatile("" : "+r"(sum));  // keeps the chain, in a register
    }
    best = std::max(best, 1e-9 * kAdditions / (thread_seconds() - start));
  }
  return best;
}

}  // namespace

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (place - static_cast<double>(low)) * (values[high] - values[low]);
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

void start_callgrind() { CALLGRIND_START_INSTRUMENTATION; }

[[gnu::noinline]] void counted(const std::function<void()>& pass) { pass(); }

void print_counted(const std::string& workload, const std::string& peer, std::size_t queries) {
  std::printf("counted %zu queries of %s by %s\n", queries, workload.c_str(), peer.c_str());
}

void run_group(std::vector<Entry>& entries, const HarnessOptions& options) {
  benchmark::ClearRegisteredBenchmarks();
  for (std::size_t k = 0; k < entries.size(); ++k) {
    if (entries[k].queries < 1.0) continue;  // nothing left to time: all answers wrong
    benchmark::RegisterBenchmark(std::to_string(k).c_str(),
                                 [&entries, k](benchmark::State& state) {
                                   for (auto _ : state) state.SetIterationTime(entries[k].pass());
                                 })
        ->UseManualTime()
        ->MinTime(options.least_time)
        ->Repetitions(entries[k].setting ? (options.repetitions + 5) / 6 : options.repetitions);
  }
  Collector collector(entries);
  benchmark::RunSpecifiedBenchmarks(&collector, "all");
  for (Entry& entry : entries) entry.pass = nullptr;  // and what it holds on to
}

namespace {

/// The machine, compiler and flags, and all entries, as JSON.
void write(const std::string& path, const std::vector<Entry>& entries) {
  std::ofstream out(path);
  out << "{\n  \"context\": {\n    \"processor\": " << quoted(processor())
      << ",\n    \"cores\": " << std::thread::hardware_concurrency()
      << ",\n    \"gigahertz\": " << number(clock_rate())
      << ",\n    \"compiler\": " << quoted("g++ " __VERSION__)
      << ",\n    \"flags\": " << quoted(QUOIN_BENCH_FLAGS)
      << ",\n    \"build\": " << quoted(QUOIN_BENCH_BUILD) << "\n  },\n  \"results\": [";
  const char* separator = "\n";
  for (const Entry& e : entries) {
    out << separator << "    {\"workload\": " << quoted(e.workload)
        << ", \"peer\": " << quoted(e.peer) << ", \"setting\": " << (e.setting ? "true" : "false")
        << ", \"nanoseconds\": " << number(median(e.nanoseconds))
        << ", \"quarter\": " << number(quantile(e.nanoseconds, 0.25))
        << ", \"three_quarters\": " << number(quantile(e.nanoseconds, 0.75))
        << ", \"repetitions\": " << e.nanoseconds.size() << ", \"pairs\": " << e.pairs
        << ", \"wrong\": " << e.wrong << ", \"error_median\": " << number(e.error_median)
        << ", \"error_max\": " << number(e.error_max) << ", \"note\": " << quoted(e.note) << "}";
    separator = ",\n";
  }
  out << "\n  ]\n}\n";
  if (!out.flush()) throw std::runtime_error("cannot write " + path);
}

/// Prints one group as a table; ratios to the entry `reference` (or the first).
void print_group(const std::vector<Entry>& entries, const std::string& reference) {
  double base = median(entries.front().nanoseconds);
  for (const Entry& e : entries)
    if (e.peer == reference) base = median(e.nanoseconds);
  std::printf("%s\n", entries.front().workload.c_str());
  for (const Entry& e : entries) {
    const double time = median(e.nanoseconds);
    std::printf("  %-30s %10.1f ns  ratio %7.3f  wrong %4d of %d  error %.1e max %.1e %s\n",
                e.peer.c_str(), time, time / base, e.wrong, e.pairs, e.error_median, e.error_max,
                e.note.c_str());
  }
  std::fflush(stdout);
}

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  const auto value = [&](int& k) -> std::string {
    if (k + 1 >= argc) {
      std::fprintf(stderr, "%s needs a value\n", argv[k]);
      std::exit(2);
    }
    return argv[++k];
  };
  for (int k = 1; k < argc; ++k) {
    const std::string name = argv[k];
    if (name == "--out") {
      arguments.out = value(k);
    } else if (name == "--filter") {
      arguments.filter = value(k);
    } else if (name == "--count") {
      arguments.count = value(k);
    } else if (name == "--repetitions") {
      arguments.harness.repetitions = std::atoi(value(k).c_str());
    } else if (name == "--quick") {
      arguments.quick = true;
      arguments.harness = {7, 0.001};
    } else if (name == "--settings") {
      arguments.settings = true;
    } else {
      std::fprintf(stderr,
                   "usage: %s [--out FILE] [--filter REGEX] [--quick] [--settings] "
                   "[--repetitions N] [--count PEER]\n",
                   argv[0]);
      std::exit(name == "--help" ? 0 : 2);
    }
  }
  static char random_interleaving[] = "--benchmark_enable_random_interleaving=true";
  char* flags[] = {argv[0], random_interleaving};
  int count = 2;
  benchmark::Initialize(&count, flags);
  return arguments;
}

}  // namespace

std::vector<Contest> contests_of(const std::vector<std::string>& names,
                                 const std::function<std::string(const std::string&)>& reference,
                                 std::vector<Entry> (*run)(const std::string&, const Arguments&)) {
  std::vector<Contest> contests;
  for (const std::string& name : names) {
    contests.push_back({.name = name,
                        .reference = reference(name),
                        .run = [=](const Arguments& arguments) { return run(name, arguments); },
                        .countable = true});
  }
  return contests;
}

int run_contests(int argc, char** argv, const std::vector<Contest>& contests) {
  const Arguments arguments = parse(argc, argv);
  const std::regex wanted(arguments.filter);
  std::vector<Entry> results;
  for (const Contest& contest : contests) {
    if (!std::regex_search(contest.name, wanted) || (arguments.quick && contest.large)) continue;
    if (!arguments.count.empty() && !contest.countable) continue;
    const std::vector<Entry> entries = contest.run(arguments);
    if (!entries.empty() && arguments.count.empty()) print_group(entries, contest.reference);
    results.insert(results.end(), entries.begin(), entries.end());
  }
  if (!arguments.count.empty()) {
    if (!results.empty()) return 0;
    std::fprintf(stderr, "nothing to count: no workload that fits \"%s\" has a peer \"%s\"\n",
                 arguments.filter.c_str(), arguments.count.c_str());
    return 2;
  }
  if (!arguments.out.empty()) write(arguments.out, results);
  return 0;
}

}  // namespace quoin::bench
