#include <quoin/geometry/worker_pool.hpp>

#include <chrono>
#include <quoin/geometry/types.hpp>
#include <string>
#include <utility>

namespace quoin::geometry {
namespace {

/// Waking a thread takes 5 us where its core is awake, 70 to 90 where that sleeps (measured, by the
/// clock on the wall). Who waits actively for about as long loses no more than twice what the best
/// would, whenever work comes.
constexpr std::chrono::microseconds kAwake{50};

void pause() {
#ifdef __SSE2__
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

/// Until `value` is no longer `old`: actively for a while, then asleep.
void await_change(const std::atomic<unsigned>& value, unsigned old) {
  const auto end = std::chrono::steady_clock::now() + kAwake;
  while (value == old) {
    if (std::chrono::steady_clock::now() > end) return value.wait(old);
    pause();
  }
}

std::size_t checked(int count) {
  if (count < 1)
    throw InputError("worker pool: " + std::to_string(count) + " workers, at least 1 needed");
  return static_cast<std::size_t>(count);
}

}  // namespace

WorkerPool::WorkerPool(int count) : taken_(checked(count)), failures_(taken_.size()) {
  threads_.reserve(static_cast<std::size_t>(count) - 1);  // so that only a thread can fail below
  try {
    for (int worker = 1; worker < count; ++worker)
      threads_.emplace_back([this, worker] { serve(worker); });
  } catch (
      const std::exception&) {  // no further thread, or no memory for it: the others do the work
  }
}

WorkerPool::~WorkerPool() {
  stop_ = true;
  ++round_;
  round_.notify_all();
}

/// Whether the share of a worker in this round is the caller's of take(): once for each.
bool WorkerPool::take(int worker, unsigned round) {
  unsigned last = round - 1;
  return taken_[static_cast<std::size_t>(worker)].compare_exchange_strong(last, round);
}

void WorkerPool::call(int worker) {
  try {
    task_(context_, worker);
  } catch (...) {
    failures_[static_cast<std::size_t>(worker)] = std::current_exception();
  }
}

void WorkerPool::serve(int worker) {
  for (unsigned round = 0;;) {
    await_change(round_, round);
    round = round_;
    if (stop_) return;
    if (!take(worker, round)) continue;
    call(worker);
    if (--working_ == 0) working_.notify_one();
  }
}

void WorkerPool::run(Task task, void* context) {
  task_ = task;
  context_ = context;
  working_ = static_cast<unsigned>(workers() - 1);
  const unsigned round = ++round_;
  round_.notify_all();
  call(0);
  for (int worker = 1; worker < workers(); ++worker) {
    if (!take(worker, round)) continue;
    call(worker);
    --working_;
  }
  for (unsigned working = working_; working != 0; working = working_)
    await_change(working_, working);
  std::exception_ptr first;
  for (std::exception_ptr& failure : failures_) {
    const std::exception_ptr thrown = std::exchange(failure, nullptr);
    if (!first) first = thrown;
  }
  if (first) std::rethrow_exception(first);
}

}  // namespace quoin::geometry
