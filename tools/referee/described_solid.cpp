#include "described_solid.hpp"

#include <algorithm>
#include <quoin/geometry/build.hpp>
#include <set>

namespace quoin::referee {

using geometry::Matrix3;
using geometry::Points;
using geometry::Vector3;

DescribedSolid::DescribedSolid(const Points& points) : points_(points) {
  find_faces();
  find_box();
}

void DescribedSolid::find_faces() {
  try {
    const geometry::Hull hull = geometry::make_hull(points_);
    const geometry::Topology& topology = hull.polyhedron.topology();
    for (int f = 0; f < topology.face_count(); ++f) {
      face_sizes_.push_back(static_cast<int>(topology.face(f).size()));
      for (const int v : topology.face(f)) {
        face_vertices_.push_back(hull.input_index[static_cast<std::size_t>(v)]);
      }
    }
  } catch (const geometry::InputError&) {
    face_sizes_.clear();
    face_vertices_.clear();
  }
}

void DescribedSolid::find_box() {
  if (points_.cols() != 8) {
    return;
  }
  const Vector3 least = points_.rowwise().minCoeff(), most = points_.rowwise().maxCoeff();
  std::set<int> corners;
  for (int i = 0; i < 8; ++i) {
    int corner = 0;
    for (int k = 0; k < 3; ++k) {
      if (points_(k, i) != least[k] && points_(k, i) != most[k]) {
        return;
      }
      corner |= (points_(k, i) == most[k] ? 1 : 0) << k;
    }
    corners.insert(corner);
  }
  const Vector3 half = 0.5 * (most - least), centre = least + half;
  if (corners.size() == 8 && centre - half == least && centre + half == most) {
    box_centre_ = centre;
    box_half_ = half;
  }
}

quoin_referee_solid DescribedSolid::view() const {
  quoin_referee_solid view{points_.data(),
                           static_cast<int>(points_.cols()),
                           face_sizes_.data(),
                           static_cast<int>(face_sizes_.size()),
                           face_vertices_.data(),
                           {},
                           {}};
  std::copy_n(box_centre_.data(), 3, view.box_centre);
  std::copy_n(box_half_.data(), 3, view.box_half);
  return view;
}

quoin_referee_placement described(const geometry::Placement& placement) {
  quoin_referee_placement to;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(to.linear) = placement.linear;
  std::copy_n(placement.translation.data(), 3, to.translation);
  return to;
}

bool is_rotation(const Matrix3& linear) {
  return (linear.transpose() * linear - Matrix3::Identity()).cwiseAbs().maxCoeff() <= 1e-14;
}

}  // namespace quoin::referee
