/// DXF as text: 3DFACE entities by layer. Other solids and surfaces are refused; what else a
/// drawing has is left aside.

#include <map>
#include <set>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

/// Group codes of a 3DFACE: 8 is its layer, 10 + i, 20 + i, 30 + i are x, y, z of corner i.
class DxfReader {
 public:
  explicit DxfReader(std::string_view text) : rest_(text) {}

  Surface read() {
    while (!rest_.empty()) {
      const std::string_view code_line = line(), value = line();
      Lines words(code_line);
      if (!words.next()) fail("a group code is missing");
      const long code = integer(code_line);
      if (code == 0) {
        begin_entity(value);
      } else if (code == 2) {
        take_name(value);
      } else if (code == 70 && entity_ == "POLYLINE" && (integer(value) & kOfFaces) != 0) {
        take_solid("POLYLINE of faces");
      } else if (in_face_ && code == 8) {
        layer_ = value;
      } else if (in_face_ && code >= 10 && code < 40 && code % 10 < 4) {
        corner_[static_cast<std::size_t>(code % 10)][static_cast<std::size_t>(code / 10 - 1)] =
            real(value);
        given_ |= 1U << (code % 10);
      }
    }
    end_face();
    return std::move(surface_);
  }

 private:
  static constexpr long kOfFaces = 16 + 64;  ///< flags of a POLYLINE that is a mesh

  void begin_entity(std::string_view entity) {
    end_face();
    entity_ = entity;
    in_face_ = entity == "3DFACE" && section_ != "BLOCKS";
    for (const std::string_view solid : {"3DFACE", "MESH", "3DSOLID", "BODY"})
      if (entity == solid && !in_face_) take_solid(std::string(solid));
  }

  /// Of a section, of a block, or of one that is inserted.
  void take_name(std::string_view name) {
    if (entity_ == "SECTION") section_ = name;
    if (entity_ == "BLOCK") block_ = name;
    if (entity_ == "INSERT" && solid_blocks_.contains(name))
      take_solid("INSERT of block " + in_quotes(name));
  }

  void take_solid(const std::string& what) {
    if (section_ != "BLOCKS") fail(what + " is not imported: explode it to 3DFACE");
    solid_blocks_.insert(block_);
  }

  [[noreturn]] void fail(const std::string& message) const {
    throw MeshError("line " + std::to_string(number_) + ": " + message);
  }

  std::string_view line() {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view text = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    const std::size_t first = std::min(text.find_first_not_of(" \t\r"), text.size());
    text.remove_prefix(first);
    return text.substr(0, text.find_last_not_of(" \t\r") + 1);
  }

  template <typename Read>
  auto number(std::string_view word, const Read& read) const {
    Lines words(word);
    if (!words.next()) fail("a number is missing");
    try {
      return read(words);
    } catch (const MeshError&) {
      fail(in_quotes(word) + " is not a number");
    }
  }
  long integer(std::string_view word) const {
    return number(word, [](const Lines& words) { return words.integer(0); });
  }
  double real(std::string_view word) {
    return number(word, [&](Lines& words) {
      digits_of({words});
      return words.real(0);
    });
  }
  void digits_of(Lines words) {
    surface_.digits = std::max(surface_.digits, significant_digits(words.words()[0]));
  }

  void end_face() {
    if (!in_face_) return;
    if ((given_ & 7U) != 7U) fail("a 3DFACE before it has fewer than three corners");
    const std::size_t count = (given_ & 8U) != 0 && corner_[3] != corner_[2] ? 4 : 3;
    for (std::size_t i = 0; i < count; ++i) {
      surface_.corners.push_back(static_cast<int>(surface_.places.size()));
      surface_.places.push_back(corner_[i]);
    }
    surface_.face_ends.push_back(surface_.corners.size());
    const auto [group, is_new] =
        groups_.try_emplace(std::string(layer_), static_cast<int>(groups_.size()));
    if (is_new) surface_.groups.push_back(group->first);
    surface_.face_group.push_back(group->second);
    given_ = 0;
    corner_ = {};  // a plane one may leave out its z
    in_face_ = false;
  }

  std::string_view rest_, layer_, section_, entity_, block_;
  std::set<std::string_view> solid_blocks_;  ///< with faces or solids: an INSERT would place these
  int number_ = 0;
  bool in_face_ = false;
  unsigned given_ = 0;  ///< corners, by bit
  std::array<std::array<double, 3>, 4> corner_{};
  Surface surface_;
  std::map<std::string, int> groups_;
};

}  // namespace

Surface read_dxf(std::string_view text) { return DxfReader(text).read(); }

}  // namespace quoin::scene_file
