#pragma once
/// Sums and products of small matrices by value, to the bit as Eigen has them. Each of its
/// expressions is a type with dozens of functions: half of the front end's time.

#include <Eigen/Core>
#include <concepts>

namespace quoin::solver {

/// Blocks and transposes too, nothing that is computed at each look.
template <class M>
concept SmallMatrix = std::same_as<typename M::PlainObject, typename M::PlainMatrix> &&
                      bool(M::Flags& Eigen::DirectAccessBit) &&
                      bool(M::SizeAtCompileTime <= 36) && bool(M::SizeAtCompileTime > 0);

template <class Result, class Entry>
inline Result matrix_of(const Entry& entry) {
  Result result;
  for (int j = 0; j < Result::ColsAtCompileTime; ++j)
    for (int i = 0; i < Result::RowsAtCompileTime; ++i) result(i, j) = entry(i, j);
  return result;
}

template <SmallMatrix A, SmallMatrix B>
inline auto operator+(const A& a, const B& b) {
  return matrix_of<typename A::PlainObject>([&](int i, int j) { return a(i, j) + b(i, j); });
}
template <SmallMatrix A, SmallMatrix B>
inline auto operator-(const A& a, const B& b) {
  return matrix_of<typename A::PlainObject>([&](int i, int j) { return a(i, j) - b(i, j); });
}
template <SmallMatrix A>
inline auto operator-(const A& a) {
  return matrix_of<typename A::PlainObject>([&](int i, int j) { return -a(i, j); });
}
template <SmallMatrix A>
inline auto operator*(double factor, const A& a) {
  return matrix_of<typename A::PlainObject>([&](int i, int j) { return factor * a(i, j); });
}
template <SmallMatrix A>
inline auto operator*(const A& a, double factor) {
  return factor * a;
}
template <SmallMatrix A>
inline auto operator/(const A& a, double divisor) {
  return matrix_of<typename A::PlainObject>([&](int i, int j) { return a(i, j) / divisor; });
}

/// Of n entries of a row and a column, from entry k on, in halves.
template <int n, class A, class B>
inline double dot(const A& a, const B& b, int i, int j, int k = 0) {
  if constexpr (n == 1)
    return a(i, k) * b(k, j);
  else
    return dot<n / 2>(a, b, i, j, k) + dot<n - n / 2>(a, b, i, j, k + n / 2);
}
/// From left to right, but for an odd row at the end.
template <SmallMatrix A, SmallMatrix B>
inline auto operator*(const A& a, const B& b) {
  constexpr int n = A::ColsAtCompileTime, rows = A::RowsAtCompileTime;
  constexpr int even = A::IsRowMajor ? rows : rows / 2 * 2;
  Eigen::Matrix<double, rows, B::ColsAtCompileTime> result;
  for (int j = 0; j < B::ColsAtCompileTime; ++j) {
    double sum[rows];  // not in the result, which might be a or b for all that gcc knows
    for (int i = 0; i < even; ++i) sum[i] = a(i, 0) * b(0, j);
    for (int k = 1; k < n; ++k)
      for (int i = 0; i < even; ++i) sum[i] += a(i, k) * b(k, j);
    if (even < rows) sum[even] = dot<n>(a, b, even, j);
    for (int i = 0; i < rows; ++i) result(i, j) = sum[i];
  }
  return result;
}

}  // namespace quoin::solver
