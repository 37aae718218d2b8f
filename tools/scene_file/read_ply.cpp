/// PLY: vertices (x, y, z) and faces (vertex_indices), as text or binary of either endianness.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "scene_file/mesh_surface.hpp"

namespace quoin::scene_file {
namespace {

/// A number of the file: how many bytes, and what they mean.
struct Scalar {
  enum class Kind : std::uint8_t { Signed, Unsigned, Real } kind = Kind::Signed;
  std::size_t size = 1;
};

struct Property {
  std::string name{};
  bool is_list = false;
  Scalar count{};  ///< of a list
  Scalar value{};
};

struct Element {
  std::string name{};
  long count = 0;
  std::vector<Property> properties{};
};

Scalar scalar(const Lines& lines, std::string_view name) {
  using Kind = Scalar::Kind;
  static constexpr struct {
    std::string_view name, other;
    Scalar scalar;
  } kTypes[] = {{"char", "int8", {Kind::Signed, 1}},   {"uchar", "uint8", {Kind::Unsigned, 1}},
                {"short", "int16", {Kind::Signed, 2}}, {"ushort", "uint16", {Kind::Unsigned, 2}},
                {"int", "int32", {Kind::Signed, 4}},   {"uint", "uint32", {Kind::Unsigned, 4}},
                {"long", "int64", {Kind::Signed, 8}},  {"ulong", "uint64", {Kind::Unsigned, 8}},
                {"float", "float32", {Kind::Real, 4}}, {"double", "float64", {Kind::Real, 8}}};
  for (const auto& type : kTypes)
    if (name == type.name || name == type.other) return type.scalar;
  lines.fail(in_quotes(name) + " is no type of PLY");
}

enum class Encoding : std::uint8_t { Ascii, LittleEndian, BigEndian };

struct Head {
  Encoding encoding = Encoding::Ascii;
  std::vector<Element> elements{};
  std::string_view body{};
};

void read_property(const Lines& lines, Head& head) {
  const auto& words = lines.words();
  if (head.elements.empty()) lines.fail("a property without an element");
  const bool is_list = words.size() == 5 && words[1] == "list";
  if (!is_list && words.size() != 3)
    lines.fail("\"property TYPE NAME\" or \"property list TYPE TYPE NAME\" expected");
  Property property{.name = std::string(words.back()), .is_list = is_list};
  property.count = is_list ? scalar(lines, words[2]) : Scalar();
  property.value = scalar(lines, words[is_list ? 3 : 1]);
  if (is_list && property.count.kind == Scalar::Kind::Real)
    lines.fail("the length of a list can't be of type " + in_quotes(words[2]));
  head.elements.back().properties.push_back(std::move(property));
}

void read_element(const Lines& lines, Head& head) {
  if (lines.words().size() != 3) lines.fail("\"element NAME COUNT\" expected");
  const long count = lines.integer(2);
  if (count < 0 || count > std::numeric_limits<int>::max())
    lines.fail("the number of elements must lie in 0 … 2147483647, is " + std::to_string(count));
  head.elements.push_back({.name = std::string(lines.words()[1]), .count = count});
}

void read_format(const Lines& lines, Head& head) {
  const std::string_view format = lines.words().size() < 2 ? "" : lines.words()[1];
  if (format == "ascii") {
    head.encoding = Encoding::Ascii;
  } else if (format == "binary_little_endian") {
    head.encoding = Encoding::LittleEndian;
  } else if (format == "binary_big_endian") {
    head.encoding = Encoding::BigEndian;
  } else {
    lines.fail("format must be ascii, binary_little_endian or binary_big_endian, is " +
               in_quotes(format));
  }
}

/// The body begins after the line "end_header".
Head read_head(std::string_view text) {
  const std::size_t end = text.find("end_header");
  const std::size_t stop = end == std::string_view::npos ? end : text.find('\n', end);
  Head head;
  if (stop != std::string_view::npos) head.body = text.substr(stop + 1);
  Lines lines(text.substr(0, end));
  if (!lines.next() || lines.words()[0] != "ply") throw MeshError("line 1: \"ply\" expected");
  if (end == std::string_view::npos) throw MeshError("has no line \"end_header\"");
  while (lines.next()) {
    const std::string_view word = lines.words()[0];
    if (word == "format")
      read_format(lines, head);
    else if (word == "element")
      read_element(lines, head);
    else if (word == "property")
      read_property(lines, head);
    else if (word != "comment" && word != "obj_info")
      lines.fail(in_quotes(word) + " is no word of a PLY head");
  }
  return head;
}

/// Numbers of the body one after the other.
class Body {
 public:
  explicit Body(const Head& head)
      : encoding_(head.encoding), bytes_(head.body), lines_(head.body) {}

  double number(const Scalar& type, const std::string& place) {
    return encoding_ == Encoding::Ascii ? word(place) : binary(type, place);
  }

 private:
  double word(const std::string& place) {
    if (at_ == lines_.words().size()) {
      if (!lines_.next()) throw MeshError(place + ": the file ends before it");
      at_ = 0;
    }
    try {
      return lines_.real(at_++);
    } catch (const MeshError& error) {  // lines count from the end of the head: name the element
      const std::string message = error.what();
      throw MeshError(place + message.substr(message.find(": ")));
    }
  }

  template <typename Number>
  static double as(std::uint64_t bits) {
    using Unsigned = std::conditional_t<
        sizeof(Number) == 1, std::uint8_t,
        std::conditional_t<sizeof(Number) == 2, std::uint16_t,
                           std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>>>;
    return static_cast<double>(std::bit_cast<Number>(static_cast<Unsigned>(bits)));
  }

  double binary(const Scalar& type, const std::string& place) {
    if (bytes_.size() < type.size) throw MeshError(place + ": the file ends before it");
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < type.size; ++i) {
      const std::size_t from = encoding_ == Encoding::BigEndian ? i : type.size - 1 - i;
      bits = bits << 8U | static_cast<unsigned char>(bytes_[from]);
    }
    bytes_.remove_prefix(type.size);
    if (type.kind == Scalar::Kind::Real) return type.size == 4 ? as<float>(bits) : as<double>(bits);
    if (type.kind == Scalar::Kind::Unsigned) return static_cast<double>(bits);
    return type.size == 1   ? as<std::int8_t>(bits)
           : type.size == 2 ? as<std::int16_t>(bits)
           : type.size == 4 ? as<std::int32_t>(bits)
                            : as<std::int64_t>(bits);
  }

  Encoding encoding_;
  std::string_view bytes_;
  Lines lines_;
  std::size_t at_ = 0;
};

class PlyReader {
 public:
  explicit PlyReader(const Head& head) : head_(head), body_(head) {
    surface_.groups.emplace_back();
  }

  Surface read() {
    for (const Element& element : head_.elements) {
      check(element);
      for (long i = 0; i < element.count && !element.properties.empty(); ++i) read(element, i);
    }
    return std::move(surface_);
  }

 private:
  static bool is_corners(const Property& property) {
    return property.is_list &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
  }

  /// What each property of the vertex is: 0, 1, 2 for x, y, z; -1 for another.
  static int axis(const Property& property) {
    const bool is_axis = !property.is_list && property.name.size() == 1 &&
                         property.name[0] >= 'x' && property.name[0] <= 'z';
    return is_axis ? property.name[0] - 'x' : -1;
  }

  static void check(const Element& element) {
    const auto has = [&](const auto& wanted) {
      return std::any_of(element.properties.begin(), element.properties.end(), wanted);
    };
    for (int a = 0; element.name == "vertex" && a < 3; ++a)
      if (!has([&](const Property& property) { return axis(property) == a; }))
        throw MeshError(std::string("element vertex has no property ") + "xyz"[a]);
    if (element.name == "face" && !has(is_corners))
      throw MeshError("element face has no list vertex_indices or vertex_index");
  }

  void read(const Element& element, long number) {
    const std::string place = element.name + " " + std::to_string(number);
    if (element.name == "vertex") surface_.places.emplace_back();
    for (const Property& property : element.properties) {
      if (element.name == "face" && is_corners(property)) {
        read_corners(property, place);
      } else if (element.name == "vertex" && axis(property) >= 0) {
        const double value = body_.number(property.value, place);
        if (!std::isfinite(value))
          throw MeshError(place + ": " + property.name + " is not a finite number");
        surface_.places.back()[static_cast<std::size_t>(axis(property))] = value;
      } else {
        skip(property, place);
      }
    }
  }

  void skip(const Property& property, const std::string& place) {
    const double count = property.is_list ? body_.number(property.count, place) : 1.0;
    for (double i = 0; i < count; ++i) (void)body_.number(property.value, place);
  }

  void read_corners(const Property& property, const std::string& place) {
    const double corners = body_.number(property.count, place);
    if (!(corners >= 3)) {
      throw MeshError(place + ": a face has at least 3 vertices, this one has " +
                      std::to_string(static_cast<long>(corners)));
    }
    for (double i = 0; i < corners; ++i) {
      const double vertex = body_.number(property.value, place);
      if (!(vertex >= 0 && vertex < static_cast<double>(surface_.places.size())) ||
          vertex != std::floor(vertex)) {
        throw MeshError(place + ": there is no vertex " +
                        std::to_string(static_cast<long>(vertex)) + ", there are " +
                        std::to_string(surface_.places.size()) + ", counted from 0");
      }
      surface_.corners.push_back(static_cast<int>(vertex));
    }
    surface_.face_ends.push_back(surface_.corners.size());
    surface_.face_group.push_back(0);
  }

  const Head& head_;
  Body body_;
  Surface surface_;
};

}  // namespace

Surface read_ply(std::string_view text) {
  const Head head = read_head(text);
  return PlyReader(head).read();
}

}  // namespace quoin::scene_file
