#pragma once
/// Bodies for the tests of finder and batch.

#include <memory>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/executor.hpp>
#include <vector>

#include "support/message.hpp"
#include "support/random.hpp"

namespace quoin::tests {

using SharedShape = std::shared_ptr<const geometry::Shape>;

inline const geometry::Vector3 kBrick(0.4, 0.2, 0.2);  // m

inline SharedShape box(const geometry::Vector3& extent) {
  return std::make_shared<const geometry::Shape>(geometry::make_box(-0.5 * extent, 0.5 * extent));
}

inline SharedShape tetrahedron() {
  geometry::Points points(3, 4);
  points << -0.2, 0.2, 0, 0, -0.1, -0.1, 0.2, 0, -0.1, -0.1, -0.1, 0.1;
  return std::make_shared<const geometry::Shape>(geometry::make_hull(points).polyhedron);
}

/// A wall with joints of 0.1 mm, whose bricks are off by `jitter`, m.
inline std::vector<geometry::Placement> wall(int rows, int columns, double jitter, Random& random) {
  std::vector<geometry::Placement> placements;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const geometry::Vector3 place(0.4001 * (column + 0.5 * (row % 2)), 0, 0.2001 * row);
      placements.push_back({geometry::Matrix3::Identity(), place + jitter * random.point(-1, 1)});
    }
  }
  return placements;
}

/// Workers one after the other, the last one first.
class Backwards final : public geometry::Executor {
 public:
  explicit Backwards(int workers) : workers_(workers) {}
  int workers() const override { return workers_; }
  void run(Task task, void* context) override {
    ++calls;
    for (int worker = workers_; worker-- > 0;) task(context, worker);
  }
  int calls = 0;

 private:
  int workers_;
};

}  // namespace quoin::tests
