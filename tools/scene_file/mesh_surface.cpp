#include "scene_file/mesh_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <sstream>

#include <quoin/geometry/build.hpp>

#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Vector3;
using Place = std::array<double, 3>;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

/// For each vertex the first one at the same place.
std::vector<int> merged_places(const std::vector<Place>& places) {
  std::vector<int> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const Place& first = places[static_cast<std::size_t>(a)];
    const Place& second = places[static_cast<std::size_t>(b)];
    return first < second || (first == second && a < b);
  });
  std::vector<int> first_at(places.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto now = static_cast<std::size_t>(order[i]);
    const bool same = i > 0 && places[static_cast<std::size_t>(order[i - 1])] == places[now];
    first_at[now] = same ? first_at[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  return first_at;
}

/// An edge of a face, from its lower to its higher vertex, or back.
struct HalfEdge {
  int low = 0, high = 0;
  int face = 0;
  bool forward = false;
};

/// Sets of faces that belong together, by their first face.
class FaceSets {
 public:
  explicit FaceSets(std::size_t count) : first_(count) {
    std::iota(first_.begin(), first_.end(), 0);
  }
  int first(int face) {
    int& up = first_[static_cast<std::size_t>(face)];
    while (up != first_[static_cast<std::size_t>(up)]) up = first_[static_cast<std::size_t>(up)];
    return up;
  }
  void unite(int a, int b) {
    const auto [low, high] = std::minmax({first(a), first(b)});
    first_[static_cast<std::size_t>(high)] = low;
  }

 private:
  std::vector<int> first_;
};

class Divider {
 public:
  explicit Divider(const Surface& surface)
      : surface_(surface), vertex_(merged_places(surface.places)), sets_(surface.face_ends.size()) {
    std::vector<HalfEdge> edges = half_edges();
    for (auto from = edges.begin(); from != edges.end();) {
      const auto until = std::find_if(from, edges.end(), [&](const HalfEdge& edge) {
        return edge.low != from->low || edge.high != from->high || group(edge) != group(*from);
      });
      join({from, until});
      from = until;
    }
  }

  std::vector<MeshBlock> blocks() {
    std::vector<MeshBlock> blocks;
    std::vector<int> group_of;
    std::map<int, std::size_t> block_of;
    for (int f = 0; f < std::ssize(surface_.face_ends); ++f) {
      const auto [found, is_new] = block_of.try_emplace(sets_.first(f), blocks.size());
      if (is_new) {
        blocks.emplace_back();
        group_of.push_back(surface_.face_group[static_cast<std::size_t>(f)]);
      }
      const std::span<const int> cycle = corners(f);
      blocks[found->second].faces.emplace_back(cycle.begin(), cycle.end());
    }
    for (MeshBlock& block : blocks) take_places(block);
    give_names(group_of, blocks);
    return blocks;
  }

 private:
  std::span<const int> corners(int face) const {
    const auto f = static_cast<std::size_t>(face);
    const std::size_t begin = f == 0 ? 0 : surface_.face_ends[f - 1];
    return {surface_.corners.data() + begin, surface_.face_ends[f] - begin};
  }

  Vector3 place(int vertex) const {
    const Place& at = surface_.places[static_cast<std::size_t>(vertex)];
    return {at[0], at[1], at[2]};
  }

  int group(const HalfEdge& edge) const {
    return surface_.face_group[static_cast<std::size_t>(edge.face)];
  }

  std::vector<HalfEdge> half_edges() const {
    std::vector<HalfEdge> edges;
    edges.reserve(surface_.corners.size());
    for (int f = 0; f < std::ssize(surface_.face_ends); ++f) {
      const std::span<const int> cycle = corners(f);
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        const int from = vertex_[static_cast<std::size_t>(cycle[i])];
        const int to = vertex_[static_cast<std::size_t>(cycle[(i + 1) % cycle.size()])];
        if (from != to) edges.push_back({std::min(from, to), std::max(from, to), f, from < to});
      }
    }
    std::sort(edges.begin(), edges.end(), [&](const HalfEdge& a, const HalfEdge& b) {
      return std::tuple(a.low, a.high, group(a), a.face) <
             std::tuple(b.low, b.high, group(b), b.face);
    });
    return edges;
  }

  Vector3 normal(int face) const {
    const std::span<const int> cycle = corners(face);
    Vector3 area = Vector3::Zero();
    for (std::size_t i = 2; i < cycle.size(); ++i)
      area += (place(cycle[i - 1]) - place(cycle[0])).cross(place(cycle[i]) - place(cycle[0]));
    return area.normalized();
  }

  /// Angle inside the solid between two faces on an edge that runs forward in `face`, rad in (0, 2
  /// pi].
  double inner_angle(const HalfEdge& face, const HalfEdge& other) const {
    constexpr double kBackToBack = 1e-6;  // rad; faces of neighbours that lie on each other
    const Vector3 along =
        (place(face.forward ? face.high : face.low) - place(face.forward ? face.low : face.high))
            .normalized();
    const Vector3 first = normal(face.face);
    const Vector3 second = normal(other.face);
    const double turned = std::atan2(first.cross(second).dot(along), first.dot(second));
    const double angle = std::numbers::pi - turned;
    return angle < kBackToBack ? angle + 2 * std::numbers::pi : angle;
  }

  void join(std::span<const HalfEdge> edges) {
    if (edges.size() == 2) {
      sets_.unite(edges[0].face, edges[1].face);
      return;
    }
    for (const HalfEdge& edge : edges) {
      const HalfEdge* nearest = nullptr;
      double least = std::numeric_limits<double>::infinity();
      for (const HalfEdge& other : edges) {
        const double angle = other.forward == edge.forward ? std::numeric_limits<double>::infinity()
                                                           : inner_angle(edge, other);
        if (angle < least) {
          least = angle;
          nearest = &other;
        }
      }
      if (nearest != nullptr) sets_.unite(edge.face, nearest->face);
    }
  }

  void take_places(MeshBlock& block) const {
    std::vector<int> used;
    for (const std::vector<int>& face : block.faces)
      used.insert(used.end(), face.begin(), face.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    block.vertices.resize(3, std::ssize(used));
    for (std::size_t i = 0; i < used.size(); ++i)
      block.vertices.col(static_cast<Eigen::Index>(i)) = place(used[i]);
    for (std::vector<int>& face : block.faces) {
      for (int& corner : face) {
        corner =
            static_cast<int>(std::lower_bound(used.begin(), used.end(), corner) - used.begin());
      }
    }
    keep_used_vertices(block);
  }

  void give_names(const std::vector<int>& group_of, std::vector<MeshBlock>& blocks) const {
    std::vector<int> parts(surface_.groups.size(), 0);
    for (const int group : group_of) ++parts[static_cast<std::size_t>(group)];
    std::vector<int> used(surface_.groups.size(), 0);
    int unnamed = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const auto group = static_cast<std::size_t>(group_of[b]);
      const std::string& name = surface_.groups[group];
      if (name.empty())
        blocks[b].id = "block" + std::to_string(unnamed++);
      else
        blocks[b].id = parts[group] == 1 ? name : name + "." + std::to_string(used[group]++);
    }
  }

  const Surface& surface_;
  std::vector<int> vertex_;  ///< of each vertex: the first at the same place
  FaceSets sets_;
};

}  // namespace

std::vector<MeshBlock> blocks_of(const Surface& surface) { return Divider(surface).blocks(); }

void keep_used_vertices(MeshBlock& mesh) {
  std::map<Place, int> numbers;
  std::vector<int> kept;
  for (std::vector<int>& face : mesh.faces) {
    for (int& vertex : face) {
      const Vector3 place = mesh.vertices.col(vertex);
      const auto [found, is_new] =
          numbers.try_emplace({place.x(), place.y(), place.z()}, static_cast<int>(kept.size()));
      if (is_new) kept.push_back(vertex);
      vertex = found->second;
    }
    face.erase(std::unique(face.begin(), face.end()), face.end());
    while (face.size() > 1 && face.front() == face.back()) face.pop_back();
  }
  std::erase_if(mesh.faces, [](const std::vector<int>& face) { return face.size() < 3; });
  mesh.vertices = geometry::Points(mesh.vertices(Eigen::all, kept));
}

MeshBlock hull_mesh(std::string id, const std::vector<std::array<double, 3>>& points) {
  MeshBlock mesh{.id = std::move(id)};
  try {
    const geometry::Hull hull = geometry::make_hull(
        Eigen::Map<const geometry::Points>(points.front().data(), 3, std::ssize(points)));
    const geometry::Shape& shape = hull.polyhedron;
    mesh.vertices = shape.vertices();
    for (int f = 0; f < shape.topology().face_count(); ++f) {
      const std::span<const int> cycle = shape.topology().face(f);
      mesh.faces.emplace_back(cycle.begin(), cycle.end());
    }
  } catch (const geometry::InputError& error) {
    throw MeshError("block " + in_quotes(mesh.id) + ": " + error.what());
  }
  return mesh;
}

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (size < 0 || size == std::numeric_limits<std::streamoff>::max())
    throw FileError(path + ": can't be read");
  std::string text(static_cast<std::size_t>(size), '\0');
  file.seekg(0);
  if (!file.read(text.data(), size)) throw FileError(path + ": can't be read");
  return text;
}

std::string in_quotes(std::string_view word) {
  constexpr std::size_t kMost = 40;
  std::string text = "\"";
  for (const char c : word.substr(0, kMost)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > kMost ? "…\"" : "\"");
}

/// Adds the words of one line; true when it goes on in the next.
bool Lines::append_words() {
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  ++read_;
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  line = line.substr(0, line.find(comment_));
  const bool goes_on = !line.empty() && line.back() == joint_;
  if (goes_on) line.remove_suffix(1);
  const auto divides = [&](char c) {
    return is_blank(c) || blanks_.find(c) != std::string_view::npos;
  };
  while (!line.empty()) {
    const auto start = std::find_if_not(line.begin(), line.end(), divides);
    const auto stop = std::find_if(start, line.end(), divides);
    if (start != stop) words_.emplace_back(&*start, static_cast<std::size_t>(stop - start));
    line.remove_prefix(static_cast<std::size_t>(stop - line.begin()));
  }
  return goes_on;
}

void Lines::set_marks(char comment, char joint, std::string_view blanks) {
  comment_ = comment;
  joint_ = joint;
  blanks_ = blanks;
}

bool Lines::next() {
  words_.clear();
  while (words_.empty() && !rest_.empty()) {
    number_ = read_ + 1;
    while (append_words() && !rest_.empty()) {
    }
  }
  return !words_.empty();
}

void Lines::fail(const std::string& message) const {
  throw MeshError("line " + std::to_string(number_) + ": " + message);
}

double Lines::real(std::size_t i) const {
  std::string_view word = words_.at(i);
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (fault != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    fail(in_quotes(words_[i]) + " is not a finite number");
  return value;
}

long Lines::integer(std::size_t i) const {
  const std::string_view word = words_.at(i).substr(0, words_[i].find('/'));
  long value = 0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (fault != std::errc() || end != word.data() + word.size())
    fail(in_quotes(words_[i]) + " is not a whole number");
  return value;
}

int significant_digits(std::string_view word) {
  word = word.substr(0, word.find_first_of("eE"));
  if (word.find('.') == std::string_view::npos) return 0;
  word.remove_prefix(std::min(word.find_first_of("123456789"), word.size()));
  return static_cast<int>(
      std::count_if(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; }));
}

std::array<double, 3> Lines::place(std::size_t first) {
  if (words_.size() < first + 3) {
    fail("three coordinates expected, " +
         std::to_string(words_.size() - std::min(first, words_.size())) + " given");
  }
  for (std::size_t i = first; i < first + 3; ++i)
    digits_ = std::max(digits_, significant_digits(words_[i]));
  return {real(first), real(first + 1), real(first + 2)};
}

}  // namespace quoin::scene_file
