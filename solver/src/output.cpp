#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <quoin/solver/output.hpp>
#include <stdexcept>

namespace quoin::solver {
namespace {

/// VTK XML text: numbers in the shortest form that reads back to the same double.
class Text {
 public:
  explicit Text(std::string path) : path_(std::move(path)) {}

  Text& raw(std::string_view text) {
    text_ += text;
    return *this;
  }
  Text& number(double value) {
    if (!std::isfinite(value)) {
      throw std::runtime_error(path_ + ": a value is not finite");
    }
    return append(value);
  }
  Text& number(long value) { return append(value); }
  Text& trim() {
    text_.pop_back();  // the blank after a number
    return *this;
  }
  Text& vector(const Eigen::Ref<const Eigen::VectorXd>& value) {
    for (Eigen::Index i = 0; i < value.size(); ++i) {
      number(value[i]);
    }
    text_.back() = '\n';
    return *this;
  }

  void array(std::string_view type, std::string_view name, int components) {
    raw("<DataArray type=\"").raw(type).raw("\" Name=\"").raw(name);
    raw("\" NumberOfComponents=\"").raw(std::to_string(components)).raw("\" format=\"ascii\">\n");
  }
  void end_array() { raw("\n</DataArray>\n"); }

  /// Written beside its name, then renamed: a reader never sees half a file.
  void save() const {
    const std::string part = path_ + ".part";
    std::ofstream file(part, std::ios::binary);
    file << text_;
    file.close();
    if (!file) {
      throw std::runtime_error(part + ": can't be written");
    }
    std::filesystem::rename(part, path_);
  }

 private:
  template <typename Number>
  Text& append(Number value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    text_.append(digits, end);
    text_ += ' ';
    return *this;
  }

  std::string path_;
  std::string text_;
};

/// One array with a value for each item: `each(i)` writes it.
template <typename Each>
void write_array(Text& text, std::string_view type, std::string_view name, int components,
                 std::size_t count, const Each& each) {
  text.array(type, name, components);
  for (std::size_t i = 0; i < count; ++i) {
    each(i);
  }
  text.end_array();
}

Matrix3 tensor(const Vector6& v) {
  Matrix3 result;
  result << v[0], v[3] / 2, v[5] / 2, v[3] / 2, v[1], v[4] / 2, v[5] / 2, v[4] / 2, v[2];
  return result;
}

/// Velocity of the material point with reference arm X: v + R (omega × (I + eps) X + eps' X).
Vector3 velocity_at(const BlockState& block, const Vector3& arm) {
  const Vector3 strained = arm + tensor(block.strain) * arm;
  const Vector3 local = block.angular_velocity.cross(strained) + tensor(block.strain_rate) * arm;
  return block.velocity + block.rotation * local;
}

void write_points(Text& text, const State& state) {
  text.raw("<Points>\n");
  write_array(text, "Float64", "Points", 3, state.polyhedra.size(), [&](std::size_t b) {
    const geometry::Points& vertices = state.polyhedra[b].vertices();
    for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
      text.vector(state.origin + vertices.col(v));
    }
  });
  text.raw("</Points>\n");
}

void write_connectivity(Text& text, const State& state) {
  long point = 0;
  for (const geometry::Polyhedron& polyhedron : state.polyhedra) {
    for (int v = 0; v < polyhedron.topology().vertex_count(); ++v) {
      text.number(point++);
    }
    text.raw("\n");
  }
}

/// Face stream of VTK_POLYHEDRON: face count, then for each face its size and its points.
std::vector<long> write_faces(Text& text, const State& state) {
  std::vector<long> ends;
  long first = 0;
  long written = 0;
  for (const geometry::Polyhedron& polyhedron : state.polyhedra) {
    const geometry::Topology& topology = polyhedron.topology();
    text.number(static_cast<long>(topology.face_count()));
    written += 1 + topology.face_count();
    for (int f = 0; f < topology.face_count(); ++f) {
      text.number(static_cast<long>(topology.face(f).size()));
      for (const int v : topology.face(f)) {
        text.number(first + v);
      }
      written += static_cast<long>(topology.face(f).size());
    }
    text.raw("\n");
    ends.push_back(written);
    first += topology.vertex_count();
  }
  return ends;
}

void write_cells(Text& text, const State& state) {
  text.raw("<Cells>\n");
  text.array("Int64", "connectivity", 1);
  write_connectivity(text, state);
  text.end_array();
  long end = 0;
  write_array(text, "Int64", "offsets", 1, state.polyhedra.size(), [&](std::size_t b) {
    text.number(end += state.polyhedra[b].topology().vertex_count());
  });
  write_array(text, "UInt8", "types", 1, state.polyhedra.size(),
              [&](std::size_t) { text.number(42L); });  // VTK_POLYHEDRON
  text.array("Int64", "faces", 1);
  const std::vector<long> ends = write_faces(text, state);
  text.end_array();
  write_array(text, "Int64", "faceoffsets", 1, ends.size(),
              [&](std::size_t b) { text.number(ends[b]); });
  text.raw("</Cells>\n");
}

void write_point_data(Text& text, const Simulation& simulation) {
  const State& state = simulation.state();
  const std::size_t count = state.polyhedra.size();
  text.raw("<PointData Vectors=\"displacement\">\n");
  write_array(text, "Float64", "displacement", 3, count, [&](std::size_t b) {
    const geometry::Points& now = state.polyhedra[b].vertices();
    const geometry::Points& start = simulation.scene().blocks[b].shape.vertices();
    for (Eigen::Index v = 0; v < now.cols(); ++v) {
      text.vector(now.col(v) - (start.col(v) - state.origin));
    }
  });
  write_array(text, "Float64", "velocity", 3, count, [&](std::size_t b) {
    const geometry::Points& now = state.polyhedra[b].vertices();
    for (Eigen::Index v = 0; v < now.cols(); ++v) {
      const Vector3 arm = simulation.reference_arm(static_cast<int>(b), state.origin + now.col(v));
      text.vector(velocity_at(state.blocks[b], arm));
    }
  });
  text.raw("</PointData>\n");
}

void write_cell_data(Text& text, const Simulation& simulation) {
  const State& state = simulation.state();
  const std::vector<Block>& blocks = simulation.scene().blocks;
  text.raw("<CellData Scalars=\"block\">\n");
  write_array(text, "Int32", "block", 1, blocks.size(),
              [&](std::size_t b) { text.number(static_cast<long>(b)); });
  write_array(text, "Int32", "kind", 1, blocks.size(),
              [&](std::size_t b) { text.number(static_cast<long>(blocks[b].kind)); });
  write_array(text, "Float64", "speed", 1, blocks.size(),
              [&](std::size_t b) { text.number(state.blocks[b].velocity.norm()); });
  write_array(text, "Float64", "stress", 6, blocks.size(), [&](std::size_t b) {
    text.vector(simulation.stress(static_cast<int>(b)));  // xx yy zz xy yz xz, as VTK orders them
  });
  text.raw("</CellData>\n");
}

template <typename Value>
void contact_array(Text& text, const char* type, const char* name, int components,
                   const std::vector<Contact>& contacts, const Value& value) {
  write_array(text, type, name, components, contacts.size(), [&](std::size_t i) {
    if constexpr (std::is_same_v<decltype(value(contacts[i])), Vector3>) {
      text.vector(value(contacts[i]));
    } else {
      text.number(value(contacts[i]));
    }
  });
}

void write_contact_data(Text& text, const std::vector<Contact>& all) {
  using C = const Contact&;
  text.raw("<PointData Scalars=\"normal_force\">\n");
  contact_array(text, "Int32", "block_a", 1, all, [](C c) -> long { return c.point.key.a; });
  contact_array(text, "Int32", "block_b", 1, all, [](C c) -> long { return c.point.key.b; });
  contact_array(text, "Int32", "type", 1, all, [](C c) { return static_cast<long>(c.point.type); });
  contact_array(text, "Int32", "state", 1, all, [](C c) { return static_cast<long>(c.mode); });
  contact_array(text, "Int32", "failed", 1, all, [](C c) { return static_cast<long>(c.failed); });
  contact_array(text, "Float64", "gap", 1, all, [](C c) { return c.point.gap; });
  contact_array(text, "Float64", "area", 1, all, [](C c) { return c.point.area; });
  contact_array(text, "Float64", "slip", 1, all, [](C c) { return c.slip; });
  contact_array(text, "Float64", "normal_force", 1, all, [](C c) { return c.normal_force; });
  contact_array(text, "Float64", "normal", 3, all, [](C c) -> Vector3 { return c.point.normal; });
  contact_array(text, "Float64", "force_on_b", 3, all, [](C c) -> Vector3 {
    return c.normal_force * c.point.normal - c.shear_force;
  });
  text.raw("</PointData>\n");
}

std::string piece(std::string_view attribute, std::size_t points, std::size_t cells) {
  return "<Piece NumberOfPoints=\"" + std::to_string(points) + "\" " + std::string(attribute) +
         "=\"" + std::to_string(cells) + "\">\n";
}

std::string xml_head(const std::string& type) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
         "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<" + type + ">\n";
}

std::string xml_foot(const std::string& type) { return "</" + type + ">\n</VTKFile>\n"; }

std::size_t vertex_count(const State& state) {
  std::size_t count = 0;
  for (const geometry::Polyhedron& polyhedron : state.polyhedra) {
    count += static_cast<std::size_t>(polyhedron.topology().vertex_count());
  }
  return count;
}

}  // namespace

void write_blocks(const std::string& path, const Simulation& simulation) {
  const State& state = simulation.state();
  Text text(path);
  text.raw(xml_head("UnstructuredGrid"));
  text.raw(piece("NumberOfCells", vertex_count(state), state.polyhedra.size()));
  write_points(text, state);
  write_cells(text, state);
  write_point_data(text, simulation);
  write_cell_data(text, simulation);
  text.raw("</Piece>\n").raw(xml_foot("UnstructuredGrid"));
  text.save();
}

void write_contacts(const std::string& path, const Simulation& simulation) {
  const State& state = simulation.state();
  const std::size_t count = state.contacts.size();
  Text text(path);
  text.raw(xml_head("PolyData")).raw(piece("NumberOfVerts", count, count));
  text.raw("<Points>\n");
  write_array(text, "Float64", "Points", 3, count, [&](std::size_t i) {
    text.vector(state.origin + state.contacts[i].point.point());
  });
  text.raw("</Points>\n<Verts>\n");
  const auto index = [&](std::size_t i) { text.number(static_cast<long>(i)); };
  const auto next = [&](std::size_t i) { text.number(static_cast<long>(i) + 1); };
  write_array(text, "Int64", "connectivity", 1, count, index);
  write_array(text, "Int64", "offsets", 1, count, next);
  text.raw("</Verts>\n");
  write_contact_data(text, state.contacts);
  text.raw("</Piece>\n").raw(xml_foot("PolyData"));
  text.save();
}

void write_series(const std::string& path, const std::vector<double>& times,
                  const std::vector<std::string>& files) {
  Text text(path);
  text.raw(xml_head("Collection"));
  for (std::size_t i = 0; i < files.size(); ++i) {
    text.raw("<DataSet file=\"").raw(files[i]).raw("\" timestep=\"").number(times[i]);
    text.trim().raw("\"/>\n");
  }
  text.raw(xml_foot("Collection"));
  text.save();
}

}  // namespace quoin::solver
