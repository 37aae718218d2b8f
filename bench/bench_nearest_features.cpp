/// W1 cold box, W2 cold hulls, W3 warm, W5 depth, W6 hard families: gap, witnesses, normal,
/// features, certificate of one pair, against the peers on the same pairs.

#include <chrono>
#include <cmath>
#include <numeric>

#include "harness.hpp"
#include "peer.hpp"

namespace quoin::bench {
namespace {

Peers make_peers(bool settings) {
  Peers peers;
  append_quoin(peers, settings);
  append_plugins(peers);
  return peers;
}

/// Which pairs a peer gets right at each step, and how far off it is.
struct Verdict {
  std::vector<std::vector<int>> right;  ///< pairs, for each step
  int asked = 0, wrong = 0;
  std::vector<double> errors;  ///< of the gap, as a share of the smaller size; all answers
};

Verdict judge(Peer& peer, const Workload& workload) {
  Verdict verdict;
  verdict.right.resize(static_cast<std::size_t>(workload.steps));
  peer.forget();
  for (int step = 0; step < workload.steps; ++step) {
    const auto s = static_cast<std::size_t>(step);
    peer.place(step);
    for (std::size_t k = 0; k < workload.pairs.size(); ++k) {
      const Pair& pair = workload.pairs[k];
      double error = HUGE_VAL;
      try {
        error = std::abs(peer.ask(static_cast<int>(k)).gap - pair.gap[s]);
      } catch (const std::exception&) {
        // gave up: wrong
      }
      ++verdict.asked;
      verdict.errors.push_back(std::isfinite(error) ? error / pair.size : 1.0);
      if (error <= workload.allowed_error(pair, step))
        verdict.right[s].push_back(static_cast<int>(k));
      else
        ++verdict.wrong;
    }
  }
  return verdict;
}

double timed_pass(Peer& peer, const std::vector<int>& pairs) {
  const double start = thread_seconds();
  benchmark::DoNotOptimize(peer.ask_all(pairs));
  return thread_seconds() - start;
}

/// One pass over all steps, placing left out: steps are too short for the clock of the thread, so
/// the median over the steps of the time per query stands for all.
double timed_steps(Peer& peer, const Workload& workload, const Verdict& verdict) {
  std::vector<double> seconds;
  double queries = 0.0;
  for (int step = 0; step < workload.steps; ++step) {
    const std::vector<int>& pairs = verdict.right[static_cast<std::size_t>(step)];
    peer.place(step);
    if (step == 0) {
      peer.forget();
      benchmark::DoNotOptimize(peer.ask_all(pairs));
    }
    if (pairs.empty()) continue;
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(peer.ask_all(pairs));
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    seconds.push_back(passed.count() / static_cast<double>(pairs.size()));
    queries += static_cast<double>(pairs.size());
  }
  return median(seconds) * queries;
}

Entry make_entry(Peer& peer, const std::string& name, const Workload& workload, bool setting) {
  peer.load(workload);
  auto verdict = std::make_shared<Verdict>(judge(peer, workload));
  Entry entry{.workload = name, .peer = peer.name(), .setting = setting};
  entry.pairs = verdict->asked;
  entry.wrong = verdict->wrong;
  entry.queries = verdict->asked - verdict->wrong;
  entry.error_median = median(verdict->errors);
  entry.error_max = quantile(verdict->errors, 1.0);
  peer.place(0);
  entry.pass = [&peer, &workload, verdict] {
    return workload.steps == 1 ? timed_pass(peer, verdict->right[0])
                               : timed_steps(peer, workload, *verdict);
  };
  return entry;
}

/// Has `name` a place among the peers that run without --settings?
bool plain(const Peers& plain_peers, const std::string& name) {
  for (const auto& peer : plain_peers)
    if (peer->name() == name) return true;
  return false;
}

std::vector<Entry> run_workload(const std::string& name, const Arguments& arguments) {
  const WorkloadScale scale = arguments.quick ? WorkloadScale{0.125, 20} : WorkloadScale{};
  const Workload workload = make_workload(name, scale);
  Peers peers = make_peers(arguments.settings);
  const Peers usual = make_peers(false);
  std::vector<Entry> entries = entries_of(peers, name, workload, arguments, [&](Peer& peer) {
    return make_entry(peer, name, workload, !plain(usual, peer.name()));
  });
  if (entries.empty() || !arguments.count.empty()) return entries;
  HarnessOptions options = arguments.harness;
  if (workload.steps > 1) options.repetitions = (options.repetitions + 2) / 3;  // medians already
  run_group(entries, options);
  return entries;
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) {
  using namespace quoin::bench;
  const auto reference = [](const std::string& name) {
    return name.starts_with("W5") ? "libccd EPA 1e-9" : "FCL libccd";
  };
  return run_contests(argc, argv, contests_of(distance_workload_names(), reference, run_workload));
}
