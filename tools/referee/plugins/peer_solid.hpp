#pragma once
/// What plug-ins of other libraries share: a solid as points and faces, and where it stands.

#include <quoin/referee.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <vector>

namespace quoin::referee {

using Vector3 = Eigen::Vector3d;

struct PeerPlacement {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Vector3 translation = Vector3::Zero();
};

inline PeerPlacement to_eigen(const quoin_referee_placement& placement) {
  using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  return {Eigen::Map<const Rows>(placement.linear), Vector3(placement.translation)};
}

inline std::vector<Vector3> points_of(const quoin_referee_solid& solid) {
  std::vector<Vector3> points;
  for (int i = 0; i < solid.point_count; ++i) points.emplace_back(solid.points + 3 * i);
  return points;
}

template <class Made>
void free_solid(void* solid) {
  delete static_cast<Made*>(solid);
}

/// What quoin_referee_plugin returns.
const quoin_referee_library* library_at(int index, const auto& libraries) {
  return index >= 0 && index < static_cast<int>(std::size(libraries)) ? libraries + index : nullptr;
}

inline void copy(const Vector3& from, double* to) { std::copy_n(from.data(), 3, to); }

}  // namespace quoin::referee
