#pragma once
/// TODO: to be deleted with the solver's last call of ContactFinder::find(blocks, …). Blocks that
/// are given by all their vertices in each call, and which of them stand still.

#include <quoin/geometry/broad_phase.hpp>

namespace quoin::geometry {

class VertexBlocks {
 public:
  explicit VertexBlocks(const ContactOptions& options)
      : options_(options), batch_(options, BatchResults::PointsAlone) {}

  FindCounts find(std::span<const Shape> blocks, std::span<const char> idle,
                  std::vector<ContactPoint>& contacts, Executor& executor);
  void set_reach(double reach);

 private:
  /// A block as it was when its box was last seen to be the same as in the call before.
  struct Standing {
    std::shared_ptr<const Topology> topology{};
    Points vertices{};
    bool is(const Shape& block) const {
      return topology == block.shared_topology() && vertices == block.vertices();
    }
  };
  void note_standing(std::span<const Shape> blocks);

  ContactOptions options_;
  BroadPhase broad_phase_;
  PairBatch batch_;
  std::vector<Box> boxes_;           // of the last call
  std::vector<Standing> standing_;   // one a block
  std::vector<BodyChange> changes_;  // since the last call
};

}  // namespace quoin::geometry
