/// COMPAS JSON: assemblies (1.x), models (2.x), lists of meshes.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Vector3;
using OrderedJson = nlohmann::ordered_json;  // blocks in the order of the file

const OrderedJson* find(const OrderedJson& document, std::initializer_list<const char*> path) {
  const OrderedJson* at = &document;
  for (const char* key : path) {
    if (!at->is_object() || !at->contains(key)) return nullptr;
    at = &(*at)[key];
  }
  return at;
}

const OrderedJson& unwrapped(const OrderedJson& value) {
  const OrderedJson* data = find(value, {"data"});
  return data != nullptr ? *data : value;
}

bool has_items(const OrderedJson* value) {
  return value != nullptr && value->is_structured() && !value->empty();
}

double coordinate(const OrderedJson& value, const std::string& place) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw MeshError(place + ": coordinates must be finite numbers");
  return value.get<double>();
}

/// {"x": …, "y": …, "z": …} or [x, y, z].
Vector3 vertex_place(const OrderedJson& vertex, const std::string& place) {
  if (vertex.is_array() && vertex.size() == 3) {
    return {coordinate(vertex[0], place), coordinate(vertex[1], place),
            coordinate(vertex[2], place)};
  }
  for (const char* axis : {"x", "y", "z"})
    if (find(vertex, {axis}) == nullptr) throw MeshError(place + ": has no " + axis);
  return {coordinate(vertex["x"], place), coordinate(vertex["y"], place),
          coordinate(vertex["z"], place)};
}

/// A mesh ("vertex", "face": dictionaries) or a polyhedron ("vertices", "faces": lists).
class MeshReader {
 public:
  explicit MeshReader(std::string id) { block_.id = std::move(id); }

  MeshBlock read(const OrderedJson& mesh) {
    const OrderedJson* vertices = find(mesh, {"vertex"});
    const OrderedJson* faces = find(mesh, {"face"});
    vertices = vertices != nullptr ? vertices : find(mesh, {"vertices"});
    faces = faces != nullptr ? faces : find(mesh, {"faces"});
    if (!has_items(vertices) || !has_items(faces))
      throw MeshError(where() + "holds no mesh with vertices and faces");
    const auto count = static_cast<Eigen::Index>(vertices->size());
    block_.vertices.resize(3, count);
    for (const auto& [key, vertex] : vertices->items()) {
      const int number = static_cast<int>(number_.size());
      number_[key] = number;
      block_.vertices.col(number) = vertex_place(vertex, where() + "vertex " + in_quotes(key));
    }
    for (const auto& [key, face] : faces->items())
      if (!face.is_null()) read_face(key, face);
    const OrderedJson* name = find(mesh, {"attributes", "name"});
    if (name != nullptr && name->is_string()) block_.name = name->get<std::string>();
    keep_used_vertices(block_);
    return std::move(block_);
  }

 private:
  std::string where() const { return "block " + in_quotes(block_.id) + ": "; }

  void read_face(const std::string& key, const OrderedJson& face) {
    std::vector<int>& cycle = block_.faces.emplace_back();
    for (const OrderedJson& vertex : face) {
      const std::string name = vertex.is_string()           ? vertex.get<std::string>()
                               : vertex.is_number_integer() ? vertex.dump()
                                                            : std::string();
      const auto found = number_.find(name);
      if (found == number_.end()) {
        throw MeshError(where() + "face " + in_quotes(key) + " names vertex " + in_quotes(name) +
                        ", which is not there");
      }
      cycle.push_back(found->second);
    }
  }

  MeshBlock block_;
  std::map<std::string, int> number_;
};

/// A COMPAS transformation (4 × 4, or null) of a model's element.
void place(const OrderedJson& element, MeshBlock& block) {
  const OrderedJson* transformation = find(element, {"transformation"});
  if (transformation == nullptr || transformation->is_null()) return;
  const OrderedJson* rows = find(unwrapped(*transformation), {"matrix"});
  Eigen::Matrix4d matrix;
  const auto is_row = [](const OrderedJson& row) {
    return row.is_array() && row.size() == 4 &&
           std::all_of(row.begin(), row.end(), [](const OrderedJson& x) { return x.is_number(); });
  };
  if (rows == nullptr || !rows->is_array() || rows->size() != 4 ||
      !std::all_of(rows->begin(), rows->end(), is_row)) {
    throw MeshError("block " + in_quotes(block.id) +
                    ": transformation is not a matrix of 4 rows of 4");
  }
  for (std::size_t i = 0; i < 16; ++i) {
    matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) =
        (*rows)[i / 4][i % 4].get<double>();
  }
  block.vertices =
      ((matrix.topLeftCorner<3, 3>() * block.vertices).colwise() + matrix.topRightCorner<3, 1>())
          .eval();
}

bool flag(const OrderedJson& attributes) {
  const OrderedJson* stated = find(attributes, {"is_support"});
  return stated != nullptr && stated->is_boolean() && stated->get<bool>();
}

MeshBlock block_of(const std::string& id, const OrderedJson& mesh, bool is_support) {
  MeshBlock block = MeshReader(id).read(unwrapped(mesh));
  block.is_support = is_support;
  return block;
}

std::vector<MeshBlock> blocks_of_nodes(const OrderedJson& nodes) {
  std::vector<MeshBlock> blocks;
  for (const auto& [id, node] : nodes.items()) {
    const OrderedJson* mesh = find(node, {"block"});
    if (mesh != nullptr) blocks.push_back(block_of(id, *mesh, flag(node)));
  }
  return blocks;
}

std::vector<MeshBlock> blocks_of_list(const OrderedJson& meshes, const OrderedJson* nodes) {
  std::vector<MeshBlock> blocks;
  for (const auto& [id, mesh] : meshes.items()) {
    const OrderedJson* node = nodes != nullptr ? find(*nodes, {id.c_str()}) : nullptr;
    blocks.push_back(block_of(id, mesh, node != nullptr && flag(*node)));
  }
  return blocks;
}

/// Elements are keyed by long identifiers; the graph's node keys name them for people.
std::vector<MeshBlock> blocks_of_elements(const OrderedJson& elements, const OrderedJson* nodes) {
  std::map<std::string, std::string> node_of;
  if (nodes != nullptr) {
    for (const auto& [id, node] : nodes->items()) {
      const OrderedJson* element = find(node, {"element"});
      if (element != nullptr && element->is_string()) node_of[element->get<std::string>()] = id;
    }
  }
  std::vector<MeshBlock> blocks;
  for (const auto& [key, element] : elements.items()) {
    const OrderedJson& data = unwrapped(element);
    const std::string id = node_of.contains(key) ? node_of[key] : key;
    const OrderedJson* shape = find(data, {"geometry"});
    if (shape == nullptr) throw MeshError("element " + in_quotes(key) + ": has no geometry");
    blocks.push_back(block_of(id, *shape, flag(data)));
    place(data, blocks.back());
  }
  return blocks;
}

/// A problem of compas_dem holds its model.
std::vector<MeshBlock> blocks_of_document(const OrderedJson& whole) {
  const OrderedJson* model = find(whole, {"data", "model"});
  const OrderedJson& document = model != nullptr ? *model : whole;
  const OrderedJson* nodes = nullptr;
  for (const auto& path : {std::initializer_list<const char*>{"data", "graph", "data", "node"},
                           {"data", "graph", "node"},
                           {"assembly", "node"},
                           {"node"}})
    nodes = nodes != nullptr ? nodes : find(document, path);
  const OrderedJson* elements = find(document, {"data", "elements"});
  if (has_items(elements)) return blocks_of_elements(*elements, nodes);
  const OrderedJson* meshes = document.is_array() ? &document : find(document, {"blocks"});
  if (has_items(meshes)) return blocks_of_list(*meshes, nodes);
  if (has_items(nodes)) return blocks_of_nodes(*nodes);
  const OrderedJson& mesh = unwrapped(document);
  const bool is_mesh = has_items(find(mesh, {"vertex"})) || has_items(find(mesh, {"vertices"}));
  return is_mesh ? std::vector{block_of("0", mesh, false)} : std::vector<MeshBlock>();
}

bool is_number(const std::string& id) {
  return !id.empty() &&
         std::all_of(id.begin(), id.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// Names first, as in the file, then numbers, ascending.
bool earlier(const MeshBlock& a, const MeshBlock& b) {
  const bool number_a = is_number(a.id), number_b = is_number(b.id);
  if (!number_a || !number_b) return number_b && !number_a;
  return std::pair(a.id.size(), a.id) < std::pair(b.id.size(), b.id);
}

}  // namespace

std::vector<MeshBlock> read_compas(std::string_view text) {
  std::vector<MeshBlock> blocks;
  try {
    blocks = blocks_of_document(OrderedJson::parse(text));
  } catch (const OrderedJson::exception& error) {
    const std::string message = error.what();
    const std::size_t start = message.find("] ");
    throw MeshError("is no JSON of blocks: " +
                    message.substr(start == std::string::npos ? 0 : start + 2, 160));
  }
  if (blocks.empty())
    throw MeshError("holds no block meshes where COMPAS assemblies and models have them");
  std::stable_sort(blocks.begin(), blocks.end(), earlier);
  return blocks;
}

}  // namespace quoin::scene_file
