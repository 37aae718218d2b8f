#pragma once
/// Blocks' shapes and places from a checked JSON document.

#include <nlohmann/json_fwd.hpp>
#include <quoin/geometry/body.hpp>
#include <string>

namespace quoin::scene_file {

geometry::Vector3 read_vector(const nlohmann::json& value);

/// `shape`: box, prism, hull or polyhedron. Throws geometry::InputError when it is no convex solid.
geometry::Shape read_shape(const nlohmann::json& shape);

/// Throws SceneError with the place below `pointer`.
geometry::Placement read_pose(const nlohmann::json& pose, const std::string& pointer);

/// Points in a frame of their own and where that stands.
struct PlacedPoints {
  geometry::Points points;
  geometry::Placement placement;
};

/// `value`: a list of points (m), or {"points": […], "placement": [t, A by rows]} with the 12
/// numbers of x = t + A X (t in m, det A > 0). Throws geometry::InputError, which begins with
/// `name`.
PlacedPoints read_placed_points(const nlohmann::json& value, const std::string& name);

}  // namespace quoin::scene_file
