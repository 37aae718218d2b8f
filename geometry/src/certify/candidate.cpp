#include "certify/candidate.hpp"

#include "polygon/line_normal.hpp"
#include "polygon/overlay.hpp"

namespace quoin::geometry {
namespace {

/// Lays the hull of a set into the plane; straight by its face label where that is known.
void lay_set(const Solid& solid, const VertexSet& set, int face, const ContactPlane& plane,
             double outward, double length, ProjectedFeature& patch) {
  if (is_whole(solid, face, set))
    lay_feature(solid, {FeatureKind::Face, face}, plane, outward, patch);
  else
    lay_support_set(solid, set, span_kind(solid, set, length), plane, outward, patch);
}

/// `faces`: the features as laid already, or null.
double margin_of(const Solid& p, const Solid& q, const Candidate& plane,
                 const ContactPolygon* faces, double rounding) {
  if (faces != nullptr) return faces->margin;
  const ProjectedPair patches(p, q, plane, plane.sets.p, plane.sets.q, rounding);
  return overlap_margin(patches.p, patches.q);
}

struct Inside {
  double rounding, margin;  // m
};

/// Of lines between vertices and edges: whatever rounding may turn their normal, no other vertex
/// comes into question, and no end of an edge within the margin.
bool joined_within(const Solid& p, const Solid& q, const Candidate& plane, const Lengths& length,
                   double margin) {
  const auto count_p = static_cast<int>(plane.sets.p.size());
  const auto count_q = static_cast<int>(plane.sets.q.size());
  if (!(plane.form.from_ends > margin * margin)) return false;
  const double lift = turning(length.rounding) / std::max(plane.gap, plane.form.across);
  return carry_turned(p, q, {count_p, count_q}, plane.normal, {lift, length.contact});
}

/// Of features that are not joined by a line: by more than the margin, or off by less than it.
bool lies_inside(const Solid& p, const Solid& q, const Candidate& plane,
                 const ContactPolygon* faces, const Inside& by) {
  const ContactSets& sets = plane.sets;
  if (sets.p.size() == 1 && sets.face_q >= 0)
    return over_face(q, sets.face_q, -Vec3(plane.normal), place(p, sets.p[0]), by.margin);
  if (sets.q.size() == 1 && sets.face_p >= 0)
    return over_face(p, sets.face_p, plane.normal, place(q, sets.q[0]), by.margin);
  return margin_of(p, q, plane, faces, by.rounding) >= by.margin;
}

}  // namespace

bool is_whole(const Solid& solid, int face, const VertexSet& set) {
  return face >= 0 && solid.topology().face_set(face).size() == set.size();
}

ProjectedPair::ProjectedPair(const Solid& solid_p, const Solid& solid_q, const Candidate& contact,
                             const VertexSet& set_p, const VertexSet& set_q, double length)
    : plane(solid_p.vertex(contact.support_p.vertex), contact.normal) {
  lay_set(solid_p, set_p, contact.sets.face_p, plane, 1.0, length, p);
  lay_set(solid_q, set_q, contact.sets.face_q, plane, -1.0, length, q);
}

void scan(const Solid& p, const Solid& q, const Vector3& normal, CandidatePlane& plane) {
  plane.normal = normal;
  const PairSupport both = support_pair(p, q, normal);
  plane.support_p = both.p;
  plane.support_q = both.q;
  plane.gap = normal.dot(q.vertex(both.q.vertex) - p.vertex(both.p.vertex));
}

void find_sets(const Solid& p, const Solid& q, const Lengths& length, CandidatePlane& plane) {
  plane.near_p.emplace().find(p, plane.normal, plane.support_p, length.widest);
  plane.near_q.emplace().find(q, -plane.normal, plane.support_q, length.widest);
  plane.near_p->select(length.rounding, plane.sets.p);
  plane.near_q->select(length.rounding, plane.sets.q);
  plane.sets.face_p = covered_face(p, plane.sets.p, plane.normal);
  plane.sets.face_q = covered_face(q, plane.sets.q, -plane.normal);
}

bool settle(const Solid& p, const Solid& q, const Lengths& length, const ContactSets& proposed,
            const Vector3& guess, CandidatePlane& plane) {
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

bool settle_normal(const Solid& p, const Solid& q, const Lengths& length, const Vector3& normal,
                   CandidatePlane& plane) {
  scan(p, q, normal, plane);
  find_sets(p, q, length, plane);
  ContactSets proposed;
  proposed.p = plane.sets.p;
  proposed.q = plane.sets.q;
  proposed.face_p = plane.sets.face_p;
  proposed.face_q = plane.sets.face_q;
  return settle(p, q, length, proposed, normal, plane);
}

bool lay_whole_faces(const Solid& p, const Solid& q, const Candidate& plane, const VertexSet& set_p,
                     const VertexSet& set_q, ContactPolygon& part) {
  part.face_p = plane.sets.face_p;
  part.face_q = plane.sets.face_q;
  if (!is_whole(p, part.face_p, set_p) || !is_whole(q, part.face_q, set_q)) return false;
  part.plane = ContactPlane(p.vertex(plane.support_p.vertex), plane.normal);
  lay_faces(p, q, plane.gap, part);
  return true;
}

bool lies_over(const Solid& p, const Solid& q, const Candidate& plane, const ContactPolygon* faces,
               double margin) {
  return plane.form.joined || lies_inside(p, q, plane, faces, {std::abs(margin), margin});
}

bool lies_firmly_over(const Solid& p, const Solid& q, const Candidate& plane,
                      const ContactPolygon* faces, const Lengths& length) {
  const double firm = kFirm * length.rounding;
  if (!plane.form.joined) return lies_inside(p, q, plane, faces, {length.rounding, firm});
  return joined_within(p, q, plane, length, plane.gap < 0.0 ? firm : length.rounding);
}

bool keeps_line(const Solid& p, const Solid& q, const Candidate& plane, const Lengths& length) {
  return !plane.form.joined || joined_within(p, q, plane, length, length.rounding);
}

bool proves_optimum(const Solid& p, const Solid& q, const Candidate& plane,
                    const ContactPolygon* faces, const Lengths& length) {
  const double rounding = length.rounding;
  if (clearly_apart(plane.gap, rounding)) return lies_firmly_over(p, q, plane, faces, length);
  const Vec3 inner = Vec3(q.vertex_mean()) - Vec3(p.vertex_mean());
  const double needed = shallow_margin(inner, plane.normal, plane.gap, rounding);
  return needed < kInfinity &&
         lies_inside(p, q, plane, faces, {rounding, std::max(needed, kFirm * rounding)});
}

bool straight_plane(const Solid& p, const Solid& q, const Lengths& length, const Vector3& guess,
                    Optimum& optimum) {
  CandidatePlane& plane = optimum.plane;
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
  if (lay_whole_faces(p, q, plane, plane.sets.p, plane.sets.q, optimum.faces.emplace()))
    optimum.faces->clear = clearly ? far_below : length.widest;
  else
    optimum.faces.reset();
  return true;
}

bool straight_answer(const Solid& p, const Solid& q, const Lengths& length, const Vector3& guess,
                     Optimum& optimum) {
  ++optimum.iterations;
  optimum.straight = straight_plane(p, q, length, guess, optimum) &&
                     proves_optimum(p, q, optimum.plane, optimum.laid(), length);
  if (!optimum.straight) optimum.faces.reset();
  return optimum.converged = optimum.straight;
}

double default_tolerance(const Body& a, const Body& b) {
  return default_tolerance(Solid(a, Vector3::Zero()), Solid(b, Vector3::Zero()));
}

bool carry_turned(const Solid& a, const Solid& b, const std::array<int, 2>& counts,
                  const Vector3& normal, const Turned& turned) {
  const double lift = turned.lift, least = std::max(lift, turned.contact - lift);
  const auto keeps = [&](const Solid& solid, const Vector3& outward, int count) {
    VertexSet near, sure;
    find_top(solid, outward, {turned.contact + lift, least}, near, sure);
    if (near.size() != sure.size() || sure.count() == count) return near.size() == sure.size();
    find_top(solid, outward, {lift, lift}, near, sure);
    return sure.count() == count;
  };
  return keeps(a, normal, counts[0]) && keeps(b, -normal, counts[1]);
}

}  // namespace quoin::geometry
