#pragma once
/// A convex polyhedron: a fixed, shared topology and the places of its vertices now.

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <quoin/geometry/types.hpp>
#include <span>
#include <vector>

namespace quoin::geometry {

enum class FeatureKind : std::uint8_t { Vertex, Edge, Face };

/// A vertex, edge or face of one polyhedron, by its index in the topology.
struct Feature {
  FeatureKind kind = FeatureKind::Vertex;
  int index = 0;
  auto operator<=>(const Feature&) const = default;
};

/// What never changes while a polyhedron moves: which vertices make which edges and faces.
/// Faces are polygons, counter-clockwise seen from outside; edges are numbered by their vertices
/// in ascending order. Shared by all polyhedra of one shape.
class Topology {
 public:
  /// `faces`: vertex cycles, counter-clockwise from outside. Throws InputError when the faces do
  /// not form one closed surface (each edge between exactly two faces, in opposite directions).
  Topology(int vertex_count, const std::vector<std::vector<int>>& faces);

  int vertex_count() const { return vertex_count_; }
  int edge_count() const { return static_cast<int>(edges_.size()); }
  int face_count() const { return static_cast<int>(face_start_.size()) - 1; }

  std::span<const int> face(int f) const;               ///< its vertices in order
  std::array<int, 2> edge(int e) const;                 ///< its vertices, first < second
  std::array<int, 2> edge_faces(int e) const;           ///< the two faces it lies between
  std::span<const int> neighbours(int v) const;         ///< vertices joined to v by an edge
  int find_edge(int v, int w) const;                    ///< index, or -1

 private:
  int vertex_count_ = 0;
  std::vector<int> face_start_, face_vertices_;
  std::vector<std::array<int, 2>> edges_, edge_faces_;
  std::vector<int> neighbour_start_, neighbours_, neighbour_edges_;
};

/// The exact convex hull of its vertices as given, in the world frame. The faces of the topology are
/// labels on that solid: a rotated quadrilateral is never exactly planar.
class Polyhedron {
 public:
  /// Takes the vertices unchecked: `build.hpp` checks. vertices: 3 × vertex_count, m.
  Polyhedron(std::shared_ptr<const Topology> topology, const Eigen::Ref<const Points>& vertices);

  /// Moves or deforms: same topology, new places. No allocation. vertices: 3 × vertex_count, m.
  void set_vertices(const Eigen::Ref<const Points>& vertices);

  const Topology& topology() const { return *topology_; }
  const std::shared_ptr<const Topology>& shared_topology() const { return topology_; }
  const Points& vertices() const { return vertices_; }
  Vector3 vertex(int v) const { return vertices_.col(v); }
  const Box& box() const { return box_; }

 private:
  std::shared_ptr<const Topology> topology_;
  Points vertices_;
  Box box_;
};

}  // namespace quoin::geometry
