#include "scene_file/read_shape.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numbers>
#include <quoin/geometry/build.hpp>

#include "scene_file/scene_error.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Matrix3;
using geometry::Points;
using geometry::Vector3;
using nlohmann::json;

Points read_points(const json& points) {
  Points result(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i)
    result.col(static_cast<Eigen::Index>(i)) = read_vector(points[i]);
  return result;
}

Matrix3 matrix_of_rows(const json& rows, const std::string& pointer) {
  Matrix3 matrix;
  for (std::size_t i = 0; i < 3; ++i)
    matrix.row(static_cast<Eigen::Index>(i)) = read_vector(rows[i]).transpose();
  const double off = (matrix * matrix.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff();
  if (off > 1e-9 || matrix.determinant() < 0) {
    throw SceneError(pointer, "is not a rotation: its rows are off orthonormal by " +
                                  json(off).dump() + ", determinant " +
                                  json(matrix.determinant()).dump());
  }
  return matrix;
}

Matrix3 read_rotation(const json& rotation, const std::string& pointer) {
  if (rotation.contains("matrix")) return matrix_of_rows(rotation["matrix"], pointer + "/matrix");
  if (rotation.contains("quaternion")) {
    const auto q = rotation["quaternion"].get<std::vector<double>>();
    const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
    if (!(quaternion.norm() > 0)) throw SceneError(pointer + "/quaternion", "must not be zero");
    return quaternion.normalized().toRotationMatrix();
  }
  const Vector3 axis = read_vector(rotation["axis"]);
  if (!(axis.norm() > 0)) throw SceneError(pointer + "/axis", "must not be zero");
  const double angle = rotation["angle_deg"].get<double>() * std::numbers::pi / 180;
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

Points read_checked_points(const json& list, const std::string& name) {
  if (!list.is_array()) throw geometry::InputError(name + " is not a list of points");
  Points points(3, static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const json& point = list[i];
    if (!point.is_array() || point.size() != 3 || !point[0].is_number() || !point[1].is_number() ||
        !point[2].is_number()) {
      throw geometry::InputError(name + ": point " + std::to_string(i) +
                                 " is not a list of three numbers");
    }
    points.col(static_cast<Eigen::Index>(i)) = read_vector(point);
  }
  return points;
}

geometry::Placement read_placement(const json& list, const std::string& name) {
  constexpr std::size_t kNumbers = 12;
  const auto number = [](const json& value) { return value.is_number(); };
  if (!list.is_array() || list.size() != kNumbers || !std::all_of(list.begin(), list.end(), number))
    throw geometry::InputError(name + ": \"placement\" is not a list of 12 numbers: t, A by rows");
  const auto numbers = list.get<std::array<double, kNumbers>>();
  geometry::Placement placement;
  placement.translation = Eigen::Map<const Vector3>(numbers.data());
  placement.linear =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data() + 3);
  const double largest = placement.translation.cwiseAbs().maxCoeff();
  if (largest > geometry::kLargestCoordinate) {
    throw geometry::InputError(name + ": \"placement\" moves by " + json(largest).dump() +
                               " m, at most " + json(geometry::kLargestCoordinate).dump());
  }
  const double determinant = placement.linear.determinant();
  if (!(determinant > 0)) {
    throw geometry::InputError(name + ": \"placement\" has determinant " +
                               json(determinant).dump() + ", must be above 0");
  }
  return placement;
}

}  // namespace

Vector3 read_vector(const json& value) {
  return Vector3(value[0].get<double>(), value[1].get<double>(), value[2].get<double>());
}

geometry::Shape read_shape(const json& shape) {
  const std::string type = shape["type"];
  if (type == "box")
    return geometry::make_box(read_vector(shape["min"]), read_vector(shape["max"]));
  if (type == "prism")
    return geometry::make_prism(read_points(shape["polygon"]), read_vector(shape["sweep"]));
  if (type == "hull") return geometry::make_hull(read_points(shape["points"])).polyhedron;
  return geometry::make_shape(read_points(shape["vertices"]),
                              shape["faces"].get<std::vector<std::vector<int>>>());
}

PlacedPoints read_placed_points(const json& value, const std::string& name) {
  if (!value.is_object()) return {read_checked_points(value, name), {}};
  for (const auto& [key, entry] : value.items()) {
    if (key != "points" && key != "placement") {
      throw geometry::InputError(name + ": unknown key \"" + key +
                                 "\", allowed are \"points\" and \"placement\"");
    }
  }
  if (!value.contains("points")) throw geometry::InputError(name + ": \"points\" is missing");
  PlacedPoints placed{read_checked_points(value["points"], name + ": \"points\""), {}};
  if (value.contains("placement")) placed.placement = read_placement(value["placement"], name);
  return placed;
}

geometry::Placement read_pose(const json& pose, const std::string& pointer) {
  geometry::Placement placement;
  if (pose.contains("rotation")) {
    placement.linear = read_rotation(pose["rotation"], pointer + "/rotation");
    const Vector3 about = pose.contains("about") ? read_vector(pose["about"]) : Vector3::Zero();
    placement.translation = about - placement.linear * about;
  }
  if (pose.contains("translation")) placement.translation += read_vector(pose["translation"]);
  return placement;
}

}  // namespace quoin::scene_file
