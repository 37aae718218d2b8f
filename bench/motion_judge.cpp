#include "motion_judge.hpp"

#include <algorithm>
#include <memory>
#include <quoin/geometry/build.hpp>

namespace quoin::bench {
namespace {

bool is_free(const RigidBody& body) { return body.density > 0.0; }

std::shared_ptr<const geometry::Shape> shape_of(const RigidBody& body) {
  return std::make_shared<const geometry::Shape>(
      body.half_size.x() > 0.0 ? geometry::make_box(-body.half_size, body.half_size)
                               : geometry::make_hull(body.vertices).polyhedron);
}

geometry::Placement placement(const Vector3d& place, const Eigen::Quaterniond& turn) {
  return {turn.toRotationMatrix(), place};
}

/// About the body's centroid.
Vector3d own_angular_momentum(const RigidBody& body, const BodyMotion& motion) {
  return motion.turn * (body.inertia * (motion.turn.conjugate() * motion.spin));
}

}  // namespace

MotionJudge::MotionJudge(const RigidScene& scene) : scene_(scene), finder_({}) {
  for (const RigidBody& body : scene_.bodies) {
    finder_.add(
        shape_of(body), placement(body.place, body.turn),
        {.motion = is_free(body) ? geometry::BodyMotion::Moving : geometry::BodyMotion::Idle});
  }
}

void MotionJudge::look(const World& world) {
  std::vector<BodyMotion> motions;
  for (int body = 0; body < finder_.size(); ++body) motions.push_back(world.motion(body));
  look_at_places(motions);
  look_at_energy(motions, world.work());
  look_at_momentum(motions);
  first_ = false;
}

double MotionJudge::energy_growth() const {
  const double scale = most_kinetic_ + highest_ - lowest_;
  return scale > 0.0 ? growth_ / scale : 0.0;
}

void MotionJudge::look_at_places(const std::vector<BodyMotion>& motions) {
  for (std::size_t i = 0; i < motions.size(); ++i)
    finder_.move(static_cast<int>(i), placement(motions[i].place, motions[i].turn));
  finder_.find(points_);
  for (const geometry::ContactPoint& point : points_)
    largest_overlap_ = std::max(largest_overlap_, -point.gap);
}

void MotionJudge::look_at_energy(const std::vector<BodyMotion>& motions, double work) {
  double kinetic = 0.0, potential = 0.0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const RigidBody& body = scene_.bodies[i];
    if (!is_free(body)) continue;
    const BodyMotion& motion = motions[i];
    kinetic += 0.5 * body.mass * motion.velocity.squaredNorm() +
               0.5 * motion.spin.dot(own_angular_momentum(body, motion));
    potential -= (body.mass * scene_.gravity + body.force).dot(motion.place - body.place);
  }
  const double energy = kinetic + potential - work;
  least_ = first_ ? energy : std::min(least_, energy);
  growth_ = std::max(growth_, energy - least_);
  most_kinetic_ = std::max(most_kinetic_, kinetic);
  lowest_ = std::min(lowest_, potential);
  highest_ = std::max(highest_, potential);
}

void MotionJudge::look_at_momentum(const std::vector<BodyMotion>& motions) {
  Vector3d momentum = Vector3d::Zero(), angular_momentum = Vector3d::Zero();
  double size = 0.0, angular_size = 0.0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const RigidBody& body = scene_.bodies[i];
    if (!is_free(body)) continue;
    const Vector3d own = body.mass * motions[i].velocity;
    const Vector3d turning = motions[i].place.cross(own) + own_angular_momentum(body, motions[i]);
    momentum += own;
    angular_momentum += turning;
    size += own.norm();
    angular_size += turning.norm();
  }
  if (!first_ && size > 0.0) {
    momentum_error_ = std::max({momentum_error_, (momentum - momentum_).norm() / size,
                                (angular_momentum - angular_momentum_).norm() / angular_size});
  }
  momentum_ = momentum;
  angular_momentum_ = angular_momentum;
}

}  // namespace quoin::bench
