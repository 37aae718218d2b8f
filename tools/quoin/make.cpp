/// quoin make SHAPE

#include <cmath>
#include <memory>

#include "commands.hpp"
#include "in_range.hpp"
#include "made_scene.hpp"
#include "moving_scenes.hpp"
#include "path_to_write.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using Vector3 = Eigen::Vector3d;

void make_wall(const Stone& stone, const Wall& wall) {
  Made made(stone, "Wall in running bond", bricks(wall));
  made.watch(lay_wall(wall, made));
  made.save_standing(1e-3);
}

struct Arch {
  double radius = 5, thickness = 0.8, width = 1, angle_deg = 180, fill = 0;  // m
  int blocks = 21;
};

constexpr double kFillDensity = 1800;  // kg/m3

/// Voussoirs of equal angle; one more at either end is the abutment. Fill is a column on each,
/// level at its top; columns bear on each other without friction, and those on abutments are fixed.
void make_arch(const Stone& stone, const Arch& arch) {
  if (arch.angle_deg * (arch.blocks + 2) > 360.0 * arch.blocks) {
    throw CLI::ValidationError("--angle-deg",
                               "must leave room for two abutments, each as wide as a block");
  }
  if (arch.fill > 0 && arch.angle_deg * (1.0 + 2.0 / arch.blocks) > 180.0)
    throw CLI::ValidationError("--fill", "lies on arches of up to 180 degrees, abutments included");
  Made made(stone, "Circular arch", arch.blocks);
  const double step = arch.angle_deg * kDegree / arch.blocks;
  const auto at = [&](double radius, int joint) {
    const double angle = -0.5 * arch.angle_deg * kDegree + joint * step;
    return Vector3(radius * std::sin(angle), 0, radius * std::cos(angle));
  };
  const double outer = arch.radius + arch.thickness, level = outer + arch.fill;
  if (arch.fill > 0) made.add_smooth_material("fill", kFillDensity);
  for (int i = -1; i <= arch.blocks; ++i) {
    const bool is_abutment = i < 0 || i == arch.blocks;
    const Vector3 from = at(outer, i), to = at(outer, i + 1);
    const json voussoir =
        prism({at(arch.radius, i), from, to, at(arch.radius, i + 1)}, {0, arch.width, 0});
    json& block = is_abutment ? made.add_fixed(i < 0 ? "left" : "right", voussoir)
                              : made.add(numbered("voussoir", i), voussoir);
    if (!(arch.fill > 0)) continue;
    const json column =
        prism({from, to, {to.x(), 0, level}, {from.x(), 0, level}}, {0, arch.width, 0});
    if (is_abutment) {
      block.erase("shape");
      block["parts"] = {voussoir, column};
    } else {
      made.add(numbered("fill", i), column).update(json{{"kind", "rigid"}, {"material", "fill"}});
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
  Made made(stone, "Hemispherical dome with an oculus",
            static_cast<double>(dome.rings) * dome.segments);
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
      made.add(numbered("stone", ring, segment), hull(corners));
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
  Made made(stone, "Tower of blocks", tower.blocks);
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
  Made made(stone, "Flight of stone slabs", stair.steps);
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
  Made made(stone, "Rock slope with a wedge", 1);
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
  made.add("wedge", hull(wedge));
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
  Made made(stone, "Blocks falling on a pile", pile.blocks);
  Uniform uniform(pile.seed);
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
  ShapeOptions& number(const char* name, double& value, const char* what, double least,
                       double most) {
    command_->add_option(name, value, what)->check(in_range(least, most))->capture_default_str();
    return *this;
  }

  ShapeOptions& count(const char* name, int& value, int least) {
    command_->add_option(name, value)->check(CLI::Range(least, kMostBlocks))->capture_default_str();
    return *this;
  }
  void end(const std::function<void(const Stone&)>& make) {
    number("--density", stone_->density, "kg/m3", 1e-6, 1e9);
    number("--push", stone_->push, "of each block's weight along x: load \"push\" of quoin limit",
           0, 1e6);
    command_->add_option("--young", stone_->young, "Pa; 0: rigid blocks")
        ->check(in_range(0.0, 1e15))
        ->capture_default_str();
    command_->add_option("--friction-deg", stone_->friction_deg, "degrees")
        ->check(in_range(0.0, 89.0))
        ->capture_default_str();
    command_
        ->add_option("--end-time", stone_->end_time,
                     "s of motion (default: of wall, arch, dome, tower and stair none after rest; "
                     "shaken-wall, pile 2; bin 10, or until rest; else 1)")
        ->check(in_range(1e-6, 1e9));
    command_->add_option("--out", stone_->out, "new file (default: standard output)")
        ->check(path_to_write());
    command_->callback([stone = stone_, make, &exit_code = exit_code_] {
      make(*stone);
      exit_code = kDone;
    });
  }

 private:
  CLI::App* command_;
  std::shared_ptr<Stone> stone_;
  int& exit_code_;
};

/// Options of the shapes, by their names in the help text.
class ShapeList {
 public:
  ShapeList(CLI::App& make, int& exit_code) : make_(make), exit_code_(exit_code) {}
  ShapeOptions add(const char* name, const char* what) {
    return {make_, name, what, stone_, exit_code_};
  }
  ShapeOptions add_wall(const char* name, const char* what, Wall& wall) {
    return add(name, what)
        .length("--length", wall.length, "m")
        .length("--height", wall.height, "m, to whole courses")
        .length("--thickness", wall.thickness, "m")
        .length("--block-length", wall.block_length, "m")
        .length("--block-height", wall.block_height, "m");
  }

 private:
  CLI::App& make_;
  int& exit_code_;
  std::shared_ptr<Stone> stone_ = std::make_shared<Stone>();
};

void add_walls(ShapeList& shapes) {
  const auto wall = std::make_shared<Wall>();
  shapes.add_wall("wall", "A wall in running bond on the ground", *wall)
      .end([wall](const Stone& s) { make_wall(s, *wall); });
  const auto shaking = std::make_shared<Shaking>();
  shapes.add_wall("shaken-wall", "The wall at rest, then shaken by the ground", *wall)
      .number("--peak", shaking->peak, "g, of the ground's acceleration", 1e-6, 1e3)
      .number("--hz", shaking->hz, "Hz; the time step is a 20th of the period, at most 0.005 s",
              1e-6, 1e6)
      .number("--direction-deg", shaking->direction_deg, "degrees; 0: along the wall", 0, 360)
      .end([wall, shaking](const Stone& s) { make_shaken_wall(s, *wall, *shaking); });
  const auto hammer = std::make_shared<Hammer>();
  shapes.add_wall("struck-wall", "The wall at rest, then hit by a flying cube", *wall)
      .number("--mass", hammer->mass, "kg, of the cube", 1e-6, 1e12)
      .number("--speed", hammer->speed, "m/s, of the cube", 1e-6, 1e6)
      .end([wall, hammer](const Stone& s) { make_struck_wall(s, *wall, *hammer); });
}

void add_curved(ShapeList& shapes) {
  const auto arch = std::make_shared<Arch>();
  shapes.add("arch", "A circular arch between two abutments")
      .length("--radius", arch->radius, "m, of the intrados")
      .length("--thickness", arch->thickness, "m")
      .length("--width", arch->width, "m")
      .angle("--angle-deg", arch->angle_deg, 270)
      .count("--blocks", arch->blocks, 2)
      .number("--fill", arch->fill, "m of fill above the crown, a column on each block; 0: none", 0,
              1e6)
      .end([arch](const Stone& s) { make_arch(s, *arch); });
  const auto dome = std::make_shared<Dome>();
  shapes.add("dome", "A hemispherical dome with an oculus")
      .length("--radius", dome->radius, "m, of the intrados")
      .length("--thickness", dome->thickness, "m")
      .angle("--oculus-deg", dome->oculus_deg, 80)
      .count("--rings", dome->rings, 1)
      .count("--segments", dome->segments, 3)
      .end([dome](const Stone& s) { make_dome(s, *dome); });
  const auto vault = std::make_shared<Vault>();
  shapes.add("vault", "A barrel vault in bond at rest on piers, then without one of them")
      .length("--radius", vault->radius, "m, of the intrados")
      .length("--thickness", vault->thickness, "m")
      .length("--length", vault->length, "m")
      .length("--block-length", vault->block_length, "m")
      .length("--pier-height", vault->pier_height, "m")
      .count("--courses", vault->courses, 3)
      .count("--piers", vault->piers, 1)
      .end([vault](const Stone& s) { make_vault(s, *vault); });
}

void add_straight(ShapeList& shapes) {
  const auto tower = std::make_shared<Tower>();
  shapes.add("tower", "Square blocks on each other")
      .length("--width", tower->width, "m")
      .length("--block-height", tower->block_height, "m")
      .count("--blocks", tower->blocks, 1)
      .end([tower](const Stone& s) { make_tower(s, *tower); });
  const auto stair = std::make_shared<Stair>();
  shapes.add("stair", "Slabs on each other, each shorter by one run")
      .length("--run", stair->run, "m")
      .length("--rise", stair->rise, "m")
      .length("--width", stair->width, "m")
      .count("--steps", stair->steps, 1)
      .end([stair](const Stone& s) { make_stair(s, *stair); });
}

void add_slopes_and_piles(ShapeList& shapes) {
  const auto slope = std::make_shared<Slope>();
  shapes.add("slope", "A wedge on two joint planes of a rock slope")
      .length("--height", slope->height, "m")
      .angle("--plunge-deg", slope->plunge_deg, 89)
      .angle("--wedge-angle-deg", slope->wedge_angle_deg, 179)
      .angle("--face-dip-deg", slope->face_dip_deg, 90)
      .length("--run-out", slope->run_out, "m, of the planes beyond the toe")
      .end([slope](const Stone& s) { make_slope(s, *slope); });
  const auto jointed = std::make_shared<JointedSlope>();
  shapes.add("jointed-slope", "Sheets of blocks on a plane at rest, then without their toe")
      .angle("--dip-deg", jointed->dip_deg, 89)
      .length("--block-length", jointed->block_length, "m, along the dip")
      .length("--block-width", jointed->block_width, "m")
      .length("--block-height", jointed->block_height, "m")
      .count("--rows", jointed->rows, 1)
      .count("--columns", jointed->columns, 1)
      .count("--sheets", jointed->sheets, 1)
      .end([jointed](const Stone& s) { make_jointed_slope(s, *jointed); });
  const auto pile = std::make_shared<Pile>();
  shapes.add("pile", "Boxes turned at random that fall on the ground")
      .length("--size", pile->size, "m, longest side")
      .count("--blocks", pile->blocks, 1)
      .count("--seed", pile->seed, 0)
      .end([pile](const Stone& s) { make_pile(s, *pile); });
  const auto bin = std::make_shared<Bin>();
  shapes.add("bin", "Hulls of random points that fall into a bin and come to rest")
      .length("--size", bin->size, "m, at most across")
      .count("--blocks", bin->blocks, 1)
      .count("--seed", bin->seed, 0)
      .end([bin](const Stone& s) { make_bin(s, *bin); });
}

}  // namespace

void add_make_command(CLI::App& app, int& exit_code) {
  CLI::App* make = app.add_subcommand(
      "make", "Write a scene to read and change: structures that stand, and moving ones");
  make->require_subcommand(0, 1);  // before it a name that is none would be told as a lack of one
  make->callback([make] {
    if (make->get_subcommands().empty())
      throw CLI::RequiredError("a shape (quoin make --help names them)");
  });
  ShapeList shapes(*make, exit_code);
  add_walls(shapes);
  add_curved(shapes);
  add_straight(shapes);
  add_slopes_and_piles(shapes);
}

}  // namespace quoin::commands
