#pragma once
/// Contacts of one pair of blocks summed up, and pairs that have parted.

#include <array>
#include <quoin/solver/simulation.hpp>
#include <span>
#include <vector>

namespace quoin::commands {

using JointedPair = std::array<int, 2>;  ///< two blocks, a < b

/// Adds the pairs that lie on each other or are closed to `pairs`, which stays ascending.
void append_joined(std::span<const solver::Contact> contacts, std::vector<JointedPair>& pairs);

/// Open contacts, without force, of those of `pairs` that `contacts` no longer has: at their
/// nearest features, with their gap. Places are relative to State::origin. Absent blocks have none.
std::vector<solver::Contact> parted_contacts(const solver::Simulation& simulation,
                                             std::span<const JointedPair> pairs,
                                             std::span<const solver::Contact> contacts);

/// The contacts of a pair of blocks as one joint. Forces are on b.
struct JointSum {
  int a = 0, b = 0;
  int points = 0, closed = 0;
  double gap = 0.0;           ///< least, m
  double area = 0.0;          ///< m2
  double normal_force = 0.0;  ///< sum, N, compression positive
  double edge_stress = -1.0;  ///< no_tension_edge_stress, Pa; below 0: none
  solver::Vector3 centre =
      solver::Vector3::Zero();  ///< of the normal forces; of the points where nothing presses, m
  solver::Vector3 normal = solver::Vector3::Zero();  ///< mean, from a to b
  solver::Vector3 force = solver::Vector3::Zero();   ///< N
  solver::Vector3 moment =
      solver::Vector3::Zero();  ///< about the middle of the points by area, N m
};

/// By pair, in the order of the contacts, which are sorted by key.
std::vector<JointSum> sums_by_joint(std::span<const solver::Contact> contacts);

}  // namespace quoin::commands
