#include "command_line.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <stdexcept>
#include <string_view>

#include "commands.hpp"
#include "processes.hpp"

namespace quoin::commands {
namespace {

/// What was printed may be stuck in a full disk or a closed pipe.
int all_is_told() {
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return kDone;
  complain("standard output can't be written");
  return kFailed;
}

/// All processes of an mpirun read the same command line: the first one tells what is wrong.
int tell(const CLI::App& app, const CLI::ParseError& error, bool on_ranks) {
  const Processes processes =
      on_ranks && Processes::are_known() ? Processes::of_mpirun() : Processes();
  if (!processes.is_first()) return kDone;
  return app.exit(error) == 0 ? all_is_told() : kBadInput;
}

/// A run on several processes is that of quoin-mpi beside this program, where it was built, and
/// the referee is quoin-referee.
void leave_to(const char* program, char** argv) {
  std::error_code none;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", none);
  ::execv((self.parent_path() / program).c_str(), argv);
}

std::terminate_handler usual_end = nullptr;

/// Memory that a destructor asks for (a JSON tree takes a list of its own to be destroyed) can't be
/// refused as an exception.
[[noreturn]] void end_without_memory() {
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    constexpr std::string_view kLine = "quoin: out of memory\n";
    if (::write(STDERR_FILENO, kLine.data(), kLine.size()) >= 0) ::_exit(kFailed);
  } catch (...) {
  }
  usual_end();
  std::abort();
}

}  // namespace

int run_command_line(int argc, char** argv, AddCommand add_referee) {
  const bool on_ranks = std::find(argv, argv + argc, std::string_view("--mpi")) < argv + argc;
  if (on_ranks && !Processes::are_known()) leave_to("quoin-mpi", argv);
  if (add_referee == nullptr && argc > 1 && argv[1] == std::string_view("referee"))
    leave_to("quoin-referee", argv);
  CLI::App app{
      "quoin: contact geometry of convex polyhedra and 3-D discontinuous deformation analysis.\n"
      "Units are SI; angles carry their unit in the name.\n"
      "Exit codes: 0 done and all is well; 1 failed: a file that can't be read or written, a run "
      "that "
      "did not converge, missed a reference or was ended early; 2 input that can't be worked "
      "with."};
  app.set_version_flag("--version", "quoin " QUOIN_VERSION);
  app.require_subcommand(0, 1);  // what follows the command names files, though one be called "run"
  int exit_code = kDone;
  add_run_command(app, exit_code);
  add_info_command(app, exit_code);
  add_check_command(app, exit_code);
  add_cut_command(app, exit_code);
  add_import_command(app, exit_code);
  add_limit_command(app, exit_code);
  add_make_command(app, exit_code);
  add_picture_commands(app);
  add_raster_command(app, exit_code);
  add_stability_command(app, exit_code);
  add_study_command(app, exit_code);
  add_contact_command(app, exit_code);
  add_validate_command(app, exit_code);
  if (add_referee != nullptr) {
    add_referee(app, exit_code);
  } else {
    app.add_subcommand("referee", "Judge contact libraries: quoin-referee beside this program")
        ->prefix_command()
        ->callback([] {
          throw std::runtime_error("quoin-referee is not there: it is built where GMP is");
        });
  }
  ::signal(SIGXFSZ, SIG_IGN);  // a file that may grow no more is told like a full disk
  usual_end = std::set_terminate(end_without_memory);
  const auto command = [&]() -> int {
    try {
      app.parse(argc, argv);
      if (app.get_subcommands().empty())
        throw CLI::RequiredError("a command (quoin --help names them)");
    } catch (const CLI::ParseError& error) {
      return tell(app, error, on_ranks);
    }
    return exit_code == kDone ? all_is_told() : exit_code;
  };
  return run_guarded(command, "");
}

}  // namespace quoin::commands
