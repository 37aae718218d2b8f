#include "shape/face_labels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "numeric/double_double.hpp"
#include "shape/convex_hull.hpp"

namespace quoin::geometry {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

WideVector wide_area(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon) {
  const Vector3 first = vertices.col(polygon[0]);
  WideVector area;
  WideVector side = wide_difference(vertices.col(polygon[1]), first);
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const WideVector next = wide_difference(vertices.col(polygon[k]), first);
    area = area + cross(side, next);
    side = next;
  }
  return area;
}

Vector3 unit_normal(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon) {
  const Vector3 normal = polygon_normal(vertices, polygon);
  const double length = normal.norm();
  return length > 0.0 ? Vector3(normal / length) : Vector3::Zero();
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

using Vector2 = Eigen::Vector2d;

double turn(const Vector2& a, const Vector2& b, const Vector2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Hull of places in the plane, counter-clockwise. Source: [Andrew 1979].
std::vector<Vector2> planar_hull(std::vector<Vector2> places) {
  std::sort(places.begin(), places.end(), [](const Vector2& p, const Vector2& q) {
    return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y();
  });
  std::vector<Vector2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const Vector2& place : places) {
      while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), place) <= 0.0) {
        hull.pop_back();
      }
      hull.push_back(place);
    }
    hull.pop_back();
    std::reverse(places.begin(), places.end());
  }
  return hull;
}

/// Does every place lie within `length` of the border of the hull of all?
bool convex_within(const std::vector<Vector2>& places, double length) {
  const std::vector<Vector2> hull = planar_hull(places);
  return std::all_of(places.begin(), places.end(), [&](const Vector2& place) {
    for (std::size_t k = 0; k < hull.size(); ++k) {
      const Vector2 &a = hull[k], &b = hull[(k + 1) % hull.size()];
      if (turn(a, b, place) <= length * (b - a).norm()) return true;
    }
    return false;
  });
}

std::vector<Vector2> laid_flat(const Eigen::Ref<const Points>& vertices, std::span<const int> loop,
                               const Vector3& normal) {
  int k = 0;
  normal.cwiseAbs().minCoeff(&k);
  const Vector3 u = normal.cross(Vector3::Unit(k)).normalized(), v = normal.cross(u);
  std::vector<Vector2> places;
  for (const int i : loop) {
    const Vector3 x = vertices.col(i) - vertices.col(loop[0]);
    places.emplace_back(u.dot(x), v.dot(x));
  }
  return places;
}

// ---- an order of the cells that hangs on the solid alone ----

/// Square of a cell's area to about 80 bits: what is left of it whatever vertex the sum began at.
struct AreaKey {
  double high = 0.0, low = 0.0;
  auto operator<=>(const AreaKey&) const = default;
};

AreaKey area_key(const Eigen::Ref<const Points>& vertices, const std::vector<int>& cell) {
  const WideVector area = wide_area(vertices, cell);
  const DoubleDouble squared = dot(area, area);
  if (!(squared.high > 0.0)) return {};
  const double step = std::ldexp(1.0, std::ilogb(squared.high) - 80);
  return {squared.high, std::nearbyint(squared.low / step) * step};
}

/// The cells, largest first; of equal ones (mirror images) the one whose vertices come first by
/// their coordinates.
std::vector<int> by_area(const Eigen::Ref<const Points>& vertices, const Faces& cells) {
  std::vector<int> places(at(static_cast<int>(vertices.cols()))), rank(places.size());
  std::iota(places.begin(), places.end(), 0);
  std::sort(places.begin(), places.end(), [&](int i, int j) {
    return std::lexicographical_compare(vertices.col(i).begin(), vertices.col(i).end(),
                                        vertices.col(j).begin(), vertices.col(j).end());
  });
  for (std::size_t k = 0; k < places.size(); ++k) rank[at(places[k])] = static_cast<int>(k);
  std::vector<std::pair<AreaKey, std::vector<int>>> keys;
  for (const std::vector<int>& cell : cells) {
    std::vector<int> ranks;
    for (const int v : cell) ranks.push_back(rank[at(v)]);
    std::sort(ranks.begin(), ranks.end());
    keys.emplace_back(area_key(vertices, cell), std::move(ranks));
  }
  std::vector<int> order(cells.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    const auto &p = keys[at(i)], &q = keys[at(j)];
    return p.first != q.first ? p.first > q.first : p.second < q.second;
  });
  return order;
}

// ---- groups of cells ----

/// Border of a group: its vertices in order, and the group beyond the side from each to the next.
struct Loop {
  std::vector<int> vertices, beyond;
};

struct BorderSide {
  int from, to, beyond;
};

/// One closed loop through all sides; empty where there is none.
Loop joined(std::vector<BorderSide>& sides) {
  Loop loop;
  std::sort(sides.begin(), sides.end(),
            [](const BorderSide& s, const BorderSide& t) { return s.from < t.from; });
  if (sides.size() < 2) return loop;
  loop.vertices.reserve(sides.size());
  loop.beyond.reserve(sides.size());
  int v = sides[0].from;
  do {
    const auto side = std::lower_bound(sides.begin(), sides.end(), v,
                                       [](const BorderSide& s, int w) { return s.from < w; });
    if (side == sides.end() || side->from != v) return {};
    loop.vertices.push_back(v);
    loop.beyond.push_back(side->beyond);
    v = side->to;
  } while (v != sides[0].from && loop.vertices.size() <= sides.size());
  if (loop.vertices.size() != sides.size()) return {};  // holes, or a border that touches itself
  return loop;
}

/// Cells of a closed surface gathered into groups.
class CellGroups {
 public:
  CellGroups(int vertex_count, const Faces& cells)
      : cells_(cells), surface_(vertex_count, cells), group_(cells.size(), -1) {}

  const Topology& surface() const { return surface_; }
  int group(int cell) const { return group_[at(cell)]; }
  void put(int cell, int group) { group_[at(cell)] = group; }
  void rename(int from, int to) { std::replace(group_.begin(), group_.end(), from, to); }
  const Loop& loop(int group) const { return loops_[at(group)]; }
  int size() const { return static_cast<int>(cells_.size()); }

  /// The border of every group; false where one is no single simple loop.
  bool find_loops() {
    std::vector<std::vector<BorderSide>> sides(cells_.size());
    std::vector<char> used(cells_.size(), 0);
    for (int cell = 0; cell < size(); ++cell) {
      used[at(group(cell))] = 1;
      const std::vector<int>& cycle = cells_[at(cell)];
      for (std::size_t k = 0; k < cycle.size(); ++k) {
        const int beyond = group(surface_.face_neighbours(cell)[k]);
        if (beyond == group(cell)) continue;
        sides[at(group(cell))].push_back({cycle[k], cycle[(k + 1) % cycle.size()], beyond});
      }
    }
    loops_.assign(cells_.size(), {});
    for (std::size_t g = 0; g < sides.size(); ++g) {
      if (!used[g]) continue;
      loops_[g] = joined(sides[g]);
      if (loops_[g].vertices.empty()) return false;
    }
    return true;
  }

  /// How many loops pass through each vertex.
  std::vector<int> visits() const {
    std::vector<int> count(at(surface_.vertex_count()), 0);
    for (const Loop& loop : loops_) {
      for (const int v : loop.vertices) ++count[at(v)];
    }
    return count;
  }

 private:
  const Faces& cells_;
  Topology surface_;
  std::vector<int> group_;
  std::vector<Loop> loops_;  // by group
};

/// The corners on a loop.
std::vector<int> polygon_of(const Loop& loop, const std::vector<char>& corner) {
  std::vector<int> polygon;
  polygon.reserve(loop.vertices.size());
  for (const int v : loop.vertices) {
    if (corner[at(v)]) polygon.push_back(v);
  }
  return polygon;
}

/// Is every side of a face a side of just one other, run through the other way?
bool is_closed(const Faces& faces) {
  std::vector<std::array<int, 2>> sides;
  for (const std::vector<int>& face : faces) {
    for (std::size_t k = 0; k < face.size(); ++k) {
      sides.push_back({face[k], face[(k + 1) % face.size()]});
    }
  }
  std::sort(sides.begin(), sides.end());
  return std::adjacent_find(sides.begin(), sides.end()) == sides.end() &&
         std::all_of(sides.begin(), sides.end(), [&](const std::array<int, 2>& side) {
           return std::binary_search(sides.begin(), sides.end(), std::array{side[1], side[0]});
         });
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
        cells_(cells),
        stated_(stated),
        order_(by_area(vertices, cells)),
        rank_(cells.size()),
        groups_(static_cast<int>(vertices.cols()), cells),
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
      std::vector<int> members{seed};
      if (length_ > 0.0 && polygon_width(vertices_, cells_[at(seed)]) > length_) {
        members = grown(seed);
      }
      for (const int cell : members) groups_.put(cell, rank_[at(seed)]);
    }
  }

  /// The largest convex union of cells around a seed that the length allows.
  std::vector<int> grown(int seed) {
    constexpr int kTrials = 13;  // from 1e-9 of the diameter down to its rounding
    double reach = length_;
    for (int trial = 0; trial < kTrials; ++trial, reach /= 4) {
      std::vector<int> members =
          cap(seed, unit_normal(vertices_, cells_[at(seed)]), cells_[at(seed)], reach);
      if (members.size() == 1) break;
      Loop loop = border(members);
      for (int fit = 0; fit < 3 && !loop.vertices.empty(); ++fit) {  // the seed may be slim
        std::vector<int> more =
            cap(seed, unit_normal(vertices_, loop.vertices), loop.vertices, reach);
        if (more.size() <= members.size()) break;
        members = std::move(more);
        loop = border(members);
      }
      if (is_polygon(members, loop.vertices)) return members;
    }
    return {seed};
  }

  /// The cells around a seed all of whose vertices lie within `reach` below the plane that touches
  /// `rim`. The part of a convex surface that a plane cuts off is a disk.
  std::vector<int> cap(int seed, const Vector3& normal, std::span<const int> rim, double reach) {
    const Vector3 base = vertices_.col(cells_[at(seed)][0]);
    double level = -std::numeric_limits<double>::infinity();
    for (const int v : rim) level = std::max(level, normal.dot(vertices_.col(v) - base));
    const auto flat = [&](int cell) {
      return std::all_of(cells_[at(cell)].begin(), cells_[at(cell)].end(), [&](int v) {
        const double height = normal.dot(vertices_.col(v) - base) - level;
        return height >= -reach && height <= reach;
      });
    };
    std::vector<int> members{seed};
    const int mark = ++marks_;
    member_[at(seed)] = mark;
    for (std::size_t k = 0; k < members.size(); ++k) {
      for (const int next : groups_.surface().face_neighbours(members[k])) {
        if (member_[at(next)] == mark || groups_.group(next) >= 0 || !flat(next)) continue;
        member_[at(next)] = mark;
        members.push_back(next);
      }
    }
    return members;
  }

  /// Of the cells found last.
  Loop border(const std::vector<int>& members) const {
    std::vector<BorderSide> sides;
    for (const int cell : members) {
      const std::vector<int>& cycle = cells_[at(cell)];
      for (std::size_t k = 0; k < cycle.size(); ++k) {
        if (member_[at(groups_.surface().face_neighbours(cell)[k])] == marks_) continue;
        sides.push_back({cycle[k], cycle[(k + 1) % cycle.size()], 0});
      }
    }
    return joined(sides);
  }

  bool is_polygon(const std::vector<int>& members, const std::vector<int>& loop) const {
    if (loop.size() < 3) return false;
    const Vector3 normal = unit_normal(vertices_, loop);
    return spread(members, normal) <= length_ &&
           convex_within(laid_flat(vertices_, loop, normal), length_);
  }

  /// Between the lowest and the highest vertex along a normal.
  double spread(const std::vector<int>& members, const Vector3& normal) const {
    const Vector3 base = vertices_.col(cells_[at(members[0])][0]);
    double low = 0.0, high = 0.0;
    for (const int cell : members) {
      for (const int v : cells_[at(cell)]) {
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
    const std::vector<char> met = corner_;
    for (int g = 0; g < groups_.size(); ++g) {
      const std::vector<int>& cycle = groups_.loop(g).vertices;
      const auto first =
          std::find_if(cycle.begin(), cycle.end(), [&](int v) { return met[at(v)]; });
      if (first == cycle.end()) continue;
      std::vector<int> round(first, cycle.end());
      round.insert(round.end(), cycle.begin(), first + 1);
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
    std::vector<char> touched(cells_.size(), 0);
    for (int g = groups_.size() - 1; g >= 0; --g) {
      const Loop& loop = groups_.loop(g);
      if (loop.vertices.empty() || touched[at(g)]) continue;
      const std::vector<int> polygon = polygon_of(loop, corner_);
      if (polygon.size() >= 3 && polygon_width(vertices_, polygon) > length_) continue;
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
  int main_neighbour(const Loop& loop) const {
    std::vector<std::pair<int, double>> shared;
    for (std::size_t k = 0; k < loop.vertices.size(); ++k) {
      const int next = loop.vertices[(k + 1) % loop.vertices.size()];
      shared.emplace_back(loop.beyond[k],
                          (vertices_.col(next) - vertices_.col(loop.vertices[k])).norm());
    }
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
    face_of_.assign(cells_.size(), -1);
    std::vector<std::vector<int>> members(cells_.size());
    for (int cell = 0; cell < groups_.size(); ++cell) {
      members[at(groups_.group(cell))].push_back(cell);
    }
    for (int cell = 0; cell < groups_.size(); ++cell) {
      const int g = groups_.group(cell);
      if (face_of_[at(g)] >= 0) continue;
      face_of_[at(g)] = static_cast<int>(faces.size());
      faces.push_back(polygon_of(groups_.loop(g), corner_));
      const std::vector<int>& polygon = faces.back();
      if (polygon.size() < 3) return false;
      const Vector3 normal = unit_normal(vertices_, polygon);
      if (length_ > 0.0 && !(normal.norm() > 0.5)) return false;
      const bool flat = members[at(g)].size() == 1 || length_ == 0.0 ||
                        spread(members[at(g)], normal) <= 2 * stated_;
      if (!flat) return false;
    }
    return faces.size() >= 4 && is_closed(faces);
  }

  /// Corners joined by an edge no longer than the length become one, and of all vertices beside a
  /// corner the farthest out is it, whichever of them the groups met in; false: a face is lost.
  bool join_corners(Faces& faces) {
    std::vector<int> name(corner_.size(), -1);  // of the cluster
    for (std::size_t v = 0; v < name.size(); ++v) {
      name[v] = corner_[v] ? static_cast<int>(v) : nearest_corner(static_cast<int>(v), faces);
    }
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
    for (std::vector<int>& face : faces) {
      for (int& v : face) v = out[at(name[at(v)])];
      face.erase(std::unique(face.begin(), face.end()), face.end());
      if (face.front() == face.back()) face.pop_back();
      if (face.size() < 3) return false;
      std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
      for (const int v : face) corner_[at(v)] = 1;
    }
    return is_closed(faces);
  }

  /// Of the faces around a vertex, within the stated length; -1: none.
  int nearest_corner(int v, const Faces& faces) const {
    int best = -1;
    double nearest = stated_;
    for (const int cell : groups_.surface().vertex_faces(v)) {
      for (const int c : faces[at(face_of_[at(groups_.group(cell))])]) {
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
    for (int v = 0; v < vertices_.cols(); ++v) {
      if (!corner_[at(v)]) labels.hosted.push_back(host_of(v, labels.faces));
    }
  }

  /// The nearest corner within the stated length, or else edge, or else the face around a vertex.
  HostedVertex host_of(int v, const Faces& faces) const {
    const Vector3 x = vertices_.col(v);
    if (const int corner = nearest_corner(v, faces); corner >= 0) return {v, {corner, -1}};
    HostedVertex by_edge{v}, by_face{v};
    double nearest = stated_, most = -std::numeric_limits<double>::infinity();
    for (const int cell : groups_.surface().vertex_faces(v)) {
      const int f = face_of_[at(groups_.group(cell))];
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
  const Faces& cells_;
  double stated_, length_ = 0.0;
  std::vector<int> order_, rank_;
  CellGroups groups_;
  std::vector<int> member_;  // the mark of the search that found a cell last
  int marks_ = 0;
  std::vector<char> corner_;
  std::vector<int> face_of_;  // by group
};

}  // namespace

Vector3 polygon_normal(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon) {
  return wide_area(vertices, polygon).rounded();
}

double polygon_width(const Eigen::Ref<const Points>& vertices, std::span<const int> polygon) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector3 a = vertices.col(polygon[k]);
    const Vector3 side = vertices.col(polygon[(k + 1) % polygon.size()]) - a;
    const double length = side.norm();
    double width = 0.0;
    for (const int v : polygon) {
      const Vector3 x = vertices.col(v) - a;
      width = std::max(width, length > 0.0 ? side.cross(x).norm() / length : x.norm());
    }
    least = std::min(least, width);
  }
  return least;
}

Faces exact_facets(const Eigen::Ref<const Points>& vertices, const Faces& cells) {
  CellGroups groups(static_cast<int>(vertices.cols()), cells);
  const auto coplanar = [&](int f, int g) {
    const std::vector<int>& plane = cells[at(f)];
    return std::all_of(cells[at(g)].begin(), cells[at(g)].end(), [&](int v) {
      return orientation(vertices.col(plane[0]), vertices.col(plane[1]), vertices.col(plane[2]),
                         vertices.col(v)) == 0;
    });
  };
  std::vector<int> stack;
  for (int seed = 0; seed < groups.size(); ++seed) {
    if (groups.group(seed) >= 0) continue;
    groups.put(seed, seed);
    stack.assign(1, seed);
    while (!stack.empty()) {
      const int cell = stack.back();
      stack.pop_back();
      for (const int next : groups.surface().face_neighbours(cell)) {
        if (groups.group(next) >= 0 || !coplanar(seed, next)) continue;
        groups.put(next, seed);
        stack.push_back(next);
      }
    }
  }
  if (!groups.find_loops()) return cells;  // cannot be: an exact facet is a convex polygon
  const std::vector<int> visits = groups.visits();
  std::vector<char> corner(visits.size());
  for (std::size_t v = 0; v < visits.size(); ++v) corner[v] = visits[v] >= 3;
  Faces facets;
  for (int g = 0; g < groups.size(); ++g) {
    if (!groups.loop(g).vertices.empty()) facets.push_back(polygon_of(groups.loop(g), corner));
  }
  std::sort(facets.begin(), facets.end());
  return facets;
}

FaceLabels label_faces(const Eigen::Ref<const Points>& vertices, const Faces& cells,
                       double length) {
  constexpr int kTrials = 7;  // from 1e-9 of the diameter to less than its rounding
  Labelling labelling(vertices, cells, length);
  FaceLabels labels;
  double shorter = length;
  for (int trial = 0; trial < kTrials; ++trial, shorter /= 16) {
    if (labelling.run(shorter, labels)) return labels;
  }
  if (!labelling.run(0.0, labels)) {
    throw InputError("the faces make no closed surface of polygons with three corners each");
  }
  return labels;
}

}  // namespace quoin::geometry
