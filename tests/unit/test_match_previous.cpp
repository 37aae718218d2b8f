#include <quoin/geometry/contact_point.hpp>

#include "support/catch.hpp"

namespace {

using namespace quoin::geometry;

/// Vertex `vertex` of block a on face `face` of block b, at x.
ContactPoint contact(int a, int b, int vertex, int face, double x) {
  ContactPoint point;
  point.key = {a, b, {FeatureKind::Vertex, vertex}, {FeatureKind::Face, face}};
  point.point_a = point.point_b = Vector3(x, 0, 0);
  return point;
}

}  // namespace

TEST_CASE("match_previous: the same key is the same contact however far it went") {
  const std::vector<ContactPoint> before{contact(0, 1, 0, 2, 0.0), contact(0, 1, 3, 2, 1.0),
                                         contact(0, 2, 0, 0, 0.0)};
  const std::vector<ContactPoint> now{contact(0, 1, 3, 2, 50.0), contact(0, 2, 0, 0, 0.0),
                                      contact(1, 2, 0, 0, 0.0)};
  CHECK(match_previous(now, before) == std::vector<int>{1, 2, -1});
  CHECK(match_previous({}, before).empty());
  CHECK(match_previous(now, {}) == std::vector<int>{-1, -1, -1});
}

TEST_CASE(
    "match_previous: over an edge the nearest unclaimed contact of the same blocks hands on") {
  const std::vector<ContactPoint> before{contact(0, 1, 0, 2, 0.0), contact(0, 1, 1, 2, 1.0)};
  const std::vector<ContactPoint> now{contact(0, 1, 0, 3, 0.01), contact(0, 1, 1, 3, 0.98)};
  CHECK(match_previous(now, before, 0.1) == std::vector<int>{0, 1});
  CHECK(match_previous(now, before, 0.015) == std::vector<int>{0, -1});
  CHECK(match_previous(now, before) == std::vector<int>{-1, -1});
}

TEST_CASE("match_previous: one to one, the nearest pair first, and keys before nearness") {
  // both of now are near the first of before; the nearer one gets it
  const std::vector<ContactPoint> before{contact(0, 1, 0, 2, 0.0)};
  const std::vector<ContactPoint> now{contact(0, 1, 0, 3, 0.05), contact(0, 1, 1, 3, 0.01)};
  CHECK(match_previous(now, before, 0.1) == std::vector<int>{-1, 0});
  // a contact that still has its key is not given away
  const std::vector<ContactPoint> keeps{contact(0, 1, 0, 2, 0.0), contact(0, 1, 0, 3, 0.0)};
  CHECK(match_previous(keeps, before, 0.1) == std::vector<int>{0, -1});
  // equal distances: the first of both
  const std::vector<ContactPoint> two{contact(0, 1, 5, 2, -0.01), contact(0, 1, 6, 2, 0.01)};
  const std::vector<ContactPoint> one{contact(0, 1, 0, 3, 0.0)};
  CHECK(match_previous(one, two, 0.1) == std::vector<int>{0});
}

TEST_CASE("match_previous: history never goes to other blocks") {
  const std::vector<ContactPoint> before{contact(0, 1, 0, 2, 0.0), contact(0, 3, 0, 2, 0.0)};
  const std::vector<ContactPoint> now{contact(0, 2, 0, 2, 0.0), contact(1, 3, 0, 2, 0.0)};
  CHECK(match_previous(now, before, 1.0) == std::vector<int>{-1, -1});
}

TEST_CASE("match_previous: a contact at NaN inherits nothing") {
  const std::vector<ContactPoint> before{contact(0, 1, 0, 2, 0.0)};
  const std::vector<ContactPoint> now{contact(0, 1, 1, 2, std::nan(""))};
  CHECK(match_previous(now, before, 1.0) == std::vector<int>{-1});
}
