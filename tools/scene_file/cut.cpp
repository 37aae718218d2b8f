#include "scene_file/cut.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry/mass_properties.hpp>
#include <quoin/geometry/split.hpp>
#include <random>

#include "scene_file/read_shape.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Shape;
using geometry::Vector3;
using nlohmann::json;

constexpr double kDegree = std::numbers::pi / 180;  // rad
constexpr double kMostPlanes = 1e5;                 // of one joint set
constexpr std::size_t kMostCells = 1000000;

double number(const json& object, const char* key, double otherwise) {
  return object.value(key, otherwise);
}

Vector3 upward_normal(double dip, double dip_direction) {
  return {std::sin(dip) * std::sin(dip_direction), std::sin(dip) * std::cos(dip_direction),
          std::cos(dip)};
}

Vector3 stated_normal(const json& entry) {
  return upward_normal(entry["dip_deg"].get<double>() * kDegree,
                       number(entry, "dip_direction_deg", 0) * kDegree);
}

/// The same numbers from the same seed everywhere, in [-1, 1].
class Scatter {
 public:
  explicit Scatter(const json& entry) : random_(entry.value("seed", std::uint64_t{1})) {}
  double operator()(double amplitude) {
    const double share = static_cast<double>(random_() >> 11U) * 0x1p-52 - 1;
    return amplitude * share;
  }

 private:
  std::mt19937_64 random_;
};

/// Where a cut acts: blocks whose centroid lies in a box or below a plane, and not in an
/// excavation that is left out.
class Range {
 public:
  explicit Range(const json& entry) {
    if (entry.contains("only_in")) ranges_ = entry["only_in"];
  }
  bool has(const CutCell& cell) const {
    if (ranges_.empty()) return true;
    const Vector3 centroid = mass_properties(cell.shape).centroid;
    return std::all_of(ranges_.begin(), ranges_.end(),
                       [&](const json& range) { return meets(range, cell, centroid); });
  }

 private:
  static bool meets(const json& range, const CutCell& cell, const Vector3& centroid) {
    if (range.contains("region")) return cell.region == range["region"].get<std::string>();
    if (range.contains("min")) {
      const Vector3 low = read_vector(range["min"]), high = read_vector(range["max"]);
      return (centroid.array() >= low.array()).all() && (centroid.array() <= high.array()).all();
    }
    return read_vector(range["normal"]).dot(centroid - read_vector(range["point"])) <= 0;
  }

  json ranges_ = json::array();
};

struct Disc {
  Vector3 centre;
  double radius = 0.0;  // m
};

/// Distance of a place in the plane of a convex polygon from it, m; 0: inside.
double distance(const Shape& shape, int face, const Vector3& place) {
  const auto corners = shape.topology().face(face);
  const Vector3 normal = shape.face_normal(face);
  double beyond = 0.0, nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3 p = shape.vertex(corners[i]);
    const Vector3 side = shape.vertex(corners[(i + 1) % corners.size()]) - p;
    beyond = std::max(beyond, (place - p).dot(side.cross(normal)) / side.norm());
    const double t = std::clamp((place - p).dot(side) / side.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (place - p - t * side).norm());
  }
  return beyond > 0 ? nearest : 0.0;
}

class Cutter {
 public:
  Cutter(const json& cut, std::string pointer) : cut_(cut), pointer_(std::move(pointer)) {}

  CutBody body() {
    read_cells();
    for (std::size_t i = 0; i < cut_["cuts"].size(); ++i) {
      const json& entry = cut_["cuts"][i];
      const std::string place = pointer_ + "/cuts/" + std::to_string(i);
      body_.joints.push_back(entry.value("name", "joint" + std::to_string(i)));
      joint_ = static_cast<int>(i);
      cuts_ = false;
      try {
        cut_by(entry);
        // The planes of a set may lie farther apart than the body is wide; of discs some may miss.
        const bool meant = entry["type"] == "plane" || entry["type"] == "excavation";
        if (meant && !cuts_) throw geometry::InputError("cuts no block: it meets none");
        if (!cuts_)
          body_.notes.push_back(place + ": \"" + body_.joints.back() + "\" cuts no block");
      } catch (const geometry::InputError& error) {
        throw SceneError(place, error.what());
      } catch (const std::length_error& error) {
        throw SceneError(place, error.what());
      }
    }
    return std::move(body_);
  }

 private:
  void read_cells() {
    const json& stated = cut_["body"];
    const json list = stated.is_array() ? stated : json::array({stated});
    for (std::size_t i = 0; i < list.size(); ++i) {
      try {
        Shape shape = read_shape(list[i]);
        std::vector<int> faces(static_cast<std::size_t>(shape.topology().face_count()), -1);
        body_.volume += mass_properties(shape).volume;
        body_.cells.push_back({std::move(shape), std::move(faces), {}});
      } catch (const geometry::InputError& error) {
        throw SceneError(pointer_ + "/body" + (stated.is_array() ? "/" + std::to_string(i) : ""),
                         error.what());
      }
    }
  }

  void cut_by(const json& entry) {
    const std::string type = entry["type"];
    check_regions(entry);
    const Range range(entry);
    const auto in_range = [&](const CutCell& cell) { return range.has(cell); };
    if (std::ranges::none_of(body_.cells, in_range))
      throw geometry::InputError("only_in leaves no block");
    if (type == "joint_set") return cut_by_set(entry, range);
    if (type == "excavation") return excavate(entry, range);
    const geometry::Plane plane{read_vector(entry[type == "disc" ? "centre" : "point"]),
                                stated_normal(entry)};
    std::optional<Disc> disc;
    if (type == "disc") disc = Disc{plane.point, entry["radius"]};
    cut_all(plane, range, disc);
  }

  /// A region is an excavation above.
  void check_regions(const json& entry) const {
    for (const json& range : entry.value("only_in", json::array())) {
      if (!range.contains("region")) continue;
      const std::string region = range["region"];
      if (std::count(body_.joints.begin(), body_.joints.end() - 1, region) == 0)
        throw geometry::InputError("only_in: no cut above is named \"" + region + '"');
    }
  }

  /// Planes at origin + k spacing along the mean normal, each with its own scatter.
  void cut_by_set(const json& entry, const Range& range) {
    const Vector3 normal = stated_normal(entry), origin = read_vector(entry["origin"]);
    const double spacing = entry["spacing"];
    double first = 0, last = number(entry, "number", 0) - 1;
    if (!entry.contains("number")) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const CutCell& cell : body_.cells) {
        const Eigen::RowVectorXd along =
            normal.transpose() * (cell.shape.vertices().colwise() - origin);
        low = std::min(low, along.minCoeff());
        high = std::max(high, along.maxCoeff());
      }
      first = std::floor(low / spacing);
      last = std::ceil(high / spacing);
    }
    if (!(last - first < kMostPlanes)) {
      throw std::length_error("would have " + json(last - first + 1).dump() +
                              " planes, at most 100000 are cut");
    }
    Scatter scatter(entry);
    for (double k = first; k <= last; ++k) {
      const double shift = k + scatter(number(entry, "spacing_scatter", 0));
      const double turn = number(entry, "scatter_deg", 0);
      const double dip = entry["dip_deg"].get<double>() + scatter(turn);
      const double direction = number(entry, "dip_direction_deg", 0) + scatter(turn);
      cut_all(
          {origin + shift * spacing * normal, upward_normal(dip * kDegree, direction * kDegree)},
          range, {});
    }
  }

  /// Blocks that reach into a convex solid are cut along its faces; those inside get its name.
  void excavate(const json& entry, const Range& range) {
    const Shape solid = read_shape(entry["shape"]);
    std::vector<CutCell> inside, outside;
    for (CutCell& cell : body_.cells) {
      if (!range.has(cell)) {
        outside.push_back(std::move(cell));
        continue;
      }
      carve(solid, std::move(cell), inside, outside);
    }
    cuts_ = !inside.empty();
    for (CutCell& cell : inside) cell.region = body_.joints.back();
    body_.cells = std::move(outside);
    std::move(inside.begin(), inside.end(), std::back_inserter(body_.cells));
  }

  void carve(const Shape& solid, CutCell cell, std::vector<CutCell>& inside,
             std::vector<CutCell>& outside) const {
    std::optional<CutCell> rest(cell);
    std::vector<CutCell> off;
    for (int f = 0; f < solid.topology().face_count() && rest; ++f) {
      auto [below, above] =
          parted(*rest, {solid.vertex(solid.topology().face(f)[0]), solid.face_normal(f)});
      if (above) off.push_back(std::move(*above));
      rest = std::move(below);
    }
    if (!rest) return outside.push_back(std::move(cell));  // it does not reach in: left whole
    inside.push_back(std::move(*rest));
    std::move(off.begin(), off.end(), std::back_inserter(outside));
  }

  void cut_all(const geometry::Plane& plane, const Range& range, const std::optional<Disc>& disc) {
    std::vector<CutCell> cells;
    cells.reserve(body_.cells.size() + 16);
    for (CutCell& cell : body_.cells) {
      if (!crosses(cell.shape, plane) || !range.has(cell)) {
        cells.push_back(std::move(cell));
        continue;
      }
      auto [below, above] = parted(cell, plane);
      if (!below || !above || (disc && !reaches(*disc, *below))) {
        cells.push_back(std::move(cell));
        continue;
      }
      cells.push_back(std::move(*below));
      cells.push_back(std::move(*above));
      cuts_ = true;
    }
    body_.cells = std::move(cells);
    if (body_.cells.size() > kMostCells) throw std::length_error("makes more than 1000000 blocks");
  }

  static bool crosses(const Shape& shape, const geometry::Plane& plane) {
    const Eigen::RowVectorXd heights =
        plane.normal.transpose() * (shape.vertices().colwise() - plane.point);
    return heights.minCoeff() < 0 && heights.maxCoeff() > 0;
  }

  bool reaches(const Disc& disc, const CutCell& below) const {
    for (std::size_t f = 0; f < below.face_joints.size(); ++f)
      if (below.face_joints[f] == joint_ &&
          distance(below.shape, static_cast<int>(f), disc.centre) <= disc.radius)
        return true;
    return false;
  }

  struct Parted {
    std::optional<CutCell> below, above;
  };
  Parted parted(const CutCell& cell, const geometry::Plane& plane) const {
    geometry::Split parts = geometry::split(cell.shape, plane);
    const auto part = [&](std::optional<geometry::SplitPart>& from) -> std::optional<CutCell> {
      if (!from) return {};
      std::vector<int> joints;
      for (const int old : from->old_faces)
        joints.push_back(old < 0 ? joint_ : cell.face_joints[static_cast<std::size_t>(old)]);
      return CutCell{std::move(from->shape), std::move(joints), cell.region};
    };
    return {part(parts.below), part(parts.above)};
  }

  const json& cut_;
  std::string pointer_;
  CutBody body_;
  int joint_ = 0;
  bool cuts_ = false;  ///< whether the entry at hand has parted or named a block
};

json polyhedron(const CutCell& cell, const std::vector<std::string>& joints) {
  const Shape& shape = cell.shape;
  json vertices = json::array(), faces = json::array(), planes = json::array();
  for (int v = 0; v < shape.vertex_count(); ++v) {
    const Vector3 place = shape.vertex(v);
    vertices.push_back({place.x(), place.y(), place.z()});
  }
  for (int f = 0; f < shape.topology().face_count(); ++f) {
    const auto corners = shape.topology().face(f);
    faces.push_back(std::vector<int>(corners.begin(), corners.end()));
    const int joint = cell.face_joints[static_cast<std::size_t>(f)];
    planes.push_back(joint < 0 ? "" : joints[static_cast<std::size_t>(joint)]);
  }
  return {{"type", "polyhedron"},
          {"vertices", std::move(vertices)},
          {"faces", std::move(faces)},
          {"planes", std::move(planes)}};
}

}  // namespace

CutBody cut_body(const json& cut, const std::string& pointer) {
  return Cutter(cut, pointer).body();
}

std::vector<std::string> expand_cut(json& scene) {
  if (!scene.contains("cut")) return {};
  CutBody body = cut_body(scene["cut"], "/cut");
  expand_cut(scene, body);
  return std::move(body.notes);
}

void expand_cut(json& scene, const CutBody& body) {
  const json cut = std::move(scene["cut"]);
  scene.erase("cut");
  json& blocks = scene["blocks"];
  if (blocks.is_object()) blocks = json::array({blocks});
  const std::string name = cut.value("name", "rock");
  const json common = cut.value("block", json::object());
  int index = 0;
  for (const CutCell& cell : body.cells) {
    json block = common;
    block["name"] = (cell.region.empty() ? "" : cell.region + ":") + name + std::to_string(index++);
    block["shape"] = polyhedron(cell, body.joints);
    blocks.push_back(std::move(block));
  }
}

}  // namespace quoin::scene_file
