#include "referee/pairs/pair_text.hpp"

#include <algorithm>
#include <charconv>

namespace quoin::referee {
namespace {

std::string number(double value) {
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

template <class Matrix>
std::string listed(const Matrix& values, const char* open, const char* close) {
  std::string text = open;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    text += (i == 0 ? "" : ", ") + number(values.data()[i]);
  return text + close;
}

/// As it may stand between the quotes of a JSON string.
std::string escaped(const std::string& text) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string safe;
  for (const char c : text)
    if (c == '"' || c == '\\')
      safe += {'\\', c};
    else if (c >= 0 && c < ' ')
      safe += {'\\', 'u', '0', '0', kDigits[c / 16], kDigits[c % 16]};
    else
      safe += c;
  return safe;
}

/// What ends no comment and no line.
std::string in_comment(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '*' || c == '\\' || (c >= 0 && c < ' '); },
      '_');
  return text;
}

geometry::Matrix3 by_rows(const Solid& solid) { return solid.placed.placement.linear.transpose(); }

std::string json(const Solid& solid) {
  std::string text;
  for (Eigen::Index i = 0; i < solid.placed.points.cols(); ++i)
    text += (i == 0 ? "[" : ",") + listed(solid.placed.points.col(i), "[", "]");
  text += "]";
  if (stands_in_own_frame(solid)) return text;
  const std::string place =
      listed(solid.placed.placement.translation, "[", ", ") + listed(by_rows(solid), "", "]");
  return "{\"points\":" + text + ",\"placement\":" + place + "}";
}

std::string cpp(const Solid& solid, const std::string& name) {
  const std::string count = std::to_string(solid.placed.points.cols());
  return "  Points " + name + "_points(3, " + count + ");\n  " + name + "_points.reshaped() << " +
         listed(solid.placed.points, "", ";\n") + "  Placement " + name + "_place;\n  " + name +
         "_place.linear << " + listed(by_rows(solid), "", ";\n") + "  " + name +
         "_place.translation << " + listed(solid.placed.placement.translation, "", ";\n") +
         "  const Hull " + name + " = make_hull(" + name + "_points);\n";
}

std::string c(const Solid& solid, const std::string& name) {
  const std::string count = std::to_string(solid.placed.points.cols());
  return "  const double " + name + "_points[] = " + listed(solid.placed.points, "{", "};\n") +
         "  quoin_body " + name + " = {0, {" + listed(by_rows(solid), "{", "}, ") +
         listed(solid.placed.placement.translation, "{", "}}};\n") + "  quoin_shape* " + name +
         "_shape = 0;\n  if (quoin_make_hull(" + name + "_points, " + count + ", &" + name +
         "_shape, message, sizeof message) != QUOIN_OK) {\n    printf(\"%s\\n\", message);\n"
         "    return 1;\n  }\n  " +
         name + ".shape = " + name + "_shape;\n";
}

}  // namespace

std::string pair_as_json(const SolidPair& pair, const std::string& id) {
  return "{\"id\":\"" + escaped(id) + "\",\"a\":" + json(pair.a) + ",\"b\":" + json(pair.b) + "}";
}

std::string pair_as_cpp(const SolidPair& pair) {
  return "// family " + in_comment(pair.family) +
         "\n#include <cstdio>\n#include <quoin/geometry/build.hpp>\n#include "
         "<quoin/geometry/nearest_features.hpp>\n\nusing namespace quoin::geometry;\n\n"
         "int main() {\n" +
         cpp(pair.a, "a") + cpp(pair.b, "b") +
         "  const NearestFeatures answer =\n      nearest_features(Body(a.polyhedron, a_place), "
         "Body(b.polyhedron, b_place));\n  std::printf(\"gap %.17g\\n\", answer.gap);\n}\n";
}

std::string pair_as_c(const SolidPair& pair) {
  return "/* family " + in_comment(pair.family) +
         " */\n#include <quoin/geometry_c.h>\n#include <stdio.h>\n\nint main(void) {\n"
         "  char message[400];\n" +
         c(pair.a, "a") + c(pair.b, "b") +
         "  quoin_nearest answer;\n  quoin_hint hint = quoin_no_hint();\n"
         "  quoin_nearest_features(&a, &b, 0, &hint, &answer);\n"
         "  printf(\"gap %.17g\\n\", answer.gap);\n  quoin_free(a_shape);\n  quoin_free(b_shape);\n"
         "  return 0;\n}\n";
}

}  // namespace quoin::referee
