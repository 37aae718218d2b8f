/// Many blocks that move at once: a pile that falls into a bin, walls, dry and with mortar, whose
/// base is shaken, a tower whose base is pulled away. Judged by what holds for any motion: no
/// overlap, no energy out of nothing; and the tower by its closed form.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <quoin/geometry/build.hpp>

#include "stability/cell.hpp"

namespace quoin::stability {
namespace {

constexpr double kDensity = 2000.0;  // kg/m3
constexpr double kDrums = 0.5;       // m, height of both

/// What a row varies, at its usual value.
struct Crowd {
  double young = 0.0;  ///< Pa; 0: rigid
  double time_step = 5e-3;
  double friction_deg = 30.0;
  solver::Joint joint{};  ///< but for its friction
};

/// A scene under way, with the worst that was seen of it.
class CrowdRun {
 public:
  explicit CrowdRun(const Crowd& crowd) : crowd_(crowd) {
    scene_.joint = crowd.joint;
    scene_.joint.friction_angle = radians(crowd.friction_deg);
  }
  int add(const Vector3& min, const Vector3& max) {
    smallest_ = std::min(smallest_, (max - min).minCoeff());
    weight_ += kDensity * kGravity * (max - min).prod();
    const geometry::Shape shape = geometry::make_box(min, max);
    return crowd_.young > 0.0
               ? scene_.add_block(shape,
                                  {.density = kDensity, .young = crowd_.young, .poisson = 0.2})
               : scene_.add_rigid(shape, {.density = kDensity});
  }
  void add_fixed(const Vector3& min, const Vector3& max) {
    scene_.add_fixed(geometry::make_box(min, max));
  }
  void add_base(const Vector3& min, const Vector3& max,
                const std::function<Vector3(double)>& acceleration) {
    add_fixed(min, max);
    scene_.blocks.back().kind = solver::BlockKind::Prescribed;
    scene_.blocks.back().motion = {solver::MotionKind::Acceleration, acceleration};
  }
  solver::Scene& scene() { return scene_; }
  double smallest() const { return smallest_; }

  /// The larger of the largest overlap by the thinnest block, and the most that mechanical energy
  /// less work rose above its least so far, by the largest kinetic energy and the swing of the
  /// rest.
  double go(Run& run, double time) {
    double least = 0.0, low = 0.0, high = 0.0, kinetic = 0.0, growth = 0.0, overlap = 0.0;
    const long steps = std::lround(time / crowd_.time_step);
    for (long i = 0; i <= steps && run.evidence.unconverged == 0; ++i) {
      if (i > 0) run.steps(1);
      const solver::State& state = run.simulation().state();
      const solver::EnergyLedger& energy = state.energy;
      const double now = energy.mechanical() - energy.work;
      const double rest = energy.mechanical() - energy.kinetic;
      least = i == 0 ? now : std::min(least, now);
      low = i == 0 ? rest : std::min(low, rest);
      high = i == 0 ? rest : std::max(high, rest);
      kinetic = std::max(kinetic, energy.kinetic);
      growth = std::max(growth, now - least);
      for (const solver::Contact& contact : state.contacts) {
        overlap = std::max(overlap, -contact.point.gap);
      }
    }
    const double noise = weight_ * solver::StepOptions{}.tolerance * smallest_;
    return std::max(overlap / smallest_, growth > noise ? growth / (kinetic + high - low) : 0.0);
  }

 private:
  Crowd crowd_;
  solver::Scene scene_;
  double smallest_ = std::numeric_limits<double>::infinity(), weight_ = 0.0;  // m, N
};

/// The part after the point of k times the golden ratio: sizes that differ, the same everywhere.
double scattered(int k) { return std::fmod(k * std::numbers::phi, 1.0); }

/// Eight turning boxes of 0.4 to 0.7 m in two layers fall into a bin; none leaves it.
Result run_pile(const Crowd& crowd) {
  CrowdRun crowd_run(crowd);
  crowd_run.add_fixed({-2, -2, -0.5}, {2, 2, 0});
  for (const double side : {-1.0, 1.0}) {
    crowd_run.add_fixed({std::min(side, 2 * side), -2, 0}, {std::max(side, 2 * side), 2, 4});
    crowd_run.add_fixed({-1, std::min(side, 2 * side), 0}, {1, std::max(side, 2 * side), 4});
  }
  for (int i = 0; i < 8; ++i) {
    const Vector3 middle(i % 2 - 0.5, i / 2 % 2 - 0.5, 0.7 + i / 4);
    const Vector3 half =
        0.5 * Vector3(0.4 + 0.3 * scattered(3 * i), 0.4 + 0.3 * scattered(3 * i + 1),
                      0.4 + 0.3 * scattered(3 * i + 2));
    solver::Block& block =
        crowd_run.scene()
            .blocks[static_cast<std::size_t>(crowd_run.add(middle - half, middle + half))];
    block.angular_velocity = 6.0 * Vector3(scattered(5 * i) - 0.5, scattered(5 * i + 2) - 0.5,
                                           scattered(5 * i + 4) - 0.5);
  }
  Run run(crowd_run.scene(), {.time_step = crowd.time_step});
  Result result{crowd_run.go(run, 1.0), {}};
  for (int b = 5; b < 13; ++b) {
    const Vector3 place = run.place(b);
    if (!(place.head<2>().cwiseAbs().maxCoeff() < 1.0 && place.z() > 0.0)) result.error = 1.0;
  }
  result.evidence = run.evidence;
  return result;
}

/// Bricks in running bond, `columns` long and `rows` high; the base is shaken across the wall by
/// `peak` of g at 2 Hz. Without mortar 0.5 is twice what it takes to rock.
struct Shaking {
  double peak = 0.5, duration = 0.2;  // g, s
  int columns = 2, rows = 4;
};

Result run_shaken_wall(const Crowd& crowd, const Shaking& shaking) {
  CrowdRun crowd_run(crowd);
  crowd_run.add_base({-2, -2, -1}, {3, 2, 0}, [peak = shaking.peak](double time) {
    return Vector3(0, peak * kGravity * std::cos(4.0 * std::numbers::pi * time), 0);
  });
  constexpr double length = 0.375, height = 0.1875;  // m; all corners are exact
  for (int row = 0; row < shaking.rows; ++row) {
    const double shift = 0.5 * length * (row % 2), low = height * row;
    for (int i = 0; i < shaking.columns + row % 2; ++i) {
      crowd_run.add(
          {std::max(0.0, length * i - shift), 0, low},
          {std::min(shaking.columns * length, length * (i + 1) - shift), height, low + height});
    }
  }
  Run run(crowd_run.scene(), {.time_step = crowd.time_step});
  const double error = crowd_run.go(run, shaking.duration);
  return {error, run.evidence};
}

/// A wall of 27 bricks that rocks. Where a step takes more than 150 solves in the mean the error is
/// 1: regularised contacts take 30 to 70, exact ones alone 230 to 580, or find no solution.
Result run_rocking_wall(const Crowd& crowd, double peak) {
  constexpr double kMostSolves = 150.0;
  Result result = run_shaken_wall(crowd, {.peak = peak, .duration = 0.35, .columns = 4, .rows = 6});
  const Evidence& evidence = result.evidence;
  const double solves = static_cast<double>(evidence.solves) / static_cast<double>(evidence.steps);
  if (!(solves <= kMostSolves)) result.error = 1.0;
  return result;
}

/// Two drums on a base that is pulled away by 0.8 g. They do not topple: their centre of mass lags
/// behind it by the friction that there is, or not at all. The error is relative to the base's way.
Result run_pulled_base(const Crowd& crowd) {
  constexpr double pull = 0.8 * kGravity, time = 0.3;
  CrowdRun crowd_run(crowd);
  crowd_run.add_base({0, 0, 0}, {1, 1, 0.5}, [=](double) { return Vector3(pull, 0, 0); });
  crowd_run.add({0, 0, 0.5}, {1, 1, 0.5 + 0.5 * kDrums});
  crowd_run.add({0, 0, 0.5 + 0.5 * kDrums}, {1, 1, 0.5 + kDrums});
  Run run(crowd_run.scene(), {.time_step = crowd.time_step});
  run.rest(1.0);
  const auto middle = [&] { return Vector3(0.5 * (run.place(1) + run.place(2))); };
  const Vector3 start = middle();
  const double error = crowd_run.go(run, time);
  const double acceleration = std::min(pull, kGravity * std::tan(radians(crowd.friction_deg)));
  const Vector3 way(0.5 * acceleration * time * time, 0, 0);
  const double off = (middle() - start - way).norm();
  return {std::max(error, off / (0.5 * pull * time * time)), run.evidence};
}

}  // namespace

void append_moving_cells(std::vector<Cell>& cells) {
  constexpr double kBalances = 1e-5;  // ten times what a single sub-step is flagged for
  const auto append = [&](const char* varied, double value, const Crowd& crowd) {
    // Ten times the strain of the drums under the pull: how far elastic blocks may sway.
    const double sway =
        1e-6 + (crowd.young > 0.0 ? 10.0 * kDensity * kGravity * kDrums / crowd.young : 0.0);
    cells.push_back({"pile", {{varied, value}}, kBalances, [=] { return run_pile(crowd); }});
    cells.push_back(
        {"shaken wall", {{varied, value}}, kBalances, [=] { return run_shaken_wall(crowd, {}); }});
    cells.push_back(
        {"pulled base", {{varied, value}}, sway, [=] { return run_pulled_base(crowd); }});
  };
  for (int exponent = 8; exponent <= 12; ++exponent) {
    const double young = std::pow(10.0, exponent);
    append("young", young, {.young = young});
  }
  for (const double step : {1e-3, 2e-3, 5e-3, 1e-2}) {
    append("time_step", step, {.time_step = step});
  }
  for (const double angle : {0.0, 10.0, 20.0, 45.0}) {
    append("friction_deg", angle, {.friction_deg = angle});
  }
  for (const double peak : {0.5, 1.0}) {
    for (const double angle : {20.0, 30.0, 35.0, 40.0, 45.0, 50.0}) {
      const Crowd crowd{.friction_deg = angle};
      cells.push_back({"rocking wall", {{"friction_deg", angle}, {"peak", peak}}, kBalances, [=] {
                         return run_rocking_wall(crowd, peak);
                       }});
    }
  }
  for (int exponent = 3; exponent <= 6; ++exponent) {
    const double cohesion = std::pow(10.0, exponent);
    const auto append_mortar = [&](const char* name, const solver::Joint& joint) {
      const Crowd crowd{.joint = joint};
      cells.push_back({name, {{"cohesion", cohesion}}, kBalances, [=] {
                         return run_shaken_wall(crowd, {.peak = 1.0, .duration = 0.5});
                       }});
    };
    const solver::Joint brittle{.cohesion = cohesion, .tension = 0.5 * cohesion};
    solver::Joint residual = brittle, softening = brittle;
    residual.residual_cohesion = 0.3 * cohesion;
    softening.softening_slip = 1e-3;
    append_mortar("mortar wall, brittle", brittle);
    append_mortar("mortar wall, residual", residual);
    append_mortar("mortar wall, softening", softening);
    append_mortar("mortar wall, tension", {.tension = 0.5 * cohesion});
  }
}

}  // namespace quoin::stability
