#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <quoin/geometry/mass_properties.hpp>

#include "scene_file/mesh_file.hpp"
#include "scene_file/moved_hulls.hpp"
#include "scene_file/scene_error.hpp"
#include "scene_file/scene_file.hpp"
#include "support/catch.hpp"

using namespace quoin;
using namespace quoin::tests;
using scene_file::convex_block;
using scene_file::MeshBlock;

namespace {

namespace fs = std::filesystem;

/// A unit cube with its faces as quadrilaterals; the one on top moved to `top`.
MeshBlock cube_mesh(const std::vector<geometry::Vector3>& top) {
  MeshBlock mesh{.id = "cube", .vertices = geometry::Points(3, 8), .faces = {}};
  const double corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int i = 0; i < 4; ++i) {
    mesh.vertices.col(i) << corners[i][0], corners[i][1], 0;
    mesh.vertices.col(4 + i) = top[static_cast<std::size_t>(i)];
  }
  mesh.faces = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  return mesh;
}

const std::vector<geometry::Vector3> kFlat = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& text)
      : path_(fs::temp_directory_path() / name) {
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { fs::remove(path_); }
  std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

std::vector<MeshBlock> read(const std::string& path) {
  return scene_file::read_mesh_file(path, scene_file::mesh_format(path, ""));
}

}  // namespace

TEST_CASE("a convex mesh becomes its hull") {
  const geometry::Shape block = convex_block(cube_mesh(kFlat), -1);
  CHECK_THAT(geometry::mass_properties(block).volume, WithinRel(1.0, 1e-14));
  CHECK(block.topology().face_count() == 6);
}

TEST_CASE("a warped face passes within its tolerance only") {
  std::vector<geometry::Vector3> top = kFlat;
  top[2].z() = 1.01;  // the diagonals of the top are now 5 mm apart in the middle
  CHECK_THROWS_WITH(convex_block(cube_mesh(top), -1), ContainsSubstring("is not convex"));
  CHECK_THROWS_WITH(convex_block(cube_mesh(top), 1e-4), ContainsSubstring("0.0001 m"));
  CHECK(convex_block(cube_mesh(top), 0.01).topology().face_count() >= 7);
}

TEST_CASE("an open mesh and a dented one are refused") {
  MeshBlock open = cube_mesh(kFlat);
  open.faces.pop_back();
  CHECK_THROWS_WITH(convex_block(open, -1), ContainsSubstring("is not closed"));
  MeshBlock dented = cube_mesh(kFlat);
  dented.vertices.conservativeResize(3, 9);
  dented.vertices.col(8) << 0.5, 0.5, 0.7;
  dented.faces[1] = {4, 5, 8};
  dented.faces.insert(dented.faces.end(), {{5, 6, 8}, {6, 7, 8}, {7, 4, 8}});
  CHECK_THROWS_WITH(convex_block(dented, -1), ContainsSubstring("0.3 m below its convex hull"));
}

TEST_CASE("OBJ: objects, negative indices, texture indices, faults by line") {
  const TemporaryFile file("quoin_test.obj", R"(# two tetrahedra
o first
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1/1 2/2 4/3
f 2//1 3//1 4//1
f 3 1 4
o second
v 5 0 0
v 6 0 0
v 5 1 0
v 5 0 2
f -4 -2 -3
f -4 -3 -1
f -3 -2 -1
f -2 -4 -1
)");
  const std::vector<MeshBlock> blocks = read(file.path());
  REQUIRE(blocks.size() == 2);
  CHECK(blocks[0].id == "first");
  CHECK_THAT(geometry::mass_properties(convex_block(blocks[0], -1)).volume,
             WithinRel(1.0 / 6, 1e-12));
  CHECK_THAT(geometry::mass_properties(convex_block(blocks[1], -1)).volume,
             WithinRel(1.0 / 3, 1e-12));
}

TEST_CASE("solids of a modeller that computes in floats are convex to 1e-4 of their size") {
  // A cube of 1 m, one corner of which lies so deep in its top: the top is two triangles.
  const auto cube = [](const char* format, double depth) {
    std::string text;
    for (int v = 0; v < 8; ++v) {
      char line[99];
      std::snprintf(line, sizeof line, format, v & 1, v >> 1 & 1, (v >> 2) - (v == 7) * depth);
      text += line;
    }
    return TemporaryFile("quoin_floats.obj",
                         text +
                             "f 1 3 4 2\nf 5 6 7\nf 6 8 7\nf 1 2 6 5\nf 3 7 8 4\n"
                             "f 1 5 7 3\nf 2 4 8 6\n");
  };
  const auto taken = [](const TemporaryFile& file) {
    double depth = 0.0;
    convex_block(read(file.path())[0], -1, &depth);
    return depth;
  };
  CHECK(taken(cube("v %d.0 %d.0 %.6f\n", 0.0)) == 0.0);
  CHECK_THAT(taken(cube("v %d.0 %d.0 %.6f\n", -2e-4)), WithinRel(1e-4, 1e-2));
  CHECK_THROWS_WITH(taken(cube("v %d.0 %d.0 %.6f\n", -1e-3)), ContainsSubstring("is not convex"));
  CHECK_THROWS_WITH(taken(cube("v %d.0 %d.0 %.12f\n", -2e-4)), ContainsSubstring("is not convex"));
}

TEST_CASE("a solid whose coordinates have six digits is as convex as these tell") {
  constexpr int kSides = 12;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, geometry::Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const auto prism = [&](const char* format) {
    std::string text = "o prism\n";
    for (int i = 0; i < 2 * kSides; ++i) {
      const double angle = 2 * M_PI * (i % kSides) / kSides;
      const geometry::Vector3 place =
          geometry::Vector3(80, -45, 60) +
          turn * geometry::Vector3(std::cos(angle), std::sin(angle), i / kSides);
      char line[99];
      std::snprintf(line, sizeof line, format, place.x(), place.y(), place.z());
      text += line;
    }
    std::string bottom = "f", top = "f";
    for (int i = 0; i < kSides; ++i) {
      const int next = (i + 1) % kSides;
      bottom += " " + std::to_string(kSides - i);
      top += " " + std::to_string(kSides + i + 1);
      for (const int corner : {i, next, next + kSides, i + kSides}) {
        text += (corner == i ? "f " : " ") + std::to_string(corner + 1);
      }
      text += "\n";
    }
    return TemporaryFile("quoin_six_digits.obj", text + bottom + "\n" + top + "\n");
  };
  const TemporaryFile six = prism("v %.6g %.6g %.6g\n");
  MeshBlock mesh = read(six.path())[0];
  CHECK_THAT(mesh.rounding, WithinRel(0.5e-4, 1e-12));
  CHECK_THAT(geometry::mass_properties(convex_block(mesh, -1)).volume,
             WithinAbs(6 * std::sin(M_PI / 6), 1e-3));
  CHECK_THROWS_WITH(convex_block(mesh, 1e-6), ContainsSubstring("is not convex"));
  mesh.vertices.col(0) += 1e-2 * turn.col(2);  // a dent that no rounding explains
  CHECK_THROWS_WITH(convex_block(mesh, -1), ContainsSubstring("is not convex"));
  const TemporaryFile doubles = prism("v %.17g %.17g %.17g\n");
  CHECK(read(doubles.path())[0].rounding == 0.0);
}

TEST_CASE("files of other programs: two boxes that share an edge and a part of a face") {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(QUOIN_SOURCE_DIR "/tests/unit/meshes")) {
    const std::string path = entry.path().string();
    if (entry.path().extension() == ".py") continue;
    INFO(path);
    ++files;
    const std::vector<MeshBlock> blocks = read(path);
    REQUIRE(blocks.size() == 2);
    const double volumes[] = {1.0, 0.5};
    for (std::size_t b = 0; b < 2; ++b) {
      const geometry::Shape shape = convex_block(blocks[b], -1);
      CHECK_THAT(geometry::mass_properties(shape).volume, WithinRel(volumes[b], 1e-14));
      CHECK(shape.topology().face_count() == 6);  // triangles of a side are one polygon
      CHECK(blocks[b].vertices.cols() == 8);
    }
  }
  CHECK(files == 18);
}

TEST_CASE("a mesh that is an earlier one moved, exactly, takes over its topology") {
  scene_file::MovedHulls hulls;
  int made = 0;
  const auto made_for = [&](const geometry::Vector3& shift) {
    MeshBlock mesh = cube_mesh({{0, 0, 1}, {1, 0, 1}, {1, 1, 1.5}, {0, 1, 1.5}});
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

TEST_CASE("a byte order mark belongs to no word") {
  const std::string faces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
  const TemporaryFile obj("quoin_mark.obj",
                          "\xEF\xBB\xBFo named\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n" + faces);
  CHECK(read(obj.path())[0].id == "named");
  const TemporaryFile off("quoin_mark.off",
                          "\xEF\xBB\xBFOFF 4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
                          "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
  CHECK(read(off.path()).size() == 1);
}

TEST_CASE("OBJ: long lines, objects that groups divide, groups of several solids") {
  const std::string tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const std::string faces = "f -4 -2 -3\nf -4 -3 -1\nf \\\n -3 -2 \\\n -1\nf -2 -4 -1\n";
  const TemporaryFile whole("quoin_whole.obj", "o one\n" + tetrahedron + "g stone\n" + faces);
  REQUIRE(read(whole.path()).size() == 1);
  CHECK(read(whole.path())[0].id == "one");
  const TemporaryFile two("quoin_two.obj", "g pair\n" + tetrahedron + faces +
                                               "v 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\n" + faces);
  REQUIRE(read(two.path()).size() == 2);
  CHECK(read(two.path())[1].id == "pair.1");
}

TEST_CASE("what a mesh file says that can't be worked with: one line, with its place") {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  const struct {
    const char* name;
    std::string text, said;
  } files[] = {
      {"a.obj", "v 0 0 0\nf 1 2 3\n", "line 2: there is no vertex \"2\", so far there are 1"},
      {"b.obj", "v 0 0 0\nf 1 1 4294967297\n", "line 2: there is no vertex \"4294967297\""},
      {"c.obj", "v 0 0 0\nf 1 1 99999999999999999999\n", "is not a whole number"},
      {"d.obj", "v 0 nan 0\n", "line 1: \"nan\" is not a finite number"},
      {"e.obj", "v 0 1\n", "line 1: three coordinates expected, 2 given"},
      {"f.obj", "v 0 0 0\nf 1 1\n", "line 2: a face has at least 3 vertices, this one has 2"},
      {"g.obj", "# empty\n", "holds no faces"},
      {"h.obj", "v 0 0 0\nf 1 1 1\n", "none of its faces has 3 corners at different places"},
      {"a.stl", "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nendloop\n",
       "line 5: a facet has 3 vertices, this one has 1"},
      {"b.stl", std::string(80, ' ') + std::string("\7\0\0\0", 4) + "12345",
       "its head states 7 facets, its 89 bytes hold 0"},
      {"c.stl", "hello\n", "line 1: \"solid\" expected, found \"hello\""},
      {"a.ply", "plyx\n", "line 1: \"ply\" expected"},
      {"b.ply", ply + "0 0 0\n3 0 0 1\n", "face 0: there is no vertex 1, there are 1"},
      {"c.ply", ply + "0 0\n", "vertex 0: the file ends before it"},
      {"d.ply", ply + "0 0 0\n2 0 0\n", "face 0: a face has at least 3 vertices, this one has 2"},
      {"e.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
       "element vertex has no property y"},
      {"f.ply", "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "is -1"},
      {"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "line 4: there is no vertex 1, there are 1"},
      {"b.off", "OFF\n2 1 0\n0 0 0\n", "the file ends before vertex 1 of 2"},
      {"c.off", "4OFF\n", "is none of OFF, COFF, NOFF, CNOFF"},
      {"a.txt", "", "its ending tells no format"},
      {"a.json", "{\"blocks\": {\"0\": {\"vertex\": {\"0\": {\"x\": 0}}, \"face\": {\"0\": []}}}}",
       "block \"0\": vertex \"0\": has no y"},
      {"b.json", "{\"blocks\": {\"0\": null}}", "block \"0\": holds no mesh"},
      {"c.json", std::string(30000, '['), "is no JSON of blocks"},
      {"d.json", "[1e999]", "number overflow"},
      {"g.ply", "ply\nformat ascii 1.0\nelement other 2000000000\nend_header\n", "holds no faces"},
  };
  for (const auto& file : files) {
    INFO(file.name);
    const TemporaryFile holder(std::string("quoin_bad_") + file.name, file.text);
    CHECK_THROWS_WITH(read(holder.path()), ContainsSubstring(file.said));
  }
}

TEST_CASE("COMPAS: lists of meshes, polyhedra, elements that are placed") {
  const std::string mesh = R"("vertices": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]],
                             "faces": [[0,2,1],[0,1,3],[1,2,3],[2,0,3]])";
  const TemporaryFile list("quoin_list.json", R"([{"dtype": "compas.geometry/Shape", "data": {)" +
                                                  mesh + R"(}}, {"data": {)" + mesh + "}}]");
  CHECK(read(list.path()).size() == 2);
  const TemporaryFile one("quoin_one.json",
                          R"({"dtype": "compas.datastructures/Mesh", "data": {)" + mesh + "}}");
  CHECK(read(one.path()).size() == 1);
  const TemporaryFile model("quoin_model.json", R"({"data": {"elements": {"e-1": {"data": {
      "is_support": true, "geometry": {"data": {)" + mesh +
                                                    R"(}},
      "transformation": {"data": {"matrix": [[1,0,0,5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}}}}},
      "graph": {"data": {"node": {"7": {"element": "e-1"}}}}}})");
  const std::vector<MeshBlock> placed = read(model.path());
  REQUIRE(placed.size() == 1);
  CHECK(placed[0].is_support);
  CHECK(placed[0].id == "7");
  CHECK(placed[0].vertices.row(0).minCoeff() == 5.0);
}

TEST_CASE("files without blocks, or that are no JSON, are refused by name") {
  const TemporaryFile empty("quoin_empty.json", "{}");
  CHECK_THROWS_AS(read(empty.path()), scene_file::MeshError);
  const TemporaryFile broken("quoin_broken.json", "{");
  CHECK_THROWS_WITH(read(broken.path()), ContainsSubstring("is no JSON"));
  CHECK_THROWS_WITH(read("none.json"), ContainsSubstring("can't be read"));
}
