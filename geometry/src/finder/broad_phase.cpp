#include <fcl/broadphase/detail/hierarchy_tree.h>
#include <fcl/math/bv/AABB.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <quoin/geometry/broad_phase.hpp>
#include <tuple>
#include <utility>

#include "numeric/numbers.hpp"
#include "simd/sse2.hpp"

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
constexpr double kMostReach = 1e37;  // m; all boxes are within it, and floats can hold it
constexpr std::size_t kBulk = BroadPhase::kBulk;  // more moved out: the whole tree is refitted
constexpr std::size_t kMany = 64;  // more than 1/64 are about to: as many follow as will soon
constexpr float kSoon = 0.5F;      // whose room has shrunk below half a skin
constexpr double kWornOut = 2;     // rebuilt when its queries visit twice as many nodes as when new
constexpr float kFloatEpsilon = std::numeric_limits<float>::epsilon();
constexpr float kSmallestFloat = std::numeric_limits<float>::min();
constexpr float kFarthest = 1e18F;  // m; fat boxes end here: FCL squares their sides

// Two boxes are compared on all sides: which one parts them cannot be foreseen.

#ifdef QUOIN_SSE2

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

// Six numbers each, min and max behind each other.
static_assert(sizeof(FloatBox) == 6 * sizeof(float) && sizeof(Box) == 6 * sizeof(double));

__m128 four(const FloatVector& min, int first) { return _mm_loadu_ps(min.data() + first); }

/// As FCL's, which are not inline: min x, min y, min z and min z, max x, … of either box.
bool within_reach(const FloatBox& a, const FloatBox& b, float reach) {
  const __m128 most = _mm_set1_ps(reach);
  const __m128 low_a = four(a.min_, 0), low_b = four(b.min_, 0);
  const __m128 high_a = four(a.min_, 2), high_b = four(b.min_, 2);  // min z, then max
  const __m128 order_a = _mm_shuffle_ps(high_a, high_a, _MM_SHUFFLE(3, 3, 2, 1));
  const __m128 order_b = _mm_shuffle_ps(high_b, high_b, _MM_SHUFFLE(3, 3, 2, 1));
  const __m128 first = _mm_cmple_ps(_mm_sub_ps(low_a, order_b), most);
  const __m128 second = _mm_cmple_ps(_mm_sub_ps(low_b, order_a), most);
  return (_mm_movemask_ps(_mm_and_ps(first, second)) & 7) == 7;
}

#else

bool none_beyond(const Vector3& x, const Vector3& y, const Vector3& u, const Vector3& v,
                 double limit) {
  return ((x - y).array() <= limit).all() && ((u - v).array() <= limit).all();
}

bool within_reach(const FloatBox& a, const FloatBox& b, float reach) {
  return ((a.min_ - b.max_).array() <= reach).all() && ((b.min_ - a.max_).array() <= reach).all();
}

#endif

/// Exactly the promise of the header. A rounded difference is at most `reach` whenever the true one
/// is.
bool within_reach(const Box& a, const Box& b, double reach) {
  return none_beyond(a.min, b.max, b.min, a.max, reach);
}

bool overlap(const FloatBox& a, const FloatBox& b) { return within_reach(a, b, 0.0F); }

/// A float is off by half an eps of itself, denormal ones by less than the smallest normal one; so
/// is, much less, the difference in double from which it comes.
float rounding(float value) { return std::abs(value) * kFloatEpsilon + kSmallestFloat; }

/// Not less than a length, not even after a difference of floats has been rounded.
float rounded_up(double length) {
  const float value = static_cast<float>(length);
  return value + 2 * rounding(value);
}

#ifdef QUOIN_SSE2

/// Minus for numbers of `min`, which go down and grow by what lies below, plus for those of `max`.
__m128 first_signs() { return _mm_set_ps(0.0F, -0.0F, -0.0F, -0.0F); }

__m128 rounded_outward(__m128 value, __m128 signs) {
  const __m128 size = _mm_andnot_ps(_mm_set1_ps(-0.0F), value);
  const __m128 by =
      _mm_add_ps(_mm_mul_ps(size, _mm_set1_ps(kFloatEpsilon)), _mm_set1_ps(kSmallestFloat));
  return _mm_add_ps(value, _mm_xor_ps(by, signs));
}

/// Into memory that is read again as it was written: four floats and two.
void round_outward(const Box& box, const Vector3& origin, FloatBox& made) {
  const double *x = box.min.data(), *o = origin.data();
  const __m128d low = _mm_sub_pd(_mm_loadu_pd(x), _mm_loadu_pd(o));
  const __m128d mixed = _mm_sub_pd(_mm_loadu_pd(x + 2), _mm_set_pd(o[0], o[2]));
  const __m128d high = _mm_sub_pd(_mm_loadu_pd(x + 4), _mm_loadu_pd(o + 1));
  const __m128 first = _mm_movelh_ps(_mm_cvtpd_ps(low), _mm_cvtpd_ps(mixed));
  _mm_storeu_ps(made.min_.data(), rounded_outward(first, first_signs()));
  _mm_storel_pi(reinterpret_cast<__m64*>(made.max_.data() + 1),
                rounded_outward(_mm_cvtpd_ps(high), _mm_setzero_ps()));
}

/// Does `outer` enclose `inner` with so much room on all sides?
bool encloses(const FloatBox& outer, const FloatBox& inner, float room) {
  const __m128 least = _mm_set1_ps(room);
  const auto last_two = [](const FloatBox& box) {  // as they were stored
    return _mm_castpd_ps(_mm_load_sd(reinterpret_cast<const double*>(box.max_.data() + 1)));
  };
  const __m128 first = _mm_xor_ps(
      _mm_sub_ps(_mm_loadu_ps(outer.min_.data()), _mm_loadu_ps(inner.min_.data())), first_signs());
  const __m128 last = _mm_sub_ps(last_two(outer), last_two(inner));
  const __m128 far_enough =
      _mm_and_ps(_mm_cmpge_ps(first, least), _mm_cmpge_ps(_mm_movelh_ps(last, last), least));
  return _mm_movemask_ps(far_enough) == 15;
}

#else

void round_outward(const Box& box, const Vector3& origin, FloatBox& made) {
  const FloatVector min = (box.min - origin).cast<float>();
  const FloatVector max = (box.max - origin).cast<float>();
  for (Eigen::Index k = 0; k < 3; ++k) {
    made.min_[k] = min[k] - rounding(min[k]);
    made.max_[k] = max[k] + rounding(max[k]);
  }
}

/// Does `outer` enclose `inner` with so much room on all sides?
bool encloses(const FloatBox& outer, const FloatBox& inner, float room) {
  return ((inner.min_ - outer.min_).array() >= room).all() &&
         ((outer.max_ - inner.max_).array() >= room).all();
}

#endif

float diagonal(const FloatBox& box) {
  return static_cast<float>((box.max_ - box.min_).cast<double>().norm());
}

float extent(const FloatBox& box) { return (box.max_ - box.min_).sum(); }

bool is_idle(std::span<const char> idle, std::size_t i) { return !idle.empty() && idle[i] != 0; }

/// Two subtrees that may have overlapping leaves; twice the same: the leaves of one.
struct NodePair {
  const Node *x, *y;
};

int leaf_index(const Node& leaf) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(leaf.data));
}

/// Of a box of its own, as it is kept.
float kept_reach(double reach) {
  return reach > 0.0 ? rounded_up(std::min(reach, kMostReach)) : 0.0F;
}

void* leaf_data(int i) { return reinterpret_cast<void*>(static_cast<std::intptr_t>(i)); }

/// Of a fat box, less than `growth` on all sides in spite of rounding; for other boxes to stay in.
FloatBox shrunk(FloatBox box, float growth) {
  for (Eigen::Index k = 0; k < 3; ++k) {
    const float min = box.min_[k] + growth, max = box.max_[k] - growth;
    box.min_[k] = min + rounding(min);
    box.max_[k] = max - rounding(max);
  }
  return box;
}

/// In which no box stays.
FloatBox no_room() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  FloatBox none;
  none.min_.setConstant(kInfinity);
  none.max_.setConstant(-kInfinity);
  return none;
}

/// Which boxes that are set get new room.
enum class Renewal : char { Left, Soon, All };  // that left theirs; and those that will soon; all

/// What holds of a box, as bits.
enum BoxState : std::uint8_t { kAbsent = 1, kIdle = 2, kMoved = 4, kUnplaced = 8, kAsked = 16 };

}  // namespace

/// Fat boxes in FCL's dynamic tree: each box with room around it, and half the reach. A box is put
/// into the tree anew only when it leaves its room; until then the pairs of overlapping fat boxes
/// (`kept`) hold every pair within reach.
struct BroadPhase::Tree {
  FclTree tree{2, 0};
  std::vector<FloatBox> boxes;  // as seen from `origin`, m
  std::vector<Node*> leaves;    // null: not in the tree
  std::vector<FloatBox> rooms;  // of all boxes, where these are given together; or empty
  std::vector<std::uint8_t> state;
  std::vector<float> own_reach;      // of each box, m; empty: all 0
  Vector3 origin = Vector3::Zero();  // m
  int present = 0, in_tree = 0;
  double built_reach = -1.0;  // m
  float growth = 0.0F;        // of a fat box beyond the box and its room, m
  std::size_t visits = 0, visits_when_new = 0;

  // Boxes out of their room, new or gone: since `kept` was brought up to date, and since the tree
  // was. Not all of them when too_many_moved.
  std::vector<int> moved, unplaced;
  bool too_many_moved = false;  // the whole tree will be refitted
  Renewal renewal = Renewal::Left;
  bool kept_is_old = true;  // not but for `moved`
  std::vector<BlockPair> kept, scratch, fresh, result;
  std::vector<int> row_end;  // of kept
  std::vector<const Node*> stack;
  std::vector<NodePair> pair_stack;

  int count() const { return static_cast<int>(boxes.size()); }
  bool has(int i, BoxState bit) const { return (state[at(i)] & bit) != 0; }
  bool both_idle(int a, int b) const { return (state[at(a)] & state[at(b)] & kIdle) != 0; }

  /// Up to where a box and any other are a pair, m, where `most` is so for all.
  float reach_of(int i, float most) const {
    return own_reach.empty() ? most : std::max(most, own_reach[at(i)]);
  }
  float reach_of(const BlockPair& pair, float most) const {
    return own_reach.empty() ? most : reach_of(pair.a, reach_of(pair.b, most));
  }

  std::size_t set_while_they_stay(std::size_t first, std::span<const Box> all,
                                  std::span<const char> idle);
  bool set_if_it_stays(int i, const Box& box, BoxUse use, double reach);
  void set(int i, const Box& box, BoxUse use, double reach);
  void look(int i, const Box& box, Leaving& leaving) const;
  void remove(int i);
  void clear();
  void find_kept(double reach);
  void find_pairs_of(std::span<const int> asked, double reach);
  void keep_near(const std::vector<BlockPair>& pairs, double reach);
  /// Calls visit(number, box) for all boxes of which those around them in the tree satisfy
  /// meets(box).
  template <class Meets, class Visit>
  void visit_where(double reach, const Meets& meets, const Visit& visit);
  template <class WithinReach>
  void filter(const std::vector<BlockPair>& pairs, WithinReach&& within);

 private:
  void note_moved(int i);
  void set_own_reach(int i, double reach);
  void make_rooms();
  void set_room(int i) {
    if (rooms.empty()) return;
    rooms[at(i)] = leaves[at(i)] == nullptr ? no_room() : shrunk(leaves[at(i)]->bv, growth);
  }
  /// Is a box still inside its fat box less the growth, and need not be renewed?
  bool has_room(int i, const FloatBox& box) const {
    if (renewal == Renewal::All) return false;
    const float more = renewal == Renewal::Soon ? soon(box) : 0.0F;
    return encloses(leaves[at(i)]->bv, box, grown_by(i) + more);
  }
  /// Fat boxes of a pair overlap when the boxes are within any reach of it.
  float grown_by(int i) const { return growth + reach_of(i, 0.0F); }
  /// Has the fat box room for much more reach than is asked?
  bool is_too_fat(int i, const FloatBox& box) const {
    if (own_reach.empty()) return false;
    const float most =
        extent(box) + 3 * kLookAheadCap * diagonal(box) + 6 * (kSkin * diagonal(box) + grown_by(i));
    return extent(leaves[at(i)]->bv) > static_cast<float>(kReachWaste) * most;
  }
  static float soon(const FloatBox& box) { return kSoon * kSkin * diagonal(box); }
  FloatBox fat_box(int i, const FloatVector& ahead) const;
  void use_reach(double reach);
  void fell_tree();
  void try_all(double reach);
  void update_tree(double reach);
  void bring_up_to_date(double reach);
  void plant();
  void follow(double reach);
  void update_kept();
  bool insert_new();
  void put_moved();
  template <class Visit>
  void query(const FloatBox& box, Visit&& visit);
  template <class Meets, class Visit>
  void walk(const Meets& meets, const Visit& visit);
  void query_all();
  void sort_kept();
  void query_moved();
  void ask_few(std::span<const int> asked, double reach);
  void ask_tree(std::span<const int> asked);
  void forget_moved();
  void forget_unplaced();
  void clear_bit(int i, BoxState bit) {
    state[at(i)] = static_cast<std::uint8_t>(state[at(i)] & ~bit);
  }
};

/// The box grown by its skin, along the way it goes, by half the reach of all and by its own; never
/// less than that in spite of rounding, but cut off at kFarthest. A box of NaN is within reach of
/// nothing: it gets a place of no size, and is looked at again in each call.
FloatBox BroadPhase::Tree::fat_box(int i, const FloatVector& ahead) const {
  const FloatBox& box = boxes[at(i)];
  const float length = std::min(diagonal(box), kFarthest);
  FloatBox fat;
  if (std::isnan(length)) {
    fat.min_.setZero();
    fat.max_.setZero();
    return fat;
  }
  const float cap = kLookAheadCap * length, room = grown_by(i);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const float way = std::clamp(kLookAhead * ahead[k], -cap, cap);
    const float low = kSkin * length + room + std::max(0.0F, -way);
    const float high = kSkin * length + room + std::max(0.0F, way);
    const float min = box.min_[k] - low - 4 * rounding(std::abs(box.min_[k]) + low);
    const float max = box.max_[k] + high + 4 * rounding(std::abs(box.max_[k]) + high);
    fat.min_[k] = std::clamp(min, -kFarthest, kFarthest);
    fat.max_[k] = std::clamp(max, -kFarthest, kFarthest);
  }
  return fat;
}

void BroadPhase::Tree::note_moved(int i) {
  if ((has(i, kMoved) && has(i, kUnplaced)) || too_many_moved) return;
  if (moved.size() * kBulk > boxes.size()) {
    too_many_moved = true;
    renewal = Renewal::All;
    return;
  }
  if (!has(i, kMoved)) moved.push_back(i);
  if (!has(i, kUnplaced)) unplaced.push_back(i);
  state[at(i)] |= kMoved | kUnplaced;
}

void BroadPhase::Tree::set_own_reach(int i, double reach) {
  if (own_reach.empty()) own_reach.assign(boxes.size(), 0.0F);
  own_reach[at(i)] = kept_reach(reach);
}

/// Of boxes without a reach of their own.
void BroadPhase::Tree::make_rooms() {
  rooms.resize(boxes.size());
  for (int i = 0; i < count(); ++i) set_room(i);
}

/// From the first on, the boxes that stay in their room and are used as before: of most no more is
/// asked. Returns the number of the first that is not set.
std::size_t BroadPhase::Tree::set_while_they_stay(std::size_t first, std::span<const Box> all,
                                                  std::span<const char> idle) {
  if (renewal != Renewal::Left || !own_reach.empty()) return first;
  if (rooms.size() != boxes.size()) make_rooms();
  const std::size_t last = std::min(all.size(), boxes.size());
  const Vector3 from = origin;
  FloatBox* const set = boxes.data();
  const FloatBox* const room = rooms.data();
  const std::uint8_t* const states = state.data();
  for (std::size_t i = first; i < last; ++i) {
    FloatBox next;
    round_outward(all[i], from, next);
    const int use = is_idle(idle, i) ? kIdle : 0;
    if (!encloses(room[i], next, 0.0F) || (states[i] & (kAbsent | kIdle)) != use) return i;
    set[i] = next;
  }
  return last;
}

void BroadPhase::Tree::look(int i, const Box& box, Leaving& leaving) const {
  const Node* leaf = i < count() ? leaves[at(i)] : nullptr;
  FloatBox next;
  round_outward(box, origin, next);
  leaving.now += leaf == nullptr || !encloses(leaf->bv, next, grown_by(i));
  leaving.soon += leaf == nullptr || !encloses(leaf->bv, next, grown_by(i) + soon(boxes[at(i)]));
}

bool BroadPhase::Tree::set_if_it_stays(int i, const Box& box, BoxUse use, double reach) {
  if (i >= count() || leaves[at(i)] == nullptr) return false;
  const std::uint8_t idle = use == BoxUse::Idle ? kIdle : 0;
  const float own = own_reach.empty() ? 0.0F : own_reach[at(i)];
  if ((state[at(i)] & (kAbsent | kIdle)) != idle || kept_reach(reach) != own) return false;
  FloatBox next;
  round_outward(box, origin, next);
  if (!has_room(i, next) || is_too_fat(i, next)) return false;
  boxes[at(i)] = next;
  return true;
}

/// A new fat box waits in the leaf until follow() brings the tree up to date.
void BroadPhase::Tree::set(int i, const Box& box, BoxUse use, double reach) {
  if (set_if_it_stays(i, box, use, reach)) return;
  if (boxes.empty() && box.min.allFinite()) origin = box.min;
  if (i == count()) {
    boxes.emplace_back();
    leaves.push_back(nullptr);
    state.push_back(kAbsent);
    if (!own_reach.empty()) own_reach.push_back(0.0F);
  }
  if (reach > 0.0 || !own_reach.empty()) set_own_reach(i, reach);
  const FloatVector before = boxes[at(i)].min_;
  round_outward(box, origin, boxes[at(i)]);
  const std::uint8_t idle = use == BoxUse::Idle ? kIdle : 0;
  const bool idle_changed = (state[at(i)] & kIdle) != idle;
  present += has(i, kAbsent);
  state[at(i)] = static_cast<std::uint8_t>((state[at(i)] & (kMoved | kUnplaced)) | idle);
  Node* leaf = leaves[at(i)];
  if (leaf != nullptr && (!has_room(i, boxes[at(i)]) || is_too_fat(i, boxes[at(i)]))) {
    leaf->bv = fat_box(i, boxes[at(i)].min_ - before);
    set_room(i);
    note_moved(i);
  } else if (leaf == nullptr || idle_changed) {
    note_moved(i);
  }
}

void BroadPhase::Tree::remove(int i) {
  if (has(i, kAbsent)) return;
  --present;
  state[at(i)] = static_cast<std::uint8_t>((state[at(i)] & (kMoved | kUnplaced)) | kAbsent);
  note_moved(i);
  if (leaves[at(i)] == nullptr) return;
  tree.remove(leaves[at(i)]);
  leaves[at(i)] = nullptr;
  set_room(i);
  --in_tree;
}

void BroadPhase::Tree::clear() {
  fell_tree();
  boxes.clear();
  leaves.clear();
  state.clear();
  own_reach.clear();
  moved.clear();
  unplaced.clear();
  kept.clear();
  present = 0;
  too_many_moved = false;
  renewal = Renewal::Left;
}

void BroadPhase::Tree::fell_tree() {
  tree.clear();
  std::fill(leaves.begin(), leaves.end(), nullptr);
  rooms.clear();
  in_tree = 0;
  kept_is_old = true;
}

void BroadPhase::Tree::use_reach(double reach) {
  built_reach = std::min(reach * kReachSlack, kMostReach);
  growth = rounded_up(0.5 * built_reach);
  rooms.clear();
}

/// Afterwards `kept` holds all pairs within reach, ascending.
void BroadPhase::Tree::find_kept(double reach) {
  const double most = std::min(reach, kMostReach);
  if (present < kFewBoxes) {
    if (in_tree > 0) fell_tree();
    try_all(most);
  } else {
    update_tree(most);
    update_kept();
  }
  forget_unplaced();
  forget_moved();
}

void BroadPhase::Tree::update_tree(double reach) {
  if (in_tree > 0) return follow(reach);
  use_reach(reach);
  plant();
}

/// The tree is up to date; afterwards `kept` is.
void BroadPhase::Tree::update_kept() {
  if (!kept_is_old) {
    if (!moved.empty()) query_moved();
    return;
  }
  query_all();
  if (visits_when_new > 0 &&
      static_cast<double>(visits) > kWornOut * static_cast<double>(visits_when_new)) {
    tree.balanceTopdown();
    query_all();
    visits_when_new = 0;
  }
  if (visits_when_new == 0) visits_when_new = visits;
  kept_is_old = false;
}

/// Into `fresh`, ascending: all pairs that may be within reach and have one of the boxes asked for.
void BroadPhase::Tree::find_pairs_of(std::span<const int> asked, double reach) {
  const double most = std::min(reach, kMostReach);
  for (const int i : asked) state[at(i)] |= kAsked;
  fresh.clear();
  if (present < kFewBoxes) {
    ask_few(asked, most);
  } else {
    bring_up_to_date(most);
    ask_tree(asked);
  }
  for (const int i : asked) clear_bit(i, kAsked);
  std::sort(fresh.begin(), fresh.end());
  fresh.erase(std::unique(fresh.begin(), fresh.end()), fresh.end());
}

/// The tree, while `kept` waits.
void BroadPhase::Tree::bring_up_to_date(double reach) {
  update_tree(reach);
  forget_unplaced();
  if (kept_is_old) forget_moved();
}

template <class Meets, class Visit>
void BroadPhase::Tree::visit_where(double reach, const Meets& meets, const Visit& visit) {
  if (present >= kFewBoxes) {
    bring_up_to_date(std::min(reach, kMostReach));
    return walk(meets, [&](const Node& leaf) { visit(leaf_index(leaf), leaf.bv); });
  }
  for (int i = 0; i < count(); ++i) {
    if (!has(i, kAbsent) && meets(boxes[at(i)])) visit(i, boxes[at(i)]);
  }
}

void BroadPhase::Tree::ask_few(std::span<const int> asked, double reach) {
  const float most = rounded_up(reach);
  for (const int i : asked) {
    for (int j = 0; j < count() && !has(i, kAbsent); ++j) {
      if (i == j || has(j, kAbsent) || (has(j, kAsked) && j < i) || both_idle(i, j)) continue;
      const BlockPair pair{std::min(i, j), std::max(i, j)};
      if (within_reach(boxes[at(i)], boxes[at(j)], reach_of(pair, most))) fresh.push_back(pair);
    }
  }
}

void BroadPhase::Tree::ask_tree(std::span<const int> asked) {
  for (const int i : asked) {
    if (has(i, kAbsent)) continue;
    query(leaves[at(i)]->bv, [&](int j) {
      if (i != j && (!has(j, kAsked) || i < j) && !both_idle(i, j)) {
        fresh.push_back({std::min(i, j), std::max(i, j)});
      }
    });
  }
}

void BroadPhase::Tree::try_all(double reach) {
  const float most = rounded_up(reach);
  kept.clear();
  for (int a = 0; a < count(); ++a) {
    if (has(a, kAbsent)) continue;
    for (int b = a + 1; b < count(); ++b) {
      if (!has(b, kAbsent) && !both_idle(a, b) &&
          within_reach(boxes[at(a)], boxes[at(b)], reach_of({a, b}, most))) {
        kept.push_back({a, b});
      }
    }
  }
}

void BroadPhase::Tree::plant() {
  fell_tree();
  std::vector<Node*> order;  // init sorts what it is given
  for (int i = 0; i < count(); ++i) {
    if (has(i, kAbsent)) continue;
    Node* leaf = new Node;  // owned and deleted by the tree
    leaf->bv = fat_box(i, FloatVector::Zero());
    leaf->parent = nullptr;
    leaf->children[1] = nullptr;
    leaf->data = leaf_data(i);
    leaves[at(i)] = leaf;
    order.push_back(leaf);
  }
  in_tree = present;
  tree.init(order, 0);
  visits_when_new = 0;
}

template <class Visit>
void BroadPhase::Tree::query(const FloatBox& box, Visit&& visit) {
  walk([&](const FloatBox& other) { return overlap(other, box); },
       [&](const Node& leaf) { visit(leaf_index(leaf)); });
}

/// Down the branches whose boxes meet something.
template <class Meets, class Visit>
void BroadPhase::Tree::walk(const Meets& meets, const Visit& visit) {
  stack.clear();
  stack.push_back(tree.getRoot());
  while (!stack.empty()) {
    const Node* node = stack.back();
    stack.pop_back();
    ++visits;
    if (!meets(node->bv)) continue;
    if (node->isLeaf()) {
      visit(*node);
    } else {
      stack.push_back(node->children[0]);
      stack.push_back(node->children[1]);
    }
  }
}

/// The tree against itself: each pair of subtrees that overlap is entered once. Whether two do
/// cannot be foreseen: both lists are written to in any case, and grow where it is so.
void BroadPhase::Tree::query_all() {
  constexpr std::size_t kMostMet = 4;  // at once
  kept.resize(kMostMet);
  pair_stack.resize(2 * kMostMet);
  visits = 0;
  std::size_t found = 0, waiting = 0;
  const auto meet = [&](const Node* x, const Node* y) {
    const bool met = overlap(x->bv, y->bv), ends = x->isLeaf() & y->isLeaf();
    const int a = leaf_index(*x), b = leaf_index(*y);
    kept[found] = {std::min(a, b), std::max(a, b)};
    found += met & ends;
    pair_stack[waiting] = {x, y};
    waiting += met & !ends;
    ++visits;
  };
  pair_stack[waiting++] = {tree.getRoot(), tree.getRoot()};
  while (waiting > 0) {
    const auto [x, y] = pair_stack[--waiting];
    if (kept.size() < found + kMostMet) kept.resize(2 * kept.size());
    if (pair_stack.size() < waiting + kMostMet) pair_stack.resize(2 * pair_stack.size());
    const Node* const* in_x = x->children;
    const Node* const* in_y = y->children;
    if (x == y) {
      for (int k = 0; k < 2; ++k) {
        pair_stack[waiting] = {in_x[k], in_x[k]};
        waiting += !in_x[k]->isLeaf();
      }
      meet(in_x[0], in_x[1]);
    } else if (x->isLeaf()) {
      for (int k = 0; k < 2; ++k) meet(x, in_y[k]);
    } else if (y->isLeaf()) {
      for (int k = 0; k < 2; ++k) meet(in_x[k], y);
    } else {
      for (int k = 0; k < 4; ++k) meet(in_x[k / 2], in_y[k % 2]);
    }
  }
  kept.resize(found);
  std::erase_if(kept, [&](const BlockPair& pair) { return both_idle(pair.a, pair.b); });
  sort_kept();
}

/// By their first blocks, a row for each few of these; then the few pairs of each row.
void BroadPhase::Tree::sort_kept() {
  constexpr int kBlocksOfRow = 4;  // a byte a block, which is kept: nothing is allocated when warm
  const auto row = [](const BlockPair& pair) { return at(pair.a / kBlocksOfRow); };
  row_end.assign(boxes.size() / kBlocksOfRow + 2, 0);
  for (const BlockPair& pair : kept) ++row_end[row(pair) + 1];
  for (std::size_t i = 1; i < row_end.size(); ++i) row_end[i] += row_end[i - 1];
  scratch.resize(kept.size());
  for (const BlockPair& pair : kept) scratch[at(row_end[row(pair)]++)] = pair;
  int first = 0;
  for (const int last : row_end) {  // each end has moved on by its row's size
    if (last - first > 1) std::sort(scratch.begin() + first, scratch.begin() + last);
    first = last;
  }
  std::swap(kept, scratch);
}

void BroadPhase::Tree::query_moved() {
  fresh.clear();
  for (const int i : moved) {
    if (has(i, kAbsent)) continue;
    query(leaves[at(i)]->bv, [&](int j) {
      if (i != j && (!has(j, kMoved) || i < j) && !both_idle(i, j)) {
        fresh.push_back({std::min(i, j), std::max(i, j)});
      }
    });
  }
  std::sort(fresh.begin(), fresh.end());
  std::erase_if(kept,
                [&](const BlockPair& pair) { return has(pair.a, kMoved) || has(pair.b, kMoved); });
  scratch.resize(kept.size() + fresh.size());
  std::merge(kept.begin(), kept.end(), fresh.begin(), fresh.end(), scratch.begin());
  std::swap(kept, scratch);
}

/// Boxes that are not in the tree yet; false: so many that it is better made anew.
bool BroadPhase::Tree::insert_new() {
  if ((present - in_tree) * static_cast<int>(kBulk) > present) return false;
  if (present == in_tree) return true;
  rooms.clear();
  for (int i = 0; i < count(); ++i) {
    if (has(i, kAbsent) || leaves[at(i)] != nullptr) continue;
    leaves[at(i)] = tree.insert(fat_box(i, FloatVector::Zero()), leaf_data(i));
    ++in_tree;
  }
  return true;
}

/// FCL's tree does nothing when the box that a leaf holds contains the new one: it holds none.
void BroadPhase::Tree::put_moved() {
  for (const int i : unplaced) {
    if (has(i, kAbsent)) continue;
    const FloatBox fat = leaves[at(i)]->bv;
    leaves[at(i)]->bv = FloatBox();
    tree.update(leaves[at(i)], fat);
  }
}

/// Brings the tree up to date with boxes that left their room, came, went, or fell idle or are so
/// no longer. `kept` may be old then.
void BroadPhase::Tree::follow(double reach) {
  const bool other_reach = reach > built_reach || reach * kReachWaste * kReachSlack < built_reach;
  if (other_reach) use_reach(reach);
  if (!insert_new()) return plant();
  if (!other_reach && !too_many_moved) return put_moved();
  if (other_reach) {
    for (int i = 0; i < count(); ++i) {
      if (leaves[at(i)] != nullptr) leaves[at(i)]->bv = fat_box(i, FloatVector::Zero());
    }
  }
  tree.refit();
  kept_is_old = true;
}

void BroadPhase::Tree::forget_moved() {
  for (const int i : moved) clear_bit(i, kMoved);
  moved.clear();
}

void BroadPhase::Tree::forget_unplaced() {
  for (const int i : unplaced) clear_bit(i, kUnplaced);
  unplaced.clear();
  too_many_moved = false;
  renewal = Renewal::Left;
}

/// Those that are within reach, into `result`.
template <class WithinReach>
void BroadPhase::Tree::filter(const std::vector<BlockPair>& pairs, WithinReach&& within) {
  std::array<BlockPair, 256> few;  // still in the cache when they are copied
  result.clear();
  result.reserve(pairs.size());
  for (std::size_t first = 0; first < pairs.size(); first += few.size()) {
    const std::size_t last = std::min(first + few.size(), pairs.size());
    std::size_t found = 0;
    for (std::size_t k = first; k < last; ++k) {
      few[found] = pairs[k];
      found += within(pairs[k]);
    }
    result.insert(result.end(), few.begin(), few.begin() + static_cast<std::ptrdiff_t>(found));
  }
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

void BroadPhase::set(int i, const Box& box, BoxUse use, double reach) {
  if (i < 0 || i > size()) {
    throw InputError("broad phase: box " + std::to_string(i) + " of " + std::to_string(size()));
  }
  require_length(reach, "broad phase: reach of a box");
  tree().set(i, box, use, reach);
}

bool BroadPhase::set_if_it_stays(int i, const Box& box, BoxUse use, double reach) {
  return i >= 0 && tree().set_if_it_stays(i, box, use, reach);
}

void BroadPhase::remove(int i) {
  if (i < 0 || i >= size()) {
    throw InputError("broad phase: box " + std::to_string(i) + " of " + std::to_string(size()));
  }
  tree().remove(i);
}

void BroadPhase::look(int i, const Box& box, Leaving& leaving) const {
  tree().look(i, box, leaving);
}

void BroadPhase::renew(const Leaving& leaving, std::size_t all) {
  if (leaving.now * kSample * kMany <= all) return;
  const bool most = leaving.soon * kSample * kBulk > all;
  tree().renewal = most ? Renewal::All : Renewal::Soon;
  tree().too_many_moved = tree().too_many_moved || most;
}

void BroadPhase::clear() { tree().clear(); }

int BroadPhase::size() const { return tree().count(); }

void BroadPhase::Tree::keep_near(const std::vector<BlockPair>& pairs, double reach) {
  const float most = rounded_up(std::min(reach, kMostReach));
  filter(pairs, [&](const BlockPair& pair) {
    return within_reach(boxes[at(pair.a)], boxes[at(pair.b)], reach_of(pair, most));
  });
}

const std::vector<BlockPair>& BroadPhase::find_candidates(double reach) {
  require_length(reach, "broad phase: reach");
  tree().find_kept(reach);
  tree().keep_near(tree().kept, reach);
  return tree().result;
}

const std::vector<BlockPair>& BroadPhase::find_candidates_of(std::span<const int> boxes,
                                                             double reach) {
  require_length(reach, "broad phase: reach");
  for (const int i : boxes) {
    if (i >= 0 && i < size()) continue;
    throw InputError("broad phase: box " + std::to_string(i) + " of " + std::to_string(size()));
  }
  tree().find_pairs_of(boxes, reach);
  tree().keep_near(tree().fresh, reach);
  return tree().result;
}

namespace {

/// A ray as seen from where boxes are, and where it enters one of them: nowhere is infinite. Places
/// are right to the rounding of `origin`, by which boxes are grown; those that the tree cuts off at
/// kFarthest go on.
struct SlabTest {
  Vector3 origin, direction;
  double length, rounding;

  double entry(const FloatBox& box) const {
    constexpr double kEnd = std::numeric_limits<double>::infinity();
    double enters = 0.0, leaves = length;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double min = box.min_[k] <= -kFarthest ? -kEnd : box.min_[k] - rounding;
      const double max = box.max_[k] >= kFarthest ? kEnd : box.max_[k] + rounding;
      if (direction[k] == 0.0) {
        if (origin[k] < min || origin[k] > max) return kEnd;
        continue;
      }
      const double s = (min - origin[k]) / direction[k], t = (max - origin[k]) / direction[k];
      enters = std::max(enters, std::min(s, t));
      leaves = std::min(leaves, std::max(s, t));
    }
    return enters <= leaves ? enters : kEnd;
  }
};

}  // namespace

void BroadPhase::find_in_box(const Box& box, double reach, std::vector<int>& found) {
  require_length(reach, "broad phase: reach");
  Tree& t = tree();
  FloatBox meant, in_tree;  // which ends at kFarthest
  round_outward(box, t.origin, meant);
  in_tree.min_ = meant.min_.cwiseMax(-kFarthest).cwiseMin(kFarthest);
  in_tree.max_ = meant.max_.cwiseMax(-kFarthest).cwiseMin(kFarthest);
  const auto meets = [&](const FloatBox& other) {
    return within_reach(other, meant, 0.0F) || within_reach(other, in_tree, 0.0F);
  };
  found.clear();
  t.visit_where(reach, meets, [&](int i, const FloatBox&) {
    if (within_reach(t.boxes[at(i)], meant, 0.0F)) found.push_back(i);
  });
  std::sort(found.begin(), found.end());
}

void BroadPhase::find_on_ray(const Vector3& origin, const Vector3& direction, double length,
                             double reach, std::vector<Entry>& found) {
  require_length(reach, "broad phase: reach");
  Tree& t = tree();
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  const double size = origin.cwiseAbs().maxCoeff() + t.origin.cwiseAbs().maxCoeff();
  const SlabTest ray{origin - t.origin, direction, length, kRounding * size};
  const auto meets = [&](const FloatBox& box) { return std::isfinite(ray.entry(box)); };
  found.clear();
  t.visit_where(reach, meets, [&](int i, const FloatBox& box) {
    found.push_back({ray.entry(box), i});
  });
  std::sort(found.begin(), found.end(), [](const Entry& x, const Entry& y) {
    return std::tie(x.s, x.box) < std::tie(y.s, y.box);
  });
}

const std::vector<BlockPair>& BroadPhase::find_candidates(std::span<const Box> boxes, double reach,
                                                          std::span<const char> idle) {
  require_length(reach, "broad phase: reach");
  if (!idle.empty() && idle.size() != boxes.size()) {
    throw InputError("idle has " + std::to_string(idle.size()) + " flags for " +
                     std::to_string(boxes.size()) + " boxes");
  }
  if (boxes.size() != tree().boxes.size()) tree().clear();
  const auto look_at_all = [&] {
    Leaving leaving;
    for (std::size_t i = 0; i < boxes.size(); i += kSample) {
      look(static_cast<int>(i), boxes[i], leaving);
    }
    renew(leaving, boxes.size());
  };
  bool looked = false;  // when the first one leaves: where many do, it is soon found
  for (std::size_t i = 0;; ++i) {
    i = tree().set_while_they_stay(i, boxes, idle);
    if (i == boxes.size()) break;
    if (!std::exchange(looked, true)) look_at_all();
    tree().set(static_cast<int>(i), boxes[i], is_idle(idle, i) ? BoxUse::Idle : BoxUse::Moving,
               0.0);
  }
  tree().find_kept(reach);
  tree().filter(tree().kept, [&](const BlockPair& pair) {
    return within_reach(boxes[at(pair.a)], boxes[at(pair.b)], reach);
  });
  return tree().result;
}

}  // namespace quoin::geometry
