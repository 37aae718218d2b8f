#include <quoin/geometry/broad_phase.hpp>

#include "boxes_peer.hpp"

namespace quoin::bench {
namespace {

class QuoinBoxes final : public BoxesPeer {
 public:
  using BoxesPeer::BoxesPeer;
  void load(std::span<const geometry::Box> boxes) override {
    broad_phase_ = {};
    broad_phase_.find_candidates(boxes, 0.0);
  }
  std::size_t step(std::span<const geometry::Box> boxes) override {
    return broad_phase_.find_candidates(boxes, 0.0).size();
  }

 private:
  geometry::BroadPhase broad_phase_;
};

}  // namespace

void append_quoin(BoxesPeers& peers) { peers.push_back(std::make_unique<QuoinBoxes>("quoin")); }

}  // namespace quoin::bench
