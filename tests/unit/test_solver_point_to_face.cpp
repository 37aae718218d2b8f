/// Every energy of the source's point-to-face contact against finite differences of its definition,
/// and action against reaction.

#include "solver/src/source_method/point_to_face.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using namespace quoin::tests;

namespace {

constexpr double kStep =
    1e-4;  // quadratic energies: central differences are exact but for rounding
constexpr double kSame = 1e-6;

Vector12 random_vector(Random& random) {
  Vector12 v;
  for (double& x : v) x = random.uniform(-1, 1);
  return v;
}

Vector3 random_point(Random& random) { return random_vector(random).head<3>(); }

/// T(x) of the source, equation (1), about a centroid.
Matrix3x12 source_motion(const Vector3& centroid, const Vector3& point) {
  const Vector3 d = point - centroid;
  const double x = d.x(), y = d.y(), z = d.z();
  Matrix3x12 t;
  t << 1, 0, 0, 0, z, -y, x, 0, 0, y / 2, 0, z / 2,  //
      0, 1, 0, -z, 0, x, 0, y, 0, x / 2, z / 2, 0,   //
      0, 0, 1, y, -x, 0, 0, 0, z, 0, y / 2, x / 2;
  return t;
}

/// A point of one block before a point of the other, far from both centroids.
struct Setting {
  Vector3 centroid_i, centroid_j, p1, p0;
  PointToFace contact;

  explicit Setting(Random& random)
      : centroid_i(random_point(random)),
        centroid_j(random_point(random)),
        p1(random_point(random)),
        p0(random_point(random)) {
    contact.normal = random_point(random).normalized();
    contact.between = p1 - p0;
    contact.motion_i = source_motion(centroid_i, p1);
    contact.motion_j = source_motion(centroid_j, p0);
  }
  /// P0'P1' from the moved points themselves.
  Vector3 between(const Vector12& d_i, const Vector12& d_j) const {
    return p1 + source_motion(centroid_i, p1) * d_i - p0 - source_motion(centroid_j, p0) * d_j;
  }
};

using Vector24 = Eigen::Matrix<double, 24, 1>;
using Matrix24 = Eigen::Matrix<double, 24, 24>;

template <class Energy>
double at(const Energy& energy, const Vector24& d) {
  return energy(Vector12(d.head<12>()), Vector12(d.tail<12>()));
}

/// Minus the gradient and the Hessian of an energy at D = 0, by central differences.
template <class Energy>
void differentiate(const Energy& energy, Vector24& force, Matrix24& stiffness) {
  const auto unit = [](int k) { return Vector24(kStep * Vector24::Unit(k)); };
  for (int r = 0; r < 24; ++r) {
    force[r] = -(at(energy, unit(r)) - at(energy, -unit(r))) / (2 * kStep);
    for (int s = 0; s < 24; ++s) {
      stiffness(r, s) = (at(energy, unit(r) + unit(s)) - at(energy, unit(r) - unit(s)) -
                         at(energy, unit(s) - unit(r)) + at(energy, -unit(r) - unit(s))) /
                        (4 * kStep * kStep);
    }
  }
}

template <class Energy>
void check(const Energy& energy, const ContactBlocks& blocks) {
  Vector24 force;
  Matrix24 stiffness;
  differentiate(energy, force, stiffness);
  CHECK((force.head<12>() - blocks.force.i).norm() < kSame * (1 + force.norm()));
  CHECK((force.tail<12>() - blocks.force.j).norm() < kSame * (1 + force.norm()));
  CHECK((stiffness.topLeftCorner<12, 12>() - blocks.ii).norm() < kSame * (1 + stiffness.norm()));
  CHECK((stiffness.topRightCorner<12, 12>() - blocks.ij).norm() < kSame * (1 + stiffness.norm()));
  CHECK((stiffness.bottomLeftCorner<12, 12>() - blocks.ij.transpose()).norm() <
        kSame * (1 + stiffness.norm()));
  CHECK((stiffness.bottomRightCorner<12, 12>() - blocks.jj).norm() <
        kSame * (1 + stiffness.norm()));
}

}  // namespace

TEST_CASE("Normal spring with multiplier: blocks are derivatives of lambda d_n + Pn d_n^2 / 2") {
  Random random(5);
  for (int i = 0; i < 10; ++i) {
    const Setting s(random);
    const double stiffness = random.uniform(0.1, 3), multiplier = random.uniform(-2, 2);
    const auto energy = [&](const Vector12& d_i, const Vector12& d_j) {
      const double gap = s.contact.normal.dot(s.between(d_i, d_j));
      return multiplier * gap + 0.5 * stiffness * gap * gap;
    };
    check(energy, normal_blocks(s.contact, stiffness, multiplier));
    // An update of the multiplier changes the force by its part alone.
    const ContactBlocks without = normal_blocks(s.contact, stiffness, 0.0);
    const ContactForces part = multiplier_forces(s.contact, multiplier);
    const ContactBlocks with = normal_blocks(s.contact, stiffness, multiplier);
    CHECK((without.force.i + part.i - with.force.i).norm() < 1e-12);
    CHECK((without.force.j + part.j - with.force.j).norm() < 1e-12);
  }
}

TEST_CASE("Shear spring: blocks are derivatives of Ps (|P0'P1'|^2 - d_n^2) / 2") {
  Random random(6);
  for (int i = 0; i < 10; ++i) {
    const Setting s(random);
    const double stiffness = random.uniform(0.1, 3);
    const auto energy = [&](const Vector12& d_i, const Vector12& d_j) {
      const Vector3 between = s.between(d_i, d_j);
      const double gap = s.contact.normal.dot(between);
      return 0.5 * stiffness * (between.squaredNorm() - gap * gap);
    };
    check(energy, shear_blocks(s.contact, stiffness));
  }
}

TEST_CASE("Friction: forces are derivatives of F d.L/|L|, and it has no stiffness") {
  Random random(7);
  for (int i = 0; i < 10; ++i) {
    const Setting s(random);
    const double friction = random.uniform(0.1, 3);
    const Vector3 direction = random_point(random).normalized();
    const auto energy = [&](const Vector12& d_i, const Vector12& d_j) {
      return friction * direction.dot(s.between(d_i, d_j) - s.contact.between);
    };
    ContactBlocks blocks;
    blocks.force = friction_forces(s.contact, friction, direction);
    check(energy, blocks);
  }
}

TEST_CASE("Forces on both blocks are equal and opposite and turn nothing when the points meet") {
  Random random(8);
  for (int i = 0; i < 10; ++i) {
    Setting s(random);
    s.p0 = s.p1;
    s.contact.motion_j = source_motion(s.centroid_j, s.p0);
    s.contact.between = 0.3 * s.contact.normal;
    ContactForces sum = normal_blocks(s.contact, 2.0, -1.0).force;
    const ContactForces shear = friction_forces(s.contact, 0.7, random_point(random).normalized());
    sum.i += shear.i;
    sum.j += shear.j;
    CHECK((sum.i.head<3>() + sum.j.head<3>()).norm() < 1e-13);
    const Vector3 moment = sum.i.segment<3>(3) + s.centroid_i.cross(Vector3(sum.i.head<3>())) +
                           sum.j.segment<3>(3) + s.centroid_j.cross(Vector3(sum.j.head<3>()));
    CHECK(moment.norm() < 1e-12);
  }
}
