#pragma once
/// A solid in the terms of the plug-in interface.

#include <quoin/referee.h>

#include <quoin/geometry/body.hpp>
#include <quoin/geometry/build.hpp>
#include <vector>

namespace quoin::referee {

/// Owns what a quoin_referee_solid points to. Without faces where quoin refuses the solid; with a
/// box where the solid is one that follows the axes of its frame.
struct DescribedSolid {
  geometry::Points points;
  std::vector<int> face_sizes, face_vertices;
  geometry::Vector3 box_centre = geometry::Vector3::Zero();
  geometry::Vector3 box_half = geometry::Vector3::Zero();

  bool is_box() const { return box_half[0] > 0; }
  quoin_referee_solid view() const;
};

/// `hull`: of these points, null where there is none.
DescribedSolid described(const geometry::Points& points, const geometry::Hull* hull);

quoin_referee_placement described(const geometry::Placement& placement);

}  // namespace quoin::referee
