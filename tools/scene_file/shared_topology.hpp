#pragma once
/// Equal topologies kept once: a wall of 1e5 bricks has one.

#include <map>
#include <quoin/geometry/shape.hpp>
#include <vector>

namespace quoin::scene_file {

class SharedTopologies {
 public:
  /// The same solid; its topology is that of an earlier one with the same faces in the same order.
  /// One with vertices that are no corners keeps its own.
  geometry::Shape share(const geometry::Shape& shape);

 private:
  std::map<std::vector<int>, std::shared_ptr<const geometry::Topology>> known_;
};

}  // namespace quoin::scene_file
