/// Object File Format: OFF with optional normals and colours, as text.

#include <limits>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

long counted(const Lines& lines, std::size_t word, const char* what) {
  if (lines.words().size() <= word)
    lines.fail(std::string("the number of ") + what + " is missing");
  const long count = lines.integer(word);
  if (count < 0 || count > std::numeric_limits<int>::max()) {
    lines.fail("the number of " + std::string(what) + " must lie in 0 … 2147483647, is " +
               std::to_string(count));
  }
  return count;
}

void read_face(const Lines& lines, Surface& surface) {
  const long corners = counted(lines, 0, "corners of a face");
  if (corners < 3)
    lines.fail("a face has at least 3 vertices, this one has " + std::to_string(corners));
  if (std::ssize(lines.words()) < corners + 1) {
    lines.fail("a face of " + std::to_string(corners) + " vertices names only " +
               std::to_string(lines.words().size() - 1));
  }
  for (long i = 1; i <= corners; ++i) {
    const long vertex = lines.integer(static_cast<std::size_t>(i));
    if (vertex < 0 || vertex >= std::ssize(surface.places)) {
      lines.fail("there is no vertex " + std::to_string(vertex) + ", there are " +
                 std::to_string(surface.places.size()) + ", counted from 0");
    }
    surface.corners.push_back(static_cast<int>(vertex));
  }
  surface.face_ends.push_back(surface.corners.size());
  surface.face_group.push_back(0);
}

}  // namespace

Surface read_off(std::string_view text) {
  Lines lines(text);
  const auto need_line = [&](const std::string& what) {
    if (!lines.next()) lines.fail("the file ends before " + what);
  };
  need_line("its head");
  std::size_t word = 0;
  const std::string_view head = lines.words()[0];
  if (head == "OFF" || head == "COFF" || head == "NOFF" || head == "CNOFF")
    word = 1;
  else if (head.find("OFF") != std::string_view::npos)
    lines.fail(in_quotes(head) + " is none of OFF, COFF, NOFF, CNOFF");
  if (lines.words().size() == word) {
    need_line("the numbers of vertices and faces");
    word = 0;
  }
  const long vertices = counted(lines, word, "vertices");
  const long faces = counted(lines, word + 1, "faces");
  Surface surface;
  surface.groups.emplace_back();
  for (long i = 0; i < vertices; ++i) {
    need_line("vertex " + std::to_string(i) + " of " + std::to_string(vertices));
    surface.places.push_back(lines.place(0));
  }
  for (long i = 0; i < faces; ++i) {
    need_line("face " + std::to_string(i) + " of " + std::to_string(faces));
    read_face(lines, surface);
  }
  surface.digits = lines.digits();
  return surface;
}

}  // namespace quoin::scene_file
