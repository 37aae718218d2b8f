#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <quoin/solver/output.hpp>
#include <stdexcept>

#include "base/index.hpp"
#include "block/displacement.hpp"
#include "contact/contact_history.hpp"
#include "contact/joint_law.hpp"
#include "linear/small_matrices.hpp"

namespace quoin::solver {
namespace {

/// With the reason of the call that failed last.
std::runtime_error unwritable(const std::string& path) {
  return std::runtime_error(path + ": can't be written" +
                            (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
}

/// From where it was written beside its name; nothing is left where that can't be.
void publish(const std::string& path) {
  const std::string part = path + ".part";
  std::error_code failed, ignored;
  std::filesystem::rename(part, path, failed);
  if (!failed) return;
  std::filesystem::remove(part, ignored);
  errno = failed.value();
  throw unwritable(path);
}

/// A VTK XML file with its numbers appended behind the text as they stand in memory: each array is
/// its size in bytes (UInt64), then its bytes. The arrays go to the file one by one; the text,
/// which says where they are, comes last into the room that was left for it. The file is written
/// beside its name, then renamed: a reader never sees half of it.
class Appended {
 public:
  explicit Appended(std::string path)
      : path_(std::move(path)), file_(path_ + ".part", std::ios::binary) {
    static_assert(std::endian::native == std::endian::little);
    file_ << std::string(kTextRoom, ' ');
  }

  Appended& raw(std::string_view text) {
    text_ += text;
    return *this;
  }

  /// One array: `fill` appends `components` numbers for each of `count` items.
  template <typename Number, typename Fill>
  void array(std::string_view name, int components, std::size_t count, const Fill& fill) {
    text_ += "<DataArray type=\"" + std::string(type_name(Number{})) + "\" Name=\"" +
             std::string(name) + "\" NumberOfComponents=\"" + std::to_string(components) + "\"";
    append<Number>(fill, count * static_cast<std::size_t>(components));
  }

  /// Of texts, each ended by a zero.
  template <typename Fill>
  void strings(std::string_view name, std::size_t count, const Fill& fill) {
    text_ += "<Array type=\"String\" Name=\"" + std::string(name) + "\" NumberOfTuples=\"" +
             std::to_string(count) + "\"";
    append<char>(fill, 16 * count);
  }

  void save(std::string_view foot) {
    const std::string_view mark = "<AppendedData encoding=\"raw\">\n_";
    if (text_.size() + mark.size() > kTextRoom)
      throw std::runtime_error(path_ + ": too many arrays");
    text_.append(kTextRoom - mark.size() - text_.size(), ' ').append(mark);
    file_ << "\n</AppendedData>\n" << foot;
    file_.seekp(0);
    file_ << text_;
    file_.close();
    if (!file_) throw unwritable(path_ + ".part");
    publish(path_);
  }

 private:
  static std::string_view type_name(double) { return "Float64"; }
  static std::string_view type_name(std::int64_t) { return "Int64"; }
  static std::string_view type_name(std::int32_t) { return "Int32"; }
  static std::string_view type_name(std::uint8_t) { return "UInt8"; }

  static constexpr std::size_t kTextRoom =
      8192;  // a line of some 90 characters for each of 20 arrays

  template <typename Number, typename Fill>
  void append(const Fill& fill, std::size_t likely_size) {
    text_ += " format=\"appended\" offset=\"" + std::to_string(data_size_) + "\"/>\n";
    std::vector<Number> values;
    values.reserve(likely_size);
    fill(values);
    if constexpr (std::is_same_v<Number, double>) {
      for (const double value : values)
        if (!std::isfinite(value)) throw std::runtime_error(path_ + ": a value is not finite");
    }
    const std::uint64_t bytes = values.size() * sizeof(Number);
    file_.write(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    file_.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(bytes));
    data_size_ += sizeof bytes + bytes;
  }

  std::string path_, text_;
  std::ofstream file_;
  std::uint64_t data_size_ = 0;
};

/// Appends the components of a vector.
template <int kSize>
void push(std::vector<double>& values, const Eigen::Matrix<double, kSize, 1>& vector) {
  values.insert(values.end(), vector.begin(), vector.end());
}

/// One array with a value for each of `count` items.
template <typename Number, typename Value>
void each(Appended& file, std::string_view name, std::size_t count, const Value& value) {
  file.array<Number>(name, 1, count, [&](std::vector<Number>& values) {
    for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<Number>(value(i)));
  });
}

/// One array with a vector of `components` for each of `count` items.
template <typename Value>
void each_vector(Appended& file, std::string_view name, int components, std::size_t count,
                 const Value& value) {
  file.array<double>(name, components, count, [&](std::vector<double>& values) {
    for (std::size_t i = 0; i < count; ++i) push(values, value(i));
  });
}

/// The blocks of a file, ascending.
struct Shown {
  const Simulation& simulation;
  std::vector<std::size_t> blocks;

  Shown(const Simulation& all, const Piece& piece) : simulation(all) {
    for (std::size_t b = 0; b < all.scene().blocks.size(); ++b)
      if (has(piece, static_cast<int>(b))) blocks.push_back(b);
  }
  static bool has(const Piece& piece, int block) {
    return piece.part_of_block.empty() || piece.part_of_block[index(block)] == piece.part;
  }
  std::size_t count() const { return blocks.size(); }
  const Block& block(std::size_t i) const { return simulation.scene().blocks[blocks[i]]; }
  const BlockState& state(std::size_t i) const { return simulation.state().blocks[blocks[i]]; }
  int number(std::size_t i) const { return static_cast<int>(blocks[i]); }
};

std::size_t vertex_count(const Shown& shown) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < shown.count(); ++i)
    count += static_cast<std::size_t>(shown.block(i).shape->vertex_count());
  return count;
}

/// Velocity of the material point with reference arm X: v + R (omega × (I + eps) X + eps' X).
Vector3 velocity_at(const BlockState& block, const Vector3& arm) {
  const Vector3 strained = arm + strain_matrix(block.strain) * arm;
  const Vector3 local =
      block.angular_velocity.cross(strained) + strain_matrix(block.strain_rate) * arm;
  return block.velocity + block.rotation * local;
}

void write_points(Appended& file, const Shown& shown) {
  file.raw("<Points>\n");
  file.array<double>("Points", 3, vertex_count(shown), [&](std::vector<double>& values) {
    for (std::size_t i = 0; i < shown.count(); ++i) {
      const geometry::Points vertices = shown.simulation.vertices(shown.number(i));
      for (Eigen::Index v = 0; v < vertices.cols(); ++v) push<3>(values, vertices.col(v));
    }
  });
  file.raw("</Points>\n");
}

/// Face streams of VTK_POLYHEDRON: face count, then for each face its size and its points.
struct FaceStreams {
  std::vector<std::int64_t> values{}, ends{};
};

FaceStreams face_streams(const Shown& shown) {
  FaceStreams streams;
  std::int64_t first = 0;
  for (std::size_t i = 0; i < shown.count(); ++i) {
    const geometry::Topology& topology = shown.block(i).shape->topology();
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

void write_cells(Appended& file, const Shown& shown) {
  const std::size_t count = shown.count(), points = vertex_count(shown);
  FaceStreams streams = face_streams(shown);
  std::int64_t end = 0;
  file.raw("<Cells>\n");
  each<std::int64_t>(file, "connectivity", points, [](std::size_t i) { return i; });
  each<std::int64_t>(file, "offsets", count,
                     [&](std::size_t i) { return end += shown.block(i).shape->vertex_count(); });
  each<std::uint8_t>(file, "types", count, [](std::size_t) { return 42; });  // VTK_POLYHEDRON
  file.array<std::int64_t>("faces", 1, 0, [&](std::vector<std::int64_t>& values) {
    values = std::move(streams.values);
  });
  each<std::int64_t>(file, "faceoffsets", count, [&](std::size_t i) { return streams.ends[i]; });
  file.raw("</Cells>\n");
}

void write_point_data(Appended& file, const Shown& shown, std::span<const BlockState> from) {
  const Simulation& simulation = shown.simulation;
  const State& state = simulation.state();
  const std::size_t count = vertex_count(shown);
  const auto each_vertex = [&](const char* name, const auto& value) {
    file.array<double>(name, 3, count, [&](std::vector<double>& values) {
      for (const std::size_t b : shown.blocks) {
        const geometry::Points arms = simulation.reference_arms(static_cast<int>(b));
        for (Eigen::Index v = 0; v < arms.cols(); ++v) push<3>(values, value(b, arms.col(v)));
      }
    });
  };
  file.raw("<PointData Vectors=\"displacement\">\n");
  each_vertex("displacement", [&](std::size_t b, const Vector3& arm) -> Vector3 {
    if (from.empty()) return simulation.displacement(static_cast<int>(b), arm);
    const Pose start = pose(from[b]), now = pose(state.blocks[b]);
    return between(start, now) + (now.shape - start.shape) * arm;
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
  return eigenvalues(matrix).reverse();
}

constexpr int kHiddenCell = 32;  // vtkDataSetAttributes::HIDDENCELL

bool is_absent(const Block& block) { return block.kind == BlockKind::Absent; }

void write_cell_data(Appended& file, const Shown& shown) {
  const std::size_t count = shown.count();
  const auto stress = [&](std::size_t i) { return shown.simulation.stress(shown.number(i)); };
  file.raw("<CellData Scalars=\"block\">\n");
  each<std::int32_t>(file, "block", count, [&](std::size_t i) { return shown.number(i); });
  each<std::int32_t>(file, "kind", count,
                     [&](std::size_t i) { return static_cast<int>(shown.block(i).kind); });
  each<std::int32_t>(file, "material", count,
                     [&](std::size_t i) { return shown.block(i).material.joint_group; });
  if (std::ranges::any_of(shown.simulation.scene().blocks, is_absent)) {
    each<std::uint8_t>(file, "vtkGhostType", count,
                       [&](std::size_t i) { return is_absent(shown.block(i)) ? kHiddenCell : 0; });
  }
  each<double>(file, "speed", count, [&](std::size_t i) { return shown.state(i).velocity.norm(); });
  // xx yy zz xy yz xz, as VTK orders them
  each_vector(file, "stress", 6, count, stress);
  each_vector(file, "principal_stress", 3, count,
              [&](std::size_t i) { return principal(stress(i)); });
  const auto write_texts = [&](const char* name, const auto& text) {
    file.strings(name, count, [&](std::vector<char>& values) {
      for (std::size_t i = 0; i < count; ++i) {
        const std::string& shown_text = text(shown.block(i));
        values.insert(values.end(), shown_text.begin(), shown_text.end());
        values.push_back(0);
      }
    });
  };
  write_texts("name", [](const Block& block) -> const std::string& { return block.name; });
  write_texts("material_name",
              [](const Block& block) -> const std::string& { return block.material.name; });
  file.raw("</CellData>\n");
}

void write_contact_data(Appended& file, const Scene& scene, std::span<const Contact> all) {
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
  integers("failed", [&](C c) { return has_failed(scene, c); });
  numbers("gap", [](C c) { return c.point.gap; });
  numbers("area", [](C c) { return c.area(); });
  numbers("slip", [](C c) { return c.slip; });
  numbers("normal_force", [](C c) { return c.normal_force; });
  numbers("shear_force", [](C c) { return c.shear_force.norm(); });
  each_vector(file, "normal", 3, count, [&](std::size_t i) { return all[i].point.normal; });
  each_vector(file, "force_on_b", 3, count, [&](std::size_t i) { return force_on_b(all[i]); });
  file.raw("</PointData>\n");
}

std::string piece_tag(std::string_view attribute, std::size_t points, std::size_t cells) {
  return "<Piece NumberOfPoints=\"" + std::to_string(points) + "\" " + std::string(attribute) +
         "=\"" + std::to_string(cells) + "\">\n";
}

std::string xml_head(const std::string& type) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
         "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<" + type + ">\n";
}

}  // namespace

namespace {

void check_by_block(const std::string& path, const Simulation& simulation, std::size_t count,
                    const char* what) {
  const std::size_t blocks = simulation.scene().blocks.size();
  if (count == 0 || count == blocks) return;
  throw InputError(path + ": " + std::to_string(count) + ' ' + what + " are given for " +
                   std::to_string(blocks) + " blocks");
}

}  // namespace

void write_blocks(const std::string& path, const Simulation& simulation,
                  std::span<const BlockState> from, const Piece& piece) {
  check_by_block(path, simulation, from.size(), "places");
  check_by_block(path, simulation, piece.part_of_block.size(), "parts");
  const Shown shown(simulation, piece);
  Appended file(path);
  file.raw(xml_head("UnstructuredGrid"));
  file.raw(piece_tag("NumberOfCells", vertex_count(shown), shown.count()));
  write_points(file, shown);
  write_cells(file, shown);
  write_point_data(file, shown, from);
  write_cell_data(file, shown);
  file.raw("</Piece>\n</UnstructuredGrid>\n");
  file.save("</VTKFile>\n");
}

bool has_failed(const Scene& scene, const Contact& contact) {
  const geometry::ContactKey& key = contact.point.key;
  return contact.failed && can_fail(joint_between(scene, key.a, key.b));
}

void write_contacts(const std::string& path, const Simulation& simulation, const Piece& piece) {
  check_by_block(path, simulation, piece.part_of_block.size(), "parts");
  const State& state = simulation.state();
  std::span<const Contact> shown = state.contacts;
  std::vector<Contact> own;
  if (!piece.part_of_block.empty()) {
    const auto can_move = [&](int block) {
      const BlockKind kind = simulation.scene().blocks[index(block)].kind;
      return kind == BlockKind::Rigid || kind == BlockKind::Deformable;
    };
    std::ranges::copy_if(shown, std::back_inserter(own), [&](const Contact& contact) {
      const geometry::ContactKey& key = contact.point.key;
      return Shown::has(piece, can_move(key.a) ? key.a : key.b);
    });
    shown = own;
  }
  const std::size_t count = shown.size();
  Appended file(path);
  file.raw(xml_head("PolyData")).raw(piece_tag("NumberOfVerts", count, count)).raw("<Points>\n");
  each_vector(file, "Points", 3, count,
              [&](std::size_t i) -> Vector3 { return state.origin + shown[i].point.point(); });
  file.raw("</Points>\n<Verts>\n");
  each<std::int64_t>(file, "connectivity", count, [](std::size_t i) { return i; });
  each<std::int64_t>(file, "offsets", count, [](std::size_t i) { return i + 1; });
  file.raw("</Verts>\n");
  write_contact_data(file, simulation.scene(), shown);
  file.raw("</Piece>\n</PolyData>\n");
  file.save("</VTKFile>\n");
}

namespace {

/// Where an end of a tie is now.
Vector3 tie_end(const Simulation& simulation, int block, const Vector3& at_start) {
  if (block < 0) return at_start;
  const Vector3 centroid = world_point(simulation.state(), block, Vector3::Zero()) -
                           simulation.displacement(block, Vector3::Zero());
  return at_start + simulation.displacement(block, at_start - centroid);
}

}  // namespace

void write_ties(const std::string& path, const Simulation& simulation) {
  const std::vector<Tie>& ties = simulation.scene().ties;
  const std::vector<TieState>& states = simulation.state().ties;
  const std::size_t count = ties.size();
  Appended file(path);
  file.raw(xml_head("PolyData")).raw(piece_tag("NumberOfLines", 2 * count, count));
  file.raw("<Points>\n");
  each_vector(file, "Points", 3, 2 * count, [&](std::size_t i) -> Vector3 {
    const Tie& tie = ties[i / 2];
    return i % 2 == 0 ? tie_end(simulation, tie.a, tie.point_a)
                      : tie_end(simulation, tie.b, tie.point_b);
  });
  file.raw("</Points>\n<Lines>\n");
  each<std::int64_t>(file, "connectivity", 2 * count, [](std::size_t i) { return i; });
  each<std::int64_t>(file, "offsets", count, [](std::size_t i) { return 2 * i + 2; });
  file.raw("</Lines>\n<CellData>\n");
  each<double>(file, "force", count, [&](std::size_t i) { return states[i].force; });
  each<double>(file, "elongation", count,
               [&](std::size_t i) { return states[i].length - states[i].rest_length; });
  each<double>(file, "plastic", count, [&](std::size_t i) { return states[i].plastic; });
  each<std::uint8_t>(file, "broken", count, [&](std::size_t i) { return states[i].broken; });
  file.raw("</CellData>\n</Piece>\n</PolyData>\n");
  file.save("</VTKFile>\n");
}

namespace {

/// Throws std::runtime_error when it can't be written.
void write_whole(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw unwritable(part);
  publish(path);
}

/// What an index says of the arrays: those of a piece's points, point data and cell data, without
/// their numbers. `text`: of the piece.
std::string declared_arrays(std::istream& text) {
  static constexpr std::string_view kSections[] = {"Points", "PointData", "CellData"};
  std::string result, line;
  bool inside = false;
  while (std::getline(text, line) && line.find("<AppendedData") == line.npos) {
    const std::string_view rest =
        std::string_view(line).substr(std::min<std::size_t>(1, line.size()));
    const bool ends = rest.starts_with('/');
    const bool is_section = std::ranges::any_of(kSections, [&](std::string_view section) {
      return rest.substr(ends ? 1 : 0).starts_with(section);
    });
    if (is_section) {
      inside = !ends;
      result += (ends ? "</P" : "<P") + std::string(rest.substr(ends ? 1 : 0)) + "\n";
    } else if (inside) {
      const std::size_t end = std::min(rest.find(" NumberOfTuples"), rest.find(" format"));
      result += "<P" + std::string(rest.substr(0, end)) + "/>\n";
    }
  }
  return result;
}

}  // namespace

void write_index(const std::string& path, const std::vector<std::string>& pieces) {
  if (pieces.empty()) throw InputError(path + ": an index needs at least one piece");
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const std::string first = (folder / pieces.front()).string();
  std::ifstream like(first, std::ios::binary);
  const std::string arrays = declared_arrays(like);
  if (!like) throw std::runtime_error(first + ": can't be read");
  const std::string type = path.ends_with(".pvtp") ? "PPolyData" : "PUnstructuredGrid";
  std::string text = xml_head(type) + arrays;
  for (const std::string& piece : pieces) text += "<Piece Source=\"" + piece + "\"/>\n";
  write_whole(path, text + "</" + type + ">\n</VTKFile>\n");
}

namespace {

/// As the value of an attribute in XML.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text)
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  return result;
}

}  // namespace

void write_series(const std::string& path, const std::vector<double>& times,
                  const std::vector<std::string>& files) {
  if (times.size() != files.size()) {
    throw InputError(path + ": " + std::to_string(times.size()) + " times are given for " +
                     std::to_string(files.size()) + " files");
  }
  std::string text = xml_head("Collection");
  for (std::size_t i = 0; i < files.size(); ++i) {
    char time[32];
    const auto end = std::to_chars(time, time + sizeof time, times[i]).ptr;
    text += "<DataSet file=\"" + escaped(files[i]) + "\" timestep=\"" + std::string(time, end) +
            "\"/>\n";
  }
  text += "</Collection>\n</VTKFile>\n";
  write_whole(path, text);
}

}  // namespace quoin::solver
