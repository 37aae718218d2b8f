#include "race.hpp"

#include <algorithm>
#include <array>

#include "library_session.hpp"

namespace quoin::referee {
namespace {

using Memory = LibrarySession::Memory;
constexpr std::size_t kRounds = 5;

/// In the child: all libraries.
class RaceServer {
 public:
  explicit RaceServer(const std::vector<LibraryInfo>& libraries) {
    for (const LibraryInfo& info : libraries)
      sessions_.emplace_back(*load_library(info.file, info.index));
  }

  Message answer(Message& question) {
    posed_.read(question);
    runners_.clear();
    for (std::size_t i = 0; i < sessions_.size(); ++i) {
      if (!posed_.goes_on) sessions_[i].forget();
      if (question.take_integer() != 0 && sessions_[i].take(posed_) == Outcome::Answered)
        runners_.push_back(i);
    }
    const std::vector<double> seconds = posed_.goes_on ? warm() : cold();
    Message reply;
    for (const double s : seconds) reply.add(s);
    return reply;
  }

 private:
  /// Negative: does not run.
  std::vector<double> warm() {
    std::vector<double> seconds(sessions_.size(), -1);
    for (const std::size_t i : in_turn()) seconds[i] = sessions_[i].seconds_of(Memory::Kept);
    return seconds;
  }

  std::vector<double> cold() {
    std::vector<std::array<double, kRounds>> times(sessions_.size());
    for (std::size_t round = 0; round < kRounds; ++round)
      for (const std::size_t i : in_turn()) times[i][round] = sessions_[i].seconds_of(Memory::None);
    std::vector<double> seconds(sessions_.size(), -1);
    for (const std::size_t i : runners_) {
      std::nth_element(times[i].begin(), times[i].begin() + kRounds / 2, times[i].end());
      seconds[i] = times[i][kRounds / 2];
    }
    return seconds;
  }

  /// Another one is the first each time: nobody always runs behind the same.
  const std::vector<std::size_t>& in_turn() {
    if (!runners_.empty()) {
      const auto first = static_cast<std::ptrdiff_t>(turns_++ % runners_.size());
      std::rotate(runners_.begin(), runners_.begin() + first, runners_.end());
    }
    return runners_;
  }

  std::vector<LibrarySession> sessions_;
  PosedQuestion posed_;
  std::vector<std::size_t> runners_;
  std::size_t turns_ = 0;
};

}  // namespace

Race::Race(std::vector<LibraryInfo> libraries, std::chrono::milliseconds limit)
    : libraries_(std::move(libraries)),
      process_([this] { return ChildProcess::served_by<RaceServer>(libraries_); },
               limit * static_cast<int>(kRounds * libraries_.size())) {}

std::vector<std::optional<double>> Race::seconds(const Question& question,
                                                 const std::vector<bool>& runs) {
  Message message, reply;
  const bool goes_on = process_.running() && solids_ == question.solids;
  solids_ = question.solids;
  PosedQuestion::write(question, goes_on, message);
  for (const bool runner : runs) message.add(runner ? 1 : 0);
  const bool whole = process_.ask(message, reply) == Message::Received::Whole;
  std::vector<std::optional<double>> seconds(runs.size());
  for (std::optional<double>& s : seconds) {
    const double time = whole ? reply.take() : -1;
    if (time >= 0) s = time;
  }
  return seconds;
}

}  // namespace quoin::referee
