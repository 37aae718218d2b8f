#pragma once
/// The Python programs that are installed with the command.

#include <string>
#include <vector>

namespace quoin::commands {

/// Becomes the program. Throws FileError where that, or a python3 with matplotlib, is missing.
[[noreturn]] void become_python_program(const std::string& name, std::vector<std::string> words);

/// Runs it to its end. Throws FileError likewise, and when it does not end with 0.
void run_python_program(const std::string& name, std::vector<std::string> words);

}  // namespace quoin::commands
