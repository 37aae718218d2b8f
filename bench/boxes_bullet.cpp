/// Bullet's dbvt broad phase with its pair cache, used as btCollisionWorld does; and that world.

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <btBulletCollisionCommon.h>

#include "boxes_peer.hpp"

namespace quoin::bench {
namespace {

btVector3 to_bullet(const geometry::Vector3& v) { return {v.x(), v.y(), v.z()}; }

class BulletBoxes final : public BoxesPeer {
 public:
  using BoxesPeer::BoxesPeer;
  ~BulletBoxes() override { clear(); }
  void load(std::span<const geometry::Box> boxes) override {
    clear();
    broad_phase_ = std::make_unique<btDbvtBroadphase>();
    for (const geometry::Box& box : boxes) {
      proxies_.push_back(broad_phase_->createProxy(to_bullet(box.min), to_bullet(box.max), 0,
                                                   nullptr, 1, 1, nullptr));
    }
    broad_phase_->calculateOverlappingPairs(nullptr);
  }
  std::size_t step(std::span<const geometry::Box> boxes) override {
    for (std::size_t i = 0; i < boxes.size(); ++i)
      broad_phase_->setAabb(proxies_[i], to_bullet(boxes[i].min), to_bullet(boxes[i].max), nullptr);
    broad_phase_->calculateOverlappingPairs(nullptr);
    return static_cast<std::size_t>(
        broad_phase_->getOverlappingPairCache()->getNumOverlappingPairs());
  }

 private:
  void clear() {
    // Not by destroyProxy: it looks through all pairs for each proxy.
    broad_phase_.reset();
    for (btBroadphaseProxy* proxy : proxies_) btAlignedFree(proxy);
    proxies_.clear();
  }
  std::unique_ptr<btDbvtBroadphase> broad_phase_;
  std::vector<btBroadphaseProxy*> proxies_;
};

btTransform to_bullet(const geometry::Placement& placement) {
  const geometry::Matrix3& a = placement.linear;
  const btMatrix3x3 turn(a(0, 0), a(0, 1), a(0, 2), a(1, 0), a(1, 1), a(1, 2), a(2, 0), a(2, 1),
                         a(2, 2));
  return btTransform(turn, to_bullet(placement.translation));
}

}  // namespace

struct BulletCollisionStep::World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broad_phase;
  btCollisionWorld world{&dispatcher, &broad_phase, &configuration};
  btBoxShape box;
  std::vector<std::unique_ptr<btCollisionObject>> objects;
  explicit World(const geometry::Vector3& size) : box(to_bullet(0.5 * size)) {}
};

BulletCollisionStep::BulletCollisionStep(const geometry::Vector3& size,
                                         std::span<const geometry::Placement> at)
    : world_(std::make_unique<World>(size)) {
  for (const geometry::Placement& placement : at) {
    btCollisionObject& object =
        *world_->objects.emplace_back(std::make_unique<btCollisionObject>());
    object.setCollisionShape(&world_->box);
    object.setWorldTransform(to_bullet(placement));
    world_->world.addCollisionObject(&object);
  }
}
BulletCollisionStep::~BulletCollisionStep() {
  for (const auto& object : world_->objects) world_->world.removeCollisionObject(object.get());
}

void BulletCollisionStep::step(std::span<const geometry::Placement> placements) {
  for (std::size_t i = 0; i < placements.size(); ++i)
    world_->objects[i]->setWorldTransform(to_bullet(placements[i]));
  world_->world.performDiscreteCollisionDetection();
}

void append_bullet(BoxesPeers& peers) {
  peers.push_back(std::make_unique<BulletBoxes>("Bullet dbvt"));
}

}  // namespace quoin::bench
