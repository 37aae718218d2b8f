#pragma once
/// Contact points of one pair: each a vertex on a face or two crossed edges, named for life by a
/// key.

#include <compare>
#include <quoin/geometry/contact_type.hpp>
#include <vector>

namespace quoin::geometry {

/// Names a contact point for life: two blocks (a < b) and one feature of each. Always vertex–face
/// (either side) or edge–edge.
struct ContactKey {
  int a = 0;
  int b = 0;
  Feature feature_a, feature_b;
  auto operator<=>(const ContactKey&) const = default;
};

/// Where the two places of a contact point are told.
enum class PointFrame : std::uint8_t {
  World,
  Bodies  ///< point_a in the frame of A's shape, point_b in that of B's: the material points. They
          ///< are right to the rounding of the two bodies, wherever these stand in the world.
};

struct ContactPoint {
  ContactKey key;
  ContactType type = ContactType::VertexFace;  ///< of the pair it belongs to
  bool indeterminate = false;         ///< the pair's contact plane is one choice of several
  int previous = -1;                  ///< ContactFinder, PairBatch: its index in their previous
                                      ///< list, -1: it was not there
  Vector3 point_a = Vector3::Zero();  ///< on A, m; ContactOptions::frame says in which frame
  Vector3 point_b = Vector3::Zero();  ///< on B, m
  Vector3 normal = Vector3::UnitX();  ///< the pair's: unit, from A to B
  double gap = 0.0;                   ///< (point_b - point_a)·normal, m, of places in the world
  double area = 0.0;                  ///< its share of the pair's contact polygon, m2
  Vector3 point() const { return 0.5 * (point_a + point_b); }  ///< of places in the world
};

/// Lengths that are negative or not finite: InputError, from every function that takes them.
struct ContactOptions {
  double tolerance = 0.0;  ///< contact length tol, m; 0: default_tolerance(a, b)
  double reach = 0.0;  ///< points are listed up to this gap above the least one (at least tol), m
  PointFrame frame = PointFrame::World;  ///< of the listed points; all else is in the world
  /// To which vertices are known, m: a vertex that far (at least tol) from an edge of a face may be
  /// on the face across, and is named by the one that leans least from the contact plane. The least
  /// gap has a point of its own only where it is less than those of the others by more than that.
  double coordinate_rounding = 0.0;
};

/// Adds the contact points of one pair, sorted by key, and returns its nearest features. `blocks`
/// are the names a and b in the keys. Here `options.reach` is the gap itself up to which points are
/// listed (and always those of touching and overlapping solids); when the least gap is larger there
/// are none. Coincident points are merged. The areas are the contact polygon's area shared out so
/// that equal pressure on the points has the same resultant, in size and place, as on the polygon.
/// No allocation once `contacts` has room.
NearestFeatures append_contacts_within_reach(const std::array<int, 2>& blocks, const Body& a,
                                             const Body& b, const ContactOptions& options,
                                             const FeatureHint& hint,
                                             std::vector<ContactPoint>& contacts);

/// All there is to know about one pair.
struct PairContact {
  NearestFeatures nearest;
  ContactType type = ContactType::VertexVertex;
  SupportSet support_a, support_b;   ///< the contact features, as vertices
  std::vector<ContactPoint> points;  ///< blocks named 0 and 1, sorted by key
  std::vector<Vector3> polygon;      ///< face-face: contact polygon, counter-clockwise seen against
                                     ///< the normal; edge-face, parallel edges: ends of the segment
  double area = 0.0;                 ///< of the polygon, m2; 0 unless face-face
};

/// Fills `contact`, whose memory is reused.
void update_pair_contact(const Body& a, const Body& b, const ContactOptions& options,
                         PairContact& contact);

/// For each contact of `now` the index of the same contact in `before`, or of the nearest one of
/// the same two blocks within `reach` that no key claims (a contact that slid over an edge), or -1.
/// Both lists sorted by key, places in the world.
std::vector<int> match_previous(const std::vector<ContactPoint>& now,
                                const std::vector<ContactPoint>& before, double reach = 0.0);
/// The same for lists that stand in records of the caller's: item i is at(owner, i).
struct ContactPointList {
  const void* owner = nullptr;
  std::size_t size = 0;
  const ContactPoint& (*at)(const void* owner, std::size_t i) = nullptr;
};
/// `match`: its memory is reused.
void match_previous(const ContactPointList& now, const ContactPointList& before, double reach,
                    std::vector<int>& match);

}  // namespace quoin::geometry
