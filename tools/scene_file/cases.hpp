#pragma once
/// Case files: a scene with a block `cases` that says which of its variants are run and what each
/// must come to. The format stands in tools/README.md.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scene_file/run_scene.hpp"

namespace quoin::scene_file {

/// A result beside its exact value and the error that is allowed.
struct CaseRow {
  std::string case_name{};  ///< "V01"
  std::string quantity{};   ///< what, of which run, unit; "rel." when the error is relative
  double exact = 0.0, result = 0.0, error = 0.0, allowed = 0.0;
  bool ok = false;       ///< error <= allowed; NaN is not ok
  double seconds = 0.0;  ///< since its run began
};

/// One variant of the scene.
struct CaseRun {
  std::size_t entry = 0;                                     ///< of `runs`
  std::string name{};                                        ///< of the entry, its numbers put in
  std::vector<std::pair<std::string, double>> parameters{};  ///< those that vary
  std::vector<std::string> changes{};                        ///< as for read_scene()
  std::vector<std::string> flags{};                          ///< that it is known to raise
  std::map<std::string, std::string> words{};                ///< of alternatives, for labels
};

struct CaseOutcome {
  std::vector<CaseRow> rows{};
  std::vector<std::string> flags{};  ///< that were raised, in the order of FlagKind
  long steps = 0, solves = 0, unconverged = 0;
  bool may_fail = false;  ///< the source's own methods may leave a step unconverged
  double seconds = 0.0;
};

/// Error of a case against what is refined: the order, and where it stops.
struct CaseSeries {
  std::string case_name{}, quantity{};
  std::string refined{};                   ///< "time_step", "penalty"
  std::vector<double> values{}, errors{};  ///< s or N/m, from coarse to fine
  double expected_order = 0.0;             ///< 0: right to rounding from the coarsest value on
  double floor = 0.0;                      ///< errors below it are of rounding and tolerance
  std::string failure{};                   ///< a run that broke off; errors end before it
  double seconds = 0.0;

  /// Of the error in the refined step (1 / penalty): least squares over the errors above the floor;
  /// NaN where fewer than two are.
  double order() const;
  /// First value whose error is below the floor; NaN when none is.
  double stops_at() const;
  /// Orders at least expected_order - 0.3 down to the floor, and nothing above it afterwards.
  bool ok() const;
};

class CaseFile {
 public:
  /// Throws SceneError and FileError.
  explicit CaseFile(const std::string& path);

  const std::string& path() const { return path_; }
  const std::string& name() const { return name_; }  ///< the file's, up to its first "_"
  const std::string& title() const { return title_; }
  bool has_series() const;

  /// The runs in their order; `quick`: without those that take long. Throws SceneError.
  std::vector<CaseRun> runs(bool quick = false) const;
  /// A run that breaks off becomes a row that is not ok. Throws SceneError when the file is wrong.
  CaseOutcome run(const CaseRun& run) const;
  std::vector<CaseSeries> series() const;

 private:
  struct Document;
  std::string path_, name_{}, title_{};
  std::shared_ptr<const Document> document_;
};

/// The schema that blocks `cases` are checked against.
std::string_view cases_schema();

/// Does it; a SceneError names the file, too.
void in_file(const std::string& path, const std::function<void()>& action);

/// The case files of a folder, by name. Throws SceneError and FileError.
std::vector<CaseFile> read_cases(const std::string& folder);

}  // namespace quoin::scene_file
