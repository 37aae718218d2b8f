/// What each feature adds to the step of a plain scene, and that what is not used adds nothing.
///
///   bench_lean --list         one line a scene: name, table, name of the scene it is measured
///   against, words bench_lean --times        least time of a step of every scene, by turns in one
///   process, as JSON bench_lean NAME           runs one scene and prints bytes and allocations as
///   JSON; callgrind counts
///                             quoin_lean_steps() alone, see bench/bench-lean

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "allocations.hpp"

namespace {

using namespace quoin;
using geometry::Vector3;
using solver::Scene;
using solver::StepOptions;

constexpr int kWarmSteps = 10;
constexpr int kSteps = 40;
const solver::Material kRock{.density = 2600};
const solver::Material kElastic{.density = 2600, .young = 5e9, .poisson = 0.25};

struct Setup {
  Scene scene;
  StepOptions options{.time_step = 1e-3};
  bool writes = false;  ///< ParaView files of blocks and contacts after each step
};

/// A rigid block slides on a fixed one, without friction.
Setup base() {
  Setup setup;
  setup.scene.add_fixed(geometry::make_box({-5, -5, -1}, {5, 5, 0}));
  setup.scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), kRock);
  setup.scene.blocks[1].velocity = {1.0, 0.5, 0.0};
  return setup;
}

Setup rough() {
  Setup setup = base();
  setup.scene.joint.friction_angle = 0.2;
  return setup;
}

Setup row(int count) {
  Setup setup = base();
  setup.scene.blocks[0].shape =
      std::make_shared<const geometry::Shape>(geometry::make_box({-5, -5, -1}, {50, 5, 0}));
  for (int i = 1; i < count; ++i) {
    const double x = 2.0 * i;
    setup.scene.add_rigid(geometry::make_box({x, 0, 0}, {x + 1, 1, 1}), kRock);
    setup.scene.blocks.back().velocity = setup.scene.blocks[1].velocity;
  }
  return setup;
}

struct Case {
  const char* name;
  const char* table;    ///< "feature": what it adds; "unused": it must add nothing
  const char* against;  ///< the scene that lacks it
  const char* words;
  std::function<Setup()> make;
};

template <typename Change>
Case changed(const char* name, const char* table, const char* against, const char* words,
             Setup (*make)(), Change change) {
  return {name, table, against, words, [=] {
            Setup setup = make();
            change(setup);
            return setup;
          }};
}

std::vector<Case> features() {
  const char* const t = "feature";
  using S = Setup&;
  const auto same = [](S) {};
  return {
      changed("base", t, "", "rigid block slides on a fixed one, no friction", base, same),
      changed("friction", t, "base", "friction, sliding", rough, same),
      changed("strength", t, "friction", "cohesion and tension (broken by sliding)", rough,
              [](S s) { s.scene.joint.cohesion = s.scene.joint.tension = 1.0; }),
      changed("deformable", t, "base", "the block deforms: 12 unknowns", base,
              [](S s) {
                s.scene.blocks[1].kind = solver::BlockKind::Deformable;
                s.scene.blocks[1].material = kElastic;
              }),
      changed("springs", t, "base", "springs instead of exact contact", base,
              [](S s) { s.options.method = solver::ContactMethod::Springs; }),
      changed("paper", t, "base", "the source's augmented Lagrangian instead of exact contact",
              base, [](S s) { s.options.method = solver::ContactMethod::Paper; }),
      changed("energy_momentum", t, "base", "forces at the middle of the step", base,
              [](S s) { s.options.scheme = solver::TimeScheme::EnergyMomentum; }),
      changed("point_load", t, "base", "a constant force on a point", base,
              [](S s) {
                s.scene.point_loads = {{1, {0.5, 0.5, 1}, Vector3(0, 0, -100)}};
              }),
      changed("load_table", t, "point_load", "the force by a table in time", base,
              [](S s) {
                s.scene.point_loads = {
                    {1, {0.5, 0.5, 1}, solver::interpolate({0, 1}, {{0, 0, -100}, {0, 0, -100}})}};
              }),
      changed("prescribed", t, "base", "the slab moves as prescribed", base,
              [](S s) {
                s.scene.blocks[0].kind = solver::BlockKind::Prescribed;
                s.scene.blocks[0].motion.value = Vector3(0.1, 0, 0);
              }),
      changed("static", t, "base", "static instead of dynamic", base,
              [](S s) { s.options.analysis = solver::Analysis::Static; }),
      changed("at_rest", t, "base", "the block stands: nothing is solved or searched again", base,
              [](S s) { s.scene.blocks[1].velocity.setZero(); }),
      changed("writers", t, "base", "ParaView files after each step", base,
              [](S s) { s.writes = true; }),
      changed("fixed_block", t, "base", "a second fixed block, touching the first alone", base,
              [](S s) {
                s.scene.add_fixed(geometry::make_box({-5, -5, -2}, {5, 5, -1}));
              }),
      changed("tie", t, "base", "a tie to a place in the world", base,
              [](S s) {
                s.scene.ties = {
                    {.b = 1, .point_a = {0.5, 0.5, 9}, .point_b = {0.5, 0.5, 1}, .stiffness = 1e5}};
              }),
      changed("water", t, "base", "water presses on a face", base,
              [](S s) {
                const solver::PressureField field{[](const Vector3&, double) { return 1e3; }, true};
                s.scene.pressure_loads = {
                    {.block = 1,
                     .corners = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
                     .field = std::make_shared<const solver::PressureField>(field)}};
              }),
      changed("compound", t, "base", "the block is of two parts", base,
              [](S s) {
                const solver::Block block =
                    solver::compound({geometry::make_box({0, 0, 0}, {1, 1, 0.5}),
                                      geometry::make_box({0, 0, 0.5}, {1, 1, 1})});
                s.scene.blocks[1].shape = block.shape;
                s.scene.blocks[1].parts = block.parts;
              }),
      changed("quiet_face", t, "base", "a quiet face", base,
              [](S s) {
                s.scene.quiet_faces = {
                    {.block = 1, .normal_impedance = 1e3, .shear_impedance = 1e3}};
              }),
      changed("block_joint", t, "base", "a joint of this pair of blocks alone", base,
              [](S s) {
                s.scene.block_joints = {{0, 1, {}}};
              }),
      {"blocks_2", t, "base", "a second block that slides, apart", [] { return row(2); }},
      {"blocks_14", t, "base", "14 blocks: all 105 pairs of boxes tried", [] { return row(14); }},
      {"blocks_20", t, "base", "20 blocks: tree of boxes", [] { return row(20); }},
      {"threads_2", t, "blocks_20", "two threads asked for 20 pairs",
       [] {
         Setup setup = row(20);
         setup.options.threads = 2;
         return setup;
       }},
  };
}

std::vector<Case> unused() {
  const char* const t = "unused";
  using S = Setup&;
  return {
      changed("unused_pair_joint", t, "base", "a joint of groups that no block is of", base,
              [](S s) {
                s.scene.pair_joints = {{7,
                                        8,
                                        {.friction_angle = 0.5,
                                         .cohesion = 1e3,
                                         .tension = 1e3,
                                         .restitution = 0.5,
                                         .dilation_angle = 0.1}}};
              }),
      changed("unused_restitution", t, "base", "restitution where nothing bounces", base,
              [](S s) { s.scene.joint.restitution = 0.5; }),
      changed("unused_residuals", t, "friction", "residual strength of a joint without strength",
              rough, [](S s) { s.scene.joint.residual_friction_angle = 0.2; }),
      changed("unused_loads", t, "base", "point, face and body load of zero", base,
              [](S s) {
                s.scene.point_loads = {{1, {0.5, 0.5, 1}, Vector3(0, 0, 0)}};
                s.scene.face_loads = {{1, 0, Vector3(0, 0, 0)}};
                s.scene.body_loads = {{1, Vector3(0, 0, 0)}};
              }),
      changed("unused_motion", t, "base", "prescribed motion of zero", base,
              [](S s) { s.scene.blocks[0].kind = solver::BlockKind::Prescribed; }),
      changed("unused_elasticity", t, "base", "elastic constants and stress of a rigid block", base,
              [](S s) {
                s.scene.blocks[1].material = kElastic;
                s.scene.blocks[1].initial_stress.setConstant(1e3);
              }),
      changed("unused_slab_material", t, "base", "density and elasticity of a fixed block", base,
              [](S s) { s.scene.blocks[0].material = kElastic; }),
      changed("unused_penalty", t, "base", "a penalty where contact is exact", base,
              [](S s) {
                s.options.penalty = 1e7;
                s.options.shear_ratio = 0.5;
              }),
      changed("unused_limits", t, "base", "limits of displacement and time step, not reached", base,
              [](S s) {
                s.options.max_displacement_ratio = 0.5;
                s.options.smallest_time_step = 1e-6;
              }),
      changed("unused_threads", t, "base", "threads for a single pair", base,
              [](S s) { s.options.threads = 8; }),
      changed("unused_scheme", t, "static",
              "time scheme, velocity and restitution in a static scene", base,
              [](S s) {
                s.options.analysis = solver::Analysis::Static;
                s.options.scheme = solver::TimeScheme::EnergyMomentum;
                s.scene.blocks[1].velocity = {3.0, 0.0, 0.0};
                s.scene.joint.restitution = 0.5;
              }),
  };
}

std::vector<Case> all_cases() {
  std::vector<Case> cases = features();
  for (Case& one : unused()) cases.push_back(std::move(one));
  return cases;
}

class Run {
 public:
  explicit Run(const Setup& setup)
      : simulation_(setup.scene, setup.options), writes_(setup.writes) {}
  bool steps(int count) {
    for (int i = 0; i < count; ++i) {
      if (simulation_.advance().status != solver::StepStatus::Converged) return false;
      if (!writes_) continue;
      solver::write_blocks(path("quoin_lean_blocks.vtu"), simulation_);
      solver::write_contacts(path("quoin_lean_contacts.vtp"), simulation_);
    }
    return true;
  }

 private:
  static std::string path(const char* name) {
    return (std::filesystem::temp_directory_path() / name).string();
  }
  solver::Simulation simulation_;
  bool writes_;
};

}  // namespace

/// What callgrind counts.
extern "C" [[gnu::noinline]] bool quoin_lean_steps(void* run) {
  return static_cast<Run*>(run)->steps(kSteps);
}

namespace {

int run_one(const Case& one) {
  const Setup setup = one.make();
  const long before = bench::bytes_in_use();
  bench::start_peak();
  Run run(setup);
  if (!run.steps(kWarmSteps)) return 1;
  const long count = bench::allocation_count();
  if (!quoin_lean_steps(&run)) return 1;
  std::printf("{\"steps\": %d, \"held\": %ld, \"peak\": %ld, \"allocations\": %.3f}\n", kSteps,
              bench::bytes_in_use() - before, bench::peak_bytes() - before,
              static_cast<double>(bench::allocation_count() - count) / kSteps);
  return 0;
}

int time_all() {
  constexpr int kRounds = 15;
  const std::vector<Case> cases = all_cases();
  std::vector<double> least(cases.size(), std::numeric_limits<double>::infinity());
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t c = 0; c < cases.size(); ++c) {
      Run run(cases[c].make());
      if (!run.steps(kWarmSteps)) return 1;
      const auto start = std::chrono::steady_clock::now();
      if (!quoin_lean_steps(&run)) return 1;
      const std::chrono::duration<double, std::micro> passed =
          std::chrono::steady_clock::now() - start;
      least[c] = std::min(least[c], passed.count() / kSteps);
    }
  }
  for (std::size_t c = 0; c < cases.size(); ++c)
    std::printf("%s\"%s\": %.3f", c == 0 ? "{" : ", ", cases[c].name, least[c]);
  std::printf("}\n");
  return 0;
}

int list() {
  for (const Case& one : all_cases())
    std::printf("%s\t%s\t%s\t%s\n", one.name, one.table, one.against, one.words);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string wanted = argc == 2 ? argv[1] : "";
  if (wanted == "--list") return list();
  if (wanted == "--times") return time_all();
  for (const Case& one : all_cases())
    if (wanted == one.name) return run_one(one);
  std::fprintf(stderr, "usage: %s --list | --times | NAME\n", argv[0]);
  return 2;
}
