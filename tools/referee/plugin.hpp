#pragma once
/// A library of a plug-in in a process of its own: asked through pipes, with a time limit, so that
/// it may crash, hang or throw.

#include <chrono>
#include <string>
#include <vector>

#include "child_process.hpp"
#include "question.hpp"

namespace quoin::referee {

/// A library of a plug-in, as it describes itself.
struct LibraryInfo {
  std::string file;  ///< of the plug-in
  int index = 0;     ///< in the plug-in
  std::string name, version;
  int offers = 0;               ///< quoin_referee_offers
  double promised_error = 0.0;  ///< share of the larger diameter
  bool has(int offer) const { return (offers & offer) != 0; }
};

/// What a library said of a pair, or what happened instead.
enum class Outcome {
  Answered,
  NoAnswer,  ///< it does not offer this
  RefusedA,
  RefusedB,
  Failed,  ///< it says so itself, or threw
  Crashed,
  TimedOut
};

struct ListedPoint {
  geometry::Vector3 point_a = geometry::Vector3::Zero(), point_b = geometry::Vector3::Zero();
  double gap = 0.0, area = 0.0;
};

struct Answer {
  Outcome outcome = Outcome::NoAnswer;
  double gap = 0.0;  ///< m
  geometry::Vector3 normal = geometry::Vector3::Zero();
  geometry::Vector3 point_a = geometry::Vector3::Zero(), point_b = geometry::Vector3::Zero();
  Outcome points_outcome = Outcome::NoAnswer;
  std::vector<ListedPoint> points{};
};

/// The libraries of a plug-in file. Throws std::runtime_error with one line where the file is no
/// plug-in of this interface.
std::vector<LibraryInfo> libraries_of(const std::string& file);

class Plugin {
 public:
  Plugin(LibraryInfo info, std::chrono::milliseconds limit);

  const LibraryInfo& info() const { return info_; }
  /// Never throws for what the library does.
  Answer ask(const Question& question);

 private:
  LibraryInfo info_;
  ChildProcess process_;
  std::shared_ptr<const DescribedPair> solids_;  ///< of the question before
};

}  // namespace quoin::referee
