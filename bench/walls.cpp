#include "walls.hpp"

#include <cmath>

#include "tests/support/random.hpp"

namespace quoin::bench {

Wall::Wall(int count, Motion motion, double gap, double amplitude)
    : motion_(motion), amplitude_(amplitude), bricks_(running_bond_wall(count)) {
  tests::Random random(7000 + static_cast<std::uint64_t>(count));
  for (Brick& brick : bricks_) {
    brick.half_size.array() -= 0.5 * gap;
    direction_.push_back(random.direction());
  }
  shape_ = box_shape(bricks_.front().half_size);
}

Vector3 Wall::place(std::size_t i, int step) const {
  const double way = motion_ == Motion::Drift
                         ? amplitude_ * step
                         : amplitude_ * std::sin(0.7 * step + static_cast<double>(i % 97));
  return bricks_[i].place + way * direction_[i];
}

geometry::Box Wall::box(std::size_t i, int step) const {
  const Vector3 centre = place(i, step);
  return {centre - bricks_[i].half_size, centre + bricks_[i].half_size};
}

std::shared_ptr<const geometry::Shape> Wall::shape() const {
  return std::make_shared<const geometry::Shape>(shape_.topology, shape_.vertices);
}

std::vector<geometry::Shape> Wall::solids() const {
  std::vector<geometry::Shape> solids;
  solids.reserve(size());
  for (std::size_t i = 0; i < size(); ++i) {
    const Points vertices = shape_.vertices.colwise() + place(i, 0);
    solids.emplace_back(shape_.topology, vertices);
  }
  return solids;
}

}  // namespace quoin::bench
