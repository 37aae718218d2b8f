/// ODE's box test (Debian's build: double precision).

#include <ode/ode.h>

#include <limits>

#include "peer.hpp"

namespace quoin::bench {
namespace {

static_assert(sizeof(dReal) == sizeof(double));

struct Box {
  dVector3 place, sides;
  dMatrix3 rotation;
};

Box box_of(const BenchShape& shape, const Pose& pose) {
  Box box{};
  for (int i = 0; i < 3; ++i) {
    box.place[i] = pose.place[i];
    box.sides[i] = 2 * shape.half_size[i];
    for (int j = 0; j < 3; ++j) box.rotation[4 * i + j] = pose.rotation(i, j);
  }
  return box;
}

/// dBoxBox on all pairs of boxes; up to eight points.
class BoxBox {
 public:
  static bool answers(const Workload& workload) {
    return workload.boxes_only() && workload.overlap;  // it says nothing of separated boxes
  }
  void load(const Workload& workload) {
    boxes_.clear();
    for (const Pair& pair : workload.pairs) {
      boxes_.push_back(
          box_of(workload.shapes[static_cast<std::size_t>(pair.shape_a)], pair.poses_a[0]));
      boxes_.push_back(
          box_of(workload.shapes[static_cast<std::size_t>(pair.shape_b)], pair.poses_b[0]));
    }
  }
  int find(int pair) {
    const Box& a = boxes_[2 * static_cast<std::size_t>(pair)];
    const Box& b = boxes_[2 * static_cast<std::size_t>(pair) + 1];
    int code = 0;
    depth = 0.0;
    return dBoxBox(a.place, a.rotation, a.sides, b.place, b.rotation, b.sides, normal, &depth,
                   &code, kMost, points, sizeof(dContactGeom));
  }
  static constexpr int kMost = 8;
  dVector3 normal{};
  dReal depth = 0.0;
  dContactGeom points[kMost];

 private:
  std::vector<Box> boxes_;
};

class Ode final : public PeerOf<Ode> {
 public:
  using PeerOf::PeerOf;
  bool answers(const Workload& workload) const override { return BoxBox::answers(workload); }
  void load(const Workload& workload) override { boxes_.load(workload); }
  void place(int) override {}
  Answer query(int pair) {
    if (boxes_.find(pair) == 0) return {};
    const Vector3 place(boxes_.points[0].pos[0], boxes_.points[0].pos[1], boxes_.points[0].pos[2]);
    return {-boxes_.depth, {boxes_.normal[0], boxes_.normal[1], boxes_.normal[2]}, place, place};
  }

 private:
  BoxBox boxes_;
};

class OdeManifold final : public ManifoldPeer {
 public:
  using ManifoldPeer::ManifoldPeer;
  bool answers(const Workload& workload) const override { return BoxBox::answers(workload); }
  void load(const Workload& workload) override { boxes_.load(workload); }
  void ask(int pair, std::vector<ManifoldPoint>& points) override {
    const int count = boxes_.find(pair);
    points.clear();
    for (int k = 0; k < count; ++k) {
      const dContactGeom& c = boxes_.points[k];
      points.push_back({{c.pos[0], c.pos[1], c.pos[2]}, -c.depth});
    }
  }
  double ask_all(std::span<const int> pairs) override {
    double sum = 0.0;
    for (const int pair : pairs) {
      boxes_.find(pair);
      sum += boxes_.depth;
    }
    return sum;
  }

 private:
  BoxBox boxes_;
};

}  // namespace

void append_ode(Peers& peers) { peers.push_back(std::make_unique<Ode>("ODE dBoxBox")); }
void append_ode(ManifoldPeers& peers) {
  peers.push_back(std::make_unique<OdeManifold>("ODE dBoxBox"));
}

}  // namespace quoin::bench
