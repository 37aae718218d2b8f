/// Bullet's dbvt broad phase with its pair cache, used as btCollisionWorld does.

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>

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

}  // namespace

void append_bullet(BoxesPeers& peers) {
  peers.push_back(std::make_unique<BulletBoxes>("Bullet dbvt"));
}

}  // namespace quoin::bench
