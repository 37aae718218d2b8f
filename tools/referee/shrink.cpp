#include "shrink.hpp"

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
    if (exhausted()) return false;
    --left_;
    if (!fails_(changed)) return false;
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
      if (first + chunk > points.cols() || points.cols() - chunk < 4) break;
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
  for (const int digits : {1, 2, 3, 4, 6, 8, 12})
    if (shorten(search, of, digits)) return;
}

}  // namespace

SolidPair shrink(const SolidPair& pair, const std::function<bool(const SolidPair&)>& fails,
                 int most_questions) {
  SolidPair bare = pair;
  bare.a.topology = bare.b.topology = nullptr;
  if (!fails(bare)) return pair;
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

}  // namespace quoin::referee
