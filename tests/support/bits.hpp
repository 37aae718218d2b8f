#pragma once
/// Answers bit by bit, signs of zeros too.

#include <bit>
#include <cstdint>
#include <quoin/geometry/contact_point.hpp>
#include <vector>

namespace quoin::tests {

/// Numbers of an answer in the order in which they were added.
struct Bits {
  std::vector<std::uint64_t> all;
  void add(double value) { all.push_back(std::bit_cast<std::uint64_t>(value)); }
  void add(int value) { all.push_back(static_cast<std::uint64_t>(value)); }
  void add(const geometry::Vector3& v) {
    for (const double x : {v.x(), v.y(), v.z()}) add(x);
  }
  void add(const geometry::Feature& feature) {
    add(static_cast<int>(feature.kind));
    add(feature.index);
  }
};

}  // namespace quoin::tests
