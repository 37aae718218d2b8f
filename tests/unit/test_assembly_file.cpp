#include <filesystem>
#include <fstream>
#include <quoin/geometry/mass_properties.hpp>

#include "scene_file/assembly_file.hpp"
#include "scene_file/scene_error.hpp"
#include "scene_file/scene_file.hpp"
#include "support/catch.hpp"
#include "support/real_data.hpp"

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

int support_count(const std::vector<MeshBlock>& blocks) {
  int count = 0;
  for (const MeshBlock& block : blocks) {
    count += block.is_support;
  }
  return count;
}

}  // namespace

TEST_CASE("a convex mesh becomes its hull") {
  const geometry::Polyhedron block = convex_block(cube_mesh(kFlat), -1);
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
  const std::vector<MeshBlock> blocks = scene_file::read_obj(file.path());
  REQUIRE(blocks.size() == 2);
  CHECK(blocks[0].id == "first");
  CHECK_THAT(geometry::mass_properties(convex_block(blocks[0], -1)).volume,
             WithinRel(1.0 / 6, 1e-12));
  CHECK_THAT(geometry::mass_properties(convex_block(blocks[1], -1)).volume,
             WithinRel(1.0 / 3, 1e-12));
  const TemporaryFile wrong("quoin_wrong.obj", "v 0 0 0\nf 1 2 3\n");
  CHECK_THROWS_WITH(scene_file::read_obj(wrong.path()), ContainsSubstring("line 2: no vertex 2"));
}

TEST_CASE("files without blocks, or that are no JSON, are refused by name") {
  const TemporaryFile empty("quoin_empty.json", "{}");
  CHECK_THROWS_AS(scene_file::read_compas(empty.path()), scene_file::FileError);
  const TemporaryFile broken("quoin_broken.json", "{");
  CHECK_THROWS_WITH(scene_file::read_compas(broken.path()), ContainsSubstring("quoin_broken.json"));
  CHECK_THROWS_WITH(scene_file::read_compas("none.json"), ContainsSubstring("can't be read"));
}

TEST_CASE("real assemblies: how many blocks, how many supports") {
  const std::string folder = real_data();
  if (folder.empty()) {
    return;
  }
  const struct {
    const char* name;
    std::size_t blocks;
    int supports;
  } files[] = {{"arch_assembly.json", 30, 2},
               {"wall_equilibrium.json", 38, 5},
               {"barrel_vault_DEM_model.json", 121, 26},
               {"cubes.json", 3, 0},
               {"type-b.json", 3, 0},  // some sides are divided into coplanar faces
               {"H.json", 3, 0}};
  for (const auto& file : files) {
    INFO(file.name);
    const std::vector<MeshBlock> blocks = scene_file::read_compas(folder + "/" + file.name);
    CHECK(blocks.size() == file.blocks);
    CHECK(support_count(blocks) == file.supports);
    for (const MeshBlock& block : blocks) {
      INFO(block.id);
      CHECK_NOTHROW(convex_block(block, -1));
    }
  }
  CHECK(scene_file::read_obj(folder + "/wall.obj").size() == 38);
}

TEST_CASE("real assemblies: warped blocks are refused, or taken within a tolerance") {
  const std::string folder = real_data();
  if (folder.empty()) {
    return;
  }
  int refused = 0;
  for (const MeshBlock& block : scene_file::read_compas(folder + "/armadillo_cra.json")) {
    INFO(block.id);
    CHECK_NOTHROW(convex_block(block, 0.05));
    try {
      (void)convex_block(block, -1);
    } catch (const geometry::InputError&) {
      ++refused;
    }
  }
  CHECK(refused > 300);
}
