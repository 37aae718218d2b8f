/// Brick files of Chrono's masonry simulator: a block a line, as the hulls of its corners.

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {

/// ID, fixed, visible, [yielding, [density,]] force (3), reference (3), corners (3 each); 9999
/// stands between the hulls of one block. Forces are left out.
std::vector<MeshBlock> read_chrono(std::string_view text) {
  constexpr double kNextHull = 9999;
  std::vector<MeshBlock> blocks;
  Lines lines(text);
  lines.set_marks('#', '\\', ",;");
  while (lines.next()) {
    const std::size_t count = lines.words().size();
    std::vector<std::size_t> ends;  // of hulls, in words
    for (std::size_t i = 9; i < count; ++i)
      if (lines.real(i) == kNextHull) ends.push_back(i);
    std::size_t first = 9 + (count - ends.size()) % 3;
    const bool has_density = first == 11;
    if (count < first + 12) {
      lines.fail("a block has 9 to 11 numbers and three for each of at least 4 corners, not " +
                 std::to_string(count));
    }
    ends.push_back(count);
    const std::string id(lines.words()[0]);
    for (std::size_t hull = 0; hull < ends.size(); first = ends[hull++] + 1) {
      if (first == ends[hull] || (ends[hull] - first) % 3 != 0) {
        lines.fail("hull " + std::to_string(hull) + " has " + std::to_string(ends[hull] - first) +
                   " numbers, not three a corner");
      }
      std::vector<std::array<double, 3>> corners;
      for (std::size_t i = first; i < ends[hull]; i += 3) corners.push_back(lines.place(i));
      blocks.push_back(hull_mesh(ends.size() == 1 ? id : id + "." + std::to_string(hull), corners));
      MeshBlock& block = blocks.back();
      if (ends.size() > 1) block.body = id;
      block.is_support = lines.real(1) != 0;
      block.density = has_density ? lines.real(4) : 0.0;
    }
  }
  return blocks;
}

}  // namespace quoin::scene_file
