/// Mesh files of other authors (not part of the repository).

#include <quoin/geometry/mass_properties.hpp>

#include "scene_file/mesh_file.hpp"
#include "support/catch.hpp"
#include "support/real_data.hpp"

using namespace quoin;
using namespace quoin::tests;
using scene_file::convex_block;
using scene_file::MeshBlock;

namespace {

std::vector<MeshBlock> read(const std::string& path) {
  return scene_file::read_mesh_file(path, scene_file::mesh_format(path, ""));
}

int support_count(const std::vector<MeshBlock>& blocks) {
  int count = 0;
  for (const MeshBlock& block : blocks) count += block.is_support;
  return count;
}

}  // namespace

TEST_CASE("real assemblies: how many blocks, how many supports") {
  const std::string folder = real_data();
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
    const std::vector<MeshBlock> blocks = read(folder + "/" + file.name);
    CHECK(blocks.size() == file.blocks);
    CHECK(support_count(blocks) == file.supports);
    for (const MeshBlock& block : blocks) {
      INFO(block.id);
      CHECK_NOTHROW(convex_block(block, -1));
    }
  }
  CHECK(read(folder + "/wall.obj").size() == 38);
  CHECK(read(folder + "/barrel_vault_DEM_results.json").size() == 121);
}

TEST_CASE("real assemblies: warped blocks are refused, or taken within a tolerance") {
  const std::string folder = real_data();
  int refused = 0;
  for (const MeshBlock& block : read(folder + "/armadillo_cra.json")) {
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
