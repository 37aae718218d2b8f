#include "walls.hpp"

#include <cmath>

#include "referee/pairs/random.hpp"

namespace quoin::bench {
namespace {

/// Every second row is shifted by half a brick; the leaves are alike.
std::vector<Vector3> running_bond(const WallOptions& options) {
  const int in_leaf = (options.count + options.leaves - 1) / options.leaves;
  const int rows = std::max(1, static_cast<int>(std::sqrt(in_leaf / 1.6)));
  const int columns = (in_leaf + rows - 1) / rows;
  std::vector<Vector3> places;
  for (int row = 0; row < rows; ++row) {
    for (int k = 0; k < columns * options.leaves; ++k) {
      if (static_cast<int>(places.size()) == options.count) return places;
      const double shift = row % 2 == 0 ? 0.0 : 0.5;
      const Vector3 steps(k / options.leaves + shift, k % options.leaves, row);
      places.push_back(steps.cwiseProduct(options.brick));
    }
  }
  return places;
}

}  // namespace

Wall::Wall(const WallOptions& options)
    : options_(options),
      places_(running_bond(options)),
      shape_(box_shape(0.5 * (options.brick.array() - options.joint))) {
  referee::Random random(7000 + static_cast<std::uint64_t>(options.count));
  for (std::size_t i = 0; i < size(); ++i) directions_.push_back(random.direction());
}

double Wall::way(std::size_t i, int step) const {
  return options_.motion == Motion::Drift ? step
                                          : std::sin(0.7 * step + static_cast<double>(i % 97));
}

geometry::Placement Wall::placement(std::size_t i, int step) const {
  const double way = this->way(i, step);
  geometry::Placement placement;
  placement.translation =
      places_[i] + step * options_.carry * Vector3::UnitX() + options_.shift * way * directions_[i];
  if (options_.turn > 0.0) {
    const Vector3 axis = directions_[(i + 1) % size()];
    placement.linear = referee::rotation_about(axis, options_.turn * way);
  }
  if (options_.heading != 0.0) {
    const Matrix3 heading = referee::rotation_about(Vector3::UnitZ(), options_.heading);
    placement.translation = heading * placement.translation;
    placement.linear = heading * placement.linear;
  }
  return placement;
}

geometry::Box Wall::box(std::size_t i, int step) const {
  const Vector3 centre = placement(i, step).translation;
  return {centre - shape_.half_size, centre + shape_.half_size};
}

}  // namespace quoin::bench
