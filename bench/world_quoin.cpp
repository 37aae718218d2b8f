/// quoin's rigid blocks, default options, one thread.

#include <quoin/geometry/build.hpp>
#include <quoin/solver.hpp>

#include "rigid_scenes.hpp"

namespace quoin::bench {
namespace {

geometry::Shape shape_of(const RigidBody& body) {
  if (body.half_size.x() <= 0.0) {
    const Eigen::Matrix3Xd world =
        (body.turn.toRotationMatrix() * body.vertices).colwise() + body.place;
    return geometry::make_hull(world).polyhedron;
  }
  geometry::Shape shape = geometry::make_box(-body.half_size, body.half_size);
  geometry::Points vertices(3, shape.topology().vertex_count());
  for (int i = 0; i < shape.topology().vertex_count(); ++i)
    vertices.col(i) = body.place + body.turn * shape.vertex(i);
  shape.set_vertices(vertices);
  return shape;
}

solver::Scene scene_of(const RigidScene& rigid) {
  solver::Scene scene;
  scene.joint.friction_angle = std::atan(rigid.friction);
  scene.gravity = rigid.gravity;
  const double held_friction = rigid.held_friction.value_or(rigid.friction);
  constexpr int kHeld = 1;  // its joint group
  if (held_friction != rigid.friction)
    scene.pair_joints.push_back({0, kHeld, {.friction_angle = std::atan(held_friction)}});
  for (const RigidBody& body : rigid.bodies) {
    if (body.density == 0.0) {
      scene.add_fixed(shape_of(body), {.joint_group = kHeld});
      if (body.acceleration) {
        scene.blocks.back().kind = solver::BlockKind::Prescribed;
        scene.blocks.back().motion = {solver::MotionKind::Acceleration, body.acceleration};
      }
      continue;
    }
    const int block = scene.add_rigid(shape_of(body), {.density = body.density});
    scene.blocks.back().velocity = body.velocity;
    scene.blocks.back().angular_velocity = body.spin;
    if (!body.force.isZero(0.0))
      scene.point_loads.push_back({block, body.place, solver::VectorOfTime(body.force)});
  }
  return scene;
}

class QuoinWorld final : public World {
 public:
  QuoinWorld(const RigidScene& scene, double time_step)
      : scene_(scene),
        simulation_(scene_of(scene),
                    {.time_step = time_step, .watch = [this](const solver::StepReport&) {
                       return !goes_on_ || goes_on_();
                     }}) {}
  void watch(std::function<bool()> goes_on) override { goes_on_ = std::move(goes_on); }
  bool step(double) override {
    const solver::StepReport report = simulation_.advance();
    factorizations_ += report.factorizations;
    return report.status == solver::StepStatus::Converged;
  }
  double work() const override { return simulation_.state().energy.work; }
  long factorizations() const override { return factorizations_; }
  BodyMotion motion(int body) const override {
    const auto b = static_cast<std::size_t>(body);
    const solver::BlockState& block = simulation_.state().blocks[b];
    const RigidBody& start = scene_.bodies[b];
    return {simulation_.state().origin + block.centroid, block.velocity,
            block.rotation * block.angular_velocity, block.rotation * start.turn};
  }
  std::vector<PairForce> forces() const override {
    std::vector<PairForce> result;
    for (const solver::Contact& contact : simulation_.state().contacts) {
      result.push_back({contact.point.key.a, contact.point.key.b, contact.normal_force,
                        contact.normal_force * contact.point.normal});
    }
    return result;
  }

 private:
  RigidScene scene_;
  std::function<bool()> goes_on_{};
  solver::Simulation simulation_;
  long factorizations_ = 0;
};

}  // namespace

std::unique_ptr<World> make_quoin(const RigidScene& scene, double time_step, int) {
  return std::make_unique<QuoinWorld>(scene, time_step);
}

}  // namespace quoin::bench
