#pragma once
/// A folder of results that appears whole: filled beside its name, put in place at the end.
///
/// While a run goes on its files are in `NAME.part-…`, with a journal (`.quoin-journal`) that names
/// them, locked by the process. At the end `manifest.json` is added (names, sizes, hashes) and the
/// folder takes the place of earlier results: only of files that such a manifest names and nobody
/// has changed since. Nothing else is ever deleted.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace quoin::commands {

class OutputFolder {
 public:
  /// Throws FileError naming what stands in the way when the folder can't be made or replaced.
  explicit OutputFolder(const std::filesystem::path& folder);

  /// To go on with a run that left a checkpoint: what was killed, else what ended early. `folder`:
  /// what
  /// --out was, or a `.part-` folder. Throws FileError when there is none, or it is still running.
  static OutputFolder reopen(const std::filesystem::path& folder);

  /// One that another process fills and puts in place, by its path(): files go there.
  static OutputFolder of_another(const std::filesystem::path& part);

  ~OutputFolder();
  OutputFolder(OutputFolder&&) noexcept;
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  OutputFolder& operator=(OutputFolder&&) = delete;

  /// Where to write the file of this name meanwhile; it becomes one of ours.
  std::filesystem::path file(const std::string& name);
  std::filesystem::path path() const { return part_; }

  /// Takes the place of earlier results. Throws FileError; what was written then stays where it is.
  enum class Checkpoint : std::uint8_t { Keep, Drop };
  void commit(Checkpoint checkpoint);

  static constexpr const char* kCheckpoint = "checkpoint.bin";

 private:
  OutputFolder() = default;
  void lock_journal(int flags);

  std::filesystem::path folder_, part_;
  std::vector<std::string> names_;
  bool copied_ = false;  ///< from results that are still there, and nothing was written since
  int journal_ = -1;     ///< file descriptor, its lock ends with the process; -1: another's folder
};

}  // namespace quoin::commands
