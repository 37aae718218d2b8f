#pragma once
/// One front of a multifrontal elimination: dense matrices, of which the first columns are
/// eliminated.

#include "base/step_watch.hpp"
#include "base/threads.hpp"
#include "linear/front_kernels.hpp"

namespace quoin::solver {

/// The columns of a front's own unknowns, which become its factors, and what they leave.
struct DenseFront {
  Columns columns;  ///< (own + below) × own
  Columns rows;     ///< below × own, transposed; none where symmetric
  Columns rest;     ///< below × below; symmetric: the lower triangle
};

/// Who eliminates a front, the same bits for any number of threads. `watch`, where there is one, is
/// looked at, which then throws StepStopped.
struct FrontCrew {
  Threads threads;
  StepWatch* watch = nullptr;
};

/// L L^T. Sets `pivots` of the own unknowns. False: not positive definite.
bool eliminate_symmetric(const DenseFront& front, const FrontCrew& crew, double* pivots);

/// L U with exchanges of own rows; `exchanges`: with which row each has changed. False: singular.
bool eliminate_general(const DenseFront& front, const FrontCrew& crew, double* pivots,
                       int* exchanges);

}  // namespace quoin::solver
