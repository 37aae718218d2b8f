/// Real assemblies (not part of the repository) come to rest and stand for a second: no overlap,
/// and the supports bear the weight.

#include <filesystem>
#include <fstream>
#include <quoin/geometry/mass_properties.hpp>

#include "scene_file/run_scene.hpp"
#include "support/catch.hpp"
#include "support/real_data.hpp"

using namespace quoin;
using namespace quoin::tests;

namespace {

namespace fs = std::filesystem;

scene_file::SceneFile real_scene(const std::string& blocks) {
  const fs::path path = fs::temp_directory_path() / "quoin_test_real_assemblies.json";
  std::ofstream(path) << R"json({
    "materials": {"stone": {"density": 2400, "young": 1e10, "poisson": 0.2}},
    "joint": {"friction_angle_deg": "=atan(0.84)/deg"},
    "time_step": 0.01,
    "stages": [{"analysis": "settle", "until": "rest"}, {"analysis": "dynamic", "end_time": 1}],
    "blocks": )json" << blocks
                      << "}";
  const scene_file::SceneFile file = scene_file::read_scene(path.string());
  fs::remove(path);
  return file;
}

double weight(const solver::Scene& scene) {
  double sum = 0.0;
  for (const solver::Block& block : scene.blocks)
    if (block.kind <= solver::BlockKind::Rigid)
      sum += 9.81 * block.material.density * geometry::mass_properties(block.body()).volume;
  return sum;
}

void check_that_it_stands(const std::string& blocks) {
  const std::string folder = real_data();
  const scene_file::SceneFile file =
      real_scene(R"({"file": ")" + folder + "/" + blocks + R"(, "material": "stone"})");
  const scene_file::RunResult result = scene_file::run_scene(file, {});
  INFO(result.message);
  CHECK(result.status == scene_file::RunStatus::Completed);
  CHECK(result.unconverged_steps == 0);
  CHECK_THAT(result.dynamic_time, WithinAbs(1.0, 1e-12));
  CHECK(result.total.largest_overlap <= 1e-6);
  CHECK(result.total.largest_speed <= 0.1);
  CHECK_THAT(result.energy.kinetic, WithinAbs(0.0, 1e-6));  // J: it stands
  CHECK_THAT(result.base_reaction.z(), WithinRel(-weight(file.scene), 1e-4));
  CHECK_THAT(result.base_reaction.head<2>().norm(), WithinAbs(0.0, 1e-4 * weight(file.scene)));
}

}  // namespace

TEST_CASE("the arch of 30 voussoirs stands") {
  check_that_it_stands(R"(arch_assembly.json", "format": "compas")");
}

TEST_CASE("the running-bond wall stands, from COMPAS") {
  check_that_it_stands(R"(wall_equilibrium.json", "format": "compas")");
}

TEST_CASE("the running-bond wall stands, from OBJ") {
  check_that_it_stands(R"(wall.obj", "format": "obj", "supports": "lowest_course")");
}

TEST_CASE("the Armadillo vault stands, though its hulls overlap by up to 32 mm") {
  const std::string folder = real_data();
  const fs::path path = fs::temp_directory_path() / "quoin_test_armadillo.json";
  std::ofstream(path) << R"json({
    "materials": {"stone": {"density": 2400}}, "joint": {"friction_angle_deg": 40},
    "initial_overlap": "zero", "time_step": 0.01,
    "stages": [{"analysis": "static"}, {"analysis": "dynamic", "end_time": 0.1}],
    "blocks": {"file": ")json"
                      << folder << R"json(/armadillo_cra.json", "kind": "rigid",
               "material": "stone", "convexity_tolerance": 0.05}})json";
  const scene_file::SceneFile file = scene_file::read_scene(path.string());
  fs::remove(path);
  const scene_file::RunResult result = scene_file::run_scene(file, {});
  INFO(result.message);
  CHECK(result.status == scene_file::RunStatus::Completed);
  CHECK(file.scene.blocks.size() == 399);
  CHECK(result.total.largest_overlap <= 1e-6);
  CHECK(result.total.largest_speed <= 1e-6);
  const double all = weight(file.scene);
  CHECK_THAT(result.base_reaction.z(), WithinRel(-all, 1e-6));
  CHECK_THAT(result.base_reaction.head<2>().norm(), WithinAbs(0.0, 1e-6 * all));
}
