#include "described_solid.hpp"

#include <algorithm>
#include <set>

namespace quoin::referee {
namespace {

using geometry::Points;
using geometry::Vector3;

void list_faces(const geometry::Hull& hull, DescribedSolid& solid) {
  const geometry::Topology& topology = hull.polyhedron.topology();
  for (int f = 0; f < topology.face_count(); ++f) {
    solid.face_sizes.push_back(static_cast<int>(topology.face(f).size()));
    for (const int v : topology.face(f)) {
      solid.face_vertices.push_back(hull.input_index[static_cast<std::size_t>(v)]);
    }
  }
}

void find_box(DescribedSolid& solid) {
  const Points& points = solid.points;
  if (points.cols() != 8) {
    return;
  }
  const Vector3 least = points.rowwise().minCoeff(), most = points.rowwise().maxCoeff();
  std::set<int> corners;
  for (int i = 0; i < 8; ++i) {
    int corner = 0;
    for (int k = 0; k < 3; ++k) {
      if (points(k, i) != least[k] && points(k, i) != most[k]) {
        return;
      }
      corner |= (points(k, i) == most[k] ? 1 : 0) << k;
    }
    corners.insert(corner);
  }
  const Vector3 half = 0.5 * (most - least), centre = least + half;
  if (corners.size() == 8 && centre - half == least && centre + half == most) {
    solid.box_centre = centre;
    solid.box_half = half;
  }
}

}  // namespace

DescribedSolid described(const Points& points, const geometry::Hull* hull) {
  DescribedSolid solid;
  solid.points = points;
  if (hull != nullptr) {
    list_faces(*hull, solid);
  }
  find_box(solid);
  return solid;
}

quoin_referee_solid DescribedSolid::view() const {
  quoin_referee_solid view{points.data(),
                           static_cast<int>(points.cols()),
                           face_sizes.data(),
                           static_cast<int>(face_sizes.size()),
                           face_vertices.data(),
                           {},
                           {}};
  std::copy_n(box_centre.data(), 3, view.box_centre);
  std::copy_n(box_half.data(), 3, view.box_half);
  return view;
}

quoin_referee_placement described(const geometry::Placement& placement) {
  quoin_referee_placement to;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(to.linear) = placement.linear;
  std::copy_n(placement.translation.data(), 3, to.translation);
  return to;
}

}  // namespace quoin::referee
