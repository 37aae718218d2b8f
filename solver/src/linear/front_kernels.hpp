#pragma once
/// The dense arithmetic of an elimination. Every entry takes its products one after the other, so
/// that vectors of any width give the same bits. All matrices are stored by columns.

namespace quoin::solver {

enum class Triangle { Both, Lower };

/// A matrix of doubles in memory: entry (i, j) stands at data[i + j * stride].
struct Columns {
  double* data = nullptr;
  long stride = 0;
  int rows = 0, columns = 0;
  Columns block(int i, int j, int height, int width) const {
    return {data + i + j * stride, stride, height, width};
  }
};

/// Entry (i, j) stands at data[i * down + j * across].
struct Strided {
  const double* data = nullptr;
  long down = 1, across = 1;
};

inline Strided as_is(const Columns& a) { return {a.data, 1, a.stride}; }
inline Strided transposed(const Columns& a) { return {a.data, a.stride, 1}; }

constexpr int kPanel = 6;  ///< columns that are eliminated at a time

/// c -= a b. Lower: what stands above the diagonal of c is left undefined.
void subtract_product(const Columns& a, Strided b, Triangle triangle, const Columns& c);

/// x U = x, by rows, with U upper triangular, kPanel × kPanel; `reciprocals`: of its diagonal, or
/// null: ones.
void solve_panel(Strided upper, const double* reciprocals, const Columns& x);

}  // namespace quoin::solver
