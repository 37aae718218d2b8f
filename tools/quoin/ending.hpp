#pragma once
/// How commands end: exit codes, and a line that says why.

#include <functional>
#include <string>

namespace quoin::commands {

/// Exit codes of every command.
enum ExitCode : int {
  kDone = 0,
  kFailed = 1,   ///< a file that can't be read or written, a run that failed or was ended early
  kBadInput = 2  ///< the input says something that can't be worked with
};

/// One line on standard error, behind "quoin: " unless `subject` names a file: without characters
/// that a terminal obeys, and cut where it is too long to be read.
void complain(const std::string& message, const std::string& subject = "quoin");

/// How a command ended: by an exception where there is a message, for complain().
struct Ending {
  int exit_code = kDone;
  std::string message{}, subject = "quoin";
};

/// What `command` returns; an exception becomes a message and an exit code. `scene`: the file it
/// reads.
Ending ending_of(const std::function<int()>& command, const std::string& scene);

/// The same; the message is said.
int run_guarded(const std::function<int()>& command, const std::string& scene);

}  // namespace quoin::commands
