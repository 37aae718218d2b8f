#include "shared_file.hpp"

#include <filesystem>

#include "scene_file/scene_error.hpp"

namespace quoin::commands {

std::string shared_file(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::path command = fs::read_symlink("/proc/self/exe", none);
  for (const fs::path& folder :
       {command.parent_path().parent_path() / "share" / "quoin", fs::path(QUOIN_TOOLS_DIR)})
    if (fs::exists(folder / name, none)) return (folder / name).string();
  throw scene_file::FileError(name + ": is not installed beside the command");
}

}  // namespace quoin::commands
