#pragma once
/// One interface for everybody who answers pairs, quoin among them.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "workloads.hpp"

namespace quoin::bench {

/// What a peer says about one pair. NaN gap: it gave none.
struct Answer {
  double gap = 0.0;  ///< m, negative: overlap
  Vector3 normal = Vector3::Zero();
  Vector3 point_a = Vector3::Zero(), point_b = Vector3::Zero();
};

class Peer {
 public:
  explicit Peer(std::string name) : name_(std::move(name)) {}
  virtual ~Peer() = default;
  const std::string& name() const { return name_; }

  /// Whether it has an answer to this kind of question at all.
  virtual bool answers(const Workload& workload) const = 0;
  /// Builds its shapes; not timed.
  virtual void load(const Workload& workload) = 0;
  /// Moves its shapes to the poses of a step; not timed with the queries.
  virtual void place(int step) = 0;
  /// Forgets what it learned of the steps before.
  virtual void forget() {}
  /// May throw.
  virtual Answer ask(int pair) = 0;
  /// What is timed: all these pairs, one after the other. Returns a sum of the gaps.
  virtual double ask_all(std::span<const int> pairs) = 0;

 private:
  std::string name_;
};

/// Keeps the call of `query` inside the timed loop free of virtual calls.
template <class Model>
class PeerOf : public Peer {
 public:
  using Peer::Peer;
  Answer ask(int pair) override { return static_cast<Model*>(this)->query(pair); }
  double ask_all(std::span<const int> pairs) override {
    double sum = 0.0;
    for (const int pair : pairs) sum += static_cast<Model*>(this)->query(pair).gap;
    return sum;
  }
};

/// A whole contact manifold: points on A and B with their gap.
struct ManifoldPoint {
  Vector3 place = Vector3::Zero();
  double gap = 0.0;  ///< m
};

class ManifoldPeer {
 public:
  explicit ManifoldPeer(std::string name) : name_(std::move(name)) {}
  virtual ~ManifoldPeer() = default;
  const std::string& name() const { return name_; }
  virtual bool answers(const Workload& workload) const = 0;
  virtual void load(const Workload& workload) = 0;
  virtual void ask(int pair, std::vector<ManifoldPoint>& points) = 0;
  virtual double ask_all(std::span<const int> pairs) = 0;

 private:
  std::string name_;
};

/// Shapes and the poses of one step, in the types of a peer.
template <class PeerShape, class Transform>
class Placed {
 public:
  explicit Placed(Transform (*transform)(const Pose&)) : transform_(transform) {}

  /// make(shape): a unique_ptr to the peer's own.
  template <class Make>
  void load(const Workload& workload, const Make& make) {
    workload_ = &workload;
    shapes_.clear();
    for (const BenchShape& shape : workload.shapes) shapes_.push_back(make(shape));
    place(0);
  }
  void place(int step) {
    poses_.clear();
    for (const Pair& pair : workload_->pairs) {
      poses_.push_back(transform_(pair.poses_a[index(step)]));
      poses_.push_back(transform_(pair.poses_b[index(step)]));
    }
  }
  const PeerShape& a(int p) const { return *shapes_[index(pair(p).shape_a)]; }
  const PeerShape& b(int p) const { return *shapes_[index(pair(p).shape_b)]; }
  const Transform& pose_a(int p) const { return poses_[2 * index(p)]; }
  const Transform& pose_b(int p) const { return poses_[2 * index(p) + 1]; }
  std::size_t pair_count() const { return workload_->pairs.size(); }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  const Pair& pair(int p) const { return workload_->pairs[index(p)]; }

  Transform (*transform_)(const Pose&);
  const Workload* workload_ = nullptr;
  std::vector<std::unique_ptr<PeerShape>> shapes_;
  std::vector<Transform> poses_;
};

using Peers = std::vector<std::unique_ptr<Peer>>;
using ManifoldPeers = std::vector<std::unique_ptr<ManifoldPeer>>;

/// `settings`: also the variants that only differ in tolerance or number of iterations.
void append_quoin(Peers& peers, bool settings);
void append_quoin(ManifoldPeers& peers);
/// What no answer can do without.
void append_floor(Peers& peers);
#ifdef QUOIN_BENCH_FCL
void append_fcl(Peers& peers, bool settings);
void append_fcl(ManifoldPeers& peers);
#endif
#ifdef QUOIN_BENCH_CCD
void append_ccd(Peers& peers, bool settings);
#endif
#ifdef QUOIN_BENCH_BULLET
void append_bullet(Peers& peers, bool settings);
void append_bullet(ManifoldPeers& peers);
#endif
#ifdef QUOIN_BENCH_ODE
void append_ode(Peers& peers);
void append_ode(ManifoldPeers& peers);
#endif

}  // namespace quoin::bench
