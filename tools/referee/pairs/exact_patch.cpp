#include "referee/pairs/exact_patch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace quoin::referee {
namespace {

using geometry::ContactType;
using geometry::FeatureKind;
using geometry::Vector3;
using Real = long double;

Place operator-(const Place& p, const Place& q) { return {p[0] - q[0], p[1] - q[1]}; }
Real cross(const Place& u, const Place& v) { return u[0] * v[1] - u[1] * v[0]; }
Real dot(const Place& u, const Place& v) { return u[0] * v[0] + u[1] * v[1]; }
Real length(const Place& u) { return std::sqrt(dot(u, u)); }

Real norm_of(const RealPoint& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); }

RealPoint cross(const RealPoint& p, const RealPoint& q) {
  return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

RealPoint operator-(const RealPoint& p, const RealPoint& q) {
  return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}

/// A vertex near the support plane.
struct Carrier {
  Place place;
  Real depth = 0;  // below the support plane, m
  RealPoint point;
  std::size_t index = 0;  // of the point
};

/// The vertices of one solid within tol of its support plane, and what they span.
struct SupportPolygon {
  std::vector<Carrier> carriers;
  std::vector<Carrier> border;  // corners of their convex hull in the plane; ends of a segment
  std::vector<Place> hull;      // of them all
  FeatureKind kind = FeatureKind::Vertex;
  bool clear = true;
  Real open_ends = 0;  // see ExactPatch
};

bool is_clear(Real value, const PatchBands& bands) {
  return std::abs(value - Real(bands.tolerance)) > Real(bands.decision);
}

std::vector<Carrier> hull_of(std::vector<Carrier> list) {
  std::sort(list.begin(), list.end(), [](const Carrier& c, const Carrier& d) {
    return c.place != d.place ? c.place < d.place : c.depth < d.depth;
  });
  list.erase(std::unique(list.begin(), list.end(),
                         [](const Carrier& c, const Carrier& d) { return c.place == d.place; }),
             list.end());
  if (list.size() < 3) return list;
  std::vector<Carrier> hull;
  const auto add = [&](const Carrier& c, std::size_t floor) {
    while (hull.size() > floor &&
           cross(hull.back().place - hull[hull.size() - 2].place, c.place - hull.back().place) <= 0)
      hull.pop_back();
    hull.push_back(c);
  };
  for (const Carrier& c : list) add(c, 1);
  const std::size_t lower = hull.size();
  for (std::size_t i = list.size() - 1; i-- > 0;) add(list[i], lower);
  hull.pop_back();
  return hull;
}

std::vector<Place> hull_of(std::vector<Place> places) {
  std::vector<Carrier> carriers;
  for (const Place& place : places)
    carriers.push_back({.place = place, .depth = 0, .point = {}, .index = 0});
  places.clear();
  for (const Carrier& c : hull_of(std::move(carriers))) places.push_back(c.place);
  return places;
}

/// Least distance between parallel lines with the polygon between them.
Real width_of(const std::vector<Carrier>& polygon) {
  Real least = std::numeric_limits<Real>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Place& p = polygon[i].place;
    const Place side = polygon[(i + 1) % polygon.size()].place - p;
    Real most = 0;
    for (const Carrier& c : polygon) most = std::max(most, cross(side, c.place - p) / length(side));
    least = std::min(least, most);
  }
  return polygon.size() < 3 ? 0 : least;
}

/// The two corners farthest from each other.
std::array<Carrier, 2> farthest_ends(const std::vector<Carrier>& polygon) {
  std::array<Carrier, 2> ends{polygon.front(), polygon.front()};
  Real most = -1;
  for (const Carrier& c : polygon) {
    for (const Carrier& d : polygon) {
      const Real apart = norm_of(d.point - c.point);
      if (apart > most) {
        most = apart;
        ends = {c, d};
      }
    }
  }
  return ends;
}

/// How far the carriers lie from the line between two of them.
Real width_in_space(const std::vector<Carrier>& carriers, const std::array<Carrier, 2>& ends) {
  const RealPoint line = ends[1].point - ends[0].point;
  Real most = 0;
  for (const Carrier& c : carriers)
    most = std::max(most, norm_of(cross(line, c.point - ends[0].point)));
  return norm_of(line) > 0 ? most / norm_of(line) : 0;
}

/// How far ends that are as far apart, within the band, lie from the ends taken.
Real open_ends(const std::vector<Carrier>& polygon, const std::array<Carrier, 2>& ends,
               const PatchBands& bands) {
  const Real enough = norm_of(ends[1].point - ends[0].point) - Real(bands.decision);
  Real most = 0;
  for (const Carrier& c : polygon) {
    const bool far = std::any_of(polygon.begin(), polygon.end(), [&](const Carrier& d) {
      return norm_of(d.point - c.point) >= enough;
    });
    if (far) {
      most = std::max(most,
                      std::min(length(c.place - ends[0].place), length(c.place - ends[1].place)));
    }
  }
  return most;
}

void classify(const PatchBands& bands, SupportPolygon& polygon) {
  const std::array<Carrier, 2> ends = farthest_ends(polygon.border);
  const Real longest = norm_of(ends[1].point - ends[0].point), width = width_of(polygon.border);
  const Real tolerance = bands.tolerance;
  if (longest <= tolerance) {
    polygon.kind = FeatureKind::Vertex;
    polygon.border.resize(1);
  } else if (width <= tolerance) {
    polygon.kind = FeatureKind::Edge;
    polygon.open_ends = open_ends(polygon.border, ends, bands);
    polygon.border = {ends[0], ends[1]};
  } else {
    polygon.kind = FeatureKind::Face;
  }
  // how a width is measured is left open within a factor of two, and whether in the plane or in
  // space
  const bool between =
      width > tolerance / 2 - Real(bands.decision) && width < 2 * tolerance + Real(bands.decision);
  const bool deep = width <= tolerance &&
                    width_in_space(polygon.carriers, ends) > tolerance - Real(bands.decision);
  polygon.clear = polygon.clear && is_clear(longest, bands) && !between && !deep;
}

/// The border of the carriers, without points that are no vertices of the solid. Such a point lies
/// between vertices, and where one of these is deeper than tol it alone would carry; between
/// carriers it changes nothing but their number.
void keep_vertices(const ExactPair& pair, int side, SupportPolygon& polygon) {
  const auto inner = [&](const Carrier& c) { return !pair.is_vertex(side, c.index); };
  polygon.border = hull_of(polygon.carriers);
  for (auto at = polygon.border.begin(); at != polygon.border.end();) {
    if (!inner(*at)) {
      ++at;
      continue;
    }
    const std::size_t index = at->index;
    std::erase_if(polygon.carriers, [&](const Carrier& c) { return c.index == index; });
    polygon.border = hull_of(polygon.carriers);
    at = polygon.border.begin();
  }
}

SupportPolygon support_polygon(const ExactPair& pair, int side, const PlaneFrame& frame,
                               const PatchBands& bands) {
  const Real sign = side == 0 ? 1 : -1;
  const std::vector<RealPoint>& points = pair.places(side);
  Real top = -std::numeric_limits<Real>::infinity();
  for (const RealPoint& x : points) top = std::max(top, sign * frame.height(x));
  SupportPolygon polygon;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const RealPoint& x = points[i];
    const Real depth = top - sign * frame.height(x);
    polygon.clear = polygon.clear && is_clear(depth, bands);
    if (depth <= Real(bands.tolerance)) polygon.carriers.push_back({frame.place(x), depth, x, i});
  }
  keep_vertices(pair, side, polygon);
  for (const Carrier& c : polygon.border) polygon.hull.push_back(c.place);
  classify(bands, polygon);
  return polygon;
}

/// At most how far the solid's surface lies below its support plane over a place on the polygon:
/// the surface is nowhere below a triangle of its own points.
Real depth_at(const SupportPolygon& polygon, const Place& place) {
  const std::vector<Carrier>& corners = polygon.border;
  Real most = 0;
  for (const Carrier& c : corners) most = std::max(most, c.depth);
  if (corners.size() == 2) {
    const Place line = corners[1].place - corners[0].place;
    const Real t =
        std::clamp(dot(place - corners[0].place, line) / dot(line, line), Real(0), Real(1));
    return corners[0].depth + t * (corners[1].depth - corners[0].depth);
  }
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Place e = corners[i].place - corners[0].place,
                f = corners[i + 1].place - corners[0].place;
    const Place x = place - corners[0].place;
    const Real s = cross(x, f) / cross(e, f), t = cross(e, x) / cross(e, f);
    const Real near = -0x1p-40L;
    if (s >= near && t >= near && s + t <= 1 - near) {
      most = corners[0].depth + s * (corners[i].depth - corners[0].depth) +
             t * (corners[i + 1].depth - corners[0].depth);
    }
  }
  return most;
}

Real sine_between(const Place& u, const Place& v) {
  const Real product = length(u) * length(v);
  return product > 0 ? std::abs(cross(u, v)) / product : 1;
}

/// A side of a polygon that is being clipped: whose it is, which way is out, and its middle before
/// it was clipped.
struct Side {
  std::size_t solid = 0;
  Place outward{};
  Place middle{};
};

/// A corner and the side that follows it.
struct ClipCorner {
  PatchCorner corner;
  Side next;
};

/// Where a side crosses a line of the other solid, or of the same one: then it is a vertex of that.
ClipCorner crossing_of(const Place& place, const Side& side, const Side& line) {
  ClipCorner crossing;
  crossing.corner.place = place;
  crossing.corner.sine = std::abs(cross(side.outward, line.outward));
  if (side.solid != line.solid) {
    crossing.corner.outward[side.solid] = side.outward;
    crossing.corner.outward[line.solid] = line.outward;
    crossing.corner.middle[side.solid] = side.middle;
    crossing.corner.middle[line.solid] = line.middle;
  }
  return crossing;
}

/// The part of a polygon or segment inside a line through `from`, or beyond it by at most `border`.
std::vector<ClipCorner> clipped(const std::vector<ClipCorner>& subject, const Side& line,
                                const Place& from, Real border) {
  const auto inside = [&](const ClipCorner& c) {
    return border - dot(line.outward, c.corner.place - from);
  };
  std::vector<ClipCorner> kept;
  const std::size_t sides = subject.size() == 2 ? 1 : subject.size();
  for (std::size_t i = 0; i < subject.size(); ++i) {
    const ClipCorner& c = subject[i];
    const Real here = inside(c);
    if (here >= 0) kept.push_back(c);
    if (i >= sides || subject.size() < 2) continue;
    const ClipCorner& next = subject[i + 1 < subject.size() ? i + 1 : 0];
    const Real there = inside(next);
    if ((here >= 0) != (there >= 0)) {
      const Real t = here / (here - there);
      const Place &p = c.corner.place, &q = next.corner.place;
      kept.push_back(
          crossing_of({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])}, c.next, line));
      kept.back().next = here >= 0 ? line : c.next;
    }
  }
  return kept;
}

/// Unit, out of a counter-clockwise polygon across one of its sides.
Place out_of(const Carrier& from, const Carrier& to) {
  const Place line = to.place - from.place;
  const Real norm = length(line);
  return norm > 0 ? Place{line[1] / norm, -line[0] / norm} : Place{};
}

Place middle_of(const Carrier& from, const Carrier& to) {
  return {(from.place[0] + to.place[0]) / 2, (from.place[1] + to.place[1]) / 2};
}

/// Out of a corner sharper than 60 degrees, along its middle; 0 for others. What is within the
/// border of the lines of both its sides may lie far beyond it.
Place out_of_tip(const Place& before, const Place& after) {
  const Place sum{before[0] + after[0], before[1] + after[1]};
  const Real norm = length(sum);
  return dot(before, after) < -0.5L && norm > 0 ? Place{sum[0] / norm, sum[1] / norm} : Place{};
}

/// `solid`: whose border the region is; the subject is the other one's.
std::vector<PatchCorner> clipped_by(const std::vector<Carrier>& subject, std::size_t solid,
                                    const std::vector<Carrier>& region, Real border) {
  std::vector<ClipCorner> part;
  for (std::size_t i = 0; i < subject.size(); ++i) {
    const Carrier& next = subject[i + 1 < subject.size() ? i + 1 : 0];
    part.push_back({{.place = subject[i].place},
                    {1 - solid, out_of(subject[i], next), middle_of(subject[i], next)}});
  }
  const std::size_t count = region.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Carrier& next = region[(i + 1) % count];
    const Place before = out_of(region[(i + count - 1) % count], region[i]);
    const Place after = out_of(region[i], next);
    part = clipped(part, {solid, after, middle_of(region[i], next)}, region[i].place, border);
    if (const Place tip = out_of_tip(before, after); tip != Place{})
      part = clipped(part, {solid, tip, region[i].place}, region[i].place, border);
  }
  std::vector<PatchCorner> corners;
  for (const ClipCorner& c : part) corners.push_back(c.corner);
  return corners;
}

/// What of a solid lies within `depth` of its support plane, as seen along the normal: the part
/// below that is cut off goes through every line between a point above the cut and one below.
std::vector<Carrier> top_of(const ExactPair& pair, int side, const PlaneFrame& frame, Real depth) {
  const Real sign = side == 0 ? 1 : -1;
  std::vector<Carrier> all, top;
  Real highest = -std::numeric_limits<Real>::infinity();
  for (const RealPoint& x : pair.places(side)) highest = std::max(highest, sign * frame.height(x));
  for (const RealPoint& x : pair.places(side))
    all.push_back({frame.place(x), highest - sign * frame.height(x), x, all.size()});
  for (const Carrier& c : all) {
    if (c.depth > depth) continue;
    top.push_back(c);
    for (const Carrier& d : all) {
      if (d.depth > depth) {
        const Real share = (depth - c.depth) / (d.depth - c.depth);
        const Place step = d.place - c.place;
        top.push_back({{c.place[0] + share * step[0], c.place[1] + share * step[1]}, depth, {}, 0});
      }
    }
  }
  return hull_of(std::move(top));
}

std::vector<PatchCorner> corners_of(const std::vector<Carrier>& carriers) {
  std::vector<PatchCorner> corners;
  for (const Carrier& c : carriers) corners.push_back({.place = c.place});
  return corners;
}

/// The stretch that two parallel segments share as seen along the longer one, midway between them.
std::vector<PatchCorner> shared_stretch(const SupportPolygon& a, const SupportPolygon& b) {
  const Place& start = a.border[0].place;
  const Place line = a.border[1].place - start;
  if (length(line) < length(b.border[1].place - b.border[0].place)) return shared_stretch(b, a);
  const auto along = [&](const Place& p) { return dot(p - start, line) / dot(line, line); };
  const Real b0 = along(b.border[0].place), b1 = along(b.border[1].place);
  const Real low = std::max(Real(0), std::min(b0, b1)), high = std::min(Real(1), std::max(b0, b1));
  const Place& other = b.border[0].place;
  const Place side = b.border[1].place - other;
  const auto at = [&](Real t) {
    const Place on_a{start[0] + t * line[0], start[1] + t * line[1]};
    const Real s = std::clamp(dot(on_a - other, side) / dot(side, side), Real(0), Real(1));
    const Place on_b{other[0] + s * side[0], other[1] + s * side[1]};
    return PatchCorner{.place = {(on_a[0] + on_b[0]) / 2, (on_a[1] + on_b[1]) / 2}};
  };
  return low <= high ? std::vector<PatchCorner>{at(low), at(high)} : std::vector<PatchCorner>{};
}

/// Where two segments cross. Nothing where their lines do so beyond an end of either by more than
/// the border allows: heights may tilt edges against each other that are parallel in the plane.
std::vector<PatchCorner> line_crossing(const SupportPolygon& a, const SupportPolygon& b,
                                       Real border) {
  const Place d = a.border[1].place - a.border[0].place;
  const Place e = b.border[1].place - b.border[0].place;
  const Place apart = b.border[0].place - a.border[0].place;
  const Real s = cross(apart, e) / cross(d, e), t = cross(apart, d) / cross(d, e);
  PatchCorner corner;
  corner.place = {a.border[0].place[0] + s * d[0], a.border[0].place[1] + s * d[1]};
  corner.sine = sine_between(d, e);
  const auto reaches = [&](Real share, const Place& segment) {
    const Real beyond = std::max(-share, share - 1) * length(segment);
    return beyond * corner.sine <= border;
  };
  return reaches(s, d) && reaches(t, e) ? std::vector<PatchCorner>{corner}
                                        : std::vector<PatchCorner>{};
}

ContactType type_of(const SupportPolygon& a, const SupportPolygon& b, const PatchBands& bands,
                    bool& clear) {
  const auto [low, high] = std::minmax(a.kind, b.kind);
  if (low == FeatureKind::Vertex) {
    return high == FeatureKind::Vertex ? ContactType::VertexVertex
           : high == FeatureKind::Edge ? ContactType::VertexEdge
                                       : ContactType::VertexFace;
  }
  if (high == FeatureKind::Face)
    return low == FeatureKind::Face ? ContactType::FaceFace : ContactType::EdgeFace;
  const RealPoint d = a.border[1].point - a.border[0].point;
  const RealPoint e = b.border[1].point - b.border[0].point;
  const Real off = norm_of(cross(d, e)) / std::max(norm_of(d), norm_of(e));
  clear = clear && is_clear(off, bands);
  return off <= Real(bands.tolerance) ? ContactType::EdgeEdgeParallel
                                      : ContactType::EdgeEdgeCrossing;
}

std::vector<PatchCorner> shared_part(const SupportPolygon& a, const SupportPolygon& b,
                                     ContactType type, Real border) {
  switch (type) {
    case ContactType::FaceFace:
      return clipped_by(a.border, 1, b.border, border);
    case ContactType::EdgeFace:
      return a.kind == FeatureKind::Edge ? clipped_by(a.border, 1, b.border, border)
                                         : clipped_by(b.border, 0, a.border, border);
    case ContactType::EdgeEdgeParallel:
      return shared_stretch(a, b);
    case ContactType::EdgeEdgeCrossing:
      return line_crossing(a, b, border);
    default:
      return corners_of(a.kind == FeatureKind::Vertex ? a.border : b.border);
  }
}

/// Whether a solid goes on beyond a place on its support polygon: see ends_at().
struct Beyond {
  const ExactPair& pair;
  PlaneFrame frame;
  double tolerance, extent;  // m

  bool goes_on(int side, const Place& from, const Place& out) const {
    if (out == Place{}) return false;
    const Real sign = side == 0 ? 1 : -1, step = 1e-6L * Real(extent);
    Real top = -std::numeric_limits<Real>::infinity();
    for (const RealPoint& x : pair.places(side)) top = std::max(top, sign * frame.height(x));
    const Place beyond{from[0] + step * out[0], from[1] + step * out[1]};
    for (int quarter = 0; quarter <= 8; ++quarter) {
      const RealPoint below = frame.point(beyond, sign * (top - quarter * Real(tolerance) / 4));
      if (pair.distance_in_long_double(side, below) <= 0.1L * Real(tolerance)) return true;
    }
    return false;
  }
};

}  // namespace

PlaneFrame::PlaneFrame(const Vector3& normal) {
  for (std::size_t k = 0; k < 3; ++k) n_[k] = Real(normal[static_cast<Eigen::Index>(k)]);
  const Real norm = norm_of(n_);
  for (Real& c : n_) c /= norm;
  RealPoint axis{};
  const auto least = std::min_element(n_.begin(), n_.end(),
                                      [](Real x, Real y) { return std::abs(x) < std::abs(y); });
  axis[static_cast<std::size_t>(least - n_.begin())] = 1;
  u_ = cross(axis, n_);
  const Real across = norm_of(u_);
  for (Real& c : u_) c /= across;
  v_ = cross(n_, u_);
}

RealPoint PlaneFrame::point(const Place& place, long double height) const {
  RealPoint x;
  for (std::size_t k = 0; k < 3; ++k) x[k] = place[0] * u_[k] + place[1] * v_[k] + height * n_[k];
  return x;
}

ExactPatch exact_patch(const ExactPair& pair, const Vector3& normal, const PatchBands& bands) {
  const PlaneFrame frame(normal);
  const SupportPolygon a = support_polygon(pair, 0, frame, bands);
  const SupportPolygon b = support_polygon(pair, 1, frame, bands);
  ExactPatch patch;
  patch.clear = a.clear && b.clear;
  patch.type = type_of(a, b, bands, patch.clear);
  patch.support_vertices = static_cast<int>(a.carriers.size() + b.carriers.size());
  patch.support = {a.hull, b.hull};
  patch.open_ends = std::max(a.open_ends, b.open_ends);
  patch.corners = shared_part(a, b, patch.type, Real(bands.border));
  std::vector<Place> polygon;
  for (PatchCorner& corner : patch.corners) {
    corner.excess = depth_at(a, corner.place) + depth_at(b, corner.place);
    polygon.push_back(corner.place);
  }
  for (std::size_t i = 0; i < polygon.size(); ++i)
    patch.perimeter += length(polygon[(i + 1) % polygon.size()] - polygon[i]);
  const Real area = polygon_area(polygon, patch.centroid);
  patch.area = patch.type == ContactType::FaceFace ? area : 0;
  return patch;
}

bool ends_at(const ExactPair& pair, const Vector3& normal, const PatchCorner& corner,
             double tolerance, double extent) {
  const Beyond beyond{pair, PlaneFrame(normal), tolerance, extent};
  return !beyond.goes_on(0, corner.place, corner.outward[0]) &&
         !beyond.goes_on(1, corner.place, corner.outward[1]);
}

bool lies_on_cut(const ExactPair& pair, const Vector3& normal, const PatchCorner& corner,
                 double tolerance, double extent) {
  const Beyond beyond{pair, PlaneFrame(normal), tolerance, extent};
  return beyond.goes_on(0, corner.middle[0], corner.outward[0]) ||
         beyond.goes_on(1, corner.middle[1], corner.outward[1]);
}

bool both_reach(const ExactPair& pair, const Vector3& normal, const PatchCorner& corner,
                double tolerance, double slack) {
  const PlaneFrame frame(normal);
  const Real depth = Real(tolerance) / 2;
  const std::vector<Carrier> top_a = top_of(pair, 0, frame, depth),
                             top_b = top_of(pair, 1, frame, depth);
  std::vector<Place> shared;
  for (const PatchCorner& c : top_a.size() > 2   ? clipped_by(top_b, 0, top_a, -Real(slack))
                              : top_b.size() > 2 ? clipped_by(top_a, 1, top_b, -Real(slack))
                                                 : std::vector<PatchCorner>{})
    shared.push_back(c.place);
  return distance_to_places(shared, corner.place) <= Real(tolerance);
}

bool asks_for_point(const ExactPair& pair, const Vector3& normal, const ExactPatch& patch,
                    const PatchCorner& corner, const CornerLengths& lengths) {
  return patch.type == ContactType::EdgeEdgeParallel
             ? both_reach(pair, normal, corner, lengths.tolerance, lengths.slack)
             : ends_at(pair, normal, corner, lengths.tolerance, lengths.extent);
}

long double gap_along(const ExactPair& pair, const Vector3& normal) {
  const PlaneFrame frame(normal);
  Real top = -std::numeric_limits<Real>::infinity(), bottom = -top;
  for (const RealPoint& x : pair.places(0)) top = std::max(top, frame.height(x));
  for (const RealPoint& x : pair.places(1)) bottom = std::min(bottom, frame.height(x));
  return bottom - top;
}

long double distance_to_places(const std::vector<Place>& places, const Place& place) {
  const std::vector<Place> hull = hull_of(places);
  Real best = std::numeric_limits<Real>::infinity();
  bool inside = hull.size() > 2;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Place line = hull[(i + 1) % hull.size()] - hull[i], step = place - hull[i];
    inside = inside && cross(line, step) >= 0;
    const Real squared = dot(line, line);
    const Real t = squared > 0 ? std::clamp(dot(step, line) / squared, Real(0), Real(1)) : 0;
    best = std::min(best, length(Place{step[0] - t * line[0], step[1] - t * line[1]}));
  }
  return inside ? 0 : best;
}

long double polygon_area(const std::vector<Place>& polygon, Place& centroid) {
  centroid = {};
  Place mean{};
  for (const Place& p : polygon)
    mean = {mean[0] + p[0] / Real(polygon.size()), mean[1] + p[1] / Real(polygon.size())};
  Real area = 0;
  Place moment{};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Place p = polygon[i] - mean, q = polygon[(i + 1) % polygon.size()] - mean;
    const Real triangle = cross(p, q) / 2;
    area += triangle;
    moment = {moment[0] + triangle * (p[0] + q[0]) / 3, moment[1] + triangle * (p[1] + q[1]) / 3};
  }
  centroid = area > 0 ? Place{mean[0] + moment[0] / area, mean[1] + moment[1] / area} : mean;
  return area;
}

}  // namespace quoin::referee
