#include "linear/small_matrices.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

namespace quoin::solver {

/// Gauss and Jordan's, the largest pivots first. All rows have twelve numbers, so that vectors of
/// one length do them.
bool invert_symmetric(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                      Eigen::Ref<Eigen::MatrixXd> inverse) {
  constexpr std::size_t kMost = 12;
  using Row = std::array<double, kMost>;
  const auto n = static_cast<std::size_t>(matrix.cols());
  std::array<Row, kMost> a{};
  for (std::size_t i = 0; i < n; ++i)
    std::copy_n(matrix.data() + static_cast<Eigen::Index>(i) * matrix.outerStride(), n,
                a[i].begin());
  std::array<bool, kMost> done{};
  std::size_t swept = 0;
  for (; swept < n; ++swept) {
    std::size_t k = kMost;
    double pivot = 0.0;
    for (std::size_t i = 0; i < n; ++i)
      if (!done[i] && a[i][i] > pivot) pivot = a[k = i][i];
    if (k == kMost) break;
    done[k] = true;
    Row by = a[k];
    by[k] = -1.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double factor = (i == k ? -1.0 : a[i][k]) / pivot;
      if (i == k) a[i].fill(0.0);
      a[i][k] = 0.0;
      for (std::size_t j = 0; j < kMost; ++j) a[i][j] -= factor * by[j];
    }
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      inverse(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) =
          done[i] && done[j] ? -a[i][j] : 0.0;
  return swept == n;
}

// Not computeDirect(): atan2 and cos of libm have other bits on other processors.
Eigen::Vector3d eigenvalues(const Eigen::Matrix3d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

}  // namespace quoin::solver
