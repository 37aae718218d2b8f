#pragma once
/// Counts calls of malloc and its kin, and their bytes, in the whole program (glibc): Eigen and the
/// C++ library alike.

namespace quoin::bench {

/// How many allocations were made up to now, by any thread.
long allocation_count();

/// Bytes allocated and not freed.
long bytes_in_use();

/// The most that was in use since start_peak().
void start_peak();
long peak_bytes();

}  // namespace quoin::bench
