#pragma once
/// What counts as rounding.

namespace quoin::solver {

/// What sums and products of many terms are off by at most, relative to these: 5e6 roundings of
/// doubles. What differs by less is the same, what is smaller is none. A tenth of it and ten times
/// as much change no answer (bench/constants.md).
inline constexpr double kRelativeRounding = 1e-9;

}  // namespace quoin::solver
