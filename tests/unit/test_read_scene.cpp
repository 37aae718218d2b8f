#include <filesystem>
#include <fstream>
#include <numbers>
#include <quoin/geometry/mass_properties.hpp>
#include <sstream>

#include "scene_file/cases.hpp"
#include "scene_file/scene_file.hpp"
#include "support/catch.hpp"

using namespace quoin;
using namespace quoin::tests;
using scene_file::CaseFile;
using scene_file::read_scene;
using scene_file::SceneFile;
using solver::Vector3;

namespace {

/// A scene file that is gone at the end of the test.
class TemporaryScene {
 public:
  explicit TemporaryScene(const std::string& text)
      : path_(std::filesystem::temp_directory_path() / "quoin_test_read_scene.json") {
    std::ofstream(path_) << text;
  }
  ~TemporaryScene() { std::filesystem::remove(path_); }
  SceneFile read(const std::vector<std::string>& changes = {}) const {
    return read_scene(path_.string(), changes);
  }

 private:
  std::filesystem::path path_;
};

std::string cube(const std::string& more) {
  return R"({"name": "cube", "material": "rock",
            "shape": {"type": "box", "min": [0, 0, 0], "max": [1, 1, 1]})" +
         more + "}";
}

std::string scene(const std::string& blocks, const std::string& more = "") {
  return R"({"materials": {"rock": {"density": 2600, "young": 5e9}, "brick": {"density": 1800}},
            "joint": {"friction_angle_deg": 30}, "end_time": 1, "blocks": [)" +
         blocks + "]" + more + "}";
}

double volume(const solver::Block& block) { return geometry::mass_properties(block.body()).volume; }

bool same(const Vector3& a, const Vector3& b) { return (a - b).norm() < 1e-14; }

bool says_something(const CaseFile& cases) { return !cases.runs().empty() || cases.has_series(); }

}  // namespace

TEST_CASE("the four shapes") {
  const SceneFile file = TemporaryScene(scene(R"(
    {"kind": "fixed", "shape": {"type": "box", "min": [0,0,0], "max": [1,2,3]}},
    {"kind": "fixed", "shape": {"type": "prism", "polygon": [[0,0,0],[1,0,0],[0,1,0]], "sweep": [0,0,2]}},
    {"kind": "fixed", "shape": {"type": "hull", "points": [[0,0,0],[1,0,0],[0,1,0],[0,0,1],[0.1,0.1,0.1]]}},
    {"kind": "fixed", "shape": {"type": "polyhedron", "vertices": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]],
      "faces": [[0,2,1],[0,1,3],[1,2,3],[2,0,3]]}})"))
                             .read();
  REQUIRE(file.scene.blocks.size() == 4);
  CHECK_THAT(volume(file.scene.blocks[0]), WithinRel(6.0, 1e-14));
  CHECK_THAT(volume(file.scene.blocks[1]), WithinRel(1.0, 1e-14));
  CHECK_THAT(volume(file.scene.blocks[2]), WithinRel(1.0 / 6, 1e-14));
  CHECK_THAT(volume(file.scene.blocks[3]), WithinRel(1.0 / 6, 1e-14));
}

TEST_CASE("a pose by axis and angle, quaternion or matrix is the same pose") {
  const std::string rotations[] = {R"({"axis": [0, 0, 2], "angle_deg": 90})",
                                   R"({"quaternion": [1, 0, 0, 1]})",
                                   R"({"matrix": [[0, -1, 0], [1, 0, 0], [0, 0, 1]]})"};
  for (const std::string& rotation : rotations) {
    const SceneFile file =
        TemporaryScene(scene(cube(R"(, "pose": {"rotation": )" + rotation +
                                  R"(, "about": [1, 0, 0], "translation": [0, 0, 5]})")))
            .read();
    const geometry::Box box = file.scene.blocks[0].body().box();
    CHECK(same(box.min, Vector3(0, -1, 5)));
    CHECK(same(box.max, Vector3(1, 0, 6)));
  }
}

TEST_CASE("blocks whose shape is stated in the same words share it, wherever they stand") {
  const SceneFile file = TemporaryScene(scene(R"(
    {"kind": "fixed", "shape": {"type": "box", "min": [0,0,0], "max": [1,2,3]}},
    {"kind": "fixed", "shape": {"type": "box", "min": [0,0,0], "max": [1,2,4]}},
    {"kind": "fixed", "shape": {"type": "box", "max": [1,2,3], "min": [0,0,0]},
     "pose": {"translation": [5, 0, 0]}})"))
                             .read();
  const auto& blocks = file.scene.blocks;
  CHECK(blocks[0].shape == blocks[2].shape);
  CHECK(blocks[0].shape != blocks[1].shape);
  CHECK(blocks[2].body().box().max == Vector3(6, 2, 3));
}

TEST_CASE("kinds, motion, initial state") {
  const SceneFile file = TemporaryScene(scene(cube(R"(, "kind": "rigid", "velocity": [1, 2, 3],
        "angular_velocity": [4, 5, 6])") + R"json(,
      {"kind": "prescribed", "motion": {"acceleration": {"formula": ["5*sin(2*pi*t)", "0", "0"]}},
       "shape": {"type": "box", "min": [0,0,-1], "max": [1,1,0]}})json"))
                             .read();
  const solver::Block& block = file.scene.blocks[0];
  CHECK(block.kind == solver::BlockKind::Rigid);
  CHECK(block.velocity == Vector3(1, 2, 3));
  CHECK(block.angular_velocity == Vector3(4, 5, 6));
  CHECK(block.material.density == 2600);
  const solver::Motion& motion = file.scene.blocks[1].motion;
  CHECK(motion.kind == solver::MotionKind::Acceleration);
  CHECK_THAT(motion.value.at(0.25).x(), WithinRel(5.0, 1e-14));
}

TEST_CASE("joints: default, by pair of materials, in radians") {
  const SceneFile file =
      TemporaryScene(scene(cube(""), R"(, "joints": [{"between": ["rock", "brick"],
        "friction_angle_deg": 45, "cohesion": 100, "residual_friction_angle_deg": 30}])"))
          .read();
  CHECK_THAT(file.scene.joint.friction_angle, WithinRel(std::numbers::pi / 6, 1e-15));
  CHECK(file.scene.joint.residual_friction_angle == -1.0);
  REQUIRE(file.scene.pair_joints.size() == 1);
  const solver::PairJoint& pair = file.scene.pair_joints[0];
  CHECK(pair.group_a != pair.group_b);
  CHECK(std::max(pair.group_a, pair.group_b) > 0);
  CHECK(file.scene.blocks[0].material.joint_group == pair.group_a);
  CHECK_THAT(pair.joint.friction_angle, WithinRel(std::numbers::pi / 4, 1e-15));
  CHECK_THAT(pair.joint.residual_friction_angle, WithinRel(std::numbers::pi / 6, 1e-15));
  CHECK(pair.joint.cohesion == 100);
}

TEST_CASE("gravity and loads: constant, table, formula; a face by its direction") {
  const SceneFile file = TemporaryScene(scene(cube(""), R"(,
    "gravity": {"table": [[0, 0, 0, 0], [2, 0, 0, -10]]},
    "loads": [{"type": "point", "block": "cube", "point": [1, 0.5, 0.5], "force": [1, 2, 3]},
              {"type": "face", "block": "cube", "towards": [0, 0.1, 1], "traction": [0, 0, -5]},
              {"type": "body", "block": "cube", "force": {"formula": ["t", "t^2", "1"]}}])"))
                             .read();
  CHECK(same(file.scene.gravity.at(1.0), Vector3(0, 0, -5)));
  CHECK(same(file.scene.gravity.at(9.0), Vector3(0, 0, -10)));
  CHECK(same(file.scene.point_loads.at(0).force.at(7.0), Vector3(1, 2, 3)));
  CHECK(same(file.scene.body_loads.at(0).force.at(3.0), Vector3(3, 9, 1)));
  const geometry::Body body = file.scene.blocks[0].body();
  for (const int vertex : body.shape().topology().face(file.scene.face_loads.at(0).face))
    CHECK(body.vertex(vertex).z() == 1.0);
}

TEST_CASE("stages follow one another; the short form is one dynamic stage") {
  const TemporaryScene text(R"({"materials": {"rock": {"density": 1, "young": 1}},
    "time_step": 0.01, "stages": [{"analysis": "settle", "unbalance": 1e-9},
    {"analysis": "static", "steps": 7}, {"analysis": "dynamic", "end_time": 2}], "blocks": [)" +
                            cube("") + "]}");
  const SceneFile file = text.read();
  REQUIRE(file.stages.size() == 3);
  CHECK(file.stages[0].analysis == solver::Analysis::Settle);
  CHECK(file.stages[0].unbalance == 1e-9);
  CHECK_FALSE(file.stages[0].steps);
  CHECK(file.stages[1].steps == 7);
  CHECK(file.stages[2].end_time == 2);
  CHECK(file.stages[2].time_step == 0.01);
  const SceneFile brief = TemporaryScene(scene(cube(""))).read();
  REQUIRE(brief.stages.size() == 1);
  CHECK(brief.stages[0].analysis == solver::Analysis::Dynamic);
  CHECK(brief.stages[0].end_time == 1);
}

TEST_CASE("stage_time counts from where the stage began, in formulas of loads alone") {
  const TemporaryScene text(
      scene(cube(""), R"(, "gravity": {"formula": ["stage_time", "t", "-9.81"]})"));
  const SceneFile file = text.read();
  CHECK(same(file.scene.gravity.at(3.0), Vector3(3, 3, -9.81)));
  file.stage_clock->start = 1.0;
  CHECK(same(file.scene.gravity.at(3.0), Vector3(2, 3, -9.81)));
  const TemporaryScene wrong(scene(cube(""), R"(, "monitors": [{"name": "m", "block": "cube"}],
    "references": [{"monitor": "m", "quantity": "displacement", "component": "x",
                    "exact": "stage_time"}])"));
  CHECK_THROWS_WITH(wrong.read(), ContainsSubstring("stage_time"));
}

TEST_CASE("parameters, expressions and changes") {
  const TemporaryScene text(
      scene(cube(""), R"json(, "parameters": {"slope": 20, "half": "=slope/2"},
    "gravity": ["=9.81*sin(slope*deg)", 0, "=-half"],
    "monitors": [{"name": "m", "block": "cube"}],
    "references": [{"monitor": "m", "quantity": "displacement", "component": "x",
                    "exact": "slope*t"}])json"));
  CHECK_THAT(text.read().scene.gravity.at(0).z(), WithinAbs(-10.0, 0.0));
  const SceneFile changed = text.read({"slope=30", "/method=penalty", "/penalty=5e7"});
  CHECK_THAT(changed.scene.gravity.at(0).x(), WithinRel(9.81 / 2, 1e-14));
  CHECK_THAT(changed.scene.gravity.at(0).z(), WithinAbs(-15.0, 0.0));
  CHECK_THAT(changed.references[0].exact(2.0)[0], WithinAbs(60.0, 0.0));
  CHECK(changed.options.method == solver::ContactMethod::Penalty);
  CHECK(changed.options.penalty == 5e7);
}

TEST_CASE("a reference by table is linear between its rows and constant outside") {
  const SceneFile file = TemporaryScene(scene(cube(""), R"(,
    "monitors": [{"name": "m", "block": "cube", "point": [0, 0, 1]}],
    "references": [{"monitor": "m", "quantity": "velocity",
                    "exact": {"table": [[0, 0, 0, 0], [2, 2, 4, 6]]}, "allowed": 0.1}])"))
                             .read();
  const scene_file::Reference& reference = file.references.at(0);
  CHECK(same(reference.exact(1.0), Vector3(1, 2, 3)));
  CHECK(same(reference.exact(-1.0), Vector3(0, 0, 0)));
  CHECK(same(reference.exact(5.0), Vector3(2, 4, 6)));
  CHECK(reference.allowed == 0.1);
}

TEST_CASE("every scene that is shipped can be read") {
  int count = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(QUOIN_SOURCE_DIR "/tools/scenes")) {
    if (entry.path().extension() == ".json") {
      INFO(entry.path());
      const std::string path = entry.path().string();
      std::ostringstream text;
      text << std::ifstream(path).rdbuf();
      const bool cases = text.str().find("\"cases\":") != std::string::npos;
      CHECK((cases ? says_something(CaseFile(path)) : !read_scene(path).scene.blocks.empty()));
      ++count;
    }
  }
  CHECK(count >= 4);
}
