#pragma once
/// certify_hints, as a kernel. See kernels/kernels.hpp. Every step is that of one pair alone, of
/// certificate_kernel.hpp and line_normal.hpp, operation by operation; conditions are those or
/// stricter. Internal.

#include "certify/canonical_order.hpp"
#include "certify/certificate_kernel.hpp"
#include "certify/certificate_lanes.hpp"
#include "shape/lane_frame.hpp"

namespace quoin::geometry {
namespace {

/// A number of each pair.
struct alignas(32) LaneRow {
  double of[HintedPairs::kPairs];
};

/// One bit a pair.
template <class Is>
unsigned lane_bits(const Is& is) {
  unsigned bits = 0;
  for (std::size_t k = 0; k < HintedPairs::kPairs; ++k) bits |= static_cast<unsigned>(is(k)) << k;
  return bits;
}

/// One body of each pair, as Solid; in its own frame where `own` says so of its pair.
template <class Lanes>
struct LaneSolid {
  using Vector = LaneVector<Lanes>;
  const std::array<const Body*, 4>& bodies;
  std::array<const int*, 4> hinted;  // vertices
  std::array<int, 4> faces;
  LaneFrame<Lanes> frame;
  std::array<const double*, 4> vertices;
  Vector base, origin;        // Shape::origin(), and where it lies from the middle of the pair
  Vector ends[2], places[2];  // of the vertices that carry the pair: in their shape's frame, placed
  Lanes diameter, coordinate;
  typename Lanes::Flags own;
  bool all_own;

  LaneSolid(const std::array<const Body*, 4>& of, unsigned in_own)
      : bodies(of),
        frame(lane_bits([&](std::size_t k) { return of[k]->is_turned(); }),
              columns([](const Body& body) { return body.placement().linear.data(); }),
              columns([](const Body& body) { return body.cofactors().data(); })),
        own(Lanes::flags(in_own)),
        all_own(in_own == 15) {
    for (std::size_t k = 0; k < 4; ++k) vertices[k] = shape(k).vertices().data();
    base = vector([](const Shape& shape) { return shape.origin().data(); });
    diameter = number([](const Body& body) { return body.stretch() * body.shape().diameter(); });
    coordinate = number([](const Body& body) { return body.shape().largest_coordinate(); });
  }
  const Shape& shape(std::size_t k) const { return bodies[k]->shape(); }
  template <class Of>
  Lanes number(const Of& of) const {
    return Lanes::of(of(*bodies[0]), of(*bodies[1]), of(*bodies[2]), of(*bodies[3]));
  }
  template <class Of>
  Vector vector(const Of& of) const {
    return Vector::of({of(shape(0)), of(shape(1)), of(shape(2)), of(shape(3))});
  }
  template <class Of>
  std::array<LanePlace, 3> columns(const Of& of) const {
    std::array<LanePlace, 3> columns;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < 4; ++k) columns[c][k] = of(*bodies[k]) + 3 * c;
    }
    return columns;
  }
  /// In the shapes' frames: number `index(k)` of lane k.
  template <class Index>
  Vector vertex(const Index& index) const {
    return Vector::of({vertices[0] + 3 * index(0), vertices[1] + 3 * index(1),
                       vertices[2] + 3 * index(2), vertices[3] + 3 * index(3)});
  }
  void place_ends(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      ends[i] = vertex([&](std::size_t k) { return hinted[k][i]; });
      places[i] = place(ends[i]);
    }
  }
  /// Of an edge, as Side.
  Vector line() const { return frame.turn(ends[1] - ends[0]); }
  void find_wide_line(LaneSum<Lanes> (&wide)[3]) const {
    using Sum = LaneSum<Lanes>;
    const Sum x = Sum::difference(ends[1].x, ends[0].x), y = Sum::difference(ends[1].y, ends[0].y),
              z = Sum::difference(ends[1].z, ends[0].z);
    wide[0] = x;
    wide[1] = y;
    wide[2] = z;
    if (!frame.any_turned) return;
    const auto turn = [&](const Lanes& a, const Lanes& b, const Lanes& c, Sum& to) {
      const Sum turned = x * a + y * b + z * c;
      to = {turned.high.where(frame.turned, to.high), turned.low.where(frame.turned, to.low)};
    };
    const Vector(&c)[3] = frame.columns;
    turn(c[0].x, c[1].x, c[2].x, wide[0]);
    turn(c[0].y, c[1].y, c[2].y, wide[1]);
    turn(c[0].z, c[1].z, c[2].z, wide[2]);
  }
  Vector place(const Vector& vertex) const {
    if (all_own) return vertex;
    return vertex.where(own, frame.turn(vertex - base) + origin);
  }
  Vector mean() const {
    return place(vector([](const Shape& shape) { return shape.vertex_mean().data(); }));
  }
  Vector face_normal() const {
    const auto normal = [&](std::size_t k) {
      return shape(k).face_normals().data() + 3 * faces[k];
    };
    return frame.normal(Vector::of({normal(0), normal(1), normal(2), normal(3)}));
  }
};

/// `Set`: the scans and lanes of an instruction set.
template <class Set, FeatureKind kA, FeatureKind kB>
class HintLanes {
 public:
  HintLanes(const HintedPairs& pairs, double tolerance)
      : in_(pairs),
        own_(lane_bits([&](std::size_t k) {
          return stands_in_own_frame(*pairs.a[k]) && stands_in_own_frame(*pairs.b[k]);
        })),
        a_(pairs.a, own_),
        b_(pairs.b, own_) {
    for (std::size_t k = 0; k < 4; ++k) {
      const FeatureHint& hint = pairs.answers[k]->hint;
      a_.hinted[k] = hint.vertices_a.data();
      b_.hinted[k] = hint.vertices_b.data();
      a_.faces[k] = hint.face_a;
      b_.faces[k] = hint.face_b;
    }
    find_lengths(tolerance);
    place_solids();
    a_.place_ends(kA == kFace ? 0 : kA == kEdge ? 2 : 1);
    b_.place_ends(kB == kFace ? 0 : kB == kEdge ? 2 : 1);
  }

  unsigned solve() {
    find_normal();
    const Lanes clear = all(kByFace ? 1.0 : 1.0 + kTurnedShare) * widest_;
    const Vector high = highest<kA>(a_, normal_, clear), low = highest<kB>(b_, -normal_, clear);
    if (good_.bits() == 0) return 0;
    gap_ = normal_.dot(low - high);
    lie_over(high, low);
    const unsigned found = good_.bits() & named();
    if (found != 0) write(found, high, low);
    return found;
  }

 private:
  using Lanes = typename Set::Lanes;
  using Vector = LaneVector<Lanes>;
  using Flags = typename Lanes::Flags;
  static constexpr bool kEdges = kA == kEdge && kB == kEdge, kByFace = kA == kFace || kB == kFace;

  static bool stands_in_own_frame(const Body& body) {  // as Body's, in plain numbers
    const double* t = body.placement().translation.data();
    return !body.is_turned() && t[0] == 0.0 && t[1] == 0.0 && t[2] == 0.0;
  }
  static Lanes all(double x) { return Lanes::all(x); }
  static Lanes square(const Vector& v) { return v.dot(v); }
  void need(const Flags& flags) { good_ = good_ & flags; }

  void find_lengths(double tolerance) {
    const Lanes smaller = b_.diameter.smaller(a_.diameter);
    const Lanes larger = a_.diameter.larger(b_.diameter);
    const Lanes coordinate = a_.coordinate.larger(b_.coordinate);
    contact_ = tolerance > 0.0 ? all(tolerance)
                               : (all(kDefaultTolerance) * smaller)
                                     .larger(all(kLeastTolerance * kEpsilon) * coordinate);
    rounding_ = all(kRounding * kEpsilon) * larger;
    const Lanes place = rounding_.larger(all(kPlaceRounding * kEpsilon) * coordinate);
    widest_ = contact_.larger(place).larger(all(kClearAbove) * rounding_);
    good_ = larger.below(all(kUneven) * smaller);
  }

  static LaneCentres centres(const std::array<const Body*, 4>& bodies) {
    LaneCentres centres;
    for (std::size_t k = 0; k < 4; ++k) {
      centres.translation[k] = bodies[k]->placement().translation.data();
      centres.turned[k] = bodies[k]->turned_origin().data();
      centres.rest[k] = bodies[k]->turned_origin_rest().data();
    }
    return centres;
  }
  /// As PlacedPair.
  void place_solids() {
    if (a_.all_own) return;
    const LaneCentres a = centres(in_.a), b = centres(in_.b);
    const Vector between = lanes_apart<Lanes>(a, b);
    a_.origin = between * all(-0.5);
    b_.origin = between * all(0.5);
    const auto half = [](const LaneCentres& c) {
      return (Vector::of(c.translation) + Vector::of(c.turned)) * all(0.5);
    };
    middle_ = half(a) + half(b);
  }

  void find_normal() {
    Vector normal;
    if constexpr (kByFace) {
      const LaneSolid<Lanes>& solid = kA == kFace ? a_ : b_;
      need(Lanes::flags(lane_bits([&](std::size_t k) { return solid.bodies[k]->is_rigid(); })));
      normal = kA == kFace ? solid.face_normal() : -solid.face_normal();
    } else if constexpr (kEdges) {
      normal = normal_of_edges();
    } else if constexpr (kA == kEdge) {
      normal = -normal_of_edge(b_, a_);
    } else if constexpr (kB == kEdge) {
      normal = normal_of_edge(a_, b_);
    } else {
      normal = unit(b_.places[0] - a_.places[0]);
    }
    const Lanes zero = all(0.0);
    normal_ = normal + Vector{zero, zero, zero};
  }
  /// As line_normal.
  Vector unit(const Vector& line) {
    const Lanes length = square(line).root();
    need(all(0.0).below(length));
    return line / length;
  }
  static Lanes from_ends(const Lanes& share, const Lanes& squared_length) {
    const Lanes least = all(0.0).larger(share.smaller(all(1.0) - share));
    return least * least * squared_length;
  }
  /// As vertex_edge, the foot between the ends.
  Vector normal_of_edge(const LaneSolid<Lanes>& vertex, const LaneSolid<Lanes>& edge) {
    const Vector w = edge.places[0] - vertex.places[0], line = edge.line();
    const Lanes squared = square(line), share = negated(w.dot(line)) / squared;
    need(all(0.0).below(share) & share.below(all(1.0)));
    from_ends_ = from_ends(share, squared);
    const Vector direct = w + line * share;
    const Flags kept = (all(kCancelled * kCancelled) * square(w)).below(square(direct));
    if (good_.without(kept).bits() == 0) return unit(direct);
    return unit(direct.where(kept, across(vertex, edge, negated(share))));
  }
  /// As across, of the way from a vertex to an edge.
  static Vector across(const LaneSolid<Lanes>& vertex, const LaneSolid<Lanes>& edge,
                       const Lanes& share) {
    LaneSum<Lanes> e[3];
    edge.find_wide_line(e);
    const auto rest = [&](const Lanes& to, const Lanes& from, const LaneSum<Lanes>& along) {
      const LaneSum<Lanes> way = LaneSum<Lanes>::difference(to, from);
      const LaneSum<Lanes> product = LaneSum<Lanes>::product(share, along.high);
      const LaneSum<Lanes> high = LaneSum<Lanes>::difference(way.high, product.high);
      return high.high + (high.low + (way.low - product.low - share * along.low));
    };
    const Vector &to = edge.places[0], &from = vertex.places[0];
    const Vector v{rest(to.x, from.x, e[0]), rest(to.y, from.y, e[1]), rest(to.z, from.z, e[2])};
    const Vector line{e[0].high, e[1].high, e[2].high};
    return v - line * (v.dot(line) / square(line));
  }
  /// As edge_edge, crossed ones.
  Vector normal_of_edges() {
    const Vector e = a_.line(), f = b_.line(), w = b_.places[0] - a_.places[0];
    const Vector normal = e.cross(f);
    const Lanes squared_a = square(e), squared_b = square(f), squared = square(normal);
    longer_ = squared_a.larger(squared_b);
    need((all(kCancelled * kCancelled) * squared_a * squared_b).below(squared));
    need((rounding_ * rounding_ * longer_).below(squared));
    share_a_ = w.cross(f).dot(normal) / squared;
    share_b_ = w.cross(e).dot(normal) / squared;
    for (const Lanes& share : {share_a_, share_b_}) {
      need(all(0.0).below(share) & share.below(all(1.0)));
    }
    from_ends_ =
        from_ends(share_a_, squared / squared_b).smaller(from_ends(share_b_, squared / squared_a));
    skew_ = squared;
    on_a_ = a_.places[0] + e * share_a_;
    on_b_ = b_.places[0] + f * share_b_;
    const Vector out = unit(normal);
    const Lanes along = out.dot(b_.mean() - a_.mean()), zero = all(0.0);
    need(zero.below(along.size()));
    return (-out).where(along.below(zero), out);
  }

  /// As carry_alone, and where the highest of the vertices lies.
  template <FeatureKind kKind>
  Vector highest(const LaneSolid<Lanes>& solid, const Vector& outward, const Lanes& clear) {
    const Vector local = solid.frame.turned_back(outward);
    const auto value = [&](const Vector& vertex) { return (vertex - solid.base).dot(local); };
    Vector top;
    Lanes most, least;
    if constexpr (kKind == kFace) {
      highest_of_faces(solid, value, top, most, least);
    } else {
      top = solid.places[0];
      most = least = value(solid.ends[0]);
    }
    if constexpr (kKind == kEdge) {
      const Lanes last = value(solid.ends[1]);
      top = solid.places[1].where(most.below(last), top);
      least = last.smaller(most);
      most = last.larger(most);
    }
    if (kKind != kVertex) need((most - least).below(all(kClearBelow) * rounding_));
    need(Lanes::flags(alone<kKind>(solid, local, most - clear)));
    return top;
  }
  template <class Value>
  static void highest_of_faces(const LaneSolid<Lanes>& solid, const Value& value, Vector& top,
                               Lanes& most, Lanes& least) {
    std::array<std::span<const int>, 4> sets;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      sets[k] = solid.shape(k).topology().face_set(solid.faces[k]);
      count = std::max(count, sets[k].size());
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Vector vertex =
          solid.vertex([&](std::size_t k) { return sets[k][i < sets[k].size() ? i : 0]; });
      const Lanes height = value(vertex);
      top = i == 0 ? vertex : vertex.where(most.below(height), top);
      most = i == 0 ? height : height.larger(most);
      least = i == 0 ? height : height.smaller(least);
    }
    top = solid.place(top);
  }
  /// Do only the vertices of the carriers reach so far?
  template <FeatureKind kKind>
  static unsigned alone(const LaneSolid<Lanes>& solid, const Vector& local, const Lanes& limit) {
    LaneRow directions[3], limits;
    local.store(directions);
    limit.store(limits.of);
    unsigned bits = 0;
#pragma GCC unroll 1  // the kernels of all kinds should fit into the cache
    for (std::size_t k = 0; k < HintedPairs::kPairs; ++k) {
      const Solid scanned(solid.shape(k));
      const Rows rows(scanned);
      const Vec3 d(directions[0].of[k], directions[1].of[k], directions[2].of[k]);
      const int count = few_vertices(scanned, scanned)
                            ? Set::FewScan::count_beyond(rows, d, limits.of[k])
                            : Set::ManyScan::count_beyond(rows, d, limits.of[k]);
      const int carriers =
          kKind == kVertex ? 1
          : kKind == kEdge ? 2
                           : static_cast<int>(scanned.topology().face_set(solid.faces[k]).size());
      bits |= static_cast<unsigned>(count == carriers) << k;
    }
    return bits;
  }

  /// The features lie over each other, by as much as proves the plane.
  void lie_over(const Vector& high, const Vector& low) {
    const Flags apart = (all(kApart) * rounding_).below(gap_);
    Lanes inside = all(kByFace ? kFirm : 1.0) * rounding_;
    if constexpr (!kByFace && !kEdges) {
      need(apart);
    } else if (good_.without(apart).bits() != 0) {
      inside = inside.where(apart, (all(kFirm) * rounding_).larger(shallow_margin()));
    }
    if constexpr (kA == kFace) {
      over_face(a_, normal_, low, inside);
    } else if constexpr (kB == kFace) {
      over_face(b_, -normal_, high, inside);
    } else {
      if (kA == kEdge || kB == kEdge) need((inside * inside).below(from_ends_));
      const Lanes turned = rounding_ * (rounding_ / all(kRounding * kEpsilon));
      const Lanes lever = kEdges ? gap_.larger((skew_ / longer_).root()) : gap_;
      need(turned.below(lever * (all(kTurnedShare) * widest_)) | good_.without(apart));
    }
  }
  /// Of the overlaps; NaN: none is enough.
  Lanes shallow_margin() {
    const Vector inner = b_.mean() - a_.mean();
    const Lanes depth = negated(gap_) * all(1.0 + kAloneShare) + all(kAlone) * rounding_;
    const Lanes down = inner.dot(normal_), below = down - depth;
    const Lanes aside = square(inner - normal_ * down);
    const Lanes margin = depth * (aside.root() + (aside + below * (down + depth)).root()) / below;
    return margin.where(all(0.0).below(below), all(kInfinity));
  }
  /// As over_face, and clearly_wide.
  void over_face(const LaneSolid<Lanes>& solid, const Vector& outward, const Vector& point,
                 const Lanes& margin) {
    std::array<std::span<const int>, 4> cycles;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      cycles[k] = solid.shape(k).topology().face(solid.faces[k]);
      count = std::max(count, cycles[k].size());
    }
    const auto corner = [&](std::size_t i) {
      return solid.place(solid.vertex([&](std::size_t k) {
        return cycles[k][i < cycles[k].size() ? i : cycles[k].size() - 1];
      }));
    };
    const Lanes clear = all(0.0).larger(margin * solid.diameter), twice = margin * margin.size();
    Vector first = corner(0), from = first, second = first, normal;
    for (std::size_t i = 1; i <= count; ++i) {
      const Vector to = i < count ? corner(i) : first, side = to - from;
      const Lanes inside = outward.dot(side.cross(point - from));
      // Behind the last corner of a face of fewer it stands again.
      const Flags none = i < 3 ? Lanes::flags(0) : Lanes::flags(lane_bits([&](std::size_t k) {
        return i < count && i >= cycles[k].size();
      }));
      need(clear.below(inside) | (twice * square(side)).below(inside * inside.size()) | none);
      if (i == 1) second = to;
      if (i == 2) normal = (second - first).cross(to - first);
      from = to;
    }
    const Lanes least = all(4.0) * contact_ * solid.diameter;
    need((least * least).below(square(normal)));
  }

  /// Edges by their numbers.
  unsigned named() {
    const auto find = [&](const LaneSolid<Lanes>& solid, std::array<int, 4>& edges) {
      return lane_bits([&](std::size_t k) {
        edges[k] = solid.shape(k).topology().find_edge(solid.hinted[k][0], solid.hinted[k][1]);
        return edges[k] >= 0;
      });
    };
    unsigned found = 15;
    if constexpr (kA == kEdge) found &= find(a_, edges_a_);
    if constexpr (kB == kEdge) found &= find(b_, edges_b_);
    return found;
  }

  void find_witnesses(const Vector& high, const Vector& low, Vector& on_a, Vector& on_b) {
    const Vector across = normal_ * gap_;
    on_a = kA == kVertex ? high : low - across;
    on_b = kB == kVertex ? low : high + across;
    if constexpr (kEdges) {
      const Flags by_b = Lanes::flags(lane_bits([&](std::size_t k) {
        if ((own_ >> k & 1) != 0) {
          return in_reverse_order(Solid(in_.a[k]->shape()), Solid(in_.b[k]->shape()));
        }
        return in_reverse_order(Solid(*in_.a[k], Vector3::Zero()),
                                Solid(*in_.b[k], Vector3::Zero()));
      }));
      on_a = (on_b_ - across).where(by_b, on_a_);
      on_b = on_b_.where(by_b, on_a_ + across);
    }
  }
  void write(unsigned found, const Vector& high, const Vector& low) {
    Vector on_a, on_b;
    find_witnesses(high, low, on_a, on_b);
    struct {
      LaneRow gap, contact, normal[3], a[3], b[3], residual_a, residual_b;
    } rows;
    const auto residual = [&](const Vector& beyond) {
      return normal_.dot(beyond).larger(all(0.0));
    };
    gap_.store(rows.gap.of);
    contact_.store(rows.contact.of);
    normal_.store(rows.normal);
    residual(high - on_a).store(rows.residual_a.of);
    residual(on_b - low).store(rows.residual_b.of);
    if (!a_.all_own) {
      on_a = on_a.where(a_.own, on_a + middle_);
      on_b = on_b.where(a_.own, on_b + middle_);
    }
    on_a.store(rows.a);
    on_b.store(rows.b);
    const unsigned open = kEdges    ? ~(contact_ * contact_ * longer_).below(skew_).bits()
                          : kByFace ? 0u
                                    : 15u;
#pragma GCC unroll 1
    for (std::size_t k = 0; k < 4; ++k) {
      if ((found >> k & 1) == 0) continue;
      const auto at = [k](const LaneRow(&row)[3]) {
        return Vector3(row[0].of[k], row[1].of[k], row[2].of[k]);
      };
      NearestFeatures& answer = *in_.answers[k];
      answer.status = status_of(rows.gap.of[k], rows.contact.of[k]);
      answer.gap = rows.gap.of[k] + 0.0;
      answer.normal = at(rows.normal);
      answer.point_a = at(rows.a);
      answer.point_b = at(rows.b);
      answer.residual_a = kA == kVertex ? 0.0 : rows.residual_a.of[k];
      answer.residual_b = kB == kVertex ? 0.0 : rows.residual_b.of[k];
      answer.iterations = 1;
      answer.indeterminate = (open >> k & 1) != 0;
      answer.rule = answer.indeterminate ? PlaneRule::ShortestLine : PlaneRule::Unique;
      FeatureHint& hint = answer.hint;
      answer.feature_a = name<kA>(a_, k, edges_a_[k], hint.vertices_a, hint.face_a);
      answer.feature_b = name<kB>(b_, k, edges_b_[k], hint.vertices_b, hint.face_b);
      answer.hint.normal = answer.normal;
    }
  }
  template <FeatureKind kKind>
  static Feature name(const LaneSolid<Lanes>& solid, std::size_t k, int edge,
                      std::array<int, 4>& hinted, int& face) {
    const Carrier by{kKind, {hinted[0], hinted[1]}, solid.faces[k]};
    hinted = {-1, -1, -1, -1};
    face = -1;
    set_hinted<kKind>(Solid(solid.shape(k)), by, hinted, face);
    return {kKind, kKind == kVertex ? by.vertices[0] : kKind == kEdge ? edge : by.face};
  }

  const HintedPairs& in_;
  const unsigned own_;
  LaneSolid<Lanes> a_, b_;
  Flags good_;
  Lanes contact_, rounding_, widest_, gap_;  // m
  Vector middle_, normal_;
  Lanes from_ends_, longer_, skew_, share_a_, share_b_;  // of edges
  Vector on_a_, on_b_;
  std::array<int, 4> edges_a_, edges_b_;
};

template <class Set, FeatureKind kA, FeatureKind kB>
unsigned try_kinds(const HintedPairs& pairs, double tolerance) {
  return HintLanes<Set, kA, kB>(pairs, tolerance).solve();
}

template <class Set>
unsigned try_hints(const HintedPairs& pairs, double tolerance) {
  constexpr unsigned (*kTry[3][3])(const HintedPairs&, double) = {
      {try_kinds<Set, kVertex, kVertex>, try_kinds<Set, kVertex, kEdge>,
       try_kinds<Set, kVertex, kFace>},
      {try_kinds<Set, kEdge, kVertex>, try_kinds<Set, kEdge, kEdge>, nullptr},
      {try_kinds<Set, kFace, kVertex>, nullptr, nullptr}};
  const auto by = kTry[static_cast<int>(pairs.kind_a)][static_cast<int>(pairs.kind_b)];
  return by == nullptr ? 0 : by(pairs, tolerance);
}

}  // namespace
}  // namespace quoin::geometry
