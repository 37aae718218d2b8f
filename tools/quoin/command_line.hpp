#pragma once
/// The command line of the programs.

namespace CLI {
class App;
}

namespace quoin::commands {

using AddCommand = void (*)(CLI::App& app, int& exit_code);

/// Does what the command line says. Returns the exit code. `add_referee`: of the program that has
/// the referee; the others leave `quoin referee` to it.
int run_command_line(int argc, char** argv, AddCommand add_referee = nullptr);

}  // namespace quoin::commands
