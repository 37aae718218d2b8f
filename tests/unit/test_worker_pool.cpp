#include <array>
#include <atomic>
#include <quoin/geometry/contact_finder.hpp>
#include <quoin/geometry/worker_pool.hpp>

#include "support/catch.hpp"

// Threads are refused by taking the place of pthread_create; sanitizers have put theirs there.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && defined(__linux__)
#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>

namespace {

int threads_left = -1;  // -1: as many as asked for

}  // namespace

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*start)(void*), void* argument) {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "pthread_create"));
  if (threads_left == 0) return EAGAIN;
  threads_left -= threads_left > 0;
  return create(thread, attributes, start, argument);
}

TEST_CASE("worker pool: where threads are refused fewer do the work, and it says how many") {
  for (const int refused_after : {0, 1, 3}) {
    threads_left = refused_after;
    quoin::geometry::WorkerPool pool(6);
    threads_left = -1;
    CHECK(pool.workers() == refused_after + 1);
    std::vector<int> calls(6, 0);
    auto work = [&](int worker) { ++calls[static_cast<std::size_t>(worker)]; };
    for (int round = 0; round < 10; ++round) pool.run_each(work);
    for (int worker = 0; worker < 6; ++worker)
      CHECK(calls[static_cast<std::size_t>(worker)] == (worker <= refused_after ? 10 : 0));
  }
  threads_left = 1;
  const quoin::geometry::ContactFinder finder({.reach = 1e-3, .threads = 4});
  threads_left = -1;
  CHECK(finder.threads() == 2);
}
#endif

TEST_CASE("worker pool: none at all is refused") {
  for (const int count : {0, -1})
    CHECK_THROWS_AS(quoin::geometry::WorkerPool(count), quoin::geometry::InputError);
}

TEST_CASE("worker pool: each share is done once in each round, whoever does it") {
  constexpr int kRounds = 20000, kWorkers = 4;
  quoin::geometry::WorkerPool pool(kWorkers);
  std::array<std::atomic<int>, kWorkers> done{};
  std::array<int, kWorkers> alone{};  // written by nobody else meanwhile
  int round = 0;
  std::atomic<int> wrong{0};
  auto work = [&](int worker) {
    const auto w = static_cast<std::size_t>(worker);
    wrong += alone[w]++ != round;
    ++done[w];
  };
  for (; round < kRounds; ++round) {
    pool.run_each(work);
    for (const std::atomic<int>& count : done) wrong += count != round + 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("worker pool: what the lowest worker throws comes out") {
  quoin::geometry::WorkerPool pool(3);
  auto work = [](int worker) {
    if (worker > 0) throw worker;
  };
  for (int round = 0; round < 3; ++round) CHECK_THROWS_AS(pool.run_each(work), int);
  auto nothing = [](int) {};
  pool.run_each(nothing);
  CHECK(pool.workers() == 3);
}
