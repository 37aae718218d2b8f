/// Data files of 3DEC: blocks that are created one by one, as of versions 5 (poly …) and 7 (block
/// create …).

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

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

  bool is_any(std::size_t i, std::initializer_list<std::string_view> keywords) const {
    return std::ranges::any_of(keywords, [&](std::string_view keyword) { return is(i, keyword); });
  }

  /// The place at word `i`. Programs write all coordinates with as many decimals: these are
  /// rounded.
  Place place(std::size_t i) {
    for (std::size_t x = i; x < std::min(i + 3, count()); ++x) {
      const std::size_t point = std::min(lines_.words()[x].find('.'), lines_.words()[x].size() - 1);
      decimals_.insert(lines_.words()[x].size() - 1 - point);
    }
    return lines_.place(i);
  }

  double rounding() const {
    constexpr std::size_t kFewest = 3;
    const bool same = decimals_.size() == 1 && *decimals_.begin() >= kFewest;
    return same ? 0.5 * std::pow(10.0, -static_cast<double>(*decimals_.begin())) : 0.0;
  }

  void read_block(std::size_t i) {
    MeshBlock block{.id = "block" + std::to_string(blocks_.size())};
    std::vector<Place> points;
    std::vector<std::vector<int>> faces;  // of a polyhedron; it need not be convex
    decimals_.clear();
    bool has_shape = false;
    while (i < count()) {
      if (is(i, "group") && i + 1 < count()) {
        block.name = name(++i);
      } else if (is(i, "brick")) {
        points = brick(++i);
      } else if (is_any(i, {"prism", "tetrahedron", "polyhedron", "poly", "face", "a", "b",
                            "face-1", "face-2"})) {
        if (is(i, "face")) faces.emplace_back();
        has_shape = true;
        ++i;
      } else if (has_shape && is_number(i)) {
        if (!faces.empty()) faces.back().push_back(static_cast<int>(points.size()));
        points.push_back(place(i));
        i += 3;
      } else if (is_any(i, {"region", "reg", "material", "mat", "constitutive", "cons", "slot"})) {
        i += 2;
      } else if (!points.empty() || text(i).find('=') != std::string::npos) {
        ++i;
      } else {
        break;
      }
    }
    if (!has_shape && points.empty()) {
      lines_.fail("can't create a block by " + in_quotes(i < count() ? text(i) : "") +
                  ": brick, prism, tetrahedron or polyhedron expected");
    }
    if (points.size() < 4) lines_.fail("a block has at least 4 corners");
    MeshBlock mesh = faces.empty() ? hull_mesh(block.id, points) : block;
    if (!faces.empty()) {
      mesh.vertices = Eigen::Map<const geometry::Points>(points[0].data(), 3, std::ssize(points));
      mesh.faces = std::move(faces);
      keep_used_vertices(mesh);
    }
    mesh.name = block.name;
    mesh.rounding = rounding();
    blocks_.push_back(std::move(mesh));
  }

  /// A name at word `i`, which then stands behind it; in quotes it may have blanks.
  std::string name(std::size_t& i) {
    const char quote = lines_.words()[i].front();
    std::string name = text(i++);
    if (quote != '"' && quote != '\'') return name;
    while ((name.size() < 2 || name.back() != quote) && i < count()) name += " " + text(i++);
    return name.substr(1, name.size() - 2);
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

  Lines lines_;
  std::set<std::size_t> decimals_;  ///< that coordinates of this block have
  std::vector<MeshBlock> blocks_;
};

}  // namespace

std::vector<MeshBlock> read_3dec(std::string_view text) { return ThreeDecReader(text).read(); }

}  // namespace quoin::scene_file
