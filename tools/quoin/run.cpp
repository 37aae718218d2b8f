/// quoin run SCENE.json

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "commands.hpp"
#include "output_folder.hpp"
#include "run_files.hpp"
#include "scene_file/run_scene.hpp"

namespace quoin::commands {
namespace {

using scene_file::RunResult;
using scene_file::RunStatus;
using scene_file::SceneFile;
using scene_file::StepView;

struct RunArguments {
  std::string scene;
  std::string out;
  std::vector<std::string> changes;
  std::string on_failure = "stop";
  int threads = 1;
  bool json = false;
};

/// Set by the handler of SIGINT; the run then ends after the step it is in.
volatile std::sig_atomic_t interrupted = 0;

extern "C" void note_interrupt(int) { interrupted = 1; }

/// One line on a terminal, rewritten a few times a second; nothing when piped.
class ProgressLine {
 public:
  explicit ProgressLine(std::size_t stages) : on_(isatty(STDERR_FILENO) != 0), stages_(stages) {}
  ~ProgressLine() {
    if (on_) {
      std::fputs("\r\033[K", stderr);
    }
  }
  void show(const StepView& view) {
    const auto now = std::chrono::steady_clock::now();
    if (!on_ || now - last_ < std::chrono::milliseconds(100)) {
      return;
    }
    last_ = now;
    std::fprintf(stderr, "\r\033[Kstage %zu of %zu  %3.0f %%  t = %.4g s  %d of %d contacts closed",
                 view.stage + 1, stages_, 100 * view.progress, view.dynamic_time,
                 view.report.closed_count, view.report.contact_count);
  }

 private:
  bool on_;
  std::size_t stages_;
  std::chrono::steady_clock::time_point last_;
};

void print_result(const SceneFile& file, const RunResult& result) {
  std::printf("%s: %ld steps, %.6g s in %.3g s\n", file.title.c_str(), result.steps, result.time,
              result.wall_seconds);
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

void save_summary(const std::filesystem::path& folder, const nlohmann::ordered_json& summary) {
  const std::filesystem::path path = folder / "summary.json";
  std::ofstream stream(path);
  stream << summary.dump(2) << '\n';
  stream.close();
  if (!stream) {
    throw scene_file::FileError(path.string() + ": can't be written");
  }
}

/// Made when the solver has taken the scene: a scene that is refused leaves nothing behind.
struct Output {
  std::optional<OutputFolder> folder;
  std::optional<RunFiles> files;
};

RunResult run_with_files(const SceneFile& file, const RunArguments& arguments, Output& output) {
  ProgressLine progress(file.stages.size());
  scene_file::RunOptions options;
  options.threads = arguments.threads;
  options.on_failure = arguments.on_failure == "accept" ? scene_file::RunOptions::OnFailure::Accept
                                                        : scene_file::RunOptions::OnFailure::Stop;
  if (!arguments.out.empty()) {
    options.before_first = [&](const StepView& view) {
      output.folder.emplace(arguments.out);
      output.files.emplace(output.folder->path(), file);
      output.files->start(view);
    };
  }
  options.after_step = [&](const StepView& view) {
    progress.show(view);
    if (output.files) {
      output.files->step(view);
    }
    return interrupted == 0;
  };
  return scene_file::run_scene(file, options);
}

int run(const RunArguments& arguments) {
  const SceneFile file = scene_file::read_scene(arguments.scene, arguments.changes);
  std::signal(SIGINT, note_interrupt);
  Output output;
  RunResult result = run_with_files(file, arguments, output);
  if (arguments.out.empty()) {
    result.left_out.emplace_back("history and ParaView files: no folder is asked for");
  }
  const nlohmann::ordered_json report = summary(file, arguments.scene, result, arguments.threads);
  if (output.folder) {
    output.files->finish();
    save_summary(output.folder->path(), report);
    output.folder->commit();
  }
  if (arguments.json) {
    std::printf("%s\n", report.dump(2).c_str());
  } else {
    print_result(file, result);
  }
  if (result.status != RunStatus::Completed) {
    std::fprintf(stderr, "quoin: %s\n", result.message.c_str());
  }
  const bool accepted = arguments.on_failure == "accept" && result.status != RunStatus::Interrupted;
  return result.status == RunStatus::Completed || accepted ? kDone : kFailed;
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Run a scene; report its error and what it took");
  command->add_option("scene", arguments->scene, "scene file, JSON (see scene.schema.json)")
      ->required();
  command->add_option("--out", arguments->out,
                      "folder for summary.json, history.csv, blocks.pvd, contacts.pvd "
                      "(default: no files)");
  command->add_flag("--json", arguments->json, "print summary.json on standard output");
  command
      ->add_option("--set", arguments->changes,
                   "change the scene before it is read: a parameter (phi=10) or a place in the "
                   "file (/penalty=5e7, /method=penalty); may be repeated")
      ->type_name("NAME=VALUE");
  command
      ->add_option("--on-failure", arguments->on_failure,
                   "a step that does not converge, a static stage that does not come to rest: "
                   "stop, or accept the best state and go on")
      ->check(CLI::IsMember({"stop", "accept"}))
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "any number gives the same bits")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->callback([arguments, &exit_code] {
    try {
      exit_code = run(*arguments);
    } catch (const scene_file::SceneError& error) {
      std::fprintf(stderr, "%s: %s\n", arguments->scene.c_str(), error.what());
      exit_code = kBadInput;
    } catch (const geometry::InputError& error) {
      std::fprintf(stderr, "%s: /blocks: %s\n", arguments->scene.c_str(), error.what());
      exit_code = kBadInput;
    }
  });
}

}  // namespace quoin::commands
