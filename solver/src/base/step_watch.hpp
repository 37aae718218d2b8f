#pragma once
/// Lets the caller look into a long step, and end it.

#include <atomic>
#include <chrono>
#include <quoin/solver/simulation.hpp>
#include <thread>

namespace quoin::solver {

/// Thrown by StepWatch::look() from deep inside a step, caught by advance(): nothing else sees it.
struct StepStopped {};

/// Asks StepOptions::watch in the long loops of a step, at most every kInterval.
class StepWatch {
 public:
  /// For the step that begins: both must outlive it. The caller is asked on this thread alone.
  void begin(const StepOptions& options, const StepReport& report) {
    watch_ = options.watch ? &options.watch : nullptr;
    report_ = &report;
    last_ = Clock::now();
    asks_ = std::this_thread::get_id();
    stopped_ = false;
  }
  void end() { watch_ = nullptr; }
  bool watches() const { return watch_ != nullptr; }

  /// Throws StepStopped when the caller wants the step to end, on all threads that look.
  void look() {
    if (watch_ == nullptr) return;
    if (stopped_) throw StepStopped{};
    if (std::this_thread::get_id() != asks_) return;
    const Clock::time_point now = Clock::now();
    if (now - last_ < kInterval) return;
    last_ = now;
    if ((*watch_)(*report_)) return;
    stopped_ = true;
    throw StepStopped{};
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kInterval{50};  // what a person takes for at once
  const std::function<bool(const StepReport&)>* watch_ = nullptr;
  const StepReport* report_ = nullptr;
  Clock::time_point last_{};
  std::thread::id asks_;
  std::atomic<bool> stopped_{false};
};

}  // namespace quoin::solver
