#include "moving_scenes.hpp"

#include <algorithm>
#include <cmath>

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using Vector3 = Eigen::Vector3d;

constexpr double kMovingStep = 5e-3;  // s
// Of a shaken wall: the ground's displacement is then good to 1e-8 of its amplitude. A step of a
// whole period sees one value of the wave.
constexpr double kStepsOfPeriod = 20.0;

/// Lengths of the blocks of a course in running bond.
std::vector<double> bond(double length, double block_length, int course) {
  std::vector<double> lengths;
  for (double from = 0.0; from < length - 1e-9; from += lengths.back()) {
    const double full = course % 2 == 1 && lengths.empty() ? 0.5 : 1.0;
    const double to = from + full * block_length;
    lengths.push_back(to > length - 0.25 * block_length ? length - from : to - from);
  }
  return lengths;
}

/// Blocks of so many courses, without laying them where a course alone has too many.
double blocks_in_bond(double length, double block_length, double courses) {
  const double about = length / block_length;
  if (about > kMostBlocks) return about * courses;
  const auto blocks = [&](int course) {
    return static_cast<double>(bond(length, block_length, course).size());
  };
  return std::ceil(0.5 * courses) * blocks(0) + std::floor(0.5 * courses) * blocks(1);
}

double courses_of(const Wall& wall) {
  return std::max(1.0, std::round(wall.height / wall.block_height));
}

}  // namespace

double bricks(const Wall& wall) {
  return blocks_in_bond(wall.length, wall.block_length, courses_of(wall));
}

std::string lay_wall(const Wall& wall, Made& made) {
  made.add_fixed("ground", box({-0.5, -1, -0.3}, {wall.length + 0.5, wall.thickness + 1, 0}));
  const int courses = static_cast<int>(courses_of(wall));
  std::string last;
  for (int course = 0; course < courses; ++course) {
    double from = 0.0;
    int i = 0;
    for (const double length : bond(wall.length, wall.block_length, course)) {
      last = numbered("brick", course, i++);
      made.add_box(last, {from, 0, course * wall.block_height},
                   {length, wall.thickness, wall.block_height});
      from += length;
    }
  }
  return last;
}

void make_shaken_wall(const Stone& stone, const Wall& wall, const Shaking& shaking) {
  Made made(stone, "Wall on a shaking table", bricks(wall));
  made.watch(lay_wall(wall, made));
  made.set("peak", shaking.peak);
  made.set("hz", shaking.hz);
  made.set("direction", shaking.direction_deg);
  const std::string wave = "peak*g*cos(2*pi*hz*stage_time)*";
  const json motion = {
      {"acceleration",
       {{"formula", {wave + "cos(direction*deg)", wave + "sin(direction*deg)", "0"}}}}};
  made.save_changing(
      std::min(kMovingStep, 1.0 / (kStepsOfPeriod * shaking.hz)), 2.0,
      {{"overrides",
        json::array({json{{"blocks", "ground"}, {"kind", "prescribed"}, {"motion", motion}}})}});
}

void make_struck_wall(const Stone& stone, const Wall& wall, const Hammer& hammer) {
  Made made(stone, "Wall that is hit by a block", bricks(wall) + 1);
  made.watch(lay_wall(wall, made));
  const double side = std::cbrt(hammer.mass / stone.density);
  constexpr double kApart = 0.01;  // m
  const double x = 0.5 * (wall.length - side), z = std::max(0.0, 0.5 * (wall.height - side));
  made.add_box("hammer", {x, -side - kApart, z}, {side, side, side})["velocity"] =
      vector({0, hammer.speed, 0});
  made.watch("hammer");
  made.save_changing(kMovingStep, 1.0, {{"add", "hammer"}});
}

void make_bin(const Stone& stone, const Bin& bin) {
  Made made(stone, "Bin filled by falling rocks", bin.blocks);
  Uniform uniform(bin.seed);
  const int across = std::max(2, static_cast<int>(std::lround(std::cbrt(bin.blocks / 2.0))));
  const double pitch = 1.05 * bin.size, half = 0.5 * across * pitch, far = half + bin.size;
  const double top = pitch * (static_cast<double>(bin.blocks) / (across * across) + 1);
  made.add_fixed("floor", box({-far, -far, -bin.size}, {far, far, 0}));
  made.add_fixed("west", box({-far, -far, 0}, {-half, far, top}));
  made.add_fixed("east", box({half, -far, 0}, {far, far, top}));
  made.add_fixed("south", box({-half, -far, 0}, {half, -half, top}));
  made.add_fixed("north", box({-half, half, 0}, {half, far, top}));
  for (int i = 0; i < bin.blocks; ++i) {
    const int layer = i / (across * across), row = i / across % across, column = i % across;
    const Vector3 middle((column - 0.5 * (across - 1)) * pitch, (row - 0.5 * (across - 1)) * pitch,
                         (layer + 0.5) * pitch);
    std::vector<Vector3> points;
    for (int p = 0; p < 12; ++p) {  // on a sphere, equally spread
      const double z = uniform(-1, 1), around = uniform(0, 2 * std::numbers::pi);
      const double r = std::sqrt(1 - z * z);
      points.push_back(middle + 0.5 * bin.size * uniform(0.8, 1) *
                                    Vector3(r * std::cos(around), r * std::sin(around), z));
    }
    made.add(numbered("rock", i), hull(points));
  }
  made.watch(numbered("rock", bin.blocks - 1));
  made.save(kMovingStep, json::array({json{{"analysis", "dynamic"},
                                           {"duration", made.end_time(10.0)},
                                           {"until", "rest"},
                                           {"unbalance", 1e-3}}}));
}

void make_jointed_slope(const Stone& stone, const JointedSlope& slope) {
  const double dip = slope.dip_deg * kDegree;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(dip, Vector3::UnitY()).toRotationMatrix();
  const Vector3 size(slope.block_length, slope.block_width, slope.block_height);
  const double length = slope.rows * size.x(), width = slope.columns * size.y(),
               height = slope.sheets * size.z();
  Made made(stone, "Jointed slope that loses its toe",
            slope.columns * blocks_in_bond(length, size.x(), slope.sheets));
  // In axes along the dip, along the strike and upwards from the plane; the toe is at 0.
  const auto place = [&](const std::string& name, const Vector3& corner, const Vector3& sides) {
    json& block = made.add(name, box(Vector3::Zero(), sides));
    block["pose"] = {{"rotation", {{"axis", {0, 1, 0}}, {"angle_deg", slope.dip_deg}}},
                     {"translation", vector(turn * corner)}};
    return &block;
  };
  const auto hold = [](json* block) { (*block)["kind"] = "fixed"; };
  hold(place("bed", {-length - size.x(), -width, -0.5}, {2 * length + size.x(), 3 * width, 0.5}));
  hold(place("toe", {0, -0.5 * width, 0}, {size.x(), 2 * width, height}));
  for (int sheet = 0; sheet < slope.sheets; ++sheet) {
    for (int column = 0; column < slope.columns; ++column) {
      int row = 0;
      double from = 0.0;
      for (const double step : bond(length, size.x(), sheet)) {
        from -= step;
        place(numbered(numbered("block", sheet, column) + "_", row++),
              {from, column * size.y(), sheet * size.z()}, {step, size.y(), size.z()});
      }
    }
  }
  made.watch(numbered(numbered("block", slope.sheets - 1, 0) + "_", 0));
  made.save_changing(kMovingStep, 1.0, {{"remove", "toe"}});
}

void make_vault(const Stone& stone, const Vault& vault) {
  Made made(stone, "Dry-stone vault that loses a pier",
            blocks_in_bond(vault.length, vault.block_length, vault.courses) + 2.0 * vault.piers);
  const double outer = vault.radius + vault.thickness, bay = vault.length / vault.piers;
  for (int pier = 0; pier < vault.piers; ++pier) {
    const double from = pier * bay, to = (pier + 1) * bay;
    made.add_fixed(numbered("left", pier),
                   box({-outer, from, -vault.pier_height}, {-vault.radius, to, 0}));
    made.add_fixed(numbered("right", pier),
                   box({vault.radius, from, -vault.pier_height}, {outer, to, 0}));
  }
  const auto at = [&](double radius, int joint) {
    const double angle = std::numbers::pi * joint / vault.courses;
    return Vector3(-radius * std::cos(angle), 0, radius * std::sin(angle));
  };
  for (int course = 0; course < vault.courses; ++course) {
    double from = 0.0;
    int i = 0;
    for (const double length : bond(vault.length, vault.block_length, course)) {
      made.add(numbered("stone", course, i++),
               prism({at(vault.radius, course), at(outer, course), at(outer, course + 1),
                      at(vault.radius, course + 1)},
                     {0, length, 0}))["pose"] = {{"translation", vector({0, from, 0})}};
      from += length;
    }
  }
  made.watch(numbered("stone", vault.courses / 2, 0));
  made.save_changing(kMovingStep, 1.0, {{"remove", numbered("left", vault.piers / 2)}});
}

}  // namespace quoin::commands
