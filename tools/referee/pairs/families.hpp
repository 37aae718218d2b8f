#pragma once
/// Seeded random pairs of convex solids, ordinary and hard: one list, in README.md with what each
/// draws and what is hard about it.

#include <span>
#include <string>
#include <vector>

#include "referee/pairs/solids.hpp"

namespace quoin::referee {

struct Family {
  const char* name;
  SolidPair (*make)(Random&);
  int weight;  ///< how often it is drawn among all
};

/// All families, and those of them that real data is made of.
std::span<const Family> families();
std::span<const Family> hard_families();

/// Names of the families, in the order of their numbers.
const std::vector<std::string>& family_names();

/// A pair of family `family` (index into family_names()).
SolidPair make_pair(int family, Random& random);

/// A pair of any family of which `wanted` is true (by number), the costly ones seldom.
SolidPair make_pair(Random& random, const std::vector<bool>& wanted = {});

}  // namespace quoin::referee
