#include "shrink.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace quoin::referee {
namespace {

using geometry::Points;

/// Tries changed pairs as long as there are questions left, and keeps what still fails.
class Search {
 public:
  Search(const SolidPair& pair, const std::function<bool(const SolidPair&)>& fails, int questions)
      : best_(pair), fails_(fails), left_(questions) {}

  bool exhausted() const { return left_ <= 0; }
  const SolidPair& best() const { return best_; }
  bool keep(const SolidPair& changed) {
    if (exhausted()) {
      return false;
    }
    --left_;
    if (!fails_(changed)) {
      return false;
    }
    best_ = changed;
    return true;
  }

 private:
  SolidPair best_;
  const std::function<bool(const SolidPair&)>& fails_;
  int left_;
};

Solid& side(SolidPair& pair, int which) { return which == 0 ? pair.a : pair.b; }

Points without(const Points& points, Eigen::Index first, Eigen::Index count) {
  Points rest(3, points.cols() - count);
  rest << points.leftCols(first), points.rightCols(points.cols() - first - count);
  return rest;
}

/// Leaves out half of the points at a time, then a quarter, … down to single ones.
void drop_points(Search& search, int which) {
  SolidPair whole = search.best();
  for (Eigen::Index chunk = std::max<Eigen::Index>(1, side(whole, which).placed.points.cols() / 2);
       chunk >= 1 && !search.exhausted(); chunk /= 2) {
    for (Eigen::Index first = 0; !search.exhausted();) {
      SolidPair changed = search.best();
      Points& points = side(changed, which).placed.points;
      if (first + chunk > points.cols() || points.cols() - chunk < 4) {
        break;
      }
      points = without(points, first, chunk);
      first += search.keep(changed) ? 0 : chunk;
    }
  }
}

double shortened(double number, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*e", digits - 1, number);
  return std::strtod(text, nullptr);
}

/// All numbers of a matrix to so many digits.
template <class Matrix>
bool shorten(Search& search, Matrix& (*of)(SolidPair&), int digits) {
  SolidPair changed = search.best();
  Matrix& numbers = of(changed);
  const Matrix before = numbers;
  numbers = numbers.unaryExpr([digits](double x) { return shortened(x, digits); });
  return numbers == before || search.keep(changed);
}

template <class Matrix>
void shorten(Search& search, Matrix& (*of)(SolidPair&)) {
  for (const int digits : {1, 2, 3, 4, 6, 8, 12}) {
    if (shorten(search, of, digits)) {
      return;
    }
  }
}

std::string number(double value) {
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

template <class Matrix>
std::string listed(const Matrix& values, const char* open, const char* close) {
  std::string text = open;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    text += (i == 0 ? "" : ", ") + number(values.data()[i]);
  }
  return text + close;
}

geometry::Matrix3 by_rows(const Solid& solid) { return solid.placed.placement.linear.transpose(); }

std::string json(const Solid& solid) {
  std::string text;
  for (Eigen::Index i = 0; i < solid.placed.points.cols(); ++i) {
    text += (i == 0 ? "[" : ",") + listed(solid.placed.points.col(i), "[", "]");
  }
  text += "]";
  if (stands_in_own_frame(solid)) {
    return text;
  }
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

SolidPair shrink(const SolidPair& pair, const std::function<bool(const SolidPair&)>& fails,
                 int most_questions) {
  SolidPair bare = pair;
  bare.a.topology = bare.b.topology = nullptr;
  if (!fails(bare)) {
    return pair;
  }
  Search search(bare, fails, most_questions);
  drop_points(search, 0);
  drop_points(search, 1);
  shorten<Points>(search, [](SolidPair& p) -> Points& { return p.a.placed.points; });
  shorten<Points>(search, [](SolidPair& p) -> Points& { return p.b.placed.points; });
  using geometry::Vector3;
  shorten<Vector3>(search,
                   [](SolidPair& p) -> Vector3& { return p.a.placed.placement.translation; });
  shorten<Vector3>(search,
                   [](SolidPair& p) -> Vector3& { return p.b.placed.placement.translation; });
  return search.best();
}

std::string pair_as_json(const SolidPair& pair, const std::string& id) {
  return "{\"id\":\"" + id + "\",\"a\":" + json(pair.a) + ",\"b\":" + json(pair.b) + "}";
}

std::string pair_as_cpp(const SolidPair& pair) {
  return "// family " + pair.family +
         "\n#include <cstdio>\n#include <quoin/geometry/build.hpp>\n#include "
         "<quoin/geometry/nearest_features.hpp>\n\nusing namespace quoin::geometry;\n\n"
         "int main() {\n" +
         cpp(pair.a, "a") + cpp(pair.b, "b") +
         "  const NearestFeatures answer =\n      nearest_features(Body(a.polyhedron, a_place), "
         "Body(b.polyhedron, b_place));\n  std::printf(\"gap %.17g\\n\", answer.gap);\n}\n";
}

std::string pair_as_c(const SolidPair& pair) {
  return "/* family " + pair.family +
         " */\n#include <quoin/geometry_c.h>\n#include <stdio.h>\n\nint main(void) {\n"
         "  char message[400];\n" +
         c(pair.a, "a") + c(pair.b, "b") +
         "  quoin_nearest answer;\n  quoin_hint hint = quoin_no_hint();\n"
         "  quoin_nearest_features(&a, &b, 0, &hint, &answer);\n"
         "  printf(\"gap %.17g\\n\", answer.gap);\n  quoin_free(a_shape);\n  quoin_free(b_shape);\n"
         "  return 0;\n}\n";
}

}  // namespace quoin::referee
