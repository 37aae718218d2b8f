#include <quoin/geometry/build.hpp>

namespace quoin::geometry {

Shape join(std::span<const Shape> parts) {
  std::vector<std::vector<int>> faces, surface;
  std::vector<HostedVertex> hosted;
  int count = 0;
  for (const Shape& part : parts) count += part.vertex_count();
  Points vertices(3, count);
  int first = 0;
  for (const Shape& part : parts) {
    const Topology& topology = part.topology();
    const auto place = [first](int v) { return v < 0 ? v : first + v; };
    const auto append = [&](std::span<const int> cycle, std::vector<std::vector<int>>& polygons) {
      polygons.emplace_back();
      for (const int v : cycle) polygons.back().push_back(place(v));
    };
    for (HostedVertex vertex : topology.hosted_vertices()) {
      vertex.vertex = place(vertex.vertex);
      for (int& corner : vertex.corners) corner = place(corner);
      if (vertex.face >= 0) vertex.face += static_cast<int>(faces.size());
      hosted.push_back(vertex);
    }
    for (int f = 0; f < topology.face_count(); ++f) append(topology.face(f), faces);
    for (const auto& triangle : topology.triangles()) append(triangle, surface);
    vertices.middleCols(first, part.vertex_count()) = part.vertices();
    first += part.vertex_count();
  }
  return {std::make_shared<const Topology>(count, faces, hosted, surface), vertices};
}

}  // namespace quoin::geometry
