#include "linear/dense_front.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace quoin::solver {
namespace {

constexpr int kStrip = 24;  // rows that a thread takes at a time: a tile of the widest kernels

void look(const FrontCrew& crew) {
  if (crew.watch != nullptr) crew.watch->look();
}

/// Calls work(first, count) for strips that make up `rows`.
template <class Work>
void each_strip(const Threads& threads, int rows, const Work& work) {
  if (threads.workers() == 1) return work(0, rows);
  const int strips = (rows + kStrip - 1) / kStrip;
  threads.take(static_cast<std::size_t>(strips), [&](int, std::size_t i) {
    const int first = (strips - 1 - static_cast<int>(i)) * kStrip;  // triangles: the longest first
    work(first, std::min(kStrip, rows - first));
  });
}

/// L U of columns of a square matrix from `at` on, with exchanges of its rows. False: singular.
bool factor_general(const Columns& square, int at, int* exchanges) {
  for (int k = at; k < at + kPanel; ++k) {
    double* column = square.data + k * square.stride;
    int best = k;
    for (int i = k + 1; i < square.rows; ++i)
      if (std::abs(column[i]) > std::abs(column[best])) best = i;
    if (!(std::abs(column[best]) > 0.0)) return false;
    exchanges[k] = best;
    for (int j = 0; best != k && j < square.columns; ++j)
      std::swap(square.data[k + j * square.stride], square.data[best + j * square.stride]);
    const double reciprocal = 1.0 / column[k];
    for (int i = k + 1; i < square.rows; ++i) column[i] *= reciprocal;
    for (int j = k + 1; j < at + kPanel; ++j) {
      double* next = square.data + j * square.stride;
      for (int i = k + 1; i < square.rows; ++i) next[i] -= column[i] * next[k];
    }
  }
  return true;
}

/// L L^T of kPanel columns. False: not positive definite.
bool factor_symmetric(const Columns& square) {
  for (int k = 0; k < kPanel; ++k) {
    double* column = square.data + k * square.stride;
    if (!(column[k] > 0.0)) return false;
    column[k] = std::sqrt(column[k]);
    const double reciprocal = 1.0 / column[k];
    for (int i = k + 1; i < kPanel; ++i) column[i] *= reciprocal;
    for (int j = k + 1; j < kPanel; ++j) {
      double* next = square.data + j * square.stride;
      for (int i = j; i < kPanel; ++i) next[i] -= column[i] * column[j];
    }
  }
  return true;
}

/// L x = x with L unit lower triangular.
void solve_unit_lower(const Columns& lower, const Columns& x) {
  for (int j = 0; j < x.columns; ++j) {
    double* column = x.data + j * x.stride;
    for (int k = 0; k < lower.columns; ++k) {
      const double* factor = lower.data + k * lower.stride;
      for (int i = k + 1; i < lower.rows; ++i) column[i] -= factor[i] * column[k];
    }
  }
}

/// Of the diagonal of kPanel columns.
void set_reciprocals(const Columns& corner, double* reciprocals) {
  for (int k = 0; k < kPanel; ++k) reciprocals[k] = 1.0 / corner.data[k + k * corner.stride];
}

/// Which triangle of a square of factors rows are solved with.
enum class Solve {
  Upper,           ///< x U = x
  LowerTransposed  ///< x L^T = x
};

/// By rows of x. `unit`: ones on the diagonal.
void solve_rows(const Columns& square, Solve by, bool unit, const FrontCrew& crew,
                const Columns& x) {
  for (int at = 0; at < x.columns; at += kPanel) {
    if (at > 0) look(crew);
    const auto seen = [&](int first, int end) {  // the triangle's panel, from row `first` on
      return by == Solve::Upper ? as_is(square.block(first, at, end - first, kPanel))
                                : transposed(square.block(at, first, kPanel, end - first));
    };
    const Columns panel = x.block(0, at, x.rows, kPanel);
    subtract_product(x.block(0, 0, x.rows, at), seen(0, at), Triangle::Both, panel);
    double reciprocals[kPanel];
    if (!unit) set_reciprocals(square.block(at, at, kPanel, kPanel), reciprocals);
    solve_panel(seen(at, at + kPanel), unit ? nullptr : reciprocals, panel);
  }
}

/// rest -= below below^T, the lower triangle.
void subtract_square(const Columns& below, const Threads& threads, const Columns& rest) {
  each_strip(threads, below.rows, [&](int first, int count) {
    const Columns strip = below.block(first, 0, count, below.columns);
    subtract_product(strip, transposed(below), Triangle::Both, rest.block(first, 0, count, first));
    subtract_product(strip, transposed(strip), Triangle::Lower,
                     rest.block(first, first, count, count));
  });
}

}  // namespace

bool eliminate_symmetric(const DenseFront& front, const FrontCrew& crew, double* pivots) {
  const Columns& columns = front.columns;
  const int own = columns.columns, below = front.rest.rows;
  const Columns square = columns.block(0, 0, own, own);
  const Columns under = columns.block(own, 0, below, own);
  for (int at = 0; at < own; at += kPanel) {
    if (at > 0) look(crew);
    const Columns corner = square.block(at, at, kPanel, kPanel);
    if (!factor_symmetric(corner)) return false;
    for (int k = 0; k < kPanel; ++k) {
      const double root = corner.data[k + k * corner.stride];
      pivots[at + k] = root * root;
    }
    const int next = at + kPanel, left = own - next;
    double reciprocals[kPanel];
    set_reciprocals(corner, reciprocals);
    const Columns panel = square.block(next, at, left, kPanel);
    solve_panel(transposed(corner), reciprocals, panel);
    subtract_product(panel, transposed(panel), Triangle::Lower,
                     square.block(next, next, left, left));
  }
  each_strip(crew.threads, below, [&](int first, int count) {
    solve_rows(square, Solve::LowerTransposed, false, crew, under.block(first, 0, count, own));
  });
  subtract_square(under, crew.threads, front.rest);
  return true;
}

bool eliminate_general(const DenseFront& front, const FrontCrew& crew, double* pivots,
                       int* exchanges) {
  const Columns &columns = front.columns, &rows = front.rows;
  const int own = columns.columns, below = front.rest.rows;
  const Columns square = columns.block(0, 0, own, own);
  const Columns under = columns.block(own, 0, below, own);
  for (int at = 0; at < own; at += kPanel) {
    if (at > 0) look(crew);
    if (!factor_general(square, at, exchanges)) return false;
    const Columns corner = square.block(at, at, kPanel, kPanel);
    for (int k = 0; k < kPanel; ++k) pivots[at + k] = std::abs(corner.data[k + k * corner.stride]);
    const int next = at + kPanel, left = own - next;
    const Columns right = square.block(at, next, kPanel, left);
    solve_unit_lower(corner, right);
    subtract_product(square.block(next, at, left, kPanel), as_is(right), Triangle::Both,
                     square.block(next, next, left, left));
  }
  for (int k = 0; k < own; ++k) {
    if (exchanges[k] == k) continue;
    double *one = rows.data + k * rows.stride, *other = rows.data + exchanges[k] * rows.stride;
    std::swap_ranges(one, one + rows.rows, other);
  }
  each_strip(crew.threads, below, [&](int first, int count) {
    solve_rows(square, Solve::Upper, false, crew, under.block(first, 0, count, own));
    solve_rows(square, Solve::LowerTransposed, true, crew, rows.block(first, 0, count, own));
  });
  each_strip(crew.threads, below, [&](int first, int count) {
    subtract_product(under.block(first, 0, count, own), transposed(rows), Triangle::Both,
                     front.rest.block(first, 0, count, below));
  });
  return true;
}

}  // namespace quoin::solver
