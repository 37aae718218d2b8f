#pragma once
/// The pipeline: polyhedra in, contact points sorted by key out.

#include <memory>
#include <quoin/geometry/contact_point.hpp>
#include <span>

namespace quoin::geometry {

struct FinderOptions {
  double reach = 0.0;      ///< contact points are listed up to this gap, m; touching pairs always
  double tolerance = 0.0;  ///< contact length tol, m; 0: default_tolerance of each pair
  int threads = 1;         ///< any number gives the same bits
};

/// What a call of ContactFinder::find() had to do.
struct FindCounts {
  int candidates = 0;  ///< pairs of blocks near enough to touch
  int searched = 0;    ///< of these: not left as they were by both blocks since the last call
};

/// Remembers its tree, where each pair's search ended and what it found for blocks that stand
/// still: that changes the speed, never the answer.
class ContactFinder {
 public:
  explicit ContactFinder(const FinderOptions& options);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  /// Pairs of blocks that are both idle (fixed, or known not to move) are never tested.
  /// `idle` is empty or one flag a block. The list is sorted by key; no allocation when warm.
  FindCounts find(std::span<const Polyhedron> blocks, std::span<const char> idle,
                  std::vector<ContactPoint>& contacts);
  FindCounts find(std::span<const Polyhedron> blocks, std::vector<ContactPoint>& contacts) {
    return find(blocks, {}, contacts);
  }

  void set_reach(double reach);  ///< m, from the next find() on

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace quoin::geometry
