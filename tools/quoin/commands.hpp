#pragma once
/// The subcommands of `quoin`: each in a file of its own, added to the command line by one
/// function.

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ending.hpp"
#include "path_to_write.hpp"

namespace quoin::commands {

/// JSON over many lines; bytes that are no UTF-8 are replaced.
std::string text(const nlohmann::ordered_json& document);

/// What a string of JSON says; there as long as the string.
const char* words(const nlohmann::ordered_json& string);

/// The scene file and `--set`, which changes it before it is read.
void add_scene_options(CLI::App& command, std::string& scene, std::vector<std::string>& changes);

/// A file or folder to be written.
template <class Path>
void add_path(CLI::App& command, const char* name, Path& path, const char* help) {
  command.add_option(name, path, help)->check(path_to_write());
}

template <class Words>
struct Subcommand {
  CLI::App& command;
  Words& words;  ///< what the command line says; there as long as the command
};

/// A subcommand that runs `act` on its words under run_guarded; what it reads, by which messages
/// begin, is their `scene` or `file`.
template <class Words>
Subcommand<Words> add_command(CLI::App& app, int& exit_code, int (*act)(const Words&),
                              const std::string& name, const std::string& help) {
  const auto words = std::make_shared<Words>();
  CLI::App* command = app.add_subcommand(name, help);
  command->callback([=, &exit_code] {
    std::string subject = "quoin " + name;
    if constexpr (requires { words->scene; }) subject = words->scene;
    if constexpr (requires { words->file; }) subject = words->file;
    exit_code = run_guarded([&] { return act(*words); }, subject);
  });
  return {*command, *words};
}

/// Each adds its subcommand to `app`; the subcommand leaves its exit code in `exit_code`.
void add_check_command(CLI::App& app, int& exit_code);
void add_contact_command(CLI::App& app, int& exit_code);
void add_cut_command(CLI::App& app, int& exit_code);
void add_import_command(CLI::App& app, int& exit_code);
void add_info_command(CLI::App& app, int& exit_code);
void add_limit_command(CLI::App& app, int& exit_code);
void add_make_command(CLI::App& app, int& exit_code);
void add_picture_commands(CLI::App& app);  ///< plot, picture, view: exit codes are those of Python
void add_raster_command(CLI::App& app, int& exit_code);
void add_run_command(CLI::App& app, int& exit_code);
void add_stability_command(CLI::App& app, int& exit_code);
void add_study_command(CLI::App& app, int& exit_code);
void add_validate_command(CLI::App& app, int& exit_code);

}  // namespace quoin::commands
