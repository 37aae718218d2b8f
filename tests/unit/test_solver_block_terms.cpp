/// Terms of one block against quadrature and finite differences of their energies.

#include <cmath>
#include <quoin/geometry/build.hpp>

#include "solver/src/block/block_terms.hpp"
#include "support/catch.hpp"
#include "support/message.hpp"
#include "support/random.hpp"

using namespace quoin::solver;
using namespace quoin::tests;
namespace geometry = quoin::geometry;

namespace {

constexpr double kDensity = 2500.0;

Vector12 random_vector(Random& random, double size) {
  Vector12 v;
  for (double& x : v) x = random.uniform(-size, size);
  return v;
}

Block tetrahedron() {
  geometry::Points points(3, 4);
  points << 0, 2, 0.3, 0.4, 0, 0.1, 1.5, 0.2, 0, -0.2, 0.1, 1.0;
  Scene scene;
  scene.add_block(geometry::make_hull(points).polyhedron,
                  {.density = kDensity, .young = 3e9, .poisson = 0.2});
  return scene.blocks[0];
}

/// Integral of rho f over the tetrahedron by the 4-point rule, exact for quadratic f.
template <typename Function>
auto integral(const BlockModel& model, const Function& f) {
  const double near = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0, far = (5.0 - std::sqrt(5.0)) / 20.0;
  const auto weighted = [&](int i) {
    Vector3 x = Vector3::Zero();
    for (int v = 0; v < 4; ++v) x += (v == i ? near : far) * reference_arms(model).col(v);
    return f(x);
  };
  const double share = 0.25 * kDensity * model.volume;
  auto sum = weighted(0);
  for (int i = 1; i < 4; ++i) sum += weighted(i);
  sum *= share;
  return sum;
}

/// T(x) of [Beyabanaki 2009], equation (2), written out by itself.
Matrix3x12 first_order_motion(const Vector3& p) {
  const double x = p.x(), y = p.y(), z = p.z();
  Matrix3x12 t;
  t << 1, 0, 0, 0, z, -y, x, 0, 0, y / 2, 0, z / 2,  //
      0, 1, 0, -z, 0, x, 0, y, 0, x / 2, z / 2, 0,   //
      0, 0, 1, y, -x, 0, 0, 0, z, 0, y / 2, x / 2;
  return t;
}

/// Central differences of a function of 12 unknowns.
template <typename Function>
Vector12 gradient(const Function& f, const Vector12& at, double h) {
  Vector12 result;
  for (int i = 0; i < 12; ++i) {
    Vector12 step = Vector12::Zero();
    step[i] = h;
    result[i] = (f(Vector12(at + step)) - f(Vector12(at - step))) / (2 * h);
  }
  return result;
}

}  // namespace

TEST_CASE("The mass matrix is the integral of rho T^T T over the polyhedron") {
  const Block block = tetrahedron();
  const BlockModel model =
      make_block_model(block, reference_shape(*block.shape), Vector3::Zero(), 0);
  CHECK_THAT(model.mass, WithinRel(kDensity * model.volume, 1e-14));
  const double dt = 0.1;
  const Matrix12 exact = integral(model, [](const Vector3& x) -> Matrix12 {
    return first_order_motion(x).transpose() * first_order_motion(x);
  });
  Matrix12 k = block_matrix(model, {.time_step = dt, .end_share = 1.0});
  k.bottomRightCorner<6, 6>() -= model.volume * model.elasticity.matrix();
  k *= 0.5 * dt * dt;
  // What elasticity adds is large: its digits are lost in the difference.
  CHECK((k - exact).norm() < 1e-9 * exact.norm());
  CHECK((k.topLeftCorner<6, 6>() - exact.topLeftCorner<6, 6>()).norm() < 1e-13 * exact.norm());
}

TEST_CASE("Inertia: K D - F is the gradient of its energy, K its Hessian") {
  // rho |T D|^2 / dt^2 - 2 rho (T D).(T V) / dt over the block; theta = 0 leaves gyroscopic terms
  // out.
  Random random(5);
  const Block block = tetrahedron();
  BlockModel model = make_block_model(block, reference_shape(*block.shape), Vector3::Zero(), 0);
  model.elasticity = {};
  const StepScheme scheme{.time_step = 0.02, .end_share = 1.0};
  Vector12 velocity = random_vector(random, 1.0), d = random_vector(random, 0.01);
  d.segment<3>(3).setZero();
  BlockState state;
  state.velocity = velocity.head<3>();
  state.angular_velocity = velocity.segment<3>(3);
  state.strain_rate = velocity.tail<6>();
  const auto energy = [&](const Vector12& increment) {
    return integral(model, [&](const Vector3& x) {
      const Vector3 moved = first_order_motion(x) * increment;
      const Vector3 v = first_order_motion(x) * velocity;
      return moved.squaredNorm() / (scheme.time_step * scheme.time_step) -
             2.0 * moved.dot(v) / scheme.time_step;
    });
  };
  const Matrix12 k = block_matrix(model, scheme);
  const Vector12 analytic = k * d - block_force(model, state, scheme, d);
  const Vector12 numeric = gradient(energy, d, 1e-3);  // exact for a quadratic but for rounding
  CHECK((analytic - numeric).norm() < 1e-9 * numeric.norm());
  for (int i = 0; i < 12; ++i) {
    const Vector12 column = (gradient(energy, Vector12(Vector12::Unit(i)), 1e-2) -
                             gradient(energy, Vector12::Zero(), 1e-2));
    CHECK((k.col(i) - column).norm() < 1e-9 * k.norm());
  }
}

TEST_CASE("Elasticity and initial stress: gradient and Hessian of the strain energy") {
  Random random(6);
  Block block = tetrahedron();
  for (double& s : block.initial_stress) s = random.uniform(-1e6, 1e6);
  const BlockModel model =
      make_block_model(block, reference_shape(*block.shape), Vector3::Zero(), 0);
  BlockState state;
  state.strain = 1e-3 * random_vector(random, 1.0).tail<6>();
  const StepScheme scheme{.time_step = 1e6, .end_share = 1.0};  // inertia vanishes
  const Vector12 d = 1e-3 * random_vector(random, 1.0);
  const auto energy = [&](const Vector12& increment) {
    BlockState end = state;
    end.strain += increment.tail<6>();
    return strain_energy(model, end);
  };
  Vector12 strain_only = d;
  strain_only.head<6>().setZero();
  const Matrix12 k = block_matrix(model, scheme);
  const Vector12 analytic = k * strain_only - block_force(model, state, scheme, Vector12::Zero());
  const Vector12 numeric = gradient(energy, strain_only, 1e-4);
  CHECK((analytic - numeric).tail<6>().norm() < 1e-8 * numeric.norm());
  for (int i = 6; i < 12; ++i) {
    const Vector12 column = gradient(energy, Vector12(1e-3 * Vector12::Unit(i)), 1e-4) -
                            gradient(energy, Vector12::Zero(), 1e-4);
    CHECK((1e-3 * k.col(i) - column).tail<6>().norm() < 1e-8 * 1e-3 * k.norm());
  }
  // Half of it in the scheme with forces at the middle of the step.
  const Matrix12 half = block_matrix(model, {.time_step = 1e6, .end_share = 0.5});
  CHECK((2.0 * half.bottomRightCorner<6, 6>() - k.bottomRightCorner<6, 6>()).norm() <
        1e-8 * k.norm());
}

TEST_CASE("Isotropic elasticity gives Young's modulus, Poisson's ratio and the shear modulus") {
  const auto e = isotropic_elasticity(5e9, 0.25);
  Vector6 strain = Vector6::Zero();
  strain << 1e-3, -0.25e-3, -0.25e-3, 2e-3, 0, 0;
  const Vector6 stress = e * strain;
  CHECK_THAT(stress[0], WithinRel(5e6, 1e-12));
  CHECK_THAT(stress[1], WithinAbs(0.0, 1e-6));
  CHECK_THAT(stress[3], WithinRel(2e9 * 2e-3, 1e-12));
}

TEST_CASE("Kinetic energy is that of the points") {
  Random random(7);
  const Block block = tetrahedron();
  const BlockModel model =
      make_block_model(block, reference_shape(*block.shape), Vector3::Zero(), 0);
  const Vector12 v = random_vector(random, 2.0);
  BlockState state;
  state.velocity = v.head<3>();
  state.angular_velocity = v.segment<3>(3);
  state.strain_rate = v.tail<6>();
  const double exact = integral(
      model, [&](const Vector3& x) { return 0.5 * (first_order_motion(x) * v).squaredNorm(); });
  CHECK_THAT(kinetic_energy(model, state), WithinRel(exact, 1e-12));
}

TEST_CASE("A material that cannot be worked with is refused by name") {
  Block block = tetrahedron();
  block.name = "keystone";
  const auto made = [&] {
    make_block_model(block, reference_shape(*block.shape), Vector3::Zero(), 7);
  };
  CHECK(message(made).empty());
  block.material.density = 0.0;
  CHECK_THAT(message(made),
             ContainsSubstring("block 7 (keystone)") && ContainsSubstring("density"));
  block.material = {.density = kDensity, .young = 0.0};
  CHECK_THAT(message(made), ContainsSubstring("Young"));
  block.material = {.density = kDensity, .young = 1e9, .poisson = 0.5};
  CHECK_THAT(message(made), ContainsSubstring("Poisson"));
  block.material = {.density = std::nan(""), .young = 1e9};
  CHECK_THAT(message(made), ContainsSubstring("density"));
}
