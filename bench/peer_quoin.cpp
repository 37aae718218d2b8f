#include <quoin/geometry/contact_point.hpp>
#include <quoin/geometry/nearest_features.hpp>
#include <quoin/geometry/pair_batch.hpp>
#include <quoin/geometry/published_search.hpp>

#include "peer.hpp"

namespace quoin::bench {
namespace {

using geometry::FeatureHint;
using geometry::NearestFeatures;
using geometry::Shape;

/// Both solids of each pair in the world frame.
class Solids {
 public:
  void load(const Workload& workload) {
    workload_ = &workload;
    solids_.clear();
    for (const Pair& pair : workload.pairs) {
      const BenchShape& a = shape(pair.shape_a);
      const BenchShape& b = shape(pair.shape_b);
      solids_.emplace_back(a.topology, pair.poses_a[0].apply(a.vertices));
      solids_.emplace_back(b.topology, pair.poses_b[0].apply(b.vertices));
    }
  }
  void place(int step) {
    const auto s = static_cast<std::size_t>(step);
    for (std::size_t k = 0; k < workload_->pairs.size(); ++k) {
      const Pair& pair = workload_->pairs[k];
      solids_[2 * k].set_vertices(pair.poses_a[s].apply(shape(pair.shape_a).vertices));
      solids_[2 * k + 1].set_vertices(pair.poses_b[s].apply(shape(pair.shape_b).vertices));
    }
  }
  const Shape& a(int pair) const { return solids_[2 * static_cast<std::size_t>(pair)]; }
  const Shape& b(int pair) const { return solids_[2 * static_cast<std::size_t>(pair) + 1]; }
  std::size_t pair_count() const { return solids_.size() / 2; }

 private:
  const BenchShape& shape(int s) const { return workload_->shapes[static_cast<std::size_t>(s)]; }
  const Workload* workload_ = nullptr;
  std::vector<Shape> solids_;
};

class Quoin final : public PeerOf<Quoin> {
 public:
  Quoin(std::string name, bool warm, int max_iterations)
      : PeerOf(std::move(name)), warm_(warm), options_{.max_iterations = max_iterations} {}
  bool answers(const Workload& workload) const override { return !warm_ || workload.warm; }
  void load(const Workload& workload) override {
    solids_.load(workload);
    hints_.assign(solids_.pair_count(), {});
  }
  void place(int step) override { solids_.place(step); }
  void forget() override { hints_.assign(hints_.size(), {}); }
  Answer query(int pair) {
    FeatureHint& hint = hints_[static_cast<std::size_t>(pair)];
    const NearestFeatures nearest =
        nearest_features(solids_.a(pair), solids_.b(pair), options_, hint);
    if (warm_) hint = nearest.hint;
    return {nearest.gap, nearest.normal, nearest.point_a, nearest.point_b};
  }

 private:
  bool warm_;
  geometry::SearchOptions options_;
  Solids solids_;
  std::vector<FeatureHint> hints_;
};

/// A shape and its poses, as a caller with rigid bodies has them.
class Bodies {
 public:
  void load(const Workload& workload) {
    workload_ = &workload;
    shapes_.clear();
    for (const BenchShape& shape : workload.shapes)
      shapes_.emplace_back(shape.topology, shape.vertices);
    bodies_.clear();
    for (const Pair& pair : workload.pairs) {
      bodies_.emplace_back(shapes_[static_cast<std::size_t>(pair.shape_a)]);
      bodies_.emplace_back(shapes_[static_cast<std::size_t>(pair.shape_b)]);
    }
    place(0);
  }
  void place(int step) {
    placements_.clear();
    for (const Pair& pair : workload_->pairs) {
      for (const std::vector<Pose>* poses : {&pair.poses_a, &pair.poses_b}) {
        const Pose& pose = (*poses)[static_cast<std::size_t>(step)];
        placements_.push_back({pose.rotation, pose.place});
      }
    }
  }
  /// Moves both bodies of a pair to where they are at the step.
  void move(int pair) {
    for (std::size_t k = 2 * static_cast<std::size_t>(pair), last = k + 1; k <= last; ++k)
      bodies_[k].move(placements_[k]);
  }
  std::span<const geometry::Body> all() const { return bodies_; }
  const geometry::Body& a(int pair) const { return bodies_[2 * static_cast<std::size_t>(pair)]; }
  const geometry::Body& b(int pair) const {
    return bodies_[2 * static_cast<std::size_t>(pair) + 1];
  }

 private:
  const Workload* workload_ = nullptr;
  std::vector<Shape> shapes_;
  std::vector<geometry::Body> bodies_;
  std::vector<geometry::Placement> placements_;
};

/// Cold, the move of both bodies in the clock.
class QuoinMoved final : public PeerOf<QuoinMoved> {
 public:
  QuoinMoved() : PeerOf("quoin, both moved") {}
  bool answers(const Workload& workload) const override { return !workload.warm; }
  void load(const Workload& workload) override { bodies_.load(workload); }
  void place(int step) override { bodies_.place(step); }
  Answer query(int pair) {
    bodies_.move(pair);
    const NearestFeatures nearest = nearest_features(bodies_.a(pair), bodies_.b(pair));
    return {nearest.gap, nearest.normal, nearest.point_a, nearest.point_b};
  }

 private:
  Bodies bodies_;
};

/// The paper's search as printed, for solids apart.
class Published final : public PeerOf<Published> {
 public:
  Published() : PeerOf("published search") {}
  bool answers(const Workload& workload) const override {
    return !workload.warm && !workload.overlap;
  }
  void load(const Workload& workload) override { solids_.load(workload); }
  void place(int step) override { solids_.place(step); }
  Answer query(int pair) {
    const geometry::PublishedAnswer found =
        geometry::published_search(solids_.a(pair), solids_.b(pair));
    return {found.gap, found.normal, found.point_a, found.point_b};
  }

 private:
  Solids solids_;
};

constexpr double kReach = 2e-3;  // beyond the largest gap of W4, m

class QuoinManifold final : public ManifoldPeer {
 public:
  QuoinManifold(std::string name, bool warm) : ManifoldPeer(std::move(name)), warm_(warm) {}
  bool answers(const Workload&) const override { return true; }
  void load(const Workload& workload) override {
    solids_.load(workload);
    hints_.assign(solids_.pair_count(), {});
    contacts_.reserve(64);
    if (!warm_) return;
    for (std::size_t k = 0; k < hints_.size(); ++k) find(static_cast<int>(k));
  }
  void ask(int pair, std::vector<ManifoldPoint>& points) override {
    find(pair);
    points.clear();
    for (const geometry::ContactPoint& c : contacts_) points.push_back({c.point(), c.gap});
  }
  double ask_all(std::span<const int> pairs) override {
    double sum = 0.0;
    for (const int pair : pairs) {
      find(pair);
      sum += contacts_.front().gap;
    }
    return sum;
  }

 private:
  void find(int pair) {
    FeatureHint& hint = hints_[static_cast<std::size_t>(pair)];
    const Shape &a = solids_.a(pair), &b = solids_.b(pair);
    contacts_.clear();
    const NearestFeatures nearest =
        append_contacts_within_reach({0, 1}, a, b, {.reach = kReach}, hint, contacts_);
    if (warm_) hint = nearest.hint;
  }
  bool warm_;
  Solids solids_;
  std::vector<FeatureHint> hints_;
  std::vector<geometry::ContactPoint> contacts_;
};

/// All pairs in one call of PairBatch, warm, as shapes and placements.
class QuoinBatch final : public ManifoldPeer {
 public:
  QuoinBatch() : ManifoldPeer("quoin batch") {}
  bool answers(const Workload&) const override { return true; }
  void load(const Workload& workload) override {
    bodies_.load(workload);
    for (int k = 0; k < std::ssize(workload.pairs); ++k) bodies_.move(k);
  }
  void ask(int pair, std::vector<ManifoldPoint>& points) override {
    for (int cold_then_warm = 0; cold_then_warm < 2; ++cold_then_warm) ask_all({&pair, 1});
    points.clear();
    for (const geometry::ContactPoint& c : contacts_) points.push_back({c.point(), c.gap});
  }
  double ask_all(std::span<const int> pairs) override {
    pairs_.clear();
    for (const int pair : pairs) pairs_.push_back({2 * pair, 2 * pair + 1});
    batch_.find(geometry::BodySource(bodies_.all()), pairs_, contacts_);
    double sum = 0.0;
    for (const geometry::PairResult& result : batch_.pairs()) sum += result.gap;
    return sum;
  }

 private:
  Bodies bodies_;
  geometry::PairBatch batch_{{.reach = kReach}};
  std::vector<geometry::BlockPair> pairs_;
  std::vector<geometry::ContactPoint> contacts_;
};

}  // namespace

void append_quoin(Peers& peers, bool settings) {
  constexpr int kMany = geometry::SearchOptions{}.max_iterations;
  peers.push_back(std::make_unique<Quoin>("quoin", false, kMany));
  peers.push_back(std::make_unique<Quoin>("quoin warm", true, kMany));
  peers.push_back(std::make_unique<QuoinMoved>());
  peers.push_back(std::make_unique<Published>());
  if (!settings) return;
  for (const int most : {1, 2, 3, 4, 6, 8, 12}) {
    peers.push_back(
        std::make_unique<Quoin>("quoin iterations " + std::to_string(most), false, most));
  }
}

void append_quoin(ManifoldPeers& peers) {
  peers.push_back(std::make_unique<QuoinManifold>("quoin", false));
  peers.push_back(std::make_unique<QuoinManifold>("quoin warm", true));
  peers.push_back(std::make_unique<QuoinBatch>());
}

}  // namespace quoin::bench
