#pragma once
/// Where the time of a step goes.

#include <chrono>
#include <quoin/solver/simulation.hpp>

namespace quoin::solver {

class PhaseClock {
 public:
  void start() {
    seconds = {};
    last_ = Clock::now();
  }
  /// The time since the last call is this phase's.
  void charge(double PhaseSeconds::*phase) {
    const Clock::time_point now = Clock::now();
    seconds.*phase += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }
  /// The time since the last call was another clock's.
  void add(const PhaseSeconds& other) {
    seconds.add(other);
    last_ = Clock::now();
  }
  PhaseSeconds seconds;

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_{};
};

}  // namespace quoin::solver
