/// quoin plot, quoin picture, quoin view: hand over to the Python programs of the same names.

#include "commands.hpp"
#include "python_program.hpp"

namespace quoin::commands {
namespace {

void add(CLI::App& app, const char* name, const char* script_name, const char* package,
         const char* what) {
  CLI::App* command = app.add_subcommand(name, what);
  command->prefix_command();
  command->set_help_flag();  // --help goes to the program, too
  command->callback([=] { become_python_program(script_name, command->remaining(), package); });
}

}  // namespace

void add_picture_commands(CLI::App& app) {
  add(app, "plot", "plot_run.py", "matplotlib",
      "Plot a run's history, thrust line, forces and pressures of its joints (matplotlib)");
  add(app, "picture", "picture.py", "matplotlib",
      "Draw a run's blocks at some times, or as GIF or MP4, with forces and contacts (matplotlib)");
  add(app, "view", "view.py", "numpy",
      "Show a run, a scene or pairs in a page for the browser, one file without a network (numpy)");
}

}  // namespace quoin::commands
