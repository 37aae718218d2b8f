#include "scene_file/not_finite.hpp"

#include <sstream>

namespace quoin::scene_file {
namespace {

class Search {
 public:
  Search(const solver::Scene& scene, double time) : scene_(scene), time_(time) {}

  std::string found() const {
    if (bad(scene_.gravity)) return line("gravity");
    for (const auto& load : scene_.point_loads)
      if (bad(load.force)) return line("a point load on", load.block);
    for (const auto& load : scene_.face_loads)
      if (bad(load.traction)) return line("a face load on", load.block);
    for (const auto& load : scene_.body_loads)
      if (bad(load.force)) return line("a body load on", load.block);
    for (const auto& point : scene_.fixed_points)
      if (bad(point.displacement)) return line("displacement of a fixed point of", point.block);
    for (const auto& load : scene_.pressure_loads) {
      for (const solver::Vector3& corner : load.corners)
        if (!std::isfinite(load.field->value(corner, time_)))
          return line("the water pressure on", load.block);
    }
    for (const auto& quiet : scene_.quiet_faces)
      if (bad(quiet.velocity)) return line("the ground's velocity at", quiet.block);
    for (std::size_t b = 0; b < scene_.blocks.size(); ++b) {
      const solver::Block& block = scene_.blocks[b];
      if (block.kind != solver::BlockKind::Prescribed ||
          !(bad(block.motion.value) || bad(block.motion.rotation)))
        continue;
      return line("motion of", static_cast<int>(b));
    }
    return "";
  }

 private:
  bool bad(const solver::VectorOfTime& value) const { return !value.at(time_).allFinite(); }

  std::string line(const char* what, int block = -1) const {
    std::ostringstream text;
    text << "; " << what;
    if (block >= 0) {
      const std::string& name = scene_.blocks[static_cast<std::size_t>(block)].name;
      text << ' ' << (name.empty() ? std::to_string(block) : '"' + name + '"');
    }
    text << " at " << time_ << " s is not finite";
    return text.str();
  }

  const solver::Scene& scene_;
  double time_;
};

}  // namespace

// Steps ask at their middle and end, motions just before and behind it, too.
std::string not_finite(const solver::Scene& scene, double time,
                       const solver::StepOptions& options) {
  for (const double share : {0.0, 1.0 / 1024, 0.5, 1.0}) {
    const std::string found = Search(scene, time + share * options.time_step).found();
    if (!found.empty()) return found;
  }
  return "";
}

}  // namespace quoin::scene_file
