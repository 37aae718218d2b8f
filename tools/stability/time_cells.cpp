/// Time step, speed and length of run.

#include <algorithm>
#include <cmath>
#include <limits>

#include <quoin/geometry/build.hpp>

#include "stability/cell.hpp"

namespace quoin::stability {
namespace {

/// A cube flies at a fixed wall, restitution 0, no gravity: it ends in touch with it. Error
/// relative to the way gone (to the block where that is shorter).
Result run_at_wall(double speed, double thickness, double aside) {
  solver::Scene scene;
  scene.gravity = Vector3(Vector3::Zero());
  scene.add_fixed(geometry::make_box({0, -1e4, -1e4}, {thickness, 1e4, 1e4}));
  scene.add_rigid(geometry::make_box({-3.3, 0, 0}, {-2.3, 1, 1}), {.density = 2500});
  scene.blocks[1].velocity = Vector3(speed, aside * speed, 0);
  const double dt = 0.01;
  Run run(std::move(scene), {.time_step = dt});
  run.steps(static_cast<long>(std::ceil(2.5 / (speed * dt))) + 3);
  const double front = run.place(1).x() + 0.5;
  const double way = (run.place(1) - Vector3(-2.8, 0.5, 0.5)).norm();
  return {std::abs(front) / std::max(1.0, way), run.evidence};
}

/// A small cube flies at a free one of the same mass: momentum, and the first stays behind the
/// second.
Result run_at_block(double speed) {
  solver::Scene scene;
  scene.gravity = Vector3(Vector3::Zero());
  scene.add_rigid(geometry::make_box({-0.73, -0.05, -0.05}, {-0.63, 0.05, 0.05}),
                  {.density = 2500});
  scene.add_rigid(geometry::make_box({0, -0.05, -0.05}, {0.1, 0.05, 0.05}), {.density = 2500});
  scene.blocks[0].velocity = Vector3(speed, 0, 0);
  const double dt = 0.01;
  Run run(std::move(scene), {.time_step = dt});
  run.steps(static_cast<long>(std::ceil(0.63 / (speed * dt))) + 3);
  const auto& blocks = run.simulation().state().blocks;
  const double passed = std::max(0.0, 0.1 - (run.place(1).x() - run.place(0).x()));
  const double momentum =
      (blocks[0].velocity + blocks[1].velocity - Vector3(speed, 0, 0)).norm() / speed;
  const double apart = (blocks[0].velocity - blocks[1].velocity).norm() / speed;
  return {std::max({passed / 0.1, momentum, apart}), run.evidence};
}

/// A free body spinning about no principal axis: its angular momentum and energy stay.
Result run_spin(long steps, double time_step) {
  solver::Scene scene;
  scene.gravity = Vector3(Vector3::Zero());
  scene.add_rigid(geometry::make_box({-0.5, -1, -1.5}, {0.5, 1, 1.5}), {.density = 1000});
  scene.blocks[0].angular_velocity = Vector3(1, 2, 3);
  scene.blocks[0].velocity = Vector3(0.1, 0.2, -0.1);
  Run run(std::move(scene), {.time_step = time_step});
  const Vector3 principal = Vector3(4 + 9, 1 + 9, 1 + 4) * 6000.0 / 12.0;
  const auto momentum = [&] {
    const solver::BlockState& block = run.simulation().state().blocks[0];
    return Vector3(block.rotation * principal.cwiseProduct(block.angular_velocity));
  };
  const Vector3 start = momentum(), place = run.place(0);
  run.steps(steps);
  const Vector3 way = Vector3(0.1, 0.2, -0.1) * time_step * static_cast<double>(steps);
  return {std::max((momentum() - start).norm() / start.norm(),
                   (run.place(0) - place - way).norm() / way.norm()),
          run.evidence};
}

/// A block that must stay: friction 25 degrees on a slope of 20. Drift in block sizes.
Result run_stay(long steps, double young) {
  Slide slide;
  slide.friction = 25.0;
  slide.young = young;
  slide.steps_before = 100;
  slide.steps = steps;
  return run_slide(slide);
}

/// What doubles can tell of a slide over a rough plane in short steps: a gap that is off by the
/// rounding of its largest coordinate, 3 m, changes the normal force by 2 m / dt^2 of it.
double allowed_of_slide(double time_step) {
  constexpr double kRounding = 3.0 * std::numeric_limits<double>::epsilon();
  return std::max(1e-6, 2.0 * kRounding / (time_step * time_step * kGravity));
}

/// Elastic bouncing of a rigid cube under gravity: energy never grows.
Result run_bounce(long steps) {
  solver::Scene scene;
  scene.joint.restitution = 0.9;
  scene.joint.friction_angle = radians(20.0);
  scene.add_fixed(geometry::make_box({-500, -500, -1}, {500, 500, 0}));
  scene.add_rigid(geometry::make_box({-0.5, -0.5, 1}, {0.5, 0.5, 2}), {.density = 2500});
  scene.blocks[1].angular_velocity = Vector3(0.5, 0.3, 0.1);
  Run run(std::move(scene), {.time_step = 0.002});
  const auto energy = [&] { return run.simulation().state().energy.mechanical(); };
  const double scale = 2500 * kGravity * 1.5;
  double least = energy(), growth = 0.0;
  for (long i = 0; i < steps; ++i) {
    run.steps(1);
    least = std::min(least, energy());
    growth = std::max(growth, energy() - least);
  }
  return {growth / scale, run.evidence};
}

}  // namespace

void append_time_cells(Extent extent, std::vector<Cell>& cells) {
  for (const double step : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1}) {
    for (const double young : {0.0, 5e9}) {
      const std::string kind = young > 0.0 ? "deformable" : "rigid";
      cells.push_back({kind + " slide",
                       {{"time_step", step}},
                       young > 0.0 ? 1e-6 : allowed_of_slide(step),
                       [=] {
                         Slide slide;
                         slide.time_step = step;
                         slide.young = young;
                         if (young > 0.0) slide.friction = 0.0;
                         return run_slide(slide);
                       }});
      cells.push_back({kind + " stack of 5", {{"time_step", step}}, 1e-6, [=] {
                         Stack stack;
                         stack.densities.assign(5, 2600);
                         if (young > 0.0) stack.youngs.assign(5, young);
                         stack.time_step = step;
                         return run_stack(stack);
                       }});
    }
  }
  for (int exponent = 0; exponent <= 5; ++exponent) {
    const double speed =
        decade(exponent);  // 0.01 … 1e3 (1e4 of the small blocks) block sizes a step
    cells.push_back({"at a thick wall", {{"speed", speed}}, 1e-6, [=] {
                       return run_at_wall(speed, 1.0, 0.0);
                     }});
    cells.push_back({"at a thin wall", {{"speed", speed}}, 1e-6, [=] {
                       return run_at_wall(speed, 1e-3, 0.0);
                     }});
    cells.push_back({"aslant at a thin wall", {{"speed", speed}}, 1e-6, [=] {
                       return run_at_wall(speed, 1e-3, 0.3);
                     }});
    cells.push_back(
        {"at a free block", {{"speed", speed}}, 1e-6, [=] { return run_at_block(speed); }});
  }
  const int last = extent == Extent::Full ? 6 : 4;
  for (int exponent = 2; exponent <= last; ++exponent) {
    const long steps = std::lround(decade(exponent));
    const double count = static_cast<double>(steps);
    cells.push_back({"free spin", {{"steps", count}}, 1e-9, [=] { return run_spin(steps, 1e-3); }});
    cells.push_back(
        {"rigid stays", {{"steps", count}}, 1e-9, [=] { return run_stay(steps, 0.0); }});
    cells.push_back(
        {"deformable stays", {{"steps", count}}, 1e-9, [=] { return run_stay(steps, 5e9); }});
    cells.push_back(
        {"bouncing energy", {{"steps", count}}, 1e-6, [=] { return run_bounce(steps); }});
  }
}

}  // namespace quoin::stability
