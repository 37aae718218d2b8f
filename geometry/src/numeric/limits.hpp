#pragma once
/// Names for two limits of doubles. Internal.

#include <limits>

namespace quoin::geometry {

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();  ///< 2^-52
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace quoin::geometry
