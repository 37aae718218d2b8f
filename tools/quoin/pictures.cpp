/// quoin plot, quoin picture: hand over to the Python programs of the same names.

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "commands.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

/// The first Python that has matplotlib; it may not be the first in PATH.
std::string python() {
  for (const char* name : {"python3", "/usr/bin/python3"}) {
    const std::string tried = std::string(name) + " -c 'import matplotlib' >/dev/null 2>&1";
    if (std::system(tried.c_str()) == 0) {
      return name;
    }
  }
  throw scene_file::FileError("no python3 with matplotlib (Debian: python3-matplotlib)");
}

[[noreturn]] void hand_over(const std::string& name, std::vector<std::string> words) {
  words.insert(words.begin(), {python(), shared_file(name)});
  std::vector<char*> pointers;
  for (std::string& word : words) {
    pointers.push_back(word.data());
  }
  pointers.push_back(nullptr);
  execvp(pointers[0], pointers.data());
  throw scene_file::FileError(words[0] + ": can't be run: " + std::strerror(errno));
}

void add(CLI::App& app, const char* name, const char* script_name, const char* what) {
  CLI::App* command = app.add_subcommand(name, what);
  command->prefix_command();
  command->set_help_flag();  // --help goes to the program, too
  command->callback([command, script_name] { hand_over(script_name, command->remaining()); });
}

}  // namespace

void add_picture_commands(CLI::App& app) {
  add(app, "plot", "plot_run.py",
      "Plot a run's history, thrust line, forces and pressures of its joints (matplotlib)");
  add(app, "picture", "picture.py",
      "Draw a run's blocks at some times, or as GIF or MP4, with forces and contacts (matplotlib)");
}

}  // namespace quoin::commands
