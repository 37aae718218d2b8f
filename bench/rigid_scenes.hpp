#pragma once
/// Scenes as plain data that every code can read: rigid convex bodies on a fixed one.

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace quoin::bench {

using Eigen::Vector3d;

/// A rigid convex body, SI. A box where `half_size` is positive, else the hull of `vertices`.
struct RigidBody {
  Vector3d place = Vector3d::Zero();  ///< of the centroid
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Vector3d half_size = Vector3d::Zero();
  Eigen::Matrix3Xd vertices{};  ///< relative to the centroid, before `turn`
  double density = 0.0;         ///< 0: fixed
  double mass = 0.0;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();              ///< body axes
  Vector3d force = Vector3d::Zero();                              ///< through the centroid, N
  Vector3d velocity = Vector3d::Zero(), spin = Vector3d::Zero();  ///< at the start, m/s, rad/s
  /// Of a body of density 0 that is moved, from rest, at a time in s; m/s2. Empty: it is fixed.
  std::function<Vector3d(double)> acceleration{};
};

struct RigidScene {
  std::vector<RigidBody> bodies{};
  double friction = 0.0;                  ///< coefficient
  std::optional<double> held_friction{};  ///< on bodies of density 0, where it is another one
  Vector3d gravity{0, 0, -9.81};
};

RigidBody box(const Vector3d& min, const Vector3d& max, double density);
RigidBody hull(const Eigen::Matrix3Xd& vertices, double density);
/// Rows of `columns` whole bricks and rows of columns - 1 whole and two half ones take turns.
RigidScene wall(int columns, int rows);

/// Position and velocity of a body, world frame.
struct BodyMotion {
  Vector3d place, velocity, spin;
  Eigen::Quaterniond turn;
};

/// What a step left between two bodies (several entries may name the same two).
struct PairForce {
  int a = 0, b = 0;                  ///< a < b
  double normal = 0.0;               ///< N, sum
  Vector3d on_b = Vector3d::Zero();  ///< the same as a vector, friction left out, N
};

/// A moved body's way, each step with the acceleration of its middle.
struct MovedBody {
  int body = 0;
  Vector3d place = Vector3d::Zero(), velocity = Vector3d::Zero();  ///< at the end of the step
  Vector3d mean_velocity = Vector3d::Zero();                       ///< of the step, m/s

  void advance(const RigidScene& scene, double time, double time_step);
};
std::vector<MovedBody> moved_bodies(const RigidScene& scene);

/// A code that steps a scene.
class World {
 public:
  virtual ~World() = default;
  virtual bool step(double time_step) = 0;  ///< false: it gave up
  /// Asked within long steps by codes that can: false ends the step as if it had not begun.
  virtual void watch(std::function<bool()> /*goes_on*/) {}
  virtual BodyMotion motion(int body) const = 0;
  virtual std::vector<PairForce> forces() const = 0;
  virtual double work() const = 0;                   ///< of moved bodies on the others so far, J
  virtual long factorizations() const { return 0; }  ///< so far, where it counts them
};

/// A contestant: a code with its settings.
struct Contestant {
  std::string name;
  std::unique_ptr<World> (*make)(const RigidScene&, double time_step, int iterations);
  int iterations = 0;
};

/// The peers that were there at configure time.
std::vector<Contestant> peers();

/// By its word: quoin, bullet:SWEEPS, ode:SWEEPS, ode:0 (its direct solver). Throws
/// std::invalid_argument where there is none.
Contestant contestant(const std::string& code);

std::unique_ptr<World> make_quoin(const RigidScene& scene, double time_step, int iterations);
#ifdef QUOIN_BENCH_BULLET
std::unique_ptr<World> make_bullet(const RigidScene& scene, double time_step, int iterations);
std::unique_ptr<World> make_bullet_nncg(const RigidScene& scene, double time_step, int iterations);
#endif
#ifdef QUOIN_BENCH_ODE
std::unique_ptr<World> make_ode(const RigidScene& scene, double time_step, int iterations);
#endif

}  // namespace quoin::bench
