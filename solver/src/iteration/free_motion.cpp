#include "iteration/free_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"

namespace quoin::solver {
namespace {

// A sum of m rounded terms is off by m u of their magnitudes, u = eps / 2 [Higham 2002,
// section 3.1]: 24 terms of two blocks' increments, of which each has six more behind it: 32 u.
constexpr double kMotionRounding = 16.0 * std::numeric_limits<double>::epsilon();
constexpr double kAsGood = 1e-12;  // of the motion: what a guess may be off by

/// Of a contact in free motion, m.
struct FreeContact {
  Vector3 end;                         ///< d
  Vector3 by_loads = Vector3::Zero();  ///< part of its change
  Vector3 rounding = Vector3::Zero();  ///< of both
};

FreeContact free_contact(const FreeMotion& free, const BlockVector& force, const LinearContact& c) {
  FreeContact moved{.end = c.offset};
  const auto add = [&](int slot, const ContactJacobian& jacobian) {
    if (slot < 0) return;
    const Vector12 increment = free.compliance.times(index(slot), force[index(slot)]);
    const Vector12& coasting = free.coasting[index(slot)];
    moved.end += jacobian * increment;
    moved.by_loads += jacobian * (increment - coasting);
    moved.rounding +=
        kMotionRounding * (jacobian.magnitudes(increment) + jacobian.magnitudes(coasting));
  };
  add(c.slot_a, c.jacobian_a);
  add(c.slot_b, c.jacobian_b);
  return moved;
}

bool is_left_alone(const LinearContact& c, const FreeContact& moved, double overlap) {
  if (c.compliant) return false;
  if (c.bonded || c.law == ContactLaw::Bilateral) {
    const Vector3 change = (moved.end - c.start).cwiseAbs() - moved.rounding;
    return (moved.by_loads.cwiseAbs() - moved.rounding).maxCoeff() <= 0.0 &&
           change.maxCoeff() <= c.rounding && moved.end.cwiseAbs().maxCoeff() <= overlap;
  }
  if (c.clings) {
    const Vector3 pulled = moved.by_loads.cwiseAbs() - moved.rounding;
    const Vector3 slid = (moved.end - c.start).cwiseAbs() - moved.rounding;
    if (pulled.tail<2>().maxCoeff() > 0.0 || slid.tail<2>().maxCoeff() > c.rounding) return false;
  }
  const double rounding = moved.rounding[0];
  return moved.end[0] >= 0.0 || (moved.by_loads[0] >= -rounding && moved.end[0] >= -overlap &&
                                 c.start[0] - moved.end[0] <= c.rounding + rounding);
}

}  // namespace

bool is_unforced(const FreeMotion& free, const BlockVector& force,
                 std::span<const LinearContact> contacts, double overlap) {
  return std::ranges::all_of(contacts, [&](const LinearContact& c) {
    return is_left_alone(c, free_contact(free, force, c), overlap);
  });
}

double coast(const FreeMotion& free, const Slots& slots, const BlockVector& force,
             BlockVector& increment) {
  double largest = 0.0;
  for (std::size_t s = 0; s < increment.size(); ++s) {
    const Vector12 next = free.compliance.times(s, force[s]);
    const double change = motion_of(next - increment[s], slots.length[s]);
    const double size = motion_of(next, slots.length[s]);
    if (std::isfinite(size) && change <= kAsGood * size) continue;
    largest = std::max(largest, change);
    increment[s] = next;
  }
  return largest;
}

void move_freely(const FreeMotion& free, const BlockVector& force,
                 std::span<LinearContact> contacts, BlockVector& increment) {
  for (std::size_t s = 0; s < increment.size(); ++s)
    increment[s] = free.compliance.times(s, force[s]);
  for (LinearContact& c : contacts) {
    c.relative = free_contact(free, force, c).end;
    c.force.setZero();
    c.multiplier.setZero();
    const bool held = c.bonded || c.law == ContactLaw::Bilateral;
    c.assumed = c.mode = held ? ContactMode::Stick : ContactMode::Open;
  }
}

}  // namespace quoin::solver
