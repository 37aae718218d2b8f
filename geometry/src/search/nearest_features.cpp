#include <quoin/geometry/nearest_features.hpp>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "certify/canonical_order.hpp"
#include "certify/certificate.hpp"
#include "certify/feature_normal.hpp"
#include "certify/line_normal.hpp"
#include "contact/projected_feature.hpp"
#include "search/box_sat.hpp"
#include "search/corner_features.hpp"
#include "search/epa.hpp"
#include "search/exact_search.hpp"
#include "search/face_face.hpp"
#include "search/nearest_feature_search.hpp"
#include "search/prefetch.hpp"

namespace quoin::geometry {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// The vertices of one solid near its support plane, and how deep below it each lies.
struct NearVertices {
  VertexSet vertices;
  SmallVector<double, 32> depths;

  void find(const Polyhedron& polyhedron, const Vector3& direction, const Support& top,
            double widest) {
    find_vertices_beyond(polyhedron, direction, top.value - widest, vertices);
    depths.clear();
    if (vertices.size() == 1) {
      depths.push_back(0.0);
      return;
    }
    for (const int v : vertices) {
      depths.push_back(top.value - along(offset(polyhedron, v), direction));
    }
  }
  void select(double length, VertexSet& set) const {
    set.clear();
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      if (depths[k] <= length) set.push_back(vertices[k]);
    }
  }
  bool clear(double rounding) const {
    return std::none_of(depths.begin(), depths.end(), [rounding](double depth) {
      return depth > kClearBelow * rounding && depth <= kClearAbove * rounding;
    });
  }
};

/// A plane between the solids: its normal, how far each reaches, what carries it.
struct Carried {
  Vector3 normal = Vector3::UnitX();
  Support support_p, support_q;
  double gap = 0.0;    // m
  ContactSets sets;    // within rounding
  FeatureNormal form;  // of these sets
};

/// The same with all vertices that come near it, where they were looked for.
struct Plane : Carried {
  LateInit<NearVertices> near_p, near_q;
};

void scan(const Polyhedron& p, const Polyhedron& q, const Vector3& normal, Plane& plane) {
  plane.normal = normal;
  const PairSupport both = support_pair(p, q, normal);
  plane.support_p = both.p;
  plane.support_q = both.q;
  plane.gap = normal.dot(q.vertex(both.q.vertex) - p.vertex(both.p.vertex));
}

void find_sets(const Polyhedron& p, const Polyhedron& q, const Lengths& length, Plane& plane) {
  plane.near_p.emplace().find(p, plane.normal, plane.support_p, length.widest);
  plane.near_q.emplace().find(q, -plane.normal, plane.support_q, length.widest);
  plane.near_p->select(length.rounding, plane.sets.p);
  plane.near_q->select(length.rounding, plane.sets.q);
  plane.sets.face_p = covered_face(p, plane.sets.p, plane.normal);
  plane.sets.face_q = covered_face(q, plane.sets.q, -plane.normal);
}

/// Takes the closed form of some sets for the plane; true when the same sets carry it, so that
/// another way to them comes to the same bits. Otherwise once more with the sets that do carry it.
bool settle(const Polyhedron& p, const Polyhedron& q, const Lengths& length,
            const ContactSets& proposed, const Vector3& guess, Plane& plane) {
  plane.form = feature_normal(p, q, proposed, guess, length.rounding);
  if (!plane.form.found) return false;
  scan(p, q, plane.form.normal, plane);
  find_sets(p, q, length, plane);
  if (plane.sets == proposed) return true;
  const FeatureNormal form = feature_normal(p, q, plane.sets, plane.normal, length.rounding);
  if (!form.found) return false;
  plane.form = form;
  if (form.normal == plane.normal) return true;
  ContactSets before;
  before.p = plane.sets.p;
  before.q = plane.sets.q;
  scan(p, q, form.normal, plane);
  find_sets(p, q, length, plane);
  return plane.sets == before;
}

/// The same from a normal alone.
bool settle_normal(const Polyhedron& p, const Polyhedron& q, const Lengths& length,
                   const Vector3& normal, Plane& plane) {
  scan(p, q, normal, plane);
  find_sets(p, q, length, plane);
  ContactSets proposed;
  proposed.p = plane.sets.p;
  proposed.q = plane.sets.q;
  proposed.face_p = plane.sets.face_p;
  proposed.face_q = plane.sets.face_q;
  return settle(p, q, length, proposed, normal, plane);
}

/// What is known in the end.
struct Optimum {
  Plane plane;
  bool several = false, middle = false;
  bool converged = false;
  bool straight = false;  // just the sets lie near the plane: `near_p`, `near_q` are not filled
  int iterations = 0;
  LateInit<ContactPolygon>& faces;  // where both features of a straight answer are whole faces
  explicit Optimum(LateInit<ContactPolygon>& shared) : faces(shared) {}
  const ContactPolygon* laid() const { return faces.get(); }
};

/// Lays the hull of a set into the plane; straight by its face label where that is known.
void lay_set(const Polyhedron& solid, const VertexSet& set, int face, const ContactPlane& plane,
             double outward, double length, ProjectedFeature& patch) {
  if (face >= 0 && solid.topology().face_set(face).size() == set.size()) {
    lay_feature(solid, {FeatureKind::Face, face}, plane, outward, patch);
  } else {
    lay_support_set(solid, set, span_kind(solid, set, length), plane, outward, patch);
  }
}

/// The two contact features laid into the contact plane.
struct ProjectedPair {
  ContactPlane plane;
  ProjectedFeature p, q;
  ProjectedPair(const Polyhedron& solid_p, const Polyhedron& solid_q, const Carried& contact,
                const VertexSet& set_p, const VertexSet& set_q, double length)
      : plane(solid_p.vertex(contact.support_p.vertex), contact.normal) {
    lay_set(solid_p, set_p, contact.sets.face_p, plane, 1.0, length, p);
    lay_set(solid_q, set_q, contact.sets.face_q, plane, -1.0, length, q);
  }
};

/// `faces`: the features as laid already, or null.
double margin_of(const Polyhedron& p, const Polyhedron& q, const Carried& plane,
                 const ContactPolygon* faces, double rounding) {
  if (faces != nullptr) return faces->margin;
  const ProjectedPair patches(p, q, plane, plane.sets.p, plane.sets.q, rounding);
  return overlap_margin(patches.p, patches.q);
}

bool is_whole(const Polyhedron& solid, int face, const VertexSet& set) {
  return face >= 0 && solid.topology().face_set(face).size() == set.size();
}

/// Lays two whole faces, if that is what the sets are; false: they are not, or have too many
/// corners.
bool lay_whole_faces(const Polyhedron& p, const Polyhedron& q, const Carried& plane,
                     const VertexSet& set_p, const VertexSet& set_q, ContactPolygon& part) {
  part.face_p = plane.sets.face_p;
  part.face_q = plane.sets.face_q;
  if (!is_whole(p, part.face_p, set_p) || !is_whole(q, part.face_q, set_q)) return false;
  part.plane = ContactPlane(p.vertex(plane.support_p.vertex), plane.normal);
  return lay_faces(p, q, plane.gap, part);
}

/// Do the features that carry the plane lie over each other? Then the plane is a facet of the
/// Minkowski difference into which the origin projects (or the line between the features is
/// shortest).
bool lies_over(const Polyhedron& p, const Polyhedron& q, const Carried& plane,
               const ContactPolygon* faces, double rounding) {
  const ContactSets& sets = plane.sets;
  if (plane.form.joined) return true;
  if (sets.p.size() == 1 && sets.face_q >= 0) {
    return over_face(q, sets.face_q, -Vec3(plane.normal), place(p, sets.p[0]), rounding);
  }
  if (sets.q.size() == 1 && sets.face_p >= 0) {
    return over_face(p, sets.face_p, plane.normal, place(q, sets.q[0]), rounding);
  }
  return margin_of(p, q, plane, faces, rounding) >= -rounding;
}

/// Proves that no other plane is better: always so when the solids are apart and the features lie
/// over each other, and for a shallow overlap.
bool proves_optimum(const Polyhedron& p, const Polyhedron& q, const Carried& plane,
                    const ContactPolygon* faces, double rounding) {
  if (clearly_apart(plane.gap, rounding)) return lies_over(p, q, plane, faces, rounding);
  const auto margin = [&] { return margin_of(p, q, plane, faces, rounding); };
  return proves_shallow(p, q, plane.normal, plane.gap, rounding, margin);
}

/// The plane of the proposed sets, when they carry it alone and no vertex lies between 0.5 and 64
/// roundings below it: nothing is left to doubt but whether it is the best.
bool straight_plane(const Polyhedron& p, const Polyhedron& q, const Lengths& length,
                    const Vector3& guess, Optimum& optimum) {
  Plane& plane = optimum.plane;
  optimum.faces.reset();
  plane.form = feature_normal(p, q, plane.sets, guess, length.rounding);
  if (!plane.form.found) return false;
  plane.normal = plane.form.normal;
  const auto alone = [&](double clear) {
    const double flat = kClearBelow * length.rounding;
    return carried_alone(p, plane.normal, {plane.sets.p, flat, clear}, plane.support_p) &&
           carried_alone(q, -plane.normal, {plane.sets.q, flat, clear}, plane.support_q);
  };
  const bool two_faces = plane.sets.face_p >= 0 && plane.sets.face_q >= 0;
  const double far_below = two_faces ? kFarBelow * std::min(p.diameter(), q.diameter()) : 0.0;
  const bool clearly = far_below > length.widest && alone(far_below);
  if (!clearly && !alone(length.widest)) return false;
  plane.gap = plane.normal.dot(q.vertex(plane.support_q.vertex) - p.vertex(plane.support_p.vertex));
  if (lay_whole_faces(p, q, plane, plane.sets.p, plane.sets.q, optimum.faces.emplace())) {
    optimum.faces->clear = clearly ? far_below : length.widest;
  } else {
    optimum.faces.reset();
  }
  return true;
}

/// Ascending, each once.
void insert_sorted(int v, VertexSet& set) {
  std::size_t k = set.size();
  while (k > 0 && set[k - 1] > v) --k;
  if (k > 0 && set[k - 1] == v) return;
  set.push_back(v);
  for (std::size_t i = set.size() - 1; i > k; --i) set[i] = set[i - 1];
  set[k] = v;
}

/// The vertices of a hint and those of the face that it names: in order when the hint is our own.
bool add_hinted(const std::array<int, 4>& vertices, int face, const Polyhedron& polyhedron,
                VertexSet& set, int& known_face) {
  const int count = polyhedron.vertex_count();
  known_face = face >= 0 && face < polyhedron.topology().face_count() ? face : -1;
  if (known_face >= 0) set.assign(polyhedron.topology().face_set(known_face));
  for (std::size_t k = 0; k < 4; ++k) {
    const int v = vertices[k];
    const bool known = k < set.size() && set[k] == v;
    if (!known && v >= 0 && v < count) insert_sorted(v, set);
  }
  return vertices[0] >= 0 && vertices[0] < count;
}

/// The plane of the proposed sets, if it is clearly theirs and proved to be the answer.
bool straight_answer(const Polyhedron& p, const Polyhedron& q, const Lengths& length,
                     const Vector3& guess, Optimum& optimum) {
  ++optimum.iterations;
  optimum.straight = straight_plane(p, q, length, guess, optimum) &&
                     proves_optimum(p, q, optimum.plane, optimum.laid(), length.rounding);
  if (!optimum.straight) optimum.faces.reset();
  return optimum.converged = optimum.straight;
}

/// Last step's features first: if they carry the optimum still, and clearly, that is the answer.
bool hinted_plane(const Polyhedron& p, const Polyhedron& q, const FeatureHint& hint,
                  const Lengths& length, Optimum& optimum) {
  ContactSets& sets = optimum.plane.sets;
  if (!add_hinted(hint.vertices_a, hint.face_a, p, sets.p, sets.face_p) ||
      !add_hinted(hint.vertices_b, hint.face_b, q, sets.q, sets.face_q)) {
    return false;
  }
  return straight_answer(p, q, length, hint.normal, optimum);
}

/// The face of `solid` above whose plane `point` lies highest (or least deep), and by how much.
std::pair<int, double> face_below(const Polyhedron& solid, const Vector3& point) {
  std::pair<int, double> best{0, -std::numeric_limits<double>::infinity()};
  for (int f = 0; f < solid.topology().face_count(); ++f) {
    const double height =
        solid.face_normal(f).dot(point - solid.vertex(solid.topology().face(f)[0]));
    if (height > best.second) best = {f, height};
  }
  return best;
}

/// The better of the two faces that look most at the other solid: where to start.
Vector3 facing_normal(const Polyhedron& p, const Polyhedron& q) {
  const auto [f, above_p] = face_below(p, q.vertex_mean());
  const auto [g, above_q] = face_below(q, p.vertex_mean());
  const Vector3 by_p = p.face_normal(f), by_q = -q.face_normal(g);
  Plane plane_p, plane_q;
  scan(p, q, by_p, plane_p);
  scan(p, q, by_q, plane_q);
  return plane_p.gap >= plane_q.gap ? by_p : by_q;
}

/// Have both solids more than one vertex near the plane? Then it is worth a try as the answer.
bool lies_flat(const Polyhedron& p, const Polyhedron& q, const Vector3& normal) {
  constexpr double kFlat = 1e-6;  // of the diameter; only speed hangs on it
  const PairSupport both = support_pair(p, q, normal);
  VertexSet near;
  find_vertices_beyond(p, normal, both.p.value - kFlat * p.diameter(), near);
  if (near.size() < 2) return false;
  find_vertices_beyond(q, -normal, both.q.value - kFlat * q.diameter(), near);
  return near.size() >= 2;
}

/// Blocks that lie flat on each other: the plane of their faces, if it is proved to be the answer.
bool flat_answer(const Polyhedron& p, const Polyhedron& q, const Lengths& length,
                 const Vector3& normal, Optimum& optimum) {
  scan(p, q, normal, optimum.plane);
  find_sets(p, q, length, optimum.plane);
  if (straight_answer(p, q, length, normal, optimum)) return true;
  optimum.converged = settle_normal(p, q, length, normal, optimum.plane) &&
                      proves_optimum(p, q, optimum.plane, nullptr, length.rounding);
  return optimum.converged;
}

/// By how much the gap of a settled plane may miss the bound that the search proved, m.
double slack(double rounding, double gap) { return rounding + 8 * kEpsilon * std::abs(gap); }

/// The corners where the search ended; a face label that has all those of one solid stands for
/// them.
void take_corners(const Polyhedron& p, const Polyhedron& q, const SearchResult& found,
                  ContactSets& sets) {
  sets.p.clear();
  sets.q.clear();
  for (int k = 0; k < found.corners; ++k) {
    insert_sorted(found.p[static_cast<std::size_t>(k)], sets.p);
    insert_sorted(found.q[static_cast<std::size_t>(k)], sets.q);
  }
  sets.face_p = common_face(p.topology(), sets.p);
  sets.face_q = common_face(q.topology(), sets.q);
  const auto complete = [](const Polyhedron& polyhedron, int face, VertexSet& set) {
    if (face >= 0) set.assign(polyhedron.topology().face_set(face));
  };
  complete(p, sets.face_p, sets.p);
  complete(q, sets.face_q, sets.q);
}

/// The plane that the last corners of the search define: for short distances the search's own line
/// between vertices and edges has lost the digits that tell which vertices carry it.
bool settle_corners(const Polyhedron& p, const Polyhedron& q, const SearchResult& found,
                    const Lengths& length, Plane& plane) {
  ContactSets sets;
  take_corners(p, q, found, sets);
  return settle(p, q, length, sets, found.normal, plane) ||
         settle_normal(p, q, length, found.normal, plane);
}

/// A pair in the order in which it is worked.
struct OrderedPair {
  const Polyhedron& p;
  const Polyhedron& q;
  bool reversed;  // q is the caller's A
  Lengths length;
  const Polyhedron& a() const { return reversed ? q : p; }
  const Polyhedron& b() const { return reversed ? p : q; }
};

OrderedPair ordered(const Polyhedron& a, const Polyhedron& b, const Lengths& length) {
  const bool reversed = in_reverse_order(a, b);
  return {reversed ? b : a, reversed ? a : b, reversed, length};
}

void swap_names(SearchResult& found) {
  found.normal = -found.normal;
  std::swap(found.p, found.q);
}

void swap_names(FeatureHint& hint) {
  hint.normal = one_zero(-Vec3(hint.normal));
  std::swap(hint.vertices_a, hint.vertices_b);
  std::swap(hint.face_a, hint.face_b);
}

void swap_names(NearestFeatures& answer) {
  answer.normal = one_zero(-Vec3(answer.normal));
  std::swap(answer.point_a, answer.point_b);
  std::swap(answer.feature_a, answer.feature_b);
  std::swap(answer.residual_a, answer.residual_b);
  swap_names(answer.hint);
}

/// The quick ways, and what is known when they have not come to the answer. For solids apart they
/// work in the order of the caller: turned round, each of their steps is the same but for signs.
struct Quick {
  Trial hint = Trial::Undecided;  // what became of last step's features
  bool searched = false;
  SearchResult found = {};           // if `searched`: in the order in which the pair is worked
  std::optional<Vector3> flat = {};  // across which solids that overlap lie flat on each other
  bool grown = false;                // `found` is the least overlap
  int iterations = 0;
};

/// Last step's features as an ordinary answer.
bool hinted_answer(const Polyhedron& a, const Polyhedron& b, const Lengths& length,
                   const FeatureHint& hint, Trial& trial, NearestFeatures& answer) {
  if (hint.vertices_a[0] < 0) return false;
  trial = certify_hint(a, b, hint, length, answer);
  answer.iterations = trial == Trial::Undecided ? 0 : 1;
  return trial == Trial::Proved;
}

/// The features that three corners each span as an ordinary answer.
bool found_answer(const Polyhedron& a, const Polyhedron& b, const Lengths& length,
                  std::span<const int> by_corners_a, std::span<const int> by_corners_b,
                  const Overlap* overlap, NearestFeatures& answer) {
  Carrier by_a, by_b;
  return corner_carrier(a, by_corners_a, by_a) && corner_carrier(b, by_corners_b, by_b) &&
         certify(a, b, by_a, by_b, length, overlap, answer) == Trial::Proved;
}

/// The least gap that the search allows a plane to have, m.
double least_gap(const SearchResult& found, double rounding) {
  const bool overlapping = found.outcome == SearchOutcome::Overlapping;
  return found.bound - slack(overlapping ? 2.2 * rounding : rounding, found.bound);
}

/// Do two solids of few faces lie flat on each other, and across which plane?
bool find_flat(const Polyhedron& p, const Polyhedron& q, std::optional<Vector3>& normal) {
  constexpr int kFewFaces = 16;
  if (p.topology().face_count() + q.topology().face_count() > kFewFaces) return false;
  const Vector3 facing = facing_normal(p, q);
  if (lies_flat(p, q, facing)) normal = facing;
  return normal.has_value();
}

/// The least overlap from where the search found that there is one.
void grow(const OrderedPair& pair, Quick& quick) {
  quick.found = expand_polytope(pair.p, pair.q, quick.found, 0.25 * pair.length.rounding);
  quick.grown = true;
  quick.iterations += quick.found.iterations;
}

bool are_bricks(const Polyhedron& a, const Polyhedron& b) {
  return !a.topology().brick().empty() && !b.topology().brick().empty();
}

/// The least overlap of two bricks, where it is clear.
bool part_bricks(const OrderedPair& pair, Quick& quick) {
  const SearchResult found = box_sat(pair.p, pair.q, pair.length.rounding);
  if (found.outcome != SearchOutcome::Overlapping) return false;
  quick.searched = true;
  quick.found = found;
  quick.iterations += found.iterations;
  return quick.grown = true;
}

/// The least overlap as an ordinary answer.
bool overlapping_answer(const OrderedPair& pair, Quick& quick, NearestFeatures& answer) {
  const double rounding = pair.length.rounding;
  if (!quick.grown) {
    if (find_flat(pair.p, pair.q, quick.flat)) return false;
    grow(pair, quick);
    if (quick.found.outcome != SearchOutcome::Overlapping) return false;
  }
  const SearchResult& found = quick.found;
  const Overlap overlap{found.normal, least_gap(found, rounding)};
  if (!found_answer(pair.p, pair.q, pair.length, found.p, found.q, &overlap, answer)) return false;
  if (pair.reversed) swap_names(answer);
  return true;
}

/// The nearest features of the corners that look at each other.
bool corner_answer(const Polyhedron& a, const Polyhedron& b, const Lengths& length, Quick& quick,
                   NearestFeatures& answer) {
  ++quick.iterations;
  const CornerFeatures corners = corner_features(a, b, b.vertex_mean() - a.vertex_mean());
  return found_answer(a, b, length, corners.p, corners.q, nullptr, answer);
}

/// The answer of a cold search.
bool searched_answer(const Polyhedron& a, const Polyhedron& b, const Lengths& length, Quick& quick,
                     NearestFeatures& answer) {
  if (has_plain_corners(a, b) && corner_answer(a, b, length, quick, answer)) return true;
  if (are_bricks(a, b)) {
    const OrderedPair pair = ordered(a, b, length);
    if (part_bricks(pair, quick)) return overlapping_answer(pair, quick, answer);
  }
  const SearchResult found =
      nearest_feature_search(a, b, b.vertex_mean() - a.vertex_mean(), 0.25 * length.rounding);
  quick.iterations += found.iterations;
  const bool overlapping = found.outcome == SearchOutcome::Overlapping;
  if (!overlapping && found_answer(a, b, length, found.p, found.q, nullptr, answer)) return true;
  const OrderedPair pair = ordered(a, b, length);
  quick.searched = true;
  quick.found = found;
  if (pair.reversed) swap_names(quick.found);
  return overlapping && overlapping_answer(pair, quick, answer);
}

bool fast_answer(const OrderedPair& pair, Quick& quick, Optimum& optimum) {
  const Polyhedron &p = pair.p, &q = pair.q;
  const Lengths& length = pair.length;
  const double rounding = length.rounding;
  if (quick.flat && flat_answer(p, q, length, *quick.flat, optimum)) return true;
  const SearchResult& found = quick.found;
  const bool overlapping = found.outcome == SearchOutcome::Overlapping;
  if (overlapping && !quick.grown) grow(pair, quick);
  if (found.outcome == SearchOutcome::Unclear) return false;
  // Of two nearly parallel planes, as good within rounding, the one where the features meet.
  const double least = least_gap(found, rounding);
  const auto best = [&] {
    return optimum.plane.gap >= least && lies_over(p, q, optimum.plane, optimum.laid(), rounding);
  };
  take_corners(p, q, found, optimum.plane.sets);
  optimum.straight = straight_plane(p, q, length, found.normal, optimum) && best();
  if (optimum.straight) return optimum.converged = true;
  optimum.faces.reset();
  optimum.converged = settle_corners(p, q, found, length, optimum.plane) && best();
  if (optimum.converged || overlapping) return optimum.converged;
  // Flush blocks: a corner just over an edge, whose line leans by a rounding over the gap.
  const int f = facing_face(p, found.p[0], found.normal);
  const int g = facing_face(q, found.q[0], -found.normal);
  if (f < 0 || g < 0) return false;
  return flat_answer(p, q, length, p.face_normal(f), optimum) ||
         flat_answer(p, q, length, -q.face_normal(g), optimum);
}

/// Whatever doubles could not decide.
void wide_answer(const Polyhedron& p, const Polyhedron& q, int max_iterations,
                 const Lengths& length, Optimum& optimum) {
  ActiveFeatures found = exact_nearest(p, q, max_iterations);
  optimum.iterations += found.iterations;
  if (found.overlapping) found = exhaustive_overlap(p, q);
  optimum.converged = found.converged;
  optimum.several = found.several;
  optimum.middle = found.middle;
  Plane& plane = optimum.plane;
  const bool same = !length.uneven && !found.middle &&
                    settle_normal(p, q, length, found.normal, plane) &&
                    plane.gap >= found.gap - slack(length.rounding, found.gap) &&
                    lies_over(p, q, plane, nullptr, length.rounding);
  if (same) return;
  scan(p, q, found.normal, plane);
  find_sets(p, q, length, plane);
  plane.form = {};
  plane.gap = found.gap;
}

/// Witness points: of the shared part of the two features that rounding cannot tell from parallel.
void set_witnesses(const Polyhedron& p, const Polyhedron& q, const Carried& contact,
                   const VertexSet& set_p, const VertexSet& set_q, double length,
                   NearestFeatures& answer) {
  const Vector3 across = answer.gap * answer.normal;
  if (set_p.size() == 1) {
    answer.point_a = p.vertex(set_p[0]);
    answer.point_b = set_q.size() == 1 && answer.gap > 0.0 ? q.vertex(set_q[0])
                                                           : Vector3(answer.point_a + across);
    return;
  }
  if (set_q.size() == 1) {
    answer.point_b = q.vertex(set_q[0]);
    answer.point_a = answer.point_b - across;
    return;
  }
  if (contact.form.crossed && set_p.size() == 2 && set_q.size() == 2) {
    const Vector3 base = p.vertex(set_p[0]);
    answer.point_a = base + contact.form.share * (p.vertex(set_p[1]) - base);
    answer.point_b = answer.point_a + across;
    return;
  }
  LateInit<ContactPolygon> faces;
  if (lay_whole_faces(p, q, contact, set_p, set_q, faces.emplace()) && faces->measured) {
    answer.point_a = faces->plane.point(faces->polygon.centroid, 0.0);
    answer.point_b = answer.point_a + across;
    return;
  }
  const ProjectedPair patches(p, q, contact, set_p, set_q, length);
  SharedCorners corners;
  append_shared_corners(patches.p, patches.q, 2 * length + kEpsilon * std::abs(answer.gap),
                        corners);
  Vector2 place = Vector2::Zero();
  if (corners.empty()) {
    place = nearest_place(patches.p, patches.q);
  } else {
    SharedPolygon polygon;
    find_polygon(corners, polygon);
    place = polygon.centroid;
  }
  answer.point_a = patches.plane.point(place, 0.0);
  answer.point_b = answer.point_a + across;
}

Feature feature_of(const Polyhedron& polyhedron, const VertexSet& set, FeatureKind kind, int face,
                   const Vector3& outward) {
  if (kind == FeatureKind::Vertex) return {kind, set[0]};
  const Topology& topology = polyhedron.topology();
  if (set.size() == 2) {
    const int edge = topology.find_edge(set[0], set[1]);
    if (edge >= 0) return {FeatureKind::Edge, edge};
  }
  const bool named = face >= 0 && topology.face_set(face).size() == set.size();
  if (kind == FeatureKind::Face && named) return {kind, face};
  return name_support_set(polyhedron, set, kind, outward);
}

/// How far either solid reaches beyond its witness.
void set_residuals(const Polyhedron& p, const Polyhedron& q, const Carried& plane,
                   NearestFeatures& answer) {
  const Vector3 high = p.vertex(plane.support_p.vertex), low = q.vertex(plane.support_q.vertex);
  answer.residual_a = std::max(0.0, answer.normal.dot(high - answer.point_a));
  answer.residual_b = std::max(0.0, answer.normal.dot(answer.point_b - low));
}

/// Features within the contact tolerance: the sets are those of `tolerance`.
void set_features(const Polyhedron& p, const Polyhedron& q, const Carried& plane,
                  const VertexSet& set_p, const VertexSet& set_q, double tolerance,
                  NearestFeatures& answer) {
  const FeatureKind kind_p = span_kind(p, set_p, tolerance);
  const FeatureKind kind_q = span_kind(q, set_q, tolerance);
  answer.feature_a = feature_of(p, set_p, kind_p, plane.sets.face_p, answer.normal);
  answer.feature_b = feature_of(q, set_q, kind_q, plane.sets.face_q, -answer.normal);
  set_residuals(p, q, plane, answer);
  if (kind_p == FeatureKind::Face || kind_q == FeatureKind::Face) return;
  if (type_of(p, q, set_p, set_q, kind_p, kind_q, tolerance) != ContactType::EdgeEdgeCrossing) {
    answer.indeterminate = true;
    answer.rule = PlaneRule::ShortestLine;
  }
}

/// The witnesses of two whole faces, and what the contact points will ask for.
void set_face_witnesses(const Polyhedron& p, const Polyhedron& q, const Carried& contact,
                        ContactPolygon& faces, NearestFeatures& answer) {
  Vector2 place;
  if (faces.corners.empty()) {
    ProjectedFeature patch_p, patch_q;
    lay_feature(p, {FeatureKind::Face, faces.face_p}, faces.plane, 1.0, patch_p);
    lay_feature(q, {FeatureKind::Face, faces.face_q}, faces.plane, -1.0, patch_q);
    place = nearest_place(patch_p, patch_q);
  } else {
    find_polygon(faces);
    place = faces.polygon.centroid;
  }
  answer.point_a = faces.plane.point(place, 0.0);
  answer.point_b = answer.point_a + answer.gap * answer.normal;
  faces.top_p = contact.support_p;
  faces.top_q = contact.support_q;
}

/// Witnesses, features and what they leave open.
void describe(const Polyhedron& p, const Polyhedron& q, Optimum& optimum, const Lengths& length,
              NearestFeatures& answer) {
  const Plane& plane = optimum.plane;
  if (optimum.faces) {
    const ContactPolygon& faces = *optimum.faces;
    set_face_witnesses(p, q, plane, *optimum.faces, answer);
    if (!surely_wide(p, q, faces, length.contact)) {
      set_features(p, q, plane, plane.sets.p, plane.sets.q, length.contact, answer);
      return;
    }
    answer.feature_a = {FeatureKind::Face, faces.face_p};
    answer.feature_b = {FeatureKind::Face, faces.face_q};
    set_residuals(p, q, plane, answer);
    return;
  }
  if (optimum.straight) {
    set_witnesses(p, q, plane, plane.sets.p, plane.sets.q, length.place, answer);
    set_features(p, q, plane, plane.sets.p, plane.sets.q, length.contact, answer);
    return;
  }
  VertexSet set_p, set_q;
  plane.near_p->select(length.place, set_p);
  plane.near_q->select(length.place, set_q);
  set_witnesses(p, q, plane, set_p, set_q, length.place, answer);
  plane.near_p->select(length.contact, set_p);
  plane.near_q->select(length.contact, set_q);
  set_features(p, q, plane, set_p, set_q, length.contact, answer);
  if (!optimum.several) return;
  answer.indeterminate = true;
  answer.rule = optimum.middle ? PlaneRule::MiddleOfPlanes : PlaneRule::LeastOverlap;
}

void set_hint(const Carried& plane, NearestFeatures& answer) {
  for (std::size_t k = 0; k < 4; ++k) {
    answer.hint.vertices_a[k] = k < plane.sets.p.size() ? plane.sets.p[k] : -1;
    answer.hint.vertices_b[k] = k < plane.sets.q.size() ? plane.sets.q[k] : -1;
  }
  answer.hint.face_a = plane.sets.face_p;
  answer.hint.face_b = plane.sets.face_q;
  answer.hint.normal = answer.normal;
}

/// The general way; true: an ordinary answer after all, in the names of the caller.
bool general_answer(const OrderedPair& pair, const SearchOptions& options, const FeatureHint& hint,
                    Quick& quick, Optimum& optimum, NearestFeatures& answer) {
  const Polyhedron &p = pair.p, &q = pair.q;
  const Lengths& length = pair.length;
  const auto warm = [&] {
    return quick.hint == Trial::Undecided && hinted_plane(p, q, hint, length, optimum);
  };
  if (length.uneven || !warm()) {
    if (!length.uneven && !quick.searched &&
        searched_answer(pair.a(), pair.b(), length, quick, answer)) {
      return true;
    }
    if (length.uneven || !fast_answer(pair, quick, optimum)) {
      optimum.faces.reset();
      wide_answer(p, q, options.max_iterations, length, optimum);
    }
  }
  answer.normal = one_zero(optimum.plane.normal);
  answer.gap = optimum.plane.gap;
  describe(p, q, optimum, length, answer);
  set_hint(optimum.plane, answer);
  if (optimum.converged) answer.status = status_of(answer.gap, length);
  return false;
}

}  // namespace

std::string_view name(PairStatus status) {
  switch (status) {
    case PairStatus::Separated:
      return "separated";
    case PairStatus::Touching:
      return "touching";
    case PairStatus::Overlapping:
      return "overlapping";
    case PairStatus::NotConverged:
      return "not-converged";
  }
  return "";
}

std::string_view name(PlaneRule rule) {
  switch (rule) {
    case PlaneRule::Unique:
      return "unique";
    case PlaneRule::ShortestLine:
      return "shortest-line";
    case PlaneRule::LeastOverlap:
      return "least-overlap";
    case PlaneRule::MiddleOfPlanes:
      return "middle-of-planes";
  }
  return "";
}

double default_tolerance(const Polyhedron& a, const Polyhedron& b) {
  return std::max(1e-9 * std::min(a.diameter(), b.diameter()),
                  16 * kEpsilon * std::max(a.largest_coordinate(), b.largest_coordinate()));
}

namespace {

/// Whatever the quick ways have left open.
void find_answer(const OrderedPair& pair, const SearchOptions& options, const FeatureHint& hint,
                 Quick& quick, Optimum& optimum, NearestFeatures& answer) {
  FeatureHint named = hint;
  if (pair.reversed) swap_names(named);
  const bool ordinary = general_answer(pair, options, named, quick, optimum, answer);
  if (pair.reversed && !ordinary) swap_names(answer);
  answer.iterations = quick.iterations + optimum.iterations;
}

/// The same; not inline, for its room on the stack is of no use to the quick ways.
[[gnu::noinline]] void find_answer_at_last(const OrderedPair& pair, const SearchOptions& options,
                                           const FeatureHint& hint, Quick& quick,
                                           NearestFeatures& answer) {
  LateInit<ContactPolygon> faces;
  Optimum optimum(faces);
  find_answer(pair, options, hint, quick, optimum, answer);
}

/// Where the hint has not led to the answer.
[[gnu::noinline]] void find_answer_apart(const Polyhedron& a, const Polyhedron& b,
                                         const SearchOptions& options, const FeatureHint& hint,
                                         const Lengths& length, Trial trial,
                                         NearestFeatures& answer) {
  Quick quick{.hint = trial, .iterations = answer.iterations};
  const bool hint_left = trial == Trial::Undecided && hint.vertices_a[0] >= 0;
  if (!length.uneven && !hint_left && searched_answer(a, b, length, quick, answer)) {
    answer.iterations = quick.iterations;
    return;
  }
  find_answer_at_last(ordered(a, b, length), options, hint, quick, answer);
}

}  // namespace

NearestFeatures nearest_features(const Polyhedron& a, const Polyhedron& b,
                                 const SearchOptions& options, const FeatureHint& hint,
                                 LateInit<ContactPolygon>& faces) {
  fetch(a);
  fetch(b);
  fetch_faces(a);
  fetch_faces(b);
  NearestFeatures answer;
  const Lengths length = lengths(a, b, options.tolerance);
  Trial trial = Trial::Undecided;
  if (length.uneven || !hinted_answer(a, b, length, hint, trial, answer)) {
    Quick quick{.hint = trial, .iterations = answer.iterations};
    Optimum optimum(faces);
    find_answer(ordered(a, b, length), options, hint, quick, optimum, answer);
  }
  return answer;
}

NearestFeatures nearest_features(const Polyhedron& a, const Polyhedron& b,
                                 const SearchOptions& options, const FeatureHint& hint) {
  fetch(a);
  fetch(b);
  NearestFeatures answer;
  const Lengths length = lengths(a, b, options.tolerance);
  Trial trial = Trial::Undecided;
  if (length.uneven || !hinted_answer(a, b, length, hint, trial, answer)) {
    find_answer_apart(a, b, options, hint, length, trial, answer);
  }
  return answer;
}

}  // namespace quoin::geometry
