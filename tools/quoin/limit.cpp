/// quoin limit SCENE.json --vary WHAT

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/solver/equilibrium.hpp>

#include "commands.hpp"
#include "in_range.hpp"
#include "output_folder.hpp"
#include "scene_file/read_json.hpp"
#include "scene_file/scene_file.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using scene_file::SceneError;
using solver::Equilibrium;
using solver::EquilibriumProblem;
using solver::EquilibriumVerdict;
using solver::Scene;
using solver::Vector3;
using solver::Vector6;

struct LimitArguments {
  std::string scene, vary, out;
  std::vector<std::string> changes;
  double tolerance = 1e-4;
  bool json = false;
};

/// What is varied, from where to where.
struct Vary {
  std::string what, name;
  double from = 0.0, to = 0.0;
  Vector3 axis = Vector3::UnitY();
};

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw std::invalid_argument("--vary " + text + ": " + why);
}

double number(const std::string& text, const std::string& whole) {
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !std::isfinite(value)) {
    refuse(whole, "\"" + text + "\" is no number");
  }
  return value;
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) c == at ? (void)parts.emplace_back() : parts.back().push_back(c);
  return parts;
}

Vary parse(const std::string& text) {
  Vary vary;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) refuse(text, "has to be WHAT=FROM:TO");
  vary.what = text.substr(0, equals);
  std::vector<std::string> parts = split(text.substr(equals + 1), ':');
  if (vary.what == "load") {
    if (parts.size() != 3) refuse(text, "has to be load=NAME:FROM:TO");
    vary.name = parts.front();
    parts.erase(parts.begin());
  } else if (vary.what == "tilt" && parts.size() == 3) {
    const std::size_t axis = std::string("xyz").find(parts[2]);
    if (parts[2].size() != 1 || axis == std::string::npos) refuse(text, "the axis is x, y or z");
    vary.axis = Vector3::Unit(static_cast<Eigen::Index>(axis));
    parts.pop_back();
  } else if (vary.what != "tilt" && vary.what != "strength" && vary.what != "friction" &&
             !vary.what.starts_with("/")) {
    refuse(text, "can vary load, tilt, strength, friction or a JSON pointer");
  }
  if (parts.size() != 2) refuse(text, "has to be WHAT=FROM:TO");
  vary.from = number(parts[0], text);
  vary.to = number(parts[1], text);
  if (!(vary.from < vary.to)) refuse(text, "FROM must be less than TO");
  if (vary.what == "strength" && !(vary.from > 0.0)) refuse(text, "must be greater than 0");
  if (vary.what == "friction" && !(vary.from >= 0.0 && vary.to < 90.0)) {
    refuse(text, "angles lie in [0, 90) degrees");
  }
  return vary;
}

template <class Change>
void change_joints(Scene& scene, const Change& change) {
  change(scene.joint);
  for (solver::PairJoint& pair : scene.pair_joints) change(pair.joint);
}

/// One value, what was solved there and what came out.
struct Trial {
  double value = 0.0;
  Scene scene{};
  EquilibriumProblem problem{};
  double factor = 0.0;
  Equilibrium found{};
};

/// Scenes by value.
class VariedScene {
 public:
  VariedScene(const LimitArguments& arguments, const Vary& vary)
      : arguments_(arguments),
        vary_(vary),
        scene_(scene_file::read_scene(arguments.scene, arguments.changes).scene) {
    if (vary.what != "load") return;
    live_ = scene_;
    live_.gravity = Vector3(0, 0, 0);
    part_loads();
    problem_ = solver::equilibrium_problem(scene_);
    const std::vector<Vector6> live = solver::block_loads(live_);
    for (std::size_t b = 0; b < live.size(); ++b) {
      problem_.blocks[b].live = live[b];
      problem_.blocks[b].load += vary.from * live[b];
    }
  }

  Trial at(double value) {
    Trial trial{value, scene_, problem_, value - vary_.from};
    if (vary_.what != "load") {
      trial.factor = 0.0;
      trial.scene = scene_at(value);
      trial.problem = solver::equilibrium_problem(trial.scene);
    }
    trial.found = solver::find_equilibrium(trial.problem, trial.factor);
    factorizations += trial.found.factorizations;
    return trial;
  }

  /// Of a load: the convex problem.
  Equilibrium largest() {
    const Equilibrium found = solver::largest_load_factor(problem_, vary_.to - vary_.from);
    factorizations += found.factorizations;
    return found;
  }

  int factorizations = 0;

 private:
  Scene scene_at(double value) const {
    Scene scene = scene_;
    if (vary_.what == "tilt") {
      const double angle = value * std::numbers::pi / 180.0;  // the ground turns by it, not gravity
      const Vector3 gravity = scene.gravity.at(0.0);
      scene.gravity = Vector3(Eigen::AngleAxisd(-angle, vary_.axis) * gravity);
    } else if (vary_.what == "strength") {
      change_joints(scene, [&](solver::Joint& joint) {
        joint.friction_angle = std::atan(std::tan(joint.friction_angle) / value);
        joint.cohesion /= value;
        joint.tension /= value;
      });
    } else if (vary_.what == "friction") {
      change_joints(scene, [&](solver::Joint& joint) {
        joint.friction_angle = value * std::numbers::pi / 180.0;
      });
    } else {
      std::vector<std::string> changes = arguments_.changes;
      char text[64];
      std::snprintf(text, sizeof text, "=%.17g", value);
      changes.push_back(vary_.what + text);
      scene = scene_file::read_scene(arguments_.scene, changes).scene;
    }
    return scene;
  }

  /// Loads of that name stay in live_ alone. Lists of the scene keep the order of the file.
  void part_loads() {
    const nlohmann::json document = scene_file::read_json(arguments_.scene);
    std::vector<char> named[3];
    for (const auto& load : document.value("loads", nlohmann::json::array())) {
      const std::string type = load.at("type");
      const int kind = type == "point" ? 0 : type == "face" ? 1 : 2;
      named[kind].push_back(load.value("name", "") == vary_.name);
    }
    bool any = false;
    const auto part = [&](auto& dead, auto& live, const std::vector<char>& is_live) {
      std::size_t i = 0;
      std::erase_if(dead, [&](const auto&) { return is_live.at(i++) != 0; });
      i = 0;
      std::erase_if(live, [&](const auto&) { return is_live.at(i++) == 0; });
      any = any || !live.empty();
    };
    part(scene_.point_loads, live_.point_loads, named[0]);
    part(scene_.face_loads, live_.face_loads, named[1]);
    part(scene_.body_loads, live_.body_loads, named[2]);
    if (!any) throw SceneError("/loads", "there is no load named \"" + vary_.name + "\"");
  }

  const LimitArguments& arguments_;
  const Vary& vary_;
  Scene scene_, live_{};
  EquilibriumProblem problem_{};  ///< of a load: with what `from` takes of it
};

/// What is known: where it stands, where it falls.
struct Limit {
  std::unique_ptr<Trial> stands{}, falls{};
  double convex = std::numeric_limits<double>::quiet_NaN();  ///< of a load: the problem's answer
  std::string why{};  ///< why the two are farther apart than the tolerance; empty: they are not
};

bool keep(Trial trial, Limit& limit) {
  if (trial.found.verdict == EquilibriumVerdict::Undecided) return false;
  auto& place = trial.found.verdict == EquilibriumVerdict::Admissible ? limit.stands : limit.falls;
  place = std::make_unique<Trial>(std::move(trial));
  return true;
}

/// Proofs on both sides of the convex problem's answer.
void prove_load(const Vary& vary, double tolerance, VariedScene& scenes, Limit& limit) {
  const Equilibrium found = scenes.largest();  // an undecided one is a good guess all the same
  if (found.verdict == EquilibriumVerdict::Mechanism || !found.limited) {
    const bool falls = found.verdict == EquilibriumVerdict::Mechanism;
    const double end = falls ? vary.from : vary.to;
    if (!keep(scenes.at(end), limit)) limit.why = "neither is proved there";
    return;
  }
  limit.convex = vary.from + found.factor;
  double width = 0.5 * tolerance * std::max(std::abs(limit.convex), 1e-3 * (vary.to - vary.from));
  for (int i = 0; i < 4 && !(limit.stands && limit.falls); ++i, width *= 10.0) {
    if (!limit.stands) keep(scenes.at(std::max(vary.from, limit.convex - width)), limit);
    if (!limit.falls) keep(scenes.at(limit.convex + width), limit);
    if (i > 0) limit.why = "nearer to the limit neither is proved";
  }
}

void bisect(const Vary& vary, double tolerance, VariedScene& scenes, Limit& limit) {
  for (const double end : {vary.from, vary.to}) {
    if (!keep(scenes.at(end), limit)) limit.why = "neither is proved at an end of the range";
  }
  while (limit.stands && limit.falls) {
    const double low = limit.stands->value, high = limit.falls->value;
    const double size = std::max({std::abs(low), std::abs(high), 1e-3 * (vary.to - vary.from)});
    if (!(std::abs(high - low) > tolerance * size)) return;
    bool decided = false;
    for (const double share : {0.5, 0.4, 0.6, 0.25, 0.75}) {
      decided = decided || keep(scenes.at(low + share * (high - low)), limit);
    }
    if (decided) continue;
    limit.why = "between them neither is proved";
    return;
  }
}

json vector_json(const Eigen::VectorXd& v) { return std::vector<double>(v.begin(), v.end()); }

/// All that checks it: see tools/guides/limit.md.
json certificate(const Trial& trial) {
  const Scene& scene = trial.scene;
  json blocks = json::array(), contacts = json::array(), joints = json::array();
  for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
    const solver::Block& block = scene.blocks[b];
    const solver::EquilibriumBlock& solved = trial.problem.blocks[b];
    if (block.kind == solver::BlockKind::Absent) continue;
    json vertices = json::array();
    for (int v = 0; v < block.shape->vertex_count(); ++v) {
      vertices.push_back(vector_json(block.body().vertex(v)));
    }
    Vector6 applied = solved.load;
    if (solved.moves) {
      applied.head<3>() -= block.material.density * geometry::mass_properties(block.body()).volume *
                           scene.gravity.at(0.0);
    }
    blocks.push_back({{"index", b},
                      {"name", block.name},
                      {"moves", solved.moves},
                      {"density", block.material.density},
                      {"group", block.material.joint_group},
                      {"vertices", vertices},
                      {"applied", vector_json(applied)},
                      {"live", vector_json(solved.live)},
                      {"velocity", vector_json(trial.found.velocities[b])}});
  }
  for (std::size_t i = 0; i < trial.problem.contacts.size(); ++i) {
    const solver::EquilibriumContact& contact = trial.problem.contacts[i];
    contacts.push_back({{"a", contact.a},
                        {"b", contact.b},
                        {"point", vector_json(contact.point + trial.problem.origin)},
                        {"normal", vector_json(contact.normal)},
                        {"held", contact.held},
                        {"force", vector_json(trial.found.forces[i])}});
  }
  const auto add_joint = [&](json groups, const solver::Joint& joint) {
    joints.push_back({{"groups", std::move(groups)},
                      {"friction", std::tan(joint.friction_angle)},
                      {"cohesion", joint.cohesion},
                      {"tension", joint.tension}});
  };
  add_joint(nullptr, scene.joint);
  for (const solver::PairJoint& pair : scene.pair_joints) {
    add_joint({pair.group_a, pair.group_b}, pair.joint);
  }
  const bool stands = trial.found.verdict == EquilibriumVerdict::Admissible;
  return {{"certificate", stands ? "stands" : "falls"},
          {"value", trial.value},
          {"factor", trial.factor},
          {"gravity", vector_json(scene.gravity.at(0.0))},
          {"joints", joints},
          {"blocks", blocks},
          {"contacts", contacts}};
}

json summary(const Trial* trial) {
  if (trial == nullptr) return nullptr;
  const Equilibrium& found = trial->found;
  if (found.verdict == EquilibriumVerdict::Admissible) {
    return {{"value", trial->value},
            {"unbalance", found.unbalance},
            {"violation", found.violation},
            {"margin", std::isfinite(found.margin) ? json(found.margin) : json()}};
  }
  return {{"value", trial->value},
          {"power", found.power},
          {"dissipation", found.dissipation},
          {"incompatibility", found.incompatibility}};
}

void print(const json& report) {
  const auto line = [&](const char* key, const char* text) {
    if (report[key].is_null()) {
      std::printf("  %s: not within the range\n", text);
    } else {
      std::printf("  %s %.9g\n", text, report[key]["value"].get<double>());
    }
  };
  std::printf("%s: %s\n", report["scene"].get<std::string>().c_str(),
              report["vary"].get<std::string>().c_str());
  line("stands", "admissible (forces within friction balance all loads) at");
  line("falls", "falls (proved, whatever the flow rule) at");
  if (!report["convex"].is_null()) {
    std::printf("  limit of the convex problem %.9g: an upper bound for Coulomb friction\n",
                report["convex"].get<double>());
  }
  if (!report["why"].is_null()) {
    std::printf("  farther apart than the tolerance: %s\n",
                report["why"].get<std::string>().c_str());
  }
  std::printf("  %d factorizations; admissible is no proof that loading reaches it\n",
              report["factorizations"].get<int>());
}

void write(OutputFolder& folder, const char* name, const json& document) {
  std::ofstream file(folder.file(name));
  file << text(document) << '\n';
  if (!file.flush()) throw scene_file::FileError(std::string(name) + ": can't be written");
}

int limit(const LimitArguments& arguments) {
  const Vary vary = parse(arguments.vary);
  VariedScene scenes(arguments, vary);
  Limit limit;
  if (vary.what == "load") {
    prove_load(vary, arguments.tolerance, scenes, limit);
  } else {
    bisect(vary, arguments.tolerance, scenes, limit);
  }
  const bool both = limit.stands && limit.falls;
  if (!both && limit.why.empty()) limit.why = "the range ends before";
  json report = {{"scene", arguments.scene},
                 {"vary", arguments.vary},
                 {"stands", summary(limit.stands.get())},
                 {"falls", summary(limit.falls.get())},
                 {"convex", std::isfinite(limit.convex) ? json(limit.convex) : json()},
                 {"why", limit.why.empty() ? json() : json(limit.why)},
                 {"factorizations", scenes.factorizations}};
  if (!arguments.out.empty()) {
    OutputFolder folder(arguments.out);
    write(folder, "limit.json", report);
    if (limit.stands) write(folder, "stands.json", certificate(*limit.stands));
    if (limit.falls) write(folder, "falls.json", certificate(*limit.falls));
    folder.commit(OutputFolder::Checkpoint::Drop);
  }
  arguments.json ? (void)std::printf("%s\n", text(report).c_str()) : print(report);
  return both && limit.why.empty() ? kDone : kFailed;
}

}  // namespace

void add_limit_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<LimitArguments>();
  CLI::App* command = app.add_subcommand(
      "limit",
      "How much a structure bears, with a proof on both sides: contact forces that balance all "
      "loads within friction, and a mechanism. Blocks count as rigid, as they stand at time 0.\n"
      "Above the mechanism nothing holds, whatever the flow rule; below it Coulomb friction may "
      "still let go: the answer is an upper bound.\n"
      "Exit codes: 0 both are proved within the tolerance, 1 not, 2 the input is refused.");
  command->add_option("scene", arguments->scene, "scene file, JSON")->required();
  command
      ->add_option("--vary", arguments->vary,
                   "load=NAME:FROM:TO (factor of the loads of that name), tilt=FROM:TO[:x|y|z] "
                   "(of the ground, degrees, default y), strength=FROM:TO (friction, cohesion and "
                   "tension are divided by it), friction=FROM:TO (angle of all joints, degrees), "
                   "/json/pointer=FROM:TO")
      ->required()
      ->type_name("WHAT=FROM:TO");
  command->add_option("--set", arguments->changes, "change the scene before it is read, as in run")
      ->type_name("NAME=VALUE");
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "how far apart the two proofs may be, relative")
      ->check(in_range(1e-7, 0.5))
      ->capture_default_str();
  command->add_option("--out", arguments->out,
                      "folder for limit.json and the certificates stands.json, falls.json");
  command->add_flag("--json", arguments->json, "the same as JSON");
  command->callback([arguments, &exit_code] {
    exit_code = run_guarded([&] { return limit(*arguments); }, arguments->scene);
  });
}

}  // namespace quoin::commands
