#include "marks.hpp"

#include <algorithm>
#include <numeric>
#include <quoin/geometry/mass_properties.hpp>
#include <set>
#include <span>

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

constexpr int kTimes = 64;  // of the run, at which the largest value of a load is looked for

/// At its knots, and at kTimes of the run.
Vector3 largest_value(const VectorOfTime& value, double seconds) {
  Vector3 largest = value.at(0.0);
  const auto look = [&](double time) {
    if (value.at(time).norm() > largest.norm()) largest = value.at(time);
  };
  for (int i = 1; i <= kTimes && !value.is_constant(); ++i) look(seconds * i / kTimes);
  std::ranges::for_each(value.knots(), look);
  return largest;
}

Vector3 middle_of(std::span<const Vector3> corners) {
  const Vector3 sum = std::accumulate(corners.begin(), corners.end(), Vector3(Vector3::Zero()));
  return sum / static_cast<double>(corners.size());
}

/// Outwards, m2.
Vector3 area_of(const solver::PressureLoad& load) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 1; i + 1 < load.corners.size(); ++i)
    sum += (load.corners[i] - load.corners[0]).cross(load.corners[i + 1] - load.corners[0]);
  return 0.5 * sum;
}

bool is_wet(const solver::PressureLoad& load) {
  return load.field->value(middle_of(load.corners), 0.0) > 0.0;
}

/// Whether loads that take off what joints bear leave nothing of a face.
bool is_taken_off(std::span<const solver::PressureLoad> all, const solver::PressureLoad& load) {
  const Vector3 area = area_of(load);
  double left = area.norm();
  for (const solver::PressureLoad& other : all) {
    if (other.factor > 0.0 || other.block != load.block || other.field != load.field) continue;
    if (is_wet(other) != is_wet(load)) continue;
    const Vector3 away = other.corners[0] - load.corners[0], covered = area_of(other);
    const bool on_it = std::abs(away.dot(area.normalized())) < 1e-6 * std::sqrt(area.norm());
    if (on_it && covered.dot(area) > 0.999 * covered.norm() * area.norm()) left -= covered.norm();
  }
  return left < 1e-6 * area.norm();
}

/// Corners, and places between them, for pressure that does not grow evenly along a side.
std::vector<Vector3> rim_of(const solver::PressureLoad& load) {
  constexpr int kPieces = 8;
  std::vector<Vector3> rim;
  for (std::size_t i = 0; i < load.corners.size(); ++i) {
    const Vector3 &from = load.corners[i], &to = load.corners[(i + 1) % load.corners.size()];
    for (int k = 0; k < kPieces; ++k) rim.push_back(from + k * (to - from) / kPieces);
  }
  return rim;
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

  /// Faces, or what joints leave of them, by the pressure around them when that of their middle is
  /// the largest of the run: x, y, z (m), Pa.
  void add_water(const solver::Scene& scene) {
    for (const solver::PressureLoad& load : scene.pressure_loads) {
      if (load.factor < 0.0 || is_taken_off(scene.pressure_loads, load)) continue;
      const Vector3 middle = middle_of(load.corners);
      double time = 0.0;
      for (int i = 1; i <= kTimes && !load.field->steady; ++i) {
        const double other = seconds * i / kTimes;
        if (load.field->value(middle, other) > load.field->value(middle, time)) time = other;
      }
      const Vector3 inwards = -area_of(load).normalized();
      const VectorOfTime pressure(Vector3(load.field->value(middle, time) * inwards));
      const std::size_t before = found.size();
      add(scene, "water", load.block, middle, &pressure, "Pa");
      for (const Vector3& place : found.size() > before ? rim_of(load) : std::vector<Vector3>{}) {
        found.back()["rim"].push_back(
            {place.x(), place.y(), place.z(), load.field->value(place, time)});
      }
    }
  }

  void add_all(const solver::Scene& scene) {
    const auto body = [&](int b) { return scene.blocks[static_cast<std::size_t>(b)].body(); };
    const auto centroid = [&](int b) { return geometry::mass_properties(body(b)).centroid; };
    for (const solver::PointLoad& load : scene.point_loads)
      add(scene, "load", load.block, load.point, &load.force, "N");
    for (const solver::FaceLoad& load : scene.face_loads) {
      add(scene, "traction", load.block, middle_of_face(body(load.block), load.face),
          &load.traction, "Pa");
    }
    for (const solver::BodyLoad& load : scene.body_loads)
      add(scene, "body load", load.block, centroid(load.block), &load.force, "N/m3");
    add_water(scene);
    for (const solver::FixedPoint& point : scene.fixed_points)
      add(scene, "fixed point", point.block, point.point);
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
  for (const scene_file::Stage& stage : file.stages)
    if (stage.scene) marks.add_all(*stage.scene);
  for (const scene_file::Monitor& monitor : file.monitors)
    if (monitor.point) marks.add(file.scene, "monitor", monitor.blocks.at(0), *monitor.point);
  return marks.found;
}

}  // namespace quoin::commands
