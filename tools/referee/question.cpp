#include "question.hpp"

#include <optional>
#include <quoin/geometry/nearest_features.hpp>

namespace quoin::referee {
namespace {

using geometry::Hull;
using geometry::Matrix3;
using geometry::Placement;
using geometry::Points;

std::optional<Hull> hull_of(const Points& points) {
  try {
    return geometry::make_hull(points);
  } catch (const geometry::InputError&) {
    return std::nullopt;
  }
}

}  // namespace

Question::Question(SolidPair asked) : pair(std::move(asked)) {
  const std::optional<Hull> hull_a = hull_of(pair.a.placed.points);
  const std::optional<Hull> hull_b = hull_of(pair.b.placed.points);
  solids = std::make_shared<DescribedPair>(DescribedPair{
      described(pair.a.placed.points, hull_a ? &*hull_a : nullptr),
      described(pair.b.placed.points, hull_b ? &*hull_b : nullptr),
      hull_a && hull_b ? default_tolerance(hull_a->polyhedron, hull_b->polyhedron) : 0.0});
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
