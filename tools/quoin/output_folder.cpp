#include "output_folder.hpp"

#include <unistd.h>

#include <string>
#include <system_error>

#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

namespace fs = std::filesystem;
using scene_file::FileError;

/// Only an empty folder or one that this command filled may be replaced.
bool is_replaceable(const fs::path& folder) {
  return !fs::exists(folder) || (fs::is_directory(folder) &&
                                 (fs::is_empty(folder) || fs::exists(folder / "summary.json")));
}

fs::path beside(const fs::path& folder, const char* what) {
  fs::path result = folder;
  result += std::string(".") + what + "-" + std::to_string(getpid());
  return result;
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& folder)
    : folder_(fs::absolute(folder).lexically_normal()) {
  if (!folder_.has_filename()) {
    folder_ = folder_.parent_path();  // a trailing slash
  }
  part_ = beside(folder_, "part");
  try {
    if (!is_replaceable(folder_)) {
      throw FileError(folder_.string() + ": is there already and holds no results of this command");
    }
    fs::create_directories(folder_.parent_path());
    if (!fs::create_directory(part_)) {
      throw FileError(part_.string() + ": is there already");
    }
  } catch (const fs::filesystem_error& error) {
    throw FileError(folder_.string() + ": can't be written: " + error.code().message());
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(part_, ignored);
}

void OutputFolder::commit() {
  try {
    if (fs::exists(folder_)) {
      const fs::path old = beside(folder_, "old");
      fs::rename(folder_, old);
      fs::rename(part_, folder_);
      fs::remove_all(old);
    } else {
      fs::rename(part_, folder_);
    }
  } catch (const fs::filesystem_error& error) {
    throw FileError(folder_.string() + ": can't be written: " + error.code().message());
  }
}

}  // namespace quoin::commands
