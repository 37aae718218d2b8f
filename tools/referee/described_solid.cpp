#include "described_solid.hpp"

#include <algorithm>
#include <numeric>
#include <quoin/geometry/build.hpp>
#include <set>

namespace quoin::referee {
namespace {

using geometry::Points;
using geometry::Vector3;

/// `number`: of each vertex among the solid's points.
void list_faces(const geometry::Topology& topology, const std::vector<int>& number,
                DescribedSolid& solid) {
  for (int f = 0; f < topology.face_count(); ++f) {
    solid.face_sizes.push_back(static_cast<int>(topology.face(f).size()));
    for (const int v : topology.face(f))
      solid.face_vertices.push_back(number[static_cast<std::size_t>(v)]);
  }
}

/// The solid's own faces need no hull.
geometry::Hull hull_of(const Solid& solid) {
  if (!solid.topology) return geometry::make_hull(solid.placed.points);
  std::vector<int> same(static_cast<std::size_t>(solid.placed.points.cols()));
  std::iota(same.begin(), same.end(), 0);
  return {shape_of(solid), same};
}

void find_box(DescribedSolid& solid) {
  const Points& points = solid.points;
  if (points.cols() != 8) return;
  const Vector3 least = points.rowwise().minCoeff(), most = points.rowwise().maxCoeff();
  std::set<int> corners;
  for (int i = 0; i < 8; ++i) {
    int corner = 0;
    for (int k = 0; k < 3; ++k) {
      if (points(k, i) != least[k] && points(k, i) != most[k]) return;
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

DescribedSolid described(const Solid& given, std::optional<geometry::Shape>& shape) {
  DescribedSolid solid;
  solid.points = given.placed.points;
  find_box(solid);
  try {
    const geometry::Hull hull = hull_of(given);
    list_faces(hull.polyhedron.topology(), hull.input_index, solid);
    shape = hull.polyhedron;
  } catch (const geometry::InputError&) {
    shape = std::nullopt;
  }
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
