#pragma once
/// A folder of results that appears whole: filled beside its name, renamed at the end.

#include <filesystem>

namespace quoin::commands {

class OutputFolder {
 public:
  /// Throws FileError when it can't be made, or when something else than earlier results is there.
  explicit OutputFolder(const std::filesystem::path& folder);
  ~OutputFolder();  ///< what was not committed is removed
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write meanwhile.
  const std::filesystem::path& path() const { return part_; }

  /// Takes the place of earlier results. Throws FileError.
  void commit();

 private:
  std::filesystem::path folder_, part_;
};

}  // namespace quoin::commands
