#include "limit/certificate.hpp"

#include <cmath>
#include <fstream>
#include <quoin/geometry/mass_properties.hpp>

namespace quoin::limit_analysis {
namespace {

using json = nlohmann::ordered_json;

constexpr double kMoves = 1e-6;  // of the fastest block

json vary_json(const Vary& vary) {
  return {{"what", vary.what},
          {"name", vary.name},
          {"from", vary.from},
          {"axis", std::vector<double>(vary.axis.begin(), vary.axis.end())}};
}

json vector_json(const Eigen::VectorXd& v) { return std::vector<double>(v.begin(), v.end()); }

}  // namespace

json certificate(const Trial& trial, const Vary& vary) {
  const Scene& scene = trial.scene;
  json blocks = json::array(), contacts = json::array(), joints = json::array();
  for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
    const solver::Block& block = scene.blocks[b];
    const solver::EquilibriumBlock& solved = trial.problem.blocks[b];
    if (block.kind == solver::BlockKind::Absent) continue;
    json vertices = json::array();
    for (int v = 0; v < block.shape->vertex_count(); ++v)
      vertices.push_back(vector_json(block.body().vertex(v)));
    Vector6 applied = solved.load;
    if (solved.moves) {
      applied.head<3>() -= block.material.density * geometry::mass_properties(block.body()).volume *
                           scene.gravity.at(0.0);
    }
    blocks.push_back({{"index", b},
                      {"name", block.name},
                      {"moves", solved.moves},
                      {"density", block.material.density},
                      {"group", block.material.joint_group},
                      {"vertices", vertices},
                      {"applied", vector_json(applied)},
                      {"live", vector_json(solved.live)},
                      {"velocity", vector_json(trial.found.velocities[b])}});
    if (block.parts) {
      json counts = json::array();
      for (const geometry::Shape& part : *block.parts) counts.push_back(part.vertex_count());
      blocks.back()["parts"] = counts;
    }
  }
  for (std::size_t i = 0; i < trial.problem.contacts.size(); ++i) {
    const solver::EquilibriumContact& contact = trial.problem.contacts[i];
    contacts.push_back({{"a", contact.a},
                        {"b", contact.b},
                        {"point", vector_json(contact.point + trial.problem.origin)},
                        {"normal", vector_json(contact.normal)},
                        {"held", contact.held || contact.guided},
                        {"guided", contact.guided},
                        {"force", vector_json(trial.found.forces[i])}});
  }
  const auto add_joint = [&](json groups, const solver::Joint& joint) {
    joints.push_back({{"groups", std::move(groups)},
                      {"friction", std::tan(joint.friction_angle)},
                      {"cohesion", joint.cohesion},
                      {"tension", joint.tension}});
  };
  add_joint(nullptr, scene.joint);
  for (const solver::PairJoint& pair : scene.pair_joints)
    add_joint({pair.group_a, pair.group_b}, pair.joint);
  for (const solver::BlockJoint& pair : scene.block_joints) {
    add_joint(nullptr, pair.joint);
    joints.back()["blocks"] = {pair.a, pair.b};
  }
  const bool stands = trial.found.verdict == EquilibriumVerdict::Admissible;
  return {{"certificate", stands ? "stands" : "falls"},
          {"value", trial.value},
          {"vary", vary_json(vary)},
          {"factor", trial.factor},
          {"shrink", trial.shrink},
          {"joints_are", name(trial.joints)},
          {"gravity", vector_json(scene.gravity.at(0.0))},
          {"joints", joints},
          {"blocks", blocks},
          {"contacts", contacts}};
}

json summary(const Trial* trial) {
  if (trial == nullptr) return nullptr;
  const Equilibrium& found = trial->found;
  if (found.verdict == EquilibriumVerdict::Admissible) {
    return {{"value", trial->value},
            {"unbalance", found.unbalance},
            {"violation", found.violation},
            {"joints", name(trial->joints)},
            {"margin", std::isfinite(found.margin) ? json(found.margin) : json()}};
  }
  return {{"value", trial->value},
          {"power", found.power},
          {"dissipation", found.dissipation},
          {"incompatibility", found.incompatibility}};
}

namespace {

/// Of a block's point, by its velocities.
Vector3 velocity_at(const Trial& trial, int block, const Vector3& point) {
  if (block < 0) return Vector3::Zero();
  const Vector6& v = trial.found.velocities[static_cast<std::size_t>(block)];
  const Vector3 place = trial.problem.blocks[static_cast<std::size_t>(block)].place;
  return v.head<3>() + Vector3(v.tail<3>()).cross(point - place);
}

JointMotion motion(const solver::EquilibriumContact& contact, const Trial& trial) {
  const Vector3 v =
      velocity_at(trial, contact.b, contact.point) - velocity_at(trial, contact.a, contact.point);
  const double opening = v.dot(contact.normal);
  const double slip = (v - opening * contact.normal).norm();
  if (opening > contact.friction * slip + kMoves) return JointMotion::Opens;
  return slip > kMoves ? JointMotion::Slides : JointMotion::Closed;
}

std::ofstream vtk_file(const std::filesystem::path& path, const char* title) {
  std::ofstream file(path);
  file.precision(12);
  file << "# vtk DataFile Version 3.0\n" << title << "\nASCII\nDATASET POLYDATA\n";
  return file;
}

template <class Rows>
void write_vectors(std::ofstream& file, const char* name, const Rows& rows) {
  file << "VECTORS " << name << " double\n";
  for (const Vector3& row : rows) file << row.transpose() << '\n';
}

void write_points(std::ofstream& file, const std::vector<Vector3>& points) {
  file << "POINTS " << points.size() << " double\n";
  for (const Vector3& point : points) file << point.transpose() << '\n';
}

void flush(std::ofstream& file, const std::filesystem::path& path) {
  if (!file.flush()) throw scene_file::FileError(path.filename().string() + ": can't be written");
}

void write_block_file(const std::filesystem::path& path, const Trial& trial) {
  std::vector<Vector3> points, velocities;
  std::vector<std::vector<int>> faces;
  for (std::size_t b = 0; b < trial.scene.blocks.size(); ++b) {
    const solver::Block& block = trial.scene.blocks[b];
    if (block.kind == solver::BlockKind::Absent) continue;
    const int first = static_cast<int>(points.size());
    for (int v = 0; v < block.shape->vertex_count(); ++v) {
      points.push_back(block.body().vertex(v));
      velocities.push_back(
          velocity_at(trial, static_cast<int>(b), points.back() - trial.problem.origin));
    }
    for (int f = 0; f < block.shape->topology().face_count(); ++f) {
      faces.emplace_back();
      for (const int v : block.shape->topology().face(f)) faces.back().push_back(first + v);
    }
  }
  std::ofstream file = vtk_file(path, "blocks");
  write_points(file, points);
  std::size_t numbers = 0;
  for (const auto& face : faces) numbers += face.size() + 1;
  file << "POLYGONS " << faces.size() << ' ' << numbers << '\n';
  for (const auto& face : faces) {
    file << face.size();
    for (const int v : face) file << ' ' << v;
    file << '\n';
  }
  file << "POINT_DATA " << points.size() << '\n';
  write_vectors(file, "velocity", velocities);
  flush(file, path);
}

}  // namespace

void write_vtk(const std::filesystem::path& blocks, const std::filesystem::path& contacts,
               const Trial& trial) {
  write_block_file(blocks, trial);
  std::ofstream file = vtk_file(contacts, "contacts");
  std::vector<Vector3> points;
  for (const auto& contact : trial.problem.contacts)
    points.push_back(contact.point + trial.problem.origin);
  write_points(file, points);
  file << "VERTICES " << points.size() << ' ' << 2 * points.size() << '\n';
  for (std::size_t i = 0; i < points.size(); ++i) file << "1 " << i << '\n';
  file << "POINT_DATA " << points.size() << "\nSCALARS motion int 1\nLOOKUP_TABLE default\n";
  for (const auto& contact : trial.problem.contacts)
    file << static_cast<int>(motion(contact, trial)) << '\n';
  write_vectors(file, "force", trial.found.forces);
  flush(file, contacts);
}

}  // namespace quoin::limit_analysis
