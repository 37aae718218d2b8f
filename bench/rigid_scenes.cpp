#include "rigid_scenes.hpp"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <stdexcept>

namespace quoin::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

double friction_of(double angle_deg) { return std::tan(angle_deg * kDegree); }

Eigen::Quaterniond about(const Vector3d& axis, double angle_deg) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_deg * kDegree, axis));
}

}  // namespace

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

void turn(RigidScene& scene, const Eigen::Quaterniond& rotation) {
  for (RigidBody& body : scene.bodies) {
    body.place = rotation * body.place;
    body.turn = rotation * body.turn;
    body.force = rotation * body.force;
  }
}

RigidScene sliding_block(double friction_angle_deg, double dip_direction_deg) {
  RigidScene scene;
  scene.friction = friction_of(friction_angle_deg);
  scene.bodies.push_back(box({-5, -5, -1}, {60, 5, 0}, 0.0));
  scene.bodies.push_back(box({-0.5, -0.5, 0}, {0.5, 0.5, 1}, 2600));
  turn(scene, about(Vector3d::UnitZ(), dip_direction_deg) * about(Vector3d::UnitY(), 20.0));
  return scene;
}

RigidScene pushed_block() {
  RigidScene scene;
  scene.bodies.push_back(box({0, 0, -2.5}, {5, 3.5, 0}, 0.0));
  scene.bodies.push_back(box({0.5, 2, 0}, {1.5, 3, 1}, 2000));
  scene.bodies.back().force = {500, -250, 0};
  return scene;
}

RigidScene tower(int count) {
  RigidScene scene;
  scene.friction = friction_of(35.0);
  scene.bodies.push_back(box({-5, -5, -1}, {5, 5, 0}, 0.0));
  for (int i = 0; i < count; ++i) {
    scene.bodies.push_back(box({-0.5, -0.5, 1.0 * i}, {0.5, 0.5, i + 1.0}, 2600));
  }
  return scene;
}

RigidScene dominoes() {
  RigidScene scene;
  scene.friction = friction_of(10.0);
  scene.bodies.push_back(box({-5, -5, -1}, {10, 5, 0}, 0.0));
  for (int i = 0; i < 4; ++i) {
    scene.bodies.push_back(box({0.6 * i, 0, 0}, {0.6 * i + 0.3, 1, 1.5}, 2700));
  }
  // The first one about its lower edge at x = 0.3, past its balance at atan(0.3 / 1.5) = 11.31
  // degrees; at 11.54 degrees it would touch the second.
  RigidBody& first = scene.bodies[1];
  const Eigen::Quaterniond tilt = about(Vector3d::UnitY(), 11.4);
  const Vector3d edge(0.3, 0, 0);
  first.place = edge + tilt * (first.place - edge);
  first.turn = tilt;
  return scene;
}

RigidScene rocking_block() {
  RigidScene scene;
  scene.friction = friction_of(60.0);
  scene.bodies.push_back(box({-5, -5, -1}, {5, 5, 0}, 0.0));
  RigidBody block = box({-0.2, -0.2, 0}, {0.2, 0.2, 1.6}, 2600);
  const Eigen::Quaterniond tilt = about(Vector3d::UnitY(), 7.0);
  const Vector3d edge(0.2, 0, 0);
  block.place = edge + tilt * (block.place - edge);
  block.turn = tilt;
  scene.bodies.push_back(block);
  return scene;
}

RigidScene wall(int columns, int rows) {
  RigidScene scene;
  scene.friction = friction_of(35.0);
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

RigidScene arch(int count, double thickness_ratio) {
  RigidScene scene;
  scene.friction = friction_of(40.0);
  constexpr double radius = 10.0;
  const double half = 0.5 * thickness_ratio * radius;
  for (int i = 0; i < count; ++i) {
    Eigen::Matrix3Xd vertices(3, 8);
    for (int corner = 0; corner < 8; ++corner) {
      const double angle = std::numbers::pi * (i + (corner & 1)) / count;
      const double r = radius + ((corner & 2) != 0 ? half : -half);
      vertices.col(corner) =
          Vector3d(r * std::cos(angle), (corner & 4) != 0 ? 0.5 : -0.5, r * std::sin(angle));
    }
    scene.bodies.push_back(hull(vertices, 2500));
  }
  scene.bodies.push_back(box({-12, -2, -1}, {-8, 2, 0}, 0.0));
  scene.bodies.push_back(box({8, -2, -1}, {12, 2, 0}, 0.0));
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
