#pragma once
/// A library of a plug-in inside a child process: the solids of the question at hand, made by it.

#include <quoin/referee.h>

#include <span>
#include <string>
#include <vector>

#include "described_solid.hpp"
#include "message.hpp"
#include "plugin.hpp"

namespace quoin::referee {

/// Null behind the last library of a plug-in. Throws std::runtime_error with one line for a file
/// that is no plug-in of this interface.
const quoin_referee_library* load_library(const std::string& file, int index);

/// A question as it goes through the pipe.
struct PosedQuestion {
  bool goes_on = false;
  DescribedSolid solids[2];
  quoin_referee_placement placements[2]{};

  static void write(const Question& question, bool goes_on, Message& message);
  /// The solids stay what they are where the question goes on.
  void read(Message& message);
};

/// Points that a library listed; they last until it is asked again.
struct ListedPoints {
  quoin_referee_status status = QUOIN_REFEREE_NO_ANSWER;
  std::span<const quoin_referee_point> points;
};

class LibrarySession {
 public:
  explicit LibrarySession(const quoin_referee_library& library) : library_(library) {}

  /// Makes the solids, or keeps them where the question goes on; Outcome::Answered, or who is
  /// refused. `forget` drops them.
  Outcome take(const PosedQuestion& question);
  void move();
  /// `memory`: with what was learned of the solids before.
  enum class Memory { None, Kept };
  quoin_referee_status ask(Memory memory, quoin_referee_answer& answer);
  ListedPoints list_points(Memory memory);
  /// The moves and the question (of a library without gaps: its points), s.
  double seconds_of(Memory memory);

  void forget();

 private:
  const quoin_referee_library& library_;
  void* made_[2] = {};
  void* memory_ = nullptr;
  std::vector<quoin_referee_point> room_;
  quoin_referee_placement placements_[2]{};
};

}  // namespace quoin::referee
