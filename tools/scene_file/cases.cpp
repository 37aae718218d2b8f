#include "scene_file/cases.hpp"

#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <quoin/geometry/mass_properties.hpp>

#include "scene_file/printable.hpp"
#include "scene_file/read_json.hpp"
#include "scene_file/schema_check.hpp"

namespace quoin::scene_file {
namespace {

using Json = nlohmann::ordered_json;
using Names = std::map<std::string, double>;  // formulas read the numbers in place

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A formula of everything that a run shows; beside muParser's functions norm(…), the length of a
/// vector, and det(…), of a 3 × 3 matrix by rows.
class CaseFormula {
 public:
  CaseFormula(const Json& text, Names& names, const std::string& pointer) : pointer_(pointer) {
    try {
      define(names);
      parser_.SetExpr(text.is_number() ? text.dump() : text.get<std::string>());
    } catch (const mu::Parser::exception_type& error) {
      throw refusal(error);
    }
  }
  double operator()() const {
    try {
      return parser_.Eval();
    } catch (const mu::Parser::exception_type& error) {
      throw refusal(error);
    }
  }

 private:
  void define(Names& names) {
    parser_.DefineConst("pi", std::numbers::pi);
    parser_.DefineConst("deg", std::numbers::pi / 180);
    if (!names.contains("g")) parser_.DefineConst("g", 9.81);
    parser_.DefineFun("norm", norm);
    parser_.DefineFun("det", det);
    // A monitor may have a name that no formula can.
    const auto in_word = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
    for (auto& [name, value] : names) {
      const bool word = std::ranges::all_of(name, in_word) && !std::isdigit(name[0]);
      if (word) parser_.DefineVar(name, &value);
    }
  }
  SceneError refusal(const mu::Parser::exception_type& error) const {
    return {pointer_, shown(parser_.GetExpr()) + ": " + printable(error.GetMsg(), 120)};
  }
  static double norm(const double* x, int count) {
    return Eigen::Map<const Eigen::VectorXd>(x, count).norm();
  }
  static double det(const double* x, int count) {
    return count == 9 ? Eigen::Map<const Eigen::Matrix3d>(x).determinant() : kNone;
  }
  std::string pointer_;
  mu::Parser parser_;
};

/// What an object says under a key; empty where it says nothing.
const Json& part(const Json& object, const char* key) {
  static const Json kEmpty = Json::object();
  return object.contains(key) ? object[key] : kEmpty;
}

/// What it must say under a key. Throws SceneError.
const Json& said(const Json& object, const char* key, const std::string& pointer) {
  if (!object.contains(key)) throw SceneError(pointer, "missing key " + shown(std::string(key)));
  return object[key];
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

/// What each step shows: calls `put(name, value)`, always in the same order.
template <class Put>
void show_step(const StepView& view, const SceneFile& file, const Put& put) {
  const solver::StepReport& report = view.report;
  const solver::EnergyLedger& energy = view.simulation.state().energy;
  put("t", view.dynamic_time);
  put("closed", report.closed_count);
  put("solves", report.linear_solves);
  put("overlap", report.largest_overlap);
  put("regularised", report.proximal_newton_attempts);
  put("islands_at_rest", report.islands_at_rest);
  put("largest_speed", report.largest_speed);
  put("omega_dt", report.stiffest_omega_dt);
  put("damping", report.numerical_damping);
  put("unbalance", report.unbalance);
  put("kinetic", energy.kinetic);
  put("potential", energy.potential);
  put("strain", energy.strain);
  put("contact_energy", energy.contact);
  put("work", energy.work);
  put("closure", energy.closure);
  put("friction_loss", energy.friction_loss);
  put("impact_loss", energy.impact_loss);
  put("algorithmic_loss", energy.algorithmic_loss);
  put("mechanical", energy.mechanical());
  const auto put_vector = [&](const std::string& name, const Vector3& v) {
    for (int i = 0; i < 3; ++i) put(name + static_cast<char>('x' + i), v[i]);
  };
  const std::vector<solver::Tie>& ties = file.scene.ties;  // of later stages: not shown
  for (std::size_t i = 0; i < ties.size() && i < view.simulation.state().ties.size(); ++i) {
    const solver::TieState& tie = view.simulation.state().ties[i];
    put(ties[i].name + "_force", tie.force);
    put(ties[i].name + "_length", tie.length);
    put(ties[i].name + "_plastic", tie.plastic);
    put(ties[i].name + "_broken", tie.broken);
  }
  const std::vector<Monitor>& monitors = file.monitors;
  for (std::size_t m = 0; m < monitors.size(); ++m) {
    const MonitorValue& value = view.monitors[m];
    const std::string name = monitors[m].name + "_";
    switch (monitors[m].kind) {
      case Monitor::Kind::Point:
        put_vector(name + "d", value.displacement);
        put_vector(name + "v", value.velocity);
        put_vector(name + "r", value.rotation);
        put_vector(name + "w", value.angular_velocity);
        break;
      case Monitor::Kind::Contact:
        put(name + "n", value.normal_force);
        put_vector(name + "m", value.moment);
        put_vector(name + "c", value.centre_of_pressure);
        [[fallthrough]];
      case Monitor::Kind::FixedPoints:
        put_vector(name + "f", value.force);
        break;
      case Monitor::Kind::Group:
        put_vector(name + "p", value.momentum);
        put_vector(name + "l", value.angular_momentum);
        for (int i = 0; i < 6; ++i) {
          constexpr const char* kComponents[] = {"xx", "yy", "zz", "xy", "yz", "zx"};
          put(name + "s" + kComponents[i], value.stress[i]);
          put(name + "e" + kComponents[i], value.strain[i]);
        }
        break;
    }
  }
}

/// Mean gap (m), extremes of the normal forces (N), and how many have failed or are bonded, of the
/// contact points between the two sides of a contact monitor.
void show_points(const solver::Simulation& simulation, const Monitor& monitor, Names& names) {
  const auto has = [](const std::vector<int>& blocks, int b) {
    return std::ranges::binary_search(blocks, b);
  };
  double gap = 0.0, least = std::numeric_limits<double>::infinity(), most = -least, count = 0.0;
  double failed = 0.0, bonded = 0.0, area = 0.0;
  for (const solver::Contact& contact : simulation.state().contacts) {
    const int a = contact.point.key.a, b = contact.point.key.b;
    if (!(has(monitor.others, a) && has(monitor.blocks, b)) &&
        !(has(monitor.others, b) && has(monitor.blocks, a)))
      continue;
    gap += contact.point.gap;
    least = std::min(least, contact.normal_force);
    most = std::max(most, contact.normal_force);
    area = std::max(area, contact.point.area);
    failed += contact.failed ? 1.0 : 0.0;
    bonded += contact.bonded ? 1.0 : 0.0;
    ++count;
  }
  names[monitor.name + "_gap"] = gap / count;
  names[monitor.name + "_least"] = least;
  names[monitor.name + "_most"] = most;
  names[monitor.name + "_failed"] = failed;
  names[monitor.name + "_bonded"] = bonded;
  names[monitor.name + "_area"] = area;
}

/// Angular momentum of all blocks about the origin, kg m2/s: of the reference shapes, as the method
/// defines it, the integral of X × (W × X + eps' X).
Vector3 angular_momentum(const solver::Simulation& simulation) {
  Vector3 total = Vector3::Zero();
  for (std::size_t b = 0; b < simulation.scene().blocks.size(); ++b) {
    const solver::Block& block = simulation.scene().blocks[b];
    if (block.kind >= solver::BlockKind::Fixed) continue;
    const geometry::MassProperties mass = geometry::mass_properties(block.body());
    const solver::BlockState& now = simulation.state().blocks[b];
    const double density = block.material.density;
    const Vector3 place = simulation.state().origin + now.centroid;
    total += density * mass.volume * place.cross(now.velocity);
    const solver::Vector6& e = now.strain_rate;  // shear as gamma
    solver::Matrix3 rate;
    rate << e[0], e[3] / 2, e[5] / 2, e[3] / 2, e[1], e[4] / 2, e[5] / 2, e[4] / 2, e[2];
    Vector3 spin = Vector3::Zero();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Vector3 moving = now.angular_velocity.cross(Vector3::Unit(j)) + rate.col(j);
        spin += density * mass.second_moment(i, j) * Vector3::Unit(i).cross(moving);
      }
    }
    total += now.rotation * spin;
  }
  return total;
}

/// Runs one scene and gathers what formulas may name: what it shows at its end; was_…, one step
/// before; `largest` over the dynamic steps; SAMPLE_…, at the first of them at which it is due.
class Gathering {
 public:
  Gathering(const SceneFile& file, const Json& entry, const Names& parameters,
            const std::string& pointer)
      : file_(file), entry_(entry), pointer_(pointer), names_(parameters) {
    for (const Stage& stage : file.stages)
      dynamic_ = dynamic_ || stage.analysis == solver::Analysis::Dynamic;
  }

  RunResult run() {
    RunOptions options;
    options.before_first = [this](const StepView& view) { take(view); };
    options.after_step = [this](const StepView& view, const SaveRun&) { take(view); };
    options.after_stage = [this](const StepView& view, const SaveRun&) {
      const Vector3 spin = angular_momentum(view.simulation);
      for (int i = 0; i < 3; ++i) names_[std::string("spin_") + "xyz"[i]] = spin[i];
    };
    options.stop = [this]() -> std::optional<RunStatus> {
      if (ended_) return RunStatus::Interrupted;
      return std::nullopt;
    };
    RunResult result = run_scene(file_, options);
    if (ended_ && result.status == RunStatus::Interrupted) result.status = RunStatus::Completed;
    names_["largest_overlap"] = result.total.largest_overlap;
    names_["energy_growth"] = result.energy_growth;
    names_["energy_scale"] = result.energy_scale;
    names_["factorization_count"] = static_cast<double>(result.total.factorizations);
    names_["loose_count"] = static_cast<double>(result.loose.size());
    names_["step_count"] = static_cast<double>(result.steps);
    names_["solve_count"] = static_cast<double>(result.total.linear_solves);
    return result;
  }
  Names& names() { return names_; }

 private:
  struct Tracked {
    double* value;
    CaseFormula formula;
  };
  struct Sample {
    std::string name;
    CaseFormula due;
    bool taken = false;
  };

  void begin(const StepView& view) {
    show_step(view, file_, [&](const std::string& name, double value) {
      if (names_.contains(name))
        throw SceneError("/parameters", shown(name) + " is the name of what cases show");
      shown_.push_back(name);
      now_.push_back(&(names_[name] = value));
      was_.push_back(&(names_["was_" + name] = value));
    });
    // Every name is there before a formula is parsed.
    show_contacts(view.simulation);
    const Json& largest = part(entry_, "largest");
    const Json& samples = part(entry_, "samples");
    for (const auto& [name, text] : largest.items()) names_[name] = -1e300;
    const Names base = names_;
    for (const auto& [name, due] : samples.items())
      for (const auto& [variable, value] : base) names_[name + "_" + variable] = kNone;
    for (const auto& [name, text] : largest.items())
      tracked_.push_back({&names_[name], {text, names_, pointer_ + "/largest/" + name}});
    for (const auto& [name, due] : samples.items()) {
      // A number is a time; a step may end a rounding error beside it.
      const Json when = due.is_number() ? Json("t > " + due.dump() + " - 1e-9") : due;
      samples_.push_back({name, {when, names_, pointer_ + "/samples/" + name}});
    }
    if (entry_.contains("until")) until_.emplace(entry_["until"], names_, pointer_ + "/until");
  }

  void show_contacts(const solver::Simulation& simulation) {
    for (const Monitor& monitor : file_.monitors)
      if (monitor.kind == Monitor::Kind::Contact) show_points(simulation, monitor, names_);
  }

  void take(const StepView& view) {
    if (now_.empty()) begin(view);
    for (std::size_t i = 0; i < now_.size(); ++i) *was_[i] = *now_[i];
    std::size_t i = 0;
    show_step(view, file_, [&](const std::string&, double value) { *now_[i++] = value; });
    show_contacts(view.simulation);
    if (dynamic_ && view.simulation.options().analysis != solver::Analysis::Dynamic) return;
    for (const Tracked& tracked : tracked_) {
      const double value = tracked.formula();
      if (std::isnan(*tracked.value)) continue;  // it stays to be seen
      if (!(value <= *tracked.value)) *tracked.value = value;
    }
    for (Sample& sample : samples_) {
      if (sample.taken || sample.due() == 0.0) continue;
      sample.taken = true;
      for (const std::string& name : shown_) {
        names_[sample.name + "_" + name] = names_[name];
        names_[sample.name + "_was_" + name] = names_["was_" + name];
      }
    }
    ended_ = until_ && (*until_)() != 0.0;
  }

  const SceneFile& file_;
  const Json& entry_;
  std::string pointer_;
  Names names_;
  bool dynamic_ = false, ended_ = false;
  std::vector<std::string> shown_;
  std::vector<double*> now_, was_;
  std::vector<Tracked> tracked_;
  std::vector<Sample> samples_;
  std::optional<CaseFormula> until_;
};

CaseRow judged(const Json& row, const std::string& quantity, double result, Names& names) {
  CaseRow made{.quantity = quantity, .result = result};
  const auto value = [&](const char* key) {
    return CaseFormula(said(row, key, "/cases/rows"), names, std::string("/cases/rows/") + key)();
  };
  if (row.contains("at_least")) {
    made.quantity += ", at least";
    made.exact = value("at_least");
    made.error = result >= made.exact ? 0.0 : made.exact - result;  // NaN stays NaN
  } else {
    const bool relative = row.contains("relative");
    made.quantity += relative ? ", rel." : "";
    made.exact = row.contains("exact") ? value("exact") : 0.0;
    made.allowed = value(relative ? "relative" : "allowed");
    made.error = std::abs(result - made.exact) / (relative ? std::abs(made.exact) : 1.0);
  }
  made.ok = made.error <= made.allowed;
  return made;
}

std::string change_of(const std::string& name, const Json& value) {
  return name + "=" + (value.is_string() ? value.get<std::string>() : value.dump());
}

}  // namespace

struct CaseFile::Document {
  std::string folder, scene;
  Json cases;

  const Json& runs() const { return cases["runs"]; }

  /// The entry, with what is said for all runs where it says nothing itself.
  Json entry(const Json& own) const {
    Json all = cases;
    all.erase("runs");
    all.erase("series");
    all.merge_patch(own);
    return all;
  }

  Names parameters(const std::vector<std::string>& changes) const {
    nlohmann::json document = parse_json(scene);
    return expand(document, changes);
  }

  /// A label with {word}s of alternatives and {formula}s of the parameters put in.
  std::string label(const std::string& text, const CaseRun& run, Names& names) const {
    std::string made;
    for (std::size_t i = 0; i < text.size();) {
      const std::size_t open = std::min(text.find('{', i), text.size());
      made += text.substr(i, open - i);
      if (open == text.size()) break;
      const std::size_t close = std::min(text.find('}', open), text.size());
      const std::string inner = text.substr(open + 1, close - open - 1);
      const auto word = run.words.find(inner);
      made += word != run.words.end() ? word->second
                                      : short_number(CaseFormula(inner, names, "/cases")());
      i = close + 1;
    }
    return made;
  }

  /// `made`, each with every alternative of an axis: KEY: [numbers], or WORD: [{name, set}].
  static void vary(const std::string& key, const Json& alternatives, std::vector<CaseRun>& made) {
    std::vector<CaseRun> next;
    for (const CaseRun& run : made) {
      for (const Json& value : alternatives) {
        next.push_back(run);
        if (value.is_object()) {
          next.back().words[key] = value["name"];
          for (const auto& [name, set] : part(value, "set").items())
            next.back().changes.push_back(change_of(name, set));
        } else {
          next.back().changes.push_back(change_of(key, value));
          next.back().parameters.emplace_back(key, value.get<double>());
        }
      }
    }
    made.swap(next);
  }

  void read_flags(const Json& entry, bool quick, std::vector<CaseRun>& made) const {
    if (!entry.contains("flags")) return;
    const Json& flags = entry["flags"];
    std::size_t used = 0;
    for (CaseRun& run : made) {
      const std::string key =
          run.parameters.empty() ? "" : short_number(run.parameters.front().second);
      if (flags.is_object() && !flags.contains(key)) continue;
      run.flags = (flags.is_object() ? flags[key] : flags).get<std::vector<std::string>>();
      ++used;
    }
    if (flags.is_object() && used < flags.size() && !quick)
      throw SceneError("/cases/runs", "flags of a value that does not vary: " + flags.dump());
  }

  struct Evaluated {
    CaseOutcome outcome{};
    std::vector<double> results{};  ///< of each row
    Names names{};                  ///< of the last run
    std::string failure{};
  };

  /// The results of an entry's rows, averaged over `mean_over`.
  Evaluated evaluate(const Json& entry, const CaseRun& run) const {
    std::vector<CaseRun> parts{run};
    for (const auto& [key, values] : part(entry, "mean_over").items()) vary(key, values, parts);
    Evaluated all;
    const Json& rows = said(entry, "rows", "/cases/runs/" + std::to_string(run.entry));
    all.results.resize(rows.size());
    std::vector<bool> raised(solver::kFlagKinds);
    for (const CaseRun& part : parts) {
      auto [result, names] = gather(entry, part.changes, all.outcome.may_fail);
      all.outcome.steps += result.steps;
      all.outcome.solves += result.total.linear_solves;
      all.outcome.unconverged += result.unconverged_steps;
      for (const RunFlag& flag : result.flags)
        raised[static_cast<std::size_t>(flag.worst.kind)] = true;
      const bool whole =
          result.status == RunStatus::Completed || result.status == RunStatus::NotTrusted;
      const std::string status = whole ? "completed" : scene_file::name(result.status);
      if (status != entry.value("status", "completed"))
        all.failure = status + ": " + result.message;
      for (std::size_t k = 0; k < all.results.size(); ++k) {
        all.results[k] += CaseFormula(rows[k]["result"], names, "/cases/rows/result")() /
                          static_cast<double>(parts.size());
      }
      all.names = std::move(names);
    }
    for (std::size_t kind = 0; kind < raised.size(); ++kind)
      if (raised[kind])
        all.outcome.flags.emplace_back(solver::name(static_cast<solver::FlagKind>(kind)));
    return all;
  }

  std::pair<RunResult, Names> gather(const Json& entry, const std::vector<std::string>& changes,
                                     bool& may_fail) const {
    const SceneFile file = parse_scene(scene, folder, changes);
    may_fail = file.options.method == solver::ContactMethod::Paper ||
               file.options.method == solver::ContactMethod::Penalty;
    Gathering gathering(file, entry, parameters(changes), "/cases");
    RunResult result = gathering.run();
    Names names = std::move(gathering.names());
    for (const auto& [prefix, set] : part(entry, "with").items()) {
      std::vector<std::string> more = changes;
      for (const auto& [name, value] : set.items()) more.push_back(change_of(name, value));
      Json plain = entry;
      plain.erase("with");
      const auto [beside, shown] = gather(plain, more, may_fail);
      for (const auto& [name, value] : shown) names[prefix + "_" + name] = value;
      if (result.status == RunStatus::Completed) result.status = beside.status;
      if (result.message.empty()) result.message = beside.message;
      result.flags.insert(result.flags.end(), beside.flags.begin(), beside.flags.end());
    }
    return {std::move(result), std::move(names)};
  }
};

CaseFile::CaseFile(const std::string& path) : path_(path) {
  const std::filesystem::path file(path);
  name_ = file.stem().string().substr(0, file.stem().string().find('_'));
  Json document = Json::parse(plain_json(path));
  check_schema(nlohmann::json::parse(cases_schema()), nlohmann::json(document));
  title_ = document.value("title", "");
  Document made{file.parent_path().string(), {}, document["cases"]};
  document.erase("cases");
  if (made.cases.contains("scene")) {  // another file's, with what this one says
    const std::filesystem::path base = file.parent_path() / made.cases["scene"];
    Json merged = Json::parse(plain_json(base.string()));
    merged.merge_patch(document);
    document = std::move(merged);
  }
  made.scene = document.dump();
  document_ = std::make_shared<const Document>(std::move(made));
}

bool CaseFile::has_series() const { return document_->cases.contains("series"); }

std::vector<CaseRun> CaseFile::runs(bool quick) const {
  std::vector<CaseRun> all;
  for (std::size_t i = 0; i < document_->runs().size(); ++i) {
    const Json entry = document_->entry(document_->runs()[i]);
    std::vector<CaseRun> made(1);
    made[0].entry = i;
    for (const auto& [name, value] : part(entry, "set").items())
      made[0].changes.push_back(change_of(name, value));
    Json axes = part(entry, "vary");
    if (quick) axes.merge_patch(part(entry, "quick"));
    for (const auto& [key, alternatives] : axes.items()) Document::vary(key, alternatives, made);
    document_->read_flags(entry, quick, made);
    for (CaseRun& run : made) {
      Names names = document_->parameters(run.changes);
      run.name = document_->label(entry.value("name", ""), run, names);
    }
    all.insert(all.end(), made.begin(), made.end());
  }
  return all;
}

CaseOutcome CaseFile::run(const CaseRun& run) const {
  const Json entry = document_->entry(document_->runs().at(run.entry));
  const auto start = std::chrono::steady_clock::now();
  Document::Evaluated evaluated = document_->evaluate(entry, run);
  CaseOutcome& outcome = evaluated.outcome;
  outcome.seconds = seconds_since(start);
  std::size_t k = 0;
  for (const Json& row : entry["rows"]) {
    const std::string quantity =
        document_->label(row.value("quantity", run.name), run, evaluated.names);
    outcome.rows.push_back(judged(row, quantity, evaluated.results[k++], evaluated.names));
  }
  if (!evaluated.failure.empty()) {
    outcome.rows.push_back({.quantity = "run broke off: " + run.name + ": " + evaluated.failure,
                            .result = kNone,
                            .error = kNone});
  }
  for (CaseRow& row : outcome.rows) {
    row.case_name = name_;
    row.seconds = outcome.seconds;
  }
  return std::move(outcome);
}

std::vector<CaseSeries> CaseFile::series() const {
  std::vector<CaseSeries> all;
  for (const Json& own : part(document_->cases, "series")) {
    const auto start = std::chrono::steady_clock::now();
    const std::string refine = own["refine"];
    const bool penalty = refine.ends_with("penalty");
    CaseSeries series{.case_name = name_,
                      .quantity = own["quantity"],
                      .refined = penalty ? "penalty" : "time_step",
                      .expected_order = own.value("order", 0.0),
                      .floor = own["floor"]};
    Json entry = document_->entry(own);
    entry["rows"] = {{{"result", own["error"]}}};
    for (int i = 0; i < own["count"]; ++i) {
      const double value = own["first"].get<double>() * std::pow(penalty ? 10.0 : 0.5, i);
      CaseRun run;
      for (const auto& [name, set] : part(entry, "set").items())
        run.changes.push_back(change_of(name, set));
      run.changes.push_back(change_of(refine, value));
      const Document::Evaluated evaluated = document_->evaluate(entry, run);
      series.failure = evaluated.failure;
      if (!series.failure.empty()) break;
      series.values.push_back(value);
      series.errors.push_back(std::abs(evaluated.results[0]));
    }
    series.seconds = seconds_since(start);
    all.push_back(std::move(series));
  }
  return all;
}

double CaseSeries::order() const {
  const double sign = refined == "penalty" ? -1.0 : 1.0;
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < errors.size() && errors[i] > floor; ++i) {
    const double step = sign * std::log(values[i]), error = std::log(errors[i]);
    n += 1.0;
    x += step;
    y += error;
    xx += step * step;
    xy += step * error;
  }
  return n < 2.0 ? kNone : (n * xy - x * y) / (n * xx - x * x);
}

double CaseSeries::stops_at() const {
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (errors[i] <= floor) return values[i];
  return kNone;
}

bool CaseSeries::ok() const {
  constexpr double kOrderSlack = 0.3;  // of an observed order: few points, events inside steps
  if (!failure.empty() || errors.empty()) return false;
  const auto at_floor = [this](double error) { return error <= floor; };
  const auto reached = std::find_if(errors.begin(), errors.end(), at_floor);
  if (!std::all_of(reached, errors.end(), at_floor)) return false;
  if (expected_order == 0.0 || reached - errors.begin() < 2) return reached == errors.begin();
  return order() >= expected_order - kOrderSlack;
}

void in_file(const std::string& path, const std::function<void()>& action) {
  try {
    action();
  } catch (const SceneError& error) {
    throw SceneError(path, error.what());
  }
}

std::vector<CaseFile> read_cases(const std::string& folder) {
  std::vector<std::string> paths;
  for (const auto& file : std::filesystem::directory_iterator(folder))
    if (file.path().extension() == ".json") paths.push_back(file.path().string());
  std::ranges::sort(paths);
  std::vector<CaseFile> cases;
  for (const std::string& path : paths) in_file(path, [&] { cases.emplace_back(path); });
  return cases;
}

}  // namespace quoin::scene_file
