#pragma once
/// Counts what a program allocates by operator new, in all threads. It replaces the operators: only
/// the one source file of a test program includes it. What Eigen's dynamic matrices take by malloc
/// is not counted.

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace quoin::tests {

inline std::atomic<long> allocations{0};
inline std::atomic<long> bytes_in_use{0};
inline std::atomic<long> until_failure{-1};  ///< allocations before one throws; negative: none does

namespace detail {

inline void* counted(void* memory) {
  const bool fails = until_failure >= 0 && until_failure-- == 0;
  if (fails) std::free(memory);
  if (fails || memory == nullptr) throw std::bad_alloc();
  ++allocations;
  bytes_in_use += static_cast<long>(malloc_usable_size(memory));
  return memory;
}

inline void give_back(void* memory) {
  if (memory != nullptr) bytes_in_use -= static_cast<long>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace detail
}  // namespace quoin::tests

void* operator new(std::size_t size) { return quoin::tests::detail::counted(std::malloc(size)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  const std::size_t border = static_cast<std::size_t>(alignment);
  return quoin::tests::detail::counted(
      std::aligned_alloc(border, (size + border - 1) / border * border));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return quoin::tests::detail::counted(std::malloc(size));
}
void operator delete(void* memory) noexcept { quoin::tests::detail::give_back(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept {
  quoin::tests::detail::give_back(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  quoin::tests::detail::give_back(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  quoin::tests::detail::give_back(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  quoin::tests::detail::give_back(memory);
}
