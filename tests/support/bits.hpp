#pragma once
/// Answers bit by bit, signs of zeros too.

#include <array>
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
  template <class T, std::size_t kCount>
  void add(const std::array<T, kCount>& values) {
    for (const T& value : values) add(value);
  }
  void add(const geometry::FeatureHint& hint) {
    add(hint.vertices_a);
    add(hint.vertices_b);
    add(std::array{hint.face_a, hint.face_b});
    add(hint.normal);
  }
  /// But for its hint and the work that it took.
  void add(const geometry::NearestFeatures& n) {
    add(std::array{n.gap, n.residual_a, n.residual_b});
    add(std::array{n.normal, n.point_a, n.point_b});
    add(std::array{n.feature_a, n.feature_b});
    add(std::array{static_cast<int>(n.status), static_cast<int>(n.rule),
                   static_cast<int>(n.indeterminate)});
  }
  /// But for its predecessor.
  void add(const geometry::ContactPoint& point) {
    add(std::array{point.key.a, point.key.b, static_cast<int>(point.type),
                   static_cast<int>(point.indeterminate)});
    add(std::array{point.key.feature_a, point.key.feature_b});
    add(std::array{point.point_a, point.point_b, point.normal});
    add(std::array{point.gap, point.area});
  }
  template <class T>
  void add(const std::vector<T>& values) {
    for (const T& value : values) add(value);
  }
  bool operator==(const Bits&) const = default;
};

Bits bits_of(const auto&... answers) {
  Bits bits;
  (bits.add(answers), ...);
  return bits;
}

}  // namespace quoin::tests
