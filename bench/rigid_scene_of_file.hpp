#pragma once
/// A scene file's blocks as plain rigid bodies, for codes that read no scene files.

#include "rigid_scenes.hpp"
#include "scene_file/scene_file.hpp"

namespace quoin::bench {

/// Throws std::invalid_argument for what the peers' worlds here do not know.
RigidScene rigid_scene(const scene_file::SceneFile& file);

}  // namespace quoin::bench
