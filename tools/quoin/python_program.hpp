#pragma once
/// The Python programs that are installed with the command.

#include <string>
#include <vector>

namespace quoin::commands {

/// Becomes the program, which finds the command in the environment variable QUOIN. Throws FileError
/// where the program, or a python3 with the package that it needs, is missing.
[[noreturn]] void become_python_program(const std::string& name, std::vector<std::string> words,
                                        const std::string& package);

/// Runs one that needs matplotlib to its end. Throws FileError likewise, and when it does not end
/// with 0.
void run_python_program(const std::string& name, std::vector<std::string> words);

}  // namespace quoin::commands
