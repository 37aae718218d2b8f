#pragma once
/// Velocities that contacts allow to rounding.

#include "statics/cone_program.hpp"

namespace quoin::solver {

/// `y` (6 a slot, the largest 1), moved as little as makes contacts that stick or slide to within
/// `near` do so exactly: v = 0 where |v| < near, v_n = mu |v_t| where these differ by less. By
/// Newton's method; the others are left as they are, so the result may be incompatible.
Eigen::VectorXd compatible_motion(const ConeProgram& program, Eigen::VectorXd y, double near);

}  // namespace quoin::solver
