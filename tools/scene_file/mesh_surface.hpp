#pragma once
/// What readers of surface files hand on: one list of places and faces, with names for runs of
/// faces.

#include <array>
#include <string_view>

#include "scene_file/mesh_file.hpp"

namespace quoin::scene_file {

/// Faces of a whole file.
struct Surface {
  std::vector<std::array<double, 3>> places{};  ///< of vertices, file units
  std::vector<int> corners{};                   ///< of all faces, one after the other
  std::vector<std::size_t> face_ends{};         ///< in `corners`
  std::vector<int> face_group{};                ///< of each face
  std::vector<std::string> groups{};            ///< names; "" for one without
  int digits = 0;                               ///< significant ones of places; 0: not decimals
};

/// One block for each closed surface of each group. Places that are the same to the bit are one
/// vertex; faces belong together when they share an edge. Where more than two faces meet on an edge
/// (blocks that stand corner on corner) a face goes with the one that it encloses the least solid
/// angle with. A group of one surface names its block; of more, NAME.0, NAME.1, …; blocks of a
/// group without name are block0, block1, …
std::vector<MeshBlock> blocks_of(const Surface& surface);

/// The text of a file. Throws FileError.
std::string read_text(const std::string& path);

/// Lines of a text file as words: '#' begins a comment, '\' at the end goes on in the next line.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  /// Goes to the next line that has words; false at the end.
  bool next();
  const std::vector<std::string_view>& words() const { return words_; }
  int number() const { return number_; }                     ///< of the line that began it
  [[noreturn]] void fail(const std::string& message) const;  ///< MeshError "line N: …"
  /// Of the words that are read from here on: the text in which comments begin with `comment`,
  /// lines that end with `joint` go on, and characters of `blanks` divide words, too.
  void set_marks(char comment, char joint, std::string_view blanks);
  /// Word `i` as a finite number.
  double real(std::size_t i) const;
  /// Word `i`, up to a '/', as a whole number.
  long integer(std::size_t i) const;
  /// Words `first` … `first` + 2 as a place.
  std::array<double, 3> place(std::size_t first);
  int digits() const { return digits_; }  ///< most significant digits of a decimal of a place

 private:
  bool append_words();

  std::string_view rest_;
  std::vector<std::string_view> words_;
  int number_ = 0;
  int read_ = 0;
  int digits_ = 0;
  char comment_ = '#', joint_ = '\\';
  std::string_view blanks_{};
};

/// A word of a file as it may stand in a message: short, without control characters.
std::string in_quotes(std::string_view word);

/// Of a decimal with a point: from the first that is not 0, before an exponent. 0: a whole number.
int significant_digits(std::string_view word);

Surface read_obj(std::string_view text);
Surface read_stl(std::string_view text);
Surface read_ply(std::string_view text);
Surface read_off(std::string_view text);
Surface read_dxf(std::string_view text);
std::vector<MeshBlock> read_compas(std::string_view text);
std::vector<MeshBlock> read_3dec(std::string_view text);
/// `dof`: text of DOF.INI; may be empty.
std::vector<MeshBlock> read_lmgc90(std::string_view text, std::string_view dof);
std::vector<MeshBlock> read_chrono(std::string_view text);
/// `path`: of the file, beside or above which its meshes are.
std::vector<MeshBlock> read_rigid_ipc(std::string_view text, const std::string& path);

/// The convex hull of points (file units) as a mesh. Throws MeshError naming `id` for a flat one.
MeshBlock hull_mesh(std::string id, const std::vector<std::array<double, 3>>& points);

/// Keeps the vertices that faces use; places that are the same to the bit become one vertex,
/// corners that stand on each other one corner, and faces of fewer than three corners are left out.
void keep_used_vertices(MeshBlock& mesh);

}  // namespace quoin::scene_file
