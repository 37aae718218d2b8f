#include "shape/face_labels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "numeric/double_double.hpp"
#include "numeric/numbers.hpp"
#include "numeric/plane.hpp"
#include "shape/cell_groups.hpp"
#include "shape/convex_hull.hpp"
#include "shape/polygon_area.hpp"

namespace quoin::geometry {
namespace {

Vector3 unit_or_zero(const Vector3& normal) {
  const double length = normal.norm();
  return length > 0.0 ? Vector3(normal / length) : Vector3::Zero();
}

Vector3 unit_normal(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon) {
  return unit_or_zero(polygon_normal(vertices, polygon));
}

double distance_to_segment(const Vector3& a, const Vector3& b, const Vector3& x) {
  const Vector3 side = b - a;
  const double squared = side.squaredNorm();
  const double share = squared > 0.0 ? std::clamp(side.dot(x - a) / squared, 0.0, 1.0) : 0.0;
  return (x - a - share * side).norm();
}

/// How far inside a polygon a point lies, seen along its normal; negative: outside.
double inside(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon,
              const Vector3& x) {
  const Vector3 normal = unit_normal(vertices, polygon);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector3 a = vertices.col(polygon[k]);
    const Vector3 side = vertices.col(polygon[(k + 1) % polygon.size()]) - a;
    const double length = side.norm();
    if (length > 0.0) least = std::min(least, normal.dot(side.cross(x - a)) / length);
  }
  return least;
}

// ---- convex within a length ----

/// Does every place lie within `length` of the border of the hull of all?
bool convex_within(const std::vector<Vector2>& places, double length) {
  SmallVector<int, 32> order;
  hull_order(places, order);
  return std::all_of(places.begin(), places.end(), [&](const Vector2& place) {
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Vector2 &a = places[at(order[k])], &b = places[at(order[(k + 1) % order.size()])];
      if (cross2(b - a, place - a) <= length * (b - a).norm()) return true;
    }
    return false;
  });
}

std::vector<Vector2> laid_flat(const Eigen::Ref<const Points>& vertices, std::span<const int> loop,
                               const Vector3& normal) {
  const ContactPlane plane(vertices.col(loop[0]), normal);
  std::vector<Vector2> places;
  places.reserve(loop.size());
  for (const int i : loop) places.push_back(plane.place(vertices.col(i)));
  return places;
}

// ---- an order of the cells that hangs on the solid alone ----

/// Square of a cell's area to about 80 bits: what is left of it whatever vertex the sum began at.
struct AreaKey {
  double high = 0.0, low = 0.0;
  auto operator<=>(const AreaKey&) const = default;
};

AreaKey area_key(const WideVector& area) {
  const DoubleDouble squared = dot(area, area);
  if (!(squared.high > 0.0)) return {};
  const double step = std::ldexp(1.0, std::ilogb(squared.high) - 80);
  return {squared.high, std::nearbyint(squared.low / step) * step};
}

/// Twice the vector areas of the cells: rough ones, and to double-double where they are asked for.
class CellAreas {
 public:
  CellAreas(const Eigen::Ref<const Points>& vertices, const CellSurface& surface)
      : vertices_(vertices), surface_(surface), wide_(at(surface.cell_count())) {
    rough_.reserve(wide_.size());
    for (int c = 0; c < surface.cell_count(); ++c)
      rough_.push_back(rough_area(vertices, surface.cell(c)));
  }

  const RoughArea& rough(int cell) const { return rough_[at(cell)]; }
  const WideVector& wide(int cell) {
    std::optional<WideVector>& area = wide_[at(cell)];
    if (!area) area = wide_area(vertices_, surface_.cell(cell));
    return *area;
  }
  /// Is a cell larger than another one, beyond what plain doubles leave open?
  bool surely_larger(int cell, int other) const {
    return rough(cell).norm - rough(cell).error > rough(other).norm + rough(other).error;
  }

 private:
  Eigen::Ref<const Points> vertices_;
  const CellSurface& surface_;
  std::vector<RoughArea> rough_;
  std::vector<std::optional<WideVector>> wide_;
};

/// The vertices' places in the order of their coordinates.
std::vector<int> coordinate_ranks(const Eigen::Ref<const Points>& vertices) {
  std::vector<int> order(at(static_cast<int>(vertices.cols()))), rank(order.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    const Vector3 p = vertices.col(i), q = vertices.col(j);
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  });
  for (std::size_t k = 0; k < order.size(); ++k) rank[at(order[k])] = static_cast<int>(k);
  return rank;
}

/// The cells, largest first; of equal ones (mirror images) the one whose vertices come first by
/// their coordinates.
std::vector<int> by_area(const Eigen::Ref<const Points>& vertices, const CellSurface& surface,
                         CellAreas& areas) {
  const std::vector<int> rank = coordinate_ranks(vertices);
  IndexRows ranks = surface.cells();
  for (int& v : ranks.values) v = rank[at(v)];
  for (int c = 0; c < ranks.size(); ++c) std::ranges::sort(ranks[c]);
  std::vector<int> order(at(surface.cell_count()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    if (areas.surely_larger(i, j)) return true;
    if (areas.surely_larger(j, i)) return false;
    const AreaKey p = area_key(areas.wide(i)), q = area_key(areas.wide(j));
    return p != q ? p > q : std::ranges::lexicographical_compare(ranks[i], ranks[j]);
  });
  return order;
}

// ---- faces of groups of cells ----

/// The corners on a loop.
void find_polygon(Loop loop, const std::vector<char>& corner, std::vector<int>& polygon) {
  polygon.clear();
  polygon.reserve(loop.size());
  for (const BorderSide& side : loop)
    if (corner[at(side.from)]) polygon.push_back(side.from);
}

/// Is every side of a face a side of just one other, run through the other way?
bool is_closed(int vertex_count, const Faces& faces) {
  // By its smaller end: twice the other, and one more where it runs from that.
  IndexRows sides = rows_by(vertex_count, [&](const auto& put) {
    for (const std::vector<int>& face : faces) {
      int v = face.back();
      for (const int w : face) {
        put(std::min(v, w), 2 * std::max(v, w) + (v < w ? 0 : 1));
        v = w;
      }
    }
  });
  for (int v = 0; v < vertex_count; ++v) {
    const std::span<int> row = sides[v];
    std::ranges::sort(row);
    if (row.size() % 2 != 0 || std::ranges::adjacent_find(row) != row.end()) return false;
    for (std::size_t k = 0; k < row.size(); k += 2)
      if (row[k] / 2 != row[k + 1] / 2) return false;
  }
  return true;
}

/// The mean of the vertices: the same bits in any order.
Vector3 mean(const Eigen::Ref<const Points>& vertices) {
  WideVector sum;
  for (int v = 0; v < vertices.cols(); ++v) sum = sum + wide(vertices.col(v));
  return (sum * (DoubleDouble(1.0) / static_cast<double>(vertices.cols()))).rounded();
}

/// Which of two vertices is farther from the middle: a choice that mirrors keep.
bool farther(const Vector3& p, const Vector3& q, const Vector3& middle) {
  const WideVector sum = wide_difference(p, middle) + wide_difference(q, middle);
  const double more = dot(wide_difference(p, q), sum).high;
  return more != 0.0 ? more > 0.0
                     : std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
}

/// The labels of the cells at one length.
class Labelling {
 public:
  Labelling(const Eigen::Ref<const Points>& vertices, const Faces& cells, double stated)
      : vertices_(vertices),
        stated_(stated),
        groups_(static_cast<int>(vertices.cols()), rows_of(cells)),
        areas_(vertices, groups_.surface()),
        order_(by_area(vertices, groups_.surface(), areas_)),
        rank_(cells.size()),
        member_(cells.size(), -1) {
    for (std::size_t k = 0; k < order_.size(); ++k) rank_[at(order_[k])] = static_cast<int>(k);
  }

  bool run(double length, FaceLabels& labels) {
    length_ = length;
    grow_groups();
    do {
      if (!groups_.find_loops()) return false;
      find_corners();
    } while (join_slivers());
    if (!name_faces(labels.faces) || !join_corners(labels.faces)) return false;
    find_hosts(labels);
    return true;
  }

 private:
  // Groups are named by the rank of the cell that they began with: smaller ones have greater names.

  void grow_groups() {
    for (int cell = 0; cell < groups_.size(); ++cell) groups_.put(cell, -1);
    std::fill(member_.begin(), member_.end(), -1);
    for (const int seed : order_) {
      if (groups_.group(seed) >= 0) continue;
      if (length_ == 0.0 || !is_wider(vertices_, cell(seed), length_) || !grow(seed))
        members_.assign(1, seed);
      for (const int cell : members_) groups_.put(cell, rank_[at(seed)]);
    }
  }

  std::span<const int> cell(int c) const { return groups_.surface().cell(c); }

  /// The largest convex union of cells around a seed that the length allows: the members; false:
  /// there is none but the seed.
  bool grow(int seed) {
    constexpr int kTrials = 13;  // from 1e-9 of the diameter down to its rounding
    if (!may_grow(seed)) return false;
    const Vector3 normal = unit_or_zero(areas_.wide(seed).rounded());
    double reach = length_;
    for (int trial = 0; trial < kTrials; ++trial, reach /= 4) {
      find_cap(seed, normal, cell(seed), reach);
      if (members_.size() == 1) return false;
      std::vector<int> loop = border();
      for (int fit = 0; fit < 3 && !loop.empty(); ++fit) {  // the seed may be slim
        const std::vector<int> fewer = members_;
        find_cap(seed, unit_normal(vertices_, loop), loop, reach);
        if (members_.size() <= fewer.size()) {
          members_ = fewer;
          break;
        }
        loop = border();
      }
      if (is_polygon(members_, loop)) return true;
    }
    return false;
  }

  /// May a free neighbour of a seed lie within the length below its plane?
  bool may_grow(int seed) const {
    const Vector3 base = vertices_.col(cell(seed)[0]);
    return std::ranges::any_of(groups_.surface().neighbours(seed), [&](int next) {
      return groups_.group(next) < 0 && std::ranges::none_of(cell(next), [&](int v) {
               return areas_.rough(seed).surely_exceeds(base - vertices_.col(v), length_);
             });
    });
  }

  /// The cells around a seed all of whose vertices lie within `reach` below the plane that touches
  /// `rim`: the members. The part of a convex surface that a plane cuts off is a disk.
  void find_cap(int seed, const Vector3& normal, std::span<const int> rim, double reach) {
    const Vector3 base = vertices_.col(cell(seed)[0]);
    double level = -std::numeric_limits<double>::infinity();
    for (const int v : rim) level = std::max(level, normal.dot(vertices_.col(v) - base));
    const auto flat = [&](int c) {
      return std::ranges::all_of(cell(c), [&](int v) {
        const double height = normal.dot(vertices_.col(v) - base) - level;
        return height >= -reach && height <= reach;
      });
    };
    members_.assign(1, seed);
    const int mark = ++marks_;
    member_[at(seed)] = mark;
    for (std::size_t k = 0; k < members_.size(); ++k) {
      for (const int next : groups_.surface().neighbours(members_[k])) {
        if (member_[at(next)] == mark || groups_.group(next) >= 0 || !flat(next)) continue;
        member_[at(next)] = mark;
        members_.push_back(next);
      }
    }
  }

  /// Of the cap found last: its vertices in order; empty where it is no single simple loop.
  std::vector<int> border() {
    std::vector<BorderSide> sides, loop;
    sides.reserve(3 * members_.size());
    for (const int c : members_) {
      const std::span<const int> cycle = cell(c), across = groups_.surface().neighbours(c);
      for (std::size_t k = 0; k < cycle.size(); ++k) {
        if (member_[at(across[k])] == marks_) continue;
        sides.push_back({cycle[k], cycle[(k + 1) % cycle.size()], 0});
      }
    }
    std::vector<int> vertices;
    loop.reserve(sides.size());
    if (!groups_.joiner().append(sides, loop)) return vertices;
    vertices.reserve(loop.size());
    for (const BorderSide& side : loop) vertices.push_back(side.from);
    return vertices;
  }

  bool is_polygon(std::span<const int> members, std::span<const int> loop) const {
    if (loop.size() < 3) return false;
    const Vector3 normal = unit_normal(vertices_, loop);
    return spread(members, normal) <= length_ &&
           convex_within(laid_flat(vertices_, loop, normal), length_);
  }

  /// Between the lowest and the highest vertex along a normal.
  double spread(std::span<const int> members, const Vector3& normal) const {
    const Vector3 base = vertices_.col(cell(members[0])[0]);
    double low = 0.0, high = 0.0;
    for (const int c : members) {
      for (const int v : cell(c)) {
        const double height = normal.dot(vertices_.col(v) - base);
        low = std::min(low, height);
        high = std::max(high, height);
      }
    }
    return high - low;
  }

  void find_corners() {
    const std::vector<int> visits = groups_.visits();
    corner_.assign(visits.size(), 0);
    for (std::size_t v = 0; v < visits.size(); ++v) corner_[v] = visits[v] >= 3;
    if (std::ranges::all_of(visits, [](int loops) { return loops >= 3 || loops == 0; })) return;
    const std::vector<char> met = corner_;
    for (int g = 0; g < groups_.size(); ++g) {
      std::vector<int> round;
      for (const BorderSide& side : groups_.loop(g)) round.push_back(side.from);
      const auto first = std::ranges::find_if(round, [&](int v) { return met[at(v)]; });
      if (first == round.end()) continue;
      std::rotate(round.begin(), first, round.end());
      round.push_back(round[0]);
      std::size_t from = 0;
      for (std::size_t k = 1; k < round.size(); ++k) {
        if (!met[at(round[k])]) continue;
        keep_kinks(std::span(round).subspan(from, k - from + 1));
        from = k;
      }
    }
  }

  /// A border between two faces is straight within the stated length or has corners of its own.
  void keep_kinks(std::span<const int> chain) {
    const Vector3 a = vertices_.col(chain.front()), b = vertices_.col(chain.back());
    std::size_t far = 0;
    double farthest = stated_;
    for (std::size_t k = 1; k + 1 < chain.size(); ++k) {
      const double off = distance_to_segment(a, b, vertices_.col(chain[k]));
      if (off <= farthest) continue;
      far = k;
      farthest = off;
    }
    if (far == 0) return;
    corner_[at(chain[far])] = 1;
    keep_kinks(chain.first(far + 1));
    keep_kinks(chain.subspan(far));
  }

  /// Groups with fewer than three corners, or too narrow, join a neighbour, smallest first; false:
  /// there are none.
  bool join_slivers() {
    bool any = false;
    std::vector<char> touched(rank_.size(), 0);
    std::vector<int> polygon;
    for (int g = groups_.size() - 1; g >= 0; --g) {
      const Loop loop = groups_.loop(g);
      if (loop.empty() || touched[at(g)]) continue;
      find_polygon(loop, corner_, polygon);
      if (polygon.size() >= 3 && is_wider(vertices_, polygon, length_)) continue;
      if (polygon.size() >= 3 && length_ == 0.0) continue;
      const int into = main_neighbour(loop);
      if (touched[at(into)]) continue;
      touched[at(g)] = touched[at(into)] = 1;
      groups_.rename(g, into);
      any = true;
    }
    return any;
  }

  /// The group beyond most of a border.
  int main_neighbour(Loop loop) const {
    std::vector<std::pair<int, double>> shared;
    for (const BorderSide& side : loop)
      shared.emplace_back(side.beyond, (vertices_.col(side.to) - vertices_.col(side.from)).norm());
    std::sort(shared.begin(), shared.end());
    int best = shared[0].first;
    double longest = -1.0, sum = 0.0;
    for (std::size_t k = 0; k < shared.size(); ++k) {
      sum = k > 0 && shared[k].first == shared[k - 1].first ? sum + shared[k].second
                                                            : shared[k].second;
      if (sum <= longest) continue;
      longest = sum;
      best = shared[k].first;
    }
    return best;
  }

  /// In the order of their first cells; false: they make no closed surface, or are not flat.
  bool name_faces(Faces& faces) {
    faces.clear();
    faces.reserve(rank_.size());
    face_of_.assign(rank_.size(), -1);
    const IndexRows members = rows_by(groups_.size(), [&](const auto& put) {
      for (int c = 0; c < groups_.size(); ++c) put(groups_.group(c), c);
    });
    for (int c = 0; c < groups_.size(); ++c) {
      const int g = groups_.group(c);
      if (face_of_[at(g)] >= 0) continue;
      face_of_[at(g)] = static_cast<int>(faces.size());
      std::vector<int>& polygon = faces.emplace_back();
      find_polygon(groups_.loop(g), corner_, polygon);
      if (polygon.size() < 3 || (length_ > 0.0 && !is_flat(members[g], polygon))) return false;
    }
    return faces.size() >= 4 && is_closed(groups_.surface().vertex_count(), faces);
  }

  /// Has a face a normal, along which its cells lie within the stated length of a middle plane?
  bool is_flat(std::span<const int> members, std::span<const int> polygon) const {
    if (members.size() == 1) {
      const RoughArea rough = rough_area(vertices_, polygon);
      if (rough.norm > 2.0 * rough.error) return true;
    }
    const Vector3 normal = unit_normal(vertices_, polygon);
    return normal.norm() > 0.5 && (members.size() == 1 || spread(members, normal) <= 2 * stated_);
  }

  /// Corners joined by an edge no longer than the length become one, and of all vertices beside a
  /// corner the farthest out is it, whichever of them the groups met in; false: a face is lost.
  bool join_corners(Faces& faces) {
    std::vector<int> name(corner_.size(), -1);  // of the cluster
    for (std::size_t v = 0; v < name.size(); ++v)
      name[v] = corner_[v] ? static_cast<int>(v) : nearest_corner(static_cast<int>(v), faces);
    const auto join = [&](int v, int w) { std::replace(name.begin(), name.end(), v, w); };
    for (const std::vector<int>& face : faces) {
      for (std::size_t k = 0; k < face.size(); ++k) {
        const int v = face[k], w = face[(k + 1) % face.size()];
        const bool near = (vertices_.col(v) - vertices_.col(w)).norm() <= length_;
        if (near && name[at(v)] != name[at(w)]) join(name[at(v)], name[at(w)]);
      }
    }
    std::vector<int> out(name.size(), -1);  // by cluster
    const Vector3 middle = mean(vertices_);
    for (int v = 0; v < vertices_.cols(); ++v) {
      if (name[at(v)] < 0) continue;
      int& best = out[at(name[at(v)])];
      if (best < 0 || farther(vertices_.col(v), vertices_.col(best), middle)) best = v;
    }
    std::fill(corner_.begin(), corner_.end(), 0);
    bool moved = false;
    for (std::vector<int>& face : faces) {
      for (int& v : face) {
        const int corner = out[at(name[at(v)])];
        moved = moved || corner != v;
        v = corner;
      }
      face.erase(std::unique(face.begin(), face.end()), face.end());
      if (face.front() == face.back()) face.pop_back();
      if (face.size() < 3) return false;
      std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
      for (const int v : face) corner_[at(v)] = 1;
    }
    return !moved || is_closed(groups_.surface().vertex_count(), faces);
  }

  int face_beside(int side) const {
    return face_of_[at(groups_.group(groups_.surface().cell_of(side)))];
  }

  /// Of the faces around a vertex, within the stated length; -1: none.
  int nearest_corner(int v, const Faces& faces) const {
    int best = -1;
    double nearest = stated_;
    for (const int side : groups_.surface().sides_from(v)) {
      for (const int c : faces[at(face_beside(side))]) {
        const double distance = (vertices_.col(c) - vertices_.col(v)).norm();
        if (distance > nearest) continue;
        nearest = distance;
        best = c;
      }
    }
    return best;
  }

  void find_hosts(FaceLabels& labels) const {
    labels.hosted.clear();
    std::vector<Vector3> normals;
    for (int v = 0; v < vertices_.cols(); ++v) {
      if (corner_[at(v)]) continue;
      const bool below = groups_.surface().sides_from(v).empty();
      if (below && normals.empty())
        for (const auto& face : labels.faces) normals.push_back(unit_normal(vertices_, face));
      labels.hosted.push_back(below ? host_above(v, labels.faces, normals)
                                    : host_of(v, labels.faces));
    }
  }

  /// Of a vertex below the cells: in the face least high above it, or at its corner or edge no
  /// farther than twice as high.
  HostedVertex host_above(int v, const Faces& faces, const std::vector<Vector3>& normals) const {
    const Vector3 x = vertices_.col(v);
    double depth = std::numeric_limits<double>::infinity();
    HostedVertex host{v};
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const double below = normals[f].dot(vertices_.col(faces[f][0]) - x);
      if (below >= depth) continue;
      depth = below;
      host.face = static_cast<int>(f);
    }
    const std::vector<int>& face = faces[at(host.face)];
    const double reach = std::max(stated_, 2 * depth);
    double to_corner = reach, to_edge = reach;
    HostedVertex by_corner{v}, by_edge{v};
    for (std::size_t k = 0; k < face.size(); ++k) {
      const int a = face[k], b = face[(k + 1) % face.size()];
      const double off_corner = (vertices_.col(a) - x).norm();
      const double off_edge = distance_to_segment(vertices_.col(a), vertices_.col(b), x);
      if (off_corner <= to_corner) by_corner.corners[0] = a;
      if (off_edge <= to_edge) by_edge.corners = {a, b};
      to_corner = std::min(to_corner, off_corner);
      to_edge = std::min(to_edge, off_edge);
    }
    if (by_corner.corners[0] >= 0) return by_corner;
    return by_edge.corners[0] >= 0 ? by_edge : host;
  }

  /// The nearest corner within the stated length, or else edge, or else the face around a vertex.
  HostedVertex host_of(int v, const Faces& faces) const {
    const Vector3 x = vertices_.col(v);
    if (const int corner = nearest_corner(v, faces); corner >= 0) return {v, {corner, -1}};
    HostedVertex by_edge{v}, by_face{v};
    double nearest = stated_, most = -std::numeric_limits<double>::infinity();
    for (const int side : groups_.surface().sides_from(v)) {
      const int f = face_beside(side);
      const std::vector<int>& face = faces[at(f)];
      for (std::size_t k = 0; k < face.size(); ++k) {
        const int a = face[k], b = face[(k + 1) % face.size()];
        const double off = distance_to_segment(vertices_.col(a), vertices_.col(b), x);
        if (off > nearest) continue;
        nearest = off;
        by_edge.corners = {a, b};
      }
      const double margin = inside(vertices_, face, x);
      if (margin > most || by_face.face < 0) by_face.face = f;
      most = std::max(most, margin);
    }
    return by_edge.corners[0] >= 0 ? by_edge : by_face;
  }

  Eigen::Ref<const Points> vertices_;
  double stated_, length_ = 0.0;
  CellGroups groups_;
  CellAreas areas_;
  std::vector<int> order_, rank_;
  std::vector<int> members_;  // of the cap found last
  std::vector<int> member_;   // the mark of the search that found a cell last
  int marks_ = 0;
  std::vector<char> corner_;
  std::vector<int> face_of_;  // by group
};

/// The vertex of a triangle that another one does not share with it.
int vertex_beside(std::span<const int> triangle, std::span<const int> other) {
  return *std::ranges::find_if(triangle,
                               [&](int v) { return std::ranges::find(other, v) == other.end(); });
}

/// Groups of exactly coplanar triangles, each named by the first of them.
void join_coplanar(const Eigen::Ref<const Points>& vertices, CellGroups& groups) {
  std::vector<int> stack;
  for (int seed = 0; seed < groups.size(); ++seed) {
    if (groups.group(seed) >= 0) continue;
    groups.put(seed, seed);
    const std::span<const int> plane = groups.surface().cell(seed);
    const auto in_plane = [&](int v) {
      return orientation(vertices.col(plane[0]), vertices.col(plane[1]), vertices.col(plane[2]),
                         vertices.col(v)) == 0;
    };
    stack.assign(1, seed);
    while (!stack.empty()) {
      const int cell = stack.back();
      stack.pop_back();
      for (const int next : groups.surface().neighbours(cell)) {
        if (groups.group(next) >= 0 ||
            !in_plane(vertex_beside(groups.surface().cell(next), groups.surface().cell(cell))))
          continue;
        groups.put(next, seed);
        stack.push_back(next);
      }
    }
  }
}

}  // namespace

Faces exact_facets(const Eigen::Ref<const Points>& vertices,
                   std::span<const std::array<int, 3>> triangles) {
  CellGroups groups(static_cast<int>(vertices.cols()), rows_of(triangles));
  join_coplanar(vertices, groups);
  Faces facets;
  if (!groups.find_loops()) {  // cannot be: an exact facet is a convex polygon
    for (const std::array<int, 3>& t : triangles) facets.push_back({t[0], t[1], t[2]});
    return facets;
  }
  const std::vector<int> visits = groups.visits();
  std::vector<char> corner(visits.size());
  for (std::size_t v = 0; v < visits.size(); ++v) corner[v] = visits[v] >= 3;
  facets.reserve(triangles.size());
  for (int g = 0; g < groups.size(); ++g)
    if (!groups.loop(g).empty()) find_polygon(groups.loop(g), corner, facets.emplace_back());
  std::sort(facets.begin(), facets.end());
  return facets;
}

FaceLabels label_faces(const Eigen::Ref<const Points>& vertices, const Faces& cells,
                       double length) {
  constexpr int kTrials = 7;  // from 1e-9 of the diameter to less than its rounding
  Labelling labelling(vertices, cells, length);
  FaceLabels labels;
  double shorter = length;
  for (int trial = 0; trial < kTrials; ++trial, shorter /= 16)
    if (labelling.run(shorter, labels)) return labels;
  if (!labelling.run(0.0, labels))
    throw InputError("the faces make no closed surface of polygons with three corners each");
  return labels;
}

}  // namespace quoin::geometry
