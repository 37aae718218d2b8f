#include "scene_file/shared_topology.hpp"

namespace quoin::scene_file {

geometry::Shape SharedTopologies::share(const geometry::Shape& shape) {
  const geometry::Topology& topology = shape.topology();
  std::vector<int> key = {topology.vertex_count(), topology.face_count()};
  for (int v = 0; v < topology.vertex_count(); ++v)
    if (!topology.is_corner(v)) return shape;
  for (int f = 0; f < topology.face_count(); ++f) {
    key.push_back(static_cast<int>(topology.face(f).size()));
    key.insert(key.end(), topology.face(f).begin(), topology.face(f).end());
  }
  for (const std::array<int, 3>& triangle : topology.triangles())
    key.insert(key.end(), triangle.begin(), triangle.end());
  const auto& kept = known_.try_emplace(std::move(key), shape.shared_topology()).first->second;
  return {kept, shape.vertices()};
}

}  // namespace quoin::scene_file
