#include "python_program.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "scene_file/scene_error.hpp"
#include "shared_file.hpp"

namespace quoin::commands {
namespace {

/// The first Python that has a package; it may not be the first in PATH.
std::string python(const std::string& package) {
  for (const char* name : {"python3", "/usr/bin/python3"}) {
    const std::string tried = std::string(name) + " -c 'import " + package + "' >/dev/null 2>&1";
    if (std::system(tried.c_str()) == 0) return name;
  }
  throw scene_file::FileError("no python3 with " + package + " (Debian: python3-" + package + ")");
}

[[noreturn]] void execute(std::vector<std::string>& words) {
  std::error_code none;
  const std::string command = std::filesystem::read_symlink("/proc/self/exe", none).string();
  setenv("QUOIN", command.c_str(), 1);  // the programs call it back
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execvp(pointers[0], pointers.data());
  throw scene_file::FileError(words[0] + ": can't be run: " + std::strerror(errno));
}

}  // namespace

void become_python_program(const std::string& name, std::vector<std::string> words,
                           const std::string& package) {
  words.insert(words.begin(), {python(package), shared_file(name)});
  execute(words);
}

void run_python_program(const std::string& name, std::vector<std::string> words) {
  words.insert(words.begin(), {python("matplotlib"), shared_file(name)});
  const pid_t process = fork();
  if (process == 0) {
    try {
      execute(words);
    } catch (const scene_file::FileError&) {
      _exit(127);
    }
  }
  int status = 0;
  if (process < 0 || waitpid(process, &status, 0) < 0 || status != 0)
    throw scene_file::FileError(name + ": failed");
}

}  // namespace quoin::commands
