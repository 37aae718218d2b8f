#pragma once
/// Threads that wait for work: geometry's one door to threads.

#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace quoin::geometry {

/// `count` workers, the calling thread being worker 0. Nothing is started for count = 1.
class WorkerPool {
 public:
  explicit WorkerPool(int count);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int count() const { return static_cast<int>(failures_.size()); }

  /// Calls work(worker) once in each worker and returns when all have come back. What a worker
  /// throws is thrown here (the lowest worker's first). No allocation.
  template <class Work>
  void run(Work& work) {
    run_task([](void* context, int worker) { (*static_cast<Work*>(context))(worker); }, &work);
  }

 private:
  using Task = void (*)(void* context, int worker);
  void run_task(Task task, void* context);
  void call(int worker);
  void serve(int worker);

  Task task_ = nullptr;
  void* context_ = nullptr;
  std::atomic<int> round_{0};    // goes up when there is work, and once more at the end
  std::atomic<int> working_{0};  // workers that have not come back
  std::atomic<bool> stop_{false};
  std::vector<std::exception_ptr> failures_;
  std::vector<std::jthread> threads_;
};

}  // namespace quoin::geometry
