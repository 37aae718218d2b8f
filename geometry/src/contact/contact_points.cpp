#include <quoin/geometry/contact_point.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "certify/canonical_order.hpp"
#include "certify/feature_normal.hpp"
#include "contact/contact_corners.hpp"
#include "contact/contact_patch.hpp"
#include "contact/facing_faces.hpp"
#include "numeric/numbers.hpp"
#include "polygon/line_normal.hpp"
#include "polygon/overlay.hpp"
#include "search/nearest_features.hpp"

namespace quoin::geometry {
namespace {

/// As facing faces: a steeper edge belongs to another contact.
constexpr double kSteepSine = 0.5;

/// Everything about one pair, in the order in which it is worked (P before Q).
struct PairPoints {
  double tolerance = 0.0, gap = 0.0;
  ContactType type = ContactType::VertexVertex;
  VertexSet band_p, band_q;  // vertices that may carry points
  VertexSet support_p, support_q;
  FeatureKind kind_p = FeatureKind::Vertex, kind_q = FeatureKind::Vertex;
  ContactPlane plane;
  bool one_face_p = false, one_face_q = false;  // all that may carry points is one face
  bool polygon_asked = false;                   // what the contact features share, too
  SharedCorners merged;
  const SharedCorners* points = &merged;  // or the corners of two faces as they are
};

/// Does the solid climb steeply from one of its edges, or from a vertex along one of its edges?
/// Then that lies on its far side, below what faces the other.
bool climbs_from_edge(const Solid& polyhedron, int edge, const Vector3& line,
                      const Vector3& outward) {
  const auto [left, right] = polyhedron.topology().edge_faces(edge);
  const double limit = kSteepSine * line.norm();
  return polyhedron.face_normal(left).cross(line).dot(outward) > limit ||
         line.cross(polyhedron.face_normal(right)).dot(outward) > limit;
}

bool climbs_from_vertex(const Solid& polyhedron, int vertex, const Vector3& outward) {
  for (const int w : polyhedron.topology().neighbours(vertex)) {
    const Vector3 line = polyhedron.vertex(w) - polyhedron.vertex(vertex);
    if (line.dot(outward) > kSteepSine * line.norm()) return true;
  }
  return false;
}

/// Is a feature with these faces around it on the far side: do they all look away?
bool looks_away(const Solid& polyhedron, std::span<const int> faces, const Vector3& outward) {
  return std::none_of(faces.begin(), faces.end(),
                      [&](int f) { return polyhedron.face_normal(f).dot(outward) > 0.0; });
}

/// The features of one solid that may carry contact points: facing faces with a vertex in the band;
/// edges and vertices in the band that belong to none of these and are not on the far side.
void find_carriers(const Solid& polyhedron, const Vector3& outward, const VertexSet& band,
                   const VertexSet& nearest, SmallVector<Feature, 32>& carriers) {
  const Topology& topology = polyhedron.topology();
  if (const int face = only_facing(polyhedron, band, outward); face >= 0)
    return carriers.push_back({FeatureKind::Face, face});
  const auto add = [&](const Feature& feature) {
    if (!carriers.contains(feature)) carriers.push_back(feature);
  };
  const LooksAlong looks_along(polyhedron, outward);
  const auto looks = [&](int face) {
    const bool along = looks_along(face);
    if (along) add({FeatureKind::Face, face});
    return along;
  };
  for (const int v : band) {
    bool covered = false;
    for (const int f : topology.vertex_faces(v)) covered |= looks(f);
    if (covered) continue;
    for (const int e : topology.vertex_edges(v)) {
      if (carriers.contains({FeatureKind::Edge, e})) {  // by its other end
        covered = true;
        continue;
      }
      const auto [from, to] = topology.edge(e);
      const Vector3 line = polyhedron.line(from, to);
      if (std::abs(line.dot(outward)) > kSteepSine * line.norm()) continue;
      const bool needed = nearest.contains(from) && nearest.contains(to);
      if (!needed && (looks_away(polyhedron, topology.edge_faces(e), outward) ||
                      climbs_from_edge(polyhedron, e, line, outward)))
        continue;
      add({FeatureKind::Edge, e});
      covered = true;
    }
    if (covered) continue;
    const bool far = looks_away(polyhedron, topology.vertex_faces(v), outward) ||
                     climbs_from_vertex(polyhedron, v, outward);
    if (far && !nearest.contains(v)) continue;
    add({FeatureKind::Vertex, v});
  }
}

/// Vertex–face before edge–edge, then the smaller key in the names of the caller.
bool better_name(const SharedCorner& x, const SharedCorner& y, bool reversed) {
  const bool edge_x = x.feature_p.kind == FeatureKind::Edge;
  const bool edge_y = y.feature_p.kind == FeatureKind::Edge;
  if (edge_x != edge_y) return edge_y;
  const auto key = [&](const SharedCorner& c) {
    return reversed ? std::pair(c.feature_q, c.feature_p) : std::pair(c.feature_p, c.feature_q);
  };
  return key(x) < key(y);
}

/// Adds a point, or merges it with the one that is there already: the nearer place, the better
/// name.
void add_merged(const SharedCorner& corner, double tolerance, bool reversed,
                SharedCorners& points) {
  for (SharedCorner& kept : points) {
    if ((kept.place - corner.place).squaredNorm() > tolerance * tolerance) continue;
    const bool renamed = better_name(corner, kept, reversed);
    const Feature feature_p = renamed ? corner.feature_p : kept.feature_p;
    const Feature feature_q = renamed ? corner.feature_q : kept.feature_q;
    if (gap_of(corner) < gap_of(kept)) kept = corner;
    kept.feature_p = feature_p;
    kept.feature_q = feature_q;
    return;
  }
  points.push_back(corner);
}

/// Do two points lie within `tolerance` of each other? Of many only those that do along u are
/// compared.
bool crowded(const SharedCorners& points, double tolerance) {
  constexpr std::size_t kFew = 16;  // of these all are: sooner done than put in order
  SmallVector<std::size_t, 32> order;
  for (std::size_t k = 0; k < points.size(); ++k) order.push_back(k);
  const bool sorted = points.size() > kFew;
  if (sorted) {
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) {
      return std::pair(points[i].place.x(), i) < std::pair(points[k].place.x(), k);
    });
  }
  for (std::size_t k = 1; k < order.size(); ++k) {
    for (std::size_t i = k; i-- > 0;) {
      const Vector2 step = points[order[k]].place - points[order[i]].place;
      if (step.squaredNorm() <= tolerance * tolerance) return true;
      if (sorted && step.x() > tolerance) break;
    }
  }
  return false;
}

/// Points within `tolerance` of each other become one. From the lowest on, so that no place moves
/// away from what has been merged with it: which names they have then changes no place.
void merge_near(double tolerance, bool reversed, SharedCorners& points) {
  if (!crowded(points, tolerance)) return;
  SmallVector<std::size_t, 32> order;
  for (std::size_t k = 0; k < points.size(); ++k) order.push_back(k);
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) {
    return std::pair(gap_of(points[i]), i) < std::pair(gap_of(points[k]), k);
  });
  SharedCorners merged;
  for (const std::size_t k : order) add_merged(points[k], tolerance, reversed, merged);
  points = merged;
}

bool named(const SharedCorner& corner) {
  return corner.feature_p.index >= 0 && corner.feature_q.index >= 0;
}

/// Box around a patch in the contact plane, m.
struct PlaceBox {
  Vector2 low, high;
  explicit PlaceBox(const ProjectedFeature& patch) : low(patch.corners[0].place), high(low) {
    for (const ProjectedCorner& c : patch.corners) {
      low = low.cwiseMin(c.place);
      high = high.cwiseMax(c.place);
    }
  }
  bool meets(const PlaceBox& other, double slack) const {
    return (low - other.high).maxCoeff() <= slack && (other.low - high).maxCoeff() <= slack;
  }
};

/// The features that may carry points, in the order in which they are tried.
struct Carriers {
  SmallVector<Feature, 32> p, q;
};

/// Of two points of one name the lower one keeps it: of needles one may come at two places.
void merge_twins(SharedCorners& points) {
  SmallVector<std::pair<std::int64_t, std::size_t>, 32> names;
  for (std::size_t k = 0; k < points.size(); ++k)
    names.push_back({key_number(points[k].feature_p, points[k].feature_q, false), k});
  std::sort(names.begin(), names.end());
  bool twins = false;
  for (std::size_t i = 1, first = 0; i < names.size(); ++i) {
    if (names[i].first != names[first].first) {
      first = i;
      continue;
    }
    SharedCorner &kept = points[names[first].second], &twin = points[names[i].second];
    if (gap_of(twin) < gap_of(kept)) kept = twin;
    twin.feature_p.index = -1;
    twins = true;
  }
  if (!twins) return;
  const auto end = std::remove_if(points.begin(), points.end(),
                                  [](const SharedCorner& point) { return !named(point); });
  points.resize(static_cast<std::size_t>(end - points.begin()));
}

/// Adds the corners within the band.
void add_points(const SharedCorners& corners, double band, PairPoints& pair) {
  for (const SharedCorner& c : corners)
    if (gap_of(c) <= pair.gap + band && named(c)) pair.merged.push_back(c);
}

/// What is the same all the way to the points: the pair as it is worked, lengths in m.
struct Working {
  const Solid &p, &q;
  bool reversed;
  double tolerance;
  double band;      // up to so much above the least gap
  double rounding;  // of a place
};

/// Is each label that carries points planar, and each edge straight, as far as rounding can tell?
bool planar(const Solid& solid, const SmallVector<Feature, 32>& carriers, double rounding) {
  return std::all_of(carriers.begin(), carriers.end(), [&](const Feature& feature) {
    if (feature.kind != FeatureKind::Face) return solid.topology().all_are_corners();
    return solid.shape().label_fit(feature.index).off_plane <= kFlatLabel * rounding;
  });
}

/// Do two sides cross that lie along each other to within `tolerance`, m? Where is chance.
bool is_crossing_of_parallels(const Solid& p, const Solid& q, const SharedCorner& corner,
                              double tolerance) {
  // Sides of faces lean by 30 degrees at most: in space they reach across by little less.
  if (!(corner.across <= 2.0 * tolerance) || !named(corner)) return false;
  const auto line = [](const Solid& solid, const Feature& edge) {
    const auto [from, to] = solid.topology().edge(edge.index);
    return solid.line(from, to);
  };
  const Vec3 e = line(p, corner.feature_p), f = line(q, corner.feature_q);
  return parallel(square(cross(e, f)), greater(square(e), square(f)), tolerance);
}

bool has_crossing_of_parallels(const Solid& p, const Solid& q, const SharedCorners& corners,
                               double tolerance) {
  return std::any_of(corners.begin(), corners.end(), [&](const SharedCorner& corner) {
    return is_crossing_of_parallels(p, q, corner, tolerance);
  });
}

/// Such crossings are no points where the other corners show the place: within tol of the hull of
/// those whose gap is at most `highest`, m.
void drop_shown_crossings(const Solid& p, const Solid& q, double tolerance, double highest,
                          SharedCorners& corners) {
  if (!has_crossing_of_parallels(p, q, corners, tolerance)) return;
  SharedCorners others;
  for (const SharedCorner& corner : corners) {
    if (gap_of(corner) > highest || is_crossing_of_parallels(p, q, corner, tolerance)) continue;
    others.push_back(corner);
  }
  const auto end = std::remove_if(corners.begin(), corners.end(), [&](const SharedCorner& corner) {
    return is_crossing_of_parallels(p, q, corner, tolerance) &&
           near_hull(others, corner.place, tolerance);
  });
  corners.resize(static_cast<std::size_t>(end - corners.begin()));
}

/// Heights by the solids; without the places beyond one of them.
void drop_beyond(const Surfaces& surfaces, SharedCorners& corners) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    SharedCorner corner = corners[k];
    if (surfaces.lift(corner)) corners[kept++] = corner;
  }
  corners.resize(kept);
}

/// A feature of either solid in the contact plane, and what the two share.
struct Patches {
  ProjectedFeature p, q;
  SharedCorners corners;
  bool alone = false;  // no other features carry points, and both are planar faces
};

/// All places where facing features lie over each other within the band. `patches`: those that were
/// laid last.
void find_points(const Working& work, LateInit<Surfaces>& surfaces, PairPoints& pair,
                 Patches& patches) {
  const Solid &p = work.p, &q = work.q;
  const double band = work.band, rounding = work.rounding;
  Carriers carriers;
  find_carriers(p, pair.plane.normal, pair.band_p, pair.support_p, carriers.p);
  find_carriers(q, -pair.plane.normal, pair.band_q, pair.support_q, carriers.q);
  const auto one_face = [](const SmallVector<Feature, 32>& of) {
    return of.size() == 1 && of[0].kind == FeatureKind::Face;
  };
  pair.one_face_p = one_face(carriers.p);
  pair.one_face_q = one_face(carriers.q);
  if (!planar(p, carriers.p, rounding) || !planar(q, carriers.q, rounding))
    surfaces.emplace(p, q, pair.plane, band + rounding, rounding);
  auto& [patch_p, patch_q, corners, alone] = patches;
  SmallVector<PlaceBox, 32> boxes_q;  // of many features few pairs lie over each other
  const bool many = carriers.p.size() * carriers.q.size() > 1;
  for (std::size_t k = 0; many && k < carriers.q.size(); ++k) {
    lay_feature(q, carriers.q[k], pair.plane, -1.0, patch_q);
    boxes_q.push_back(PlaceBox(patch_q));
  }
  for (const Feature& f : carriers.p) {
    lay_feature(p, f, pair.plane, 1.0, patch_p);
    LateInit<PlaceBox> box_p;
    if (many) box_p.emplace(patch_p);
    for (std::size_t k = 0; k < carriers.q.size(); ++k) {
      if (box_p && !box_p->meets(boxes_q[k], 64 * rounding)) continue;
      lay_feature(q, carriers.q[k], pair.plane, -1.0, patch_q);
      corners.clear();
      append_shared_corners(patch_p, patch_q, rounding, corners);
      const std::size_t shared = corners.size();
      if (surfaces) drop_beyond(*surfaces, corners);
      drop_shown_crossings(p, q, work.tolerance, pair.gap + band, corners);
      alone = pair.one_face_p && pair.one_face_q && !surfaces && corners.size() == shared;
      add_points(corners, band, pair);
    }
  }
  if (!alone) merge_twins(pair.merged);
}

/// The point nearest to a place; most often it is number `guess`, there to the bit.
SharedCorner& nearest_point(const Vector2& place, std::size_t guess, SharedCorners& points) {
  if (guess < points.size() && points[guess].place == place) return points[guess];
  const auto nearer = [&](const SharedCorner& x, const SharedCorner& y) {
    return (x.place - place).squaredNorm() < (y.place - place).squaredNorm();
  };
  return *std::min_element(points.begin(), points.end(), nearer);
}

/// Is there a point within `tolerance` (m) of a place?
bool has_near(const SharedCorners& points, const Vector2& place, double tolerance) {
  return std::any_of(points.begin(), points.end(), [&](const SharedCorner& point) {
    return (point.place - place).squaredNorm() <= tolerance * tolerance;
  });
}

/// Ends of the stretch, as seen along the longer edge.
void append_stretch(const ProjectedFeature& patch_p, const ProjectedFeature& patch_q,
                    double rounding, SharedCorners& corners) {
  std::array<Vector2, 2> ends;
  const auto squared = [](const ProjectedFeature& edge) {
    return (edge.corners[1].place - edge.corners[0].place).squaredNorm();
  };
  const bool along_p = squared(patch_p) >= squared(patch_q);
  if (!find_shared_stretch(along_p ? patch_p : patch_q, along_p ? patch_q : patch_p, rounding,
                           ends))
    return;
  for (const Vector2& place : ends) {
    corners.push_back({place,
                       height_along(patch_p, place),
                       height_along(patch_q, place),
                       {FeatureKind::Edge, patch_p.corners[0].edge},
                       {FeatureKind::Edge, patch_q.corners[0].edge}});
  }
}

/// Adds a corner of the shared part as a point, unless the points show it: one of its own kind when
/// one lies within tol, a place on a side that tol cuts through a face when it lies in their hull.
void add_patch_point(const Working& work, const ProjectedFeature& patch_p,
                     const ProjectedFeature& patch_q, SharedCorner corner, PairPoints& pair) {
  if (gap_of(corner) > pair.gap + work.band + work.rounding) return;
  if (has_near(pair.merged, corner.place, pair.tolerance)) return;
  const bool inner = !named(corner) && pair.type == ContactType::FaceFace;
  if (inner && near_hull(pair.merged, corner.place, pair.tolerance)) return;
  const bool keeps_name = named(corner) && is_free(corner.feature_p, corner.feature_q, pair.merged);
  if (!keeps_name && !name_cut(work.p, work.q, patch_p, patch_q, pair.merged, corner)) return;
  pair.merged.push_back(corner);
}

/// The ends of parallel edges that lie beside each other by less than tol: the place next to an end
/// where the solids, within half of tol of their support planes, lie over each other. Elsewhere the
/// two have no point in common.
void add_stretch_points(const ProjectedFeature& patch_p, const ProjectedFeature& patch_q,
                        const Working& work, const SharedCorners& ends, PairPoints& pair) {
  const auto shown = [&](const SharedCorner& end) {
    return has_near(pair.merged, end.place, pair.tolerance);
  };
  if (std::all_of(ends.begin(), ends.end(), shown)) return;
  ProjectedFeature top_p, top_q;
  lay_top(work.p, patch_p.face, pair.plane, 1.0, 0.5 * pair.tolerance, top_p);
  lay_top(work.q, patch_q.face, pair.plane, -1.0, 0.5 * pair.tolerance, top_q);
  SharedCorners shared;
  append_shared_corners(top_p, top_q, 0.0, shared);  // on both: both have width
  if (shared.empty()) return;
  const Surfaces surfaces(work.p, work.q, pair.plane, work.band + work.rounding, work.rounding);
  for (const SharedCorner& end : ends) {
    if (shown(end)) continue;
    SharedCorner corner = nearest_in_hull(shared, end.place);
    if ((corner.place - end.place).norm() > pair.tolerance || !surfaces.lift(corner)) continue;
    if (gap_of(corner) > pair.gap + work.band) {
      // On steep sides little is known of heights: either solid has a point there no deeper.
      corner.height_p = std::max(corner.height_p, -0.5 * pair.tolerance);
      corner.height_q = std::min(corner.height_q, pair.gap + 0.5 * pair.tolerance);
    }
    const bool keeps = named(corner) && is_free(corner.feature_p, corner.feature_q, pair.merged);
    if (!keeps && !name_cut(work.p, work.q, patch_p, patch_q, pair.merged, corner)) continue;
    pair.merged.push_back(corner);
  }
}

/// Where the way from a corner of the shared part to the next comes to a gap that lies between
/// theirs (m). The gap of two solids is convex along it: the chord comes to that gap no later, and
/// so does each further one from there to the corner beyond.
SharedCorner place_of_gap(const SharedCorner& inner, const SharedCorner& outer, double gap,
                          const LateInit<Surfaces>& surfaces, double rounding) {
  constexpr int kChords = 16;  // most often the second is the last: gaps are linear but for kinks
  SharedCorner place = inner;
  for (int chord = 0; chord < kChords; ++chord) {
    const double share = (gap - gap_of(place)) / (gap_of(outer) - gap_of(place));
    place = {place.place + share * (outer.place - place.place),
             place.height_p + share * (outer.height_p - place.height_p),
             place.height_q + share * (outer.height_q - place.height_q),
             {FeatureKind::Edge, -1},
             {FeatureKind::Edge, -1}};
    SharedCorner lifted = place;
    if (!surfaces || !surfaces->lift(lifted)) return place;
    place = lifted;
    if (!(gap_of(place) < gap - rounding)) return place;
  }
  return place;
}

/// Where tol above the least gap is reached on the border of the shared part, which goes on to
/// twice that: either solid may lie tol below its support plane.
void add_tolerance_line(const Working& work, const ProjectedFeature& patch_p,
                        const ProjectedFeature& patch_q, const ContactPolygon& part,
                        const LateInit<Surfaces>& surfaces, PairPoints& pair) {
  SmallVector<int, 32> order;
  find_order(part.corners, order);
  const double limit = pair.gap + work.band;
  const auto add = [&](const SharedCorner& inner, const SharedCorner& outer) {
    const SharedCorner place = place_of_gap(inner, outer, limit, surfaces, work.rounding);
    add_patch_point(work, patch_p, patch_q, place, pair);
  };
  for (std::size_t k = 0; k < order.size(); ++k) {
    const SharedCorner& from = part.corners[static_cast<std::size_t>(order[k])];
    const SharedCorner& to =
        part.corners[static_cast<std::size_t>(order[k + 1 < order.size() ? k + 1 : 0])];
    const bool leaves = gap_of(to) > limit, enters = gap_of(from) > limit;
    if (leaves != enters) add(leaves ? from : to, leaves ? to : from);
  }
}

/// Are these vertices some of a face?
bool is_part_of(const Solid& solid, const VertexSet& set, int face) {
  const std::span<const int> whole = solid.topology().face_set(face);
  return std::includes(whole.begin(), whole.end(), set.begin(), set.end());
}

/// Lays the two contact features, and what they share, unless that is done already.
void lay_contact_features(const Working& work, const PairPoints& pair, Patches& patches) {
  const auto is_laid = [](const Solid& solid, const Feature& label, FeatureKind kind,
                          const VertexSet& set) {
    return label.kind == kind && is_just(solid, label, set);
  };
  const bool has_p = is_laid(work.p, patches.p.label, pair.kind_p, pair.support_p);
  const bool has_q = is_laid(work.q, patches.q.label, pair.kind_q, pair.support_q);
  if (!has_p) lay_support_set(work.p, pair.support_p, pair.kind_p, pair.plane, 1.0, patches.p);
  if (!has_q) lay_support_set(work.q, pair.support_q, pair.kind_q, pair.plane, -1.0, patches.q);
  if (pair.type == ContactType::EdgeEdgeParallel || (has_p && has_q && patches.alone)) return;
  patches.corners.clear();
  append_shared_corners(patches.p, patches.q, work.rounding, patches.corners);
}

/// Two whole faces are laid and hold all vertices that carry the answer, which are those of an edge
/// on one side at least: are all corners of what the contact features share among the points?
bool are_listed(const Working& work, const PairPoints& pair, const Patches& patches) {
  const bool of_edge =
      pair.type == ContactType::EdgeFace || pair.type == ContactType::EdgeEdgeCrossing;
  return of_edge && patches.alone && is_part_of(work.p, pair.support_p, patches.p.face) &&
         is_part_of(work.q, pair.support_q, patches.q.face);
}

/// The part that the two contact features share. Unless they are `listed`, its corners are points,
/// too, where the labels do not reach as far: where tol cuts a face, or vertices that are no
/// corners of labels stand out.
void find_shared_part(const Working& work, LateInit<Surfaces>& surfaces, bool listed,
                      PairPoints& pair, Patches& patches, ContactPolygon& part) {
  lay_contact_features(work, pair, patches);
  const auto& [patch_p, patch_q, corners, alone] = patches;
  if (pair.type == ContactType::EdgeEdgeParallel) {
    append_stretch(patch_p, patch_q, work.rounding, part.corners);
    add_stretch_points(patch_p, patch_q, work, part.corners, pair);
  } else {
    const double off_plane = kFlatLabel * work.rounding;
    if (!surfaces && !(is_flat(patch_p, off_plane) && is_flat(patch_q, off_plane)))
      surfaces.emplace(work.p, work.q, pair.plane, work.band + work.rounding, work.rounding);
    part.corners = corners;
    if (surfaces) surfaces->lift(part.corners);
    SharedCorners shown;
    if (!listed) shown = part.corners;
    drop_shown_crossings(work.p, work.q, work.tolerance, pair.gap + work.band, shown);
    for (const SharedCorner& corner : shown) {
      SharedCorner lifted = corner;
      const bool over = !surfaces || surfaces->lift(lifted);
      // Where two sides cross their own heights stand in; over a label there is nothing.
      if (!over && corner.feature_p.kind != corner.feature_q.kind) continue;
      add_patch_point(work, patch_p, patch_q, over ? lifted : corner, pair);
    }
  }
  find_polygon(part.corners, part.polygon);
  if (pair.type == ContactType::FaceFace)
    add_tolerance_line(work, patch_p, patch_q, part, surfaces, pair);
  else
    part.polygon.area = 0.0;
}

/// Marks the points that stand out of the hull of the others: the corners of the hull of all, but
/// of places where two edges cross only those beyond tol of the line between the corners beside
/// them. Where labels meet that rounding has split, their sides cross on the border.
void mark_outer(const SharedCorners& points, const SmallVector<int, 32>& order, double tolerance,
                SmallVector<char, 32>& outer) {
  outer.resize(points.size());
  std::fill(outer.begin(), outer.end(), 0);
  std::size_t before = order.size() - 1;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t after = k + 1 < order.size() ? k + 1 : 0;
    const auto point = [&](std::size_t i) -> const SharedCorner& {
      return points[static_cast<std::size_t>(order[i])];
    };
    const bool crossing = point(k).feature_p.kind == FeatureKind::Edge;
    if (crossing &&
        near_segment(point(before).place, point(after).place, point(k).place, tolerance))
      continue;
    outer[static_cast<std::size_t>(order[k])] = 1;
    before = k;
  }
}

/// Within tol of the least gap, as they all are, what does not stand out of the hull of the points
/// says nothing more. What stands for a corner of the polygon, the lowest, and vertices on the
/// border stay.
void drop_inner_points(const ContactPolygon& part, PairPoints& pair) {
  SmallVector<int, 32> order;
  SmallVector<char, 32> outer;
  find_order(pair.merged, order);
  mark_outer(pair.merged, order, pair.tolerance, outer);
  const auto lower = [](const SharedCorner& c, const SharedCorner& d) {
    return gap_of(c) < gap_of(d);
  };
  const auto lowest = std::min_element(pair.merged.begin(), pair.merged.end(), lower);
  SharedCorners kept;
  for (std::size_t k = 0; k < pair.merged.size(); ++k) {
    const SharedCorner& point = pair.merged[k];
    const bool crossing = point.feature_p.kind == FeatureKind::Edge;
    const bool inner =
        outer[k] == 0 && (crossing || well_inside(pair.merged, order, point.place, pair.tolerance));
    const bool stays = !inner || point.share > 0.0 || &point == lowest ||
                       has_near(part.corners, point.place, pair.tolerance);
    if (stays) kept.push_back(point);
  }
  pair.merged = kept;
}

/// The area of the polygon goes to the nearest points.
void share_area(const ContactPolygon& part, double band, PairPoints& pair) {
  for (SharedCorner& point : pair.merged) point.share = 0.0;
  for (std::size_t i = 0; i < part.corners.size(); ++i)
    nearest_point(part.corners[i].place, i, pair.merged).share += part.corners[i].share;
  if (band <= pair.tolerance) drop_inner_points(part, pair);
  balance_shares(part.polygon, pair.merged);
}

int most_facing_face(const Solid& polyhedron, const VertexSet& vertices, const Vector3& outward) {
  return std::max(
      0, facing_face(polyhedron, polyhedron.topology().vertex_faces(vertices[0]), outward));
}

/// The pair as it is worked: P and Q, and the answer's normal in that order.
struct OrderedPair {
  const Solid& p;
  const Solid& q;
  bool reversed;
  Vector3 normal;
  OrderedPair(const Solid& a, const Solid& b, bool reverse, const NearestFeatures& nearest)
      : p(reverse ? b : a),
        q(reverse ? a : b),
        reversed(reverse),
        normal(reverse ? Vector3(-nearest.normal) : nearest.normal) {}
};

/// Names the nearest features, for the rare pair whose patches do not show them: two crossed edges,
/// else a vertex of one on a face of the other. Of several names the first that no point has yet.
void name_nearest(const Solid& p, const Solid& q, const PairPoints& pair, SharedCorner& corner) {
  const auto take = [&](const Feature& feature_p, const Feature& feature_q) {
    corner.feature_p = feature_p;
    corner.feature_q = feature_q;
    return is_free(feature_p, feature_q, pair.merged);
  };
  if (pair.type == ContactType::EdgeEdgeCrossing) {
    const int e = p.topology().find_edge(pair.support_p[0], pair.support_p[1]);
    const int f = q.topology().find_edge(pair.support_q[0], pair.support_q[1]);
    if (e >= 0 && f >= 0 && take({FeatureKind::Edge, e}, {FeatureKind::Edge, f})) return;
  }
  const Vector3& normal = pair.plane.normal;
  const Feature face_p{FeatureKind::Face, most_facing_face(p, pair.support_p, normal)};
  const Feature face_q{FeatureKind::Face, most_facing_face(q, pair.support_q, -normal)};
  const auto take_vertex_of_q = [&] {
    return std::any_of(pair.support_q.begin(), pair.support_q.end(), [&](int v) {
      return take(face_p, {FeatureKind::Vertex, v});
    });
  };
  if (pair.support_q.size() == 1 && take_vertex_of_q()) return;
  for (const int v : pair.support_p)
    if (take({FeatureKind::Vertex, v}, face_q)) return;
  take_vertex_of_q();
}

/// The witnesses, laid.
SharedCorner laid_witnesses(const NearestFeatures& nearest, bool reversed,
                            const ContactPlane& plane) {
  const Vector3& point_p = reversed ? nearest.point_b : nearest.point_a;
  const Vector3& point_q = reversed ? nearest.point_a : nearest.point_b;
  SharedCorner corner;
  corner.place = plane.place(point_p);
  corner.height_p = plane.height(point_p);
  corner.height_q = plane.height(point_q);
  return corner;
}

/// The least gap itself is always among the points: deep overlaps of needles, and rounding, may
/// hide it from the faces.
void ensure_least_gap(const OrderedPair& ordered, const NearestFeatures& nearest, double rounding,
                      PairPoints& pair) {
  for (const SharedCorner& point : pair.merged)
    if (gap_of(point) <= pair.gap + rounding) return;
  SharedCorner corner = laid_witnesses(nearest, ordered.reversed, pair.plane);
  name_nearest(ordered.p, ordered.q, pair, corner);
  add_merged(corner, pair.tolerance, ordered.reversed, pair.merged);
  merge_twins(pair.merged);
}

/// The contact features are two whole faces.
void take_sets(const OrderedPair& ordered, const ContactPolygon& part, PairPoints& pair) {
  pair.support_p.assign(ordered.p.topology().face_set(part.face_p));
  pair.support_q.assign(ordered.q.topology().face_set(part.face_q));
}

/// The points of two whole faces, from what the search has found already.
bool find_face_points(const OrderedPair& ordered, double band, double rounding,
                      LateInit<ContactPolygon>& part, PairPoints& pair) {
  if (!part || !faces_alone(ordered.p, ordered.q, *part, band)) return false;
  if (!are_wide(ordered.p, ordered.q, *part, pair.tolerance)) return false;
  const LabelFit &of_p = ordered.p.shape().label_fit(part->face_p),
                 &of_q = ordered.q.shape().label_fit(part->face_q);
  if (std::max(of_p.outside, of_q.outside) > kFlatLabel * rounding) return false;
  const bool flat = std::max(of_p.off_plane, of_q.off_plane) <= kFlatLabel * rounding;
  if (!flat)
    Surfaces(ordered.p, ordered.q, part->plane, band + rounding, rounding).lift(part->corners);
  const auto in_reach = [&](const SharedCorner& c) { return gap_of(c) <= pair.gap + band; };
  const auto is_least = [&](const SharedCorner& c) { return gap_of(c) <= pair.gap + rounding; };
  const bool within = std::all_of(part->corners.begin(), part->corners.end(), in_reach);
  const bool settled =
      flat && part->convex && within &&
      std::any_of(part->corners.begin(), part->corners.end(), is_least) &&
      !has_crossing_of_parallels(ordered.p, ordered.q, part->corners, pair.tolerance) &&
      !crowded(part->corners, pair.tolerance);
  if (!within) return false;
  pair.type = ContactType::FaceFace;
  pair.kind_p = pair.kind_q = FeatureKind::Face;
  pair.plane = part->plane;
  if (settled) {
    pair.points = &part->corners;
  } else {
    take_sets(ordered, *part, pair);
    SharedCorners shown = part->corners;
    drop_shown_crossings(ordered.p, ordered.q, pair.tolerance, pair.gap + band, shown);
    add_points(shown, band, pair);
    merge_twins(pair.merged);
    merge_near(pair.tolerance, ordered.reversed, pair.merged);
  }
  return true;
}

/// What contact features span that are all of a `face`, some of it, or not of one (-1).
FeatureKind kind_of(const Solid& solid, const VertexSet& set, int face, double tolerance) {
  const bool whole = face >= 0 && solid.topology().face_set(face).size() == set.size();
  return whole && is_wide(solid, face, tolerance) ? FeatureKind::Face
                                                  : span_kind(solid, set, tolerance);
}

/// The points of any pair.
void find_all_points(const OrderedPair& ordered, const ContactOptions& options, double rounding,
                     LateInit<ContactPolygon>& part, PairPoints& pair) {
  const double band = std::max(pair.tolerance, options.reach);
  const Solid &p = ordered.p, &q = ordered.q;
  const std::array depths{band, pair.tolerance};
  const Support top = find_top(p, ordered.normal, depths, pair.band_p, pair.support_p);
  find_top(q, -ordered.normal, depths, pair.band_q, pair.support_q);
  pair.plane = ContactPlane(p.vertex(top.vertex), ordered.normal);
  const Working work{p, q, ordered.reversed, pair.tolerance, band, rounding};
  LateInit<Surfaces> surfaces;
  Patches patches;
  find_points(work, surfaces, pair, patches);
  pair.kind_p = kind_of(p, pair.support_p, pair.one_face_p ? patches.p.face : -1, pair.tolerance);
  pair.kind_q = kind_of(q, pair.support_q, pair.one_face_q ? patches.q.face : -1, pair.tolerance);
  pair.type =
      type_of(p, q, pair.support_p, pair.support_q, pair.kind_p, pair.kind_q, pair.tolerance);
  const double beside = std::max(pair.tolerance, options.coordinate_rounding);
  if (!pair.one_face_p) name_least_leaning(p, pair.plane, 1.0, beside, pair.merged);
  if (!pair.one_face_q) name_least_leaning(q, pair.plane, -1.0, beside, pair.merged);
  merge_near(pair.tolerance, work.reversed, pair.merged);
  part.reset();
  const bool of_vertex = pair.kind_p == FeatureKind::Vertex || pair.kind_q == FeatureKind::Vertex;
  const bool listed = are_listed(work, pair, patches);
  if (of_vertex || (listed && !pair.polygon_asked)) return;
  find_shared_part(work, surfaces, listed, pair, patches, part.emplace());
}

void find_pair_points(const OrderedPair& ordered, const NearestFeatures& nearest,
                      const ContactOptions& options, LateInit<ContactPolygon>& part,
                      PairPoints& pair) {
  pair.tolerance =
      options.tolerance > 0.0 ? options.tolerance : default_tolerance(ordered.p, ordered.q);
  pair.gap = nearest.gap;
  const double band = std::max(pair.tolerance, options.reach);
  const double rounding = border_rounding(ordered.p, ordered.q, pair.gap);
  if (!find_face_points(ordered, band, rounding, part, pair))
    find_all_points(ordered, options, rounding, part, pair);
  if (pair.points != &pair.merged) return;
  ensure_least_gap(ordered, nearest, std::max(rounding, options.coordinate_rounding), pair);
  if (pair.type == ContactType::FaceFace) share_area(*part, band, pair);
}

/// Of places in order the two that are farthest from each other: where an edge lies along the
/// border of a face rounding tells several at an end.
void keep_ends(const SharedCorners& corners, SmallVector<int, 32>& order) {
  const auto place = [&](int i) { return corners[static_cast<std::size_t>(i)].place; };
  if (order.size() <= 2) return;
  std::array<int, 2> ends{order[0], order[1]};
  double farthest = 0.0;
  for (std::size_t k = 1; k < order.size(); ++k) {
    for (std::size_t i = 0; i < k; ++i) {
      const double squared = (place(order[k]) - place(order[i])).squaredNorm();
      if (squared <= farthest) continue;
      farthest = squared;
      ends = {order[i], order[k]};
    }
  }
  order.assign(ends);
}

/// Polygon or segment as points half-way between the solids, counter-clockwise against A's normal.
void copy_polygon(const ContactPolygon& part, const PairPoints& pair, bool reversed,
                  std::vector<Vector3>& polygon) {
  SmallVector<int, 32> order;
  find_order(part.corners, order);
  if (pair.type != ContactType::FaceFace) keep_ends(part.corners, order);
  for (const int i : order) {
    const SharedCorner& c = part.corners[static_cast<std::size_t>(i)];
    polygon.push_back(pair.plane.point(c.place, 0.5 * (c.height_p + c.height_q)));
  }
  if (reversed) std::reverse(polygon.begin(), polygon.end());
}

void move(const PlacedPair& pair, PointFrame frame, std::span<ContactPoint> points) {
  if (!pair.as_shapes) move(pair.a, pair.b, pair.middle, frame, points);
}

void update(const Solid& a, const Solid& b, const ContactOptions& options, PairContact& contact) {
  LateInit<ContactPolygon> part;
  const FeatureHint hint = contact.nearest.hint;
  contact.nearest = {};
  find_nearest_features(a, b, {.tolerance = options.tolerance}, hint, &part, contact.nearest);
  if (!std::isfinite(contact.nearest.gap)) {
    PairContact none;
    none.nearest = contact.nearest;
    contact = std::move(none);
    return;
  }
  const OrderedPair ordered(a, b, in_reverse_order(a, b), contact.nearest);
  PairPoints pair;
  pair.polygon_asked = true;
  find_pair_points(ordered, contact.nearest, options, part, pair);
  if (pair.points != &pair.merged) take_sets(ordered, *part, pair);
  contact.points.clear();
  append_corners({0, 1}, ordered.reversed, contact.nearest, pair.type, pair.plane, *pair.points,
                 contact.points);
  contact.type = pair.type;
  contact.area = part ? part->polygon.area : 0.0;
  contact.polygon.clear();
  if (part) copy_polygon(*part, pair, ordered.reversed, contact.polygon);
  const auto copy = [](const VertexSet& set, FeatureKind kind, SupportSet& to) {
    to.vertices.assign(set.begin(), set.end());
    to.kind = kind;
  };
  copy(pair.support_p, pair.kind_p, ordered.reversed ? contact.support_b : contact.support_a);
  copy(pair.support_q, pair.kind_q, ordered.reversed ? contact.support_a : contact.support_b);
}

void check_lengths(const ContactOptions& options) {
  require_length(options.tolerance, "tolerance");
  require_length(options.coordinate_rounding, "coordinate rounding");
}

void check(const ContactOptions& options) {
  check_lengths(options);
  require_length(options.reach, "reach");
}

/// `reach` is a gap, below 0 for overlaps.
void check_with_gap(const ContactOptions& options) {
  check_lengths(options);
  require_length(std::abs(options.reach), "reach");
}

}  // namespace

NearestFeatures append_contacts_within_reach(const std::array<int, 2>& blocks, const Body& a,
                                             const Body& b, const ContactOptions& options,
                                             const FeatureHint& hint,
                                             std::vector<ContactPoint>& contacts) {
  check_with_gap(options);
  const PlacedPair placed(a, b);
  const auto& [as_shapes, middle, solid_a, solid_b] = placed;
  NearestFeatures nearest;
  LateInit<ContactPolygon> part;
  find_nearest_features(solid_a, solid_b, {.tolerance = options.tolerance}, hint, &part, nearest);
  if (std::isfinite(nearest.gap) &&
      (nearest.gap <= options.reach || nearest.status == PairStatus::Touching)) {
    const std::size_t first = contacts.size();
    const OrderedPair ordered(solid_a, solid_b, in_reverse_order(solid_a, solid_b), nearest);
    ContactOptions above_least = options;
    above_least.reach = std::max(0.0, options.reach - nearest.gap);
    PairPoints pair;
    find_pair_points(ordered, nearest, above_least, part, pair);
    append_corners(blocks, ordered.reversed, nearest, pair.type, pair.plane, *pair.points,
                   contacts);
    move(placed, options.frame, std::span(contacts).subspan(first));
  }
  move(placed, nearest);
  return nearest;
}

void update_pair_contact(const Body& a, const Body& b, const ContactOptions& options,
                         PairContact& contact) {
  check(options);
  const PlacedPair pair(a, b);
  update(pair.a, pair.b, options, contact);
  move(pair, contact.nearest);
  move(pair, options.frame, contact.points);
  for (Vector3& corner : contact.polygon) corner += pair.middle;
}

}  // namespace quoin::geometry
