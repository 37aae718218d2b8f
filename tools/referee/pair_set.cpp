#include "pair_set.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "question.hpp"
#include "referee/pairs/exact_patch.hpp"
#include "referee/pairs/pair_text.hpp"

namespace quoin::referee {

namespace {

/// A gap that could be taken for rounding, m; as a share of the larger diameter.
constexpr double kNearlyNothing = 1e-9;
constexpr std::size_t kLongestFraction = 400;  // characters

}  // namespace

std::string pair_with_answer(const SolidPair& pair, const std::string& id) {
  const Question question(pair);
  if (question.solids->contact_length == 0) throw std::invalid_argument("quoin refuses a solid");
  const ExactPair exact(pair.a.placed, pair.b.placed);
  const ExactGap gap = exact.gap();
  const double size = std::max(diameter(pair.a), diameter(pair.b));
  const ExactPatch patch =
      exact_patch(exact, gap.normal, {question.solids->contact_length, 0x1p-48 * size, 0});
  auto line = nlohmann::ordered_json::parse(pair_as_json(pair, id));
  line["source"] = "quoin";
  line["what"] = pair.family;
  line["exact"] = {{"gap", static_cast<double>(gap.gap)},
                   {"normal", {gap.normal.x(), gap.normal.y(), gap.normal.z()}},
                   {"tol", question.solids->contact_length}};
  if (std::abs(gap.gap) <= kNearlyNothing * size) {
    const std::string squared = exact.squared_gap();
    if (squared.size() <= kLongestFraction) line["exact"]["gap_squared"] = squared;
  }
  if (patch.clear) {
    line["exact"]["type"] = name(patch.type);
    line["exact"]["area"] = static_cast<double>(patch.area);
  }
  return line.dump();
}

}  // namespace quoin::referee
