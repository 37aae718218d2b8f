/// ODE's rigid boxes: dWorldQuickStep with so many iterations, dWorldStep (its direct solver) with
/// 0.

#include <ode/ode.h>

#include <cstdarg>
#include <deque>

#include "rigid_scenes.hpp"

namespace quoin::bench {
namespace {

bool trouble = false;  // the library says so by a message only

void note_trouble(int, const char*, va_list) { trouble = true; }

struct Library {
  Library() {
    dInitODE2(0);
    dSetMessageHandler(note_trouble);
  }
  ~Library() { dCloseODE(); }
};

class OdeWorld final : public World {
 public:
  OdeWorld(const RigidScene& scene, int iterations)
      : scene_(scene),
        moved_(moved_bodies(scene)),
        iterations_(iterations),
        world_(dWorldCreate()),
        space_(dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ)),
        contacts_(dJointGroupCreate(0)) {
    dWorldSetGravity(world_, scene.gravity.x(), scene.gravity.y(), scene.gravity.z());
    if (iterations > 0) dWorldSetQuickStepNumIterations(world_, iterations);
    for (const RigidBody& body : scene.bodies) add(body);
  }
  ~OdeWorld() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }
  bool step(double dt) override {
    dJointGroupEmpty(contacts_);
    feedback_.clear();
    dSpaceCollide(space_, this, &OdeWorld::near);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i] == nullptr) continue;
      const Vector3d& f = scene_.bodies[i].force;
      dBodyAddForce(bodies_[i], f.x(), f.y(), f.z());
    }
    for (MovedBody& moved : moved_) {
      moved.advance(scene_, time_, dt);
      const Vector3d& v = moved.mean_velocity;
      dBodySetLinearVel(bodies_[static_cast<std::size_t>(moved.body)], v.x(), v.y(), v.z());
    }
    time_ += dt;
    trouble = false;
    const bool done = (iterations_ > 0 ? dWorldQuickStep(world_, dt) : dWorldStep(world_, dt)) != 0;
    for (const MovedBody& moved : moved_)
      work_ += dt * force_by(moved.body).dot(moved.mean_velocity);
    return done && !trouble;
  }
  double work() const override { return work_; }
  BodyMotion motion(int index) const override {
    const dBodyID body = bodies_[static_cast<std::size_t>(index)];
    if (body == nullptr) {
      const RigidBody& fixed = scene_.bodies[static_cast<std::size_t>(index)];
      return {fixed.place, Vector3d::Zero(), Vector3d::Zero(), fixed.turn};
    }
    const dReal* q = dBodyGetQuaternion(body);
    return {Vector3d(dBodyGetPosition(body)),
            Vector3d(dBodyGetLinearVel(body)),
            Vector3d(dBodyGetAngularVel(body)),
            {q[0], q[1], q[2], q[3]}};
  }
  std::vector<PairForce> forces() const override {
    std::vector<PairForce> result;
    for (const Feedback& f : feedback_) {
      // The normal points into the first body, which f1 acts on.
      const double force = f.normal.dot(Vector3d(f.joint.f1));
      const Vector3d on_second = -force * f.normal;
      result.push_back({std::min(f.first, f.second), std::max(f.first, f.second), std::abs(force),
                        f.first < f.second ? on_second : Vector3d(-on_second)});
    }
    return result;
  }

 private:
  struct Feedback {
    int first = 0, second = 0;
    Vector3d normal = Vector3d::Zero();
    dJointFeedback joint{};
  };

  /// Of a moved body on the others, with friction, N.
  Vector3d force_by(int body) const {
    Vector3d sum = Vector3d::Zero();
    for (const Feedback& f : feedback_) {
      if (f.first == body) sum += Vector3d(f.joint.f2);
      if (f.second == body) sum += Vector3d(f.joint.f1);
    }
    return sum;
  }

  void add(const RigidBody& body) {
    const dGeomID geom =
        dCreateBox(space_, 2 * body.half_size.x(), 2 * body.half_size.y(), 2 * body.half_size.z());
    dGeomSetData(geom, reinterpret_cast<void*>(bodies_.size()));
    const dQuaternion q = {body.turn.w(), body.turn.x(), body.turn.y(), body.turn.z()};
    if (body.acceleration) {
      bodies_.push_back(dBodyCreate(world_));
      dBodySetKinematic(bodies_.back());
      dGeomSetBody(geom, bodies_.back());
    } else if (body.density == 0.0) {
      bodies_.push_back(nullptr);
    } else {
      const dBodyID id = dBodyCreate(world_);
      dMass mass;
      dMassSetBoxTotal(&mass, body.mass, 2 * body.half_size.x(), 2 * body.half_size.y(),
                       2 * body.half_size.z());
      dBodySetMass(id, &mass);
      dBodySetLinearVel(id, body.velocity.x(), body.velocity.y(), body.velocity.z());
      dBodySetAngularVel(id, body.spin.x(), body.spin.y(), body.spin.z());
      dGeomSetBody(geom, id);
      bodies_.push_back(id);
    }
    dGeomSetPosition(geom, body.place.x(), body.place.y(), body.place.z());
    dGeomSetQuaternion(geom, q);
  }

  static void near(void* self, dGeomID a, dGeomID b) { static_cast<OdeWorld*>(self)->touch(a, b); }

  static bool moves_freely(dGeomID geom) {
    const dBodyID body = dGeomGetBody(geom);
    return body != nullptr && dBodyIsKinematic(body) == 0;
  }

  void touch(dGeomID a, dGeomID b) {
    if (!moves_freely(a) && !moves_freely(b)) return;
    dContactGeom found[8];
    const int count = dCollide(a, b, 8, found, sizeof(dContactGeom));
    for (int i = 0; i < count; ++i) {
      dContact contact{};
      contact.geom = found[i];
      contact.surface.mode = dContactApprox1;
      const bool free = moves_freely(a) && moves_freely(b);
      contact.surface.mu = free ? scene_.friction : scene_.held_friction.value_or(scene_.friction);
      const dJointID joint = dJointCreateContact(world_, contacts_, &contact);
      dJointAttach(joint, dGeomGetBody(a), dGeomGetBody(b));
      Feedback f{static_cast<int>(reinterpret_cast<std::size_t>(dGeomGetData(a))),
                 static_cast<int>(reinterpret_cast<std::size_t>(dGeomGetData(b))),
                 Vector3d(found[i].normal),
                 {}};
      feedback_.push_back(f);
      dJointSetFeedback(joint, &feedback_.back().joint);
    }
  }

  RigidScene scene_;
  std::vector<MovedBody> moved_;
  double time_ = 0.0, work_ = 0.0;
  int iterations_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  std::vector<dBodyID> bodies_;
  std::deque<Feedback> feedback_;
};

}  // namespace

std::unique_ptr<World> make_ode(const RigidScene& scene, double, int iterations) {
  static const Library library;
  return std::make_unique<OdeWorld>(scene, iterations);
}

}  // namespace quoin::bench
