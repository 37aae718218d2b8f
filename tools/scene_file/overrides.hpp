#pragma once
/// The scene's list `overrides`: which blocks each of them means.

#include <nlohmann/json.hpp>
#include <quoin/geometry/types.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "scene_file/formula.hpp"

namespace quoin::scene_file {

/// By what an override finds a block.
struct BlockLabel {
  std::string_view name{};       ///< of the scene
  std::string_view file_name{};  ///< of its file, beside its id; may be empty
  geometry::Vector3 centroid = geometry::Vector3::Zero();  ///< at the start, m
};

/// For each block the numbers of the overrides that mean it, ascending. "blocks" holds names, ids
/// or patterns (* ? [abc], as of files), "where" a condition of the centroid x, y, z (m); both:
/// both must hold. Throws SceneError for a name, pattern or condition that no block meets.
std::vector<std::vector<int>> match_overrides(const nlohmann::json& overrides,
                                              std::span<const BlockLabel> blocks,
                                              const Parameters& parameters);

}  // namespace quoin::scene_file
