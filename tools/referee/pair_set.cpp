#include "pair_set.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "shrink.hpp"
#include "support/exact_patch.hpp"

namespace quoin::referee {
namespace {

/// As nearest_features takes it where none is given: the larger of 1e-9 of the smaller diameter
/// (twice the farthest vertex from the middle of the box) and 16 eps of the largest coordinate.
double contact_length(const tests::Solid& solid) {
  const geometry::Points& points = solid.placed.points;
  const geometry::Vector3 middle =
      0.5 * (points.rowwise().minCoeff() + points.rowwise().maxCoeff());
  return 1e-9 * 2 * (points.colwise() - middle).colwise().norm().maxCoeff();
}

}  // namespace

std::string pair_with_answer(const tests::SolidPair& pair, const std::string& id) {
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  const tests::ExactPair exact(pair.a.placed, pair.b.placed);
  const tests::ExactGap gap = exact.gap();
  const double coordinate = std::max(largest_coordinate(pair.a), largest_coordinate(pair.b));
  const double tolerance =
      std::max(std::min(contact_length(pair.a), contact_length(pair.b)), 16 * kEps * coordinate);
  const double size = std::max(diameter(pair.a), diameter(pair.b));
  const tests::ExactPatch patch =
      tests::exact_patch(exact, gap.normal, {tolerance, 0x1p-48 * size, 0});
  auto line = nlohmann::ordered_json::parse(pair_as_json(pair, id));
  line["source"] = "quoin";
  line["what"] = pair.family;
  line["exact"] = {{"gap", static_cast<double>(gap.gap)},
                   {"normal", {gap.normal.x(), gap.normal.y(), gap.normal.z()}},
                   {"tol", tolerance}};
  if (patch.clear) {
    line["exact"]["type"] = name(patch.type);
    line["exact"]["area"] = static_cast<double>(patch.area);
  }
  return line.dump();
}

}  // namespace quoin::referee
