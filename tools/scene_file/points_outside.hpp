#pragma once
/// Loads and fixed points whose place is no point of their block.

#include <string>
#include <vector>

#include "scene_file/scene_file.hpp"

namespace quoin::scene_file {

/// It moves along with its block all the same, as the end of a lever.
struct PointOutside {
  const char* what = "";  ///< "load" or "fixed point"
  int block = 0;
  Vector3 point = Vector3::Zero();  ///< at the start, m
  /// How far, at least: its largest distance from a face's plane, m.
  double distance = 0.0;
};

/// Those farther out than 1e-6 of their block's size.
std::vector<PointOutside> points_outside(const solver::Scene& scene);

/// A line for each of any stage, once; those after the tenth are counted in one line.
std::vector<std::string> points_outside_lines(const SceneFile& file);

/// Of a point from the planes of the faces of a block, of the part that it is nearest to, as it is
/// at the start: the largest, m. Below 0 inside.
double distance_outside(const solver::Block& block, const Vector3& point);

}  // namespace quoin::scene_file
