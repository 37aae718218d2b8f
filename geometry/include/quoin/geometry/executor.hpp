#pragma once
/// The caller's threads, for PairBatch and ContactFinder.

namespace quoin::geometry {

/// Something that runs one piece of work in several workers at once. The answers hang neither on
/// the number of workers nor on their order.
class Executor {
 public:
  using Task = void (*)(void* context, int worker);

  virtual ~Executor() = default;
  virtual int workers()
      const = 0;  ///< at least 1 (less counts as 1); may change between two calls of run()
  /// Calls task(context, w) once for each w from 0 to workers() - 1, at once or one after the
  /// other, and returns when all have come back. What a task throws (std::bad_alloc) must reach the
  /// caller.
  virtual void run(Task task, void* context) = 0;

  /// The same with anything that can be called with a worker.
  template <class Work>
  void run_each(Work& work) {
    run([](void* context, int worker) { (*static_cast<Work*>(context))(worker); }, &work);
  }
};

}  // namespace quoin::geometry
