/// Solids that are not convex, split exactly into convex parts.

#include <Eigen/Geometry>
#include <numbers>
#include <quoin/geometry/mass_properties.hpp>

#include "scene_file/mesh_file.hpp"
#include "support/catch.hpp"

using namespace quoin;
using namespace quoin::tests;
using geometry::Vector3;
using scene_file::MeshBlock;

namespace {

using Corners = std::vector<std::array<double, 2>>;

/// A polygon in x, z, counter-clockwise seen against y, swept along y by 1.
MeshBlock prism(const Corners& polygon) {
  const int n = static_cast<int>(polygon.size());
  MeshBlock mesh{.id = "prism", .vertices = geometry::Points(3, 2 * n), .faces = {{}, {}}};
  for (int i = 0; i < n; ++i) {
    const auto& [x, z] = polygon[static_cast<std::size_t>(i)];
    mesh.vertices.col(i) << x, 0, z;
    mesh.vertices.col(n + i) << x, 1, z;
    mesh.faces[0].push_back(i);
    mesh.faces[1].insert(mesh.faces[1].begin(), n + i);
    mesh.faces.push_back({(i + 1) % n, i, n + i, n + (i + 1) % n});
  }
  return mesh;
}

/// Squares of half sides and heights that follow each other, joined by quadrilaterals; the last is
/// joined to the first where the surface is a ring, else both are closed.
MeshBlock squares(const Corners& sections, bool ring) {
  const int n = static_cast<int>(sections.size());
  MeshBlock mesh{.id = "squares", .vertices = geometry::Points(3, 4 * n), .faces = {}};
  for (int s = 0; s < n; ++s) {
    const auto& [half, z] = sections[static_cast<std::size_t>(s)];
    for (int c = 0; c < 4; ++c)
      mesh.vertices.col(4 * s + c) << (c == 0 || c == 3 ? -half : half), (c < 2 ? -half : half), z;
    const int next = (s + 1) % n;
    for (int c = 0; c < 4 && (ring || next > 0); ++c) {
      const int d = (c + 1) % 4;
      mesh.faces.push_back({4 * s + c, 4 * s + d, 4 * next + d, 4 * next + c});
    }
  }
  if (!ring)
    mesh.faces.insert(mesh.faces.end(),
                      {{3, 2, 1, 0}, {4 * n - 4, 4 * n - 3, 4 * n - 2, 4 * n - 1}});
  return mesh;
}

struct Profile {
  const char* name;
  MeshBlock mesh;
  double volume;
  std::size_t parts;
};

std::vector<Profile> profiles() {
  return {
      {"box", prism({{0, 0}, {2, 0}, {2, 1}, {0, 1}}), 2, 1},
      {"L", prism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}), 4, 2},
      {"T", prism({{1, 0}, {2, 0}, {2, 2}, {3, 2}, {3, 3}, {0, 3}, {0, 2}, {1, 2}}), 5, 3},
      {"U", prism({{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}), 7, 3},
      {"ring", squares({{2, 0}, {2, 1}, {1, 1}, {1, 0}}, true), 12, 4},
      {"steps", squares({{3, 0}, {3, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 3}}, false), 36 + 16 + 4, 3}};
}

double volume_of(const std::vector<geometry::Shape>& parts) {
  double volume = 0;
  for (const geometry::Shape& part : parts) volume += geometry::mass_properties(part).volume;
  return volume;
}

}  // namespace

TEST_CASE("L, T and U profiles, a ring and a step pyramid are split exactly") {
  const geometry::Matrix3 turn =
      Eigen::AngleAxisd(1.1, Vector3(2, -1, 3).normalized()).toRotationMatrix();
  for (Profile& profile : profiles()) {
    CAPTURE(profile.name);
    const std::vector<geometry::Shape> parts = scene_file::convex_parts(profile.mesh);
    CHECK(parts.size() <= profile.parts);
    CHECK_THAT(volume_of(parts), WithinRel(profile.volume, 1e-12));
    profile.mesh.vertices = ((turn * profile.mesh.vertices).colwise() + Vector3(7, -3, 5)).eval();
    CHECK_THAT(volume_of(scene_file::convex_parts(profile.mesh)), WithinRel(profile.volume, 1e-12));
  }
}

TEST_CASE("Parts meet on the same places") {
  const std::vector<geometry::Shape> parts = scene_file::convex_parts(profiles()[3].mesh);
  int shared = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    for (std::size_t q = 0; q < p; ++q) {
      for (int v = 0; v < parts[p].vertex_count(); ++v)
        for (int w = 0; w < parts[q].vertex_count(); ++w)
          shared += parts[p].vertex(v) == parts[q].vertex(w);
    }
  }
  CHECK(shared == 4);  // each wall stands on the inner edge of the base with two corners
}

TEST_CASE("A surface that is open or crosses itself is refused") {
  MeshBlock open = profiles()[1].mesh;
  open.faces.pop_back();
  CHECK_THROWS_WITH(scene_file::convex_parts(open), ContainsSubstring("can't be split"));
  MeshBlock crossing = profiles()[4].mesh;
  std::swap(crossing.faces[0][0], crossing.faces[0][1]);
  CHECK_THROWS_WITH(scene_file::convex_parts(crossing), ContainsSubstring("can't be split"));
}
