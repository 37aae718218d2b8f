#pragma once
/// States of the solver that agree to the bit.

#include <algorithm>
#include <quoin/solver/simulation.hpp>
#include <sstream>
#include <string>

namespace quoin::tests {

inline bool same_bits(const solver::BlockState& a, const solver::BlockState& b) {
  return a.centroid == b.centroid && a.centroid_rest == b.centroid_rest &&
         a.rotation.coeffs() == b.rotation.coeffs() && a.strain == b.strain &&
         a.velocity == b.velocity && a.angular_velocity == b.angular_velocity &&
         a.strain_rate == b.strain_rate;
}

inline bool same_bits(const solver::State& a, const solver::State& b) {
  const auto same_contact = [](const solver::Contact& c, const solver::Contact& d) {
    return c.point.key == d.point.key && c.point.gap == d.point.gap &&
           c.normal_force == d.normal_force && c.shear_force == d.shear_force && c.slip == d.slip;
  };
  return a.time == b.time && a.energy.mechanical() == b.energy.mechanical() &&
         std::ranges::equal(a.contacts, b.contacts, same_contact) &&
         std::ranges::equal(a.blocks, b.blocks,
                            [](const auto& x, const auto& y) { return same_bits(x, y); });
}

/// The bytes of its checkpoint.
inline std::string saved(const solver::Simulation& simulation) {
  std::ostringstream out;
  simulation.save(out);
  return out.str();
}

}  // namespace quoin::tests
