#include "linear/front_kernels.hpp"

#include <algorithm>
#include <cstring>

namespace quoin::solver {
namespace {

/// The kernels with vectors of kLanes; a tile has kLanes × kVectors rows. What is left of the rows
/// goes through lower tiles, down to vectors of one.
template <int kLanes, int kVectors>
struct Tiles {
  typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double)), aligned(8)));
  static constexpr int kRows = kLanes * kVectors;
  using Lower = Tiles<(kVectors > 1 ? kLanes : kLanes / 2), (kVectors > 1 ? kVectors - 1 : 1)>;

  [[gnu::always_inline]] static inline Lanes load(const double* from) {
    Lanes lanes;
    std::memcpy(&lanes, from, sizeof(Lanes));
    return lanes;
  }
  [[gnu::always_inline]] static inline void store(const Lanes& lanes, double* to) {
    std::memcpy(to, &lanes, sizeof(Lanes));
  }

  /// Of one tile of kRows × kColumns.
  template <int kColumns>
  [[gnu::always_inline]] static inline void subtract(const double* a, long stride, Strided b,
                                                     int depth, double* c, long c_stride) {
    Lanes sum[kColumns][kVectors];
    for (int j = 0; j < kColumns; ++j)
      for (int v = 0; v < kVectors; ++v) sum[j][v] = load(c + j * c_stride + v * kLanes);
    for (int k = 0; k < depth; ++k, a += stride, b.data += b.down) {
      Lanes column[kVectors];
      for (int v = 0; v < kVectors; ++v) column[v] = load(a + v * kLanes);
      for (int j = 0; j < kColumns; ++j)
        for (int v = 0; v < kVectors; ++v) sum[j][v] -= column[v] * b.data[j * b.across];
    }
    for (int j = 0; j < kColumns; ++j)
      for (int v = 0; v < kVectors; ++v) store(sum[j][v], c + j * c_stride + v * kLanes);
  }

  /// Rows from `first` on.
  [[gnu::always_inline]] static inline void product(int first, const Columns& a, Strided b,
                                                    Triangle triangle, const Columns& c) {
    int i = first;
    for (; i + kRows <= c.rows; i += kRows) {
      const int whole = (i + kRows + kPanel - 1) / kPanel * kPanel;  // panels down to the diagonal
      const int end = triangle == Triangle::Lower ? std::min(c.columns, whole) : c.columns;
      int j = 0;
      for (; j + kPanel <= end; j += kPanel) {
        subtract<kPanel>(a.data + i, a.stride, {b.data + j * b.across, b.down, b.across}, a.columns,
                         c.data + i + j * c.stride, c.stride);
      }
      for (; j < end; ++j) {
        subtract<1>(a.data + i, a.stride, {b.data + j * b.across, b.down, b.across}, a.columns,
                    c.data + i + j * c.stride, c.stride);
      }
    }
    if constexpr (kRows > 1) {
      if (i < c.rows) Lower::product(i, a, b, triangle, c);
    }
  }

  [[gnu::always_inline]] static inline void solve(int first, Strided upper,
                                                  const double* reciprocals, const Columns& x) {
    int i = first;
    for (; i + kLanes <= x.rows; i += kLanes) {
      Lanes row[kPanel];
      for (int j = 0; j < kPanel; ++j) row[j] = load(x.data + i + j * x.stride);
      for (int k = 0; k < kPanel; ++k) {
        if (reciprocals != nullptr) row[k] *= reciprocals[k];
        for (int j = k + 1; j < kPanel; ++j)
          row[j] -= row[k] * upper.data[k * upper.down + j * upper.across];
      }
      for (int j = 0; j < kPanel; ++j) store(row[j], x.data + i + j * x.stride);
    }
    if constexpr (kLanes > 1) {
      if (i < x.rows) Tiles<kLanes / 2, 1>::solve(i, upper, reciprocals, x);
    }
  }
};

/// The kernels for one set of instructions.
struct Kernels {
  void (*product)(const Columns&, Strided, Triangle, const Columns&);
  void (*solve)(Strided, const double*, const Columns&);
};

template <int kLanes, int kVectors>
struct Portable {
  static void product(const Columns& a, Strided b, Triangle triangle, const Columns& c) {
    Tiles<kLanes, kVectors>::product(0, a, b, triangle, c);
  }
  static void solve(Strided upper, const double* reciprocals, const Columns& x) {
    Tiles<kLanes, 1>::solve(0, upper, reciprocals, x);
  }
};

#if defined(__x86_64__)
[[gnu::target("avx2")]] void product_avx2(const Columns& a, Strided b, Triangle triangle,
                                          const Columns& c) {
  Tiles<4, 2>::product(0, a, b, triangle, c);
}
[[gnu::target("avx2")]] void solve_avx2(Strided upper, const double* reciprocals,
                                        const Columns& x) {
  Tiles<4, 1>::solve(0, upper, reciprocals, x);
}
[[gnu::target("avx512f,avx512vl")]] void product_avx512(const Columns& a, Strided b,
                                                        Triangle triangle, const Columns& c) {
  Tiles<8, 3>::product(0, a, b, triangle, c);
}
[[gnu::target("avx512f,avx512vl")]] void solve_avx512(Strided upper, const double* reciprocals,
                                                      const Columns& x) {
  Tiles<8, 1>::solve(0, upper, reciprocals, x);
}
#endif

Kernels fastest() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl"))
    return {product_avx512, solve_avx512};
  if (__builtin_cpu_supports("avx2")) return {product_avx2, solve_avx2};
#endif
  return {Portable<2, 2>::product, Portable<2, 2>::solve};
}

const Kernels& kernels() {
  static const Kernels chosen = fastest();
  return chosen;
}

}  // namespace

void subtract_product(const Columns& a, Strided b, Triangle triangle, const Columns& c) {
  kernels().product(a, b, triangle, c);
}

void solve_panel(Strided upper, const double* reciprocals, const Columns& x) {
  kernels().solve(upper, reciprocals, x);
}

}  // namespace quoin::solver
