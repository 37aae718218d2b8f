#pragma once
/// A reference of a scene file against what its monitor shows, step after step; whoever steps.

#include "scene_file/scene_file.hpp"

namespace quoin::scene_file {

/// What a monitor shows now. Displacements and rotations count from the start of the first dynamic
/// stage (of the run, where there is none).
struct MonitorValue {
  Vector3 displacement = Vector3::Zero();      ///< m
  Vector3 velocity = Vector3::Zero();          ///< m/s
  Vector3 rotation = Vector3::Zero();          ///< rotation vector, rad
  Vector3 angular_velocity = Vector3::Zero();  ///< world axes, rad/s
  Vector3 force =
      Vector3::Zero();  ///< of contacts: on Monitor::blocks; of fixed points: on their blocks, N
  double normal_force = 0.0;         ///< of contacts: sum, N
  Vector3 moment = Vector3::Zero();  ///< of contacts: of `force`, about Monitor::about, N m
  /// Of contacts: mean place of the normal forces, m, in the world; NaN where nothing presses.
  Vector3 centre_of_pressure = Vector3::Zero();
  Vector3 momentum = Vector3::Zero();          ///< of a group, N s
  Vector3 angular_momentum = Vector3::Zero();  ///< of a group about its centre of mass, N m s
  /// Of a group: mean by volume over its deformable blocks, NaN where it has none; (xx, yy, zz, xy,
  /// yz, zx), world axes; tension positive, Pa; strain since the start of the run, shear as gamma.
  solver::Vector6 stress = solver::Vector6::Zero(), strain = solver::Vector6::Zero();
};

struct ReferenceResult {
  double error = 0.0;  ///< largest difference / largest exact value (or absolute where that is 0)
  double error_end = 0.0;            ///< the same for the last time it was compared
  Eigen::VectorXd value{}, exact{};  ///< when it was last compared
  long compared = 0;                 ///< steps
  bool ok = true;                    ///< compared, a number, and not above what is allowed
};

/// One reference, compared at the steps within its time; it must outlive this.
class Comparison {
 public:
  explicit Comparison(const Reference& reference) : reference_(reference) {}

  /// time: s since the start of the first dynamic stage.
  void compare(double time, const MonitorValue& monitor);
  ReferenceResult result() const;

  template <class Archive>
  void transfer(Archive& archive) {
    archive(result_.value, result_.exact, result_.compared, largest_difference_, last_difference_,
            largest_exact_);
  }

 private:
  Eigen::VectorXd quantity(const MonitorValue& monitor) const;

  const Reference& reference_;
  ReferenceResult result_;
  double largest_difference_ = 0.0, last_difference_ = 0.0, largest_exact_ = 0.0;
};

}  // namespace quoin::scene_file
