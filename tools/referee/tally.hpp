#pragma once
/// What was found, by library and family, and the report of it.

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "judge.hpp"

namespace quoin::referee {

/// Of one library on one family.
struct Tally {
  long asked = 0, answered = 0, faulty = 0;  ///< questions
  std::map<std::string, long> kinds;         ///< questions that show a kind of fault
  std::vector<double> gap_errors;  ///< of what was answered, shares of the larger diameter
  std::vector<double> seconds;     ///< of questions that were answered
};

/// A pair that showed a fault, made smaller.
struct Failure {
  std::string library, family, kind, text;
  std::string json, cpp, c;  ///< the pair as a line of JSON, C++ and C
};

struct Report {
  std::uint64_t seed = 0;
  long questions = 0;
  long left_out = 0;  ///< questions not judged: a flat solid has no depth
  double seconds = 0.0;
  std::vector<LibraryInfo> libraries;
  std::map<std::string, std::map<std::string, Tally>> tallies;  ///< by library and family
  std::vector<Failure> failures;
};

void count(const Judgement& judgement, Tally& tally);

/// One of the numbers in the middle; 0 of none.
double median(std::vector<double> numbers);

/// All of it, for programs.
nlohmann::ordered_json to_json(const Report& report);
/// Verdicts by library, for people.
std::string to_text(const Report& report);

}  // namespace quoin::referee
