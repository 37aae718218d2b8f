#include "scene_file/moved_hulls.hpp"

#include <quoin/geometry/build.hpp>
#include <tuple>

namespace quoin::scene_file {
namespace {

constexpr std::size_t kMostKnown = 1000;  // some 1 kB each; walls have a few

/// What a - b loses by rounding, exactly [Knuth 1969, TwoSum].
double rounding_of_difference(double a, double b) {
  const double difference = a - b;
  const double b_of = a - difference, a_of = difference + b_of;
  return (a - a_of) + (b_of - b);
}

}  // namespace

bool MovedHulls::Key::operator<(const Key& other) const {
  return std::tie(differences, faces) < std::tie(other.differences, other.faces);
}

/// False where a difference of corners rounds, or is no number.
bool MovedHulls::set(const MeshBlock& mesh, Key& key) {
  for (Eigen::Index v = 1; v < mesh.vertices.cols(); ++v) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double a = mesh.vertices(c, v), b = mesh.vertices(c, 0);
      if (!(rounding_of_difference(a, b) == 0.0)) return false;
      key.differences.push_back(a - b);
    }
  }
  key.differences.push_back(geometry::label_length(mesh.vertices));
  for (const std::vector<int>& face : mesh.faces) {
    key.faces.push_back(static_cast<int>(face.size()));
    key.faces.insert(key.faces.end(), face.begin(), face.end());
  }
  return true;
}

geometry::Shape MovedHulls::shape_of(const MeshBlock& mesh,
                                     const std::function<geometry::Shape()>& make) {
  Key key;
  if (!set(mesh, key)) return make();
  const auto found = known_.find(key);
  if (found != known_.end()) return {found->second, mesh.vertices};
  geometry::Shape shape = make();
  if (shape.topology().vertex_count() == mesh.vertices.cols() && known_.size() < kMostKnown)
    known_.emplace(std::move(key), shape.shared_topology());
  return shape;
}

}  // namespace quoin::scene_file
