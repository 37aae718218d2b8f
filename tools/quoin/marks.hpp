#pragma once
/// Loads, supports at points, motions and monitors of a scene, for `quoin view SCENE.json`.

#include <nlohmann/json.hpp>

#include "scene_file/scene_file.hpp"

namespace quoin::commands {

/// Of all stages, each once: `kind` (load, traction, body load, water, fixed point, motion,
/// monitor), `block`, `at` (where it acts at the start, m); of those that push or move `vector`,
/// the value that is the largest of the run, and `unit`; of water `rim`: around the face x, y, z
/// (m) and pressure (Pa).
nlohmann::ordered_json marks_json(const scene_file::SceneFile& file);

}  // namespace quoin::commands
