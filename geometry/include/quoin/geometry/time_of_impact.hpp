#pragma once
/// When two bodies that move and turn through a step come near each other.

#include <quoin/geometry/nearest_features.hpp>

namespace quoin::geometry {

/// How a body moves from where it stands through a step, s = 0 … 1: `centre` goes evenly along
/// `translation`, and the body turns evenly about it. By default it stands still.
struct Motion {
  Vector3 translation = Vector3::Zero();  ///< of the whole step, m
  Vector3 rotation = Vector3::Zero();     ///< axis times angle of the whole step, rad, any angle
  Vector3 centre = Vector3::Zero();       ///< in the world at s = 0, m
};

/// Where a body that stands at `start` is at s of its motion.
Placement placement_at(const Placement& start, const Motion& motion, double s);

/// The motion from one placement to another, of which both are rotations, by the shorter turn about
/// a point of the body: `centre` in the world at `start`, m.
Motion motion_between(const Placement& start, const Placement& end, const Vector3& centre);

enum class ImpactStatus : std::uint8_t {
  Impact,       ///< at `s` they are within the length of each other
  Apart,        ///< to the end of the step they stay apart by more than half of that
  NotConverged  ///< up to `s` they are apart; beyond it is not known
};

struct Impact {
  ImpactStatus status = ImpactStatus::NotConverged;
  double s = 0.0;           ///< part of the step, 0 … 1; up to here they do not touch
  NearestFeatures nearest;  ///< at s
  int iterations = 0;       ///< distances asked for
};

struct ImpactOptions {
  double length = 0.0;  ///< the gap that counts as an impact, m; at least what rounding leaves open
  int max_iterations = 1000;
};

/// The time of impact, never late: before `s` the gap is above half of `length`, and at an impact
/// it is at most `length`. Bodies that touch, overlap or are within `length` at the start: an
/// impact at 0. The gap is advanced on by the bound of its change ([Mirtich 1996]): each distance
/// is certified, and none of their points comes nearer along its normal than by the translations
/// and by what the turns move the point farthest from the axes. Costs a distance a step; bodies
/// that slide past each other at about `length` need up to 2 (their way) / length of them. Throws
/// InputError for placements, motions and lengths that are not finite or negative.
Impact time_of_impact(const Body& a, const Motion& motion_a, const Body& b, const Motion& motion_b,
                      const ImpactOptions& options);

}  // namespace quoin::geometry
