#include "marks.hpp"

#include <algorithm>
#include <quoin/geometry/mass_properties.hpp>
#include <set>

namespace quoin::commands {
namespace {

using json = nlohmann::ordered_json;
using scene_file::SceneFile;
using solver::Vector3;
using solver::VectorOfTime;

json vector_json(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

/// Simulated time of the dynamic stages that say how long they are, s.
double seconds_of(const SceneFile& file) {
  double seconds = 0.0;
  for (const scene_file::Stage& stage : file.stages) {
    if (stage.analysis != solver::Analysis::Dynamic) continue;
    const double steps = static_cast<double>(stage.steps.value_or(0)) * stage.time_step;
    seconds = std::max({seconds, seconds + stage.duration, seconds + steps, stage.end_time});
  }
  return seconds;
}

/// At its knots, and at 65 times of the run.
Vector3 largest_value(const VectorOfTime& value, double seconds) {
  constexpr int kTimes = 64;
  Vector3 largest = value.at(0.0);
  const auto look = [&](double time) {
    if (value.at(time).norm() > largest.norm()) largest = value.at(time);
  };
  for (int i = 1; i <= kTimes && !value.is_constant(); ++i) look(seconds * i / kTimes);
  std::ranges::for_each(value.knots(), look);
  return largest;
}

Vector3 middle_of_face(const geometry::Body& body, int face) {
  Vector3 sum = Vector3::Zero();
  const auto corners = body.shape().topology().face(face);
  for (const int corner : corners) sum += body.vertex(corner);
  return sum / static_cast<double>(corners.size());
}

struct Marks {
  double seconds = 0.0;
  json found = json::array();
  std::set<json> known{};

  void add(const solver::Scene& scene, const char* kind, int block, const Vector3& at,
           const VectorOfTime* value = nullptr, const char* unit = "") {
    json mark = {{"kind", kind},
                 {"block", scene.blocks[static_cast<std::size_t>(block)].name},
                 {"at", vector_json(at)}};
    if (value != nullptr) {
      const Vector3 largest = largest_value(*value, seconds);
      if (largest.isZero(0.0)) return;
      mark["vector"] = vector_json(largest);
      mark["unit"] = unit;
    }
    if (known.insert(mark).second) found.push_back(std::move(mark));
  }

  void add_all(const solver::Scene& scene) {
    const auto body = [&](int b) { return scene.blocks[static_cast<std::size_t>(b)].body(); };
    const auto centroid = [&](int b) { return geometry::mass_properties(body(b)).centroid; };
    for (const solver::PointLoad& load : scene.point_loads) {
      add(scene, "load", load.block, load.point, &load.force, "N");
    }
    for (const solver::FaceLoad& load : scene.face_loads) {
      add(scene, "traction", load.block, middle_of_face(body(load.block), load.face),
          &load.traction, "Pa");
    }
    for (const solver::BodyLoad& load : scene.body_loads) {
      add(scene, "body load", load.block, centroid(load.block), &load.force, "N/m3");
    }
    for (const solver::PressureLoad& load : scene.pressure_loads) {
      if (load.factor < 0.0) continue;
      const auto& corners = load.corners;
      Vector3 middle = Vector3::Zero();
      for (const Vector3& corner : corners) middle += corner / static_cast<double>(corners.size());
      const Vector3 inwards =
          -(corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
      const VectorOfTime pressure([&](double time) -> Vector3 {
        return load.factor * load.field->value(middle, time) * inwards;
      });
      add(scene, "water", load.block, middle, &pressure, "Pa");
    }
    for (const solver::FixedPoint& point : scene.fixed_points) {
      add(scene, "fixed point", point.block, point.point);
    }
    constexpr const char* kUnits[] = {"m", "m/s", "m/s2"};
    for (int b = 0; b < std::ssize(scene.blocks); ++b) {
      const solver::Block& block = scene.blocks[static_cast<std::size_t>(b)];
      if (block.kind != solver::BlockKind::Prescribed) continue;
      add(scene, "motion", b, centroid(b), &block.motion.value,
          kUnits[static_cast<std::size_t>(block.motion.kind)]);
    }
  }
};

}  // namespace

json marks_json(const SceneFile& file) {
  Marks marks{seconds_of(file)};
  marks.add_all(file.scene);
  for (const scene_file::Stage& stage : file.stages) {
    if (stage.scene) marks.add_all(*stage.scene);
  }
  for (const scene_file::Monitor& monitor : file.monitors) {
    if (monitor.point) marks.add(file.scene, "monitor", monitor.blocks.at(0), *monitor.point);
  }
  return marks.found;
}

}  // namespace quoin::commands
