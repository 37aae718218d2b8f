#pragma once
/// The scene's list `overrides`: which blocks each of them means.

#include <nlohmann/json.hpp>
#include <quoin/solver/scene.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "scene_file/formula.hpp"

namespace quoin::scene_file {

/// By what an override finds a block.
struct BlockLabel {
  std::string_view name{};               ///< of the scene
  std::string_view file_name{};          ///< of its file, beside its id; may be empty
  const solver::Block* block = nullptr;  ///< for its centroid at the start
};

/// For each block the numbers of the overrides (at `pointer`) that mean it, ascending. "blocks"
/// holds names, ids or patterns (* ? [abc], as of files), "where" a condition of the centroid x, y,
/// z (m); both: both must hold. Throws SceneError for a name, pattern or condition that no block
/// meets.
std::vector<std::vector<int>> match_overrides(const nlohmann::json& overrides,
                                              const std::string& pointer,
                                              std::span<const BlockLabel> blocks,
                                              const Parameters& parameters);

/// By block: whether one of the names, ids or patterns means it (`names`: one, or a list). Throws
/// SceneError for one that means no block.
std::vector<char> match_blocks(const nlohmann::json& names, const std::string& pointer,
                               std::span<const BlockLabel> blocks, std::string_view what = "block");

}  // namespace quoin::scene_file
