#pragma once
/// A plane that may be the answer: what carries it, and whether it is proved to be the best.
/// Proposers name features or a normal; nothing else decides. Internal.

#include "certify/certificate.hpp"
#include "certify/feature_normal.hpp"
#include "numeric/late_init.hpp"
#include "polygon/projected_feature.hpp"

namespace quoin::geometry {

/// The vertices of one solid near its support plane, and how deep below it each lies.
struct NearVertices {
  VertexSet vertices;
  SmallVector<double, 32> depths;

  void find(const Solid& polyhedron, const Vector3& direction, const Support& top, double widest) {
    find_vertices_beyond(polyhedron, direction, top.value - widest, vertices);
    depths.clear();
    const Vec3 local = polyhedron.turned_back(direction);
    for (const int v : vertices)
      depths.push_back(top.value - dot(row_offset(polyhedron, v), local));
  }
  void select(double length, VertexSet& set) const {
    set.clear();
    for (std::size_t k = 0; k < vertices.size(); ++k)
      if (depths[k] <= length) set.push_back(vertices[k]);
  }
};

/// A plane between the solids: its normal, how far each reaches, what carries it.
struct Candidate {
  Vector3 normal = Vector3::UnitX();
  Support support_p, support_q;
  double gap = 0.0;    // m
  ContactSets sets;    // within rounding
  FeatureNormal form;  // of these sets
};

/// The two contact features laid into the contact plane.
struct ProjectedPair {
  ContactPlane plane;
  ProjectedFeature p, q;
  ProjectedPair(const Solid& solid_p, const Solid& solid_q, const Candidate& contact,
                const VertexSet& set_p, const VertexSet& set_q, double length);
};

/// The same with all vertices that come near it, where they were looked for.
struct CandidatePlane : Candidate {
  LateInit<NearVertices> near_p, near_q;
};

/// What is known in the end.
struct Optimum {
  CandidatePlane plane;
  bool several = false, middle = false;
  bool converged = false;
  bool straight = false;  // just the sets lie near the plane: `near_p`, `near_q` are not filled
  bool loose = false;     // the plane alone is proved: its sets need not lie over each other
  int iterations = 0;
  LateInit<ContactPolygon>& faces;  // where both features of a straight answer are whole faces
  explicit Optimum(LateInit<ContactPolygon>& shared) : faces(shared) {}
  const ContactPolygon* laid() const { return faces.get(); }
};

/// Is a set just the vertices of a face?
bool is_whole(const Solid& solid, int face, const VertexSet& set);

/// The candidate along a normal: how far both solids reach, and the gap.
void scan(const Solid& p, const Solid& q, const Vector3& normal, CandidatePlane& plane);

/// The vertices that come near a scanned plane, and the sets that carry it.
void find_sets(const Solid& p, const Solid& q, const Lengths& length, CandidatePlane& plane);

/// Takes the closed form of some sets for the plane; true when the same sets carry it, so that
/// another way to them comes to the same bits. Otherwise once more with the sets that do carry it.
bool settle(const Solid& p, const Solid& q, const Lengths& length, const ContactSets& proposed,
            const Vector3& guess, CandidatePlane& plane);

/// The same from a normal alone.
bool settle_normal(const Solid& p, const Solid& q, const Lengths& length, const Vector3& normal,
                   CandidatePlane& plane);

/// Lays two whole faces, if that is what the sets are.
bool lay_whole_faces(const Solid& p, const Solid& q, const Candidate& plane, const VertexSet& set_p,
                     const VertexSet& set_q, ContactPolygon& part);

/// Do the features that carry the plane lie over each other? Then the plane is a facet of the
/// Minkowski difference into which the origin projects (or the line between the features is
/// shortest). By more than `margin`, or off by less than -margin, m.
bool lies_over(const Solid& p, const Solid& q, const Candidate& plane, const ContactPolygon* faces,
               double margin);

/// The same, so clearly that no other plane is as good but in the same direction.
bool lies_firmly_over(const Solid& p, const Solid& q, const Candidate& plane,
                      const ContactPolygon* faces, const Lengths& length);

/// Is the plane not across a line between its features, or are its features the same however
/// rounding turns that line?
bool keeps_line(const Solid& p, const Solid& q, const Candidate& plane, const Lengths& length);

/// Proves that no other plane is better: always so when the solids are apart and the features lie
/// over each other, and for a shallow overlap.
bool proves_optimum(const Solid& p, const Solid& q, const Candidate& plane,
                    const ContactPolygon* faces, const Lengths& length);

/// The plane of the proposed sets, when they carry it alone and no vertex lies between 0.5 and 64
/// roundings below it: nothing is left to doubt but whether it is the best.
bool straight_plane(const Solid& p, const Solid& q, const Lengths& length, const Vector3& guess,
                    Optimum& optimum);

/// The plane of the proposed sets, if it is clearly theirs and proved to be the answer.
bool straight_answer(const Solid& p, const Solid& q, const Lengths& length, const Vector3& guess,
                     Optimum& optimum);

}  // namespace quoin::geometry
