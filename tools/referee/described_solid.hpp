#pragma once
/// A solid in the terms of the plug-in interface.

#include <quoin/referee.h>

#include <vector>

#include "support/solids.hpp"

namespace quoin::referee {

/// Owns what a quoin_referee_solid points to. Faces are those of quoin's hull; where it refuses the
/// solid there are none.
class DescribedSolid {
 public:
  explicit DescribedSolid(const geometry::Points& points);
  quoin_referee_solid view() const;

 private:
  void find_faces();
  void find_box();

  geometry::Points points_;
  std::vector<int> face_sizes_, face_vertices_;
  geometry::Vector3 box_centre_ = geometry::Vector3::Zero();
  geometry::Vector3 box_half_ = geometry::Vector3::Zero();
};

quoin_referee_placement described(const geometry::Placement& placement);

/// A rotation within rounding of its nine numbers.
bool is_rotation(const geometry::Matrix3& linear);

}  // namespace quoin::referee
