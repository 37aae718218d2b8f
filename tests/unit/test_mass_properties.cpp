/// Volume, centroid, second moments against closed forms, near the origin and far from it.

#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>

#include "referee/pairs/families.hpp"
#include "support/catch.hpp"

namespace {

using namespace quoin::geometry;
using namespace quoin::referee;
using namespace quoin::tests;

}  // namespace

TEST_CASE("mass properties: a box") {
  const MassProperties box = mass_properties(make_box({1, 2, 3}, {2, 4, 6}));
  CHECK_THAT(box.volume, WithinRel(6.0, 1e-15));
  CHECK_THAT((box.centroid - Vector3(1.5, 3, 4.5)).norm(), WithinAbs(0.0, 1e-15));
  const Vector3 exact = 6.0 / 12.0 * Vector3(1, 4, 9);
  CHECK_THAT((box.second_moment - Matrix3(exact.asDiagonal())).norm(), WithinAbs(0.0, 1e-14));
}

TEST_CASE("mass properties: a tetrahedron") {
  Points corners(3, 4);
  corners << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  const MassProperties solid = mass_properties(make_hull(corners).polyhedron);
  CHECK_THAT(solid.volume, WithinRel(1.0 / 6.0, 1e-15));
  CHECK_THAT((solid.centroid - Vector3::Constant(0.25)).norm(), WithinAbs(0.0, 1e-16));
  CHECK_THAT(solid.second_moment(0, 0), WithinRel(1.0 / 160.0, 1e-13));   // 3/80 of the volume
  CHECK_THAT(solid.second_moment(0, 1), WithinRel(-1.0 / 480.0, 1e-13));  // -1/80 of the volume
}

TEST_CASE("mass properties: turned, and 1e8 m from the origin") {
  Random random(5);
  const Shape box = make_box({-1, -1.5, -0.25}, {1, 1.5, 0.25});
  const Matrix3 turn = random.rotation();
  const Vector3 shift(0x1p27, -0x1p26, 0x1p27);
  const MassProperties near = mass_properties(transformed(box, 1.0, turn, Vector3::Zero()));
  const Vector3 exact = 3.0 / 12.0 * Vector3(4, 9, 0.25);
  const Matrix3 turned = turn * exact.asDiagonal() * turn.transpose();
  CHECK_THAT((near.second_moment - turned).norm(), WithinAbs(0.0, 1e-14));
  const MassProperties far = mass_properties(transformed(box, 1.0, Matrix3::Identity(), shift));
  CHECK(far.volume == 3.0);
  CHECK(far.centroid == shift);
}
