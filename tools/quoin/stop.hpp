#pragma once
/// What ends a run before its time: Ctrl-C, TERM, HUP, a limit of wall time.

#include <chrono>
#include <optional>

#include "scene_file/run_scene.hpp"

namespace quoin::commands {

/// From here on SIGINT, SIGTERM and SIGHUP ask the run to end; the second one ends the process at
/// once, with exit code 1. A HUP that is ignored (nohup) stays so.
void catch_signals();

/// Asked by RunOptions::stop.
class StopRequest {
 public:
  /// max_seconds: of wall time from now on; none: no limit.
  explicit StopRequest(std::optional<double> max_seconds);
  std::optional<scene_file::RunStatus> operator()() const;

 private:
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> end_;
};

}  // namespace quoin::commands
