/// Bullet's rigid bodies (double precision) with its sequential-impulse and NNCG solvers.

#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Eigenvalues>

#include "rigid_scenes.hpp"

namespace quoin::bench {
namespace {

btVector3 to_bullet(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Vector3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// Bullet's axes of a body in its own: those of inertia, of which it knows no others.
Eigen::Quaterniond axes_of(const RigidBody& body) {
  if (body.half_size.x() > 0.0) return Eigen::Quaterniond::Identity();
  Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body.inertia).eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) *= -1.0;
  return Eigen::Quaterniond(axes);
}

std::unique_ptr<btCollisionShape> shape_of(const RigidBody& body, const Eigen::Quaterniond& axes) {
  if (body.half_size.x() > 0.0) return std::make_unique<btBoxShape>(to_bullet(body.half_size));
  auto shape = std::make_unique<btConvexHullShape>();
  for (Eigen::Index i = 0; i < body.vertices.cols(); ++i)
    shape->addPoint(to_bullet(axes.conjugate() * body.vertices.col(i)));
  shape->setMargin(1e-6);  // it lies around the hull: hulls laid without gaps overlap by two
  return shape;
}

class BulletWorld final : public World {
 public:
  BulletWorld(const RigidScene& scene, double time_step, int iterations,
              std::unique_ptr<btConstraintSolver> solver)
      : solver_(std::move(solver)),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broad_phase_, solver_.get(), &configuration_),
        moved_(moved_bodies(scene)),
        scene_(scene),
        time_step_(time_step) {
    world_.setGravity(to_bullet(scene.gravity));
    world_.getSolverInfo().m_numIterations = iterations;
    for (const RigidBody& body : scene.bodies) add(body);
  }
  ~BulletWorld() override {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  bool step(double dt) override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) bodies_[i]->applyCentralForce(forces_[i]);
    for (MovedBody& moved : moved_) {
      moved.advance(scene_, time_, dt);
      btTransform& transform = bodies_[static_cast<std::size_t>(moved.body)]->getWorldTransform();
      transform.setOrigin(to_bullet(moved.place));
    }
    world_.stepSimulation(dt, 0);
    time_ += dt;
    for (const MovedBody& moved : moved_)
      work_ -= dt * force_on(moved.body).dot(moved.mean_velocity);
    return true;
  }
  double work() const override { return work_; }
  BodyMotion motion(int index) const override {
    const auto i = static_cast<std::size_t>(index);
    const btRigidBody& body = *bodies_[i];
    const btQuaternion q = body.getWorldTransform().getRotation();
    const Eigen::Quaterniond turn(q.w(), q.x(), q.y(), q.z());
    return {from_bullet(body.getWorldTransform().getOrigin()),
            from_bullet(body.getLinearVelocity()), from_bullet(body.getAngularVelocity()),
            turn * axes_[i].conjugate()};
  }
  std::vector<PairForce> forces() const override {
    std::vector<PairForce> result;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold =
          *const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(m);
      PairForce pair{manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()};
      for (int p = 0; p < manifold.getNumContacts(); ++p) {
        const btManifoldPoint& point = manifold.getContactPoint(p);  // its normal: towards body 0
        const double force = point.getAppliedImpulse() / time_step_;
        pair.normal += force;
        pair.on_b -= force * from_bullet(point.m_normalWorldOnB);
      }
      if (pair.a > pair.b) {
        std::swap(pair.a, pair.b);
        pair.on_b = -pair.on_b;
      }
      result.push_back(pair);
    }
    return result;
  }

 private:
  /// With friction, N.
  Vector3d force_on(int body) const {
    Vector3d impulse = Vector3d::Zero();
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold =
          *const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(m);
      const bool first = manifold.getBody0()->getUserIndex() == body;
      if (!first && manifold.getBody1()->getUserIndex() != body) continue;
      for (int p = 0; p < manifold.getNumContacts(); ++p) {
        const btManifoldPoint& point = manifold.getContactPoint(p);
        const btVector3 on_first = point.getAppliedImpulse() * point.m_normalWorldOnB +
                                   point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1;
        impulse += (first ? 1.0 : -1.0) * from_bullet(on_first);
      }
    }
    return impulse / time_step_;
  }

  /// Bullet multiplies those of two bodies.
  double friction_of(const RigidBody& body) const {
    const double own = std::sqrt(scene_.friction);
    const bool as_others = body.density > 0.0 || !scene_.held_friction;
    return as_others ? own : *scene_.held_friction / own;
  }

  void add(const RigidBody& body) {
    axes_.push_back(axes_of(body));
    shapes_.push_back(shape_of(body, axes_.back()));
    const Eigen::Matrix3d axes = axes_.back().toRotationMatrix();
    const Vector3d inertia = (axes.transpose() * body.inertia * axes).diagonal();
    btRigidBody::btRigidBodyConstructionInfo info(body.mass, nullptr, shapes_.back().get(),
                                                  to_bullet(inertia));
    const Eigen::Quaterniond q = body.turn * axes_.back();
    info.m_startWorldTransform =
        btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), to_bullet(body.place));
    info.m_friction = friction_of(body);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    if (body.acceleration) {
      bodies_.back()->setCollisionFlags(bodies_.back()->getCollisionFlags() |
                                        btCollisionObject::CF_KINEMATIC_OBJECT);
    }
    if (body.density > 0.0) {
      bodies_.back()->setLinearVelocity(to_bullet(body.velocity));
      bodies_.back()->setAngularVelocity(to_bullet(body.spin));
    }
    bodies_.back()->setUserIndex(static_cast<int>(bodies_.size()) - 1);
    forces_.push_back(to_bullet(body.force));
    world_.addRigidBody(bodies_.back().get());
  }

  std::unique_ptr<btConstraintSolver> solver_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broad_phase_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<btVector3> forces_;
  std::vector<Eigen::Quaterniond> axes_;
  std::vector<MovedBody> moved_;
  RigidScene scene_;
  double time_step_, time_ = 0.0, work_ = 0.0;
};

}  // namespace

std::unique_ptr<World> make_bullet(const RigidScene& scene, double time_step, int iterations) {
  return std::make_unique<BulletWorld>(scene, time_step, iterations,
                                       std::make_unique<btSequentialImpulseConstraintSolver>());
}

std::unique_ptr<World> make_bullet_nncg(const RigidScene& scene, double time_step, int iterations) {
  return std::make_unique<BulletWorld>(scene, time_step, iterations,
                                       std::make_unique<btNNCGConstraintSolver>());
}

}  // namespace quoin::bench
