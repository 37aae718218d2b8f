/// The solver scenes S1–S8: error, drift, force error, overlap, energy growth and CPU time of
/// stepping, quoin, Bullet and ODE on the same bodies in one run.

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <numbers>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/nearest_features.hpp>
#include <regex>

#include "rigid_scenes.hpp"

namespace quoin::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kGravity = 9.81;

/// CPU time of this thread: other work on the machine does not count.
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Value {
  std::string name;
  double number = 0.0;
  double goal = 0.0;  ///< quoin's, 0: none
};

struct Row {
  std::string scene, contestant;
  double time_step = 0.0;
  long steps = 0;
  double cpu = 0.0;                     ///< s of stepping
  double cpu_goal = 0.0;                ///< s, 0: none
  bool ended = true;                    ///< every step did
  double share = 1.0;                   ///< of the run that was done within the limit of CPU time
  long solves = 0, factorizations = 0;  ///< of a code that counts them
  std::vector<Value> values{};
};

/// Sees each step; `last` is set at the last one.
using Watch = std::function<void(const World&, double time, bool last)>;

/// CPU time that one run may take, s; it then ends where it is, and its row says so.
double cpu_limit = std::numeric_limits<double>::infinity();

/// Steps to `end` s; `watch` is not timed.
Row run(const std::string& name, const RigidScene& scene, const Contestant& who, double dt,
        double end, const Watch& watch) {
  Row row{name, who.name, dt};
  const std::unique_ptr<World> world = who.make(scene, dt, who.iterations);
  const long all = std::lround(end / dt);
  while (row.steps < all && row.cpu < cpu_limit) {
    const double start = cpu_seconds();
    row.ended = world->step(dt) && row.ended;
    row.cpu += cpu_seconds() - start;
    ++row.steps;
    watch(*world, static_cast<double>(row.steps) * dt, row.steps == all || row.cpu >= cpu_limit);
  }
  row.share = static_cast<double>(row.steps) / static_cast<double>(all);
  row.solves = world->solves();
  row.factorizations = world->factorizations();
  return row;
}

double mechanical_energy(const RigidScene& scene, const World& world) {
  double energy = 0.0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const RigidBody& body = scene.bodies[b];
    if (body.density == 0.0) continue;
    const BodyMotion m = world.motion(static_cast<int>(b));
    const Vector3d spin = m.turn.conjugate() * m.spin;
    energy += 0.5 * body.mass * m.velocity.squaredNorm() + 0.5 * spin.dot(body.inertia * spin) -
              body.mass * scene.gravity.dot(m.place);
  }
  return energy;
}

geometry::Shape placed(const RigidBody& body, const BodyMotion& m) {
  geometry::Shape shape = geometry::make_box(-body.half_size, body.half_size);
  geometry::Points vertices(3, shape.topology().vertex_count());
  for (int i = 0; i < shape.topology().vertex_count(); ++i) {
    vertices.col(i) = m.place + m.turn * shape.vertex(i);
  }
  shape.set_vertices(vertices);
  return shape;
}

/// Largest overlap of the bodies as they stand (few bodies only), m.
double overlap(const RigidScene& scene, const World& world) {
  std::vector<geometry::Shape> shapes;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    shapes.push_back(placed(scene.bodies[b], world.motion(static_cast<int>(b))));
  }
  double worst = 0.0;
  for (std::size_t a = 0; a < shapes.size(); ++a) {
    for (std::size_t b = a + 1; b < shapes.size(); ++b) {
      worst = std::max(worst, -geometry::nearest_features(shapes[a], shapes[b]).gap);
    }
  }
  return worst;
}

double largest_drift(const RigidScene& scene, const World& world) {
  double worst = 0.0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Vector3d moved = world.motion(static_cast<int>(b)).place - scene.bodies[b].place;
    worst = std::max(worst, moved.norm());
  }
  return worst;
}

// --- the scenes

Row sliding(const std::string& name, const Contestant& who, double friction_deg, double dip_deg,
            double dt, double end) {
  const RigidScene scene = sliding_block(friction_deg, dip_deg);
  const double slope = 20.0 * kDegree;
  const double acceleration = std::max(
      0.0, kGravity * (std::sin(slope) - std::cos(slope) * std::tan(friction_deg * kDegree)));
  const Vector3d down = Eigen::AngleAxisd(dip_deg * kDegree, Vector3d::UnitZ()) *
                        Vector3d(std::cos(slope), 0, -std::sin(slope));
  double error = 0.0;
  Row row = run(name, scene, who, dt, end, [&](const World& world, double t, bool) {
    const Vector3d exact = 0.5 * acceleration * t * t * down;
    error = (world.motion(1).place - scene.bodies[1].place - exact).norm();
  });
  row.cpu_goal = 10e-6 * static_cast<double>(row.steps);
  if (acceleration > 0.0) {
    const double way = 0.5 * acceleration * end * end;
    row.values.push_back({"error", error / way, friction_deg > 15 ? 1e-8 : 1e-9});
  } else {
    row.values.push_back({"drift m", error, 1e-9});
  }
  return row;
}

Row pushed(const Contestant& who, double dt) {
  const RigidScene scene = pushed_block();
  double error = 0.0;
  Row row = run("S2 two forces", scene, who, dt, 4.5, [&](const World& world, double t, bool) {
    const Vector3d exact = scene.bodies[1].force / scene.bodies[1].mass * 0.5 * t * t;
    error = (world.motion(1).place - scene.bodies[1].place - exact).norm() / exact.norm();
  });
  row.cpu_goal = 10e-6 * static_cast<double>(row.steps);
  row.values.push_back({"error", error, 1e-9});
  return row;
}

/// Largest error of the force between i and i + 1, relative to what stands above.
double tower_force_error(int count, double weight, const World& world) {
  std::vector<double> sums(static_cast<std::size_t>(count), 0.0);
  for (const PairForce& pair : world.forces()) {
    if (pair.b == pair.a + 1) sums[static_cast<std::size_t>(pair.a)] += pair.normal;
  }
  double worst = 0.0;
  for (int i = 0; i < count; ++i) {
    const double exact = (count - i) * weight;
    worst = std::max(worst, std::abs(sums[static_cast<std::size_t>(i)] - exact) / exact);
  }
  return worst;
}

Row tower_row(int count, const Contestant& who, double dt, double end = 5.0) {
  const RigidScene scene = tower(count);
  double drift = 0.0, force = 0.0;
  Row row = run("S4 tower of " + std::to_string(count), scene, who, dt, end,
                [&](const World& world, double, bool last) {
                  drift = std::max(drift, largest_drift(scene, world));
                  if (last) force = tower_force_error(count, 2600 * kGravity, world);
                });
  const bool ten = count <= 10;
  row.cpu_goal = (ten ? 0.13 : 0.9) * end / 5.0;
  row.values.push_back({"drift m", drift, ten ? 1e-6 : 1e-5});
  row.values.push_back({"force error", force, ten ? 1e-7 : 1e-6});
  return row;
}

Row domino_row(const Contestant& who, double dt) {
  const RigidScene scene = dominoes();
  double least = std::numeric_limits<double>::infinity(), growth = 0.0, worst = 0.0;
  Row row = run("S5 dominoes", scene, who, dt, 3.0, [&](const World& world, double, bool) {
    const double energy = mechanical_energy(scene, world);
    least = std::min(least, energy);
    growth = std::max(growth, energy - least);
    worst = std::max(worst, overlap(scene, world));
  });
  double total = 0.0;  // potential energy over the base at the start
  for (std::size_t b = 1; b < scene.bodies.size(); ++b) {
    total += scene.bodies[b].mass * kGravity * scene.bodies[b].place.z();
  }
  row.cpu_goal = dt >= 0.005 ? 0.1 : 0.0;
  row.values.push_back({"overlap m", worst, 1e-4});
  row.values.push_back({"energy growth", growth / total, 1e-9});
  return row;
}

double tilt_of(const BodyMotion& m) {
  const Vector3d up = m.turn * Vector3d::UnitZ();
  return std::atan2(up.x(), up.z());
}

Row rocking_row(const Contestant& who, double dt) {
  constexpr double quarter = 0.440674, peak = 5.4157 * kDegree;
  const RigidScene scene = rocking_block();
  double crossing = 0.0, least = 0.0;
  double t0 = 0.0, tilt0 = 7.0 * kDegree, rate0 = 0.0, rate_before = 0.0;
  Row row = run("S6 rocking block", scene, who, dt, 1.3, [&](const World& world, double t, bool) {
    const BodyMotion m = world.motion(1);
    const double tilt = tilt_of(m);
    if (crossing == 0.0 &&
        tilt <= 1e-9) {  // on from the last step by its velocity and acceleration
      const double a = 0.5 * (rate0 - rate_before) / dt;
      crossing =
          t0 + 2.0 * tilt0 / (-rate0 + std::sqrt(std::max(0.0, rate0 * rate0 - 4.0 * a * tilt0)));
    }
    if (crossing > 0.0 && t < crossing + 0.75) least = std::min(least, tilt);
    t0 = t;
    tilt0 = tilt;
    rate_before = rate0;
    rate0 = m.spin.y();
  });
  row.values.push_back(
      {"quarter error", std::abs(crossing - quarter) / quarter, dt >= 0.01 ? 1e-4 : 0.0});
  row.values.push_back({"peak error", std::abs(-least - peak) / peak, 0.0});
  return row;
}

Row wall_row(int columns, int rows, const Contestant& who, double dt, double end = 0.5) {
  const RigidScene scene = wall(columns, rows);
  double drift = 0.0, reaction = 0.0, weight = 0.0;
  for (const RigidBody& body : scene.bodies) weight += body.mass * kGravity;
  const int count = static_cast<int>(scene.bodies.size()) - 1;
  Row row = run("S7 wall of " + std::to_string(count), scene, who, dt, end,
                [&](const World& world, double, bool last) {
                  if (!last) return;
                  drift = largest_drift(scene, world);
                  for (const PairForce& pair : world.forces()) {
                    if (pair.a == 0) reaction += pair.normal;
                  }
                });
  row.cpu_goal = (count < 200 ? 0.15 : count < 2000 ? 3.0 : 60.0) * end / 0.5;
  row.values.push_back({"drift m", drift, count < 2000 ? 1e-5 : 1e-4});
  row.values.push_back({"unbalance", std::abs(reaction - weight) / weight, 1e-6});
  return row;
}

/// Stands or falls within 10 s; a fallen one is not followed any further.
bool arch_stands(const Contestant& who, double ratio, double dt, Row& row) {
  constexpr int count = 27;
  const RigidScene scene = arch(count, ratio);
  const std::unique_ptr<World> world = who.make(scene, dt, who.iterations);
  const double start = cpu_seconds();
  bool stands = true;
  for (double t = 0.0; t < 10.0 && stands; t += dt) {
    row.ended = world->step(dt) && row.ended;
    ++row.steps;
    const double moved = (world->motion(count / 2).place - scene.bodies[count / 2].place).norm();
    stands = moved < 0.2;
  }
  row.cpu += cpu_seconds() - start;
  row.solves += world->solves();
  row.factorizations += world->factorizations();
  return stands;
}

Row arch_row(const Contestant& who, double dt) {
  constexpr double exact = 0.106721;
  Row row{"S8 arch", who.name, dt};
  double low = 0.09, high = 0.13;
  int simulations = 0;
  for (; high - low > 4e-4 * exact && row.cpu < cpu_limit; ++simulations) {
    const double middle = 0.5 * (low + high);
    (arch_stands(who, middle, dt, row) ? high : low) = middle;
  }
  if (high - low > 4e-4 * exact) row.share = 0.0;
  row.cpu_goal = 0.13 * simulations;
  row.values.push_back({"least t/R error", std::abs(0.5 * (low + high) - exact) / exact, 2e-3});
  return row;
}

// --- the programme

std::vector<Contestant> contestants() {
  std::vector<Contestant> all = peers();
  all.insert(all.begin(), {"quoin", make_quoin});
  return all;
}

struct Task {
  std::string name;
  std::function<Row(const Contestant&)> row;
  bool long_running = false;
  bool boxes_only = true;  ///< else ODE is left out: its general convex bodies abort
  bool small = true;       ///< else ODE's direct solver is left out
};

std::vector<Task> tasks() {
  std::vector<Task> list;
  const auto slide = [&](const char* name, double friction, double dip, double dt, double end) {
    list.push_back(
        {name, [=](const Contestant& who) { return sliding(name, who, friction, dip, dt, end); }});
  };
  for (const double dt : {0.02, 0.005}) {
    slide("S1 incline", 10, 0, dt, 5);
    slide("S1 dip 30", 10, 30, dt, 5);
    slide("S1 dip 123", 10, 123, dt, 5);
    list.push_back({"S2 two forces", [dt](const Contestant& who) { return pushed(who, dt); }});
    slide("S3 at 20.1", 20.1, 0, dt, 10);
    slide("S3 at 19.9", 19.9, 0, dt, 10);
  }
  for (const double dt : {0.01, 0.005}) {
    list.push_back(
        {"S4 tower of 10", [dt](const Contestant& who) { return tower_row(10, who, dt); }});
    list.push_back(
        {"S4 tower of 30", [dt](const Contestant& who) { return tower_row(30, who, dt); }});
  }
  for (const double dt : {0.01, 0.005, 0.002, 0.001}) {
    list.push_back({"S5 dominoes", [dt](const Contestant& who) { return domino_row(who, dt); }});
  }
  for (const double dt : {0.01, 0.005, 0.0025}) {
    list.push_back(
        {"S6 rocking block", [dt](const Contestant& who) { return rocking_row(who, dt); }});
  }
  list.push_back({"S7 wall of 105",
                  [](const Contestant& who) { return wall_row(10, 10, who, 0.01); }, false, true,
                  false});
  list.push_back({"S7 wall of 1012",
                  [](const Contestant& who) { return wall_row(40, 25, who, 0.01); }, true, true,
                  false});
  list.push_back({"S7 wall of 10040",
                  [](const Contestant& who) { return wall_row(125, 80, who, 0.01); }, true, true,
                  false});
  list.push_back(
      {"S8 arch", [](const Contestant& who) { return arch_row(who, 0.01); }, true, false});
  return list;
}

void print(const Row& row) {
  std::printf("| %s | %g | %s | ", row.scene.c_str(), row.time_step, row.contestant.c_str());
  const bool ours = row.contestant == "quoin";
  for (const Value& v : row.values) {
    std::printf("%s %.2g%s; ", v.name.c_str(), v.number,
                !ours || v.goal == 0.0 || row.share < 1.0 ? ""
                : v.number <= v.goal                      ? " (met)"
                                                          : " (MISSED)");
  }
  const double steps = static_cast<double>(row.steps);
  if (row.solves > 0) {
    std::printf("%.2g solves, %.2g factorizations a step ", static_cast<double>(row.solves) / steps,
                static_cast<double>(row.factorizations) / steps);
  }
  if (row.share < 1.0) std::printf("stopped by --limit at %.3g of the run ", row.share);
  const bool met = row.cpu <= row.cpu_goal && row.share == 1.0;
  std::printf("| %.3g%s | %.3g | %s |\n", row.cpu,
              !ours || row.cpu_goal == 0.0 ? ""
              : met                        ? " (met)"
                                           : " (MISSED)",
              1e6 * row.cpu / steps, row.ended ? "yes" : "no");
  std::fflush(stdout);
}

void write_json(const std::string& path, const std::vector<Row>& rows) {
  std::ofstream out(path);
  out << "[\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    char text[512];
    std::snprintf(
        text, sizeof text,
        "  {\"scene\": \"%s\", \"contestant\": \"%s\", \"time_step\": %g, \"steps\": %ld, "
        "\"cpu_seconds\": %.4g, \"cpu_goal\": %.4g, \"every_step_ended\": %s, "
        "\"share_done\": %g, \"solves\": %ld, \"factorizations\": %ld, \"values\": {",
        row.scene.c_str(), row.contestant.c_str(), row.time_step, row.steps, row.cpu, row.cpu_goal,
        row.ended ? "true" : "false", row.share, row.solves, row.factorizations);
    out << text;
    for (std::size_t v = 0; v < row.values.size(); ++v) {
      std::snprintf(text, sizeof text, "%s\"%s\": {\"value\": %.6g, \"goal\": %g}",
                    v > 0 ? ", " : "", row.values[v].name.c_str(),
                    std::isfinite(row.values[v].number) ? row.values[v].number : 1e300,
                    row.values[v].goal);
      out << text;
    }
    out << "}}" << (i + 1 < rows.size() ? "," : "") << "\n";
  }
  out << "]\n";
}

int main_program(int argc, char** argv) {
  std::string filter = ".*", who_filter = ".*", out;
  bool quick = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool more = i + 1 < argc;
    if (argument == "--quick")
      quick = true;
    else if (argument == "--filter" && more)
      filter = argv[++i];
    else if (argument == "--who" && more)
      who_filter = argv[++i];
    else if (argument == "--out" && more)
      out = argv[++i];
    else if (argument == "--limit" && more)
      cpu_limit = std::strtod(argv[++i], nullptr);
    else {
      std::fprintf(stderr,
                   "usage: %s [--quick] [--filter REGEX] [--who REGEX] [--limit CPU_SECONDS] "
                   "[--out FILE.json]\n",
                   argv[0]);
      return 2;
    }
  }
  std::printf(
      "| scene | dt s | code | measures | CPU s | us a step | every step ended "
      "|\n|---|---|---|---|---|---|---|\n");
  std::vector<Row> rows;
  for (const Task& task : tasks()) {
    if (!std::regex_search(task.name, std::regex(filter)) || (quick && task.long_running)) continue;
    for (const Contestant& who : contestants()) {
      if (!std::regex_search(who.name, std::regex(who_filter))) continue;
      if (!task.boxes_only && who.name.starts_with("ODE")) continue;
      if (!task.small && who.name == "ODE step") continue;
      rows.push_back(task.row(who));
      print(rows.back());
    }
  }
  if (!out.empty()) write_json(out, rows);
  return 0;
}

}  // namespace
}  // namespace quoin::bench

int main(int argc, char** argv) { return quoin::bench::main_program(argc, argv); }
