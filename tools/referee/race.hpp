#pragma once
/// Times of several libraries side by side: all in one process, asked the same pair in turns.

#include <optional>
#include <vector>

#include "plugin.hpp"

namespace quoin::referee {

class Race {
 public:
  /// `limit`: for one library.
  Race(std::vector<LibraryInfo> libraries, std::chrono::milliseconds limit);

  /// Seconds of both moves and the question, for each library that `runs` (by its number); none
  /// where the libraries do not bear each other. Of a further step of a motion, as it was asked,
  /// with memory; else the median of five askings without memory.
  std::vector<std::optional<double>> seconds(const Question& question,
                                             const std::vector<bool>& runs);

 private:
  std::vector<LibraryInfo> libraries_;
  ChildProcess process_;
  std::shared_ptr<const DescribedPair> solids_;  ///< of the question before
};

}  // namespace quoin::referee
