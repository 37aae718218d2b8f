/// quoin run SCENE.json

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <quoin/solver/parts.hpp>
#include <set>

#include "checkpoint.hpp"
#include "commands.hpp"
#include "in_range.hpp"
#include "limit/certificate.hpp"
#include "output_folder.hpp"
#include "path_to_write.hpp"
#include "processes.hpp"
#include "run_files.hpp"
#include "scene_file/contact_problem_file.hpp"
#include "scene_file/mechanism_proof.hpp"
#include "scene_file/peak_memory.hpp"
#include "scene_file/points_outside.hpp"
#include "scene_file/run_scene.hpp"
#include "scene_file/scene_error.hpp"
#include "stop.hpp"

namespace quoin::commands {
namespace {

using scene_file::RunResult;
using scene_file::RunStatus;
using scene_file::SceneFile;
using scene_file::StepView;

struct RunArguments {
  RunRequest request;
  std::string out;
  std::string resume;
  std::optional<double> max_seconds;
  int threads = 1;
  bool json = false;
  bool mpi = false;
};

/// One line on a terminal, rewritten a few times a second; nothing when piped, nothing of a process
/// that is not the first.
class ProgressLine {
 public:
  ProgressLine(std::size_t stages, const Processes& processes)
      : on_(processes.is_first() && isatty(STDERR_FILENO) != 0), stages_(stages) {}
  ~ProgressLine() {
    if (on_) std::fputs("\r\033[K", stderr);
  }
  void show(const StepView& view) {
    if (!is_time()) return;
    show_place(view);
    std::fprintf(stderr, "  %d of %d contacts closed", view.report.closed_count,
                 view.report.contact_count);
  }
  void show_in_step(const StepView& view) {
    if (!is_time()) return;
    show_place(view);
    std::fprintf(stderr, "  in a step for %.0f s: %d sub-steps, %d open-close iterations",
                 std::chrono::duration<double>(last_ - step_began_).count(), view.report.sub_steps,
                 view.report.iterations);
  }
  void end_step() { step_began_ = std::chrono::steady_clock::now(); }

 private:
  bool is_time() {
    const auto now = std::chrono::steady_clock::now();
    if (!on_ || now - last_ < std::chrono::milliseconds(100)) return false;
    last_ = now;
    return true;
  }
  void show_place(const StepView& view) const {
    std::fprintf(stderr, "\r\033[Kstage %zu of %zu  %3.0f %%  t = %.4g s  %.0f MB", view.stage + 1,
                 stages_, 100 * view.progress, view.dynamic_time, scene_file::peak_memory_mb());
  }

  bool on_;
  std::size_t stages_;
  std::chrono::steady_clock::time_point last_{};
  std::chrono::steady_clock::time_point step_began_ = std::chrono::steady_clock::now();
};

void print_result(const SceneFile& file, const std::string& path, const RunResult& result) {
  std::printf("%s: %ld steps, %.6g s in %.3g s, %.0f MB of memory\n",
              file.title.empty() ? path.c_str() : file.title.c_str(), result.steps, result.time,
              result.wall_seconds, scene_file::peak_memory_mb());
  for (std::size_t s = 0; s < result.stages.size(); ++s) {
    const scene_file::StageResult& stage = result.stages[s];
    if (stage.analysis == solver::Analysis::Dynamic) continue;
    if (std::isnan(stage.unbalance)) {
      std::printf("  stage %zu: %s, proved before any step\n", s, name(stage.verdict));
      continue;
    }
    std::printf("  stage %zu: %s, unbalance %.3g in %ld steps\n", s, name(stage.verdict),
                stage.unbalance, stage.steps);
    if (file.stages[s].ramp_to > 0)
      std::printf("  largest load factor at rest: %g\n", stage.load_factor);
    const auto loose =
        std::ranges::count(result.loose, static_cast<int>(s), &scene_file::LooseBlock::stage);
    if (loose > 0) std::printf("  %td blocks came loose\n", loose);
  }
  for (std::size_t r = 0; r < result.references.size(); ++r) {
    const scene_file::ReferenceResult& compared = result.references[r];
    std::printf("  %-24s error %.3g%s\n", file.references[r].name.c_str(), compared.error,
                compared.ok ? "" : "  MORE THAN ALLOWED");
  }
  std::printf("  largest overlap %.3g m, %d linear solves, %d open-close iterations\n",
              result.total.largest_overlap, result.total.linear_solves, result.total.iterations);
  for (const scene_file::RunFlag& flag : result.flags) {
    std::printf("  FLAG %s: %.3g (limit %.3g), from %.6g s in %ld steps",
                std::string(solver::name(flag.worst.kind)).c_str(), flag.worst.value,
                flag.worst.limit, flag.first_time, flag.steps);
    if (flag.worst.block >= 0) std::printf(", block %d", flag.worst.block);
    if (flag.worst.other >= 0) std::printf(" and %d", flag.worst.other);
    std::printf("\n");
  }
}

void save(const std::filesystem::path& path, const nlohmann::ordered_json& document) {
  std::ofstream stream(path);
  stream << text(document) << '\n';
  stream.close();
  if (!stream) throw scene_file::unwritable(path.string());
}

/// Made when the solver has taken the scene: a scene that is refused leaves nothing behind.
struct Output {
  std::optional<OutputFolder> folder{};
  std::optional<RunFiles> files{};
  std::vector<int> rank_of_block{};  ///< which process writes a block's files
  std::ifstream checkpoint{};
  std::chrono::steady_clock::time_point saved = std::chrono::steady_clock::now();
};

/// A checkpoint when it is time for one. The time that it takes itself does not count.
void save_if_due(const RunRequest& request, Output& output, const scene_file::SaveRun& save) {
  if (request.checkpoint_seconds <= 0.0) return;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - output.saved;
  if (since.count() < request.checkpoint_seconds) return;
  write_checkpoint(*output.folder, request, *output.files, save);
  output.saved = std::chrono::steady_clock::now();
}

/// The first process makes the folder, the others write to it as well.
OutputFolder open_folder(const std::string& out, const Processes& processes) {
  std::optional<OutputFolder> folder;
  std::string failure;
  try {
    if (processes.is_first()) folder.emplace(out);
  } catch (const scene_file::FileError& error) {
    failure = error.what();
  }
  const std::string part = processes.of_first(folder ? folder->path().string() : "");
  if (part.empty()) throw scene_file::FileError(failure);
  return folder ? std::move(*folder) : OutputFolder::of_another(part);
}

bool ended_early(RunStatus status) {
  return status == RunStatus::Interrupted || status == RunStatus::TimeLimit;
}

/// What is written while the run goes on.
void add_files(const SceneFile& file, const RunArguments& arguments, const Processes& processes,
               Output& output, scene_file::RunOptions& options) {
  options.before_first = [&](const StepView& view) {
    output.folder.emplace(open_folder(arguments.out, processes));
    output.files.emplace(*output.folder, file,
                         FileShare{output.rank_of_block, processes.rank(), processes.count()});
    output.files->start(view);
  };
  options.after_stage = [&](const StepView& view, const scene_file::SaveRun& save) {
    if (ended_early(view.status) && !processes.of_mpi()) {
      write_checkpoint(*output.folder, arguments.request, *output.files, save);
    }
    output.files->end_stage(view);
  };
}

/// Not a failure: the answer is the same to the bit.
void complain_of_threads(const solver::Simulation& simulation) {
  const int asked = simulation.options().threads, given = simulation.threads();
  if (!simulation.threads_refused()) return;
  std::fprintf(stderr, "quoin: %d of %d threads: the system starts no more\n", given, asked);
}

/// Writes the contact problems of every so many steps, each island's as first tried.
class ProblemFiles {
 public:
  explicit ProblemFiles(long every) : every_(every) {}
  /// Throws FileError when one of the step could not be written.
  void end_step() {
    written_.clear();
    if (!failed_.empty()) throw scene_file::FileError(failed_);
  }
  /// `step`: how many have ended. Does not throw.
  void write(const solver::ContactProblem& problem, long step, OutputFolder& folder) {
    if (step % every_ != 0 || !written_.insert(problem.first_block).second) return;
    char name[64];
    std::snprintf(name, sizeof name, "contact_problem_%06ld_%06d.txt", step, problem.first_block);
    const std::filesystem::path path = folder.file(name);
    std::ofstream file(path);
    scene_file::write(file, problem);
    file.close();
    if (!file) failed_ = scene_file::unwritable(path.string()).what();
  }

 private:
  long every_;
  std::string failed_;     ///< why a file can't be written
  std::set<int> written_;  ///< first blocks of the islands that this step has shown
};

/// StopRequest of all processes. They ask each other when a step has ended; within one they give
/// the last answer, since their clocks differ and all take the same steps.
class StopTogether {
 public:
  StopTogether(std::optional<double> max_seconds, const Processes& processes)
      : mine_(max_seconds), processes_(processes) {}
  void end_step() {
    if (!processes_.of_mpi()) return;
    const std::optional<RunStatus> mine = mine_();
    const int all = processes_.largest(mine ? static_cast<int>(*mine) : kNone);
    if (all != kNone) agreed_ = static_cast<RunStatus>(all);
  }
  std::optional<RunStatus> operator()() const { return processes_.of_mpi() ? agreed_ : mine_(); }

 private:
  static constexpr int kNone = -1;
  StopRequest mine_;
  const Processes& processes_;
  std::optional<RunStatus> agreed_{};
};

RunResult run_with_files(const SceneFile& file, const RunArguments& arguments, Processes& processes,
                         Output& output) {
  ProgressLine progress(file.stages.size(), processes);
  StopTogether stop(arguments.max_seconds, processes);
  scene_file::RunOptions options;
  options.threads = arguments.threads;
  options.on_failure = arguments.request.on_failure == "accept"
                           ? scene_file::RunOptions::OnFailure::Accept
                           : scene_file::RunOptions::OnFailure::Stop;
  options.distributed_solver = processes.solver(output.rank_of_block);
  if (output.files) options.resume = &output.checkpoint;
  if (!arguments.out.empty() || output.files)
    add_files(file, arguments, processes, output, options);
  options.before_first = [&, then = options.before_first](const StepView& view) {
    if (processes.is_first()) complain_of_threads(view.simulation);
    if (then) then(view);
  };
  options.stop = [&] { return stop(); };
  options.in_step = [&](const StepView& view) { progress.show_in_step(view); };
  std::optional<ProblemFiles> problems;
  if (arguments.request.dump_steps > 0) {
    problems.emplace(arguments.request.dump_steps);
    options.contact_problem = [&](const solver::ContactProblem& problem) {
      problems->write(problem, output.files->steps(), *output.folder);
    };
  }
  options.after_step = [&](const StepView& view, const scene_file::SaveRun& save) {
    progress.end_step();
    if (problems) problems->end_step();
    progress.show(view);
    stop.end_step();
    if (!output.files) return;
    output.files->step(view);
    save_if_due(arguments.request, output, save);
  };
  return scene_file::run_scene(file, options);
}

/// Opens what is to be gone on with; the arguments become those of its run.
SceneFile resumed(RunArguments& arguments, Output& output) {
  output.folder.emplace(OutputFolder::reopen(arguments.resume));
  const std::filesystem::path path = output.folder->path() / OutputFolder::kCheckpoint;
  try {
    output.checkpoint.open(path, std::ios::binary);
    const double every = arguments.request.checkpoint_seconds;
    arguments.request = read_request(output.checkpoint);
    if (every > 0.0) arguments.request.checkpoint_seconds = every;
  } catch (const scene_file::FileError& error) {
    throw scene_file::FileError(path.string() + ": " + error.what());
  }
  SceneFile file = scene_file::read_scene(arguments.request.path, arguments.request.changes);
  if (hash_of_inputs(file) != arguments.request.inputs) {
    throw scene_file::FileError(arguments.request.scene +
                                ": it, or a file that it names, was changed since the checkpoint");
  }
  return file;
}

SceneFile opened(RunArguments& arguments, Output& output) {
  if (!arguments.resume.empty()) return resumed(arguments, output);
  SceneFile file = scene_file::read_scene(arguments.request.scene, arguments.request.changes);
  if (!arguments.out.empty()) {
    arguments.request.path = std::filesystem::absolute(arguments.request.scene).string();
    arguments.request.inputs = hash_of_inputs(file);
  }
  return file;
}

/// What several processes do not share out is refused: each would do all of it.
void check_distributed(const SceneFile& file) {
  using solver::ContactMethod, solver::ContactIteration;
  const ContactMethod method = file.options.method;
  if (method == ContactMethod::Paper || method == ContactMethod::Penalty) {
    throw scene_file::SceneError(
        "/method", std::string("\"") + name(method) + "\" knows one process alone, --mpi does not");
  }
  for (const scene_file::Stage& stage : file.stages) {
    if (stage.contact_iteration != ContactIteration::ProximalNewton) continue;
    throw scene_file::SceneError("/contact_iteration",
                                 "\"proximal_newton\" knows one process alone, --mpi does not");
  }
}

void end_files(const nlohmann::ordered_json& report, const RunResult& result,
               const Processes& processes, Output& output) {
  output.files->finish();
  processes.largest(0);  // all pieces are there
  if (!processes.is_first()) return;
  save(output.folder->file("summary.json"), report);
  if (const auto& proof = result.proof) {
    save(output.folder->file("mechanism.json"),
         limit_analysis::certificate({0.0, proof->scene, proof->problem, 0.0, proof->found},
                                     {.what = "run"}));
  }
  const bool goes_on = ended_early(result.status) && !processes.of_mpi();
  output.folder->commit(goes_on ? OutputFolder::Checkpoint::Keep : OutputFolder::Checkpoint::Drop);
}

/// Of loads on what came loose and was removed.
void complain_of_lost_loads(const SceneFile& file, const RunResult& result) {
  for (const scene_file::LooseBlock& loose : result.loose) {
    const auto is_on = [&](const auto& load) { return load.block == loose.block; };
    bool any = false;
    for (auto s = static_cast<std::size_t>(loose.stage); s < result.stages.size(); ++s) {
      const solver::Scene& scene = file.scene_in(s);
      any = any || std::ranges::any_of(scene.point_loads, is_on) ||
            std::ranges::any_of(scene.face_loads, is_on) ||
            std::ranges::any_of(scene.body_loads, is_on);
    }
    if (!any || !loose.removed) continue;
    complain("block " + file.scene.blocks[static_cast<std::size_t>(loose.block)].name +
             ": its loads act on nothing: it came loose in stage " + std::to_string(loose.stage) +
             " and was removed");
  }
}

int run(RunArguments& arguments, Processes& processes) {
  catch_signals();
  Output output;
  const SceneFile file = opened(arguments, output);
  if (processes.of_mpi()) {
    check_distributed(file);
    output.rank_of_block = solver::parts_of_blocks(file.scene, processes.count());
  }
  if (processes.is_first()) {
    for (const std::string& line : file.notes) complain(line);
    for (const std::string& line : scene_file::points_outside_lines(file)) complain(line);
  }
  if (output.folder) output.files.emplace(*output.folder, file, output.checkpoint);
  RunResult result = run_with_files(file, arguments, processes, output);
  if (!output.folder)
    result.left_out.emplace_back("history and ParaView files: no folder is asked for");
  if (output.folder && !file.paraview)
    result.left_out.emplace_back("ParaView files: \"paraview\" is false");
  const nlohmann::ordered_json report = summary(file, arguments.request.scene, result);
  if (output.folder) end_files(report, result, processes, output);
  const std::vector<std::string> failed = failures(file, result);
  const int exit_code = failed.empty() ? kDone : kFailed;
  if (!processes.is_first()) return exit_code;
  if (arguments.json)
    std::printf("%s\n", text(report).c_str());
  else
    print_result(file, arguments.request.scene, result);
  complain_of_lost_loads(file, result);
  for (const std::string& line : failed) complain(line);
  return exit_code;
}

int run_on_ranks(RunArguments& arguments) {
  return run_guarded(
      [&] {
        Processes processes = Processes::of_mpirun();
        return processes.end_together(
            ending_of([&] { return run(arguments, processes); }, arguments.request.scene));
      },
      arguments.request.scene);
}

int run_alone(RunArguments& arguments) {
  Processes processes;
  return run_guarded([&] { return run(arguments, processes); }, arguments.request.scene);
}

/// A process of several writes no checkpoint and reads none.
void add_mpi(CLI::App& command, RunArguments& arguments) {
  CLI::Option* mpi = command.add_flag(
      "--mpi", arguments.mpi,
      "share out large linear systems and ParaView files over the processes of mpirun");
  for (const char* option : {"--resume", "--checkpoint", "--dump-steps"})
    mpi->excludes(command.get_option(option));
}

void add_clocks(CLI::App& command, RunArguments& arguments) {
  command
      .add_option("--max-seconds", arguments.max_seconds,
                  "end after this wall time, s, with all files of the state reached and, but for "
                  "--mpi, a checkpoint (default: no limit)")
      ->check(in_range(0, kMostSeconds));
  command
      .add_option("--checkpoint", arguments.request.checkpoint_seconds,
                  "write a checkpoint in the folder every so many seconds of wall time (default: "
                  "only when the run is ended early)")
      ->check(in_range(1e-3, kMostSeconds));
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  RunRequest& request = arguments->request;
  CLI::App* command = app.add_subcommand("run", "Run a scene; report its error and what it took");
  CLI::Option* scene =
      command->add_option("scene", request.scene, "scene file, JSON (see scene.schema.json)");
  CLI::Option* out = command->add_option(
      "--out", arguments->out,
      "folder for summary.json, history.csv, blocks.csv, contacts.csv, blocks.pvd and "
      "contacts.pvd; "
      "takes the place of earlier results, of nothing else (default: no files)");
  out->check(path_to_write());
  command->add_flag("--json", arguments->json, "print summary.json on standard output");
  CLI::Option* set = command->add_option(
      "--set", request.changes,
      "change the scene before it is read: a parameter (phi=10) or a place in the file "
      "(/penalty=5e7, /method=penalty); may be repeated");
  set->type_name("NAME=VALUE");
  CLI::Option* on_failure = command->add_option(
      "--on-failure", request.on_failure,
      "a step that does not converge, a static stage that does not come to rest: stop, or accept "
      "the best state and go on (the exit code is 1 all the same)");
  on_failure->check(CLI::IsMember({"stop", "accept"}))->capture_default_str();
  add_clocks(*command, *arguments);
  command
      ->add_option("--resume", arguments->resume,
                   "go on with the run that was killed or ended early, to the bit; DIR: its --out")
      ->type_name("DIR")
      ->excludes(scene)
      ->excludes(out)
      ->excludes(set)
      ->excludes(on_failure);
  command
      ->add_option("--dump-steps", arguments->request.dump_steps,
                   "write the linearised contact problem of every N-th step to the folder "
                   "(contact_problem_….txt; format: solver/README.md)")
      ->type_name("N")
      ->check(CLI::Range(1L, 1000000000L))
      ->needs(out);
  command->add_option("--threads", arguments->threads, "any number gives the same bits")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_mpi(*command, *arguments);
  command->callback([arguments, &exit_code] {
    if (arguments->request.scene.empty() && arguments->resume.empty())
      throw CLI::RequiredError("scene");
    if (arguments->request.checkpoint_seconds > 0.0 && arguments->out.empty() &&
        arguments->resume.empty())
      throw CLI::ValidationError("--checkpoint", "needs a folder: --out");
    exit_code = arguments->mpi ? run_on_ranks(*arguments) : run_alone(*arguments);
  });
}

}  // namespace quoin::commands
