/// The command `quoin`.

#include <signal.h>

#include <cstdio>
#include <exception>
#include <iostream>

#include "commands.hpp"

namespace {

/// What was printed may be stuck in a full disk or a closed pipe.
int all_is_told() {
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) {
    return quoin::commands::kDone;
  }
  quoin::commands::complain("standard output can't be written");
  return quoin::commands::kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "quoin: contact geometry of convex polyhedra and 3-D discontinuous deformation analysis.\n"
      "Units are SI; angles carry their unit in the name.\n"
      "Exit codes: 0 done and all is well; 1 failed: a file that can't be read or written, a run "
      "that "
      "did not converge, missed a reference or was ended early; 2 input that can't be worked "
      "with."};
  app.set_version_flag("--version", "quoin " QUOIN_VERSION);
  int exit_code = quoin::commands::kDone;
  quoin::commands::add_run_command(app, exit_code);
  quoin::commands::add_info_command(app, exit_code);
  quoin::commands::add_check_command(app, exit_code);
  quoin::commands::add_make_command(app, exit_code);
  quoin::commands::add_picture_commands(app);
  quoin::commands::add_stability_command(app, exit_code);
  quoin::commands::add_study_command(app, exit_code);
  quoin::commands::add_contact_command(app, exit_code);
  quoin::commands::add_validate_command(app, exit_code);
#ifdef QUOIN_REFEREE
  quoin::commands::add_referee_command(app, exit_code);
#endif
  ::signal(SIGXFSZ, SIG_IGN);  // a file that may grow no more is told like a full disk
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) {
      throw CLI::RequiredError("a command (quoin --help names them)");
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? all_is_told() : quoin::commands::kBadInput;
  } catch (const std::exception& error) {
    quoin::commands::complain(error.what());
    return quoin::commands::kFailed;
  }
  return exit_code == quoin::commands::kDone ? all_is_told() : exit_code;
}
