/// Blocks of several convex parts: one motion, contacts by part.

#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver.hpp>
#include <quoin/solver/equilibrium.hpp>
#include <sstream>

#include "support/catch.hpp"

using namespace quoin::solver;
namespace geometry = quoin::geometry;
using namespace quoin::tests;

namespace {

const Material kStone{.density = 2000, .young = 1e9, .poisson = 0.2};

/// Turned, and as far away as wanted.
struct Frame {
  Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  Vector3 origin = Vector3::Zero();
  double stretch = 1.0;
  geometry::Placement placement() const { return {turn, origin}; }
  Vector3 gravity(const Vector3& local) const { return turn * local; }
};

Block block_of(std::vector<geometry::Shape> parts, BlockKind kind, const Frame& frame) {
  Block block;
  block.shape = std::make_shared<const geometry::Shape>(parts.front());
  if (parts.size() > 1) block = compound(std::move(parts));
  block.material = kStone;
  block.kind = kind;
  block.placement = frame.placement();
  return block;
}

std::vector<geometry::Shape> ell() {  // foot along x, upright at its left end; centroid x = 0.75
  return {geometry::make_box({0, 0, 0}, {2, 1, 1}), geometry::make_box({0, 0, 1}, {1, 1, 3})};
}

std::vector<geometry::Shape> whole() {
  return {geometry::make_box({-0.5, -0.2, 0}, {1, 0.6, 0.4})};
}
std::vector<geometry::Shape> halves() {
  return {geometry::make_box({-0.5, -0.2, 0}, {0.25, 0.6, 0.4}),
          geometry::make_box({0.25, -0.2, 0}, {1, 0.6, 0.4})};
}

Vector3 force_on(const Simulation& simulation, int block) {
  Vector3 sum = Vector3::Zero();
  for (const Contact& c : simulation.state().contacts) {
    const Vector3 on_b = c.normal_force * c.point.normal - c.shear_force;
    if (c.point.key.b == block) sum += on_b;
    if (c.point.key.a == block) sum -= on_b;
  }
  return sum;
}

double distance(const BlockState& a, const BlockState& b) {
  return (a.centroid - b.centroid + a.centroid_rest - b.centroid_rest).norm() +
         a.rotation.angularDistance(b.rotation) + (a.strain - b.strain).norm();
}

}  // namespace

TEST_CASE("Mass properties of parts sum up about their common centroid") {
  const std::vector<geometry::Shape> parts = ell();
  const geometry::MassProperties sum = geometry::mass_properties(geometry::join(parts));
  CHECK_THAT(sum.volume, WithinRel(4.0, 1e-14));
  CHECK((sum.centroid - Vector3(0.75, 0.5, 1.25)).norm() < 1e-14);
  // Of each box about its own centroid, and its volume at its distance.
  const double long_side = 4.0 / 12, short_side = 1.0 / 12;
  CHECK_THAT(sum.second_moment(0, 0),
             WithinRel(2.0 * (long_side + 0.0625) + 2.0 * (short_side + 0.0625), 1e-12));
  CHECK_THAT(sum.second_moment(2, 2),
             WithinRel(2.0 * (short_side + 0.5625) + 2.0 * (long_side + 0.5625), 1e-12));
  CHECK_THAT(sum.second_moment(0, 2), WithinRel(-2.0 * 0.25 * 0.75 - 2.0 * 0.25 * 0.75, 1e-12));
  const std::vector<geometry::Shape> none;
  CHECK_THROWS_AS(compound(none), InputError);
}

TEST_CASE("A box cut in two and joined moves as the whole one") {
  const BlockKind kind = GENERATE(BlockKind::Rigid, BlockKind::Deformable);
  const double far = GENERATE(0.0, 1e5);
  const Frame frame{.origin = far * Vector3(1, -2, 0.5)};
  const auto end = [&](std::vector<geometry::Shape> parts) {
    Scene scene{.joint = {.friction_angle = 0.3, .restitution = 0.5}};
    scene.gravity = frame.gravity({0.5, 0, -9.81});
    const auto floor = std::vector{geometry::make_box({-5, -5, -1.1}, {5, 5, -0.1})};
    scene.blocks.push_back(block_of(floor, BlockKind::Fixed, frame));
    scene.blocks.push_back(block_of(std::move(parts), kind, frame));
    scene.blocks.back().angular_velocity = frame.turn * Vector3(0.4, 0.2, -0.3);
    Simulation simulation(scene, {.time_step = 1e-3});
    const double start = simulation.state().energy.mechanical();
    for (int step = 0; step < 250; ++step) {
      REQUIRE(simulation.advance().status == StepStatus::Converged);
    }
    return std::pair(simulation.state(), start);
  };
  const State one = end(whole()).first;
  const auto [two, start] = end(halves());
  CHECK(distance(one.blocks[1], two.blocks[1]) < (kind == BlockKind::Rigid ? 1e-7 : 1e-6));
  const EnergyLedger& ledger = two.energy;
  const double lost = ledger.friction_loss + ledger.impact_loss + ledger.algorithmic_loss;
  CHECK_THAT(ledger.mechanical() + lost - ledger.work, WithinAbs(start, 1e-7 * 2000 * 0.48 * 9.81));
  CHECK_THAT(ledger.mechanical(), WithinRel(one.energy.mechanical(), 1e-6));
}

TEST_CASE("An L-stone rests on its foot by its weight") {
  const BlockKind kind = GENERATE(BlockKind::Rigid, BlockKind::Deformable);
  const double far = GENERATE(0.0, 1e5);
  const Frame frame{.origin = far * Vector3(1, -2, 0.5)};
  Scene scene{.joint = {.friction_angle = 0.5}};
  scene.gravity = frame.gravity({0, 0, -9.81});
  scene.blocks.push_back(
      block_of({geometry::make_box({-5, -5, -1}, {5, 5, 0})}, BlockKind::Fixed, frame));
  scene.blocks.push_back(block_of(ell(), kind, frame));
  Simulation simulation(scene, {.time_step = 1e-2, .analysis = Analysis::Static});
  for (int step = 0; step < 5; ++step) {
    REQUIRE(simulation.advance().status == StepStatus::Converged);
  }
  const double weight = 2000 * 4.0 * 9.81;
  CHECK((force_on(simulation, 1) - frame.gravity({0, 0, weight})).norm() < 1e-6 * weight);
}

TEST_CASE("An L-stone tips when its centroid leaves its foot") {
  // Standing on its upright's end, the foot overhangs: the edge is at x = 1, the centroid at 0.75.
  // The floor tilts by gravity; tan = 0.25 / 1.75.
  const auto status = [](double tan) {
    Scene scene{.joint = {.friction_angle = 0.7}};
    scene.gravity = Vector3(9.81 * tan, 0, 9.81);
    const Frame frame{.turn = Matrix3::Identity()};
    scene.blocks.push_back(
        block_of({geometry::make_box({-5, -5, 3}, {5, 5, 4})}, BlockKind::Fixed, frame));
    scene.blocks.push_back(block_of(ell(), BlockKind::Rigid, frame));
    return find_equilibrium(equilibrium_problem(scene)).verdict;
  };
  CHECK(status(0.99 * 0.25 / 1.75) == EquilibriumVerdict::Admissible);
  CHECK(status(1.01 * 0.25 / 1.75) == EquilibriumVerdict::Mechanism);
}

TEST_CASE("A block slides over the flush parts of a floor, and on from a checkpoint") {
  const BlockKind kind = GENERATE(BlockKind::Rigid, BlockKind::Deformable);
  const Frame frame;
  Scene scene;
  scene.gravity = frame.gravity({0, 0, -9.81});
  scene.blocks.push_back(block_of({geometry::make_box({-1, -1, -1}, {0.1, 1, 0}),
                                   geometry::make_box({0.1, -1, -1}, {0.7, 0.05, 0}),
                                   geometry::make_box({0.1, 0.05, -1}, {0.7, 1, 0}),
                                   geometry::make_box({0.7, -1, -1}, {3, 1, 0})},
                                  BlockKind::Fixed, frame));
  scene.blocks.push_back(block_of({geometry::make_box({-0.6, -0.2, 0}, {-0.3, 0.3, 0.4}),
                                   geometry::make_box({-0.3, -0.2, 0}, {0, 0.3, 0.2})},
                                  kind, frame));
  scene.blocks.back().velocity = frame.turn * Vector3(1, 0.1, 0);
  Simulation simulation(scene, {.time_step = 5e-3});
  std::stringstream saved;
  for (int step = 0; step < 200; ++step) {
    if (step == 100) simulation.save(saved);
    REQUIRE(simulation.advance().status == StepStatus::Converged);
  }
  const BlockState& end = simulation.state().blocks[1];
  const Vector3 along = frame.turn.transpose() * end.velocity;  // it still swings a little, upwards
  CHECK((along - Vector3(1, 0.1, along.z())).norm() < 1e-9);
  Simulation resumed(scene, {.time_step = 5e-3}, saved);
  for (int step = 100; step < 200; ++step) {
    REQUIRE(resumed.advance().status == StepStatus::Converged);
  }
  CHECK(resumed.state().blocks[1].centroid == end.centroid);
}
