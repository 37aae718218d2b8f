/// quoin limit SCENE.json --vary WHAT

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>

#include "commands.hpp"
#include "in_range.hpp"
#include "limit/certificate.hpp"
#include "limit/loading.hpp"
#include "limit/proofs.hpp"
#include "limit/settlement.hpp"
#include "limit/single_blocks.hpp"
#include "limit/thrust.hpp"
#include "output_folder.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using limit_analysis::Limit;
using limit_analysis::Trial;
using limit_analysis::VariedScene;
using limit_analysis::Vary;

struct LimitArguments {
  std::string scene, vary, thrust, out;
  std::vector<std::string> changes;
  double tolerance = 1e-4;
  double loading = 60.0;  // wall time of the runs, s
  bool json = false, each = false;
};

/// On the last line of a terminal; nothing where standard error is none.
void show_progress(const std::string& line) {
  if (isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\r\033[K%s", line.c_str());
}

void end_progress() { show_progress(""); }

json number_or_null(const std::optional<double>& value) { return value ? json(*value) : json(); }

json reached_json(const limit_analysis::Reached& reached) {
  return {{"holds", number_or_null(reached.holds)},
          {"lost", number_or_null(reached.lost)},
          {"runs", reached.runs},
          {"why", reached.why.empty() ? json() : json(reached.why)}};
}

/// The three numbers that say what loading reaches; null what was not looked for.
/// `stands`: with brittle joints.
json loading_json(const LimitArguments& arguments, VariedScene& scenes, const Limit& limit,
                  const Trial* stands) {
  if (!(arguments.loading > 0.0) || !limit.stands) return nullptr;
  json result = {{"proved_upper_bound", limit.falls ? json(limit.falls->value) : json()}};
  const double half = 0.5 * arguments.loading;
  result["sudden"] =
      reached_json(limit_analysis::sudden_loading(scenes, limit, half, show_progress));
  result["gradual"] =
      reached_json(limit_analysis::gradual_loading(scenes, limit, half, show_progress));
  result["coulomb_mechanism"] = nullptr;
  if (const auto found = limit_analysis::coulomb_mechanism(scenes, limit, half, show_progress))
    result["coulomb_mechanism"] = {{"value", found->value}, {"excess", found->excess}};
  // The value nearest to the safe end of all that is lost, or falls.
  const bool rises = limit_analysis::rises(scenes.vary(), limit);
  std::optional<double> safe;
  if (stands != nullptr) safe = stands->value;
  const auto take = [&](const json& value) {
    if (value.is_null())
      safe.reset();
    else if (safe)
      safe = rises ? std::min(*safe, value.get<double>()) : std::max(*safe, value.get<double>());
  };
  take(result["sudden"]["holds"]);
  take(result["gradual"]["holds"]);
  if (!result["coulomb_mechanism"].is_null()) take(result["coulomb_mechanism"]["value"]);
  result["safe"] = number_or_null(safe);
  return result;
}

void print_reached(const char* how, const json& reached) {
  const auto at = [&](const char* key) {
    return reached[key].is_null() ? std::string("nowhere") : "at " + text(reached[key]);
  };
  std::printf("  %s loading, observed: holds %s, is lost %s", how, at("holds").c_str(),
              at("lost").c_str());
  const bool done = reached["why"].is_null();
  std::printf("%s\n", done ? "" : (" (" + reached["why"].get<std::string>() + ")").c_str());
}

void print_loading(const json& loading) {
  if (loading.is_null()) return;
  if (loading["safe"].is_null()) {
    std::printf("  no value is known that loading reaches\n");
  } else {
    std::printf("  safe to count on: %.6g, the least of what follows\n",
                loading["safe"].get<double>());
  }
  for (const char* how : {"sudden", "gradual"})
    if (loading.contains(how)) print_reached(how, loading[how]);
  if (const json found = loading.value("coulomb_mechanism", json()); !found.is_null()) {
    std::printf(
        "  a mechanism without dilation was found at %.6g (friction exceeded by %.1e of the "
        "largest load; lower ones may exist)\n",
        found["value"].get<double>(), found["excess"].get<double>());
  }
}

void print(const json& report) {
  const auto line = [&](const char* key, const char* text) {
    if (report[key].is_null())
      std::printf("  %s: not within the range\n", text);
    else
      std::printf("  %s %.9g\n", text, report[key]["value"].get<double>());
  };
  std::printf("%s: %s\n", words(report["scene"]), words(report["vary"]));
  print_loading(report["loading"]);
  line("stands", "admissible (forces within what joints bear balance all loads) at");
  line("falls", "falls (proved, whatever the flow rule) at");
  if (!report["convex"].is_null()) {
    std::printf("  limit of the convex problem %.9g: an upper bound for Coulomb friction\n",
                report["convex"].get<double>());
  }
  if (!report["why"].is_null()) {
    std::printf("  farther apart than the tolerance: %s\n", words(report["why"]));
  }
  std::printf("  %d factorizations; admissible is no proof that loading reaches it\n",
              report["factorizations"].get<int>());
}

void write(OutputFolder& folder, const char* name, const json& document) {
  std::ofstream file(folder.file(name));
  file << text(document) << '\n';
  if (!file.flush()) throw scene_file::FileError(std::string(name) + ": can't be written");
}

void write_trial(OutputFolder& folder, const std::string& name, const Trial* trial,
                 const Vary& vary) {
  if (trial == nullptr) return;
  write(folder, (name + ".json").c_str(), limit_analysis::certificate(*trial, vary));
  limit_analysis::write_vtk(folder.file(name + "_blocks.vtk"), folder.file(name + "_contacts.vtk"),
                            *trial);
}

/// `name`: of the report in the folder --out, into which `add` puts what is beside it.
int show(const LimitArguments& arguments, const json& report, void (*print_report)(const json&),
         int exit_code, const char* name, const std::function<void(OutputFolder&)>& add = {}) {
  if (!arguments.out.empty()) {
    OutputFolder folder(arguments.out);
    write(folder, name, report);
    if (add) add(folder);
    folder.commit(OutputFolder::Checkpoint::Drop);
  }
  arguments.json ? (void)std::printf("%s\n", text(report).c_str()) : print_report(report);
  return exit_code;
}

void print_blocks(const json& report) {
  std::printf("%s: every block alone, its neighbours fixed\n", words(report["scene"]));
  std::printf("  %-20s %12s  strength divided by: stands, falls\n", "key block", "volume, m3");
  for (const json& block : report["blocks"]) {
    if (!block["key"].get<bool>()) continue;
    const auto at = [&](const char* key) {
      return block[key].is_null() ? std::string("none") : text(block[key]);
    };
    std::printf("  %-20s %12.6g  %s, %s\n", words(block["name"]), block["volume"].get<double>(),
                at("stands").c_str(), at("falls").c_str());
  }
  std::printf("  %zu blocks move, %d of them could be taken out, %d are key blocks\n",
              report["blocks"].size(), report["removable"].get<int>(), report["keys"].get<int>());
  std::printf(
      "  upper bounds: a wedge may bear half; --vary strength shows what loading reaches\n");
}

int each(const LimitArguments& arguments) {
  const auto scene = scene_file::read_scene(arguments.scene, arguments.changes).scene;
  json blocks = json::array();
  int removable = 0, keys = 0;
  for (const auto& single : limit_analysis::single_blocks(scene, arguments.tolerance)) {
    removable += static_cast<int>(single.removable);
    keys += static_cast<int>(single.key);
    blocks.push_back({{"block", single.block},
                      {"name", scene.blocks[static_cast<std::size_t>(single.block)].name},
                      {"volume", single.volume},
                      {"removable", single.removable},
                      {"key", single.key},
                      {"stands", number_or_null(single.stands)},
                      {"falls", number_or_null(single.falls)}});
  }
  const json report = {
      {"scene", arguments.scene}, {"removable", removable}, {"keys", keys}, {"blocks", blocks}};
  return show(arguments, report, print_blocks, kDone, "blocks.json");
}

/// `sign`: of the values, -1 where the push was against what is asked for.
json side(const Limit& limit, double sign) {
  const auto summary = [&](const std::unique_ptr<limit_analysis::Trial>& trial) {
    json told = limit_analysis::summary(trial.get());
    if (trial) told["value"] = sign * trial->value;
    return told;
  };
  return {{"stands", summary(limit.stands)},
          {"falls", summary(limit.falls)},
          {"why", limit.why.empty() ? json() : json(limit.why)}};
}

void print_thrust(const json& report) {
  std::printf("%s: thrust on \"%s\" along (%.6g, %.6g, %.6g), N\n", words(report["scene"]),
              words(report["support"]), report["direction"][0].get<double>(),
              report["direction"][1].get<double>(), report["direction"][2].get<double>());
  const auto print_side = [&](const char* key, const char* title) {
    for (const auto& [verdict, word] :
         {std::pair("stands", "admissible"), {"falls", "not admissible"}}) {
      const json& found = report[key][verdict];
      if (found.is_null()) {
        const json& why = report[key]["why"];
        std::printf("  %s: %s: not proved%s%s\n", title, word, why.is_null() ? "" : ": ",
                    why.is_null() ? "" : words(why));
      } else {
        std::printf("  %s: %s at %.9g\n", title, word, found["value"].get<double>());
      }
    }
  };
  print_side("least", "least thrust");
  print_side("greatest", "greatest thrust");
  print_side("shrink", "joints shrunk to a share");
  if (!report["geometric_factor_of_safety"].is_null()) {
    std::printf("  geometric factor of safety %s%.6g; the thrust is %s\n",
                report["shrink"]["falls"].is_null() ? "at least " : "",
                report["geometric_factor_of_safety"].get<double>(),
                report["unique"].get<bool>() ? "unique" : "not unique");
  }
}

int thrust(const LimitArguments& arguments) {
  const auto scene = scene_file::read_scene(arguments.scene, arguments.changes).scene;
  const limit_analysis::Thrust found =
      limit_analysis::thrust_on(scene, arguments.thrust, arguments.tolerance);
  const bool both = found.least.stands && found.greatest.stands;
  json unique, factor;
  if (both) {
    const double least = -found.least.stands->value, greatest = found.greatest.stands->value;
    unique = greatest - least <= 4.0 * arguments.tolerance * std::abs(greatest);
  }
  if (found.shrink.stands) factor = 1.0 / found.shrink.stands->value;
  const auto is_answered = [](const Limit& limit) {
    return limit.stands && (limit.why.empty() || limit.everywhere);
  };
  const bool proved =
      is_answered(found.least) && is_answered(found.greatest) && is_answered(found.shrink);
  const json report = {
      {"scene", arguments.scene},
      {"support", arguments.thrust},
      {"direction", std::vector<double>(found.direction.begin(), found.direction.end())},
      {"least", side(found.least, -1.0)},
      {"greatest", side(found.greatest, 1.0)},
      {"shrink", side(found.shrink, 1.0)},
      {"geometric_factor_of_safety", factor},
      {"unique", unique}};
  const auto add = [&](OutputFolder& folder) {
    for (const auto& [name, limit] : {std::pair("least", &found.least),
                                      {"greatest", &found.greatest},
                                      {"shrink", &found.shrink}}) {
      write_trial(folder, std::string(name) + "_stands", limit->stands.get(), {.what = "thrust"});
      write_trial(folder, std::string(name) + "_falls", limit->falls.get(), {.what = "thrust"});
    }
  };
  return show(arguments, report, print_thrust, proved ? kDone : kFailed, "thrust.json", add);
}

/// A path: what the run says stands beside what is proved of its geometries.
Limit settlement(const LimitArguments& arguments, const VariedScene& scenes, json& loading) {
  if (!(arguments.loading > 0.0)) {
    throw std::invalid_argument(
        "--vary settlement: is a run of the solver: --loading must not be 0");
  }
  limit_analysis::Reached reached;
  Limit limit = limit_analysis::settle(scenes, arguments.tolerance, arguments.loading,
                                       show_progress, reached);
  loading = {{"gradual", reached_json(reached)}, {"safe", number_or_null(reached.holds)}};
  return limit;
}

/// In place of what joints reach that yield. `safe`: what loading is known to reach, if any is.
void take_brittle(std::unique_ptr<Trial> stands, const json& safe, double tolerance, Limit& limit) {
  const auto is_reached = [&](double value, double allowed) {
    return limit.stands &&
           std::abs(value - limit.stands->value) <= allowed * std::abs(limit.stands->value);
  };
  const bool lost =
      safe.is_number() && !is_reached(safe.get<double>(), 4.0 * limit_analysis::kRunTolerance);
  const bool reached = stands && is_reached(stands->value, tolerance) && !lost;
  limit.stands = std::move(stands);
  if (reached) return;
  limit.why = "joints with tension are brittle: one after another they can break before all yield";
}

int limit(const LimitArguments& arguments) {
  using limit_analysis::summary;
  VariedScene scenes(arguments.scene, arguments.changes,
                     limit_analysis::parse_vary(arguments.vary));
  scenes.progress = show_progress;
  json loading;
  const bool sinks = scenes.vary().what == "settlement";
  Limit limit = sinks ? settlement(arguments, scenes, loading)
                      : limit_analysis::prove(scenes, arguments.tolerance);
  const bool brittle = !sinks && limit_analysis::has_tension(scenes.file().scene);
  auto stands = brittle ? limit_analysis::stands_brittle(scenes, arguments.tolerance) : nullptr;
  if (!sinks)
    loading = loading_json(arguments, scenes, limit, brittle ? stands.get() : limit.stands.get());
  if (brittle) {
    const json safe = loading.is_null() ? json() : loading["safe"];
    take_brittle(std::move(stands), safe, arguments.tolerance, limit);
  }
  end_progress();
  json report = {{"scene", arguments.scene},
                 {"vary", arguments.vary},
                 {"stands", summary(limit.stands.get())},
                 {"falls", summary(limit.falls.get())},
                 {"convex", std::isfinite(limit.convex) ? json(limit.convex) : json()},
                 {"loading", loading},
                 {"why", limit.why.empty() ? json() : json(limit.why)},
                 {"factorizations", scenes.factorizations}};
  const auto add = [&](OutputFolder& folder) {
    write_trial(folder, "stands", limit.stands.get(), scenes.vary());
    write_trial(folder, "falls", limit.falls.get(), scenes.vary());
  };
  return show(arguments, report, print, limit.why.empty() ? kDone : kFailed, "limit.json", add);
}

int asked(const LimitArguments& words) {
  const bool varies = !words.vary.empty(), thrusts = !words.thrust.empty();
  if (int{varies} + int{thrusts} + int{words.each} != 1)
    throw std::invalid_argument(
        "limit: one of --vary, --each and --thrust has to be given, and one alone");
  LimitArguments with_stage = words;
  with_stage.changes = limit_analysis::with_static_stage(words.scene, words.changes);
  if (words.each) return each(with_stage);
  return thrusts ? thrust(with_stage) : limit(with_stage);
}

}  // namespace

void add_limit_command(CLI::App& app, int& exit_code) {
  const auto [command, words] = add_command<LimitArguments>(
      app, exit_code, asked, "limit",
      "How much a structure bears, with a proof on both sides: contact forces that balance all "
      "loads within friction, and a mechanism. Blocks count as rigid, as they stand at time 0.\n"
      "Above the mechanism nothing holds, whatever the flow rule; below it Coulomb friction may "
      "still let go: the answer is an upper bound.\n"
      "Exit codes: 0 both are proved within the tolerance, 1 not, 2 the input is refused.");
  add_scene_options(command, words.scene, words.changes);
  command
      .add_option("--vary", words.vary,
                  "load=NAME:FROM:TO (factor of the loads of that name), tilt=FROM:TO[:x|y|z] "
                  "(of the ground about an axis, degrees, default y: towards +x), strength=FROM:TO "
                  "(friction, cohesion and tension are divided by it), friction=FROM:TO (angle of "
                  "all joints, degrees), "
                  "settlement=BLOCK:0:TO (of a fixed block, m, by runs), "
                  "/json/pointer=FROM:TO")
      ->type_name("WHAT=FROM:TO");
  command.add_flag("--each", words.each,
                   "key blocks: every block alone among its neighbours, which stay");
  command.add_option("--thrust", words.thrust,
                     "least and greatest horizontal thrust on this fixed block, and the geometric "
                     "factor of safety");
  command
      .add_option("--tolerance", words.tolerance, "how far apart the two proofs may be, relative")
      ->check(in_range(1e-7, 0.5))
      ->capture_default_str();
  command
      .add_option("--loading", words.loading,
                  "wall time, s, for runs that show what loading reaches; 0: none")
      ->check(in_range(0, kMostSeconds))
      ->capture_default_str();
  command.add_option("--out", words.out,
                     "folder for limit.json and the certificates stands.json, falls.json");
  command.add_flag("--json", words.json, "the same as JSON");
}

}  // namespace quoin::commands
