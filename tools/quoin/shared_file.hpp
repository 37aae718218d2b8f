#pragma once
/// What the command finds beside itself.

#include <string>

namespace quoin::commands {

/// A file or folder of tools/ (a script, scenes): beside the installed command, or where it was
/// built from. Throws FileError.
std::string shared_file(const std::string& name);

}  // namespace quoin::commands
