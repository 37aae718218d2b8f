#pragma once
/// The checkpoint of a run: what was asked for, then where its files and its simulation are.

#include <istream>
#include <string>
#include <vector>

#include "output_folder.hpp"
#include "run_files.hpp"

namespace quoin::commands {

/// What was asked for: enough to read the same scene again.
struct RunRequest {
  std::string scene{};  ///< as it was named
  std::string path{};   ///< the same, absolute
  std::vector<std::string> changes{};
  std::string on_failure = "stop";
  double checkpoint_seconds = 0.0;  ///< of wall time between checkpoints; 0: none while it runs
  long dump_steps = 0;   ///< steps between those whose contact problems are written; 0: none
  std::string inputs{};  ///< hash of the scene and all files that it names
};

/// Hash of the files that a scene was read from. Throws FileError.
std::string hash_of_inputs(const scene_file::SceneFile& file);

/// Appears whole in the place of the last one. Throws FileError.
void write_checkpoint(OutputFolder& folder, const RunRequest& request, RunFiles& files,
                      const scene_file::SaveRun& save);

/// The request; `in` then stands where RunFiles and run_scene() go on. Throws FileError when the
/// checkpoint is of another program.
RunRequest read_request(std::istream& in);

}  // namespace quoin::commands
