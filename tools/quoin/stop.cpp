#include "stop.hpp"

#include <signal.h>
#include <unistd.h>

#include "commands.hpp"

namespace quoin::commands {
namespace {

volatile sig_atomic_t signals = 0;

extern "C" void note_signal(int) {
  if (signals != 0) ::_exit(kFailed);
  signals = 1;
}

}  // namespace

void catch_signals() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (::sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = note_signal;
    ::sigaction(number, &action, nullptr);
  }
}

StopRequest::StopRequest(std::optional<double> max_seconds) {
  if (!max_seconds) return;
  end_ = Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*max_seconds));
}

std::optional<scene_file::RunStatus> StopRequest::operator()() const {
  if (signals != 0) return scene_file::RunStatus::Interrupted;
  if (end_ && Clock::now() >= *end_) return scene_file::RunStatus::TimeLimit;
  return std::nullopt;
}

}  // namespace quoin::commands
