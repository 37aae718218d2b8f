#pragma once
/// One interface for everybody who answers pairs, quoin among them.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "harness.hpp"
#include "workloads.hpp"

namespace quoin::bench {

/// What a peer says about one pair. NaN gap: it gave none.
struct Answer {
  double gap = 0.0;  ///< m, negative: overlap
  Vector3 normal = Vector3::Zero();
  Vector3 point_a = Vector3::Zero(), point_b = Vector3::Zero();
};

/// What those who answer distances and those who list manifolds have in common.
class AnyPeer {
 public:
  explicit AnyPeer(std::string name) : name_(std::move(name)) {}
  virtual ~AnyPeer() = default;
  const std::string& name() const { return name_; }

  /// Whether it has an answer to this kind of question at all.
  virtual bool answers(const Workload& workload) const = 0;
  /// Builds its shapes; not timed.
  virtual void load(const Workload& workload) = 0;
  /// Moves its shapes to the poses of a step; not timed with the queries.
  virtual void place(int /*step*/) {}
  /// What is timed: all these pairs, one after the other. Returns a sum of the gaps.
  virtual double ask_all(std::span<const int> pairs) = 0;

 private:
  std::string name_;
};

class Peer : public AnyPeer {
 public:
  using AnyPeer::AnyPeer;
  /// Forgets what it learned of the steps before.
  virtual void forget() {}
  /// May throw.
  virtual Answer ask(int pair) = 0;
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

class ManifoldPeer : public AnyPeer {
 public:
  using AnyPeer::AnyPeer;
  virtual void ask(int pair, std::vector<ManifoldPoint>& points) = 0;
};

using Peers = std::vector<std::unique_ptr<Peer>>;
using ManifoldPeers = std::vector<std::unique_ptr<ManifoldPeer>>;

/// `settings`: also the variants that only differ in the number of iterations.
void append_quoin(Peers& peers, bool settings);
void append_quoin(ManifoldPeers& peers);
/// The libraries of the referee's plug-ins that were built.
void append_plugins(Peers& peers);
void append_plugins(ManifoldPeers& peers);

/// By callgrind, all pairs of all steps, after a pass over the first step that is not counted.
void count_queries(AnyPeer& peer, const std::string& name, const Workload& workload);

/// Everybody who answers pairs, and the entries of those who are counted or timed on a workload.
template <class Peers, class Make>
std::vector<Entry> entries_of(const Peers& peers, const std::string& name, const Workload& workload,
                              const Arguments& arguments, const Make& make_entry) {
  std::vector<Entry> entries;
  for (const auto& peer : peers) {
    if (!peer->answers(workload)) continue;
    if (arguments.count.empty()) entries.push_back(make_entry(*peer));
    if (peer->name() != arguments.count) continue;
    count_queries(*peer, name, workload);
    entries.push_back({.workload = name, .peer = peer->name()});
  }
  return entries;
}

}  // namespace quoin::bench
