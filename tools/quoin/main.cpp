/// The command `quoin`.

#include <cstdio>
#include <exception>

#include "commands.hpp"

int main(int argc, char** argv) {
  CLI::App app{
      "quoin: contact geometry of convex polyhedra and 3-D discontinuous deformation analysis.\n"
      "Units are SI; angles carry their unit in the name.\n"
      "Exit codes: 0 done, 1 failed (file, convergence), 2 input that can't be worked with."};
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
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) {
      throw CLI::RequiredError("a command (quoin --help names them)");
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? quoin::commands::kDone : quoin::commands::kBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "quoin: %s\n", error.what());
    return quoin::commands::kFailed;
  }
  return exit_code;
}
