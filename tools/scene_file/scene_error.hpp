#pragma once
/// What can be wrong with a scene: what it says, or the file itself.

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

namespace quoin::scene_file {

/// The scene says something that can't be worked with; names the place by a JSON pointer.
class SceneError : public std::runtime_error {
 public:
  SceneError(const std::string& pointer, const std::string& message)
      : std::runtime_error((pointer.empty() ? "/" : pointer) + ": " + message) {}
};

/// A file that can't be read or written.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// With the reason of the call that failed last.
inline FileError unwritable(const std::string& path) {
  return FileError(path + ": can't be written" +
                   (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
}

}  // namespace quoin::scene_file
