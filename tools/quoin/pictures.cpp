/// quoin plot, quoin picture: hand over to the Python programs of the same names.

#include "commands.hpp"
#include "python_program.hpp"

namespace quoin::commands {
namespace {

void add(CLI::App& app, const char* name, const char* script_name, const char* what) {
  CLI::App* command = app.add_subcommand(name, what);
  command->prefix_command();
  command->set_help_flag();  // --help goes to the program, too
  command->callback(
      [command, script_name] { become_python_program(script_name, command->remaining()); });
}

}  // namespace

void add_picture_commands(CLI::App& app) {
  add(app, "plot", "plot_run.py",
      "Plot a run's history, thrust line, forces and pressures of its joints (matplotlib)");
  add(app, "picture", "picture.py",
      "Draw a run's blocks at some times, or as GIF or MP4, with forces and contacts (matplotlib)");
}

}  // namespace quoin::commands
