#include <fcl/broadphase/detail/hierarchy_tree.h>
#include <fcl/math/bv/AABB.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <quoin/geometry/broad_phase.hpp>
#include <tuple>

#include "numeric/floating_point.hpp"
#include "numeric/numbers.hpp"

namespace quoin::geometry {
namespace {

using FloatBox = fcl::AABB<float>;
using FloatVector = Eigen::Vector3f;
using FclTree = fcl::detail::HierarchyTree<FloatBox>;
using Node = FclTree::NodeType;

constexpr int kFewBoxes = 16;        // below this all pairs are tried and no tree is built
constexpr float kSkin = 0.05F;       // skin of a fat box, as a part of the box's diagonal
constexpr float kLookAhead = 16;     // a moving box is fattened for this many calls to come
constexpr float kLookAheadCap = 1;   // but by no more than this part of its diagonal
constexpr double kReachSlack = 1.5;  // reach built into the tree, as a multiple of the reach asked
constexpr double kReachWaste = 4;    // rebuilt when the reach asked shrinks below 1/4 of it
constexpr std::size_t kBulk = 8;     // more than 1/8 out of their room: the tree is refitted
constexpr double kWornOut = 2;       // rebuilt when queries visit twice as many nodes as when new
constexpr float kFarthest = 1e18F;   // m; boxes are cut off here: FCL squares their sides
constexpr float kFloatEpsilon = std::numeric_limits<float>::epsilon();
constexpr float kSmallestFloat = std::numeric_limits<float>::min();

bool within_reach(const FloatBox& a, const FloatBox& b, float reach) {
  return ((a.min_ - b.max_).array() <= reach).all() && ((b.min_ - a.max_).array() <= reach).all();
}

/// Exactly: a rounded difference is at most `reach` whenever the true one is.
bool within_reach(const Box& a, const Box& b, double reach) {
  return ((a.min - b.max).array() <= reach).all() && ((b.min - a.max).array() <= reach).all();
}

/// A float is off by half an eps of itself, denormal ones by less than the smallest normal one; so
/// is, much less, the difference in double from which it comes.
float rounding(float value) { return std::abs(value) * kFloatEpsilon + kSmallestFloat; }

/// Not less than a length, not even after a difference of floats has been rounded.
float rounded_up(double length) {
  const auto value = static_cast<float>(std::min(length, 4.0 * kFarthest));
  return value + 2 * rounding(value);
}

/// As seen from `origin`.
FloatBox rounded_outward(const Box& box, const Vector3& origin) {
  FloatBox made;
  const auto seen = [](double x) {
    return static_cast<float>(std::clamp<double>(x, -kFarthest, kFarthest));
  };
  for (Eigen::Index k = 0; k < 3; ++k) {
    const float min = seen(box.min[k] - origin[k]), max = seen(box.max[k] - origin[k]);
    made.min_[k] = min - rounding(min);
    made.max_[k] = max + rounding(max);
  }
  return made;
}

/// What holds of a box, as bits: moved since the pairs were found, or since the tree was brought up
/// to date.
enum BoxState : std::uint8_t { kPresent = 1, kIdle = 2, kMoved = 4, kWaiting = 8, kAsked = 16 };

int leaf_index(const Node& leaf) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(leaf.data));
}

void* leaf_data(int i) { return reinterpret_cast<void*>(static_cast<std::intptr_t>(i)); }

}  // namespace

/// Fat boxes in FCL's dynamic tree: each box with room around it, and half the reach. A box is put
/// into the tree anew only when it leaves its room; until then the pairs of overlapping fat boxes
/// (`kept`) hold every pair within reach.
struct BroadPhase::Tree {
  FclTree tree{2, 0};
  std::vector<FloatBox> boxes;   // as seen from `origin`, m
  std::vector<float> own_reach;  // of each box, m; empty: all 0
  std::vector<Node*> leaves;     // null: not in the tree
  std::vector<std::uint8_t> state;
  Vector3 origin = Vector3::Zero();  // m
  std::size_t present = 0;
  double built_reach = -1.0;  // for which there is room in the tree, m
  std::size_t visits = 0, visits_when_new = 0;
  std::vector<int> moved;   // boxes with that bit; those before `placed` have not moved since
  std::size_t placed = 0;   // the tree was brought up to date, or are named again
  bool many_moved = false;  // more than `moved` names
  bool kept_is_old = true;  // not but for `moved`
  std::vector<BlockPair> kept, fresh, merged, result;
  std::vector<const Node*> stack;

  int count() const { return static_cast<int>(boxes.size()); }
  bool few() const { return present < kFewBoxes; }
  bool has(int i, BoxState bit) const { return (state[at(i)] & bit) != 0; }
  void clear_bit(int i, BoxState bit) {
    state[at(i)] = static_cast<std::uint8_t>(state[at(i)] & ~bit);
  }
  float reach_of(int i) const { return own_reach.empty() ? 0.0F : own_reach[at(i)]; }

  void set(int i, const Box& box, BoxUse use, double reach);
  void remove(int i);
  void find_kept(double reach);
  void find_pairs_of(std::span<const int> asked, double reach);
  template <class Near>
  void filter(const std::vector<BlockPair>& pairs, const Near& near);
  void keep_near(const std::vector<BlockPair>& pairs, double reach);
  void update_tree(double reach);
  /// Calls visit(number, box) for all boxes of which those around them in the tree satisfy
  /// meets(box).
  template <class Meets, class Visit>
  void visit_where(const Meets& meets, const Visit& visit);

 private:
  float room(int i) const { return rounded_up(0.5 * built_reach) + reach_of(i); }
  FloatBox fat_box(int i, const FloatVector& way) const;
  bool stays(int i) const;
  bool set_reach(int i, double reach);
  void note_moved(int i);
  void fell();
  void plant();
  void insert_new();
  void follow();
  void find_all();
  void find_moved();
  void find_around(int i, BoxState once);
};

/// With its skin and its room, and along the way it goes. Fat boxes of a pair overlap as soon as it
/// is within reach, in spite of rounding. A box of NaN is within reach of nothing: it gets a place
/// of no size, and is looked at again in each call.
FloatBox BroadPhase::Tree::fat_box(int i, const FloatVector& way) const {
  const FloatBox& box = boxes[at(i)];
  const float diagonal = std::min((box.max_ - box.min_).stableNorm(), kFarthest);
  FloatBox fat;
  if (std::isnan(diagonal)) {
    fat.min_.setZero();
    fat.max_.setZero();
    return fat;
  }
  const float cap = kLookAheadCap * diagonal, skin = kSkin * diagonal + room(i);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const float ahead = std::clamp(kLookAhead * way[k], -cap, cap);
    const float low = skin + std::max(0.0F, -ahead), high = skin + std::max(0.0F, ahead);
    const float min = box.min_[k] - low - 4 * rounding(std::abs(box.min_[k]) + low);
    const float max = box.max_[k] + high + 4 * rounding(std::abs(box.max_[k]) + high);
    fat.min_[k] = std::clamp(min, -kFarthest, kFarthest);
    fat.max_[k] = std::clamp(max, -kFarthest, kFarthest);
  }
  return fat;
}

/// In its room in the tree.
bool BroadPhase::Tree::stays(int i) const {
  const FloatBox &box = boxes[at(i)], &fat = leaves[at(i)]->bv;
  const float least = room(i);
  return ((box.min_ - fat.min_).array() >= least).all() &&
         ((fat.max_ - box.max_).array() >= least).all();
}

/// Whether it had another one.
bool BroadPhase::Tree::set_reach(int i, double reach) {
  const float next = reach > 0.0 ? rounded_up(reach) : 0.0F;
  if (next == reach_of(i)) return false;
  own_reach.resize(boxes.size(), 0.0F);
  own_reach[at(i)] = next;
  return true;
}

void BroadPhase::Tree::note_moved(int i) {
  if (many_moved || has(i, kWaiting)) return;
  many_moved = (moved.size() + 1) * kBulk > boxes.size();
  if (many_moved) return;
  moved.push_back(i);
  state[at(i)] |= kMoved | kWaiting;
}

/// A new fat box waits in the leaf until update_tree().
void BroadPhase::Tree::set(int i, const Box& box, BoxUse use, double reach) {
  if (boxes.empty() && box.min.allFinite()) origin = box.min;
  const FloatBox next = rounded_outward(box, origin);
  if (i == count()) {
    boxes.push_back(next);
    leaves.push_back(nullptr);
    state.push_back(0);
    if (!own_reach.empty()) own_reach.push_back(0.0F);
  }
  const FloatVector way = next.min_ - boxes[at(i)].min_;
  boxes[at(i)] = next;
  const std::uint8_t use_now = use == BoxUse::Idle ? kPresent | kIdle : kPresent;
  const bool other_use = (state[at(i)] & (kPresent | kIdle)) != use_now;
  const bool other_reach = set_reach(i, reach);
  Node* const leaf = leaves[at(i)];
  if (leaf != nullptr && !other_use && !other_reach && stays(i)) return;
  present += has(i, kPresent) ? 0 : 1;
  state[at(i)] = static_cast<std::uint8_t>((state[at(i)] & ~kIdle) | use_now);
  if (leaf != nullptr) leaf->bv = fat_box(i, way);
  note_moved(i);
}

void BroadPhase::Tree::remove(int i) {
  if (!has(i, kPresent)) return;
  --present;
  clear_bit(i, kPresent);
  note_moved(i);
  if (leaves[at(i)] != nullptr) tree.remove(leaves[at(i)]);
  leaves[at(i)] = nullptr;
}

void BroadPhase::Tree::fell() {
  tree.clear();
  std::fill(leaves.begin(), leaves.end(), nullptr);
  kept_is_old = true;
}

void BroadPhase::Tree::plant() {
  fell();
  std::vector<Node*> order;  // init sorts what it is given
  for (int i = 0; i < count(); ++i) {
    if (!has(i, kPresent)) continue;
    Node* leaf = new Node;  // owned and deleted by the tree
    leaf->bv = fat_box(i, FloatVector::Zero());
    leaf->parent = nullptr;
    leaf->children[1] = nullptr;
    leaf->data = leaf_data(i);
    leaves[at(i)] = leaf;
    order.push_back(leaf);
  }
  tree.init(order, 0);
  visits_when_new = 0;
}

void BroadPhase::Tree::insert_new() {
  for (int i = 0; i < count() && tree.size() < present; ++i) {
    if (!has(i, kPresent) || leaves[at(i)] != nullptr) continue;
    leaves[at(i)] = tree.insert(fat_box(i, FloatVector::Zero()), leaf_data(i));
  }
}

/// FCL's tree does nothing when the box that a leaf holds contains the new one: it holds none.
void BroadPhase::Tree::follow() {
  insert_new();
  if (many_moved) {
    tree.refit();
    kept_is_old = true;
    return;
  }
  for (std::size_t k = placed; k < moved.size(); ++k) {
    Node* const leaf = leaves[at(moved[k])];
    if (leaf == nullptr) continue;
    const FloatBox fat = leaf->bv;
    leaf->bv = FloatBox();
    tree.update(leaf, fat);
  }
}

/// Brings it up to date with boxes that left their room, came, went, or fell idle or are so no
/// longer. `kept` may be old then.
void BroadPhase::Tree::update_tree(double reach) {
  if (few()) {
    fell();
  } else {
    const bool fits = reach <= built_reach && reach * kReachWaste * kReachSlack >= built_reach;
    if (!fits) built_reach = kReachSlack * reach;
    const bool many_new = (present - tree.size()) * kBulk > present;
    fits && !many_new ? follow() : plant();
  }
  for (; placed < moved.size(); ++placed) clear_bit(moved[placed], kWaiting);
  many_moved = false;
}

template <class Meets, class Visit>
void BroadPhase::Tree::visit_where(const Meets& meets, const Visit& visit) {
  if (few()) {
    for (int i = 0; i < count(); ++i)
      if (has(i, kPresent) && meets(boxes[at(i)])) visit(i, boxes[at(i)]);
    return;
  }
  stack.assign(1, tree.getRoot());
  while (!stack.empty()) {
    const Node* node = stack.back();
    stack.pop_back();
    ++visits;
    if (!meets(node->bv)) continue;
    if (node->isLeaf()) {
      visit(leaf_index(*node), node->bv);
    } else {
      stack.push_back(node->children[0]);
      stack.push_back(node->children[1]);
    }
  }
}

/// Into `fresh`: all pairs of a box that may be within reach, those of two boxes with the bit
/// `once` at the lesser one.
void BroadPhase::Tree::find_around(int i, BoxState once) {
  const FloatBox* around = few() ? nullptr : &leaves[at(i)]->bv;
  const auto meets = [&](const FloatBox& box) {
    return around == nullptr || within_reach(*around, box, 0.0F);
  };
  visit_where(meets, [&](int j, const FloatBox&) {
    if (j == i || (j < i && has(j, once)) || (state[at(i)] & state[at(j)] & kIdle) != 0) return;
    fresh.push_back({std::min(i, j), std::max(i, j)});
  });
}

void BroadPhase::Tree::find_all() {
  fresh.clear();
  visits = 0;
  for (int i = 0; i < count(); ++i)
    if (has(i, kPresent)) find_around(i, kPresent);
}

void BroadPhase::Tree::find_moved() {
  fresh.clear();
  for (const int i : moved)
    if (has(i, kPresent)) find_around(i, kMoved);
  std::sort(fresh.begin(), fresh.end());
  fresh.erase(std::unique(fresh.begin(), fresh.end()), fresh.end());
  std::erase_if(kept,
                [&](const BlockPair& pair) { return has(pair.a, kMoved) || has(pair.b, kMoved); });
  merged.resize(kept.size() + fresh.size());
  std::merge(kept.begin(), kept.end(), fresh.begin(), fresh.end(), merged.begin());
  std::swap(kept, merged);
}

/// Afterwards `kept` holds all pairs within reach, ascending.
void BroadPhase::Tree::find_kept(double reach) {
  update_tree(reach);
  if (!kept_is_old) {
    if (!moved.empty()) find_moved();
  } else {
    find_all();
    if (visits_when_new > 0 &&
        static_cast<double>(visits) > kWornOut * static_cast<double>(visits_when_new)) {
      tree.balanceTopdown();
      visits_when_new = 0;
      find_all();
    }
    if (visits_when_new == 0) visits_when_new = visits;
    std::swap(kept, fresh);
    std::sort(kept.begin(), kept.end());
    kept_is_old = false;
  }
  for (const int i : moved) clear_bit(i, kMoved);
  moved.clear();
  placed = 0;
}

/// Into `fresh`, ascending: all pairs that may be within reach and have one of the boxes asked for.
void BroadPhase::Tree::find_pairs_of(std::span<const int> asked, double reach) {
  update_tree(reach);
  fresh.clear();
  for (const int i : asked) state[at(i)] |= kAsked;
  for (const int i : asked)
    if (has(i, kPresent)) find_around(i, kAsked);
  for (const int i : asked) clear_bit(i, kAsked);
  std::sort(fresh.begin(), fresh.end());
  fresh.erase(std::unique(fresh.begin(), fresh.end()), fresh.end());
}

/// Those that are near, into `result`.
template <class Near>
void BroadPhase::Tree::filter(const std::vector<BlockPair>& pairs, const Near& near) {
  result.clear();
  for (const BlockPair& pair : pairs)
    if (near(pair)) result.push_back(pair);
}

void BroadPhase::Tree::keep_near(const std::vector<BlockPair>& pairs, double reach) {
  const float most = rounded_up(reach);
  filter(pairs, [&](const BlockPair& pair) {
    return within_reach(boxes[at(pair.a)], boxes[at(pair.b)],
                        std::max({most, reach_of(pair.a), reach_of(pair.b)}));
  });
}

bool tries_all_pairs(std::size_t boxes) { return boxes < kFewBoxes; }

BroadPhase::BroadPhase() : tree_(std::make_unique<Tree>()) {}
BroadPhase::~BroadPhase() = default;
BroadPhase::BroadPhase(BroadPhase&&) noexcept = default;
BroadPhase& BroadPhase::operator=(BroadPhase&&) noexcept = default;

BroadPhase::Tree& BroadPhase::tree() const {
  if (!tree_) throw InputError("broad phase: it was moved from");
  return *tree_;
}

void BroadPhase::require_box(int i, int end) const {
  if (i >= 0 && i < end) return;
  throw InputError("broad phase: box " + std::to_string(i) + " of " + std::to_string(size()));
}

void BroadPhase::set(int i, const Box& box, BoxUse use, double reach) {
  require_box(i, size() + 1);
  require_length(reach, "broad phase: reach of a box");
  tree().set(i, box, use, reach);
}

void BroadPhase::remove(int i) {
  require_box(i, size());
  tree().remove(i);
}

int BroadPhase::size() const { return tree().count(); }

const std::vector<BlockPair>& BroadPhase::find_candidates(double reach) {
  require_length(reach, "broad phase: reach");
  tree().find_kept(reach);
  tree().keep_near(tree().kept, reach);
  return tree().result;
}

const std::vector<BlockPair>& BroadPhase::find_candidates_of(std::span<const int> boxes,
                                                             double reach) {
  require_length(reach, "broad phase: reach");
  for (const int i : boxes) require_box(i, size());
  tree().find_pairs_of(boxes, reach);
  tree().keep_near(tree().fresh, reach);
  return tree().result;
}

const std::vector<BlockPair>& BroadPhase::find_candidates(std::span<const Box> boxes, double reach,
                                                          std::span<const char> idle) {
  require_length(reach, "broad phase: reach");
  if (!idle.empty() && idle.size() != boxes.size()) {
    throw InputError("idle has " + std::to_string(idle.size()) + " flags for " +
                     std::to_string(boxes.size()) + " boxes");
  }
  if (static_cast<int>(boxes.size()) != size()) *this = {};
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const bool is_idle = !idle.empty() && idle[i] != 0;
    set(static_cast<int>(i), boxes[i], is_idle ? BoxUse::Idle : BoxUse::Moving);
  }
  tree().find_kept(reach);
  tree().filter(tree().kept, [&](const BlockPair& pair) {
    return within_reach(boxes[at(pair.a)], boxes[at(pair.b)], reach);
  });
  return tree().result;
}

void BroadPhase::find_in_box(const Box& box, double reach, std::vector<int>& found) {
  require_length(reach, "broad phase: reach");
  Tree& t = tree();
  const FloatBox meant = rounded_outward(box, t.origin);
  t.update_tree(reach);
  found.clear();
  t.visit_where([&](const FloatBox& other) { return within_reach(other, meant, 0.0F); },
                [&](int i, const FloatBox&) {
                  if (within_reach(t.boxes[at(i)], meant, 0.0F)) found.push_back(i);
                });
  std::sort(found.begin(), found.end());
}

namespace {

/// A ray as seen from where boxes are, and where it enters one of them: nowhere is infinite. Places
/// are right to the rounding of `origin`, by which boxes are grown; those that are cut off go on.
struct SlabTest {
  Vector3 origin, direction;
  double length, rounding;

  double entry(const FloatBox& box) const {
    double enters = 0.0, leaves = length;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double low = box.min_[k] <= -kFarthest ? -kInfinity : box.min_[k] - rounding;
      const double high = box.max_[k] >= kFarthest ? kInfinity : box.max_[k] + rounding;
      if (direction[k] == 0.0) {
        if (origin[k] < low || origin[k] > high) return kInfinity;
        continue;
      }
      const double s = (low - origin[k]) / direction[k], t = (high - origin[k]) / direction[k];
      enters = std::max(enters, std::min(s, t));
      leaves = std::min(leaves, std::max(s, t));
    }
    return enters <= leaves ? enters : kInfinity;
  }
};

}  // namespace

void BroadPhase::find_on_ray(const Vector3& origin, const Vector3& direction, double length,
                             double reach, std::vector<Entry>& found) {
  require_length(reach, "broad phase: reach");
  Tree& t = tree();
  constexpr double kRounding = 8 * kEpsilon;
  const double size = origin.cwiseAbs().maxCoeff() + t.origin.cwiseAbs().maxCoeff();
  const SlabTest ray{origin - t.origin, direction, length, kRounding * size};
  t.update_tree(reach);
  found.clear();
  t.visit_where([&](const FloatBox& box) { return std::isfinite(ray.entry(box)); },
                [&](int i, const FloatBox& box) {
                  found.push_back({ray.entry(box), i});
                });
  std::sort(found.begin(), found.end(), [](const Entry& x, const Entry& y) {
    return std::tie(x.s, x.box) < std::tie(y.s, y.box);
  });
}

}  // namespace quoin::geometry
