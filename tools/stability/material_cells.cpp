/// Penalty, stiffness, mass and friction.

#include <cmath>

#include <quoin/geometry/build.hpp>

#include "stability/cell.hpp"

namespace quoin::stability {
namespace {

using solver::ContactMethod;

/// Two cubes meet, no gravity, restitution 0: both go on with the speed of their common momentum.
Result run_impact(double mass_ratio, double speed, double time_step, long steps) {
  solver::Scene scene;
  scene.gravity = Vector3(Vector3::Zero());
  scene.add_rigid(geometry::make_box({0, 0, 0}, {1, 1, 1}), {.density = 2500});
  scene.add_rigid(geometry::make_box({1.01, 0, 0}, {2.01, 1, 1}), {.density = 2500 * mass_ratio});
  scene.blocks[0].velocity = Vector3(speed, 0, 0);
  Run run(std::move(scene), {.time_step = time_step});
  run.steps(steps);
  const double exact = speed / (1.0 + mass_ratio);
  double worst = 0.0;
  for (const solver::BlockState& block : run.simulation().state().blocks) {
    worst = std::max(worst, (block.velocity - Vector3(exact, 0, 0)).norm() / speed);
  }
  return {worst, run.evidence};
}

}  // namespace

void append_penalty_cells(std::vector<Cell>& cells) {
  for (const ContactMethod method : {ContactMethod::Springs, ContactMethod::Paper}) {
    const std::string tail = std::string(" / ") + name(method);
    for (int exponent = 3; exponent <= 15; ++exponent) {
      const double penalty = decade(exponent);
      cells.push_back({"slide" + tail,
                       {{"penalty", penalty}},
                       1e-3,
                       [=] {
                         Slide slide;
                         slide.method = method;
                         slide.penalty = penalty;
                         return run_slide(slide);
                       },
                       method});
      cells.push_back({"stack of 5" + tail,
                       {{"penalty", penalty}},
                       1e-6,
                       [=] {
                         Stack stack;
                         stack.densities.assign(5, 2600);
                         stack.method = method;
                         stack.penalty = penalty;
                         return run_stack(stack);
                       },
                       method});
    }
  }
}

namespace {

void append_stiffness_cells(std::vector<Cell>& cells) {
  for (int exponent = 5; exponent <= 13;
       ++exponent) {  // softer: shorter than nothing under its weight
    const double young = decade(exponent);
    cells.push_back({"slide", {{"young", young}}, 1e-6, [=] {
                       Slide slide;
                       slide.young = young;
                       slide.friction = 0.0;  // with friction the elastic sway has no closed form
                       return run_slide(slide);
                     }});
    cells.push_back({"column strain", {{"young", young}}, 1e-4, [=] {
                       Stack stack;
                       stack.densities.assign(3, 2500);
                       stack.youngs.assign(3, young);
                       return run_column_strain(stack);
                     }});
    if (exponent == 5) continue;  // the lowest of five would be shorter than nothing
    cells.push_back({"stack of 5", {{"young", young}}, 1e-6, [=] {
                       Stack stack;
                       stack.densities.assign(5, 2500);
                       stack.youngs.assign(5, young);
                       return run_stack(stack);
                     }});
  }
}

void append_ratio_cells(std::vector<Cell>& cells) {
  for (int exponent = -6; exponent <= 6; ++exponent) {
    const double ratio = decade(exponent);
    cells.push_back({"rigid on rigid", {{"mass_ratio", ratio}}, 1e-8, [=] {
                       Stack stack;
                       stack.densities = {2500, 2500 * ratio};
                       return run_stack(stack);
                     }});
    cells.push_back({"deformable on deformable", {{"mass_ratio", ratio}}, 1e-6, [=] {
                       Stack stack;
                       stack.densities = {2500, 2500 * ratio};
                       stack.youngs = {5e13, 5e13};
                       return run_stack(stack);
                     }});
    cells.push_back({"impact", {{"mass_ratio", ratio}}, 1e-8, [=] {
                       return run_impact(ratio, 1.0, 0.003, 20);
                     }});
    cells.push_back(
        {"column strain", {{"stiffness_ratio", ratio}}, 1e-4, [=] {
           Stack stack;
           stack.densities = {2500, 2500};
           stack.youngs = {ratio > 1 ? 1e7 : 1e7 / ratio, ratio > 1 ? 1e7 * ratio : 1e7};
           return run_column_strain(stack);
         }});
    cells.push_back(
        {"stack of 2", {{"stiffness_ratio", ratio}}, 1e-6, [=] {
           Stack stack;
           stack.densities = {2500, 2500};
           stack.youngs = {ratio > 1 ? 1e7 : 1e7 / ratio, ratio > 1 ? 1e7 * ratio : 1e7};
           return run_stack(stack);
         }});
  }
}

void append_friction_cells(std::vector<Cell>& cells) {
  for (const double angle : {0.0, 1.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0, 85.0, 88.0, 89.0}) {
    const auto plate = [=](double slope) {
      Slide slide;
      slide.size = Vector3(1, 1, 0.005);  // a plate: a cube would topple
      slide.friction = angle;
      slide.slope = slope;
      return run_slide(slide);
    };
    const double tight = angle > 87.0 ? 0.1 : 0.5;
    cells.push_back(
        {"slides", {{"friction_deg", angle}}, 1e-8, [=] { return plate(angle + tight); }});
    if (angle == 0.0) continue;
    cells.push_back(
        {"sticks", {{"friction_deg", angle}}, 1e-9, [=] { return plate(angle - tight); }});
  }
}

}  // namespace

void append_material_cells(std::vector<Cell>& cells) {
  append_stiffness_cells(cells);
  append_ratio_cells(cells);
  append_friction_cells(cells);
}

}  // namespace quoin::stability
