#pragma once
/// Loads, fixed points, ties and monitors whose place is no point of their block.

#include <string>
#include <string_view>
#include <vector>

#include "scene_file/scene_file.hpp"

namespace quoin::scene_file {

/// It moves along with its block all the same, as the end of a lever.
struct PointOutside {
  std::string_view what;  ///< "load", "fixed point", "tie" or "monitor"
  std::string block;
  Vector3 point = Vector3::Zero();  ///< at the start, m
  /// How far, at least: its largest distance from a face's plane, m.
  double distance = 0.0;
};

/// Those of any stage, once, farther out than 1e-6 of their block's size.
std::vector<PointOutside> points_outside(const SceneFile& file);

/// A line for each; those after the tenth are counted in one line.
std::vector<std::string> points_outside_lines(const SceneFile& file);

/// Of a point from the planes of the faces of a block, of the part that it is nearest to, as it is
/// at the start: the largest, m. Below 0 inside.
double distance_outside(const solver::Block& block, const Vector3& point);

/// A point so far outside a block still counts as on it: 1e-6 of the block's size, m.
double largest_distance_on(const solver::Block& block);

}  // namespace quoin::scene_file
