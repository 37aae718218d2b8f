#pragma once
/// A solid in the terms of the plug-in interface.

#include <quoin/referee.h>

#include <optional>
#include <vector>

#include "referee/pairs/solids.hpp"

namespace quoin::referee {

/// Owns what a quoin_referee_solid points to. Faces are the solid's own or those of quoin's hull,
/// none where quoin refuses the solid; a box is one that follows the axes of its frame.
struct DescribedSolid {
  geometry::Points points;
  std::vector<int> face_sizes, face_vertices;
  geometry::Vector3 box_centre = geometry::Vector3::Zero();
  geometry::Vector3 box_half = geometry::Vector3::Zero();

  bool is_box() const { return box_half[0] > 0; }
  quoin_referee_solid view() const;
};

/// `shape`: as quoin takes the solid; none where it refuses.
DescribedSolid described(const Solid& solid, std::optional<geometry::Shape>& shape);

quoin_referee_placement described(const geometry::Placement& placement);

}  // namespace quoin::referee
