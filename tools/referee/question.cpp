#include "question.hpp"

#include <optional>
#include <quoin/geometry/nearest_features.hpp>

namespace quoin::referee {
namespace {

using geometry::Matrix3;
using geometry::Placement;
using geometry::Shape;

double contact_length(const std::optional<Shape>& a, const std::optional<Shape>& b) {
  return a && b ? default_tolerance(*a, *b) : 0.0;
}

}  // namespace

Question::Question(SolidPair asked) : pair(std::move(asked)) {
  std::optional<Shape> a, b;
  const auto described_pair = std::make_shared<DescribedPair>();
  described_pair->a = described(pair.a, a);
  described_pair->b = described(pair.b, b);
  described_pair->contact_length = contact_length(a, b);
  solids = described_pair;
}

SteadyMotion::SteadyMotion(const Solid& start, double amount, Random& random)
    : start_(start.placed.placement),
      middle_(start_.translation + start_.linear * start.placed.points.rowwise().mean()),
      axis_(random.direction()),
      velocity_(amount * diameter(start) * random.uniform() * random.direction()),
      turn_(amount * random.uniform()) {}

Placement SteadyMotion::at(int step) const {
  const Matrix3 turn = rotation_about(axis_, step * turn_);
  Placement place;
  place.linear = turn * start_.linear;
  place.translation = middle_ + turn * (start_.translation - middle_) + step * velocity_;
  return place;
}

}  // namespace quoin::referee
