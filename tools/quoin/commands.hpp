#pragma once
/// The subcommands of `quoin`: each in a file of its own, added to the command line by one
/// function.

#include <CLI/CLI.hpp>

namespace quoin::commands {

/// Exit codes of every command.
enum ExitCode : int {
  kDone = 0,
  kFailed = 1,   ///< a file that can't be read or written, a run that could not converge
  kBadInput = 2  ///< the input says something that can't be worked with
};

/// Each adds its subcommand to `app`; the subcommand leaves its exit code in `exit_code`.
void add_check_command(CLI::App& app, int& exit_code);
void add_contact_command(CLI::App& app, int& exit_code);
void add_info_command(CLI::App& app, int& exit_code);
void add_make_command(CLI::App& app, int& exit_code);
void add_picture_commands(CLI::App& app);  ///< plot, picture: exit codes are those of Python
void add_run_command(CLI::App& app, int& exit_code);
void add_stability_command(CLI::App& app, int& exit_code);
void add_study_command(CLI::App& app, int& exit_code);
void add_validate_command(CLI::App& app, int& exit_code);

}  // namespace quoin::commands
