/// BODIES.DAT of LMGC90: the POLYR and PLANx of its RBDY3.

#include <Eigen/Geometry>
#include <map>
#include <utility>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

using geometry::Matrix3;
using geometry::Vector3;

/// "coo1= 1.0" as words "coo1", "1.0"; exponents by D.
std::string plain(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c == '=' ? ' ' : c;
  for (std::size_t i = 1; i + 1 < result.size(); ++i) {
    const bool digit = result[i - 1] >= '0' && result[i - 1] <= '9';
    if (result[i] == 'D' && digit && (result[i + 1] == '+' || result[i + 1] == '-'))
      result[i] = 'E';
  }
  return result;
}

/// The numbers behind three keys of a line, the first of them at word `first`.
Vector3 three(Lines& lines, std::string_view key, std::size_t first = 0) {
  if (lines.words().size() < first + 6 || !lines.words()[first].starts_with(key))
    lines.fail("three numbers " + std::string(key) + "… are missing");
  return {lines.real(first + 1), lines.real(first + 3), lines.real(first + 5)};
}

void need_line(Lines& lines) {
  if (!lines.next()) lines.fail("the file ends in the midst of a body");
}

struct Frame {
  Vector3 translation = Vector3::Zero();
  Matrix3 axes = Matrix3::Identity();
};

/// Of the bodies, by number, as DOF.INI has them.
std::map<long, Frame> frames(const std::string& text) {
  std::map<long, Frame> result;
  Lines lines(text);
  lines.set_marks('!', '\\', "");
  Frame* frame = nullptr;
  while (lines.next()) {
    const std::string_view word = lines.words()[0];
    if (word == "RBDY3" && lines.words().size() > 1) frame = &result[lines.integer(1)];
    if (frame == nullptr) continue;
    if (word == "NO6xx" && lines.words().size() > 2) frame->translation = three(lines, "X(1)", 2);
    for (int axis = 0; axis < 3; ++axis) {
      const std::string key = std::string(1, "abg"[axis]) + "(1)";
      if (word == key) frame->axes.col(axis) = three(lines, key);
    }
  }
  return result;
}

/// A POLYR from its line on; corners are seen from `place`. LMGC90 reads by columns: what the keys
/// are called (nb_faces, nb_face) differs between the programs that write such files.
MeshBlock polyr(Lines& lines, const Vector3& place, const Matrix3& axes) {
  if (lines.words().size() < 8) lines.fail("nb_vertex and nb_faces are missing");
  const long vertices = lines.integer(5), faces = lines.integer(7);
  if (vertices < 4 || faces < 4) lines.fail("a POLYR has at least 4 vertices and 4 faces");
  MeshBlock mesh;
  mesh.vertices.resize(3, vertices);
  for (long v = 0; v < vertices; ++v) {
    need_line(lines);
    mesh.vertices.col(v) = place + axes * three(lines, "coo1");
  }
  for (long f = 0; f < faces; ++f) {
    need_line(lines);
    mesh.faces.emplace_back();
    for (const double number : three(lines, "ver1")) {
      if (!(number >= 1 && number <= static_cast<double>(vertices)))
        lines.fail("there is no vertex " + std::to_string(static_cast<long>(number)));
      mesh.faces.back().push_back(static_cast<int>(number) - 1);
    }
  }
  keep_used_vertices(mesh);
  return mesh;
}

/// A PLANx: a box by its half lengths.
MeshBlock planx(Lines& lines, const Vector3& place, const Matrix3& axes) {
  const Vector3 half = three(lines, "", 4);
  if (!(half.minCoeff() > 0.0)) lines.fail("the half lengths of a PLANx must be greater than 0");
  std::vector<std::array<double, 3>> corners;
  for (unsigned c = 0; c < 8; ++c) {
    const Vector3 signs((c & 1U) ? 1.0 : -1.0, (c & 2U) ? 1.0 : -1.0, (c & 4U) ? 1.0 : -1.0);
    const Vector3 corner = place + axes * half.cwiseProduct(signs);
    corners.push_back({corner.x(), corner.y(), corner.z()});
  }
  return hull_mesh("", corners);
}

}  // namespace

std::vector<MeshBlock> read_lmgc90(std::string_view text, std::string_view dof) {
  std::map<long, Frame> turned = frames(plain(dof));
  const std::string words = plain(text);
  Lines lines(words);
  lines.set_marks('!', '\\', "");
  std::vector<MeshBlock> blocks;
  std::size_t first = 0;  // of this body
  long number = 0;
  Vector3 place = Vector3::Zero();
  const auto end_body = [&] {  // a block by itself goes by the number alone
    if (blocks.size() == first + 1) blocks.back().id = std::exchange(blocks.back().body, "");
    first = blocks.size();
  };
  while (lines.next()) {
    const std::string_view word = lines.words()[0];
    if (word == "RBDY3" && lines.words().size() > 1) {
      end_body();
      ++number;  // LMGC90 counts; the file may have a number twice
    } else if (word == "NO6xx") {
      place = three(lines, "coo1", 2) + turned[number].translation;
    } else if (word == "POLYR" || word == "PLANx") {
      const Matrix3& axes = turned[number].axes;
      blocks.push_back(word == "POLYR" ? polyr(lines, place, axes) : planx(lines, place, axes));
      blocks.back().body = "RBDY3_" + std::to_string(number);
      blocks.back().id = blocks.back().body + "." + std::to_string(blocks.size() - 1 - first);
    } else if (word == "SPHER" || word == "SPHEb" || word == "CYLND" || word == "DNLYC") {
      lines.fail("a contactor " + in_quotes(word) + " is not imported: POLYR and PLANx alone are");
    }
  }
  end_body();
  if (blocks.empty()) throw MeshError("holds no POLYR and no PLANx");
  return blocks;
}

}  // namespace quoin::scene_file
