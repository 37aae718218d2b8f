#pragma once
/// Threads that wait for work: those of a ContactFinder where the caller has none.

#include <atomic>
#include <exception>
#include <quoin/geometry/executor.hpp>
#include <thread>
#include <vector>

namespace quoin::geometry {

/// Workers of which the calling thread is worker 0. Nothing is started for count = 1. Where the
/// system refuses a thread there are fewer workers: workers() says how many. A share that its
/// thread has not begun when the caller is done with its own is the caller's, too: nobody waits for
/// a thread that wakes or has no core.
class WorkerPool final : public Executor {
 public:
  explicit WorkerPool(int count);  ///< InputError below 1
  ~WorkerPool() override;
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int workers() const override { return static_cast<int>(threads_.size()) + 1; }

  /// What a worker throws is thrown here (the lowest worker's first). No allocation.
  void run(Task task, void* context) override;

 private:
  bool take(int worker, unsigned round);
  void call(int worker);
  void serve(int worker);

  Task task_ = nullptr;
  void* context_ = nullptr;
  std::atomic<unsigned> round_{0};    // goes up when there is work, and once more at the end
  std::atomic<unsigned> working_{0};  // shares that are not done, but for the caller's
  std::vector<std::atomic<unsigned>> taken_;  // of each worker's shares the last that somebody took
  std::atomic<bool> stop_{false};
  std::vector<std::exception_ptr> failures_;
  std::vector<std::jthread> threads_;
};

}  // namespace quoin::geometry
