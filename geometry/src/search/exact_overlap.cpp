#include "search/exact_search.hpp"

#include <cmath>
#include <cstdint>

#include "numeric/error_bounds.hpp"
#include "numeric/vec3.hpp"
#include "shape/convex_hull.hpp"

namespace quoin::geometry {
namespace {

/// The plane of a facet beyond which the set of differences does not reach, within rounding.
struct SupportPlane {
  Vec3 normal;         // unit, outward
  DoubleDouble value;  // its distance from the origin, m
  bool slim;           // of a triangle so slim that rounding turns the normal
  SupportPlane() {}    // NOLINT: filled later
  SupportPlane(const Vec3& normal_in, const DoubleDouble& value_in, bool slim_in)
      : normal(normal_in), value(value_in), slim(slim_in) {}
};

/// The vertices of which one may make the farthest corner along a direction: rounding shifts two
/// corners by eps D each, and two values of the scan by half of that. False: there are too many.
bool find_candidates(const Solid& solid, const Vector3& direction, double rounding,
                     VertexSet& vertices) {
  constexpr double kNear = 4.0;      // of eps D; with room
  constexpr std::size_t kMany = 32;  // room in VertexSet
  const double limit = support(solid, direction).value - kNear * rounding;
  const Vec3 local = solid.turned_back(direction);
  for (int v = 0; v < solid.vertex_count(); ++v) {
    if (dot(row_offset(solid, v), local) < limit) continue;
    if (vertices.size() == kMany) return false;
    vertices.push_back(v);
  }
  return true;
}

/// Planes of different directions, of each direction the best.
class SupportPlanes {
 public:
  const SupportPlane* begin() const { return planes_.data(); }
  const SupportPlane* end() const { return planes_.data() + count_; }
  /// `one`: the square of the angle, rad, up to which two directions count as one.
  void clear(double one) {
    count_ = 0;
    one_ = one;
  }

  /// That of the same direction, or the end.
  const SupportPlane* find(const Vec3& normal) const {
    return std::find_if(begin(), end(),
                        [&](const SupportPlane& m) { return square(m.normal - normal) < one_; });
  }
  /// Are two of those within a distance so close that corners left out may make them one, or not?
  bool any_close(double limit) const {
    for (const SupportPlane* m = begin(); m != end(); ++m) {
      if (!(m->value.high <= limit)) continue;
      const bool close = std::any_of(begin(), m, [&](const SupportPlane& n) {
        return n.value.high <= limit && square(m->normal - n.normal) < 4.0 * kOneDirection;
      });
      if (close) return true;
    }
    return false;
  }
  /// Those that find no room are as good as the others.
  void add(const SupportPlane& plane) {
    const auto place = static_cast<std::size_t>(find(plane.normal) - begin());
    if (place < count_) {
      if (plane.value < planes_[place].value) planes_[place] = plane;
    } else if (count_ < planes_.size()) {
      planes_[count_++] = plane;
    }
  }

 private:
  std::array<SupportPlane, 512> planes_;
  std::size_t count_ = 0;
  double one_ = 0.25 * kOneDirection;  // half of the angle: the rest is looked at once more
};

/// The hull of some corners of the set of differences Q - P, each rounded to doubles, convex by
/// predicates in double-double; the origin may lie anywhere. The facet whose plane is nearest to
/// the origin (or has it farthest outside) either is a facet of the whole set within rounding, or
/// the set reaches beyond it and a corner is added. Facets are triangles, counter-clockwise seen
/// from outside.
class Polytope {
 public:
  Polytope(const Solid& p, const Solid& q)
      : p_(p), q_(q), rounding_(kEpsilon * std::max(p.diameter(), q.diameter())) {}

  LeastOverlap grow(const ActiveFeatures& start) {
    LeastOverlap result;
    expand(start);
    if (full_) {  // what is known of planes stays
      left_ = kInfinity;
      for (octant_ = 0; octant_ < kWhole; ++octant_) expand(start);
    }
    conclude(result);
    if (!full_ && is_doubtful()) {
      look_closer();
      if (!full_) conclude(result);
    }
    result.iterations = steps_;
    return result;
  }

 private:
  using Index = std::size_t;     // of a corner or a facet
  using Number = std::uint16_t;  // the same, stored
  static constexpr Index kMostCorners = 2048, kMostFacets = 2 * kMostCorners;
  static constexpr Index kNone = kMostFacets;
  static constexpr unsigned kWhole = 8;  // octants
  static constexpr Index kBlock = 32;    // facets whose least key is known
  // In units of the rounding, eps of the larger diameter:
  static constexpr double kFlush = 1.25;       // so far the set may reach beyond a facet of its own
  static constexpr double kShort = 1.75;       // the same, and what doubles may be off
  static constexpr double kClear = 64.0;       // beyond a facet that is laid in doubles
  static constexpr double kSpan = 64.0;        // a corner of the start from the others
  static constexpr double kTie = 2.0;          // planes as good
  static constexpr double kSure = 8.0;         // planes surely no better
  static constexpr double kTouch = kRounding;  // an overlap that is none
  static constexpr double kBothTouch =
      kBothPart * kRounding;                           // of planes that part the solids, too
  static constexpr double kLook = kBothTouch + kSure;  // facets that may carry such planes

  struct Corner {
    Vec3 w;
    int p, q;
  };
  struct Facet {
    Vec3 normal;      // unit, outward
    double distance;  // of the plane from the origin, m
    double error;     // of the normal, rad
    Number corners[3];
    Number across[3];    // the facet beyond the side from corner k to the next
    std::uint32_t seen;  // the last growth that took it away
    bool exact;          // the normal is right to the last places
    bool found;  // one of the set that may carry the answer: what lies beside it is looked at
  };
  struct Side {
    Number from, to, outside;
  };

  static Number number(Index i) { return static_cast<Number>(i); }
  Vec3 place(const Facet& facet, Index k) const { return corners_[facet.corners[k]].w; }

  Corner corner_of(int i, int j) { return {exact_corner(p_, q_, i, j).rounded(), i, j}; }
  Corner find_corner(const Vec3& direction) {
    return corner_of(support(p_, -direction).vertex, support(q_, direction).vertex);
  }

  /// The same exactly, among all that may be it; a corner of the facet where those are too many.
  Corner farthest_corner(const Facet& facet) {
    const Vec3 a = place(facet, 0);
    const WideVector normal =
        cross(wide_difference(place(facet, 1), a), wide_difference(place(facet, 2), a));
    VertexSet near_p, near_q;
    if (!find_candidates(p_, -facet.normal, rounding_, near_p) ||
        !find_candidates(q_, facet.normal, rounding_, near_q))
      return corners_[facet.corners[0]];
    Corner best = corners_[facet.corners[0]];
    DoubleDouble most = 0.0;
    for (const int i : near_p) {
      for (const int j : near_q) {
        const Corner corner = corner_of(i, j);
        const DoubleDouble height = dot(normal, wide_difference(corner.w, a));
        if (!(most < height)) continue;
        most = height;
        best = corner;
      }
    }
    return best;
  }
  /// Of a facet beyond which the set reaches by less than doubles tell. False: it does not.
  bool add_farthest(Index f) {
    const Facet& facet = facets_[f];
    const Corner corner = farthest_corner(facet);
    if (!(orientation(place(facet, 0), place(facet, 1), place(facet, 2), corner.w) > 0))
      return false;
    const Growth growth = add(f, corner);
    full_ = full_ || growth == Growth::Full;
    return growth == Growth::Grown;
  }

  /// Until each facet that may carry the answer has been looked at.
  void expand(const ActiveFeatures& start) {
    corner_count_ = facet_count_ = free_count_ = 0;
    if (!begin(start)) {
      left_ = -kInfinity;
      return;
    }
    while (step()) {
    }
  }

  /// All facets once more, now until no corner lies beyond those that are looked at.
  void look_closer() {
    closer_ = true;
    planes_.clear(kOneDirection);
    broad_.clear(kOneDirection);
    for (Index f = 0; f < facet_count_; ++f) facets_[f].found = false;
    for (Index f = 0; f < facet_count_; ++f)
      if (!(key_[f] < kInfinity))
        lay_exactly(f);
      else
        set_key(f, least_distance(f));
    for (Index k = 0; k < free_count_; ++k) set_key(free_[k], kInfinity);
    while (step()) {
    }
  }

  // ---- the first tetrahedron ----

  bool begin(const ActiveFeatures& start) {
    for (Index k = 0; k < static_cast<Index>(start.corners) && corner_count_ < 4; ++k) {
      const Corner corner = corner_of(start.p[k], start.q[k]);
      if (reach(corner.w) > kSpan * rounding_) corners_[corner_count_++] = corner;
    }
    while (corner_count_ < 4)
      if (!add_across()) return false;
    const Vec3 a = corners_[0].w;
    if (volume(a, corners_[1].w, corners_[2].w, corners_[3].w) > 0.0)
      std::swap(corners_[0], corners_[1]);
    static constexpr Number kSides[4][3] = {{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}};
    static constexpr Number kAcross[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    for (Index f = 0; f < 4; ++f) {
      Facet& facet = facets_[f];
      std::copy_n(kSides[f], 3, facet.corners);
      std::copy_n(kAcross[f], 3, facet.across);
      facet.seen = 0;
      facet.found = false;
      open_slot();
    }
    for (Index f = 0; f < 4; ++f) lay(f);
    return true;
  }

  /// Six times the volume, positive where d is outside of a, b, c.
  static double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Vec3 u = b - a, v = c - a, w = d - a;
    const double rough = dot(cross(u, v), w);
    const double size = std::sqrt(square(u) * square(v) * square(w));
    if (std::abs(rough) > kVolumeRounding * kEpsilon * size) return rough;
    const double fine =
        double(dot(cross(wide_difference(b, a), wide_difference(c, a)), wide_difference(d, a)));
    return std::abs(fine) > kWideVolumeRounding * size ? fine : orientation(a, b, c, d);
  }

  /// A direction in which the corners so far do not extend.
  Vec3 across_corners() const {
    const Vec3 a = corners_[0].w;
    if (corner_count_ == 3) return cross(corners_[1].w - a, corners_[2].w - a);
    Vector3 line = corner_count_ == 2 ? Vector3(corners_[1].w - a)
                                      : Vector3(q_.vertex_mean() - p_.vertex_mean());
    if (line.isZero(0.0)) line = Vector3::UnitX();
    int axis = 0;
    line.cwiseAbs().minCoeff(&axis);
    return line.cross(Vector3::Unit(axis));
  }

  /// How far a corner lies from what those that are there span, m.
  double reach(const Vec3& w) const {
    if (corner_count_ == 0) return kInfinity;
    const Vec3 a = corners_[0].w;
    if (corner_count_ == 1) return std::sqrt(square(w - a));
    const Vec3 line = corners_[1].w - a;
    if (corner_count_ == 2) return std::sqrt(square(cross(line, w - a)) / square(line));
    const Vec3 normal = cross(line, corners_[2].w - a);
    return std::abs(dot(normal, w - a)) / std::sqrt(square(normal));
  }

  bool add_across() {
    if (corner_count_ == 0) {
      corners_[corner_count_++] = find_corner(Vec3(p_.vertex_mean()) - Vec3(q_.vertex_mean()));
      return true;
    }
    const Vec3 direction = across_corners();
    Corner best{};
    double most = 0.0;
    for (const double side : {1.0, -1.0}) {
      const Corner corner = find_corner(side * direction);
      const double more = reach(corner.w);
      if (more > most) {
        most = more;
        best = corner;
      }
    }
    if (!(most > 0.0)) return false;
    corners_[corner_count_++] = best;
    return true;
  }

  // ---- planes and their order ----

  void open_slot() {
    const Index f = facet_count_++;
    if (f % kBlock == 0) least_[f / kBlock] = kInfinity;
    key_[f] = kInfinity;
  }
  void set_key(Index f, double key) {
    key_[f] = key;
    double& least = least_[f / kBlock];
    if (key <= least) {
      least = key;
      return;
    }
    const Index first = f - f % kBlock, last = std::min(first + kBlock, facet_count_);
    least = *std::min_element(key_ + first, key_ + last);
  }
  Index least_facet() const {
    const Index blocks = (facet_count_ + kBlock - 1) / kBlock;
    const Index block = static_cast<Index>(std::min_element(least_, least_ + blocks) - least_);
    if (!(least_[block] < kInfinity)) return kNone;
    Index f = block * kBlock;
    while (key_[f] != least_[block]) ++f;
    return f;
  }

  void lay(Index f) {
    Facet& facet = facets_[f];
    const Vec3 a = place(facet, 0), u = place(facet, 1) - a, v = place(facet, 2) - a;
    const Vec3 normal = cross(u, v);
    const double squared = square(normal), whole = square(u) * square(v);
    constexpr double kSlimSine = 1.0 / 16;  // slimmer: the cross product loses four bits
    if (closer_ || !(squared > kSlimSine * kSlimSine * whole)) return lay_exactly(f);
    facet.normal = normal / std::sqrt(squared);
    facet.distance = dot(facet.normal, a);
    facet.error = kNormalRounding * kEpsilon * std::sqrt(whole / squared);
    facet.exact = false;
    order(f);
  }

  /// From exact differences of the corners.
  void lay_exactly(Index f) {
    Facet& facet = facets_[f];
    const Vec3 a = place(facet, 0), b = place(facet, 1), c = place(facet, 2);
    const WideVector normal = cross(wide_difference(b, a), wide_difference(c, a));
    const Vec3 rounded = normal.rounded();
    const double length = std::sqrt(square(rounded));
    const double whole = std::sqrt(square(b - a) * square(c - a));
    facet.exact = true;
    if (!(length > 1e-24 * whole)) {
      facet.normal = Vec3(0.0, 0.0, 0.0);  // a line: it has no plane and no side
      facet.error = 1.0;
      set_key(f, kInfinity);
      facet.distance = found_beside(f);
      if (facet.distance < kInfinity) spread(f);
      return;
    }
    facet.normal = rounded / length;
    facet.distance = double(dot(normal, wide(a))) / length;
    facet.error = kExactNormalRounding * kEpsilon + kWideVolumeRounding * whole / length;
    order(f);
  }

  /// Of the plane of a facet, less its rounding.
  double least_distance(Index f) const {
    const Facet& facet = facets_[f];
    return facet.exact ? facet.distance
                       : facet.distance - facet.error * std::sqrt(square(place(facet, 0)));
  }
  void order(Index f) { set_key(f, std::min(least_distance(f), found_beside(f))); }

  /// The least distance of the planes found beside a facet that make it worth a look; infinite:
  /// there is none.
  double found_beside(Index f) const {
    const Facet& facet = facets_[f];
    double least = kInfinity;
    for (Index i = 0; i < 3; ++i) {
      const Facet& beside = facets_[facet.across[i]];
      if (!beside.found || !(beside.distance < least)) continue;
      if (ends_near_foot(beside, place(facet, (i + 1) % 3), place(facet, i)))
        least = beside.distance;
    }
    return least;
  }

  /// Does a side of a facet come near the foot of the origin, or has it the foot on its other side?
  /// Planes that lean about any other side are worse, or lean by less than tells two directions.
  bool ends_near_foot(const Facet& facet, const Vec3& from, const Vec3& to) const {
    const Vec3 side = to - from;
    const double inside = -dot(cross(facet.normal, side), from);
    return !(inside > kFirm * kRounding * rounding_ * std::sqrt(square(side)));
  }

  /// Where a plane of the set is found, what lies beside it is looked at, too: what is laid there
  /// so far may be far away, and another plane as good be hidden below.
  void spread(Index f) {
    facets_[f].found = true;
    const Facet& facet = facets_[f];
    const double distance = facet.distance;
    for (Index i = 0; i < 3; ++i) {
      const Number g = facet.across[i];
      if (facets_[g].found) continue;
      if (!ends_near_foot(facet, place(facet, i), place(facet, (i + 1) % 3))) continue;
      if (square(facets_[g].normal) == 0.0) {  // a line
        facets_[g].distance = distance;
        spread(g);
      } else if (key_[g] < kInfinity && distance < key_[g]) {
        set_key(g, distance);
      }
    }
  }

  /// Does a point lie outside of a facet?
  bool sees(const Vec3& w, const Facet& facet) const {
    const Vec3 a = place(facet, 0), t = w - a;
    const double height = dot(facet.normal, t);
    const double bound = (facet.error + kHeightRounding * kEpsilon) * std::sqrt(square(t));
    if (std::abs(height) > bound) return height > 0.0;
    return volume(a, place(facet, 1), place(facet, 2), w) > 0.0;
  }

  // ---- growing ----

  enum class Growth { Grown, Torn, Full };

  /// Not those that cover no part of the octant, nor those of a plane of which a better facet is
  /// known.
  bool is_of_interest(Index f) const {
    const Facet& facet = facets_[f];
    if (octant_ < kWhole) {
      const Vec3 a = place(facet, 0), b = place(facet, 1), c = place(facet, 2);
      const auto beside = [](bool up, double x, double y, double z) {
        return up ? x < 0.0 && y < 0.0 && z < 0.0 : x > 0.0 && y > 0.0 && z > 0.0;
      };
      if (beside((octant_ & 1) != 0, a.x, b.x, c.x) || beside((octant_ & 2) != 0, a.y, b.y, c.y) ||
          beside((octant_ & 4) != 0, a.z, b.z, c.z))
        return false;
    }
    const SupportPlane* const known = broad_.find(facet.normal);
    const double least = least_distance(f);
    if (known == broad_.end() || least < best_ - kFlush * rounding_) return true;
    return least <= known->value.high + kKeyRounding * kEpsilon * std::abs(known->value.high);
  }

  /// One facet: grown over, or found to be one of the set. False: nothing is left to look at.
  bool step() {
    const Index f = least_facet();
    if (f == kNone || key_[f] > best_ + kLook * rounding_) return false;
    const Facet& facet = facets_[f];
    if (!is_of_interest(f)) {
      set_key(f, kInfinity);
      if (octant_ == kWhole && least_distance(f) <= best_ + kLook * rounding_) spread(f);
      return true;
    }
    const Corner corner = find_corner(facet.normal);
    const double gain = dot(facet.normal, corner.w - place(facet, 0));
    if (!facet.exact && !(gain > kClear * rounding_)) {
      lay_exactly(f);
      return true;
    }
    ++steps_;
    offer(facet.normal, facet.distance + std::max(gain, 0.0));
    const bool beyond = gain > kFlush * rounding_, outside = beyond && sees(corner.w, facet);
    if (outside) {
      const Growth growth = add(f, corner);
      if (growth == Growth::Grown) return true;
      left_ = std::min(left_, key_[f]);
      if (growth == Growth::Full) {
        full_ = true;
        return false;
      }
    }
    if (closer_ && add_farthest(f)) return true;
    if (full_) return false;
    set_key(f, kInfinity);
    if (facet.distance > best_ + kLook * rounding_) return true;
    spread(f);
    // A line all but exactly: its normal is not known.
    if (beyond && !outside && facet.error > 2.0 * kExactNormalRounding * kEpsilon) return true;
    const SupportPlane plane = exact_plane(facet);
    planes_.add(plane);
    if (!plane.slim) broad_.add(plane);
    return true;
  }

  /// A plane that leaves no corner beyond it: the solids overlap by no more than its distance.
  void offer(const Vec3& normal, double value) {
    if (!(value < best_)) return;
    best_ = value;
    best_normal_ = normal;
  }

  SupportPlane exact_plane(const Facet& facet) const {
    const Vec3 a = place(facet, 0), b = place(facet, 1), c = place(facet, 2);
    const WideVector normal = cross(wide_difference(b, a), wide_difference(c, a));
    const DoubleDouble length = square_root(dot(normal, normal));
    return {facet.normal, dot(normal, wide(a)) / length,
            !(length.high > kSlimHeight * rounding_ * longest_side(facet))};
  }

  /// Less the diagonal of a parallelogram: which of its two was drawn is of no account. m
  double longest_side(const Facet& facet) const {
    double along = 0.0, across = 0.0;
    int edges = 0;
    for (Index i = 0; i < 3; ++i) {
      const Corner &from = corners_[facet.corners[i]], &to = corners_[facet.corners[(i + 1) % 3]];
      const bool edge = from.p == to.p || from.q == to.q;
      edges += edge ? 1 : 0;
      double& most = edge ? along : across;
      most = std::max(most, square(to.w - from.w));
    }
    return std::sqrt(edges == 2 ? along : std::max(along, across));
  }

  /// Takes away the facets that a new corner sees; a cone over the border closes the hole.
  Growth add(Index first, const Corner& corner) {
    if (corner_count_ == kMostCorners) return Growth::Full;
    if (!find_border(first, corner.w)) return Growth::Torn;
    if (facet_count_ + border_count_ > kMostFacets + seen_count_ + free_count_) return Growth::Full;
    const Number apex = number(corner_count_);
    corners_[corner_count_++] = corner;
    for (Index k = 0; k < seen_count_; ++k) {
      set_key(seen_[k], kInfinity);
      free_[free_count_++] = seen_[k];
    }
    for (Index k = 0; k < border_count_; ++k) {
      const Side& side = border_[k];
      const Index f = take_slot();
      Facet& facet = facets_[f];
      facet.corners[0] = side.from;
      facet.corners[1] = side.to;
      facet.corners[2] = apex;
      facet.across[0] = side.outside;
      facet.seen = 0;
      facet.found = false;
      facet.normal = Vec3(1.0, 0.0, 0.0);  // no line, until it is laid
      side_of_[side.from] = number(f);
      Facet& outside = facets_[side.outside];
      for (Index i = 0; i < 3; ++i)
        if (outside.corners[i] == side.to) outside.across[i] = number(f);
    }
    for (Index k = 0; k < border_count_; ++k) {
      const Number f = side_of_[border_[k].from], next = side_of_[border_[k].to];
      facets_[f].across[1] = next;
      facets_[next].across[2] = f;
    }
    for (Index k = 0; k < border_count_; ++k) lay(side_of_[border_[k].from]);
    return Growth::Grown;
  }

  Index take_slot() {
    if (free_count_ > 0) return free_[--free_count_];
    open_slot();
    return facet_count_ - 1;
  }

  /// The facets around the first one that see a point, and the sides around them. False: they are
  /// not one loop, which rounding alone can do.
  bool find_border(Index first, const Vec3& w) {
    const std::uint32_t stamp = ++stamp_;
    seen_count_ = border_count_ = 0;
    seen_[seen_count_++] = number(first);
    facets_[first].seen = stamp;
    for (Index k = 0; k < seen_count_; ++k) {
      const Facet& facet = facets_[seen_[k]];
      for (Index i = 0; i < 3; ++i) {
        const Number g = facet.across[i];
        if (facets_[g].seen == stamp) continue;
        if (sees(w, facets_[g])) {
          facets_[g].seen = stamp;
          seen_[seen_count_++] = g;
          continue;
        }
        if (border_count_ == kMostCorners) return false;
        border_[border_count_++] = {facet.corners[i], facet.corners[(i + 1) % 3], g};
      }
    }
    return is_one_loop();
  }

  bool is_one_loop() {
    for (Index k = 0; k < border_count_; ++k) side_of_[border_[k].to] = number(kNone);
    for (Index k = 0; k < border_count_; ++k) {
      Number& side = side_of_[border_[k].from];
      if (side != kNone) return false;
      side = number(k);
    }
    if (border_count_ < 3) return false;
    Index length = 0, k = 0;
    do {
      k = side_of_[border_[k].to];
      ++length;
    } while (k != 0 && k != kNone && length <= border_count_);
    return k == 0 && length == border_count_;
  }

  // ---- the answer ----

  double wide_gap(const Vector3& normal) const {
    const WideVector direction = wide(normal);
    const int i = wide_support(p_, direction), j = wide_support(q_, -direction);
    return double(dot(direction, exact_corner(p_, q_, i, j)) /
                  square_root(dot(direction, direction)));
  }

  /// The least overlap, and up to where planes are as good. m
  struct Limits {
    const SupportPlane* best;  // null: none is known to be
    double least, tie;
    bool touching;
  };
  Limits limits() const {
    const SupportPlane* best = planes_.begin();
    for (const SupportPlane& plane : planes_) best = is_better(plane, *best) ? &plane : best;
    const bool known = best != planes_.end() && !(best_ < best->value.high - kSure * rounding_);
    const double least = known ? best->value.high : best_;
    const bool touching = std::abs(least) <= kTouch * rounding_;
    return {known ? best : nullptr, least,
            touching ? kBothTouch * rounding_ : least + kTie * rounding_, touching};
  }

  /// May a limit lie between a plane and where it would be if no corner lay beyond its facet? Of
  /// planes that are no ties a slim one may hide the best.
  bool is_doubtful() const {
    const auto near = [&](double value, double limit) {
      return std::abs(value - limit) <= kShort * rounding_;
    };
    const Limits is = limits();
    if (near(std::abs(is.least), kTouch * rounding_) || broad_.any_close(is.tie)) return true;
    int directions = 0;
    for (const SupportPlane& plane : broad_) {
      if (near(plane.value.high, is.tie)) return true;
      directions += plane.value.high <= is.tie ? 1 : 0;
    }
    return directions < 2 && std::any_of(planes_.begin(), planes_.end(), [&](const auto& plane) {
             return plane.slim && near(plane.value.high, is.least);
           });
  }

  void conclude(LeastOverlap& result) const {
    const Limits is = limits();
    result.normal = one_zero(-(is.best ? whose_direction_is_known(*is.best).normal : best_normal_));
    result.gap = wide_gap(result.normal);
    result.converged = is.least <= left_ + kSure * rounding_;
    result.directions = 0;
    result.middle = false;
    Vec3 sum(0.0, 0.0, 0.0);
    for (const SupportPlane& plane : broad_) {
      if (!(plane.value.high <= is.tie)) continue;
      ++result.directions;
      sum = sum + plane.normal;
    }
    if (result.directions > 1 && is.touching) take_middle(-sum, result);
  }

  /// A slim plane's direction is not known: a broad one that is as good stands for it.
  const SupportPlane& whose_direction_is_known(const SupportPlane& plane) const {
    if (!plane.slim) return plane;
    const SupportPlane* best = &plane;
    for (const SupportPlane& other : broad_) {
      const bool as_good = other.value.high <= plane.value.high + kTie * rounding_;
      if (as_good && (best->slim || is_better(other, *best))) best = &other;
    }
    return *best;
  }

  /// Nearer to the origin: the facet nearest of all has the foot of the origin within it. Of equal
  /// ones the first in the order of directions.
  bool is_better(const SupportPlane& m, const SupportPlane& n) const {
    constexpr double kEqual = 1e-9;
    const double more = double(m.value - n.value);
    return std::abs(more) > kEqual * rounding_ ? more < 0.0 : comes_before(m.normal, n.normal);
  }

  /// An order that hangs on the directions alone: x first, greatest first.
  static bool comes_before(const Vec3& m, const Vec3& n) {
    constexpr double kSame = 1e-9;
    if (std::abs(m.x - n.x) > kSame) return m.x < n.x;
    if (std::abs(m.y - n.y) > kSame) return m.y < n.y;
    return m.z < n.z;
  }

  /// Touching: the mean of the planes keeps the solids apart as well and shows the vertex or edge
  /// in which they meet.
  void take_middle(const Vec3& sum, LeastOverlap& result) const {
    const double length = std::sqrt(square(sum));
    if (!(length > 1e-3)) return;
    const Vector3 mean = one_zero(sum / length);
    const double gap = wide_gap(mean);
    if (!(std::abs(gap) <= kTouch * rounding_)) return;
    result.normal = mean;
    result.gap = gap;
    result.middle = true;
  }

  const Solid& p_;
  const Solid& q_;
  double rounding_;          // m
  double best_ = kInfinity;  // an overlap that is enough, m
  Vec3 best_normal_{1.0, 0.0, 0.0};
  double left_ = kInfinity;   // of planes beyond which the set reaches, but which could not grow, m
  bool closer_ = false;       // no corner is left beyond a facet
  bool full_ = false;         // there was no room for another corner
  unsigned octant_ = kWhole;  // only directions of this one are looked at; bits: x, y, z upwards
  int steps_ = 0;             // corners added and facets done with
  std::uint32_t stamp_ = 0;
  Index corner_count_ = 0, facet_count_ = 0, free_count_ = 0, seen_count_ = 0, border_count_ = 0;
  SupportPlanes planes_, broad_;  // all; those whose direction is known
  Corner corners_[kMostCorners];
  Facet facets_[kMostFacets];
  double key_[kMostFacets];  // a plane is at least so far; infinite: done with, or no facet
  double least_[kMostFacets / kBlock];
  Number free_[kMostFacets], seen_[kMostFacets];
  Number side_of_[kMostCorners];
  Side border_[kMostCorners];
};

}  // namespace

[[gnu::noinline]] LeastOverlap exact_overlap(const Solid& p, const Solid& q,
                                             const ActiveFeatures& start) {
  return Polytope(p, q).grow(start);
}

}  // namespace quoin::geometry
