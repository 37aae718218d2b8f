#pragma once
/// Broad phases: boxes in, number of pairs of touching boxes out, step after step.

#include <memory>
#include <quoin/geometry/body.hpp>
#include <span>
#include <string>
#include <vector>

namespace quoin::bench {

class BoxesPeer {
 public:
  explicit BoxesPeer(std::string name) : name_(std::move(name)) {}
  virtual ~BoxesPeer() = default;
  const std::string& name() const { return name_; }
  virtual void load(std::span<const geometry::Box> boxes) = 0;  ///< not timed
  /// Timed: takes the boxes over and finds the pairs; returns how many it lists.
  virtual std::size_t step(std::span<const geometry::Box> boxes) = 0;

 private:
  std::string name_;
};
using BoxesPeers = std::vector<std::unique_ptr<BoxesPeer>>;

#ifdef QUOIN_BENCH_FCL
void append_fcl(BoxesPeers& peers);
#endif
#ifdef QUOIN_BENCH_BULLET
void append_bullet(BoxesPeers& peers);

/// Bullet's whole collision step of boxes that move: tree, pairs and manifolds.
class BulletCollisionStep {
 public:
  BulletCollisionStep(const geometry::Vector3& size, std::span<const geometry::Placement> at);
  ~BulletCollisionStep();
  void step(std::span<const geometry::Placement> placements);

 private:
  struct World;
  std::unique_ptr<World> world_;
};
#endif

}  // namespace quoin::bench
