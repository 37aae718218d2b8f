#include <quoin/geometry/polyhedron.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "numeric/double_double.hpp"

namespace quoin::geometry {
namespace {

struct HalfEdge {
  std::array<int, 2> ends;  // first < second
  int face;
  int slot;      // where its edge number belongs in face_edges
  bool forward;  // the face runs from ends[0] to ends[1]
};

void check_faces(int vertex_count, const std::vector<std::vector<int>>& faces) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::string name = "face " + std::to_string(f);
    if (faces[f].size() < 3) {
      throw InputError(name + " has " + std::to_string(faces[f].size()) +
                       " vertices, at least 3 needed");
    }
    for (const int v : faces[f]) {
      if (v < 0 || v >= vertex_count) {
        throw InputError(name + " names vertex " + std::to_string(v) + ", but there are " +
                         std::to_string(vertex_count) + " vertices");
      }
      if (std::count(faces[f].begin(), faces[f].end(), v) > 1) {
        throw InputError(name + " names vertex " + std::to_string(v) + " twice");
      }
    }
  }
}

std::string edge_name(const std::array<int, 2>& ends) {
  return "edge " + std::to_string(ends[0]) + "-" + std::to_string(ends[1]);
}

void check_twins(const HalfEdge* begin, const HalfEdge* end) {
  if (end - begin == 1) {
    throw InputError(edge_name(begin->ends) + " belongs to face " + std::to_string(begin->face) +
                     " only: the surface is open");
  }
  if (end - begin > 2) {
    throw InputError(edge_name(begin->ends) + " belongs to " + std::to_string(end - begin) +
                     " faces, 2 allowed");
  }
  if (begin->forward == begin[1].forward) {
    throw InputError(edge_name(begin->ends) + ": faces " + std::to_string(begin->face) + " and " +
                     std::to_string(begin[1].face) +
                     " run along it in the same direction (mixed orientation)");
  }
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

/// The same sum in double-double, for faces so slim that the products cancel.
Vector3 wide_normal(const Points& vertices, std::span<const int> face) {
  const Vector3 first = vertices.col(face[0]);
  WideVector normal;
  WideVector side = wide_difference(vertices.col(face[1]), first);
  for (std::size_t k = 2; k < face.size(); ++k) {
    const WideVector next = wide_difference(vertices.col(face[k]), first);
    normal = normal + cross(side, next);
    side = next;
  }
  return normal.rounded();
}

Vector3 unit_normal(const Points& vertices, std::span<const int> face) {
  constexpr double kSlim = 0.25;  // below it rounding costs more than two bits
  double size = 0.0;
  Vector3 normal = summed_normal(vertices, face, size);
  if (!(normal.norm() > kSlim * size)) normal = wide_normal(vertices, face);
  const double length = normal.norm();
  return length > 0.0 ? Vector3(normal / length) : Vector3::Zero();
}

}  // namespace

Topology::Topology(int vertex_count, const std::vector<std::vector<int>>& faces)
    : vertex_count_(vertex_count) {
  check_faces(vertex_count, faces);
  face_start_.push_back(0);
  for (const std::vector<int>& face : faces) {
    face_vertices_.insert(face_vertices_.end(), face.begin(), face.end());
    face_start_.push_back(static_cast<int>(face_vertices_.size()));
    face_sets_.insert(face_sets_.end(), face.begin(), face.end());
    std::sort(face_sets_.end() - std::ssize(face), face_sets_.end());
    face_four_start_.push_back(static_cast<int>(face_fours_.size() / 4));
    face_fours_.insert(face_fours_.end(), face.begin(), face.end());
    while (face_fours_.size() % 4 != 0) face_fours_.push_back(face[0]);
  }
  add_edges();
  add_neighbours();
  find_brick();
}

void Topology::add_edges() {
  std::vector<HalfEdge> halves;
  halves.reserve(face_vertices_.size());
  for (int f = 0; f < face_count(); ++f) {
    const std::span<const int> cycle = face(f);
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const int v = cycle[k], w = cycle[(k + 1) % cycle.size()];
      const int slot = face_start_[index(f)] + static_cast<int>(k);
      halves.push_back({{std::min(v, w), std::max(v, w)}, f, slot, v < w});
    }
  }
  std::sort(halves.begin(), halves.end(), [](const HalfEdge& p, const HalfEdge& q) {
    return std::pair(p.ends, !p.forward) < std::pair(q.ends, !q.forward);
  });
  face_edges_.assign(face_vertices_.size(), -1);
  face_neighbours_.assign(face_vertices_.size(), -1);
  for (std::size_t i = 0; i < halves.size();) {
    std::size_t j = i;
    while (j < halves.size() && halves[j].ends == halves[i].ends) ++j;
    check_twins(halves.data() + i, halves.data() + j);
    for (std::size_t k = i; k < j; ++k) {
      face_edges_[index(halves[k].slot)] = edge_count();
      face_neighbours_[index(halves[k].slot)] = halves[k == i ? i + 1 : i].face;
    }
    edges_.push_back(halves[i].ends);
    edge_faces_.push_back({halves[i].face, halves[i + 1].face});
    i = j;
  }
  if (vertex_count_ > kFewVertices) return;
  edge_between_.assign(index(vertex_count_ * vertex_count_), -1);
  for (int e = 0; e < edge_count(); ++e) {
    const auto [v, w] = edge(e);
    edge_between_[index(v * vertex_count_ + w)] = edge_between_[index(w * vertex_count_ + v)] =
        static_cast<std::int16_t>(e);
  }
}

void Topology::add_neighbours() {
  std::vector<std::vector<std::pair<int, int>>> around(index(vertex_count_));
  for (int e = 0; e < edge_count(); ++e) {
    around[index(edge(e)[0])].emplace_back(edge(e)[1], e);
    around[index(edge(e)[1])].emplace_back(edge(e)[0], e);
  }
  neighbour_start_.push_back(0);
  for (auto& row : around) {
    std::sort(row.begin(), row.end());
    for (const auto& [v, e] : row) {
      neighbours_.push_back(v);
      neighbour_edges_.push_back(e);
    }
    neighbour_start_.push_back(static_cast<int>(neighbours_.size()));
  }
  std::vector<std::vector<int>> faces_around(index(vertex_count_));
  for (int f = 0; f < face_count(); ++f) {
    for (const int v : face(f)) faces_around[index(v)].push_back(f);
  }
  vertex_face_start_.push_back(0);
  for (const std::vector<int>& row : faces_around) {
    three_faces_at_vertices_ = three_faces_at_vertices_ && row.size() == 3;
    vertex_faces_.insert(vertex_faces_.end(), row.begin(), row.end());
    vertex_face_start_.push_back(static_cast<int>(vertex_faces_.size()));
  }
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
  const std::span<const int> row = neighbours(v);
  for (std::size_t k = 0; k < row.size(); ++k) {  // a handful: quicker than to halve
    if (row[k] == w) return vertex_edges(v)[k];
  }
  return -1;
}

Polyhedron::Polyhedron(std::shared_ptr<const Topology> topology,
                       const Eigen::Ref<const Points>& vertices)
    : topology_(std::move(topology)),
      vertices_(3, vertices.cols()),
      face_normals_(3, topology_->face_count()),
      padded_count_(static_cast<int>((vertices.cols() + 7) / 8 * 8)) {
  offsets_.resize(3 * static_cast<std::size_t>(padded_count_));
  set_vertices(vertices);
}

void Polyhedron::set_vertices(const Eigen::Ref<const Points>& vertices) {
  vertices_ = vertices;
  box_.min = vertices_.rowwise().minCoeff();
  box_.max = vertices_.rowwise().maxCoeff();
  origin_ = 0.5 * box_.min + 0.5 * box_.max;
  largest_coordinate_ = std::max(box_.min.cwiseAbs().maxCoeff(), box_.max.cwiseAbs().maxCoeff());
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
  update_face_normals();
}

void Polyhedron::update_face_normals() {
  for (int f = 0; f < topology_->face_count(); ++f) {
    face_normals_.col(f) = unit_normal(vertices_, topology_->face(f));
  }
}

}  // namespace quoin::geometry
