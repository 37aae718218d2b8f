/// STL: triangles, as text (any number of solids) or binary (one).

#include <bit>
#include <cmath>
#include <cstring>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

constexpr std::size_t kHead = 80;       // bytes of text, then the number of facets
constexpr std::size_t kFacetSize = 50;  // 12 floats and 2 bytes

std::uint32_t little_endian(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8U | static_cast<unsigned char>(bytes[i]);
  return value;
}

bool is_binary(std::string_view text) {
  if (text.size() >= kHead + 4 &&
      text.size() == kHead + 4 + kFacetSize * std::size_t{little_endian(text.data() + kHead)})
    return true;
  return text.find('\0') != std::string_view::npos;
}

void add_triangle(int group, Surface& surface) {
  const int end = static_cast<int>(surface.places.size());
  surface.corners.insert(surface.corners.end(), {end - 3, end - 2, end - 1});
  surface.face_ends.push_back(surface.corners.size());
  surface.face_group.push_back(group);
}

Surface read_binary(std::string_view text) {
  if (text.size() < kHead + 4) {
    throw MeshError("a binary STL file has at least 84 bytes, this one has " +
                    std::to_string(text.size()));
  }
  const std::size_t count = little_endian(text.data() + kHead);
  if (text.size() < kHead + 4 + kFacetSize * count) {
    throw MeshError("its head states " + std::to_string(count) + " facets, its " +
                    std::to_string(text.size()) + " bytes hold " +
                    std::to_string((text.size() - kHead - 4) / kFacetSize));
  }
  Surface surface;
  surface.groups.emplace_back();
  for (std::size_t f = 0; f < count; ++f) {
    const char* corner = text.data() + kHead + 4 + kFacetSize * f + 12;  // after the normal
    for (int i = 0; i < 3; ++i) {
      std::array<double, 3>& place = surface.places.emplace_back();
      for (double& coordinate : place) {
        coordinate = std::bit_cast<float>(little_endian(corner));
        corner += 4;
        if (!std::isfinite(coordinate))
          throw MeshError("facet " + std::to_string(f) + ": a coordinate is not a finite number");
      }
    }
    add_triangle(0, surface);
  }
  return surface;
}

/// Names of "solid NAME"; what exporters write after it (units, a date) stays part of the name.
std::string rest_of(const Lines& lines) {
  std::string name;
  for (std::size_t i = 1; i < lines.words().size(); ++i)
    name += (i == 1 ? "" : " ") + std::string(lines.words()[i]);
  return name;
}

Surface read_ascii(std::string_view text) {
  Surface surface;
  Lines lines(text);
  int corners = 0;
  while (lines.next()) {
    const std::string_view word = lines.words()[0];
    if (word == "solid") {
      surface.groups.push_back(rest_of(lines));
    } else if (surface.groups.empty()) {
      lines.fail("\"solid\" expected, found " + in_quotes(word));
    } else if (word == "vertex") {
      surface.places.push_back(lines.place(1));
      ++corners;
    } else if (word == "endloop") {
      if (corners != 3)
        lines.fail("a facet has 3 vertices, this one has " + std::to_string(corners));
      add_triangle(static_cast<int>(surface.groups.size()) - 1, surface);
      corners = 0;
    } else if (word != "facet" && word != "outer" && word != "endfacet" && word != "endsolid") {
      lines.fail(in_quotes(word) + " is no word of STL");
    }
  }
  if (corners != 0) lines.fail("the file ends within a facet");
  surface.digits = lines.digits();
  return surface;
}

}  // namespace

Surface read_stl(std::string_view text) {
  return is_binary(text) ? read_binary(text) : read_ascii(text);
}

}  // namespace quoin::scene_file
