#pragma once
/// The referee: the same pairs to every library, each answer judged.

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "tally.hpp"

namespace quoin::referee {

struct Options {
  std::vector<std::string> plugins;  ///< files
  std::vector<bool> families;        ///< those drawn from, by number, with their weights
  std::vector<SolidPair> pairs;      ///< instead of families, if there are any
  long count = 10000;                ///< sequences
  std::function<bool()> stop;        ///< asked before each question: true ends the run
  std::uint64_t seed = 1;
  int steps = 1;                                 ///< questions of a sequence
  std::chrono::milliseconds limit{2000};         ///< for one answer
  int shrink_questions = 300;                    ///< at most, for each failure
  std::function<void(long questions)> progress;  ///< called now and then
};

/// Throws std::runtime_error for a file that is no plug-in.
Report run(const Options& options);

}  // namespace quoin::referee
