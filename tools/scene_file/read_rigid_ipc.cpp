/// Fixtures of rigid-ipc: bodies by mesh, position, rotation and scale.

#include <Eigen/Geometry>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Matrix3;
using geometry::Vector3;
using nlohmann::json;

/// `otherwise` where the key is missing; a number stands for three.
Vector3 vector_at(const json& body, const char* key, const Vector3& otherwise) {
  if (!body.contains(key)) return otherwise;
  const json& value = body[key];
  if (value.is_number()) return Vector3::Constant(value.get<double>());
  const auto numbers = value.get<std::vector<double>>();
  if (numbers.size() != 3) throw MeshError(std::string(key) + " has not three numbers");
  return {numbers[0], numbers[1], numbers[2]};
}

/// Rotations about x, y, z in degrees, x first.
Matrix3 rotation_of(const json& body) {
  const Vector3 angles = std::numbers::pi / 180 * vector_at(body, "rotation", Vector3::Zero());
  Matrix3 rotation = Matrix3::Identity();
  for (int axis = 0; axis < 3; ++axis)
    rotation = Eigen::AngleAxisd(angles[axis], Vector3::Unit(axis)).toRotationMatrix() * rotation;
  return rotation;
}

bool is_fixed(const json& body) {
  if (body.value("type", "dynamic") != "dynamic") return true;
  const json fixed = body.value("is_dof_fixed", json(false));
  if (fixed.is_boolean()) return fixed.get<bool>();
  return std::ranges::all_of(fixed, [](const json& one) { return one.get<bool>(); });
}

/// Beside the file, or in a folder `meshes` of one above.
std::string mesh_path(const std::string& file, const std::string& mesh) {
  namespace fs = std::filesystem;
  std::error_code none;
  for (fs::path folder = fs::absolute(file).parent_path();; folder = folder.parent_path()) {
    for (const fs::path& path : {folder / mesh, folder / "meshes" / mesh})
      if (fs::is_regular_file(path, none)) return path.string();
    if (folder == folder.parent_path()) break;
  }
  throw MeshError("there is no mesh " + in_quotes(mesh) +
                  " beside it, nor in a folder \"meshes\" above");
}

/// Of a mesh: `dimensions` (m) say how large it is to be, in place of `scale`.
Vector3 scale_of(const json& body, const std::vector<MeshBlock>& meshes) {
  if (!body.contains("dimensions")) return vector_at(body, "scale", Vector3::Ones());
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const MeshBlock& mesh : meshes) {
    low = low.cwiseMin(Vector3(mesh.vertices.rowwise().minCoeff()));
    high = high.cwiseMax(Vector3(mesh.vertices.rowwise().maxCoeff()));
  }
  const Vector3 wanted = vector_at(body, "dimensions", Vector3::Ones());
  return (high.array() > low.array()).select(wanted.array() / (high - low).array(), wanted);
}

/// A flat support is the upper side, y up, of a slab a tenth as thick as it is wide.
void thicken(MeshBlock& mesh) {
  constexpr double kFlat = 1e-9, kThick = 0.1;  // of its width
  const Vector3 first = mesh.vertices.col(0);
  const geometry::Points from_first = mesh.vertices.colwise() - first;
  const double width = from_first.colwise().norm().maxCoeff();
  const std::vector<int>& face = mesh.faces.front();
  Vector3 up = Vector3(mesh.vertices.col(face[1]) - mesh.vertices.col(face[0]))
                   .cross(Vector3(mesh.vertices.col(face[2]) - mesh.vertices.col(face[0])))
                   .normalized();
  if (up.y() < 0.0) up = -up;
  if ((up.transpose() * from_first).cwiseAbs().maxCoeff() > kFlat * width) return;
  std::vector<std::array<double, 3>> corners;
  for (const double depth : {0.0, kThick * width}) {
    for (Eigen::Index v = 0; v < mesh.vertices.cols(); ++v) {
      const Vector3 corner = mesh.vertices.col(v) - depth * up;
      corners.push_back({corner.x(), corner.y(), corner.z()});
    }
  }
  MeshBlock slab = hull_mesh(mesh.id, corners);
  mesh.vertices = std::move(slab.vertices);
  mesh.faces = std::move(slab.faces);
}

void append_body(const json& body, std::size_t number, const std::string& file,
                 std::vector<MeshBlock>& blocks) {
  const std::string path = mesh_path(file, body.at("mesh").get<std::string>());
  const Vector3 position = vector_at(body, "position", Vector3::Zero());
  std::vector<MeshBlock> meshes = read_mesh_file(path, mesh_format(path, ""));
  const Matrix3 linear = rotation_of(body) * scale_of(body, meshes).asDiagonal();
  const std::string name = "body" + std::to_string(number);
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    MeshBlock& mesh = meshes[m];
    mesh.vertices = ((linear * mesh.vertices).colwise() + position).eval();
    mesh.rounding *= linear.colwise().norm().maxCoeff();
    mesh.name = std::filesystem::path(path).stem().string();
    mesh.id = meshes.size() == 1 ? name : name + "." + std::to_string(m);
    mesh.body = meshes.size() == 1 ? "" : name;
    mesh.is_support = is_fixed(body);
    mesh.density = body.value("density", 0.0);
    if (mesh.is_support) thicken(mesh);
    blocks.push_back(std::move(mesh));
  }
}

}  // namespace

std::vector<MeshBlock> read_rigid_ipc(std::string_view text, const std::string& path) {
  std::vector<MeshBlock> blocks;
  std::size_t number = 0;
  try {
    const json document = json::parse(text);
    const json& problem =
        document.contains("rigid_body_problem") ? document["rigid_body_problem"] : document;
    for (const json& body : problem.at("rigid_bodies")) {
      append_body(body, number, path, blocks);
      ++number;
    }
  } catch (const json::exception& error) {
    throw MeshError("body " + std::to_string(number) + ": " + error.what());
  } catch (const MeshError& error) {
    throw MeshError("body " + std::to_string(number) + ": " + error.what());
  }
  return blocks;
}

}  // namespace quoin::scene_file
