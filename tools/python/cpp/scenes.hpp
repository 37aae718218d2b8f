#pragma once
/// Scenes as Python holds them.

#include "arrays.hpp"
#include "scene_file/scene_file.hpp"

namespace quoin::python {

/// Of an object with to_json() and `folder`, that the files it names are relative to.
scene_file::SceneFile scene_file_of(const py::object& scene,
                                    const std::vector<std::string>& changes);

inline void copy(double* target, const Vector3& v) { std::copy_n(v.data(), 3, target); }

}  // namespace quoin::python
