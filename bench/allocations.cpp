#include "allocations.hpp"

#include <malloc.h>

#include <atomic>
#include <cerrno>
#include <cstddef>

namespace {

std::atomic<long> count{0}, in_use{0}, peak{0};

void* counted(void* place) {
  count.fetch_add(1, std::memory_order_relaxed);
  const auto bytes = static_cast<long>(malloc_usable_size(place));
  const long now = in_use.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  for (long known = peak.load(std::memory_order_relaxed);
       now > known && !peak.compare_exchange_weak(known, now, std::memory_order_relaxed);) {
  }
  return place;
}

void released(void* place) {
  in_use.fetch_sub(static_cast<long>(malloc_usable_size(place)), std::memory_order_relaxed);
}

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) { return counted(__libc_malloc(size)); }
void* calloc(std::size_t number, std::size_t size) { return counted(__libc_calloc(number, size)); }
void* realloc(void* old, std::size_t size) {
  released(old);
  return counted(__libc_realloc(old, size));
}
void* memalign(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** place, std::size_t alignment, std::size_t size) {
  *place = memalign(alignment, size);
  return *place == nullptr ? ENOMEM : 0;
}
void free(void* place) {
  released(place);
  __libc_free(place);
}
}

namespace quoin::bench {
long allocation_count() { return count.load(std::memory_order_relaxed); }
long bytes_in_use() { return in_use.load(std::memory_order_relaxed); }
void start_peak() { peak.store(bytes_in_use(), std::memory_order_relaxed); }
long peak_bytes() { return peak.load(std::memory_order_relaxed); }
}  // namespace quoin::bench
