#include "tally.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

namespace quoin::referee {
namespace {

using Json = nlohmann::ordered_json;

Tally sum(const std::map<std::string, Tally>& families) {
  Tally all;
  for (const auto& [name, tally] : families) {
    all.asked += tally.asked;
    all.answered += tally.answered;
    all.faulty += tally.faulty;
    for (const auto& [kind, number] : tally.kinds) all.kinds[kind] += number;
    all.gap_errors.insert(all.gap_errors.end(), tally.gap_errors.begin(), tally.gap_errors.end());
    all.seconds.insert(all.seconds.end(), tally.seconds.begin(), tally.seconds.end());
  }
  return all;
}

double largest(const std::vector<double>& numbers) {
  return numbers.empty() ? 0.0 : *std::max_element(numbers.begin(), numbers.end());
}

Json to_json(const Tally& tally) {
  Json json{{"asked", tally.asked},
            {"answered", tally.answered},
            {"faulty", tally.faulty},
            {"kinds", tally.kinds},
            {"gaps", tally.gap_errors.size()},
            {"gap_error_median", median(tally.gap_errors)},
            {"gap_error_largest", largest(tally.gap_errors)},
            {"timed", tally.seconds.size()},
            {"seconds_median", median(tally.seconds)}};
  return json;
}

template <class... Values>
std::string line(const char* format, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string row(const std::string& name, const Tally& tally) {
  return line("%-32s %9ld %9ld %9ld %12.2g %12.2g %10.3g\n", name.c_str(), tally.asked,
              tally.answered, tally.faulty, median(tally.gap_errors), largest(tally.gap_errors),
              1e6 * median(tally.seconds));
}

const char* const kHead =
    "                                     asked  answered    faulty  error, half "
    "error, most  us, half\n";

}  // namespace

void count(const Judgement& judgement, Tally& tally) {
  ++tally.asked;
  tally.answered += judgement.answered ? 1 : 0;
  tally.faulty += judgement.faults.list.empty() ? 0 : 1;
  std::set<std::string> kinds;
  for (const Fault& fault : judgement.faults.list) kinds.insert(fault.kind);
  for (const std::string& kind : kinds) ++tally.kinds[kind];
  if (judgement.gap_given) tally.gap_errors.push_back(judgement.gap_error);
}

double median(std::vector<double> numbers) {
  if (numbers.empty()) return 0.0;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

Json to_json(const Report& report) {
  Json json{{"seed", report.seed},
            {"questions", report.questions},
            {"left_out", report.left_out},
            {"seconds", report.seconds}};
  for (const LibraryInfo& library : report.libraries) {
    Json families = Json::object();
    const auto found = report.tallies.find(library.name);
    if (found != report.tallies.end()) {
      for (const auto& [family, tally] : found->second) families[family] = to_json(tally);
      families["all"] = to_json(sum(found->second));
    }
    json["libraries"].push_back({{"name", library.name},
                                 {"version", library.version},
                                 {"offers", library.offers},
                                 {"promised_error", library.promised_error},
                                 {"families", families}});
  }
  json["failures"] = Json::array();
  for (const Failure& failure : report.failures) {
    json["failures"].push_back({{"library", failure.library},
                                {"family", failure.family},
                                {"kind", failure.kind},
                                {"text", failure.text},
                                {"pair", Json::parse(failure.json)}});
  }
  return json;
}

std::string to_text(const Report& report) {
  std::string text = kHead;
  for (const LibraryInfo& library : report.libraries) {
    const auto found = report.tallies.find(library.name);
    if (found == report.tallies.end()) continue;
    const Tally all = sum(found->second);
    text += row(library.name, all);
    for (const auto& [kind, number] : all.kinds)
      text += line("    %-46s %9ld\n", kind.c_str(), number);
  }
  return text;
}

}  // namespace quoin::referee
