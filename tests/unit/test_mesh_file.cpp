/// Files of other programs: what blocks they make, and what is said of bad ones (imports.jsonl).

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <quoin/geometry/mass_properties.hpp>

#include "scene_file/mesh_file.hpp"
#include "scene_file/moved_hulls.hpp"
#include "scene_file/read_json.hpp"
#include "support/catch.hpp"
#include "support/json_lines.hpp"

using namespace quoin;
using namespace quoin::tests;
using nlohmann::json;
using scene_file::convex_block;
using scene_file::MeshBlock;

namespace {

namespace fs = std::filesystem;

std::vector<MeshBlock> read(const std::string& path) {
  return scene_file::read_mesh_file(path, scene_file::mesh_format(path, ""));
}

/// Each value that a case states of a block, by the names of imports.jsonl.
void check_block(const std::vector<MeshBlock>& blocks, std::size_t b, const json& expected,
                 const json& line) {
  const MeshBlock& mesh = blocks[b];
  double taken = 0.0;
  const geometry::Shape shape = convex_block(mesh, line.value("tolerance", -1.0), &taken);
  const json found = {{"id", mesh.id},
                      {"name", mesh.name},
                      {"body", mesh.body},
                      {"support", mesh.is_support},
                      {"parts", scene_file::meshes_of_block(blocks, b).size()},
                      {"faces", shape.topology().face_count()},
                      {"vertices", mesh.vertices.cols()},
                      {"density", mesh.density},
                      {"rounding", mesh.rounding},
                      {"taken", taken},
                      {"volume", geometry::mass_properties(shape).volume}};
  const auto near = [&](double value, double wanted) {
    CHECK_THAT(value, WithinRel(wanted, line.value("within", 1e-12)) || WithinAbs(wanted, 1e-14));
  };
  for (const auto& [name, value] : expected.items()) {
    INFO(name);
    if (value.is_array()) {  // a place
      geometry::Vector3 place = mesh.vertices.rowwise().minCoeff();
      if (name == "max") place = mesh.vertices.rowwise().maxCoeff();
      if (name.starts_with("vertex_")) place = mesh.vertices.col(std::stoi(name.substr(7)));
      for (int i = 0; i < 3; ++i)
        if (!value[i].is_null()) near(place[i], value[i]);
    } else if (found.at(name).is_number_float()) {
      near(found.at(name), value);
    } else {
      CHECK(found.at(name) == value);
    }
  }
}

void check_file(const std::string& path, const json& line) {
  const std::vector<MeshBlock> blocks = read(path);
  if (line.contains("blocks")) REQUIRE(blocks.size() == line["blocks"].size());
  for (std::size_t b = 0; b < blocks.size(); ++b)
    check_block(blocks, b, line.contains("blocks") ? line["blocks"][b] : json::object(), line);
}

/// A unit cube with a slanting top, as a mesh of quadrilaterals.
MeshBlock cube_mesh() {
  MeshBlock mesh{.id = "cube", .vertices = geometry::Points(3, 8), .faces = {}};
  mesh.vertices << 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 1.5, 1.5;
  mesh.faces = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  return mesh;
}

}  // namespace

TEST_CASE("imports: each file makes its blocks, or one line says what is wrong and where") {
  const fs::path folder = fs::temp_directory_path() / "quoin_test_imports",
                 files = folder / "files";
  for_each_line(QUOIN_SOURCE_DIR "/tests/unit/imports.jsonl", 78, [&](const json& line) {
    fs::remove_all(folder);
    fs::create_directories(files);
    fs::create_directories(folder / "meshes");
    const auto write = [&](const std::string& name, const std::string& content, int times) {
      std::ofstream out(files / name);
      for (int i = 0; i < times; ++i) out << content;
    };
    write(line["file"], line["text"], line.value("times", 1));
    const json beside = line.value("beside", json::object());
    for (const auto& [name, content] : beside.items()) write(name, content, 1);
    const std::string path = files / line["file"].get<std::string>();
    INFO(line["what"] << ": " << path);
    if (line.contains("said"))
      CHECK_THROWS_WITH(check_file(path, line), ContainsSubstring(line["said"].get<std::string>()));
    else
      CHECK_NOTHROW(check_file(path, line));
  });
  fs::remove_all(folder);
  CHECK_THROWS_WITH(read("none.json"), ContainsSubstring("can't be read"));
}

TEST_CASE("files of other programs: two boxes that share an edge and a part of a face") {
  const json two = json::parse(R"({"within": 1e-14, "blocks": [
      {"volume": 1.0, "faces": 6, "vertices": 8}, {"volume": 0.5, "faces": 6, "vertices": 8}]})");
  int files = 0;
  for (const auto& entry : fs::directory_iterator(QUOIN_SOURCE_DIR "/tests/unit/meshes")) {
    if (entry.path().extension() == ".py") continue;
    INFO(entry.path());
    ++files;
    check_file(entry.path().string(), two);
  }
  CHECK(files == 18);
}

TEST_CASE("a mesh that is an earlier one moved, exactly, takes over its topology") {
  scene_file::MovedHulls hulls;
  int made = 0;
  const auto made_for = [&](const geometry::Vector3& shift) {
    MeshBlock mesh = cube_mesh();
    mesh.vertices.colwise() += shift;
    const int before = made;
    const auto make = [&] {
      ++made;
      return convex_block(mesh, -1);
    };
    const geometry::Shape shape = hulls.shape_of(mesh, make), whole = convex_block(mesh, -1);
    CHECK(shape.vertices() == whole.vertices());
    CHECK(std::ranges::equal(shape.topology().triangles(), whole.topology().triangles()));
    REQUIRE(shape.topology().face_count() == whole.topology().face_count());
    for (int f = 0; f < whole.topology().face_count(); ++f)
      CHECK(std::ranges::equal(shape.topology().face(f), whole.topology().face(f)));
    return made - before;
  };
  CHECK(made_for({0, 0, 0}) == 1);
  CHECK(made_for({3, -2, 0.25}) == 0);
  CHECK(made_for({0.1, 0, 0}) == 1);  // 1.1 - 0.1 rounds
  CHECK(made_for({1e9, 0, 0}) == 1);  // exact, but its labels are coarser
  CHECK(made_for({1e9, 8, 0}) == 0);
}
