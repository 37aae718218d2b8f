#include <quoin/geometry/worker_pool.hpp>

#include <utility>

namespace quoin::geometry {

WorkerPool::WorkerPool(int count) : failures_(static_cast<std::size_t>(count)) {
  threads_.reserve(static_cast<std::size_t>(count) - 1);  // so that only a thread can fail below
  try {
    for (int worker = 1; worker < count; ++worker) {
      threads_.emplace_back([this, worker] { serve(worker); });
    }
  } catch (
      const std::exception&) {  // no further thread, or no memory for it: the others do the work
  }
}

WorkerPool::~WorkerPool() {
  stop_ = true;
  ++round_;
  round_.notify_all();
}

void WorkerPool::call(int worker) {
  try {
    task_(context_, worker);
  } catch (...) {
    failures_[static_cast<std::size_t>(worker)] = std::current_exception();
  }
}

void WorkerPool::serve(int worker) {
  for (int round = 0;;) {
    round_.wait(round);
    round = round_;
    if (stop_) {
      return;
    }
    call(worker);
    if (--working_ == 0) {
      working_.notify_one();
    }
  }
}

void WorkerPool::run(Task task, void* context) {
  task_ = task;
  context_ = context;
  working_ = workers() - 1;
  ++round_;
  round_.notify_all();
  call(0);
  for (int working = working_; working != 0; working = working_) {
    working_.wait(working);
  }
  std::exception_ptr first;
  for (std::exception_ptr& failure : failures_) {
    const std::exception_ptr thrown = std::exchange(failure, nullptr);
    if (!first) first = thrown;
  }
  if (first) std::rethrow_exception(first);
}

}  // namespace quoin::geometry
