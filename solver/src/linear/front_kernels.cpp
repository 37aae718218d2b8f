#include "linear/front_kernels.hpp"

#include <cstring>

namespace quoin::solver {
namespace {

using Left = Eigen::Ref<const Eigen::MatrixXd>;
using Sum = Eigen::Ref<Eigen::MatrixXd>;

constexpr int kColumns = 6;  // of a tile: a block has 6 or 12 unknowns

/// With vectors of kLanes; a tile has kLanes × kVectors rows. What is left of the rows goes through
/// lower tiles, down to vectors of one.
template <int kLanes, int kVectors>
struct Tiles {
  typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double)), aligned(8)));
  static constexpr int kRows = kLanes * kVectors;
  using Lower = Tiles<(kVectors > 1 ? kLanes : kLanes / 2), (kVectors > 1 ? kVectors - 1 : 1)>;

  [[gnu::always_inline]] static inline Lanes load(const double* from) {
    Lanes lanes;
    std::memcpy(&lanes, from, sizeof lanes);
    return lanes;
  }

  [[gnu::always_inline]] static inline void subtract(const double* a, long stride, Strided b,
                                                     long depth, double* c, long c_stride) {
    Lanes sum[kColumns][kVectors];
    for (int j = 0; j < kColumns; ++j)
      for (int v = 0; v < kVectors; ++v) sum[j][v] = load(c + j * c_stride + v * kLanes);
    for (long k = 0; k < depth; ++k, a += stride, b.data += b.down) {
      Lanes column[kVectors];
      for (int v = 0; v < kVectors; ++v) column[v] = load(a + v * kLanes);
      for (int j = 0; j < kColumns; ++j)
        for (int v = 0; v < kVectors; ++v) sum[j][v] -= column[v] * b.data[j * b.across];
    }
    for (int j = 0; j < kColumns; ++j)
      for (int v = 0; v < kVectors; ++v)
        std::memcpy(c + j * c_stride + v * kLanes, &sum[j][v], sizeof(Lanes));
  }

  /// Rows from `i` on.
  [[gnu::always_inline]] static inline void product(long i, const Left& a, Strided b, Sum& c) {
    for (; i + kRows <= c.rows(); i += kRows)
      for (long j = 0; j < c.cols(); j += kColumns)
        subtract(a.data() + i, a.outerStride(), b.at(0, j), a.cols(), &c(i, j), c.outerStride());
    if constexpr (kRows > 1)
      if (i < c.rows()) Lower::product(i, a, b, c);
  }
};

using Product = void(const Left&, Strided, Sum&);

void portable(const Left& a, Strided b, Sum& c) { Tiles<2, 2>::product(0, a, b, c); }

#if defined(__x86_64__)
[[gnu::target("avx2")]] void with_avx2(const Left& a, Strided b, Sum& c) {
  Tiles<4, 2>::product(0, a, b, c);
}
[[gnu::target("avx512f,avx512vl")]] void with_avx512(const Left& a, Strided b, Sum& c) {
  Tiles<8, 3>::product(0, a, b, c);
}
#endif

Product* fastest() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) return with_avx512;
  if (__builtin_cpu_supports("avx2")) return with_avx2;
#endif
  return portable;
}

}  // namespace

void subtract_product(const Left& a, Strided b, Sum c) {
  static Product* const chosen = fastest();
  chosen(a, b, c);
}

}  // namespace quoin::solver
