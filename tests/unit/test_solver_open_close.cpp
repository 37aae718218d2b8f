/// Contact forces of a linearised step: gradient and Hessian of the contact energies, Coulomb's
/// law.

#include <cmath>

#include "solver/src/iteration/open_close.hpp"
#include "support/catch.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using namespace quoin::tests;

namespace {

/// Two deformable blocks and contacts between them and to the ground, all numbers drawn.
struct Problem {
  Slots slots = make_slots({12, 12}, {1.0, 1.0});
  BlockSystem base;
  BlockVector force, increment;
  std::vector<LinearContact> contacts;

  Problem(Random& random, int count, ContactLaw law, bool compliant) {
    base.diagonal.resize(2, 12);
    for (std::size_t b = 0; b < 2; ++b) {
      Matrix12 root;
      for (double& x : root.reshaped()) x = random.uniform(-1, 1);
      base.diagonal[b] = 1e4 * (root * root.transpose() + Matrix12::Identity());
      Vector12 f;
      for (double& x : f) x = random.uniform(-100, 100);
      force.push_back(f);
    }
    base.pairs = {{0, 1}};
    base.off_diagonal.resize(1, 12);
    increment.assign(2, Vector12::Zero());
    for (int i = 0; i < count; ++i) {
      LinearContact c;
      c.slot_b = i % 2;
      if (i % 3 == 0) {
        c.slot_a = 0;
        c.slot_b = 1;
        c.pair = 0;
      }
      c.law = law;
      c.compliant = compliant;
      const auto draw = [&](ContactJacobian& jacobian) {
        Matrix3x12 all;
        for (double& x : all.reshaped()) x = random.uniform(-1, 1);
        jacobian.set(all, true);
      };
      if (c.slot_a >= 0) draw(c.jacobian_a);
      draw(c.jacobian_b);
      c.offset = Vector3(random.uniform(-1e-3, 1e-3), 0, 0);
      c.friction = law == ContactLaw::Coulomb ? 0.5 : 0.0;
      c.normal_stiffness = compliant ? 1e5 : 1e9;
      c.shear_stiffness = compliant ? 5e4 : 1e9;
      contacts.push_back(c);
    }
  }

  OpenCloseResult solve(double tolerance) {
    OpenClose solver(slots);
    return solver.solve(base, force, contacts, {.force_tolerance = tolerance}, increment);
  }

  Vector3 relative(const LinearContact& c, const BlockVector& d) const {
    Vector3 result = c.offset;
    if (c.slot_a >= 0) result += c.jacobian_a * d[static_cast<std::size_t>(c.slot_a)];
    if (c.slot_b >= 0) result += c.jacobian_b * d[static_cast<std::size_t>(c.slot_b)];
    return result;
  }
};

/// 1/2 p min(d_n, 0)^2 + 1/2 p_s |d_t|^2 while closed: [Beyabanaki 2009], equations (29) and (42).
double spring_energy(const LinearContact& c, const Vector3& d) {
  if (c.law == ContactLaw::Bilateral) {
    return 0.5 * c.normal_stiffness * d[0] * d[0] +
           0.5 * c.shear_stiffness * d.tail<2>().squaredNorm();
  }
  if (d[0] >= 0.0) return 0.0;
  const double normal = 0.5 * c.normal_stiffness * d[0] * d[0];
  const bool rough = c.law == ContactLaw::Stuck;
  return normal + (rough ? 0.5 * c.shear_stiffness * d.tail<2>().squaredNorm() : 0.0);
}

OpenCloseResult solved(Problem& p, double tolerance) {
  const OpenCloseResult result = p.solve(tolerance);
  REQUIRE(result.converged);
  return result;
}

double energy(const Problem& p, const BlockVector& d) {
  double sum = 0.0;
  for (std::size_t s = 0; s < d.size(); ++s)
    sum += 0.5 * d[s].dot(p.base.diagonal[s] * d[s]) - p.force[s].dot(d[s]);
  for (const LinearContact& c : p.contacts) sum += spring_energy(c, p.relative(c, d));
  return sum;
}

}  // namespace

TEST_CASE("Springs: the solution is where the gradient of the total energy vanishes") {
  Random random(21);
  for (const ContactLaw law : {ContactLaw::Frictionless, ContactLaw::Bilateral}) {
    for (int i = 0; i < 20; ++i) {
      Problem p(random, 6, law, true);
      solved(p, 1e-12);
      const double h = 1e-6;
      for (std::size_t s = 0; s < 2; ++s) {
        for (int k = 0; k < 12; ++k) {
          BlockVector low = p.increment, high = p.increment;
          low[s][k] -= h;
          high[s][k] += h;
          const double slope = (energy(p, high) - energy(p, low)) / (2 * h);
          CHECK_THAT(slope, WithinAbs(0.0, 1e-5));  // forces are of the order of 100
        }
      }
    }
  }
}

TEST_CASE("Springs that stay closed are one linear solve: the Hessian is exact") {
  Random random(22);
  for (int i = 0; i < 20; ++i) {
    Problem p(random, 6, ContactLaw::Bilateral, true);
    CHECK(solved(p, 1e-10).solves == 1);
  }
}

TEST_CASE("Exact contacts: no overlap, no tension, forces where the gap is closed") {
  Random random(23);
  for (int i = 0; i < 50; ++i) {
    Problem p(random, 5, ContactLaw::Frictionless, false);
    solved(p, 1e-11);
    for (const LinearContact& c : p.contacts) {
      const Vector3 d = p.relative(c, p.increment);
      CHECK(c.force[0] >= 0.0);
      CHECK(d[0] > -1e-10);
      CHECK(std::abs(c.force[0] * d[0]) < 1e-7);  // N m; forces of 100 N, gaps of 1e-3 m
      CHECK(c.force.tail<2>().norm() == 0.0);
    }
  }
}

TEST_CASE("Coulomb's law holds at every contact of the converged step") {
  Random random(24);
  int slipping = 0, sticking = 0;
  for (int i = 0; i < 50; ++i) {
    Problem p(random, 4, ContactLaw::Coulomb, false);
    const OpenCloseResult result = p.solve(1e-11);
    if (!result.converged) continue;  // drawn Jacobians may have no solution with friction
    for (const LinearContact& c : p.contacts) {
      const Vector3 d = p.relative(c, p.increment);
      const double shear = c.force.tail<2>().norm();
      CHECK(c.force[0] >= 0.0);
      CHECK(shear <= 0.5 * c.force[0] + 1e-6);
      if (c.mode == ContactMode::Slip && c.force[0] > 1e-3) {
        ++slipping;
        CHECK(c.force.tail<2>().dot(d.tail<2>()) <= 1e-12);
        CHECK_THAT(shear, WithinRel(0.5 * c.force[0], 1e-6));
      } else if (c.mode == ContactMode::Stick) {
        ++sticking;
        CHECK(d.tail<2>().norm() < 1e-9);
      }
    }
  }
  CHECK(slipping > 10);
  CHECK(sticking > 3);
}

TEST_CASE("Forces on both blocks of the solution balance: K D = F + J^T f") {
  Random random(25);
  Problem p(random, 5, ContactLaw::Frictionless, false);
  solved(p, 1e-11);
  for (std::size_t s = 0; s < 2; ++s) {
    Vector12 left = p.force[s] - p.base.diagonal[s] * p.increment[s];
    for (const LinearContact& c : p.contacts) {
      if (c.slot_a == static_cast<int>(s)) left += c.jacobian_a.push(c.force);
      if (c.slot_b == static_cast<int>(s)) left += c.jacobian_b.push(c.force);
    }
    CHECK(left.norm() < 1e-7);
  }
}
