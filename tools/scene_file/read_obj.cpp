/// Wavefront OBJ: v, f, o, g; everything else is left aside.

#include <map>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

class ObjReader {
 public:
  explicit ObjReader(std::string_view text) : lines_(text) {}

  Surface read() {
    while (lines_.next()) {
      const std::string_view word = lines_.words()[0];
      if (word == "v")
        surface_.places.push_back(lines_.place(1));
      else if (word == "f")
        read_face();
      else if (word == "o" || word == "g")
        read_name(word == "o");
    }
    surface_.digits = lines_.digits();
    return std::move(surface_);
  }

 private:
  /// Groups divide a file that has no objects.
  void read_name(bool is_object) {
    if (objects_ && !is_object) return;
    if (is_object && !objects_) {
      objects_ = true;
      group_ = -1;
    }
    std::string name;
    for (std::size_t i = 1; i < lines_.words().size(); ++i)
      name += (i == 1 ? "" : " ") + std::string(lines_.words()[i]);
    const auto [found, is_new] =
        groups_.try_emplace(name, static_cast<int>(surface_.groups.size()));
    if (is_new) surface_.groups.push_back(name);
    group_ = found->second;
  }

  void read_face() {
    const std::size_t corners = lines_.words().size() - 1;
    if (corners < 3)
      lines_.fail("a face has at least 3 vertices, this one has " + std::to_string(corners));
    const long count = std::ssize(surface_.places);
    for (std::size_t i = 1; i <= corners; ++i) {
      const long number = lines_.integer(i);
      const long vertex = number < 0 ? count + number : number - 1;
      if (number == 0 || vertex < 0 || vertex >= count) {
        lines_.fail("there is no vertex " + in_quotes(lines_.words()[i]) + ", so far there are " +
                    std::to_string(count));
      }
      surface_.corners.push_back(static_cast<int>(vertex));
    }
    if (group_ < 0) read_default_group();
    surface_.face_ends.push_back(surface_.corners.size());
    surface_.face_group.push_back(group_);
  }

  void read_default_group() {
    const auto [found, is_new] = groups_.try_emplace("", static_cast<int>(surface_.groups.size()));
    if (is_new) surface_.groups.emplace_back();
    group_ = found->second;
  }

  Lines lines_;
  Surface surface_;
  std::map<std::string, int> groups_;
  bool objects_ = false;
  int group_ = -1;
};

}  // namespace

Surface read_obj(std::string_view text) { return ObjReader(text).read(); }

}  // namespace quoin::scene_file
