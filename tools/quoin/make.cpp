/// quoin make wall|arch|dome|tower|stair|slope|pile

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "commands.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using Vector3 = Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

/// What every made scene has.
struct Stone {
  double density = 2400;  // kg/m3
  double young = 0;       // Pa
  double friction_deg = 35;
  double end_time = 0;  // s
  std::string out;
};

/// A length in m, to a picometre: what is shared by two blocks is the same number in both.
double rounded(double x) {
  const double value = std::round(x * 1e12) / 1e12;
  return value == 0.0 ? 0.0 : value;
}

json vector(const Vector3& v) { return {rounded(v.x()), rounded(v.y()), rounded(v.z())}; }

json box(const Vector3& min, const Vector3& max) {
  return {{"type", "box"}, {"min", vector(min)}, {"max", vector(max)}};
}

json points(const std::vector<Vector3>& list) {
  json all = json::array();
  for (const Vector3& point : list) {
    all.push_back(vector(point));
  }
  return all;
}

json prism(const std::vector<Vector3>& polygon, const Vector3& sweep) {
  return {{"type", "prism"}, {"polygon", points(polygon)}, {"sweep", vector(sweep)}};
}

/// The blocks of a scene, and the rest of it.
class Made {
 public:
  Made(const Stone& stone, std::string title) : stone_(stone), title_(std::move(title)) {}

  void add(const std::string& name, json shape) {
    blocks_.push_back({{"name", name},
                       {"kind", stone_.young > 0 ? "deformable" : "rigid"},
                       {"material", "stone"},
                       {"shape", std::move(shape)}});
  }
  /// A box by its lowest corner: those of one size share their shape.
  void add_box(const std::string& name, const Vector3& corner, const Vector3& size) {
    add(name, box(Vector3::Zero(), size));
    blocks_.back()["pose"] = {{"translation", vector(corner)}};
  }
  void add_turned(const std::string& name, json shape, const Eigen::Quaterniond& turn,
                  const Vector3& about) {
    add(name, std::move(shape));
    blocks_.back()["pose"] = {
        {"rotation",
         {{"quaternion",
           {rounded(turn.w()), rounded(turn.x()), rounded(turn.y()), rounded(turn.z())}}}},
        {"about", vector(about)}};
  }
  void add_fixed(const std::string& name, json shape) {
    blocks_.push_back({{"name", name}, {"kind", "fixed"}, {"shape", std::move(shape)}});
  }
  void watch(const std::string& block) { monitors_.push_back({{"name", block}, {"block", block}}); }

  /// The scene comes to rest, then moves for `end_time` where that is not 0.
  void save_standing(double time_step) const {
    json stages = json::array({json{{"analysis", "static"}}});
    if (stone_.end_time > 0) {
      stages.push_back({{"analysis", "dynamic"}, {"end_time", stone_.end_time}});
    }
    save(time_step, stages);
  }
  /// The scene moves from the start.
  void save_moving(double time_step, double otherwise) const {
    const double end_time = stone_.end_time > 0 ? stone_.end_time : otherwise;
    save(time_step, json::array({json{{"analysis", "dynamic"}, {"end_time", end_time}}}));
  }

 private:
  void save(double time_step, const json& stages) const {
    json material = {{"density", stone_.density}};
    if (stone_.young > 0) {
      material["young"] = stone_.young;
    }
    const json head = {{"title", title_},
                       {"parameters", {{"phi", stone_.friction_deg}}},
                       {"materials", {{"stone", material}}},
                       {"joint", {{"friction_angle_deg", "=phi"}}},
                       {"time_step", time_step},
                       {"stages", stages},
                       {"monitors", monitors_}};
    std::string text = "{\n";
    for (const auto& [key, value] : head.items()) {
      text += "  " + json(key).dump() + ": " + value.dump() + ",\n";
    }
    text += "  \"blocks\": [\n";
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      text += "    " + blocks_[b].dump() + (b + 1 < blocks_.size() ? ",\n" : "\n");
    }
    write(text + "  ]\n}\n");
  }

  void write(const std::string& text) const {
    if (stone_.out.empty()) {
      std::fputs(text.c_str(), stdout);
      return;
    }
    std::ofstream file(stone_.out);
    file << text;
    file.close();
    if (!file) {
      throw scene_file::FileError(stone_.out + ": can't be written");
    }
  }

  const Stone& stone_;
  std::string title_;
  json blocks_ = json::array();
  json monitors_ = json::array();
};

std::string numbered(const std::string& stem, int number) { return stem + std::to_string(number); }

std::string numbered(const std::string& stem, int first, int second) {
  return stem + std::to_string(first) + "_" + std::to_string(second);
}

struct Wall {
  double length = 4, height = 2, thickness = 0.3, block_length = 0.8, block_height = 0.25;  // m
};

/// Running bond: every second course begins with half a block.
void make_wall(const Stone& stone, const Wall& wall) {
  Made made(stone, "Wall in running bond");
  made.add_fixed("ground", box({-0.5, -1, -0.3}, {wall.length + 0.5, wall.thickness + 1, 0}));
  const int courses = std::max(1, static_cast<int>(std::lround(wall.height / wall.block_height)));
  std::string last;
  for (int course = 0; course < courses; ++course) {
    const double z = course * wall.block_height;
    double from = 0.0;
    for (int i = 0; from < wall.length - 1e-9; ++i) {
      const double full = course % 2 == 1 && i == 0 ? 0.5 : 1.0;
      double to = from + full * wall.block_length;
      to = to > wall.length - 0.25 * wall.block_length ? wall.length : to;
      last = numbered("brick", course, i);
      made.add_box(last, {from, 0, z}, {to - from, wall.thickness, wall.block_height});
      from = to;
    }
  }
  made.watch(last);
  made.save_standing(1e-3);
}

struct Arch {
  double radius = 5, thickness = 0.8, width = 1, angle_deg = 180;  // m
  int blocks = 21;
};

/// Voussoirs of equal angle; one more at either end is the abutment.
void make_arch(const Stone& stone, const Arch& arch) {
  Made made(stone, "Circular arch");
  const double step = arch.angle_deg * kDegree / arch.blocks;
  const auto at = [&](double radius, int joint) {
    const double angle = -0.5 * arch.angle_deg * kDegree + joint * step;
    return Vector3(radius * std::sin(angle), 0, radius * std::cos(angle));
  };
  const double outer = arch.radius + arch.thickness;
  for (int i = -1; i <= arch.blocks; ++i) {
    const json shape =
        prism({at(arch.radius, i), at(outer, i), at(outer, i + 1), at(arch.radius, i + 1)},
              {0, arch.width, 0});
    if (i < 0 || i == arch.blocks) {
      made.add_fixed(i < 0 ? "left" : "right", shape);
    } else {
      made.add(numbered("voussoir", i), shape);
    }
  }
  made.watch(numbered("voussoir", arch.blocks / 2));
  made.save_standing(1e-2);
}

struct Dome {
  double radius = 4, thickness = 0.5, oculus_deg = 15;  // m
  int rings = 6, segments = 16;
};

/// Rings of equal angle over the horizon, all head joints in meridian planes.
void make_dome(const Stone& stone, const Dome& dome) {
  Made made(stone, "Hemispherical dome with an oculus");
  const double outer = dome.radius + dome.thickness, reach = 1.2 * outer;
  made.add_fixed("ground", box({-reach, -reach, -0.3}, {reach, reach, 0}));
  const double rise = (90 - dome.oculus_deg) * kDegree / dome.rings;
  const double turn = 2 * std::numbers::pi / dome.segments;
  for (int ring = 0; ring < dome.rings; ++ring) {
    for (int segment = 0; segment < dome.segments; ++segment) {
      std::vector<Vector3> corners;
      for (int corner = 0; corner < 8; ++corner) {
        const double up = (ring + (corner >> 2 & 1)) * rise;
        const double around = (segment + (corner >> 1 & 1)) % dome.segments * turn;
        corners.push_back((corner & 1 ? outer : dome.radius) *
                          Vector3(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                                  std::sin(up)));
      }
      made.add(numbered("stone", ring, segment), {{"type", "hull"}, {"points", points(corners)}});
    }
  }
  made.watch(numbered("stone", dome.rings - 1, 0));
  made.save_standing(1e-2);
}

struct Tower {
  double width = 1, block_height = 0.5;  // m
  int blocks = 8;
};

void make_tower(const Stone& stone, const Tower& tower) {
  Made made(stone, "Tower of blocks");
  const double w = tower.width;
  made.add_fixed("ground", box({-w, -w, -0.3}, {2 * w, 2 * w, 0}));
  for (int i = 0; i < tower.blocks; ++i) {
    made.add(numbered("drum", i),
             box({0, 0, i * tower.block_height}, {w, w, (i + 1) * tower.block_height}));
  }
  made.watch(numbered("drum", tower.blocks - 1));
  made.save_standing(1e-3);
}

struct Stair {
  double run = 0.3, rise = 0.17, width = 1.2;  // m
  int steps = 8;
};

/// Slabs on each other, each shorter by one run than the one below.
void make_stair(const Stone& stone, const Stair& stair) {
  Made made(stone, "Flight of stone slabs");
  const double length = stair.steps * stair.run;
  made.add_fixed("ground", box({-0.5, -0.5, -0.3}, {length + 0.5, stair.width + 0.5, 0}));
  for (int i = 0; i < stair.steps; ++i) {
    made.add(numbered("step", i),
             box({i * stair.run, 0, i * stair.rise}, {length, stair.width, (i + 1) * stair.rise}));
  }
  made.watch(numbered("step", stair.steps - 1));
  made.save_standing(1e-3);
}

struct Slope {
  double height = 10, plunge_deg = 35, wedge_angle_deg = 90, face_dip_deg = 65, run_out = 5;  // m
};

/// A symmetrical wedge on two joint planes that meet in a line of the given plunge, which daylights
/// at the toe (the origin); the slope's face dips towards +x, its top is level. Source of its
/// factor of safety, friction alone: tan(phi) / (tan(plunge) sin(wedge_angle / 2)), [Hoek & Bray
/// 1981], wedge failure with equal friction angles.
void make_slope(const Stone& stone, const Slope& slope) {
  const double plunge = slope.plunge_deg * kDegree, half = 0.5 * slope.wedge_angle_deg * kDegree;
  if (!(slope.face_dip_deg > slope.plunge_deg)) {
    throw CLI::ValidationError("--face-dip-deg",
                               "must be greater than --plunge-deg, or no wedge daylights");
  }
  Made made(stone, "Rock slope with a wedge");
  const Vector3 down(std::cos(plunge), 0, -std::sin(plunge));
  const Vector3 toe = Vector3::Zero(), back = -down * (slope.height / std::sin(plunge));
  const double crest_x = -slope.height / std::tan(slope.face_dip_deg * kDegree);
  std::vector<Vector3> wedge = {toe, back};
  for (const double side : {1.0, -1.0}) {
    // Normal of the joint plane, into the wedge.
    const Vector3 normal(std::sin(half) * std::sin(plunge), -side * std::cos(half),
                         std::sin(half) * std::cos(plunge));
    const double y = -(normal.x() * crest_x + normal.z() * slope.height) / normal.y();
    const Vector3 crest(crest_x, y, slope.height);
    wedge.push_back(crest);
    const Vector3 run = slope.run_out * down;
    made.add_fixed(side > 0 ? "left_wall" : "right_wall",
                   prism({back, toe + run, crest + run, crest}, -0.3 * slope.height * normal));
  }
  made.add("wedge", {{"type", "hull"}, {"points", points(wedge)}});
  made.watch("wedge");
  made.save_moving(1e-2, 1.0);
}

struct Pile {
  double size = 0.5;  // m
  int blocks = 60, seed = 1;
};

/// Boxes of sides 0.6 to 1 of the size, turned at random, over each other with room between: they
/// fall.
void make_pile(const Stone& stone, const Pile& pile) {
  Made made(stone, "Blocks falling on a pile");
  std::mt19937_64 random(static_cast<std::uint64_t>(pile.seed));
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  const int across = std::max(1, static_cast<int>(std::lround(std::cbrt(pile.blocks / 2.0))));
  const double pitch = std::sqrt(3.0) * pile.size, reach = (across + 4) * pitch;
  made.add_fixed("ground", box({-reach, -reach, -0.3}, {reach, reach, 0}));
  for (int i = 0; i < pile.blocks; ++i) {
    const int layer = i / (across * across), row = i / across % across, column = i % across;
    const Vector3 middle((column - 0.5 * (across - 1)) * pitch, (row - 0.5 * (across - 1)) * pitch,
                         (layer + 0.55) * pitch);
    const Vector3 half =
        0.5 * pile.size * Vector3(uniform(0.6, 1), uniform(0.6, 1), uniform(0.6, 1));
    const Eigen::Quaterniond turn =
        Eigen::AngleAxisd(uniform(0, std::numbers::pi),
                          Vector3(uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)).normalized()) *
        Eigen::Quaterniond::Identity();
    made.add_turned(numbered("rock", i), box(middle - half, middle + half), turn, middle);
  }
  made.watch(numbered("rock", pile.blocks - 1));
  made.save_moving(5e-3, 2.0);
}

/// One shape of the command: its options, in the order of the help text.
class ShapeOptions {
 public:
  ShapeOptions(CLI::App& make, const char* name, const char* what, std::shared_ptr<Stone> stone,
               int& exit_code)
      : command_(make.add_subcommand(name, what)),
        stone_(std::move(stone)),
        exit_code_(exit_code) {}

  ShapeOptions& length(const char* name, double& value, const char* what) {
    return number(name, value, what, 1e-6, 1e6);
  }
  ShapeOptions& angle(const char* name, double& value, double most) {
    return number(name, value, "degrees", 1e-3, most);
  }
  ShapeOptions& count(const char* name, int& value, int least) {
    command_->add_option(name, value)->check(CLI::Range(least, 1000000))->capture_default_str();
    return *this;
  }
  void end(const std::function<void(const Stone&)>& make) {
    number("--density", stone_->density, "kg/m3", 1e-6, 1e9);
    command_->add_option("--young", stone_->young, "Pa; 0: rigid blocks")
        ->check(CLI::Range(0.0, 1e15))
        ->capture_default_str();
    command_->add_option("--friction-deg", stone_->friction_deg, "degrees")
        ->check(CLI::Range(0.0, 89.0))
        ->capture_default_str();
    command_
        ->add_option("--end-time", stone_->end_time,
                     "s of motion (default: none after rest; slope 1, pile 2)")
        ->check(CLI::Range(0.0, 1e9));
    command_->add_option("--out", stone_->out, "file (default: standard output)");
    command_->callback([stone = stone_, make, &exit_code = exit_code_] {
      make(*stone);
      exit_code = kDone;
    });
  }

 private:
  ShapeOptions& number(const char* name, double& value, const char* what, double least,
                       double most) {
    command_->add_option(name, value, what)->check(CLI::Range(least, most))->capture_default_str();
    return *this;
  }

  CLI::App* command_;
  std::shared_ptr<Stone> stone_;
  int& exit_code_;
};

}  // namespace

void add_make_command(CLI::App& app, int& exit_code) {
  CLI::App* make = app.add_subcommand(
      "make", "Write a scene to read and change: wall, arch, dome, tower, stair, slope, pile");
  make->require_subcommand(1);
  const auto stone = std::make_shared<Stone>();
  const auto shape = [&](const char* name, const char* what) {
    return ShapeOptions(*make, name, what, stone, exit_code);
  };
  const auto wall = std::make_shared<Wall>();
  shape("wall", "A wall in running bond on the ground")
      .length("--length", wall->length, "m")
      .length("--height", wall->height, "m, to whole courses")
      .length("--thickness", wall->thickness, "m")
      .length("--block-length", wall->block_length, "m")
      .length("--block-height", wall->block_height, "m")
      .end([wall](const Stone& s) { make_wall(s, *wall); });
  const auto arch = std::make_shared<Arch>();
  shape("arch", "A circular arch between two abutments")
      .length("--radius", arch->radius, "m, of the intrados")
      .length("--thickness", arch->thickness, "m")
      .length("--width", arch->width, "m")
      .angle("--angle-deg", arch->angle_deg, 270)
      .count("--blocks", arch->blocks, 2)
      .end([arch](const Stone& s) { make_arch(s, *arch); });
  const auto dome = std::make_shared<Dome>();
  shape("dome", "A hemispherical dome with an oculus")
      .length("--radius", dome->radius, "m, of the intrados")
      .length("--thickness", dome->thickness, "m")
      .angle("--oculus-deg", dome->oculus_deg, 80)
      .count("--rings", dome->rings, 1)
      .count("--segments", dome->segments, 3)
      .end([dome](const Stone& s) { make_dome(s, *dome); });
  const auto tower = std::make_shared<Tower>();
  shape("tower", "Square blocks on each other")
      .length("--width", tower->width, "m")
      .length("--block-height", tower->block_height, "m")
      .count("--blocks", tower->blocks, 1)
      .end([tower](const Stone& s) { make_tower(s, *tower); });
  const auto stair = std::make_shared<Stair>();
  shape("stair", "Slabs on each other, each shorter by one run")
      .length("--run", stair->run, "m")
      .length("--rise", stair->rise, "m")
      .length("--width", stair->width, "m")
      .count("--steps", stair->steps, 1)
      .end([stair](const Stone& s) { make_stair(s, *stair); });
  const auto slope = std::make_shared<Slope>();
  shape("slope", "A wedge on two joint planes of a rock slope")
      .length("--height", slope->height, "m")
      .angle("--plunge-deg", slope->plunge_deg, 89)
      .angle("--wedge-angle-deg", slope->wedge_angle_deg, 179)
      .angle("--face-dip-deg", slope->face_dip_deg, 90)
      .length("--run-out", slope->run_out, "m, of the planes beyond the toe")
      .end([slope](const Stone& s) { make_slope(s, *slope); });
  const auto pile = std::make_shared<Pile>();
  shape("pile", "Boxes turned at random that fall on the ground")
      .length("--size", pile->size, "m, longest side")
      .count("--blocks", pile->blocks, 1)
      .count("--seed", pile->seed, 0)
      .end([pile](const Stone& s) { make_pile(s, *pile); });
}

}  // namespace quoin::commands
