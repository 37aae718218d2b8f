#pragma once
/// Counts calls of malloc and its kin in the whole program (glibc): Eigen and the C++ library
/// alike.

namespace quoin::bench {

/// How many allocations were made up to now, by any thread.
long allocation_count();

}  // namespace quoin::bench
