#pragma once
/// Direct solution of K x = f for a sparse matrix of blocks.

#include "linear/multifrontal.hpp"

namespace quoin::solver {
using LinearSolver = Multifrontal;
}
