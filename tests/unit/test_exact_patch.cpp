/// The exact patch against closed forms, and the judge of contact points against answers that are
/// spoilt on purpose, one thing at a time.

#include <functional>
#include <quoin/geometry/build.hpp>

#include "support/catch.hpp"
#include "support/check_contact.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::tests;

const Vector3 kUp = Vector3::UnitZ();
constexpr double kQuarter = 0.78539816339744831;

Points box(const Vector3& min, const Vector3& max) { return make_box(min, max).vertices(); }

Points moved(const Points& points, const Matrix3& turn, const Vector3& shift) {
  return (turn * points).colwise() + shift;
}

ExactPatch patch_of(const Points& a, const Points& b) {
  return exact_patch(ExactPair({a, {}}, {b, {}}), kUp, {1e-9, 1e-15, 1e-16});
}

/// What is said of a right answer after `spoil`.
std::vector<std::string> kinds_after(const quoin::tests::SolidPair& pair,
                                     const std::function<void(PairContact&)>& spoil) {
  const Trial trial(pair);
  PairContact contact = trial.query.contact();
  spoil(contact);
  Faults faults;
  check_contact(trial, contact, faults);
  std::vector<std::string> kinds;
  for (const Fault& fault : faults.list) kinds.push_back(fault.kind);
  return kinds;
}

std::vector<std::string> kinds_after(const std::function<void(PairContact&)>& spoil) {
  return kinds_after({"", make_box({0, 0, 0}, {1, 1, 1}), make_box({0.5, 0.25, 1}, {1.5, 1.25, 2})},
                     spoil);
}

bool finds(const char* kind, const std::function<void(PairContact&)>& spoil) {
  const std::vector<std::string> kinds = kinds_after(spoil);
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

}  // namespace

TEST_CASE("exact patch: types, corners, area") {
  const Points cube = box({0, 0, 0}, {1, 1, 1});
  const Matrix3 one = Matrix3::Identity();
  const ExactPatch half = patch_of(cube, moved(cube, one, {0.5, 0.25, 1}));
  CHECK(half.type == ContactType::FaceFace);
  CHECK(half.clear);
  CHECK(half.corners.size() == 4);
  CHECK_THAT(static_cast<double>(half.area), WithinAbs(0.375, 1e-15));

  const Points roof = moved(box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}),
                            rotation_about(Vector3::UnitX(), kQuarter), Vector3::Zero());
  const double top = roof.row(2).maxCoeff();
  const ExactPatch ridge =
      patch_of(moved(roof, one, {0.5, 0.5, 1 - top}), moved(cube, one, {0.25, 0, 1}));
  CHECK(ridge.type == ContactType::EdgeFace);
  CHECK(ridge.corners.size() == 2);
  CHECK(ridge.area == 0);
  const Points flipped = moved(roof, rotation_about(kUp, 2 * kQuarter), {0, 0, 2 * top});
  CHECK(patch_of(roof, flipped).type == ContactType::EdgeEdgeCrossing);
  const ExactPatch lines = patch_of(roof, moved(roof, one, {0.25, 0, 2 * top}));
  CHECK(lines.type == ContactType::EdgeEdgeParallel);
  CHECK(lines.corners.size() == 2);

  const Points tip = (Points(3, 4) << 0.5, 0, 1, 0.5, 0.5, 0, 0, 1, 1, 2, 2, 2).finished();
  CHECK(patch_of(cube, tip).type == ContactType::VertexFace);
}

TEST_CASE("exact patch: edges whose lines cross beyond an end share nothing") {
  const auto shared = [](double end_a, double end_b) {
    // Edges along x: on 1 m B's rises by 0.8 tol and comes 0.7 tol nearer to A's, whose line it
    // crosses there. In space that is an angle of more than tol, in the plane of less.
    Points below(3, 4), above(3, 4);
    below << 0, end_a, 0.2, 0.2, 0, 0, 1, -1, 0, 0, -1, -1;
    above << 0, end_b, 0.2, 0.2, 0.7e-9, 0.7e-9 * (1 - end_b), 1, -1, 0, 0.8e-9 * end_b, 1, 1;
    const ExactPatch patch = patch_of(below, above);
    CHECK(patch.clear);
    CHECK(patch.type == ContactType::EdgeEdgeCrossing);
    return patch.corners.size();
  };
  CHECK(shared(1.0, 1.0) == 1);
  CHECK(shared(1.2, 1.2) == 1);
  CHECK(shared(0.99, 1.2) == 0);
  CHECK(shared(1.2, 0.99) == 0);
}

TEST_CASE("exact patch: a height or an angle near tol is not clear") {
  const Points cube = box({0, 0, 0}, {1, 1, 1});
  for (const double tilt : {0.999e-9, 1.001e-9}) {
    const Points above = moved(cube, rotation_about(Vector3::UnitY(), -tilt), {0, 0, 1});
    CHECK(patch_of(cube, above).clear);
    CHECK(patch_of(cube, above).type ==
          (tilt < 1e-9 ? ContactType::FaceFace : ContactType::EdgeFace));
    CHECK_FALSE(exact_patch(ExactPair({cube, {}}, {above, {}}), kUp, {1e-9, 1e-11, 0}).clear);
  }
}

TEST_CASE("exact patch: a point between vertices is none") {
  const double fall = 3e-9;  // three times tol; a quarter of it is exact
  Points tilted(3, 9);
  tilted << 0, 0, 1, 1, 0, 0, 1, 1, 0.25, 0, 1, 0, 1, 0, 1, 0, 1, 0, 0, 0, -fall, -fall, -1, -1, -1,
      -1, -fall / 4;
  CHECK_FALSE(ExactPair({tilted, {}}, {tilted, {}}).is_vertex(0, 8));
  CHECK(ExactPair({tilted, {}}, {tilted, {}}).is_vertex(1, 3));
  const ExactPatch edge = patch_of(tilted, box({-1, -1, 0}, {2, 2, 1}));
  CHECK(edge.type == ContactType::EdgeFace);
  CHECK(edge.support_vertices == 6);
  tilted(2, 8) += 1e-12;  // now it stands out
  CHECK(patch_of(tilted, box({-1, -1, 0}, {2, 2, 1})).type == ContactType::FaceFace);
}

TEST_CASE("exact patch: parallel edges beside each other share a place while their roofs do") {
  const double tolerance = 1e-9;
  const auto reach = [&](double slope, double beside) {
    Points below(3, 4), above(3, 4);
    below << 0, 1, 0, 0, 0, 0, 1, -1, 0, 0, -slope, -slope;
    above << 0, 1, 1, 1, beside, beside, 1, -1, 0, 0, slope, slope;
    const ExactPair pair({below, {}}, {above, {}});
    return both_reach(pair, kUp, {.place = quoin::tests::PlaneFrame(kUp).place(pair.places(0)[0])},
                      tolerance, 1e-15);
  };
  CHECK(reach(1.0, 0.0));
  CHECK(reach(1.0, 0.8e-9));  // half-way, over no vertex
  CHECK_FALSE(reach(1.5, 0.8e-9));
  CHECK_FALSE(reach(1e3, 0.8e-9));
}

TEST_CASE("exact patch: a corner beside the end of a side that tol cuts through a face") {
  const double tolerance = 1e-9, fall = 4 * tolerance;
  // The top falls towards one corner of the square: tol leaves the triangle of the other three.
  Points falling = box({0, 0, -1}, {1, 1, 0});
  for (int v = 0; v < 8; ++v)
    if (falling(0, v) == 1 && falling(1, v) == 1) falling(2, v) -= fall;
  const Points above = box({-1, 3e-9, 0}, {2, 2, 1});
  const auto cut_corners = [&](const Points& below) {
    const ExactPair pair({below, {}}, {above, {}});
    const ExactPatch patch = exact_patch(pair, kUp, {tolerance, 1e-15, 1e-16});
    return std::count_if(patch.corners.begin(), patch.corners.end(), [&](const auto& corner) {
      return ends_at(pair, kUp, corner, tolerance, 1.0) &&
             lies_on_cut(pair, kUp, corner, tolerance, 1.0);
    });
  };
  CHECK(cut_corners(falling) == 1);  // where the diagonal enters the other solid
  CHECK(cut_corners(box({0, 0, -1}, {1, 1, 0})) == 0);
}

TEST_CASE("judge of contact points: a right answer passes, a spoilt one does not") {
  CHECK(kinds_after([](PairContact&) {}).empty());
  CHECK(finds("missing corner", [](PairContact& c) { c.points.pop_back(); }));
  CHECK(finds("no points", [](PairContact& c) { c.points.clear(); }));
  CHECK(finds("area", [](PairContact& c) { c.points[0].area *= 1.001; }));
  CHECK(finds("area", [](PairContact& c) { c.area *= 0.5; }));
  CHECK(finds("moment", [](PairContact& c) {
    c.points[0].area += 0.01;
    c.points[3].area -= 0.01;
  }));
  CHECK(finds("type", [](PairContact& c) { c.type = ContactType::EdgeFace; }));
  CHECK(finds("polygon", [](PairContact& c) { c.polygon.pop_back(); }));
  CHECK(finds("polygon", [](PairContact& c) { c.polygon[0].x() += 1e-12; }));
  CHECK(finds("point gap", [](PairContact& c) { c.points[0].gap += 1e-12; }));
  CHECK(finds("point gap", [](PairContact& c) { c.points[0].point_a.x() -= 1e-12; }));
  CHECK(finds("point off by less than tol",
              [](PairContact& c) { c.points[0].point_a.z() += 1e-12; }));
  CHECK(finds("point", [](PairContact& c) { c.points[0].point_b.z() -= 1e-6; }));
  for (const double off : {1e-12, 1e-6}) {
    CHECK(finds(off < 1e-9 ? "least gap off by less than tol" : "least gap missing",
                [off](PairContact& c) {
                  for (ContactPoint& point : c.points) point.gap += off;
                }));
  }
  CHECK(finds("point out of reach", [](PairContact& c) { c.points[0].gap = 1e-6; }));
  CHECK(finds("point below least gap", [](PairContact& c) { c.points[0].gap = -1e-12; }));
  CHECK(finds("point order", [](PairContact& c) { std::swap(c.points[0], c.points[1]); }));
  CHECK(finds("point name", [](PairContact& c) { c.points[0].key.feature_a.index = 99; }));
  CHECK(finds("point normal", [](PairContact& c) { c.points[0].normal.x() = 1e-16; }));
  CHECK(finds("many points", [](PairContact& c) { c.points.resize(17, c.points[0]); }));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(finds("point not finite", [nan](PairContact& c) { c.points[0].gap = nan; }));
  CHECK(finds("area", [nan](PairContact& c) { c.area = nan; }));
  CHECK(finds("polygon", [nan](PairContact& c) { c.polygon[0].x() = nan; }));
}

TEST_CASE("judge of contact points: half a segment is none") {
  const auto halve = [](PairContact& c) {
    REQUIRE(c.polygon.size() == 2);
    const Vector3 middle = 0.5 * (c.polygon[0] + c.polygon[1]);
    for (Vector3& end : c.polygon) end = 0.5 * (end + middle);
  };
  // A ridge of 1 m below one of 2 m, and below a plate.
  Points ridge(3, 6), hung(3, 6);
  ridge << 0, 0, 0, 1, 1, 1, 0, -1, 1, 0, -1, 1, 0, -1, -1, 0, -1, -1;
  hung << -0.5, -0.5, -0.5, 1.5, 1.5, 1.5, 0, -1, 1, 0, -1, 1, 0, 1, 1, 0, 1, 1;
  for (const Points& above : {hung, box({-1, -1, 0}, {2, 1, 1})}) {
    const quoin::tests::SolidPair pair{"", make_hull(ridge).polyhedron,
                                       make_hull(above).polyhedron};
    CHECK(kinds_after(pair, [](PairContact&) {}).empty());
    const std::vector<std::string> kinds = kinds_after(pair, halve);
    CHECK(std::find(kinds.begin(), kinds.end(), "polygon") != kinds.end());
  }
}
