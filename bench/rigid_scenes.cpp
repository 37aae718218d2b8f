#include "rigid_scenes.hpp"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <stdexcept>

namespace quoin::bench {

RigidBody box(const Vector3d& min, const Vector3d& max, double density) {
  RigidBody body;
  body.place = 0.5 * (min + max);
  body.half_size = 0.5 * (max - min);
  body.density = density;
  body.mass = density * (max - min).prod();
  const Vector3d squares = (max - min).cwiseAbs2();
  body.inertia = (body.mass / 12.0) *
                 (Vector3d::Constant(squares.sum()) - squares).asDiagonal().toDenseMatrix();
  return body;
}

RigidBody hull(const Eigen::Matrix3Xd& vertices, double density) {
  const geometry::Shape shape = geometry::make_hull(vertices).polyhedron;
  const geometry::MassProperties properties = geometry::mass_properties(shape);
  RigidBody body;
  body.place = properties.centroid;
  body.vertices = vertices.colwise() - properties.centroid;
  body.density = density;
  body.mass = density * properties.volume;
  const Eigen::Matrix3d& second = properties.second_moment;
  body.inertia = density * (second.trace() * Eigen::Matrix3d::Identity() - second);
  return body;
}

RigidScene wall(int columns, int rows) {
  RigidScene scene;
  scene.friction = std::tan(35.0 * std::numbers::pi / 180.0);
  constexpr double length = 0.4, height = 0.2;
  scene.bodies.push_back(box({-2, -2, -1}, {length * columns + 2, 2, 0}, 0.0));
  for (int row = 0; row < rows; ++row) {
    const bool shifted = row % 2 == 1;
    const int count = columns + (shifted ? 1 : 0);
    for (int i = 0; i < count; ++i) {
      const double from = shifted ? std::max(0.0, length * (i - 0.5)) : length * i;
      const double to = shifted ? std::min(length * columns, length * (i + 0.5)) : length * (i + 1);
      scene.bodies.push_back(box({from, 0, height * row}, {to, 0.2, height * (row + 1)}, 2000));
    }
  }
  return scene;
}

void MovedBody::advance(const RigidScene& scene, double time, double time_step) {
  const auto& acceleration = scene.bodies[static_cast<std::size_t>(body)].acceleration;
  const Vector3d before = velocity;
  velocity += time_step * acceleration(time + 0.5 * time_step);
  mean_velocity = 0.5 * (before + velocity);
  place += time_step * mean_velocity;
}

std::vector<MovedBody> moved_bodies(const RigidScene& scene) {
  std::vector<MovedBody> moved;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (!scene.bodies[i].acceleration) continue;
    moved.push_back({.body = static_cast<int>(i), .place = scene.bodies[i].place});
  }
  return moved;
}

Contestant contestant(const std::string& code) {
  const auto colon = code.find(':');
  const std::string name = code.substr(0, colon);
  const int sweeps = colon == std::string::npos ? 0 : std::atoi(code.c_str() + colon + 1);
  const std::string count = std::to_string(sweeps);
  if (name == "quoin") return {"quoin", make_quoin};
#ifdef QUOIN_BENCH_BULLET
  if (name == "bullet") return {"Bullet SI " + count, make_bullet, sweeps};
#endif
#ifdef QUOIN_BENCH_ODE
  if (name == "ode") return {sweeps > 0 ? "ODE quick " + count : "ODE step", make_ode, sweeps};
#endif
  throw std::invalid_argument("no code " + code);
}

std::vector<Contestant> peers() {
  std::vector<Contestant> all;
#ifdef QUOIN_BENCH_BULLET
  all.push_back({"Bullet SI 50", make_bullet, 50});
  all.push_back({"Bullet NNCG 100", make_bullet_nncg, 100});
#endif
#ifdef QUOIN_BENCH_ODE
  all.push_back({"ODE step", make_ode, 0});
  all.push_back({"ODE quick 50", make_ode, 50});
#endif
  return all;
}

}  // namespace quoin::bench
