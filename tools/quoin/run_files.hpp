#pragma once
/// The files of one run: history.csv, ParaView files, summary.json.

#include <filesystem>
#include <fstream>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scene_file/run_scene.hpp"

namespace quoin::commands {

/// history.csv, blocks_*.vtu + blocks.pvd, contacts_*.vtp + contacts.pvd, as the run goes on.
class RunFiles {
 public:
  RunFiles(const std::filesystem::path& folder, const scene_file::SceneFile& file);
  void start(const scene_file::StepView& view);
  void step(const scene_file::StepView& view);
  void finish();  ///< throws FileError when something could not be written

 private:
  void write_history_head();
  void write_history_line(const scene_file::StepView& view);
  void write_vtk(const scene_file::StepView& view);
  bool is_due(const scene_file::StepView& view) const;

  std::filesystem::path folder_;
  const scene_file::SceneFile& file_;
  std::ofstream history_;
  long steps_ = 0;
  std::vector<double> times_;
  std::vector<std::string> block_files_, contact_files_;
};

/// The keys of summary.json, as tools/README.md documents them.
nlohmann::ordered_json summary(const scene_file::SceneFile& file, const std::string& path,
                               const scene_file::RunResult& result, int threads);

}  // namespace quoin::commands
