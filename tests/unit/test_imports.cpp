/// Files of other programs: what blocks they make, and what is said of bad ones.

#include <filesystem>
#include <fstream>
#include <quoin/geometry/mass_properties.hpp>

#include "scene_file/mesh_surface.hpp"
#include "support/catch.hpp"

using namespace quoin;
using namespace quoin::tests;
using namespace quoin::scene_file;

namespace {

double volume_of(const MeshBlock& mesh) {
  return geometry::mass_properties(convex_block(mesh, -1)).volume;
}

std::string dxf_face(const std::string& layer, const std::array<std::array<int, 3>, 4>& corners) {
  std::string text = "0\n3DFACE\n 8\n" + layer + "\n";
  for (int c = 0; c < 4; ++c) {
    for (int axis = 0; axis < 3; ++axis) {
      if (axis == 2 && corners[static_cast<std::size_t>(c)][2] == 0) continue;  // may be left out
      text += " " + std::to_string(10 * (axis + 1) + c) + "\n" +
              std::to_string(corners[static_cast<std::size_t>(c)][static_cast<std::size_t>(axis)]) +
              ".0\n";
    }
  }
  return text;
}

/// A tetrahedron at x.
std::string dxf_tetrahedron(const std::string& layer, int x) {
  const std::array<int, 3> o{x, 0, 0}, a{x + 1, 0, 0}, b{x, 1, 0}, c{x, 0, 1};
  return dxf_face(layer, {o, b, a, a}) + dxf_face(layer, {o, a, c, c}) +
         dxf_face(layer, {o, c, b, b}) + dxf_face(layer, {a, b, c, c});
}

}  // namespace

TEST_CASE("DXF: the 3DFACE of each layer") {
  const std::string text = "  0\r\nSECTION\r\n  2\r\nENTITIES\r\n" + dxf_tetrahedron("a stone", 0) +
                           "0\nLINE\n8\n0\n10\n5.0\n" + dxf_tetrahedron("b", 5) + "0\nEOF\n";
  const std::vector<MeshBlock> blocks = blocks_of(read_dxf(text));
  REQUIRE(blocks.size() == 2);
  CHECK(blocks[0].id == "a stone");
  CHECK(blocks[1].id == "b");
  for (const MeshBlock& block : blocks) CHECK_THAT(volume_of(block), WithinRel(1.0 / 6, 1e-14));
  CHECK_THROWS_WITH(read_dxf("0\n3DFACE\n10\nabc\n"),
                    ContainsSubstring("line 4: \"abc\" is not a number"));
  CHECK_THROWS_WITH(read_dxf("0\n3DFACE\n10\n1.0\n0\nEOF\n"),
                    ContainsSubstring("fewer than three corners"));
}

TEST_CASE("DXF: solids that are no 3DFACE of the drawing itself are refused") {
  const auto drawing = [](const std::string& entities) {
    return "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nbrick\n" + dxf_tetrahedron("0", 9) +
           "0\nENDBLK\n0\nBLOCK\n2\nframe\n0\nLINE\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES"
           "\n" +
           dxf_tetrahedron("a", 0) + entities + "0\nENDSEC\n0\nEOF\n";
  };
  CHECK(blocks_of(read_dxf(drawing("0\nINSERT\n2\nframe\n0\nPOLYLINE\n70\n1\n"))).size() == 1);
  for (const auto& [entity, what] :
       {std::pair("0\nINSERT\n2\nbrick\n", "INSERT of block \"brick\""),
        std::pair("0\nMESH\n8\n0\n", "MESH is"), std::pair("0\n3DSOLID\n8\n0\n", "3DSOLID is"),
        std::pair("0\nPOLYLINE\n70\n64\n", "POLYLINE of faces")})
    CHECK_THROWS_WITH(read_dxf(drawing(entity)), ContainsSubstring(what));
}

TEST_CASE("3DEC: bricks, prisms and polyhedra, old words and new ones") {
  const std::vector<MeshBlock> blocks = read_3dec(R"(model new  ; a comment
block create brick 0 1 0 2 0,3 group 'base' ; x, y, z
block create prism face-1 (0,0,0) (1,0,0) (0,1,0) &
   face-2 0 0 2  1 0 2  0 1 2 group "wedges"
POLY prism a 0 0 0 1 0 0 0 1 0 b 0 0 1 1 0 1 0 1 1
poly face 0 0 0 0 1 0 1 0 0 face 0 0 0 1 0 0 0 0 1 face 0 0 0 0 0 1 0 1 0 face 1 0 0 0 1 0 0 0 1
block create group "the cap" poly face 0.000,0.000,0.000 0.000,1.000,0.000 1.000,0.000,0.000 &
  face 0.000,0.000,0.000 1.000,0.000,0.000 0.000,0.000,1.000 &
  face 0.000,0.000,0.000 0.000,0.000,1.000 0.000,1.000,0.000 &
  face 1.000,0.000,0.000 0.000,1.000,0.000 0.000,0.000,1.000 r=0
block property density 2000
)");
  REQUIRE(blocks.size() == 5);
  CHECK(blocks[0].name == "base");
  CHECK(blocks[1].name == "wedges");
  CHECK(blocks[4].name == "the cap");
  CHECK(blocks[3].rounding == 0);
  CHECK(blocks[4].rounding == 0.5e-3);  // three decimals everywhere: what a program has rounded
  const double volumes[] = {6, 1, 0.5, 1.0 / 6, 1.0 / 6};
  for (std::size_t b = 0; b < 5; ++b)
    CHECK_THAT(volume_of(blocks[b]), WithinRel(volumes[b], 1e-13));
  const MeshBlock angle = read_3dec(R"(block create polyhedron &
face 0 0 0  0 2 0  1 2 0  1 1 0  2 1 0  2 0 0 face 0 0 1  2 0 1  2 1 1  1 1 1  1 2 1  0 2 1 &
face 0 0 0  2 0 0  2 0 1  0 0 1 face 2 0 0  2 1 0  2 1 1  2 0 1 face 2 1 0  1 1 0  1 1 1  2 1 1 &
face 1 1 0  1 2 0  1 2 1  1 1 1 face 1 2 0  0 2 0  0 2 1  1 2 1 face 0 2 0  0 0 0  0 0 1  0 2 1
)")[0];
  CHECK_THROWS_WITH(volume_of(angle), ContainsSubstring("is not convex"));  // import splits it
  CHECK_THROWS_WITH(read_3dec("\nblock create brick 0 1 0 x 0 1\n"),
                    ContainsSubstring("line 2: \"x\""));
  CHECK_THROWS_WITH(read_3dec("block cut joint-set dip 3\n"),
                    ContainsSubstring("line 1: \"block cut\""));
  CHECK_THROWS_WITH(read_3dec("block create drum\n"), ContainsSubstring("\"drum\""));
  CHECK_THROWS_WITH(read_3dec("model new\n"), ContainsSubstring("creates no blocks"));
}

TEST_CASE("Chrono: brick files with and without density, blocks of several hulls") {
  const std::string cube = "0,0,0, 1,0,0, 0,1,0, 1,1,0, 0,0,1, 1,0,1, 0,1,1, 1,1,1";
  const std::string tetrahedron = "1,0,0, 2,0,0, 1,1,0, 1,0,1";
  const std::vector<MeshBlock> blocks =
      read_chrono("0,1,1,1, 0,0,0, 0,0,0, " + cube + "\n7,0,1,1,1800, 0,0,0, 0,0,0, " + cube +
                  ", 9999, " + tetrahedron + "\n8,0,1, 0,0,0, 0,0,0, " + cube + "\n");
  REQUIRE(blocks.size() == 4);
  CHECK(blocks[0].is_support);
  CHECK(blocks[0].density == 0);
  CHECK(blocks[1].density == 1800);
  CHECK(blocks[1].body == "7");
  CHECK(meshes_of_block(blocks, 1).size() == 2);
  CHECK_THAT(volume_of(blocks[2]), WithinRel(1.0 / 6, 1e-13));
  CHECK_THROWS_WITH(read_chrono("\n1,0,1,1,0,0,0,0,0,0,1,2\n"),
                    ContainsSubstring("line 2: a block has"));
  CHECK_THROWS_WITH(read_chrono("1,0,1,1,0,0,0,0,0,0,0,0,0,1,0,0,0,1,0,1,1,0\n"),
                    ContainsSubstring("block \"1\""));
}

TEST_CASE("LMGC90: POLYR turned by DOF.INI; several of one body are parts of it") {
  const std::string polyr = R"( POLYR      1  color  BLEUx  nb_vertex=      4    nb_faces=      4
                             coo1= 0.0000000E+00  coo2= 0.0000000E+00  coo3= 0.0000000E+00
                             coo1= 2.0000000D+00  coo2= 0.0000000D+00  coo3= 0.0000000D+00
                             coo1= 0.0000000E+00  coo2= 1.0000000E+00  coo3= 0.0000000E+00
                             coo1= 0.0000000E+00  coo2= 0.0000000E+00  coo3= 1.0000000E+00
                             ver1=      1         ver2=      3         ver3=      2
                             ver1=      1         ver2=      2         ver3=      4
                             ver1=      1         ver2=      4         ver3=      3
                             ver1=      2         ver2=      3         ver3=      4
)";
  const auto body = [](int number, const std::string& contactors) {
    return "$bdyty\n RBDY3      " + std::to_string(number) + R"(
$blmty
 PLAIN      1  behav  STONE  avrd= 1.0000000E+00
                             I1  = 1.0000000E+00  I2  = 1.0000000E+00  I3  = 1.0000000E+00
$nodty
 NO6xx      1                coo1= 5.0000000E+00  coo2= 0.0000000E+00  coo3= 0.0000000E+00
                             coo4= 0.0000000E+00  coo5= 0.0000000E+00  coo6= 0.0000000E+00
$tacty
)" + contactors +
           "$$$$$$\n";
  };
  const std::string dof = R"($bdyty
 RBDY3        1
$nodty
 NO6xx      1                X(1)= 1.0000000D+00  X(2)= 0.0000000D+00  X(3)= 0.0000000D+00
                             a(1)= 0.0000000D+00  a(2)= 1.0000000D+00  a(3)= 0.0000000D+00
                             b(1)=-1.0000000D+00  b(2)= 0.0000000D+00  b(3)= 0.0000000D+00
                             g(1)= 0.0000000D+00  g(2)= 0.0000000D+00  g(3)= 1.0000000D+00
$$$$$$
)";
  const std::vector<MeshBlock> blocks = read_lmgc90(body(1, polyr) + body(2, polyr + polyr), dof);
  REQUIRE(blocks.size() == 3);
  CHECK(blocks[0].id == "RBDY3_1");
  CHECK(blocks[0].body.empty());
  CHECK(blocks[2].body == "RBDY3_2");
  CHECK(blocks[0].vertices.col(2) == geometry::Vector3(6, 2, 0));
  CHECK(blocks[1].vertices.col(2) == geometry::Vector3(7, 0, 0));
  CHECK_THAT(volume_of(blocks[0]), WithinRel(1.0 / 3, 1e-13));
  const std::vector<MeshBlock> plane = read_lmgc90(
      body(1, " PLANx  1  color  VERTx  axe1= 2.0D+00  axe2= 1.0D+00  axe3= 1.0D-01\n"), dof);
  REQUIRE(plane.size() == 1);
  CHECK_THAT(volume_of(plane[0]), WithinRel(1.6, 1e-13));
  CHECK_THAT(plane[0].vertices.row(1).maxCoeff(), WithinRel(2.0, 1e-13));  // turned
  const std::vector<MeshBlock> old = read_lmgc90(  // keys of other programs, a number twice
      body(1, " PLANx  1  color  VERTx  coo1= 2.0D+00  coo2= 1.0D+00  coor= 1.0D-01\n") +
          body(1, std::string(polyr).replace(polyr.find("nb_faces"), 8, "nb_face ")),
      "");
  REQUIRE(old.size() == 2);
  CHECK(old[1].id == "RBDY3_2");
  CHECK_THAT(volume_of(old[0]) + volume_of(old[1]), WithinRel(1.6 + 1.0 / 3, 1e-13));
  CHECK_THROWS_WITH(read_lmgc90(body(1, " PLANx 1 color VERTx axe1= 1.0 axe2= 1.0\n"), ""),
                    ContainsSubstring("three numbers"));
  CHECK_THROWS_WITH(read_lmgc90(body(1, polyr.substr(0, 300)), ""), ContainsSubstring("line 1"));
  CHECK_THROWS_WITH(read_lmgc90(body(1, " SPHER  1 color BLUEx byrd= 1.0\n"), ""),
                    ContainsSubstring("\"SPHER\" is not imported"));
}

TEST_CASE("rigid-ipc: meshes scaled, turned and moved") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / "quoin_test_rigid_ipc";
  fs::create_directories(folder / "meshes");
  fs::create_directories(folder / "fixtures");
  std::ofstream(folder / "meshes" / "tet.obj")
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const std::string path = (folder / "fixtures" / "scene.json").string();
  const std::vector<MeshBlock> blocks = read_rigid_ipc(
      R"({"rigid_body_problem": {"rigid_bodies": [
        {"mesh": "tet.obj", "position": [1, 2, 3], "rotation": [0, 0, 90], "scale": [2, 1, 1], "density": 500},
        {"mesh": "tet.obj", "is_dof_fixed": [true, true, true, true, true, true]}]}})",
      path);
  REQUIRE(blocks.size() == 2);
  CHECK(blocks[0].density == 500);
  CHECK(!blocks[0].is_support);
  CHECK(blocks[1].is_support);
  CHECK((blocks[0].vertices.col(2) - geometry::Vector3(1, 4, 3)).norm() < 1e-14);
  std::ofstream(folder / "meshes" / "plane.obj")
      << "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3\nf 1 3 4\n";
  const std::vector<MeshBlock> slope = read_rigid_ipc(
      R"({"rigid_bodies": [
        {"mesh": "tet.obj", "dimensions": [4, 3, 0.5]},
        {"mesh": "plane.obj", "is_dof_fixed": true, "dimensions": [10, 0, 10], "rotation": [0, 0, 30]}]})",
      path);
  REQUIRE(slope.size() == 2);
  CHECK_THAT(volume_of(slope[0]), WithinRel(1.0, 1e-13));
  const double thick = 0.1 * std::hypot(10.0, 10.0);
  CHECK_THAT(volume_of(slope[1]), WithinRel(100 * thick, 1e-12));
  CHECK_THAT(slope[1].vertices.row(1).maxCoeff(),
             WithinAbs(2.5, 1e-12));  // it lies below the plane
  CHECK_THROWS_WITH(read_rigid_ipc(R"({"rigid_bodies": [{"mesh": "no.obj"}]})", path),
                    ContainsSubstring("body 0: there is no mesh \"no.obj\""));
  CHECK_THROWS_WITH(read_rigid_ipc(R"({"bodies": []})", path), ContainsSubstring("rigid_bodies"));
  fs::remove_all(folder);
}
