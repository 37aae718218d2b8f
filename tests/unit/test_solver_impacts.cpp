/// Impacts with known answers, where rounding or a moving frame could tell on them: at the very end
/// of a step, and on supports that move.

#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>
#include <vector>

#include "support/catch.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr Material kRock{.density = 2000, .young = 1e9, .poisson = 0.2};
constexpr double kGravity = 9.81;

/// Where a scene stands in the world: nothing hangs on it.
struct Frame {
  Matrix3 turn = Matrix3::Identity();
  Vector3 origin = Vector3::Zero();
};

std::vector<Frame> frames() {
  const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  return {{}, {.turn = turn}, {.turn = turn, .origin = {1000, -2000, 500}}};
}

/// Boxes on a floor whose top is at z = 0, as they stand in a frame.
class Boxes {
 public:
  explicit Boxes(const Frame& frame = {}) : frame_(frame) {
    scene.gravity = Vector3(frame.turn * Vector3(0, 0, -kGravity));
    scene.add_fixed(geometry::make_box({-50, -50, -1}, {50, 50, 1}));
    place({0, 0, -1}, scene.blocks.back());
  }

  int add(const Vector3& centre, const Vector3& half, const Vector3& velocity = Vector3::Zero()) {
    const int block = scene.add_rigid(geometry::make_box(-half, half), kRock);
    place(centre, scene.blocks.back());
    scene.blocks.back().velocity = frame_.turn * velocity;
    return block;
  }

  /// In the frame.
  Vector3 velocity(const Simulation& simulation, int block) const {
    return frame_.turn.transpose() *
           simulation.state().blocks[static_cast<std::size_t>(block)].velocity;
  }

  Scene scene;

 private:
  void place(const Vector3& centre, Block& block) const {
    block.placement = {.linear = frame_.turn, .translation = frame_.origin + frame_.turn * centre};
  }

  Frame frame_;
};

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(simulation.advance().status == StepStatus::Converged);
}

/// Of a block that falls on the floor, and goes along with it if that moves by `motion` (m/s).
Scene falling(double height, const Vector3& slides, double restitution) {
  Boxes boxes;
  boxes.scene.joint = {.friction_angle = 0.5, .restitution = restitution};
  boxes.add({0, 0, 0.125 + height}, {0.4, 0.4, 0.125}, slides);
  return boxes.scene;
}

Scene moved_along(Scene scene, const Vector3& motion) {
  scene.blocks[0].kind = BlockKind::Prescribed;
  scene.blocks[0].motion = {MotionKind::Velocity, motion};
  for (std::size_t b = 1; b < scene.blocks.size(); ++b) scene.blocks[b].velocity += motion;
  return scene;
}

}  // namespace

TEST_CASE("What lands on a support in steady motion does so as on one at rest") {
  constexpr int kSteps = 20;
  constexpr double kTimeStep = 0.01;
  struct Draw {
    double height;
    Vector3 slides;
    double restitution;
  };
  for (const Draw& draw : {Draw{0.1, {0, 0, 0}, 0.0}, Draw{0.1, {1, 0.5, 0}, 0.0},
                           Draw{0.1, {0, 0, 0}, 0.5}, Draw{0.0, {0, 0, -1}, 0.5}}) {
    const Scene scene = falling(draw.height, draw.slides, draw.restitution);
    Simulation at_rest(scene, {.time_step = kTimeStep});
    run(at_rest, kSteps);
    for (const Vector3& motion : {Vector3(5, 0, 0), Vector3(0, 0, 3), Vector3(2, -3, 1)}) {
      CAPTURE(draw.height, draw.slides.transpose(), draw.restitution, motion.transpose());
      Simulation moving(moved_along(scene, motion), {.time_step = kTimeStep});
      run(moving, kSteps);
      const BlockState &still = at_rest.state().blocks[1], &moved = moving.state().blocks[1];
      const Vector3 way = motion * (kSteps * kTimeStep);
      CHECK((moved.centroid - way - still.centroid).norm() < 1e-11);
      CHECK((moved.velocity - motion - still.velocity).norm() < 1e-11);
    }
  }
}

TEST_CASE("A block bounces on a lift that sets off as under more gravity") {
  constexpr double kTimeStep = 0.01, kHeight = 0.2, kLift = 4.0, kRestitution = 0.5;
  constexpr int kSteps = 25;
  Scene scene = falling(kHeight, Vector3::Zero(), kRestitution);
  scene.blocks[0].kind = BlockKind::Prescribed;
  scene.blocks[0].motion = {MotionKind::Acceleration, Vector3(0, 0, kLift)};
  Simulation simulation(scene, {.time_step = kTimeStep});
  run(simulation, kSteps);
  const double pull = kGravity + kLift, fall = std::sqrt(2.0 * kHeight / pull);
  const double end = kSteps * kTimeStep, since = end - fall;
  const double above = since * (kRestitution * pull * fall - 0.5 * pull * since);
  CHECK_THAT(simulation.state().blocks[1].centroid.z(),
             WithinAbs(0.125 + above + 0.5 * kLift * end * end, 1e-12));
}
