#include <Eigen/Eigenvalues>
#include <bit>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <quoin/solver/output.hpp>
#include <stdexcept>

namespace quoin::solver {
namespace {

/// A VTK XML file with its numbers appended behind the text as they stand in memory: each array is
/// its size in bytes (UInt64), then its bytes.
class Appended {
 public:
  explicit Appended(std::string path) : path_(std::move(path)) {
    static_assert(std::endian::native == std::endian::little);
  }

  Appended& raw(std::string_view text) {
    text_ += text;
    return *this;
  }

  /// One array: `fill` appends `components` numbers for each item.
  template <typename Number, typename Fill>
  void array(std::string_view name, int components, const Fill& fill) {
    text_ += "<DataArray type=\"" + std::string(type_name(Number{})) + "\" Name=\"" +
             std::string(name) + "\" NumberOfComponents=\"" + std::to_string(components) + "\"";
    append(fill, std::vector<Number>());
  }

  /// Of texts, each ended by a zero.
  template <typename Fill>
  void strings(std::string_view name, std::size_t count, const Fill& fill) {
    text_ += "<Array type=\"String\" Name=\"" + std::string(name) + "\" NumberOfTuples=\"" +
             std::to_string(count) + "\"";
    append(fill, std::vector<char>());
  }

  /// Written beside its name, then renamed: a reader never sees half a file.
  void save(std::string_view foot) const {
    const std::string part = path_ + ".part";
    std::ofstream file(part, std::ios::binary);
    file << text_ << "<AppendedData encoding=\"raw\">\n_" << data_ << "\n</AppendedData>\n" << foot;
    file.close();
    if (!file) {
      throw std::runtime_error(part + ": can't be written");
    }
    std::filesystem::rename(part, path_);
  }

 private:
  static std::string_view type_name(double) { return "Float64"; }
  static std::string_view type_name(std::int64_t) { return "Int64"; }
  static std::string_view type_name(std::int32_t) { return "Int32"; }
  static std::string_view type_name(std::uint8_t) { return "UInt8"; }

  template <typename Fill, typename Number>
  void append(const Fill& fill, std::vector<Number> values) {
    text_ += " format=\"appended\" offset=\"" + std::to_string(data_.size()) + "\"/>\n";
    fill(values);
    if constexpr (std::is_same_v<Number, double>) {
      for (const double value : values) {
        if (!std::isfinite(value)) throw std::runtime_error(path_ + ": a value is not finite");
      }
    }
    const std::uint64_t bytes = values.size() * sizeof(Number);
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }

  std::string path_, text_, data_;
};

/// Appends the components of a vector.
void push(std::vector<double>& values, const Eigen::Ref<const Eigen::VectorXd>& vector) {
  values.insert(values.end(), vector.begin(), vector.end());
}

/// One array with a value for each of `count` items.
template <typename Number, typename Value>
void each(Appended& file, std::string_view name, std::size_t count, const Value& value) {
  file.array<Number>(name, 1, [&](std::vector<Number>& values) {
    for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<Number>(value(i)));
  });
}

/// One array with a vector of `components` for each of `count` items.
template <typename Value>
void each_vector(Appended& file, std::string_view name, int components, std::size_t count,
                 const Value& value) {
  file.array<double>(name, components, [&](std::vector<double>& values) {
    for (std::size_t i = 0; i < count; ++i) push(values, value(i));
  });
}

std::size_t vertex_count(const std::vector<Block>& blocks) {
  std::size_t count = 0;
  for (const Block& block : blocks) count += static_cast<std::size_t>(block.shape->vertex_count());
  return count;
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

void write_points(Appended& file, const Simulation& simulation) {
  file.raw("<Points>\n");
  file.array<double>("Points", 3, [&](std::vector<double>& values) {
    for (std::size_t b = 0; b < simulation.scene().blocks.size(); ++b) {
      const geometry::Points vertices = simulation.vertices(static_cast<int>(b));
      for (Eigen::Index v = 0; v < vertices.cols(); ++v) push(values, vertices.col(v));
    }
  });
  file.raw("</Points>\n");
}

/// Face streams of VTK_POLYHEDRON: face count, then for each face its size and its points.
struct FaceStreams {
  std::vector<std::int64_t> values{}, ends{};
};

FaceStreams face_streams(const std::vector<Block>& blocks) {
  FaceStreams streams;
  std::int64_t first = 0;
  for (const Block& block : blocks) {
    const geometry::Topology& topology = block.shape->topology();
    streams.values.push_back(topology.face_count());
    for (int f = 0; f < topology.face_count(); ++f) {
      streams.values.push_back(std::ssize(topology.face(f)));
      for (const int v : topology.face(f)) streams.values.push_back(first + v);
    }
    streams.ends.push_back(std::ssize(streams.values));
    first += topology.vertex_count();
  }
  return streams;
}

void write_cells(Appended& file, const std::vector<Block>& blocks) {
  const std::size_t count = blocks.size(), points = vertex_count(blocks);
  const FaceStreams streams = face_streams(blocks);
  std::int64_t end = 0;
  file.raw("<Cells>\n");
  each<std::int64_t>(file, "connectivity", points, [](std::size_t i) { return i; });
  each<std::int64_t>(file, "offsets", count,
                     [&](std::size_t b) { return end += blocks[b].shape->vertex_count(); });
  each<std::uint8_t>(file, "types", count, [](std::size_t) { return 42; });  // VTK_POLYHEDRON
  each<std::int64_t>(file, "faces", streams.values.size(),
                     [&](std::size_t i) { return streams.values[i]; });
  each<std::int64_t>(file, "faceoffsets", count, [&](std::size_t b) { return streams.ends[b]; });
  file.raw("</Cells>\n");
}

void write_point_data(Appended& file, const Simulation& simulation) {
  const State& state = simulation.state();
  const auto each_vertex = [&](const char* name, const auto& value) {
    file.array<double>(name, 3, [&](std::vector<double>& values) {
      for (std::size_t b = 0; b < state.blocks.size(); ++b) {
        const geometry::Points arms = simulation.reference_arms(static_cast<int>(b));
        for (Eigen::Index v = 0; v < arms.cols(); ++v) push(values, value(b, arms.col(v)));
      }
    });
  };
  file.raw("<PointData Vectors=\"displacement\">\n");
  each_vertex("displacement", [&](std::size_t b, const Vector3& arm) {
    return simulation.displacement(static_cast<int>(b), arm);
  });
  each_vertex("velocity",
              [&](std::size_t b, const Vector3& arm) { return velocity_at(state.blocks[b], arm); });
  file.raw("</PointData>\n");
}

/// The largest first, tension positive.
Vector3 principal(const Vector6& stress) {
  Matrix3 matrix;
  matrix << stress[0], stress[3], stress[5], stress[3], stress[1], stress[4], stress[5], stress[4],
      stress[2];
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(matrix, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().reverse();
}

void write_cell_data(Appended& file, const Simulation& simulation) {
  const State& state = simulation.state();
  const std::vector<Block>& blocks = simulation.scene().blocks;
  const std::size_t count = blocks.size();
  const auto stress = [&](std::size_t b) { return simulation.stress(static_cast<int>(b)); };
  file.raw("<CellData Scalars=\"block\">\n");
  each<std::int32_t>(file, "block", count, [](std::size_t b) { return b; });
  each<std::int32_t>(file, "kind", count,
                     [&](std::size_t b) { return static_cast<int>(blocks[b].kind); });
  each<std::int32_t>(file, "material", count,
                     [&](std::size_t b) { return blocks[b].material.joint_group; });
  each<double>(file, "speed", count,
               [&](std::size_t b) { return state.blocks[b].velocity.norm(); });
  // xx yy zz xy yz xz, as VTK orders them
  each_vector(file, "stress", 6, count, stress);
  each_vector(file, "principal_stress", 3, count,
              [&](std::size_t b) { return principal(stress(b)); });
  const auto write_texts = [&](const char* name, const auto& text) {
    file.strings(name, count, [&](std::vector<char>& values) {
      for (const Block& block : blocks) {
        values.insert(values.end(), text(block).begin(), text(block).end());
        values.push_back(0);
      }
    });
  };
  write_texts("name", [](const Block& block) -> const std::string& { return block.name; });
  write_texts("material_name",
              [](const Block& block) -> const std::string& { return block.material.name; });
  file.raw("</CellData>\n");
}

void write_contact_data(Appended& file, const std::vector<Contact>& all) {
  const std::size_t count = all.size();
  const auto integers = [&](const char* name, const auto& value) {
    each<std::int32_t>(file, name, count,
                       [&](std::size_t i) { return static_cast<int>(value(all[i])); });
  };
  const auto numbers = [&](const char* name, const auto& value) {
    each<double>(file, name, count, [&](std::size_t i) { return value(all[i]); });
  };
  using C = const Contact&;
  file.raw("<PointData Scalars=\"normal_force\">\n");
  integers("block_a", [](C c) { return c.point.key.a; });
  integers("block_b", [](C c) { return c.point.key.b; });
  integers("type", [](C c) { return c.point.type; });
  integers("state", [](C c) { return c.mode; });
  integers("failed", [](C c) { return c.failed; });
  numbers("gap", [](C c) { return c.point.gap; });
  numbers("area", [](C c) { return c.point.area; });
  numbers("slip", [](C c) { return c.slip; });
  numbers("normal_force", [](C c) { return c.normal_force; });
  numbers("shear_force", [](C c) { return c.shear_force.norm(); });
  each_vector(file, "normal", 3, count, [&](std::size_t i) { return all[i].point.normal; });
  each_vector(file, "force_on_b", 3, count, [&](std::size_t i) -> Vector3 {
    return all[i].normal_force * all[i].point.normal - all[i].shear_force;
  });
  file.raw("</PointData>\n");
}

std::string piece(std::string_view attribute, std::size_t points, std::size_t cells) {
  return "<Piece NumberOfPoints=\"" + std::to_string(points) + "\" " + std::string(attribute) +
         "=\"" + std::to_string(cells) + "\">\n";
}

std::string xml_head(const std::string& type) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
         "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<" + type + ">\n";
}

}  // namespace

void write_blocks(const std::string& path, const Simulation& simulation) {
  const std::vector<Block>& blocks = simulation.scene().blocks;
  Appended file(path);
  file.raw(xml_head("UnstructuredGrid"));
  file.raw(piece("NumberOfCells", vertex_count(blocks), blocks.size()));
  write_points(file, simulation);
  write_cells(file, blocks);
  write_point_data(file, simulation);
  write_cell_data(file, simulation);
  file.raw("</Piece>\n</UnstructuredGrid>\n");
  file.save("</VTKFile>\n");
}

void write_contacts(const std::string& path, const Simulation& simulation) {
  const State& state = simulation.state();
  const std::size_t count = state.contacts.size();
  Appended file(path);
  file.raw(xml_head("PolyData")).raw(piece("NumberOfVerts", count, count)).raw("<Points>\n");
  each_vector(file, "Points", 3, count, [&](std::size_t i) -> Vector3 {
    return state.origin + state.contacts[i].point.point();
  });
  file.raw("</Points>\n<Verts>\n");
  each<std::int64_t>(file, "connectivity", count, [](std::size_t i) { return i; });
  each<std::int64_t>(file, "offsets", count, [](std::size_t i) { return i + 1; });
  file.raw("</Verts>\n");
  write_contact_data(file, state.contacts);
  file.raw("</Piece>\n</PolyData>\n");
  file.save("</VTKFile>\n");
}

void write_series(const std::string& path, const std::vector<double>& times,
                  const std::vector<std::string>& files) {
  std::string text = xml_head("Collection");
  for (std::size_t i = 0; i < files.size(); ++i) {
    char time[32];
    const auto end = std::to_chars(time, time + sizeof time, times[i]).ptr;
    text += "<DataSet file=\"" + files[i] + "\" timestep=\"" + std::string(time, end) + "\"/>\n";
  }
  text += "</Collection>\n</VTKFile>\n";
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary);
  file << text;
  file.close();
  if (!file) {
    throw std::runtime_error(part + ": can't be written");
  }
  std::filesystem::rename(part, path);
}

}  // namespace quoin::solver
