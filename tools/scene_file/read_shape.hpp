#pragma once
/// Blocks' shapes and places from a checked JSON document.

#include <nlohmann/json_fwd.hpp>
#include <quoin/geometry/polyhedron.hpp>

namespace quoin::scene_file {

geometry::Vector3 read_vector(const nlohmann::json& value);

/// `shape`: box, prism, hull or polyhedron. Throws geometry::InputError when it is no convex solid.
geometry::Polyhedron read_shape(const nlohmann::json& shape);

/// Moves a polyhedron to `pose`. Throws SceneError with the place below `pointer`.
void apply_pose(const nlohmann::json& pose, const std::string& pointer,
                geometry::Polyhedron& polyhedron);

}  // namespace quoin::scene_file
