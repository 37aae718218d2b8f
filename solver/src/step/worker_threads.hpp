#pragma once
/// The solver's threads: for the contact search, and for islands side by side.

#include <condition_variable>
#include <exception>
#include <mutex>
#include <quoin/geometry/executor.hpp>
#include <thread>
#include <vector>

namespace quoin::solver {

/// Sleeps between two run(). The calling thread is worker 0.
class WorkerThreads : public geometry::Executor {
 public:
  /// At least 1 worker; fewer than asked for where the system starts no more threads.
  explicit WorkerThreads(int workers);
  ~WorkerThreads() override;
  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  int workers() const override { return static_cast<int>(threads_.size()) + 1; }
  void run(Task task, void* context) override;

 private:
  void serve(int worker);
  void take(int worker);

  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable begins_, ends_;
  Task task_ = nullptr;
  void* context_ = nullptr;
  long runs_ = 0;    ///< begun so far
  int running_ = 0;  ///< workers but the first that have not come back
  bool closing_ = false;
  std::exception_ptr thrown_;
};

}  // namespace quoin::solver
