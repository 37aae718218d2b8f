#pragma once
/// Sizes of a pair, what an answer to it may be off, and which solids may be refused.
///
/// With D the larger diameter and P the share of it that a library promises (quoin: 0), m:
///   gap    1e-12 of itself + 16 eps D + P D, + 4 eps of the largest coordinate of a shape that a
///          placement turns (its own frame rounds there)
///   place  the same + 4 eps of the largest coordinate in the world (a point is three doubles: half
///          an eps each, once for the place, once for what it is measured from, in three axes)

#include <limits>

#include "referee/pairs/solids.hpp"

namespace quoin::referee {

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// Sizes of a pair, m, and what follows from them.
struct PairSizes {
  double larger = 0, smaller = 0;  ///< diameters
  double shape_coordinate = 0;     ///< largest in the shapes' own frames
  double world_coordinate = 0;     ///< largest of all
  bool own_frames = false;         ///< no placement moves either solid

  explicit PairSizes(const SolidPair& pair);

  /// `promised`: the share P.
  double allowed_gap(long double exact, double promised = 0.0) const;
  double allowed_place(long double exact, double promised = 0.0) const;
};

/// The length below which points count as lying in one plane, m.
double stated_thickness(const Solid& solid);
/// The thickness of the points, m; 0 where they lie in one plane.
double thickness(const Solid& solid);
/// Sizes for which answers are promised.
bool in_range(const Solid& solid);

}  // namespace quoin::referee
