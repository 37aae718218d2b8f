#pragma once
/// One pair in exact numbers, and what is wrong with an answer to it.

#include "plugin.hpp"
#include "referee/pairs/faults.hpp"
#include "referee/pairs/pair_sizes.hpp"

namespace quoin::referee {

struct Judgement {
  bool asked = true;      ///< false: the library does not offer this pair
  bool answered = false;  ///< a gap or contact points
  bool gap_given = false;
  Faults faults;
  double gap_error = 0.0;  ///< share of the larger diameter; of what was answered
};

class Judge {
 public:
  /// Keeps a reference. Throws std::invalid_argument for a solid that lies in one plane.
  explicit Judge(const Question& question);

  /// Whether the library offers an answer to this pair at all: its kind of gap, of solids, of
  /// placements.
  bool offered(const LibraryInfo& library) const;
  Judgement judge(const LibraryInfo& library, const Answer& answer) const;
  const ExactGap& exact() const { return gap_; }

 private:
  bool solids_offered(const LibraryInfo& library) const;
  bool gap_offered(const LibraryInfo& library) const;
  bool points_offered(const LibraryInfo& library) const;
  void check_gap(const LibraryInfo& library, const Answer& answer, Judgement& result) const;
  void check_witnesses(const LibraryInfo& library, const Answer& answer, Judgement& result) const;
  void check_points(const LibraryInfo& library, const Answer& answer, Judgement& result) const;
  const Solid& refused(const Answer& answer) const;
  double allowed_gap(const LibraryInfo& library) const {
    return sizes_.allowed_gap(gap_.gap, library.promised_error);
  }
  double allowed_place(const LibraryInfo& library) const {
    return sizes_.allowed_place(gap_.gap, library.promised_error);
  }

  const Question& question_;
  ExactPair numbers_;
  ExactGap gap_;
  PairSizes sizes_;
  bool boxes_, rotations_;
};

}  // namespace quoin::referee
