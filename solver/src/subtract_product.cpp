#include "subtract_product.hpp"

#include <algorithm>
#include <cstring>

namespace quoin::solver {
namespace {

constexpr int kDepth =
    256;  // columns of a at a time: what a tile reads then stays in the nearest caches

/// Memory of both factors, packed.
struct Packed {
  double *a = nullptr, *b = nullptr;
};

/// A tile at the edge of c, by columns `stride` apart.
struct CutTile {
  double* c = nullptr;
  long stride = 0, rows = 0, columns = 0;
};

/// One product with tiles of c of kVectors × kLanes rows and kColumns columns, which fill the
/// registers.
template <int kLanes, int kVectors, int kColumns>
struct Tiles {
  typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double)), aligned(8)));
  static constexpr int kRows = kLanes * kVectors;

  /// `width` rows (or columns) of a matrix side by side, zeros after the last.
  template <int kWidth>
  [[gnu::always_inline]] static inline void pack(Strided from, long width, int depth, double* to) {
    for (long first = 0; first < width; first += kWidth) {
      const long count = std::min<long>(kWidth, width - first);
      const double* source = from.data + first * from.down;
      for (int k = 0; k < depth; ++k, to += kWidth) {
        for (long i = 0; i < count; ++i) to[i] = source[i * from.down + k * from.across];
        for (long i = count; i < kWidth; ++i) to[i] = 0.0;
      }
    }
  }

  [[gnu::always_inline]] static inline void subtract(const double* a, const double* b, int depth,
                                                     double* c, long stride) {
    Lanes sum[kColumns][kVectors];
    for (int j = 0; j < kColumns; ++j) {
      for (int v = 0; v < kVectors; ++v) {
        std::memcpy(&sum[j][v], c + j * stride + v * kLanes, sizeof(Lanes));
      }
    }
    for (int k = 0; k < depth; ++k, a += kRows, b += kColumns) {
      Lanes column[kVectors];
      for (int v = 0; v < kVectors; ++v) std::memcpy(&column[v], a + v * kLanes, sizeof(Lanes));
      for (int j = 0; j < kColumns; ++j) {
        for (int v = 0; v < kVectors; ++v) sum[j][v] -= column[v] * b[j];
      }
    }
    for (int j = 0; j < kColumns; ++j) {
      for (int v = 0; v < kVectors; ++v) {
        std::memcpy(c + j * stride + v * kLanes, &sum[j][v], sizeof(Lanes));
      }
    }
  }

  /// A tile that the edge of c cuts goes through memory of a whole one.
  [[gnu::always_inline]] static inline void subtract_cut(const double* a, const double* b,
                                                         int depth, const CutTile& cut) {
    double whole[kRows * kColumns] = {};
    for (long j = 0; j < cut.columns; ++j) {
      std::copy_n(cut.c + j * cut.stride, cut.rows, whole + j * kRows);
    }
    subtract(a, b, depth, whole, kRows);
    for (long j = 0; j < cut.columns; ++j) {
      std::copy_n(whole + j * kRows, cut.rows, cut.c + j * cut.stride);
    }
  }

  [[gnu::always_inline]] static inline void product(Strided a, Strided b, int depth,
                                                    Triangle triangle, const Packed& packed,
                                                    Eigen::Ref<Eigen::MatrixXd>& c) {
    pack<kRows>(a, c.rows(), depth, packed.a);
    pack<kColumns>({b.data, b.across, b.down}, c.cols(), depth, packed.b);
    for (long j = 0; j < c.cols(); j += kColumns) {
      const long columns = std::min<long>(kColumns, c.cols() - j);
      const long top = triangle == Triangle::Lower ? j / kRows * kRows : 0;
      for (long i = top; i < c.rows(); i += kRows) {
        const long rows = std::min<long>(kRows, c.rows() - i);
        double* tile = c.data() + i + j * c.outerStride();
        const double *left = packed.a + i * depth, *right = packed.b + j * depth;
        if (rows == kRows && columns == kColumns) {
          subtract(left, right, depth, tile, c.outerStride());
        } else {
          subtract_cut(left, right, depth, {tile, c.outerStride(), rows, columns});
        }
      }
    }
  }
};

using Product = void (*)(Strided, Strided, int, Triangle, const Packed&,
                         Eigen::Ref<Eigen::MatrixXd>&);

void narrow(Strided a, Strided b, int depth, Triangle triangle, const Packed& packed,
            Eigen::Ref<Eigen::MatrixXd>& c) {
  Tiles<2, 2, 4>::product(a, b, depth, triangle, packed, c);
}

#if defined(__x86_64__)
[[gnu::target("avx512f")]] void wide(Strided a, Strided b, int depth, Triangle triangle,
                                     const Packed& packed, Eigen::Ref<Eigen::MatrixXd>& c) {
  Tiles<8, 2, 8>::product(a, b, depth, triangle, packed, c);
}

bool has_wide() { return __builtin_cpu_supports("avx512f"); }
#else
constexpr Product wide = narrow;
bool has_wide() { return false; }
#endif

constexpr long kFewRows = 24;      // narrow tiles waste less of them
constexpr long kMostPadding = 16;  // rows of the tallest tile

}  // namespace

void SubtractProduct::operator()(Strided a, Strided b, int depth, Triangle triangle,
                                 Eigen::Ref<Eigen::MatrixXd> c) {
  const Product product = c.rows() >= kFewRows && has_wide() ? wide : narrow;
  const auto grow = [](std::vector<double>& memory, long width) {
    memory.resize(
        std::max(memory.size(), static_cast<std::size_t>((width + kMostPadding) * kDepth)));
  };
  grow(packed_a_, c.rows());
  grow(packed_b_, c.cols());
  for (int done = 0; done < depth; done += kDepth) {
    const Strided left{a.data + done * a.across, a.down, a.across};
    const Strided right{b.data + done * b.down, b.down, b.across};
    product(left, right, std::min(kDepth, depth - done), triangle,
            {packed_a_.data(), packed_b_.data()}, c);
  }
}

}  // namespace quoin::solver
