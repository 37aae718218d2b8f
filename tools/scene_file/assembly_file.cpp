#include "scene_file/assembly_file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <sstream>

#include "scene_file/read_json.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Points;
using geometry::Vector3;
using json = nlohmann::ordered_json;  // blocks in the order of the file

std::ifstream open(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    throw FileError(path + ": can't be read");
  }
  return file;
}

Points columns(const std::vector<Vector3>& points) {
  Points result(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    result.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  return result;
}

/// Keeps the vertices that faces use; places that are the same to the bit become one vertex.
void keep_used_vertices(MeshBlock& mesh) {
  std::map<std::array<double, 3>, int> places;
  std::vector<Vector3> kept;
  for (std::vector<int>& face : mesh.faces) {
    for (int& vertex : face) {
      const Vector3 place = mesh.vertices.col(vertex);
      const auto [found, is_new] =
          places.try_emplace({place.x(), place.y(), place.z()}, static_cast<int>(kept.size()));
      if (is_new) {
        kept.push_back(place);
      }
      vertex = found->second;
    }
  }
  if (kept.size() < 4) {
    throw SceneError("block " + mesh.id, "its faces use " + std::to_string(kept.size()) +
                                             " vertices, at least 4 are needed");
  }
  mesh.vertices = columns(kept);
}

MeshBlock compas_mesh(const std::string& id, const json& mesh, bool is_support) {
  MeshBlock block{.id = id, .vertices = {}, .faces = {}, .is_support = is_support};
  std::map<std::string, int> number;
  std::vector<Vector3> places;
  for (const auto& [key, vertex] : mesh.at("vertex").items()) {
    number[key] = static_cast<int>(places.size());
    places.emplace_back(vertex.at("x").get<double>(), vertex.at("y").get<double>(),
                        vertex.at("z").get<double>());
  }
  for (const auto& [key, face] : mesh.at("face").items()) {
    if (face.is_null()) {
      continue;
    }
    std::vector<int> cycle;
    for (const json& vertex : face) {
      const std::string name = vertex.is_string() ? vertex.get<std::string>() : vertex.dump();
      if (!number.contains(name)) {
        throw SceneError("face " + key, "names vertex " + name + ", which is not there");
      }
      cycle.push_back(number[name]);
    }
    block.faces.push_back(std::move(cycle));
  }
  block.vertices = columns(places);
  keep_used_vertices(block);
  return block;
}

/// A COMPAS transformation (4 × 4, or null) of a model's element.
void place(const json& transformation, MeshBlock& block) {
  if (transformation.is_null()) {
    return;
  }
  const json& holder = transformation.contains("data") ? transformation["data"] : transformation;
  const json& rows = holder.at("matrix");
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      matrix(i, j) = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j));
    }
  }
  block.vertices =
      ((matrix.topLeftCorner<3, 3>() * block.vertices).colwise() + matrix.topRightCorner<3, 1>())
          .eval();
}

bool flag(const json& attributes) {
  return attributes.contains("is_support") && attributes["is_support"].is_boolean() &&
         attributes["is_support"].get<bool>();
}

const json& unwrapped(const json& mesh) { return mesh.contains("data") ? mesh["data"] : mesh; }

bool earlier(const MeshBlock& a, const MeshBlock& b) {
  const auto number = [](const std::string& id) {
    const bool digits = !id.empty() && std::all_of(id.begin(), id.end(), ::isdigit);
    return digits ? std::stol(id) : -1L;
  };
  return number(a.id) < number(b.id);
}

const json* find(const json& document, std::initializer_list<const char*> path) {
  const json* at = &document;
  for (const char* key : path) {
    if (!at->is_object() || !at->contains(key)) {
      return nullptr;
    }
    at = &(*at)[key];
  }
  return at;
}

std::vector<MeshBlock> blocks_of_nodes(const json& nodes) {
  std::vector<MeshBlock> blocks;
  for (const auto& [id, node] : nodes.items()) {
    if (node.contains("block")) {
      blocks.push_back(compas_mesh(id, unwrapped(node["block"]), flag(node)));
    }
  }
  return blocks;
}

std::vector<MeshBlock> blocks_of_list(const json& meshes, const json* nodes) {
  std::vector<MeshBlock> blocks;
  for (const auto& [id, mesh] : meshes.items()) {
    const bool support = nodes != nullptr && nodes->contains(id) && flag((*nodes)[id]);
    blocks.push_back(compas_mesh(id, unwrapped(mesh), support));
  }
  return blocks;
}

/// Elements are keyed by long identifiers; the graph's node keys name them for people.
std::vector<MeshBlock> blocks_of_elements(const json& elements, const json* nodes) {
  std::map<std::string, std::string> node_of;
  if (nodes != nullptr) {
    for (const auto& [id, node] : nodes->items()) {
      node_of[node.value("element", std::string())] = id;
    }
  }
  std::vector<MeshBlock> blocks;
  for (const auto& [key, element] : elements.items()) {
    const json& data = unwrapped(element);
    const std::string id = node_of.contains(key) ? node_of[key] : key;
    blocks.push_back(compas_mesh(id, unwrapped(data.at("geometry")), flag(data)));
    place(data.contains("transformation") ? data["transformation"] : json(), blocks.back());
  }
  return blocks;
}

std::vector<MeshBlock> compas_blocks(const json& document) {
  const json* nodes = find(document, {"data", "graph", "data", "node"});
  if (const json* elements = find(document, {"data", "elements"})) {
    nodes = nodes != nullptr ? nodes : find(document, {"data", "graph", "node"});
    return blocks_of_elements(*elements, nodes);
  }
  if (nodes != nullptr) {
    return blocks_of_nodes(*nodes);
  }
  if (const json* meshes = find(document, {"blocks"})) {
    nodes = find(document, {"assembly", "node"});
    return blocks_of_list(*meshes, nodes != nullptr ? nodes : find(document, {"node"}));
  }
  return {};
}

/// Depth of a point below the surface of a convex polyhedron with its outward face planes, m.
struct Plane {
  Vector3 normal;
  double offset;
};

std::vector<Plane> planes(const geometry::Polyhedron& hull) {
  std::vector<Plane> result;
  for (int f = 0; f < hull.topology().face_count(); ++f) {
    const std::span<const int> cycle = hull.topology().face(f);
    Vector3 area = Vector3::Zero();
    Vector3 middle = Vector3::Zero();
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      const Vector3 from = hull.vertex(cycle[i]) - hull.vertex(cycle[0]);
      area += from.cross(hull.vertex(cycle[(i + 1) % cycle.size()]) - hull.vertex(cycle[0]));
      middle += hull.vertex(cycle[i]) / static_cast<double>(cycle.size());
    }
    const Vector3 normal = area.normalized();
    result.push_back({normal, normal.dot(middle)});
  }
  return result;
}

double depth(const std::vector<Plane>& planes, const Vector3& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const Plane& plane : planes) {
    least = std::min(least, plane.offset - plane.normal.dot(point));
  }
  return least;
}

/// How deep vertices, edge middles and face middles of the mesh lie below its hull, m.
double greatest_depth(const MeshBlock& mesh, const std::vector<Plane>& planes) {
  double greatest = 0.0;
  for (const std::vector<int>& face : mesh.faces) {
    Vector3 middle = Vector3::Zero();
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vector3 here = mesh.vertices.col(face[i]);
      const Vector3 next = mesh.vertices.col(face[(i + 1) % face.size()]);
      middle += here / static_cast<double>(face.size());
      greatest = std::max({greatest, depth(planes, here), depth(planes, 0.5 * (here + next))});
    }
    greatest = std::max(greatest, depth(planes, middle));
  }
  return greatest;
}

/// Volume of the cones from an inner point to the faces, whichever way they are turned, m3.
double cone_volume(const MeshBlock& mesh, const Vector3& inside) {
  double volume = 0.0;
  for (const std::vector<int>& face : mesh.faces) {
    double cone = 0.0;
    const Vector3 first = mesh.vertices.col(face[0]) - inside;
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      const Vector3 second = mesh.vertices.col(face[i]) - inside;
      const Vector3 third = mesh.vertices.col(face[i + 1]) - inside;
      cone += first.dot(second.cross(third)) / 6;
    }
    volume += std::abs(cone);
  }
  return volume;
}

std::string text(double value) {
  std::ostringstream stream;
  stream.precision(3);
  stream << value;
  return stream.str();
}

/// Index of an OBJ face corner "7", "7/1", "7//2" or "-1".
int corner(const std::string& word, std::size_t vertex_count) {
  int number = 0;
  const char* const end = word.data() + word.size();
  const auto [at, error] = std::from_chars(word.data(), end, number);
  if (error != std::errc() || (at != end && *at != '/')) return -1;
  return number < 0 ? static_cast<int>(vertex_count) + number : number - 1;
}

}  // namespace

std::vector<MeshBlock> read_compas(const std::string& path) {
  std::ifstream file = open(path);
  try {
    std::vector<MeshBlock> blocks = compas_blocks(json::parse(file));
    if (blocks.empty()) {
      throw FileError(path +
                      ": holds no block meshes where COMPAS assemblies and models have them");
    }
    std::stable_sort(blocks.begin(), blocks.end(), earlier);
    return blocks;
  } catch (const nlohmann::json::exception& error) {
    throw FileError(path + ": " + plain_message(error));
  } catch (const SceneError& error) {
    throw FileError(path + ": " + error.what());
  }
}

std::vector<MeshBlock> read_obj(const std::string& path) {
  std::ifstream file = open(path);
  std::vector<Vector3> places;
  std::vector<MeshBlock> blocks;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Vector3 place = Vector3::Zero();
      if (!(words >> place.x() >> place.y() >> place.z())) {
        throw FileError(path + ": line " + std::to_string(number) + ": three coordinates expected");
      }
      places.push_back(place);
    } else if (word == "o" || word == "g") {
      std::string name = "block" + std::to_string(blocks.size());
      words >> name;
      blocks.push_back({.id = name, .vertices = {}, .faces = {}});
    } else if (word == "f") {
      if (blocks.empty()) {
        blocks.push_back({.id = "block0", .vertices = {}, .faces = {}});
      }
      std::vector<int>& face = blocks.back().faces.emplace_back();
      while (words >> word) {
        const int vertex =
            std::isdigit(word[0]) || word[0] == '-' ? corner(word, places.size()) : -1;
        if (vertex < 0 || vertex >= static_cast<int>(places.size())) {
          throw FileError(path + ": line " + std::to_string(number) + ": no vertex " + word);
        }
        face.push_back(vertex);
      }
      if (face.size() < 3) {
        throw FileError(path + ": line " + std::to_string(number) + ": a face of " +
                        std::to_string(face.size()) + " vertices");
      }
    }
  }
  std::erase_if(blocks, [](const MeshBlock& block) { return block.faces.empty(); });
  for (MeshBlock& block : blocks) {
    block.vertices = columns(places);
    try {
      keep_used_vertices(block);
    } catch (const SceneError& error) {
      throw FileError(path + ": " + error.what());
    }
  }
  if (blocks.empty()) {
    throw FileError(path + ": holds no faces");
  }
  return blocks;
}

geometry::Polyhedron convex_block(const MeshBlock& mesh, double tolerance) {
  const geometry::Hull hull = geometry::make_hull(mesh.vertices);
  const geometry::Box& box = hull.polyhedron.box();
  const double limit = tolerance < 0 ? 1e-6 * (box.max - box.min).norm() : tolerance;
  const double deep = greatest_depth(mesh, planes(hull.polyhedron));
  if (deep > limit) {
    throw geometry::InputError("is not convex: its surface lies " + text(deep) +
                               " m below its convex hull, more than convexity_tolerance " +
                               text(limit) + " m");
  }
  const geometry::MassProperties mass = geometry::mass_properties(hull.polyhedron);
  const double enclosed = cone_volume(mesh, mass.centroid);
  // A surface at most `limit` below the hull leaves out at most limit × area, and area < 6 d^2.
  const double allowed = 6 * limit * (box.max - box.min).squaredNorm() + 1e-9 * mass.volume;
  if (std::abs(enclosed - mass.volume) > allowed) {
    throw geometry::InputError("is not closed: its faces enclose " + text(enclosed) +
                               " m3, its convex hull " + text(mass.volume) + " m3");
  }
  return hull.polyhedron;
}

}  // namespace quoin::scene_file
