#include <quoin/geometry/shape.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "numeric/error_bounds.hpp"
#include "numeric/numbers.hpp"
#include "shape/polygon_area.hpp"
#include "shape/rows.hpp"

namespace quoin::geometry {
namespace {

struct HalfEdge {
  std::array<int, 2> ends{};  // first < second
  int face = 0;
  int slot = 0;          // where its edge number belongs in face_edges
  bool forward = false;  // the face runs from ends[0] to ends[1]
};

using Polygons = std::vector<std::vector<int>>;

/// By their ends; of the same two the forward ones first.
std::vector<HalfEdge> sorted_halves(int vertex_count, const Polygons& faces) {
  std::vector<int> start;
  std::vector<HalfEdge> halves;
  const auto visit = [&](const auto& put) {
    int slot = 0;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const std::vector<int>& cycle = faces[f];
      for (std::size_t k = 0; k < cycle.size(); ++k, ++slot) {
        const int v = cycle[k], w = cycle[k + 1 < cycle.size() ? k + 1 : 0];
        put(std::min(v, w),
            HalfEdge{{std::min(v, w), std::max(v, w)}, static_cast<int>(f), slot, v < w});
      }
    }
  };
  fill_rows(vertex_count, visit, start, halves);
  for (std::size_t v = 0; v + 1 < start.size(); ++v) {
    std::sort(halves.begin() + start[v], halves.begin() + start[v + 1],
              [](const HalfEdge& p, const HalfEdge& q) {
                return std::pair(p.ends[1], !p.forward) < std::pair(q.ends[1], !q.forward);
              });
  }
  return halves;
}

/// `what`: a polygon's name in messages.
void check_polygons(int vertex_count, const Polygons& polygons, const std::string& what) {
  const auto name = [&](std::size_t f) { return what + " " + std::to_string(f); };
  for (std::size_t f = 0; f < polygons.size(); ++f) {
    if (polygons[f].size() < 3) {
      throw InputError(name(f) + " has " + std::to_string(polygons[f].size()) +
                       " vertices, at least 3 needed");
    }
    for (const int v : polygons[f]) {
      if (v < 0 || v >= vertex_count) {
        throw InputError(name(f) + " names vertex " + std::to_string(v) + ", but there are " +
                         std::to_string(vertex_count) + " vertices");
      }
      if (std::count(polygons[f].begin(), polygons[f].end(), v) > 1)
        throw InputError(name(f) + " names vertex " + std::to_string(v) + " twice");
    }
  }
}

std::string edge_name(const std::array<int, 2>& ends) {
  return "edge " + std::to_string(ends[0]) + "-" + std::to_string(ends[1]);
}

void check_twins(std::span<const HalfEdge> halves, const std::string& what) {
  const auto edge = [&] { return edge_name(halves[0].ends); };
  if (halves.size() == 1) {
    throw InputError(edge() + " belongs to " + what + " " + std::to_string(halves[0].face) +
                     " only: the surface is open");
  }
  if (halves.size() > 2) {
    throw InputError(edge() + " belongs to " + std::to_string(halves.size()) + " " + what +
                     "s, 2 allowed");
  }
  if (halves[0].forward == halves[1].forward) {
    throw InputError(edge() + ": " + what + "s " + std::to_string(halves[0].face) + " and " +
                     std::to_string(halves[1].face) +
                     " run along it in the same direction (mixed orientation)");
  }
}

/// The halves of each edge in turn, checked.
template <typename Visit>
void visit_edges(const std::vector<HalfEdge>& halves, const std::string& what, const Visit& visit) {
  for (std::size_t i = 0; i < halves.size();) {
    std::size_t j = i;
    while (j < halves.size() && halves[j].ends == halves[i].ends) ++j;
    const std::span<const HalfEdge> of_edge(halves.data() + i, j - i);
    check_twins(of_edge, what);
    visit(of_edge);
    i = j;
  }
}

void check_surface(int vertex_count, const Polygons& surface) {
  const std::string what = "surface polygon";
  check_polygons(vertex_count, surface, what);
  visit_edges(sorted_halves(vertex_count, surface), what, [](const auto&) {});
}

/// What is around the vertices that are no corners, vertex by vertex and then ascending.
struct AroundHosted {
  using Pairs = std::vector<std::array<int, 2>>;  // of the vertex and what is around it
  Pairs neighbours, edges, faces;
};

/// What surrounds the host of a vertex surrounds the vertex, too.
void add_host_neighbours(const Topology& topology, int v, AroundHosted& hosted) {
  std::vector<std::array<int, 2>> around;  // neighbour, edge to it (-1: none)
  std::vector<int> faces;
  const auto [kind, i] = topology.host(v);
  if (kind == FeatureKind::Vertex) {
    for (int e = 0; e < topology.edge_count(); ++e) {
      const auto [from, to] = topology.edge(e);
      if (from == i || to == i) around.push_back({from == i ? to : from, e});
    }
    for (int f = 0; f < topology.face_count(); ++f) {
      const std::span<const int> cycle = topology.face(f);
      if (std::ranges::find(cycle, i) != cycle.end()) faces.push_back(f);
    }
  } else if (kind == FeatureKind::Edge) {
    for (const int end : topology.edge(i)) around.push_back({end, i});
    faces.assign(topology.edge_faces(i).begin(), topology.edge_faces(i).end());
  } else {
    for (const int corner : topology.face(i)) around.push_back({corner, -1});
    faces.push_back(i);
  }
  std::sort(around.begin(), around.end());
  std::sort(faces.begin(), faces.end());
  for (const auto& [neighbour, e] : around) {
    hosted.neighbours.push_back({v, neighbour});
    if (e >= 0) hosted.edges.push_back({v, e});
  }
  for (const int f : faces) hosted.faces.push_back({v, f});
}

void check_coordinates(const Eigen::Ref<const Points>& vertices) {
  for (int v = 0; v < vertices.cols(); ++v) {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(vertices(k, v)) <= kLargestCoordinate) continue;
      throw InputError("vertex " + std::to_string(v) + " has a coordinate of " +
                       text(vertices(k, v)) + " m, limit " + text(kLargestCoordinate) + " m");
    }
  }
}

std::shared_ptr<const Topology> checked(std::shared_ptr<const Topology> topology) {
  if (!topology) throw InputError("shape: its topology is null");
  return topology;
}

[[noreturn]] void refuse_count(const Eigen::Ref<const Points>& vertices, const Topology& topology) {
  throw InputError(std::to_string(vertices.cols()) + " vertices for a topology of " +
                   std::to_string(topology.vertex_count()));
}

[[noreturn]] void refuse_extent(double extent) {
  throw InputError("the largest extent of the vertices is " + text(extent) + " m, limit " +
                   text(kSmallestExtent) + " m");
}

/// Sum of the cross products at the corners of a quadrilateral (right for long bricks), of the fan
/// from the first vertex otherwise. `size` is the sum of the lengths multiplied.
Vector3 summed_normal(const Points& vertices, std::span<const int> face, double& size) {
  Vector3 normal = Vector3::Zero();
  if (face.size() == 4) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3 p = vertices.col(face[k]);
      const Vector3 next = vertices.col(face[(k + 1) % 4]) - p;
      const Vector3 before = vertices.col(face[(k + 3) % 4]) - p;
      normal += next.cross(before);
      size += next.norm() * before.norm();
    }
    return normal;
  }
  const Vector3 first = vertices.col(face[0]);
  Vector3 side = vertices.col(face[1]) - first;
  for (std::size_t k = 2; k < face.size(); ++k) {
    const Vector3 next = vertices.col(face[k]) - first;
    normal += side.cross(next);
    size += side.norm() * next.norm();
    side = next;
  }
  return normal;
}

Vector3 unit_normal(const Points& vertices, std::span<const int> face) {
  constexpr double kSlim = 0.25;  // below it rounding costs more than two bits
  double size = 0.0;
  Vector3 normal = summed_normal(vertices, face, size);
  if (!(normal.norm() > kSlim * size)) normal = polygon_normal(vertices, face);
  const double length = normal.norm();
  return length > 0.0 ? Vector3(normal / length) : Vector3::Zero();
}

}  // namespace

Topology::Topology(int vertex_count, const std::vector<std::vector<int>>& faces,
                   const std::vector<HostedVertex>& hosted,
                   const std::vector<std::vector<int>>& surface)
    : vertex_count_(vertex_count) {
  if (vertex_count < 0 || faces.empty()) {
    throw InputError("topology: " + std::to_string(vertex_count) + " vertices and " +
                     std::to_string(faces.size()) + " faces make no closed surface");
  }
  check_polygons(vertex_count, faces, "face");
  if (!surface.empty() && surface != faces) check_surface(vertex_count, surface);
  std::size_t corners = 0;
  for (const std::vector<int>& face : faces) corners += face.size();
  face_vertices_.reserve(corners);
  face_start_.reserve(faces.size() + 1);
  face_start_.push_back(0);
  for (const std::vector<int>& face : faces) {
    face_vertices_.insert(face_vertices_.end(), face.begin(), face.end());
    face_start_.push_back(static_cast<int>(face_vertices_.size()));
  }
  triangles_.reserve(2 * index(vertex_count));
  for (const std::vector<int>& cell : surface.empty() ? faces : surface)
    for (std::size_t k = 2; k < cell.size(); ++k)
      triangles_.push_back({cell[0], cell[k - 1], cell[k]});
  add_edges(faces);
  add_hosts(hosted);
  add_neighbours();
  add_face_sets(surface);
  add_edge_table();
  find_brick();
}

void Topology::add_edges(const std::vector<std::vector<int>>& faces) {
  const std::vector<HalfEdge> halves = sorted_halves(vertex_count_, faces);
  face_edges_.assign(face_vertices_.size(), -1);
  face_neighbours_.assign(face_vertices_.size(), -1);
  edges_.reserve(halves.size() / 2);
  edge_faces_.reserve(halves.size() / 2);
  visit_edges(halves, "face", [&](std::span<const HalfEdge> of_edge) {
    for (const std::size_t k : {0u, 1u}) {
      face_edges_[index(of_edge[k].slot)] = edge_count();
      face_neighbours_[index(of_edge[k].slot)] = of_edge[1 - k].face;
    }
    edges_.push_back(of_edge[0].ends);
    edge_faces_.push_back({of_edge[0].face, of_edge[1].face});
  });
}

void Topology::add_hosts(const std::vector<HostedVertex>& hosted) {
  std::vector<char> placed(index(vertex_count_), 0);
  for (const int v : face_vertices_) placed[index(v)] = 1;
  const std::vector<char> corner = placed;
  if (!hosted.empty())
    for (int v = 0; v < vertex_count_; ++v) hosts_.push_back({FeatureKind::Vertex, v});
  for (const HostedVertex& at : hosted) {
    const auto [a, b] = std::minmax(at.corners[0], at.corners[1]);
    const auto edge = std::lower_bound(edges_.begin(), edges_.end(), std::array{a, b});
    const bool known = edge != edges_.end() && *edge == std::array{a, b};
    Feature host{FeatureKind::Face, at.face};
    if (b >= 0) host = {FeatureKind::Vertex, b};
    if (a >= 0) host = {FeatureKind::Edge, known ? static_cast<int>(edge - edges_.begin()) : -1};
    const int count = host.kind == FeatureKind::Face ? face_count() : vertex_count_;
    const bool good = at.vertex >= 0 && at.vertex < vertex_count_ && host.index >= 0 &&
                      (host.kind == FeatureKind::Edge || host.index < count) &&
                      (host.kind != FeatureKind::Vertex || corner[index(host.index)]);
    if (!good || placed[index(at.vertex)]) {
      throw InputError("vertex " + std::to_string(at.vertex) +
                       (good ? " is a corner or has two hosts" : " has no such host"));
    }
    placed[index(at.vertex)] = 1;
    hosts_[index(at.vertex)] = host;
  }
  const auto unused = std::find(placed.begin(), placed.end(), 0);
  if (unused != placed.end())
    throw InputError("vertex " + std::to_string(unused - placed.begin()) + " belongs to no face");
}

void Topology::add_neighbours() {
  AroundHosted hosted;
  for (int v = 0; v < vertex_count_ && !hosts_.empty(); ++v)
    if (!is_corner(v)) add_host_neighbours(*this, v, hosted);
  const auto visit_edges = [&](const auto& put) {  // vertex, edge, and which of its ends it is
    for (const std::size_t end : {1u, 0u})         // first all smaller neighbours come
      for (int e = 0; e < edge_count(); ++e) put(edge(e)[end], e, end);
  };
  const auto visit_neighbours = [&](const auto& put) {
    visit_edges([&](int v, int e, std::size_t end) { put(v, edge(e)[1 - end]); });
    for (const auto& [v, neighbour] : hosted.neighbours) put(v, neighbour);
  };
  const auto visit_vertex_edges = [&](const auto& put) {
    visit_edges([&](int v, int e, std::size_t) { put(v, e); });
    for (const auto& [v, e] : hosted.edges) put(v, e);
  };
  const auto visit_faces = [&](const auto& put) {
    for (int f = 0; f < face_count(); ++f) {
      for (const int v : face(f)) put(v, f);
    }
    for (const auto& [v, f] : hosted.faces) put(v, f);
  };
  fill_rows(vertex_count_, visit_neighbours, neighbour_start_, neighbours_);
  fill_rows(vertex_count_, visit_vertex_edges, neighbour_edge_start_, neighbour_edges_);
  fill_rows(vertex_count_, visit_faces, vertex_face_start_, vertex_faces_);
  three_faces_at_vertices_ = hosts_.empty();
  for (int v = 0; v < vertex_count_; ++v)
    three_faces_at_vertices_ = three_faces_at_vertices_ && vertex_faces(v).size() == 3;
}

void Topology::add_face_sets(const std::vector<std::vector<int>>& surface) {
  std::vector<char> below(index(vertex_count_), surface.empty() ? 0 : 1);
  for (const std::vector<int>& polygon : surface)
    for (const int v : polygon) below[index(v)] = 0;
  const auto visit = [&](const auto& put) {
    for (int v = 0; v < vertex_count_; ++v) {
      if (below[index(v)]) continue;
      for (const int f : vertex_faces(v)) put(f, v);
    }
  };
  fill_rows(face_count(), visit, face_set_start_, face_sets_);
}

void Topology::add_edge_table() {
  if (vertex_count_ > kFewVertices) return;
  std::vector<std::int16_t> table(index(vertex_count_) * index(vertex_count_), -1);
  const auto between = [&](int v, int w) -> std::int16_t& {
    return table[index(v * vertex_count_ + w)];
  };
  for (int e = 0; e < edge_count(); ++e) {
    const auto [v, w] = edge(e);
    between(v, w) = between(w, v) = static_cast<std::int16_t>(e);
  }
  for (int v = 0; v < vertex_count_ && !hosts_.empty(); ++v) {
    for (int w = 0; w < vertex_count_; ++w) {
      if (is_corner(v) && is_corner(w)) continue;
      between(v, w) = static_cast<std::int16_t>(search_edge(v, w));
    }
  }
  edge_between_ = std::move(table);
}

void Topology::find_brick() {
  bool quadrilaterals = vertex_count_ == 8 && face_count() == 6 && three_faces_at_vertices_;
  for (int f = 0; f < face_count(); ++f) quadrilaterals = quadrilaterals && face(f).size() == 4;
  if (!quadrilaterals) return;
  brick_.assign(8, 0);
  for (std::size_t k = 0; k < 3; ++k) brick_[std::size_t{1} << k] = neighbours(0)[k];
  const auto other_neighbour = [&](std::size_t i, std::size_t j, std::size_t known) {
    for (const int v : neighbours(brick_[i])) {
      const std::span<const int> row = neighbours(brick_[j]);
      const bool common = std::find(row.begin(), row.end(), v) != row.end();
      if (common && v != brick_[known]) return v;
    }
    return 0;
  };
  for (const std::size_t place : {3, 5, 6}) {  // two bits: beside the vertices with one of them
    const std::size_t low = place & (~place + 1);
    brick_[place] = other_neighbour(low, place ^ low, 0);
  }
  brick_[7] = other_neighbour(3, 5, 1);
}

int Topology::search_edge(int v, int w) const {
  const Feature at_v = host(v), at_w = host(w);
  if (at_v == at_w) return at_v.kind == FeatureKind::Edge ? at_v.index : -1;
  const bool along = at_v.kind == FeatureKind::Edge;  // else from the corner that v is, or is at
  if (!along && at_v.kind != FeatureKind::Vertex) return -1;
  if (at_w.kind == FeatureKind::Face || (along && at_w.kind == FeatureKind::Edge)) return -1;
  const int from = along ? v : at_v.index;
  const std::span<const int> row = neighbours(from), edges = vertex_edges(from);
  for (std::size_t k = 0; k < row.size(); ++k)  // a handful: quicker than to halve
    if (at_w.kind == FeatureKind::Edge ? edges[k] == at_w.index : row[k] == at_w.index)
      return edges[k];
  return -1;
}

std::vector<HostedVertex> Topology::hosted_vertices() const {
  std::vector<HostedVertex> list;
  for (int v = 0; v < vertex_count_; ++v) {
    if (is_corner(v)) continue;
    const auto [kind, place] = host(v);
    HostedVertex hosted{.vertex = v};
    if (kind == FeatureKind::Vertex) hosted.corners = {place, -1};
    if (kind == FeatureKind::Edge) hosted.corners = edge(place);
    if (kind == FeatureKind::Face) hosted.face = place;
    list.push_back(hosted);
  }
  return list;
}

namespace {

/// Does a polygon turn left at each of its corners, within rounding of a place?
bool turns_left(const Points& vertices, std::span<const int> face, const Vector3& normal,
                double diameter) {
  const std::size_t n = face.size();
  const double slack = kRounding * kEpsilon * diameter;
  Vector3 before = vertices.col(face[0]) - vertices.col(face[n - 1]);
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3 after = vertices.col(face[k + 1 < n ? k + 1 : 0]) - vertices.col(face[k]);
    const double turn = normal.dot(before.cross(after));
    if (turn < 0.0 && turn * turn > slack * slack * (before + after).squaredNorm()) return false;
    before = after;
  }
  return true;
}

/// No more than the least width of a convex polygon, m: its area over half of its border, which is
/// no shorter than any line between two of its places.
double width_bound(const Points& vertices, std::span<const int> face, const Vector3& normal) {
  double area = 0.0, border = 0.0;
  Vector3 from = vertices.col(face.back()) - vertices.col(face[0]);
  for (const int v : face) {
    const Vector3 to = vertices.col(v) - vertices.col(face[0]);
    area += 0.5 * normal.dot(from.cross(to));
    border += (to - from).norm();
    from = to;
  }
  return border > 0.0 ? 2.0 * area / border : 0.0;
}

/// How far a point lies beyond the sides of a face, as seen along its normal.
double beyond_sides(const Points& vertices, std::span<const int> face, const Vector3& normal,
                    const Vector3& point) {
  Vector3 from = vertices.col(face.back());
  double most = 0.0;
  for (const int v : face) {
    const Vector3 to = vertices.col(v), side = to - from;
    const double inside = normal.dot(side.cross(point - from));
    if (inside < 0.0) most = std::max(most, -inside / side.norm());
    from = to;
  }
  return most;
}

}  // namespace

Shape::Shape(std::shared_ptr<const Topology> topology, const Eigen::Ref<const Points>& vertices)
    : topology_(checked(std::move(topology))),
      vertices_(3, vertices.cols()),
      padded_count_(static_cast<int>((vertices.cols() + 7) / 8 * 8)),
      face_normals_(3, topology_->face_count()),
      label_fits_(static_cast<std::size_t>(topology_->face_count())) {
  offsets_.resize(3 * static_cast<std::size_t>(padded_count_));
  check_rounding_mode();
  set_vertices(vertices);
}

void Shape::set_vertices(const Eigen::Ref<const Points>& vertices) {
  if (vertices.cols() != topology_->vertex_count()) refuse_count(vertices, *topology_);
  // A sum shows what is not finite; least and greatest values would not.
  if (!std::isfinite(vertices.sum())) check_coordinates(vertices);
  const Box box{vertices.rowwise().minCoeff(), vertices.rowwise().maxCoeff()};
  const double largest = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  if (!(largest <= kLargestCoordinate)) check_coordinates(vertices);
  const double extent = (box.max - box.min).maxCoeff();
  if (!(extent >= kSmallestExtent)) refuse_extent(extent);
  vertices_ = vertices;
  box_ = box;
  largest_coordinate_ = largest;
  origin_ = 0.5 * box_.min + 0.5 * box_.max;
  double squared_radius = 0.0;
  Vector3 sum = Vector3::Zero();
  const std::size_t rows = static_cast<std::size_t>(padded_count_);
  for (std::size_t k = 0; k < rows; ++k) {
    const Eigen::Index v =
        static_cast<Eigen::Index>(k) < vertices_.cols() ? static_cast<Eigen::Index>(k) : 0;
    const Vector3 offset = vertices_.col(v) - origin_;
    offsets_[k] = offset.x();
    offsets_[rows + k] = offset.y();
    offsets_[2 * rows + k] = offset.z();
    squared_radius = std::max(squared_radius, offset.squaredNorm());
    if (static_cast<Eigen::Index>(k) < vertices_.cols()) sum += offset;
  }
  vertex_mean_ = origin_ + sum / static_cast<double>(vertices_.cols());
  diameter_ = 2.0 * std::sqrt(squared_radius);
  update_faces();
}

void Shape::update_faces() {
  for (int f = 0; f < topology_->face_count(); ++f) {
    const std::span<const int> face = topology_->face(f);
    const Vector3 normal = unit_normal(vertices_, face);
    face_normals_.col(f) = normal;
    LabelFit fit;
    if (face.size() > 3 && !turns_left(vertices_, face, normal, diameter_)) fit.outside = kInfinity;
    for (const int v : topology_->face_set(f)) {
      const Vector3 place = vertices_.col(v);
      fit.off_plane = std::max(fit.off_plane, std::abs(normal.dot(place - vertices_.col(face[0]))));
      if (topology_->is_corner(v)) continue;
      fit.outside = std::max(fit.outside, beyond_sides(vertices_, face, normal, place));
    }
    if (fit.outside < kInfinity) fit.width = width_bound(vertices_, face, normal);
    label_fits_[static_cast<std::size_t>(f)] = fit;
  }
  for (int f = 0; f < topology_->face_count(); ++f) {
    double& turn = label_fits_[static_cast<std::size_t>(f)].turn;
    for (const int v : topology_->face(f))
      for (const int g : topology_->vertex_faces(v))
        if (g != f) turn = std::max(turn, face_normals_.col(f).dot(face_normals_.col(g)));
  }
}

}  // namespace quoin::geometry
