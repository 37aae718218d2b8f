#pragma once
/// One pair in exact numbers, and what is wrong with an answer to it.
///
/// Lengths that are allowed, m, with D the larger diameter and P the error that the library
/// promises (0: none):
///   gap    1e-12 of itself + 16 eps D + 4 eps of the largest coordinate of a turned solid + P D
///   place  the same + 4 eps of the largest coordinate in the world
/// (sums of the roundings of an answer in double precision: tests/support/trial.hpp).

#include <optional>
#include <string>
#include <vector>

#include "plugin.hpp"
#include "support/exact_arbiter.hpp"

namespace quoin::referee {

/// Something that does not hold: a kind, which is counted, and the numbers.
struct Fault {
  std::string kind, text;
};

struct Judgement {
  bool asked = true;  ///< false: the library does not offer this pair
  bool answered = false;
  std::vector<Fault> faults;
  double gap_error = 0.0;  ///< share of the larger diameter; of what was answered
};

class Judge {
 public:
  explicit Judge(const tests::SolidPair& pair);

  /// Whether the library offers an answer to this pair at all: its kind of gap, of solids, of
  /// placements.
  bool offered(const LibraryInfo& library) const;
  Judgement judge(const LibraryInfo& library, const Answer& answer) const;
  const tests::ExactGap& exact() const { return gap_; }

 private:
  void check_gap(const LibraryInfo& library, const Answer& answer, Judgement& result) const;
  void check_normal(const LibraryInfo& library, const Answer& answer, Judgement& result) const;
  void check_witnesses(const LibraryInfo& library, const Answer& answer, Judgement& result) const;
  void check_points(const LibraryInfo& library, const Answer& answer, Judgement& result) const;
  bool refusal_is_right(int side) const;
  double allowed_gap(const LibraryInfo& library) const;
  double allowed_place(const LibraryInfo& library) const;

  const tests::SolidPair& pair_;
  tests::ExactPair numbers_;
  tests::ExactGap gap_;
  double larger_ = 0.0, smaller_ = 0.0, turned_coordinate_ = 0.0, world_coordinate_ = 0.0;
  double tolerance_ = 0.0;  ///< contact length, m
  bool boxes_ = false, rotations_ = false;
};

}  // namespace quoin::referee
