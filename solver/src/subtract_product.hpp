#pragma once
/// The dense product of the elimination.

#include <Eigen/Core>
#include <vector>

namespace quoin::solver {

enum class Triangle { Both, Lower };

/// A matrix of doubles in memory: entry (i, j) stands at data[i * down + j * across].
struct Strided {
  const double* data = nullptr;
  long down = 1, across = 1;
};

/// c -= a b with `depth` columns of a. Each entry takes its products one after the other, so that vectors of
/// any width give the same bits. Lower: what stands above the diagonal of c is left undefined.
class SubtractProduct {
 public:
  void operator()(Strided a, Strided b, int depth, Triangle triangle, Eigen::Ref<Eigen::MatrixXd> c);

 private:
  std::vector<double> packed_a_, packed_b_;  // memory
};

}  // namespace quoin::solver
