/// FCL's dynamic tree manager, used as its documentation says: objects moved, update(), collide().

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>

#include "boxes_peer.hpp"

namespace quoin::bench {
namespace {

bool count_pair(fcl::CollisionObjectd*, fcl::CollisionObjectd*, void* count) {
  ++*static_cast<std::size_t*>(count);
  return false;
}

class FclBoxes final : public BoxesPeer {
 public:
  using BoxesPeer::BoxesPeer;
  void load(std::span<const geometry::Box> boxes) override {
    manager_.clear();
    objects_.clear();
    // All in place and at once: one by one, still at the origin, they would make a degenerate tree.
    std::vector<fcl::CollisionObjectd*> all;
    for (const geometry::Box& box : boxes) {
      const geometry::Vector3 size = box.max - box.min;
      objects_.push_back(
          std::make_unique<fcl::CollisionObjectd>(std::make_shared<fcl::Boxd>(size)));
      all.push_back(objects_.back().get());
    }
    move(boxes);
    manager_.registerObjects(all);
    manager_.setup();
  }
  std::size_t step(std::span<const geometry::Box> boxes) override {
    move(boxes);
    manager_.update();
    std::size_t count = 0;
    manager_.collide(&count, count_pair);
    return count;
  }

 private:
  void move(std::span<const geometry::Box> boxes) {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      objects_[i]->setTranslation(0.5 * (boxes[i].min + boxes[i].max));
      objects_[i]->computeAABB();
    }
  }
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_;
  fcl::DynamicAABBTreeCollisionManagerd manager_;
};

}  // namespace

void append_fcl(BoxesPeers& peers) { peers.push_back(std::make_unique<FclBoxes>("FCL tree")); }

}  // namespace quoin::bench
