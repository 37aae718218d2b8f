/// Data files of 3DEC: blocks that are created one by one, as of versions 5 (poly …) and 7 (block
/// create …).

#include <cctype>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

using Place = std::array<double, 3>;

class ThreeDecReader {
 public:
  explicit ThreeDecReader(std::string_view text) : lines_(text) {
    lines_.set_marks(';', '&', ",()");
  }

  std::vector<MeshBlock> read() {
    while (lines_.next()) {
      if (is(0, "poly") || is(0, "polyhedron")) {
        read_block(1);
      } else if (is(0, "block") && is(1, "create")) {
        read_block(2);
      } else if (is(0, "jset") || is(0, "tunnel") ||
                 (is(0, "block") && (is(1, "cut") || is(1, "delete") || is(1, "densify")))) {
        lines_.fail(in_quotes(text(0) + (is(0, "block") ? " " + text(1) : "")) +
                    " is not imported: blocks must be created one by one");
      }
    }
    if (blocks_.empty()) throw MeshError("creates no blocks (block create …, or poly …)");
    return std::move(blocks_);
  }

 private:
  std::size_t count() const { return lines_.words().size(); }
  std::string text(std::size_t i) const { return std::string(lines_.words().at(i)); }

  bool is(std::size_t i, std::string_view keyword) const {
    if (i >= count() || lines_.words()[i].size() != keyword.size()) return false;
    return std::equal(keyword.begin(), keyword.end(), lines_.words()[i].begin(),
                      [](char k, char c) {
                        return k == static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
                      });
  }

  bool is_number(std::size_t i) const {
    return i < count() &&
           lines_.words()[i].find_first_not_of("+-.0123456789eE") == std::string_view::npos;
  }

  /// The numbers from word `i` on, which then stands behind them.
  std::vector<Place> places(std::size_t& i) {
    std::vector<Place> places;
    for (; is_number(i); i += 3) places.push_back(lines_.place(i));
    return places;
  }

  void read_block(std::size_t i) {
    const std::string id = "block" + std::to_string(blocks_.size());
    const std::string keyword = i < count() ? text(i) : "";
    std::vector<Place> points;
    if (is(i, "brick")) {
      points = brick(++i);
    } else if (is(i, "prism") || is(i, "tetrahedron") || is(i, "polyhedron") || is(i, "face")) {
      if (!is(i, "face")) ++i;
      while (i < count() && !is(i, "group")) {
        if (!is_number(i)) ++i;  // a, b, face-1, face-2, face: their points follow
        const std::vector<Place> more = places(i);
        if (more.empty()) break;
        points.insert(points.end(), more.begin(), more.end());
      }
    } else {
      lines_.fail("can't create a block by " + in_quotes(keyword) +
                  ": brick, prism, tetrahedron or polyhedron expected");
    }
    if (points.size() < 4) lines_.fail("a block has at least 4 corners");
    blocks_.push_back(hull_mesh(id, points));
    for (; i + 1 < count(); ++i) {
      if (is(i, "group")) blocks_.back().name = unquoted(lines_.words()[i + 1]);
    }
  }

  /// Of its limits: least and largest x, then y, then z.
  std::vector<Place> brick(std::size_t& i) {
    if (i + 6 > count()) lines_.fail("a brick has 6 limits");
    std::vector<Place> corners;
    for (std::size_t c = 0; c < 8; ++c) {
      corners.push_back({lines_.real(i + (c & 1U)), lines_.real(i + 2 + (c >> 1U & 1U)),
                         lines_.real(i + 4 + (c >> 2U))});
    }
    i += 6;
    return corners;
  }

  static std::string unquoted(std::string_view word) {
    const std::size_t first = word.find_first_not_of("'\"");
    if (first == std::string_view::npos) return {};
    return std::string(word.substr(first, word.find_last_not_of("'\"") + 1 - first));
  }

  Lines lines_;
  std::vector<MeshBlock> blocks_;
};

}  // namespace

std::vector<MeshBlock> read_3dec(std::string_view text) { return ThreeDecReader(text).read(); }

}  // namespace quoin::scene_file
