#pragma once
/// Solids that touch with two whole faces, the ordinary contact of masonry: answer and contact
/// points in straight code. Private to the room.

#include <quoin/geometry/contact_point.hpp>

#include "ordinary.hpp"
#include "shared_part.hpp"

namespace quoin::geometry {

/// Does a face look at the other solid? One steeper than 30 degrees does not.
bool looks_along(const Polyhedron& solid, int face, const Vector3& outward);

/// Are two whole faces all there is within the band?
bool faces_alone(const Polyhedron& p, const Polyhedron& q, const SharedPart& part, double band);

/// Are the shared corners the contact points as they are: no gap above `highest`, one at most
/// `least`, none within `tolerance` of another? m
bool need_no_second_look(const SharedPart& part, double highest, double least, double tolerance);

/// Adds the contact points of two solids whose contact features are two whole faces, beyond doubt,
/// and fills the answer. False: nothing was added; ask the general way, which comes to the same bits
/// where this one does. `hint`: its faces are tried; where it is empty those that look at each other,
/// if there are such, which are named in it then.
bool append_flush_contacts(const std::array<int, 2>& blocks, const Polyhedron& a,
                           const Polyhedron& b, const ContactOptions& options, FeatureHint& hint,
                           NearestFeatures& answer, std::vector<ContactPoint>& contacts);

}  // namespace quoin::geometry
