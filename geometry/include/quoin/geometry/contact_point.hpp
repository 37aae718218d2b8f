#pragma once
/// Contact points of one pair: each a vertex on a face or two crossed edges, named for life by a key.

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

struct ContactPoint {
  ContactKey key;
  ContactType type = ContactType::VertexFace;   ///< of the pair it belongs to
  bool indeterminate = false;                   ///< the pair's contact plane is one choice of several
  Vector3 point_a = Vector3::Zero();            ///< on A, m
  Vector3 point_b = Vector3::Zero();            ///< on B, m
  Vector3 normal = Vector3::UnitX();            ///< the pair's: unit, from A to B
  double gap = 0.0;                             ///< (point_b - point_a)·normal, m
  double area = 0.0;                            ///< its share of the pair's contact polygon, m2
  Vector3 point() const { return 0.5 * (point_a + point_b); }
};

/// For each contact of `now` the index of the same contact in `before`, or of the nearest one of the
/// same two blocks within `reach` that no key claims (a contact that slid over an edge), or -1.
/// Both lists sorted by key.
std::vector<int> match_previous(const std::vector<ContactPoint>& now,
                                const std::vector<ContactPoint>& before, double reach = 0.0);

}  // namespace quoin::geometry
