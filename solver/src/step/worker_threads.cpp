#include "step/worker_threads.hpp"

#include <system_error>
#include <utility>

namespace quoin::solver {

WorkerThreads::WorkerThreads(int workers) {
  threads_.reserve(static_cast<std::size_t>(workers));
  try {
    for (int w = 1; w < workers; ++w) threads_.emplace_back([this, w] { serve(w); });
  } catch (const std::system_error&) {  // with those that there are
  }
}

WorkerThreads::~WorkerThreads() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  begins_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerThreads::run(Task task, void* context) {
  {
    const std::lock_guard lock(mutex_);
    task_ = task;
    context_ = context;
    thrown_ = nullptr;
    running_ = static_cast<int>(threads_.size());
    ++runs_;
  }
  begins_.notify_all();
  take(0);
  std::unique_lock lock(mutex_);
  ends_.wait(lock, [this] { return running_ == 0; });
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
}

void WorkerThreads::serve(int worker) {
  for (long seen = 0;;) {
    {
      std::unique_lock lock(mutex_);
      begins_.wait(lock, [&] { return closing_ || runs_ > seen; });
      if (closing_) return;
      seen = runs_;
    }
    take(worker);
    const std::lock_guard lock(mutex_);
    if (--running_ == 0) ends_.notify_one();
  }
}

void WorkerThreads::take(int worker) {
  try {
    task_(context_, worker);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    if (!thrown_) thrown_ = std::current_exception();
  }
}

}  // namespace quoin::solver
