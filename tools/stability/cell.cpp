#include "stability/cell.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <quoin/geometry/build.hpp>

namespace quoin::stability {
namespace {

constexpr double kAtRest = 1e-8;  // unbalance that is left after the static steps

geometry::Shape turned_box(const Vector3& min, const Vector3& max, const Eigen::Matrix3d& rotation,
                           const Vector3& origin) {
  geometry::Shape shape = geometry::make_box(min, max);
  geometry::Points vertices(3, shape.topology().vertex_count());
  for (int i = 0; i < shape.topology().vertex_count(); ++i) {
    vertices.col(i) = origin + rotation * shape.vertex(i);
  }
  shape.set_vertices(vertices);
  return shape;
}

int add(solver::Scene& scene, geometry::Shape shape, double density, double young, double poisson) {
  if (young > 0.0) {
    return scene.add_block(std::move(shape),
                           {.density = density, .young = young, .poisson = poisson});
  }
  return scene.add_rigid(std::move(shape), {.density = density});
}

solver::Scene stack_scene(const Stack& stack, double poisson) {
  solver::Scene scene;
  scene.joint.friction_angle = radians(35.0);
  const double width = 0.5 * stack.size.x(), height = stack.size.z();
  const auto at = [&](const Vector3& min, const Vector3& max) {
    return turned_box(min, max, Eigen::Matrix3d::Identity(), stack.origin);
  };
  scene.add_fixed(at({-3 * width, -3 * width, -height}, {3 * width, 3 * width, 0}));
  for (std::size_t i = 0; i < stack.densities.size(); ++i) {
    const double low = height * static_cast<double>(i);
    add(scene, at({-width, -width, low}, {width, width, low + height}), stack.densities[i],
        stack.youngs.empty() ? 0.0 : stack.youngs[i], poisson);
  }
  return scene;
}

double weight_above(const Stack& stack, std::size_t from) {
  double sum = 0.0;
  for (std::size_t i = from; i < stack.densities.size(); ++i) {
    sum += stack.densities[i] * stack.size.prod() * kGravity;
  }
  return sum;
}

}  // namespace

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }
double decade(int exponent) { return std::pow(10.0, exponent); }

std::vector<std::string> flag_names(const Evidence& evidence) {
  std::vector<std::string> names;
  for (std::size_t kind = 0; kind < evidence.raised.size(); ++kind) {
    if (evidence.raised[kind]) names.emplace_back(name(static_cast<solver::FlagKind>(kind)));
  }
  return names;
}

Run::Run(solver::Scene scene, const solver::StepOptions& options)
    : simulation_(std::move(scene), options) {}

void Run::step() {
  const solver::StepReport report = simulation_.advance();
  ++evidence.steps;
  evidence.solves += report.linear_solves;
  evidence.unconverged += report.status != solver::StepStatus::Converged;
  for (const solver::StepFlag& flag : report.flags) {
    evidence.raised[static_cast<std::size_t>(flag.kind)] = true;
  }
  if (simulation_.options().analysis != solver::Analysis::Dynamic) {
    evidence.unbalance = report.unbalance;
  }
}

void Run::rest(double time_step, solver::Analysis analysis, int most) {
  const solver::StepOptions before = simulation_.options();
  solver::StepOptions options = before;
  options.time_step = time_step;
  options.analysis = analysis;
  simulation_.set_options(options);
  for (int i = 0; i < most; ++i) {
    step();
    if (evidence.unbalance < 1e-12 || evidence.unconverged > 0) break;
  }
  simulation_.set_options(before);
}

void Run::steps(long count) {
  for (long i = 0; i < count && evidence.unconverged == 0; ++i) step();
}

Vector3 Run::place(int block) const {
  return simulation_.state().origin +
         simulation_.state().blocks[static_cast<std::size_t>(block)].centroid;
}

double Run::force(int a, int b) const {
  double sum = 0.0;
  for (const solver::Contact& contact : simulation_.state().contacts) {
    if (contact.point.key.a == a && contact.point.key.b == b) sum += contact.normal_force;
  }
  return sum;
}

Result run_slide(const Slide& slide) {
  const double slope = radians(slide.slope), friction = radians(slide.friction);
  const Eigen::Matrix3d axes = Eigen::AngleAxisd(slope, Vector3::UnitY()).toRotationMatrix();
  const double time = slide.time_step * static_cast<double>(slide.steps);
  const double acceleration =
      std::max(0.0, kGravity * (std::sin(slope) - std::cos(slope) * std::tan(friction)));
  const double way = 0.5 * acceleration * time * time;
  const double largest = slide.size.maxCoeff(), along = slide.size.x(), across = slide.size.y();
  solver::Scene scene;
  scene.joint.friction_angle = friction;
  scene.add_fixed(turned_box({-2 * largest, -2 * largest, -largest},
                             {1.2 * way + 3 * largest, 2 * largest, 0}, axes, slide.origin));
  add(scene,
      turned_box({-0.5 * along, -0.5 * across, 0}, {0.5 * along, 0.5 * across, slide.size.z()},
                 axes, slide.origin),
      slide.density, slide.young, 0.25);
  Run run(std::move(scene),
          {.time_step = slide.time_step, .method = slide.method, .penalty = slide.penalty});
  run.rest(100.0 * slide.rest_step, solver::Analysis::Settle);
  run.steps(slide.steps_before);
  const Vector3 start = run.place(1);
  run.steps(slide.steps);
  const double gone = axes.col(0).dot(run.place(1) - start);
  return {acceleration > 0.0 ? std::abs(gone - way) / way : std::abs(gone) / along, run.evidence};
}

Result run_stack(const Stack& stack) {
  Run run(stack_scene(stack, 0.25),
          {.time_step = stack.time_step, .method = stack.method, .penalty = stack.penalty});
  const bool springs = stack.method == solver::ContactMethod::Springs;
  if (!stack.youngs.empty() || springs) run.rest(100.0 * stack.rest_step);
  if (!springs || run.evidence.unbalance < kAtRest) run.steps(stack.steps);
  double worst = 0.0;
  for (std::size_t i = 0; i < stack.densities.size(); ++i) {
    const double exact = weight_above(stack, i);
    const int block = static_cast<int>(i);
    worst = std::max(worst, std::abs(run.force(block, block + 1) - exact) / exact);
  }
  return {worst, run.evidence};
}

Result run_column_strain(const Stack& stack) {
  Run run(stack_scene(stack, 0.0),
          {.time_step = stack.time_step, .method = stack.method, .penalty = stack.penalty});
  run.rest(100.0 * stack.rest_step);
  double worst = 0.0;
  const double area = stack.size.x() * stack.size.y();
  for (std::size_t i = 0; i < stack.densities.size(); ++i) {
    const double mean = 0.5 * (weight_above(stack, i) + weight_above(stack, i + 1));
    const double exact = -mean / (area * stack.youngs[i]);
    const double strain = run.simulation().state().blocks[i + 1].strain[2];
    worst = std::max(worst, std::abs(strain - exact) / std::abs(exact));
  }
  return {worst, run.evidence};
}

std::vector<Cell> all_cells(Extent extent, const std::string& scenes) {
  std::vector<Cell> cells;
  append_penalty_cells(cells);
  append_material_cells(cells);
  append_geometry_cells(cells);
  append_collapse_cells(scenes, cells);
  append_moving_cells(cells);
  append_time_cells(extent, cells);
  return cells;
}

}  // namespace quoin::stability
