#pragma once
/// Rows of a large system side by side on the caller's threads.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <quoin/geometry/executor.hpp>
#include <vector>

namespace quoin::solver {

class Threads {
 public:
  Threads() = default;
  /// `executor`: null for one thread; nobody else may run it meanwhile, and its number of workers
  /// stays.
  explicit Threads(geometry::Executor* executor) : executor_(executor) {}

  int workers() const { return executor_ == nullptr ? 1 : executor_->workers(); }

  /// Calls work(worker, i) for each i below `count`, the next one on whichever worker is free.
  template <class Work>
  void take(std::size_t count, const Work& work) const {
    if (count == 0) return;
    std::atomic<std::size_t> next{0};
    auto share = [&](int worker) {
      for (std::size_t i; (i = next++) < count;) work(worker, i);
    };
    executor_ == nullptr ? share(0) : executor_->run_each(share);
  }

  /// Calls work(first, end) for ranges that make up 0 … count: each writes what no other reads.
  template <class Work>
  void ranges(std::size_t count, const Work& work) const {
    const std::size_t workers = workers_for(count);
    if (workers == 1) return work(std::size_t{0}, count);
    auto share = [&](int worker) {
      const auto w = static_cast<std::size_t>(worker);
      if (w < workers) work(count * w / workers, count * (w + 1) / workers);
    };
    executor_->run_each(share);
  }

  /// Calls work(i) for each i below `count`.
  template <class Work>
  void each(std::size_t count, const Work& work) const {
    ranges(count, [&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) work(i);
    });
  }

 private:
  // Rows of six unknowns that take some 30 us, a few times what it takes to wake a thread.
  static constexpr std::size_t kRowsPerWorker = 256;

  std::size_t workers_for(std::size_t count) const {
    if (executor_ == nullptr) return 1;
    const std::size_t most = static_cast<std::size_t>(executor_->workers());
    return std::clamp<std::size_t>(count / kRowsPerWorker, 1, most);
  }

  geometry::Executor* executor_ = nullptr;
};

}  // namespace quoin::solver
