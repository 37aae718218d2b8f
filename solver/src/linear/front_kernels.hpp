#pragma once
/// The product of an elimination's dense matrices. Every entry takes its terms one after the other,
/// so that vectors of any width give the same bits.

#include <Eigen/Core>

namespace quoin::solver {

/// Entry (i, j) stands at data[i * down + j * across].
struct Strided {
  const double* data = nullptr;
  long down = 1, across = 1;
  Strided at(long i, long j) const { return {data + i * down + j * across, down, across}; }
};

template <class Matrix>
Strided as_is(const Matrix& a) {
  return {a.data(), 1, a.outerStride()};
}
template <class Matrix>
Strided transposed(const Matrix& a) {
  return {a.data(), a.outerStride(), 1};
}

/// c -= a b. The columns of c are a multiple of six.
void subtract_product(const Eigen::Ref<const Eigen::MatrixXd>& a, Strided b,
                      Eigen::Ref<Eigen::MatrixXd> c);

}  // namespace quoin::solver
