#pragma once
/// The files of one run: history, end states of its stages, ParaView files, summary.json.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "csv_file.hpp"
#include "joint_rows.hpp"
#include "output_folder.hpp"
#include "scene_file/run_scene.hpp"

namespace quoin::commands {

/// Which share of the ParaView files this process writes: of several each writes the pieces of its
/// blocks, the first also the index over them and all other files.
struct FileShare {
  std::vector<int> rank_of_block{};
  int rank = 0, count = 1;
};

/// history.csv; ties.csv, where there are any; blocks_*.vtu + blocks.pvd, contacts_*.vtp +
/// contacts.pvd, ties_*.vtp + ties.pvd; blocks.csv,
/// contacts.csv and joints.csv with the end of every stage. Throws FileError when something can't
/// be written.
class RunFiles {
 public:
  RunFiles(OutputFolder& folder, const scene_file::SceneFile& file, FileShare share = {});
  /// To go on where `save` was called.
  RunFiles(OutputFolder& folder, const scene_file::SceneFile& file, std::istream& resume);

  void start(const scene_file::StepView& view);
  void step(const scene_file::StepView& view);
  void end_stage(const scene_file::StepView& view);
  void finish();
  long steps() const { return steps_; }  ///< that have ended
  /// Brings everything so far to the files and writes what a run needs to go on with them.
  void save(std::ostream& out);

 private:
  void remove_later_frames();
  void write_history_line(const scene_file::StepView& view);
  void write_ties(const scene_file::StepView& view);
  void write_blocks(const scene_file::StepView& view);
  void write_contacts(const scene_file::StepView& view);
  void write_joints(const scene_file::StepView& view, std::span<const solver::Contact> contacts);
  void write_vtk(const scene_file::StepView& view);
  void write_frame(const scene_file::StepView& view);
  void write_pieces(const scene_file::StepView& view);
  double frame_time(double time) const;
  bool is_due(const scene_file::StepView& view) const;

  OutputFolder& folder_;
  const scene_file::SceneFile& file_;
  const FileShare share_{};
  long steps_ = 0;
  long frame_step_ = 0;              ///< steps when the last frame was written
  std::vector<double> times_;        ///< of the ParaView files, s
  std::vector<JointedPair> joined_;  ///< closed after the first step or at the end of a stage
  std::optional<CsvFile> history_, blocks_, contacts_, joints_, ties_;  ///< of the first process
};

/// The keys of summary.json, as tools/README.md documents them.
nlohmann::ordered_json summary(const scene_file::SceneFile& file, const std::string& path,
                               const scene_file::RunResult& result);

}  // namespace quoin::commands
