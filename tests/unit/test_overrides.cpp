#include <filesystem>
#include <fstream>

#include "scene_file/scene_file.hpp"
#include "support/catch.hpp"

using namespace quoin;
using namespace quoin::tests;
using scene_file::SceneFile;
using solver::BlockKind;
using solver::Vector3;

namespace {

/// Three cubes of an OBJ file in millimetres, "base", "a1" and "a2", one on the other.
std::string cubes() {
  std::string text;
  const char* names[] = {"base", "a1", "a2"};
  for (int i = 0; i < 3; ++i) {
    text += std::string("o ") + names[i] + "\n";
    for (int corner = 0; corner < 8; ++corner) {
      text += "v " + std::to_string(1000 * (corner & 1)) + " " +
              std::to_string(1000 * (corner >> 1 & 1)) + " " +
              std::to_string(1000 * (i + (corner >> 2))) + "\n";
    }
    text +=
        "f -8 -6 -5 -7\nf -4 -3 -1 -2\nf -8 -7 -3 -4\nf -7 -5 -1 -3\nf -5 -6 -2 -1\nf -6 -8 -4 "
        "-2\n";
  }
  return text;
}

SceneFile read(const std::string& overrides) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  const std::filesystem::path mesh = folder / "quoin_test_overrides.obj";
  const std::filesystem::path path = folder / "quoin_test_overrides.json";
  std::ofstream(mesh) << cubes();
  std::ofstream(path) << R"({"materials": {"rock": {"density": 2600, "young": 5e9},
      "brick": {"density": 1800}}, "parameters": {"low": 1.1},
      "joint": {"friction_angle_deg": 30}, "end_time": 1,
      "joints": [{"between": ["rock", "mortar"], "friction_angle_deg": 10}],
      "blocks": {"file": "quoin_test_overrides.obj", "units": "mm", "material": "rock"},
      "overrides": )" << overrides
                      << "}";
  return scene_file::read_scene(path.string());  // both are written anew each time
}

}  // namespace

TEST_CASE("overrides by name, pattern and place: the last one wins") {
  const SceneFile file = read(R"([
    {"where": "z < low", "kind": "fixed"},
    {"blocks": "a*", "kind": "rigid", "joint_group": "mortar", "velocity": [1, 0, 0]},
    {"blocks": ["a2"], "where": "z > 2", "material": "brick", "velocity": [2, 0, 0]}])");
  const auto& blocks = file.scene.blocks;
  REQUIRE(blocks.size() == 3);
  CHECK(blocks[0].kind == BlockKind::Fixed);
  CHECK(blocks[1].kind == BlockKind::Rigid);
  CHECK(blocks[1].velocity == Vector3(1, 0, 0));
  CHECK(blocks[1].material.density == 2600);
  CHECK(blocks[2].velocity == Vector3(2, 0, 0));
  CHECK(blocks[2].material.density == 1800);
  REQUIRE(file.scene.pair_joints.size() == 1);
  CHECK(file.scene.pair_joints[0].group_a == blocks[0].material.joint_group);
  CHECK(file.scene.pair_joints[0].group_b == blocks[1].material.joint_group);
  CHECK(blocks[0].body().box().max.x() == 1.0);
}

TEST_CASE("a block of a file may be moved as prescribed") {
  const SceneFile file = read(R"json([{"blocks": "a?", "joint_group": "mortar"},
    {"blocks": "base", "kind": "prescribed",
     "motion": {"velocity": {"formula": ["sin(t)", "0", "0"]}}}])json");
  CHECK(file.scene.blocks[0].kind == BlockKind::Prescribed);
  CHECK(file.scene.blocks[0].motion.value.at(0.5).x() > 0.4);
}

TEST_CASE("overrides that mean no block, or can't be made, are refused with their place") {
  const struct {
    const char *overrides, *said;
  } cases[] = {
      {R"([{"blocks": "b2", "kind": "rigid"}])", R"(/overrides/0/blocks: no block is named "b2")"},
      {R"([{"blocks": ["a1", 7], "kind": "rigid"}])",
       "/overrides/0/blocks/1: no block is named \"7\""},
      {R"([{"where": "z > 9", "kind": "rigid"}])", "/overrides/0/where: no block's centroid meets"},
      {R"([{"where": "z >", "kind": "rigid"}])", "/overrides/0/where: "},
      {R"([{"where": "q > 1", "kind": "rigid"}])", "/overrides/0/where: "},
      {R"([{"kind": "rigid"}])", "/overrides/0: needs \"blocks\" or \"where\""},
      {R"([{"blocks": "a1", "material": "wood"}])", "/overrides/0/material: there is no material"},
      {R"([{"blocks": "a1", "material": "brick"}])", "has no young"},
      {R"([{"blocks": "a1", "kind": "fixed", "velocity": [1, 0, 0]}])",
       "/overrides/0/velocity: a fixed or prescribed block can't have it"},
      {R"([{"blocks": "a1", "kind": "prescribed"}])", "missing key \"motion\""},
      {R"([{"blocks": "a1", "colour": "red"}])", "/overrides/0/colour: unknown key"}};
  for (const auto& one : cases) {
    INFO(one.overrides);
    CHECK_THROWS_WITH(read(one.overrides), ContainsSubstring(one.said));
  }
}
