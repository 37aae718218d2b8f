#include <algorithm>
#include <cmath>
#include <quoin/geometry/build.hpp>
#include <quoin/solver/scene.hpp>

namespace quoin::solver {

VectorOfTime interpolate(std::vector<double> times, std::vector<Vector3> values) {
  if (times.empty() || times.size() != values.size()) {
    throw InputError("table in time: " + std::to_string(times.size()) + " times for " +
                     std::to_string(values.size()) + " values");
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || !values[i].allFinite())
      throw InputError("table in time: entry " + std::to_string(i) + " is not finite");
    if (i > 0 && !(times[i] >= times[i - 1] && (i < 2 || times[i] > times[i - 2]))) {
      throw InputError("table in time: time " + std::to_string(i) + " (" +
                       std::to_string(times[i]) +
                       " s) is not after the one before it, nor a jump of two entries");
    }
  }
  const auto knots = std::make_shared<const std::vector<double>>(std::move(times));
  return {[knots, values = std::move(values)](double time) -> Vector3 {
            const auto next = std::ranges::upper_bound(*knots, time);
            if (next == knots->begin()) return values.front();
            if (next == knots->end()) return values.back();
            const auto i = static_cast<std::size_t>(next - knots->begin());
            const double share = (time - next[-1]) / (next[0] - next[-1]);
            return values[i - 1] + share * (values[i] - values[i - 1]);
          },
          knots};
}

namespace {

int append(Scene& scene, geometry::Shape shape, const Material& material, BlockKind kind) {
  scene.blocks.push_back({.shape = std::make_shared<const geometry::Shape>(std::move(shape)),
                          .material = material,
                          .kind = kind});
  return static_cast<int>(scene.blocks.size()) - 1;
}

}  // namespace

Block compound(std::vector<geometry::Shape> parts) {
  Block block;
  block.parts = std::make_shared<const std::vector<geometry::Shape>>(std::move(parts));
  block.shape = std::make_shared<const geometry::Shape>(geometry::join(*block.parts));
  return block;
}

int Scene::add_block(geometry::Shape shape, const Material& material) {
  return append(*this, std::move(shape), material, BlockKind::Deformable);
}

int Scene::add_rigid(geometry::Shape shape, const Material& material) {
  return append(*this, std::move(shape), material, BlockKind::Rigid);
}

int Scene::add_fixed(geometry::Shape shape, const Material& material) {
  return append(*this, std::move(shape), material, BlockKind::Fixed);
}

}  // namespace quoin::solver
