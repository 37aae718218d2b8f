#pragma once
/// Maxima and minima that compilers turn into one instruction: those of the library become
/// branches, which could not be foreseen. Internal.

namespace quoin::geometry {

inline double greater(double x, double y) { return x > y ? x : y; }
inline double lesser(double x, double y) { return x < y ? x : y; }

}  // namespace quoin::geometry
