#pragma once
/// A convex polyhedron: a fixed, shared topology and the places of its vertices now.

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <quoin/geometry/types.hpp>
#include <span>
#include <vector>

namespace quoin::geometry {

/// The sizes that are worked with, m: every coordinate at most kLargestCoordinate, the largest side
/// of a solid's box at least kSmallestExtent. Searches multiply up to six lengths; a product of six
/// stays below 1.8e308 for lengths up to 2e51, and keeps two roundings in double-double (1e-64)
/// above 2.2e-308 down to lengths of 4e-41. What lies between is left to slim solids and their
/// faces.
inline constexpr double kLargestCoordinate = 1e30;
inline constexpr double kSmallestExtent = 1e-30;

enum class FeatureKind : std::uint8_t { Vertex, Edge, Face };

/// A vertex, edge or face of one polyhedron, by its index in the topology.
struct Feature {
  FeatureKind kind = FeatureKind::Vertex;
  int index = 0;
  auto operator<=>(const Feature&) const = default;
};

/// A vertex of the solid that is no corner of its faces, and where it lies within the length to
/// which labels are known: at a corner ({c, -1}), on the edge between two corners, or, where both
/// are -1, in a face. One that lies deeper below the surface goes by what is nearest.
struct HostedVertex {
  int vertex = 0;
  std::array<int, 2> corners{-1, -1};
  int face = -1;
};

/// What never changes while a polyhedron moves: which vertices make which edges and faces.
/// Faces are polygons, counter-clockwise seen from outside; edges are numbered by their vertices
/// in ascending order. Vertices that are no corners have a host (a corner, an edge or a face),
/// whose faces and edges count as theirs. Shared by all polyhedra of one shape.
class Topology {
 public:
  /// `faces`: cycles of corners, counter-clockwise from outside. `hosted`: all other vertices.
  /// `surface`: polygons of a finer closed surface, such as the exact hull's; vertices that it does
  /// not name lie below it. Empty: the faces. Throws InputError when the faces, or the surface, do
  /// not form a closed surface (each edge between exactly two faces, in opposite directions), or a
  /// vertex has neither face nor host, or a host that is no corner.
  Topology(int vertex_count, const std::vector<std::vector<int>>& faces,
           const std::vector<HostedVertex>& hosted = {},
           const std::vector<std::vector<int>>& surface = {});

  int vertex_count() const { return vertex_count_; }
  int edge_count() const { return static_cast<int>(edges_.size()); }
  int face_count() const { return static_cast<int>(face_start_.size()) - 1; }

  /// Its corners, in order.
  std::span<const int> face(int f) const { return row(face_vertices_, face_start_, f); }
  /// All vertices that lie in it, ascending: its corners and those that they, its edges and itself
  /// host, but for vertices below the surface.
  std::span<const int> face_set(int f) const { return row(face_sets_, face_set_start_, f); }
  /// Edge from each vertex of the face to the next; the face across it.
  std::span<const int> face_edges(int f) const { return row(face_edges_, face_start_, f); }
  std::span<const int> face_neighbours(int f) const {
    return row(face_neighbours_, face_start_, f);
  }
  /// Is every vertex a corner in which just three faces meet? Then the faces around a face are its
  /// neighbours.
  bool three_faces_at_vertices() const { return three_faces_at_vertices_; }
  const std::array<int, 2>& edge(int e) const { return edges_[index(e)]; }  ///< first < second
  /// The two faces it lies between; the first one runs from its first to its second vertex.
  const std::array<int, 2>& edge_faces(int e) const { return edge_faces_[index(e)]; }
  /// Where v lies: {Vertex, v} for a corner, otherwise its host.
  Feature host(int v) const {
    return hosts_.empty() ? Feature{FeatureKind::Vertex, v} : hosts_[index(v)];
  }
  bool all_are_corners() const { return hosts_.empty(); }
  bool is_corner(int v) const { return host(v) == Feature{FeatureKind::Vertex, v}; }
  /// All vertices that are no corners, ascending, in the form in which the constructor takes them.
  std::vector<HostedVertex> hosted_vertices() const;
  /// Corners joined to v by an edge, ascending; the edge to each; the faces around v, ascending, at
  /// least one. A vertex at a corner has that corner's; one on an edge has the ends of the edge,
  /// each by that edge; one in a face has the corners of the face and no edges.
  std::span<const int> neighbours(int v) const { return row(neighbours_, neighbour_start_, v); }
  std::span<const int> vertex_edges(int v) const {
    return row(neighbour_edges_, neighbour_edge_start_, v);
  }
  std::span<const int> vertex_faces(int v) const {
    return row(vertex_faces_, vertex_face_start_, v);
  }
  /// The edge on which both v and w lie, or -1.
  int find_edge(int v, int w) const {
    return edge_between_.empty() ? search_edge(v, w) : edge_between_[index(v * vertex_count_ + w)];
  }
  /// Of a solid with the faces of a brick: its vertices in the order of their places, bit k of
  /// which says that a vertex lies across edge k of vertex 0. Empty for others.
  std::span<const int> brick() const { return brick_; }
  /// A closed surface, counter-clockwise from outside, through all vertices but those below it.
  std::span<const std::array<int, 3>> triangles() const { return triangles_; }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static std::span<const int> row(const std::vector<int>& values, const std::vector<int>& start,
                                  int i) {
    return {values.data() + start[index(i)], values.data() + start[index(i) + 1]};
  }
  void add_edges(const std::vector<std::vector<int>>& faces);
  void add_hosts(const std::vector<HostedVertex>& hosted);
  void add_neighbours();
  void add_face_sets(const std::vector<std::vector<int>>& surface);
  void add_edge_table();
  void find_brick();
  int search_edge(int v, int w) const;

  static constexpr int kFewVertices = 64;  // for so many a table is worth its memory
  int vertex_count_ = 0;
  std::vector<std::int16_t> edge_between_;  // vertex_count × vertex_count, of few vertices
  std::vector<int> face_start_, face_vertices_, face_edges_, face_neighbours_;
  std::vector<int> face_set_start_, face_sets_;
  std::vector<std::array<int, 2>> edges_, edge_faces_;
  std::vector<int> neighbour_start_, neighbours_, neighbour_edge_start_, neighbour_edges_;
  std::vector<int> vertex_face_start_, vertex_faces_;
  std::vector<Feature> hosts_;  // by vertex; empty where all are corners
  std::vector<std::array<int, 3>> triangles_;
  std::vector<int> brick_;
  bool three_faces_at_vertices_ = true;
};

/// A face label: how far its vertices lie off it (rounding), its width, the faces around it.
struct LabelFit {
  double off_plane = 0.0;  ///< off the face's plane, m
  double outside = 0.0;    ///< and, as seen along its normal, beyond its sides, m; infinite: its
                           ///< corners are not those of a convex polygon, within rounding
  double width = 0.0;      ///< of the polygon, m: its least width is no less; 0: not known
  double turn = -1.0;      ///< greatest cosine of its normal and that of a face at its vertices
};

/// Memory on 64-byte borders, so that wide loads never straddle cache lines.
template <typename T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  AlignedAllocator() = default;
  template <typename U>
  explicit AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kAlignment); }
  bool operator==(const AlignedAllocator&) const { return true; }
};

/// The exact convex hull of its vertices as given, in the world frame. The faces of the topology
/// are labels on that solid: a rotated quadrilateral is never exactly planar.
class alignas(64) Shape {
 public:
  /// Whether the vertices make the faces convex is not checked: `build.hpp` does. vertices:
  /// 3 × vertex_count, m. Throws InputError as set_vertices does, for a topology that is null, and
  /// while the rounding mode of floating point is not to nearest (other calls do not ask).
  Shape(std::shared_ptr<const Topology> topology, const Eigen::Ref<const Points>& vertices);

  /// Moves or deforms: same topology, new places, of which the faces must still turn outward: that
  /// they do, and are convex, is not checked (mirrored vertices have a negative volume). No
  /// allocation. vertices: 3 × vertex_count, m.
  /// Throws InputError, and leaves everything as it was, for another number of columns, for a
  /// coordinate that is not finite or larger than kLargestCoordinate, and where the largest extent
  /// is smaller than kSmallestExtent.
  void set_vertices(const Eigen::Ref<const Points>& vertices);

  const Topology& topology() const { return *topology_; }
  const std::shared_ptr<const Topology>& shared_topology() const { return topology_; }
  const Points& vertices() const { return vertices_; }
  Vector3 vertex(int v) const { return vertices_.col(v); }
  int vertex_count() const { return static_cast<int>(vertices_.cols()); }
  const Box& box() const { return box_; }
  /// Twice the largest distance of a vertex from the middle of the box, m: the diameter of a
  /// centrally symmetric solid in any pose, never less than the diameter and never more than the
  /// diagonal of the box.
  double diameter() const { return diameter_; }
  double largest_coordinate() const { return largest_coordinate_; }  ///< of all |x|, |y|, |z|, m
  const Vector3& vertex_mean() const { return vertex_mean_; }        ///< a point inside, m
  /// Unit normal of a face label (area-weighted over its polygon), outward.
  Vector3 face_normal(int f) const { return face_normals_.col(f); }
  const Points& face_normals() const { return face_normals_; }
  const LabelFit& label_fit(int f) const { return label_fits_[static_cast<std::size_t>(f)]; }

  /// What the search scans. Offsets of the vertices from `origin`, rows x, y, z of `padded_count`
  /// doubles (a multiple of 8; the padding repeats vertex 0), 64-byte aligned, m.
  const Vector3& origin() const { return origin_; }
  const double* offsets() const { return offsets_.data(); }
  int padded_count() const { return padded_count_; }

 private:
  void update_faces();

  // What every query reads fills two cache lines.
  std::shared_ptr<const Topology> topology_;
  Points vertices_;
  std::vector<double, AlignedAllocator<double>> offsets_;
  int padded_count_ = 0;
  Vector3 origin_ = Vector3::Zero();
  double diameter_ = 0.0;
  double largest_coordinate_ = 0.0;
  Vector3 vertex_mean_ = Vector3::Zero();
  Points face_normals_;
  std::vector<LabelFit> label_fits_;
  Box box_;
};

}  // namespace quoin::geometry
