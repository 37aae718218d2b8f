#include <fcl/broadphase/detail/hierarchy_tree.h>
#include <fcl/math/bv/AABB.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <quoin/geometry/broad_phase.hpp>

#include "simd/dispatch.hpp"

namespace quoin::geometry {
namespace {

using FclTree = fcl::detail::HierarchyTree<fcl::AABBd>;
using Node = FclTree::NodeType;

constexpr std::size_t kFewBoxes = 16;  // below this all pairs are tried and no tree is built
constexpr double kSkin = 0.05;         // skin of a fat box, as a part of the box's diagonal
constexpr double kLookAhead = 16;      // a moving box is fattened for this many calls to come
constexpr double kLookAheadCap = 1;    // but by no more than this part of its diagonal
constexpr double kReachSlack = 1.5;  // reach built into the tree, as a multiple of the reach asked
constexpr double kReachWaste = 4;    // rebuilt when the reach asked shrinks below 1/4 of it
constexpr std::size_t kBulk = 8;     // more than 1/8 of the boxes moved out: refit the whole tree
constexpr std::size_t kMany =
    64;                         // more than 1/64: those that will follow soon are renewed as well
constexpr double kSoon = 0.5;   // whose room has shrunk below half a skin
constexpr double kWornOut = 2;  // rebuilt when its queries visit twice as many nodes as when new

// Two boxes are compared on all sides: which one parts them cannot be foreseen.

#ifdef QUOIN_WIDE_LANES

/// x <= y and u <= v, all three of each?
bool none_above(const Vector3& x, const Vector3& y, const Vector3& u, const Vector3& v) {
  const __m128d first = _mm_cmple_pd(_mm_loadu_pd(x.data()), _mm_loadu_pd(y.data()));
  const __m128d second = _mm_cmple_pd(_mm_loadu_pd(u.data()), _mm_loadu_pd(v.data()));
  const __m128d third = _mm_cmple_pd(_mm_set_pd(x[2], u[2]), _mm_set_pd(y[2], v[2]));
  return _mm_movemask_pd(_mm_and_pd(_mm_and_pd(first, second), third)) == 3;
}

/// x - y <= limit and u - v <= limit, all three of each?
bool none_beyond(const Vector3& x, const Vector3& y, const Vector3& u, const Vector3& v,
                 double limit) {
  const __m128d most = _mm_set1_pd(limit);
  const __m128d first = _mm_sub_pd(_mm_loadu_pd(x.data()), _mm_loadu_pd(y.data()));
  const __m128d second = _mm_sub_pd(_mm_loadu_pd(u.data()), _mm_loadu_pd(v.data()));
  const __m128d third = _mm_sub_pd(_mm_set_pd(x[2], u[2]), _mm_set_pd(y[2], v[2]));
  const __m128d within = _mm_and_pd(_mm_cmple_pd(first, most), _mm_cmple_pd(second, most));
  return _mm_movemask_pd(_mm_and_pd(within, _mm_cmple_pd(third, most))) == 3;
}

#else

bool none_above(const Vector3& x, const Vector3& y, const Vector3& u, const Vector3& v) {
  return (x.array() <= y.array()).all() && (u.array() <= v.array()).all();
}

bool none_beyond(const Vector3& x, const Vector3& y, const Vector3& u, const Vector3& v,
                 double limit) {
  return ((x - y).array() <= limit).all() && ((u - v).array() <= limit).all();
}

#endif

/// Exactly the promise of the header. A rounded difference is at most `reach` whenever the true one
/// is.
bool within_reach(const Box& a, const Box& b, double reach) {
  return none_beyond(a.min, b.max, b.min, a.max, reach);
}

bool contains(const Box& outer, const Box& inner) {
  return none_above(outer.min, inner.min, inner.max, outer.max);
}

/// As FCL's, which are not inline.
bool overlap(const fcl::AABBd& a, const fcl::AABBd& b) {
  return none_above(a.min_, b.max_, b.min_, a.max_);
}

double squared_size(const fcl::AABBd& box) { return (box.max_ - box.min_).squaredNorm(); }

/// Has the box come closer than this part of its skin to a side of its room?
bool leaves_soon(const Box& room, const Box& box) {
  const double least = kSoon * kSkin * (box.max - box.min).norm();
  return (box.min - room.min).minCoeff() < least || (room.max - box.max).minCoeff() < least;
}

bool is_idle(std::span<const char> idle, std::size_t i) { return !idle.empty() && idle[i] != 0; }

bool both_idle(std::span<const char> idle, int a, int b) {
  return is_idle(idle, static_cast<std::size_t>(a)) && is_idle(idle, static_cast<std::size_t>(b));
}

/// Two subtrees that may have overlapping leaves; twice the same: the leaves of one.
struct NodePair {
  const Node *x, *y;
};

int leaf_index(const Node& leaf) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(leaf.data));
}

}  // namespace

/// Fat boxes in FCL's dynamic tree. A box is put into the tree anew only when it leaves its roomy
/// box; until then the pairs of overlapping fat boxes (`kept`) hold every pair within reach.
struct BroadPhase::Tree {
  std::unique_ptr<FclTree> tree;  // made for the first scene that is not small
  std::vector<Node*> leaves;
  std::vector<Box> roomy;       // a box that stays inside needs no update, m
  std::vector<Vector3> home;    // centre at the last update, m
  std::vector<long> home_call;  // and the call it was made in
  double built_reach = -1.0;    // m
  long call = 0;
  std::size_t visits = 0, visits_when_new = 0;

  std::vector<char> idle;  // one flag a box; no pair of two idle ones is in `kept`
  std::vector<BlockPair> kept, scratch, fresh, result;
  std::vector<int> moved;
  std::vector<char> is_moved;
  std::vector<const Node*> stack;
  std::vector<NodePair> pair_stack;
  std::vector<std::size_t> bucket_end;

  void try_all(std::span<const Box> boxes, double reach, std::span<const char> idle_now);
  void build(std::span<const Box> boxes, double reach, std::span<const char> idle_now);
  void follow(std::span<const Box> boxes, double reach, std::span<const char> idle_now);
  void make_roomy(std::span<const Box> boxes, std::size_t i);
  fcl::AABBd fat_box(std::size_t i) const;
  template <class Visit>
  void query(const fcl::AABBd& box, Visit&& visit);
  void query_all();
  void split_self(const Node& x);
  void split_larger(const Node& x, const Node& y);
  void sort_kept();
  void query_moved();
  void add_soon_moved(std::span<const Box> boxes);
  void filter(std::span<const Box> boxes, double reach);
};

void BroadPhase::Tree::try_all(std::span<const Box> boxes, double reach,
                               std::span<const char> idle_now) {
  leaves.clear();
  result.clear();
  const int count = static_cast<int>(boxes.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      if (!both_idle(idle_now, a, b) && within_reach(boxes[static_cast<std::size_t>(a)],
                                                     boxes[static_cast<std::size_t>(b)], reach)) {
        result.push_back({a, b});
      }
    }
  }
}

/// The box grown by its skin and along the way it went lately. A box that is not finite is within
/// reach of nothing: it gets a place of no size and is looked at again in each call.
void BroadPhase::Tree::make_roomy(std::span<const Box> boxes, std::size_t i) {
  const Box& box = boxes[i];
  const Vector3 extent = box.max - box.min;
  const double diagonal = extent.norm();
  if (!std::isfinite(diagonal) || !box.min.allFinite()) {
    roomy[i] = Box{};
    home_call[i] = call;
    return;
  }
  const Vector3 centre = box.min + 0.5 * extent;
  const double skin = kSkin * diagonal;
  roomy[i] = {(box.min.array() - skin).matrix(), (box.max.array() + skin).matrix()};
  if (const long calls = call - home_call[i]; calls > 0 && home_call[i] >= 0) {
    const double cap = kLookAheadCap * diagonal;
    for (int k = 0; k < 3; ++k) {
      const double ahead = std::clamp(
          (centre[k] - home[i][k]) * (kLookAhead / static_cast<double>(calls)), -cap, cap);
      (ahead > 0 ? roomy[i].max : roomy[i].min)[k] += ahead;
    }
  }
  home[i] = centre;
  home_call[i] = call;
}

/// What stands in the tree: the roomy box grown by half the reach and by what rounding may take.
fcl::AABBd BroadPhase::Tree::fat_box(std::size_t i) const {
  constexpr double kUlps = 8 * std::numeric_limits<double>::epsilon();
  const Box& room = roomy[i];
  const double largest = std::max(room.min.cwiseAbs().maxCoeff(), room.max.cwiseAbs().maxCoeff());
  const double growth = 0.5 * built_reach + kUlps * (largest + built_reach);
  fcl::AABBd fat;
  fat.min_ = (room.min.array() - growth).matrix();
  fat.max_ = (room.max.array() + growth).matrix();
  return fat;
}

void BroadPhase::Tree::build(std::span<const Box> boxes, double reach,
                             std::span<const char> idle_now) {
  const std::size_t count = boxes.size();
  idle.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    idle[i] = is_idle(idle_now, i) ? 1 : 0;
  }
  built_reach = reach * kReachSlack;
  call = 0;
  leaves.resize(count);
  roomy.resize(count);
  home.resize(count);
  home_call.assign(count, -1);
  is_moved.assign(count, 0);
  if (!tree) tree = std::make_unique<FclTree>(2, 0);
  tree->clear();
  for (std::size_t i = 0; i < count; ++i) {
    make_roomy(boxes, i);
    Node* leaf = new Node;  // owned and deleted by the tree
    leaf->bv = fat_box(i);
    leaf->parent = nullptr;
    leaf->children[1] = nullptr;
    leaf->data = reinterpret_cast<void*>(static_cast<std::intptr_t>(i));
    leaves[i] = leaf;
  }
  std::vector<Node*> order = leaves;  // init sorts what it is given
  tree->init(order, 0);
  query_all();
  visits_when_new = visits;
}

template <class Visit>
void BroadPhase::Tree::query(const fcl::AABBd& box, Visit&& visit) {
  stack.clear();
  stack.push_back(tree->getRoot());
  while (!stack.empty()) {
    const Node* node = stack.back();
    stack.pop_back();
    ++visits;
    if (!overlap(node->bv, box)) {
      continue;
    }
    if (node->isLeaf()) {
      visit(leaf_index(*node));
    } else {
      stack.push_back(node->children[0]);
      stack.push_back(node->children[1]);
    }
  }
}

/// The tree against itself: each pair of subtrees that overlap is entered once.
void BroadPhase::Tree::query_all() {
  kept.clear();
  visits = 0;
  pair_stack.clear();
  pair_stack.push_back({tree->getRoot(), tree->getRoot()});
  while (!pair_stack.empty()) {
    const auto [x, y] = pair_stack.back();
    pair_stack.pop_back();
    ++visits;
    if (x == y) {
      if (!x->isLeaf()) split_self(*x);
    } else if (overlap(x->bv, y->bv)) {
      if (x->isLeaf() && y->isLeaf()) {
        const auto [a, b] = std::minmax({leaf_index(*x), leaf_index(*y)});
        if (!both_idle(idle, a, b)) kept.push_back({a, b});
      } else {
        split_larger(*x, *y);
      }
    }
  }
  sort_kept();
}

void BroadPhase::Tree::split_self(const Node& x) {
  pair_stack.push_back({x.children[0], x.children[1]});
  pair_stack.push_back({x.children[0], x.children[0]});
  pair_stack.push_back({x.children[1], x.children[1]});
}

void BroadPhase::Tree::split_larger(const Node& x, const Node& y) {
  const bool split_x = y.isLeaf() || (!x.isLeaf() && squared_size(x.bv) > squared_size(y.bv));
  const Node &split = split_x ? x : y, &whole = split_x ? y : x;
  pair_stack.push_back({split.children[0], &whole});
  pair_stack.push_back({split.children[1], &whole});
}

/// Into one bucket for each first block, whose few pairs are then sorted.
void BroadPhase::Tree::sort_kept() {
  bucket_end.assign(leaves.size() + 1, 0);
  for (const BlockPair& pair : kept) ++bucket_end[static_cast<std::size_t>(pair.a) + 1];
  for (std::size_t i = 1; i < bucket_end.size(); ++i) bucket_end[i] += bucket_end[i - 1];
  scratch.resize(kept.size());
  for (const BlockPair& pair : kept) scratch[bucket_end[static_cast<std::size_t>(pair.a)]++] = pair;
  std::size_t first = 0;
  for (std::size_t i = 0; i < leaves.size(); ++i) {  // each end has moved on by its bucket's size
    const auto at = [&](std::size_t k) { return scratch.begin() + static_cast<std::ptrdiff_t>(k); };
    if (bucket_end[i] - first > 1) std::sort(at(first), at(bucket_end[i]));
    first = bucket_end[i];
  }
  std::swap(kept, scratch);
}

void BroadPhase::Tree::query_moved() {
  for (int i : moved) {
    is_moved[static_cast<std::size_t>(i)] = 1;
  }
  fresh.clear();
  for (int i : moved) {
    query(leaves[static_cast<std::size_t>(i)]->bv, [&](int j) {
      if (i != j && (is_moved[static_cast<std::size_t>(j)] == 0 || i < j) &&
          !both_idle(idle, i, j)) {
        fresh.push_back({std::min(i, j), std::max(i, j)});
      }
    });
  }
  std::sort(fresh.begin(), fresh.end());
  std::erase_if(kept, [&](const BlockPair& pair) {
    return is_moved[static_cast<std::size_t>(pair.a)] != 0 ||
           is_moved[static_cast<std::size_t>(pair.b)] != 0;
  });
  scratch.resize(kept.size() + fresh.size());
  std::merge(kept.begin(), kept.end(), fresh.begin(), fresh.end(), scratch.begin());
  std::swap(kept, scratch);
  for (int i : moved) {
    is_moved[static_cast<std::size_t>(i)] = 0;
  }
}

/// Blocks that move alike leave their rooms within a few calls of each other: better all in one.
void BroadPhase::Tree::add_soon_moved(std::span<const Box> boxes) {
  for (int i : moved) is_moved[static_cast<std::size_t>(i)] = 1;
  const std::size_t first = moved.size();
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (is_moved[i] == 0 && leaves_soon(roomy[i], boxes[i])) moved.push_back(static_cast<int>(i));
  }
  for (std::size_t k = 0; k < first; ++k) is_moved[static_cast<std::size_t>(moved[k])] = 0;
}

/// Brings the tree up to date with boxes that left their roomy box, fell idle or are so no longer.
void BroadPhase::Tree::follow(std::span<const Box> boxes, double reach,
                              std::span<const char> idle_now) {
  ++call;
  moved.clear();
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const bool idle_changed = (idle[i] != 0) != is_idle(idle_now, i);
    if (idle_changed || !contains(roomy[i], boxes[i])) {
      idle[i] = is_idle(idle_now, i) ? 1 : 0;
      moved.push_back(static_cast<int>(i));
    }
  }
  if (moved.size() * kMany > boxes.size()) add_soon_moved(boxes);
  const bool refit = reach > built_reach || reach * kReachWaste * kReachSlack < built_reach ||
                     moved.size() * kBulk > boxes.size();
  if (!refit) {
    for (int i : moved) {
      make_roomy(boxes, static_cast<std::size_t>(i));
      tree->update(leaves[static_cast<std::size_t>(i)], fat_box(static_cast<std::size_t>(i)));
    }
    if (!moved.empty()) {
      query_moved();
    }
    return;
  }
  if (reach > built_reach || reach * kReachWaste * kReachSlack < built_reach) {
    built_reach = reach * kReachSlack;
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {  // all are asked for anyway: all get new room
    make_roomy(boxes, i);
    leaves[i]->bv = fat_box(i);
  }
  tree->refit();
  query_all();
  if (static_cast<double>(visits) > kWornOut * static_cast<double>(visits_when_new)) {
    tree->balanceTopdown();
    query_all();
    visits_when_new = visits;
  }
}

void BroadPhase::Tree::filter(std::span<const Box> boxes, double reach) {
  std::array<BlockPair, 256> few;  // still in the cache when they are copied
  result.clear();
  result.reserve(kept.size());
  for (std::size_t first = 0; first < kept.size(); first += few.size()) {
    const std::size_t last = std::min(first + few.size(), kept.size());
    std::size_t count = 0;
    for (std::size_t k = first; k < last; ++k) {
      few[count] = kept[k];
      count += within_reach(boxes[static_cast<std::size_t>(kept[k].a)],
                            boxes[static_cast<std::size_t>(kept[k].b)], reach);
    }
    result.insert(result.end(), few.begin(), few.begin() + static_cast<std::ptrdiff_t>(count));
  }
}

bool tries_all_pairs(std::size_t boxes) { return boxes < kFewBoxes; }

BroadPhase::BroadPhase() : tree_(std::make_unique<Tree>()) {}
BroadPhase::~BroadPhase() = default;
BroadPhase::BroadPhase(BroadPhase&&) noexcept = default;
BroadPhase& BroadPhase::operator=(BroadPhase&&) noexcept = default;

const std::vector<BlockPair>& BroadPhase::find_candidates(std::span<const Box> boxes, double reach,
                                                          std::span<const char> idle) {
  if (!idle.empty() && idle.size() != boxes.size()) {
    throw InputError("idle has " + std::to_string(idle.size()) + " flags for " +
                     std::to_string(boxes.size()) + " boxes");
  }
  if (tries_all_pairs(boxes.size())) {
    tree_->try_all(boxes, reach, idle);
    return tree_->result;
  }
  if (boxes.size() != tree_->leaves.size()) {
    tree_->build(boxes, reach, idle);
  } else {
    tree_->follow(boxes, reach, idle);
  }
  tree_->filter(boxes, reach);
  return tree_->result;
}

}  // namespace quoin::geometry
