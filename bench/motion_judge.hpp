#pragma once
/// How well any code's motion keeps to contact and to the balances: from places and velocities
/// alone, with quoin's geometry.

#include <quoin/geometry/contact_finder.hpp>

#include "rigid_scenes.hpp"

namespace quoin::bench {

class MotionJudge {
 public:
  explicit MotionJudge(const RigidScene& scene);
  /// Looks at the bodies as they are now.
  void look(const World& world);

  double largest_overlap() const { return largest_overlap_; }  ///< of any two bodies so far, m
  /// Most that kinetic and potential energy less the work of moved bodies rose above its least so
  /// far, by the largest kinetic energy and the swing of the potential.
  double energy_growth() const;
  /// Largest change of momentum, or of angular momentum about the origin, from one look to the
  /// next, by the sum of its sizes over the bodies; means something where nothing but bodies acts
  /// on bodies.
  double momentum_error() const { return momentum_error_; }

 private:
  void look_at_places(const std::vector<BodyMotion>& motions);
  void look_at_energy(const std::vector<BodyMotion>& motions, double work);
  void look_at_momentum(const std::vector<BodyMotion>& motions);

  RigidScene scene_;
  geometry::ContactFinder finder_;
  std::vector<geometry::ContactPoint> points_;
  double largest_overlap_ = 0.0;
  double least_ = 0.0, growth_ = 0.0;
  double most_kinetic_ = 0.0, lowest_ = 0.0, highest_ = 0.0;
  Vector3d momentum_ = Vector3d::Zero(), angular_momentum_ = Vector3d::Zero();
  double momentum_error_ = 0.0;
  bool first_ = true;
};

}  // namespace quoin::bench
