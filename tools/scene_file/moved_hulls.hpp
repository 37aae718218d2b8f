#pragma once
/// Equal bricks need one hull: a mesh that is an earlier one moved takes over its topology.

#include <functional>
#include <map>
#include <memory>
#include <quoin/geometry/shape.hpp>
#include <vector>

#include "scene_file/mesh_file.hpp"

namespace quoin::scene_file {

class MovedHulls {
 public:
  /// What `make` gives for the mesh, or its like for an earlier mesh with the same faces from which
  /// it differs by a translation, exactly in doubles: no sign that the hull hangs on then differs.
  /// Where a difference of corners rounds, or a vertex is none of the hull's, `make` is asked.
  geometry::Shape shape_of(const MeshBlock& mesh, const std::function<geometry::Shape()>& make);

 private:
  struct Key {
    std::vector<double> differences{};  ///< corners less the first; the label length
    std::vector<int> faces{};           ///< each behind its number of corners
    bool operator<(const Key& other) const;
  };
  static bool set(const MeshBlock& mesh, Key& key);

  std::map<Key, std::shared_ptr<const geometry::Topology>> known_;
};

}  // namespace quoin::scene_file
